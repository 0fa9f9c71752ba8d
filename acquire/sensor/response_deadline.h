#pragma once

#include <array>
#include <cstddef>

#include "base/clock.h"

namespace haptometer::acquire {

/// How long to wait for a reply: the maker's second at first, then four times the slowest of the
/// last 64 exchanges, from 50 ms to 1 s, so that one lost reply does not cost a whole second's row.
class ResponseDeadline {
 public:
  /// The unit answers within 1 s or not at all (DL-RS1A, IG Edition; the FD-MH Edition says 500
  /// ms).
  static constexpr MonotonicNs kLongestNs = kNsPerS;
  static constexpr MonotonicNs kShortestNs = 50'000'000;

  /// Notes an exchange that succeeded.
  void Note(MonotonicNs exchange_ns);

  /// How long to wait for the next reply, in ns.
  [[nodiscard]] MonotonicNs WaitNs() const;

 private:
  std::array<MonotonicNs, 64> exchanges_ns_{};  ///< the last ones, in a ring
  std::size_t noted_ = 0;
};

}  // namespace haptometer::acquire
