#pragma once

#include <cstdint>

#ifdef __x86_64__
#include <xmmintrin.h>
#endif

namespace haptometer::dsp {

/// While it lives, results below 2.2e-308 become 0 and such inputs count as 0, on this thread.
///
/// After a signal falls silent a filter's state decays through the subnormal numbers, on which many
/// processors are 10 to 100 times slower. Every instruction set of x86-64 that is used here obeys
/// the same two bits of MXCSR, so the results do not depend on which one ran; on AArch64 one bit of
/// FPCR does both, for NEON too. The destructor brings back the caller's mode, whatever it was.
class FlushSubnormals {
 public:
  FlushSubnormals() : before_(Mode()) { SetMode(before_ | kFlush); }
  ~FlushSubnormals() { SetMode(before_); }
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
#if defined(__x86_64__)
  using Register = unsigned;
  static constexpr Register kFlush = 0x8000 | 0x0040;  // results (FTZ) and inputs (DAZ)
  static Register Mode() { return _mm_getcsr(); }
  static void SetMode(Register mode) { _mm_setcsr(mode); }
#elif defined(__aarch64__)
  using Register = std::uint64_t;
  static constexpr Register kFlush = Register{1} << 24U;  // FZ: results and inputs
  // "memory": what is computed from values in memory, and stored, remains on its side
  static Register Mode() {
    Register mode = 0;
    asm volatile("mrs %0, fpcr" : "=r"(mode) : : "memory");
    return mode;
  }
  static void SetMode(Register mode) { asm volatile("msr fpcr, %0" : : "r"(mode) : "memory"); }
#else
#error "no way is known to flush subnormal numbers on this processor"
#endif

  Register before_;
};

}  // namespace haptometer::dsp
