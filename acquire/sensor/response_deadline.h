#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/clock.h"

namespace haptometer::acquire {

/// When a reply can be the one to the request: not sooner than the wire carries both and than 0.9
/// times the fastest of the last 64 exchanges, and not later than a deadline: the maker's second at
/// first, then four times the slowest of them, from 50 ms to 1 s, so that one lost reply does not
/// cost a whole second's row.
///
/// What comes sooner is likely the second reply to a request before: a device that answers twice,
/// or that is one reply behind. Then the right one follows within a usual exchange.
class ResponseDeadline {
 public:
  /// `wire_ns`: what request and reply need on the wire; 0 where no wire is known.
  explicit ResponseDeadline(MonotonicNs wire_ns = 0) : wire_ns_(wire_ns) {}

  /// The unit answers within 1 s or not at all (DL-RS1A, IG Edition; the FD-MH Edition says 500
  /// ms).
  static constexpr MonotonicNs kLongestNs = kNsPerS;
  static constexpr MonotonicNs kShortestNs = 50'000'000;

  /// Notes an exchange that succeeded.
  void Note(MonotonicNs exchange_ns);

  /// How long to wait for the next reply, in ns.
  [[nodiscard]] MonotonicNs WaitNs() const;
  /// A reply that comes sooner after its request is doubtful, in ns.
  [[nodiscard]] MonotonicNs EarliestNs() const;
  /// How long to look for a further reply behind a doubtful one: 1.5 times the median exchange, at
  /// least EarliestNs(), in ns from the request.
  [[nodiscard]] MonotonicNs UsualNs() const;
  [[nodiscard]] MonotonicNs wire_ns() const { return wire_ns_; }

 private:
  MonotonicNs wire_ns_;
  std::array<MonotonicNs, 64> exchanges_ns_{};  ///< the last ones, in a ring
  std::size_t noted_ = 0;
};

/// Replies of a device that is asked one thing at a time.
struct ReplyCounts {
  std::uint64_t taken = 0;     ///< that became rows
  std::uint64_t surplus = 0;   ///< to requests that had been answered already: discarded
  std::uint64_t too_soon = 0;  ///< of those taken, that no wire carries as fast
};

/// What they say of the device and of its wire, on which request and reply need `wire_ns`, in
/// sentences for the user; none where all is well.
[[nodiscard]] std::vector<std::string> DoubtfulReplies(const ReplyCounts& replies,
                                                       MonotonicNs wire_ns);

}  // namespace haptometer::acquire
