#pragma once

#include <cstdint>

#include "base/clock.h"
#include "trial/sensor_head.h"

namespace haptometer::acquire::emulator {

/// A sensor head that looks at something moving, over the emulator's time (0: switched on).
struct MovingHead {
  trial::SensorHead head;
  trial::Displacement
      displacement;        ///< metres at seconds since the start; also asked at negative times
  std::uint64_t seed = 1;  ///< of the noise

  /// When raw sample `number` is complete: number * sampling_s, rounded to nanoseconds.
  [[nodiscard]] MonotonicNs SampleTime(std::int64_t number) const;

  /// The last raw sample complete at `now` >= 0.
  [[nodiscard]] std::int64_t LastSample(MonotonicNs now) const;

  /// The head's reading number `number` (trial/sensor_head.h).
  [[nodiscard]] trial::HeadReading Reading(std::int64_t number) const;
};

}  // namespace haptometer::acquire::emulator
