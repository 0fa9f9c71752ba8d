#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// The pauses between attempts to open a device that is away: 50 ms, 100 ms, ... at most 250 ms, so
/// that its return is noticed within a second while the processor sleeps in between.
class RetryPause {
 public:
  /// The next one, in ns.
  [[nodiscard]] MonotonicNs Next() {
    return std::exchange(pause_ns_, std::min(2 * pause_ns_, kLongestNs));
  }
  /// Begins anew, for a device that has gone away again.
  void Reset() { pause_ns_ = kFirstNs; }

 private:
  static constexpr MonotonicNs kFirstNs = 50'000'000;
  static constexpr MonotonicNs kLongestNs = 250'000'000;

  MonotonicNs pause_ns_ = kFirstNs;
};

/// A sensor that is opened again whenever its connection is lost.
///
/// The port is let go at once, so that a replugged adapter gets its old name back; then it is tried
/// again and again (RetryPause). What comes back must send the same channels; anything
/// else is not taken, and tried again. Where it has another averaging, sampling period or head, the
/// recording ends (Outcome::kGone): its header would not hold for the rows behind it.
///
/// Next() waits longer than other sensors' while the device that has come back is started.
class ReconnectingSensor final : public Sensor {
 public:
  /// Opens the sensor's port anew; called in the recording thread.
  using Open = std::function<Result<std::unique_ptr<Sensor>>()>;

  /// After `longest_away_ns` (empty: never) the sensor is given up: Outcome::kGone. `clock` must
  /// outlive the sensor.
  ReconnectingSensor(Open open, std::optional<MonotonicNs> longest_away_ns, Clock& clock);

  /// Opens and starts the device, once: what is not there at the beginning is an error.
  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  /// While it is away, what it said last.
  [[nodiscard]] Findings Found() const override;
  /// Also while it is away: then readings begin when it is back.
  [[nodiscard]] MonotonicNs Begin() override;
  [[nodiscard]] Outcome Next(Reading& reading) override;
  [[nodiscard]] MonotonicNs LostReplyNs() const override {
    return sensor_ ? sensor_->LostReplyNs() : 0;
  }
  [[nodiscard]] std::uint64_t discarded_bytes() const override;

  /// Why the last attempt did not bring the device back; empty when none failed since it was there.
  [[nodiscard]] const std::string& last_refusal() const { return last_refusal_; }

 private:
  [[nodiscard]] Outcome TryAgain();
  void LetGo();

  Open open_;
  std::optional<MonotonicNs> longest_away_ns_;
  Clock& clock_;
  const std::atomic<bool>* stop_ = nullptr;
  std::unique_ptr<Sensor> sensor_;  ///< empty while away
  trial::TrialHeader header_;
  MonotonicNs away_since_ns_ = 0;
  RetryPause pause_;
  MonotonicNs next_try_ns_ = 0;
  std::string last_refusal_;
  Findings last_found_;                 ///< of the sensor that is gone
  std::uint64_t discarded_before_ = 0;  ///< by the sensors that are gone
};

}  // namespace haptometer::acquire
