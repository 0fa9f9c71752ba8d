#include "acquire/sensor/response_deadline.h"

#include <fmt/core.h>

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

MonotonicNs ResponseDeadline::EarliestNs() const {
  if (noted_ < exchanges_ns_.size()) return wire_ns_;
  return std::max(wire_ns_, std::ranges::min(exchanges_ns_) / 10 * 9);
}

MonotonicNs ResponseDeadline::UsualNs() const {
  if (noted_ < exchanges_ns_.size()) return wire_ns_;
  auto sorted_ns = exchanges_ns_;
  const auto middle = sorted_ns.begin() + sorted_ns.size() / 2;
  std::ranges::nth_element(sorted_ns, middle);
  return std::max(EarliestNs(), *middle * 3 / 2);
}

std::vector<std::string> DoubtfulReplies(const ReplyCounts& replies, MonotonicNs wire_ns) {
  std::vector<std::string> remarks;
  if (replies.surplus > 0) {
    remarks.push_back(fmt::format(
        "{} replies came to requests that had been answered already and were discarded: the device "
        "answers more than once",
        replies.surplus));
  }
  if (replies.too_soon > 0) {
    const double wire_s = SecondsFromNs(wire_ns);
    remarks.push_back(fmt::format(
        "{} of {} replies came sooner than the stated baud rate carries request and reply ({:.3g} "
        "ms): the port is no such wire, or the device has another baud rate; readings were taken "
        "at {:.4g} Hz at most, as the stated rate allows",
        replies.too_soon, replies.taken, 1e3 * wire_s, 1 / wire_s));
  }
  return remarks;
}

}  // namespace haptometer::acquire
