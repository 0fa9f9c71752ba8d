#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "trial/record.h"

namespace haptometer::trial {

/// What a laser sensor's head and amplifier do to a displacement before anybody sees a number.
struct SensorHead {
  std::string name;
  double sampling_s = 0;    ///< raw samples are taken at k * sampling_s, k = 0, 1, ...
  int averages = 1;         ///< each reading is the mean of the last `averages` raw samples
  double resolution_m = 0;  ///< readings are rounded to whole steps; 0: not rounded
  double noise_rms_m = 0;   ///< white, Gaussian, per raw sample
  double range_min_m = 0;   ///< below: SampleStatus::kUnder
  double range_max_m = 0;   ///< above: SampleStatus::kOver
};

/// Keyence IL-030 on an IL-1000: 1 um steps, from -15 mm to +10 mm about the 30 mm reference (45 mm
/// to 20 mm away), 11 um of white noise per raw sample, which is the data sheet's 1 um at 128
/// averages. Sampling 1 ms, 16 averages (factory setting).
[[nodiscard]] SensorHead Il030();

/// A fast head for free-running output: 10 kHz, 0.1 um steps, 0.5 um of noise, no averaging.
[[nodiscard]] SensorHead Stream10kHz();

/// What averaging `averages` (>= 1) samples taken every `sampling_s` leaves of a tone:
///   |sin(pi f n Ts) / (n sin(pi f Ts))|
[[nodiscard]] double AveragingGain(double frequency_hz, double sampling_s, int averages);

/// Displacement in metres at time t in seconds.
using Displacement = std::function<double(double t_s)>;

/// One reading as the head hands it out.
struct HeadReading {
  double value_m = 0;  ///< rounded to the resolution; at the range's end when over or under
  SampleStatus status = SampleStatus::kOk;
};

/// Reading number `k`: mean of the raw samples k - averages + 1 .. k (times may be negative), plus
/// noise, rounded, checked against the range.
///
/// The noise of a raw sample depends only on (seed, its number), so any reading can be had in any
/// order, twice with the same answer. Cost: `averages` calls of `displacement`; no state, threads
/// may share it.
[[nodiscard]] HeadReading ReadingAt(const SensorHead& head, const Displacement& displacement,
                                    std::int64_t k, std::uint64_t seed);

}  // namespace haptometer::trial
