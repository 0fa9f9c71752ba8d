#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "acquire/transport/modbus_port.h"

namespace haptometer::tests {

/// A Modbus link whose other end is a script on a ManualClock: no time passes but what it says.
class ScriptedModbusLink final : public acquire::ModbusLink {
 public:
  using Answer = std::function<void(ScriptedModbusLink&, const std::string& frame)>;

  ScriptedModbusLink(Clock& clock, acquire::ModbusFraming framing, Answer answer)
      : clock_(clock), framing_(framing), answer_(std::move(answer)) {}

  /// A frame, or damage, arrives `after_ns` from now.
  void Reply(std::string frame, MonotonicNs after_ns,
             acquire::ModbusFault fault = acquire::ModbusFault::kNone) {
    const Event event{clock_.Now() + after_ns, std::move(frame), fault};
    events_.insert(std::ranges::upper_bound(events_, event.time_ns, {}, &Event::time_ns), event);
  }
  /// The line gives each request back before the reply.
  void GiveRequestsBack() { has_echo_ = true; }
  void HangUp() { gone_ = true; }

  bool Send(std::string_view frame) override {
    if (gone_) return false;
    is_echo_due_ = has_echo_;
    answer_(*this, std::string(frame));
    return true;
  }

  acquire::ModbusReply Receive(std::size_t /*expected*/, MonotonicNs deadline) override {
    using acquire::ModbusArrival;
    if (std::exchange(is_echo_due_, false)) return {.arrival = ModbusArrival::kEcho};
    if (events_.empty() && gone_) return {.arrival = ModbusArrival::kGone};
    if (events_.empty() || events_.front().time_ns > deadline) {
      clock_.SleepUntil(deadline);
      return {.arrival = ModbusArrival::kNothing};
    }
    clock_.SleepUntil(events_.front().time_ns);
    taken_ = std::move(events_.front());
    events_.pop_front();
    const bool is_sound = taken_.fault == acquire::ModbusFault::kNone;
    return {.arrival = is_sound ? ModbusArrival::kFrame : ModbusArrival::kDamaged,
            .bytes = taken_.frame,
            .fault = taken_.fault};
  }

  std::size_t Flush() override {
    std::size_t bytes = 0;
    while (!events_.empty() && events_.front().time_ns <= clock_.Now()) {
      bytes += events_.front().frame.size();
      events_.pop_front();
    }
    return bytes;
  }

  acquire::ModbusFraming framing() const override { return framing_; }
  std::string Source() const override { return "device: scripted"; }
  std::optional<MonotonicNs> LatencyTimer() const override { return 16'000'000; }
  const std::string& name() const override { return name_; }

 private:
  struct Event {
    MonotonicNs time_ns = 0;
    std::string frame;
    acquire::ModbusFault fault = acquire::ModbusFault::kNone;
  };
  Clock& clock_;
  acquire::ModbusFraming framing_;
  Answer answer_;
  std::deque<Event> events_;
  Event taken_;
  bool gone_ = false;
  bool has_echo_ = false;
  bool is_echo_due_ = false;
  std::string name_ = "scripted";
};

}  // namespace haptometer::tests
