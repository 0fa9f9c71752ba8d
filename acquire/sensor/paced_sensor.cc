#include "acquire/sensor/paced_sensor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kSliceNs = 100'000'000;

}  // namespace

PacedSensor::PacedSensor(std::unique_ptr<Sensor> inner, double speed, Clock& clock)
    : inner_(std::move(inner)), speed_(speed), clock_(clock) {
  HAPTOMETER_CHECK(speed > 0, "speed = {}", speed);
}

MonotonicNs PacedSensor::Begin() {
  is_held_ = false;  // a row of the beginning before, with its index
  inner_begin_ns_ = inner_->Begin();
  begin_ns_ = clock_.Now();
  return begin_ns_;
}

MonotonicNs PacedSensor::DueNs() const {
  const trial::TrialHeader& header = inner_->header();
  double since_begin_s = 0;
  if (header.timing == trial::Timing::kUniform) {
    since_begin_s = static_cast<double>(held_.index) / header.rate_hz;
  } else {
    const bool is_polled = header.timing == trial::Timing::kPolled;
    const MonotonicNs time_ns = is_polled ? held_.reply_ns : held_.time_ns;
    since_begin_s = SecondsFromNs(time_ns - inner_begin_ns_);
  }
  return begin_ns_ + NsFromSeconds(since_begin_s / speed_);
}

Outcome PacedSensor::Next(Reading& reading) {
  if (!is_held_) {
    if (const Outcome outcome = inner_->Next(held_); outcome != Outcome::kReading) return outcome;
    is_held_ = true;
  }
  if (std::isfinite(speed_)) {
    const MonotonicNs due_ns = DueNs();
    const MonotonicNs now_ns = clock_.Now();
    if (due_ns > now_ns) clock_.SleepUntil(std::min(due_ns, now_ns + kSliceNs));
    if (clock_.Now() < due_ns) return Outcome::kNothing;
  }
  is_held_ = false;
  reading = held_;
  // the same distances from this beginning
  reading.time_ns += begin_ns_ - inner_begin_ns_;
  reading.reply_ns += begin_ns_ - inner_begin_ns_;
  return Outcome::kReading;
}

}  // namespace haptometer::acquire
