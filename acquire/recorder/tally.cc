#include "acquire/recorder/tally.h"

#include <algorithm>

namespace haptometer::acquire {

Tally::Tally(const Sensor& sensor, MonotonicNs origin_ns)
    : sensor_(sensor),
      timing_(sensor.header().timing),
      rate_hz_(sensor.header().rate_hz),
      origin_ns_(origin_ns),
      gaps_(timing_,
            sensor.header().metadata.fields.contains(std::string(trial::kLineNumbersField))) {}

MonotonicNs Tally::SinceBegin(const Reading& reading) const {
  if (timing_ != trial::Timing::kUniform) return reading.time_ns - origin_ns_;
  return NsFromSeconds(static_cast<double>(reading.index) / rate_hz_);
}

void Tally::Add(const Reading& reading) {
  ++summary_.readings;
  ++summary_.statuses[static_cast<std::size_t>(RowStatus(reading))];
  if (std::ranges::any_of(reading.samples, trial::IsMeasurement, &trial::Sample::status)) {
    ++summary_.measured;
  }
  const MonotonicNs time_ns = SinceBegin(reading);
  summary_.elapsed_s = SecondsFromNs(time_ns);
  // what the sensor counts itself needs no guess from the interval
  if (reading.lost_before > 0) {
    ++known_gaps_;
    Restart();
  }
  intervals_.Add(time_ns);
  gaps_.Add(reading);
}

void Tally::Restart() {
  gaps_.Restart();
  intervals_.Restart();
}

void Tally::Lose(std::uint64_t rows) {
  summary_.lost += rows;
  ++known_gaps_;
  Restart();
}

void Tally::Leave() {
  summary_.is_away = true;
  ++known_gaps_;
}

void Tally::Return() {
  summary_.is_away = false;
  ++summary_.reconnects;
  Restart();
}

void Tally::Fire() {
  ++summary_.triggers;
  Restart();
}

void Tally::End(MonotonicNs since_begin_ns) {
  if (!summary_.is_away) gaps_.End(origin_ns_ + since_begin_ns);
}

RecordingSummary Tally::Summary() const {
  RecordingSummary summary = summary_;
  summary.gaps = gaps_.gaps() + known_gaps_;
  summary.rate_hz = intervals_.RateHz();
  summary.interval_sd_s = intervals_.DeviationSeconds();
  summary.discarded_bytes = sensor_.discarded_bytes();
  return summary;
}

}  // namespace haptometer::acquire
