#pragma once

#include <cstdint>
#include <optional>

#include "dsp/analysis/decision_limits.h"
#include "trial/record.h"

namespace haptometer::dsp {

/// What is known of what a sensor does to a vibration before anybody sees a number.
enum class SensorKnowledge : std::uint8_t {
  kNone,     ///< it averages nothing and hands out each reading once
  kKnown,    ///< sampling period and averages are on record
  kUnknown,  ///< not on record: amplitudes are not verified
};

/// A sensor's averaging, and the holding of readings that are handed out again.
struct SensorAveraging {
  SensorKnowledge knowledge = SensorKnowledge::kUnknown;
  double sampling_s = 0;  ///< of raw samples; where knowledge is kKnown
  int averages = 1;       ///< raw samples in one reading
  double rate_hz = 0;     ///< of the record's rows
  int repeats = 1;        ///< rows that one reading fills
};

/// What `metadata` and the rates say. A source without averages on record is kUnknown, whatever it
/// is; one average is kNone, with or without a sampling period. `fresh_rate_hz` is the rate without
/// repeated readings (<= rate_hz); the ratio counts as repeats where it is a whole number within 2
/// %, and is rounded up otherwise.
[[nodiscard]] SensorAveraging AveragingOf(const trial::Metadata& metadata, double rate_hz,
                                          double fresh_rate_hz);

/// The gain at `frequency_hz`: trial::AveragingGain of the averages times that of the repeats, a
/// mean of `repeats` rows; nothing where it is unknown.
[[nodiscard]] std::optional<double> GainAt(const SensorAveraging& sensor, double frequency_hz);

/// Least and greatest gain over a band, on 1000 frequencies and its ends.
struct GainBounds {
  double least = 1;
  double greatest = 1;
};
[[nodiscard]] std::optional<GainBounds> GainsOver(const SensorAveraging& sensor, double lower_hz,
                                                  double upper_hz);

/// The most averages that leave at least kLeastSensorGain at `frequency_hz`; at least 1.
[[nodiscard]] int MostAverages(double frequency_hz, double sampling_s);

}  // namespace haptometer::dsp
