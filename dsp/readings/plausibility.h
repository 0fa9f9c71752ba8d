#pragma once

#include <cstddef>
#include <optional>

#include "base/error.h"
#include "dsp/findings.h"
#include "dsp/readings/raw_summary.h"
#include "trial/record.h"
#include "trial/row_source.h"

/// Whether a record's readings are what they are said to be: slips of a unit, a setting, a sensor
/// that stands still. What may be right is a doubt and changes no number.
namespace haptometer::dsp {

/// Farther than this from zero, or from end to end, reaches no displacement sensor.
inline constexpr double kFarthestReadingM = 1;
/// An RMS above or below which no vibration is read by a laser distance sensor.
inline constexpr double kLargestBandRmsM = 0.01;
inline constexpr double kSmallestBandRmsM = 1e-10;

/// How fast a record is, and how fast it must be.
struct ReadingRate {
  double rate_hz = 0;
  double fresh_rate_hz = 0;  ///< without readings handed out again
  double duration_s = 0;
  double needed_hz = 0;  ///< by what is asked of it
};

/// Adds a doubt where readings lie beyond kFarthestReadingM; where the file's sampling period
/// allows fewer new readings than came (by more than 5 %); and where an imported table is too slow
/// or too fast, but would not be with times in milli- or microseconds, or seconds.
void RemarkPlausibility(const trial::Record& head, const RawSummary& summary,
                        const ReadingRate& rate, Findings* findings);

/// Adds a doubt where measurements of `channel` lie beyond the range in which the record's
/// calibration was measured, by more than 1 % of its width. Reads the channel where one does.
/// Errors: as RowSource::Read.
[[nodiscard]] Result<void> CheckCalibratedRange(const trial::RowSource& source, std::size_t channel,
                                                const RawSummary& summary, Findings* findings);

/// Adds a doubt where an RMS (m) lies beyond the limits above; a large one only where the readings,
/// `farthest_m` from zero or from end to end, are not doubted already.
void RemarkImplausibleRms(double rms_m, double farthest_m, Findings* findings);

/// Why the readings cannot be of a vibration: 16 or more that are all the same; nothing otherwise.
[[nodiscard]] std::optional<Finding> WhyStuck(const RawSummary& summary);

}  // namespace haptometer::dsp
