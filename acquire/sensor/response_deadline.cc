#include "acquire/sensor/response_deadline.h"

#include <algorithm>

namespace haptometer::acquire {

void ResponseDeadline::Note(MonotonicNs exchange_ns) {
  exchanges_ns_[noted_++ % exchanges_ns_.size()] = exchange_ns;
}

MonotonicNs ResponseDeadline::WaitNs() const {
  constexpr MonotonicNs kFactor = 4;
  if (noted_ < exchanges_ns_.size()) return kLongestNs;  // too few to know the slow ones
  return std::clamp(kFactor * std::ranges::max(exchanges_ns_), kShortestNs, kLongestNs);
}

}  // namespace haptometer::acquire
