#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"

namespace haptometer::acquire {

inline constexpr MonotonicNs kMs = 1'000'000;
inline const std::atomic<bool> kNeverStop{false};

inline trial::TrialHeader OneChannel(trial::Timing timing) {
  trial::TrialHeader header;
  header.timing = timing;
  header.rate_hz = timing == trial::Timing::kUniform ? 1000 : 0;
  header.metadata.source = "simulated: a test";
  trial::ChannelFormat channel;
  channel.name = "displacement";
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.encoding = trial::Encoding::kI32;
  channel.scale = 1e-7;
  header.channels = {channel};
  return header;
}

/// Row k at k * period; then silence, the end or a hang-up.
class CountingSensor final : public Sensor {
 public:
  CountingSensor(Clock& clock, trial::Timing timing, std::uint64_t rows, Outcome then,
                 MonotonicNs period_ns = kMs)
      : clock_(clock),
        header_(OneChannel(timing)),
        rows_(rows),
        then_(then),
        period_ns_(period_ns) {}

  Result<void> Start(const std::atomic<bool>& /*stop*/) override { return {}; }
  const trial::TrialHeader& header() const override { return header_; }
  Findings Found() const override {
    Findings found;
    found.Note(FindingKind::kLinesNumbered, {{"last", 99}});
    if (next_ > 0) found.Doubt(FindingKind::kWireErrors, {{"errors", "1 timeout"}});
    return found;
  }
  MonotonicNs Begin() override { return origin_ns_ = clock_.Now(); }
  Outcome Next(Reading& reading) override {
    if (next_ == rows_) {
      clock_.SleepUntil(clock_.Now() + 100 * kMs);
      return then_;
    }
    reading.index = static_cast<std::int64_t>(next_);
    reading.time_ns = origin_ns_ + reading.index * period_ns_;
    reading.reply_ns = reading.time_ns + kMs / 2;
    const auto status =
        statuses.empty() ? trial::SampleStatus::kOk : statuses[next_ % statuses.size()];
    reading.samples = {{trial::RawValue::Counts(static_cast<std::int32_t>(next_)), status}};
    reading.follows_gap = next_ == gap_at;
    reading.lost_before = lost_before.empty() ? 0 : lost_before[next_ % lost_before.size()];
    ++next_;
    return Outcome::kReading;
  }
  bool waits() const override { return waits_for_us; }
  std::uint64_t discarded_bytes() const override { return 17; }

  std::vector<trial::SampleStatus> statuses;  ///< in turn; empty: all ok
  bool waits_for_us = false;
  trial::Metadata& metadata() { return header_.metadata; }
  trial::ChannelFormat& channel() { return header_.channels[0]; }
  std::optional<std::uint64_t>
      gap_at{};  ///< row before which rows of an unknown number are missing
  std::vector<std::int64_t> lost_before;  ///< in turn; empty: none

 private:
  Clock& clock_;
  trial::TrialHeader header_;
  std::uint64_t rows_;
  Outcome then_;
  MonotonicNs period_ns_;
  MonotonicNs origin_ns_ = 0;
  std::uint64_t next_ = 0;
};

}  // namespace haptometer::acquire
