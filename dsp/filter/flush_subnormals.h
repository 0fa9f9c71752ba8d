#pragma once

#include <xmmintrin.h>

namespace haptometer::dsp {

/// While it lives, results below 2.2e-308 become 0 and such inputs count as 0, on this thread.
///
/// After a signal falls silent a filter's state decays through the subnormal numbers, on which many
/// processors are 10 to 100 times slower. Every instruction set that is used here obeys the same
/// two bits of MXCSR, so the results do not depend on which one ran. The destructor brings back the
/// caller's mode, whatever it was.
class FlushSubnormals {
 public:
  FlushSubnormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | kFlushToZero | kZeroInputs); }
  ~FlushSubnormals() { _mm_setcsr(before_); }
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
  static constexpr unsigned kFlushToZero = 0x8000;
  static constexpr unsigned kZeroInputs = 0x0040;
  unsigned before_;
};

}  // namespace haptometer::dsp
