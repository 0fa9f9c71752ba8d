#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>

#include "acquire/sensor/sensor.h"

namespace haptometer::acquire {

inline const std::atomic<bool> kNeverStop{false};

/// Starts `sensor` and, where it answers, begins its readings.
[[nodiscard]] inline Result<void> StartAndBegin(Sensor& sensor) {
  auto started = sensor.Start(kNeverStop);
  if (started) (void)sensor.Begin();
  return started;
}

/// The next row of `sensor`, however often Next() has to be called; a bound keeps a defect from
/// hanging.
inline Reading NextRowOf(Sensor& sensor) {
  Reading reading;
  for (int call = 0; call < 1000; ++call) {
    if (sensor.Next(reading) == Outcome::kReading) return reading;
  }
  ADD_FAILURE() << "no row";
  reading.samples.resize(1);
  return reading;
}

inline std::int32_t Counts(const trial::Sample& sample) {
  return static_cast<std::int32_t>(sample.raw.bits());
}

/// The counts of a row's first channel.
inline std::int32_t Counts(const Reading& reading) { return Counts(reading.samples[0]); }

}  // namespace haptometer::acquire
