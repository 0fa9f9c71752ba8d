#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/transport/transport.h"

namespace haptometer::tests {

/// A transport whose other end is a script on a ManualClock: no time passes but what it says.
class ScriptedTransport final : public acquire::Transport {
 public:
  /// What the other end does when it gets `bytes`; it answers with Send().
  using Answer = std::function<void(ScriptedTransport&, const std::string& bytes)>;

  explicit ScriptedTransport(Clock& clock, Answer answer = {})
      : clock_(clock), answer_(std::move(answer)) {}

  /// `bytes` arrive `after_ns` from now.
  void Send(const std::string& bytes, MonotonicNs after_ns) {
    const Event event{clock_.Now() + after_ns, bytes};
    const auto later = std::ranges::upper_bound(events_, event.time_ns, {}, &Event::time_ns);
    events_.insert(later, event);
  }
  /// The other end hangs up `after_ns` from now.
  void HangUp(MonotonicNs after_ns) { gone_ns_ = clock_.Now() + after_ns; }

  acquire::ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override {
    const bool has_bytes = !events_.empty() && events_.front().time_ns <= gone_ns_;
    const MonotonicNs next_ns = has_bytes ? events_.front().time_ns : gone_ns_;
    if (next_ns > deadline) {
      clock_.SleepUntil(deadline);
      return {acquire::ReadState::kTimeout, 0};
    }
    clock_.SleepUntil(next_ns);
    if (!has_bytes) return {acquire::ReadState::kGone, 0};
    std::string& bytes = events_.front().bytes;
    const std::size_t taken = std::min(bytes.size(), buffer.size());
    std::copy_n(bytes.begin(), taken, buffer.begin());
    bytes.erase(0, taken);
    if (bytes.empty()) events_.pop_front();
    return {acquire::ReadState::kBytes, taken};
  }

  Result<void> Write(std::string_view bytes, MonotonicNs /*deadline*/) override {
    if (clock_.Now() >= gone_ns_) return Failed(name_, "the connection was lost");
    written_.emplace_back(bytes);
    if (answer_) answer_(*this, written_.back());
    return {};
  }

  std::string Source() const override { return "device: scripted"; }
  std::optional<MonotonicNs> LatencyTimer() const override { return latency_ns; }
  const std::string& name() const override { return name_; }
  const std::vector<std::string>& written() const { return written_; }

  std::optional<MonotonicNs> latency_ns;  ///< of its adapter

 private:
  struct Event {
    MonotonicNs time_ns;
    std::string bytes;
  };
  Clock& clock_;
  Answer answer_;
  std::deque<Event> events_;
  MonotonicNs gone_ns_ = std::numeric_limits<MonotonicNs>::max();
  std::vector<std::string> written_;
  std::string name_ = "scripted";
};

}  // namespace haptometer::tests
