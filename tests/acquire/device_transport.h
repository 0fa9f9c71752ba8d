#pragma once

#include <algorithm>
#include <string>

#include "acquire/emulator/device.h"
#include "acquire/transport/transport.h"

namespace haptometer::tests {

/// A transport whose other end is an emulated device on the same clock: a sensor and its emulator
/// in one thread, without sleeping. Give it a ManualClock that stands at 0.
class DeviceTransport final : public acquire::Transport {
 public:
  DeviceTransport(acquire::emulator::Device& device, Clock& clock)
      : device_(device), clock_(clock) {}

  acquire::ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override {
    while (true) {
      device_.Advance(clock_.Now(), waiting_);
      is_gone_ = device_.TakeHangUp() || is_gone_;
      if (!waiting_.empty()) break;
      if (is_gone_) return {acquire::ReadState::kGone, 0};
      const auto due = device_.NextDue();
      if (!due || *due > deadline) {
        clock_.SleepUntil(deadline);
        return {acquire::ReadState::kTimeout, 0};
      }
      clock_.SleepUntil(*due);
    }
    const std::size_t taken = std::min(waiting_.size(), buffer.size());
    std::copy_n(waiting_.begin(), taken, buffer.begin());
    waiting_.erase(0, taken);
    return {acquire::ReadState::kBytes, taken};
  }

  Result<void> Write(std::string_view bytes, MonotonicNs /*deadline*/) override {
    if (is_gone_) return Failed(name_, "the connection was lost");
    device_.Receive(bytes, clock_.Now());
    return {};
  }

  std::string Source() const override { return "device: emulator on a manual clock"; }
  const std::string& name() const override { return name_; }

 private:
  acquire::emulator::Device& device_;
  Clock& clock_;
  std::string waiting_;
  bool is_gone_ = false;
  std::string name_ = "emulator";
};

}  // namespace haptometer::tests
