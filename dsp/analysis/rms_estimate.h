#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dsp/analysis/band_noise.h"
#include "dsp/statistics/distributions.h"

namespace haptometer::dsp {

/// How a contribution was evaluated (JCGM 100:2008, 4.2 and 4.3).
enum class Evaluation : std::uint8_t {
  kStatistical,  ///< Type A: from the scatter of the data
  kBound,        ///< Type B: a rectangle of half width a, whose standard deviation is a / sqrt(3)
  kStated,       ///< Type B: a standard uncertainty that is stated
};

/// What an RMS is uncertain by. A budget holds the sensor's calibration only where its uncertainty
/// is stated.
enum class RmsCause : std::uint8_t {
  kNoise,         ///< periodogram of what the tone leaves
  kNoiseFloor,    ///< scatter of the floor that is taken off
  kNoiseKept,     ///< noise that is not known: the RMS may hold so much of it, which lies below it
  kBelowBand,     ///< motion there: its amplitude times |H|^2, as power and as a beat with the tone
  kQuantisation,  ///< step / sqrt(12), white up to half the rate
  kBridged,       ///< readings: power of interpolation's errors in the band, and their beat
  kFilterEnds,    ///< what lay beyond the ends, as far as it may still show
  kBeat,          ///< of the tone with the next one: a window holds a part of one
  kDriveEdges,    ///< what a shorter window, or one without all that may be bumps, would change
  kSteps,         ///< their energy within the band
  kFoot,          ///< motion below the band in it: half of what was subtracted, all that was not
  kHum,           ///< half of its power; half a percent of it where a pause shows it alone
  kDrift,         ///< half the change of the amplitude over the window
  kCalibration,   ///< RMS times the relative standard uncertainty of the sensor's gain
};
inline constexpr std::size_t kRmsCauseCount = 14;

/// One line of an uncertainty budget.
struct UncertaintyLine {
  RmsCause cause{};
  Evaluation evaluation = Evaluation::kStatistical;
  double standard_uncertainty_m = 0;  ///< of the RMS
};

/// A bound on an error of the RMS as the filter put it out.
struct RmsBound {
  RmsCause cause{};
  double half_width_m = 0;
  bool only_below = false;  ///< the RMS may be too large by it, not too small
};

/// What a window holds, in mean squares behind the filter.
struct BandPower {
  double tone_mean_square = 0;      ///< of the drive: all that was measured, less the noise
  double tone_variance = 0;         ///< of `tone_mean_square`, from its beat with the noise
  NoisePower rest;                  ///< the window's own noise; without a drive all of it
  std::optional<NoisePower> floor;  ///< of the same band and filter without drive
  double sensor_gain = 1;           ///< at the tone; divided out of `tone_mean_square`
};

/// The band RMS with what was taken off and how well it is known.
///
///   RMS^2 = tone / gain^2 + rest - floor
struct RmsEstimate {
  double as_measured_m = 0;       ///< sqrt(tone + rest): nothing taken off, nothing divided out
  std::optional<double> floor_m;  ///< RMS of the floor
  double rms_m = 0;               ///< with the floor taken off and the gain divided out
  double standard_uncertainty_m = 0;
  double lower_m = 0;  ///< 95 % interval; at most the tone's, where the interval is wide
  double upper_m = 0;
  /// The floor is not exceeded (one-sided 95 %): `rms_m` says nothing, `at_most_m` does, and the
  /// interval is from 0 to it.
  bool below_floor = false;
  /// One-sided 95 % upper limit; never less than it is for a vibration of nothing, or of the tone;
  /// below the floor no more than was measured.
  double at_most_m = 0;
  /// The floor is above all that was measured (97.5 %): it is not this record's.
  bool floor_contradicts = false;
  std::vector<UncertaintyLine> budget;  ///< adds up in squares to standard_uncertainty_m
};

/// Adds up a window's power and its uncertainty.
///
/// The interval is that of the sum of independent mean squares by the method of variance estimates
/// recovery (Zou and Donner, Statistics in Medicine 27, 2008, p. 1693): each noise power has the
/// limits of its own chi-squared, the tone those of a t distribution, and the sum's distance to
/// either limit is the root of their squared distances. Bounds widen it in squares by 1.96 of their
/// standard deviations, which alone would cover a rectangle whole. One that is only below moves the
/// lower limit by all of it: that error may well be there in full.
[[nodiscard]] RmsEstimate EstimateRms(const BandPower& power, std::span<const RmsBound> bounds);

/// 95 % limits of `value` with those of a gain beside them, of relative standard uncertainty u: the
/// distances grow in squares by 1.96 u times the value, above by 1.96 u times the limit.
[[nodiscard]] Interval WithGain(double value, const Interval& limits, double relative);

/// Adds the sensor's gain to uncertainty, limits and budget:
/// u_total^2 = u^2 + (RMS u_gain)^2, u_gain = `relative`.
void AddGainUncertainty(double relative, RmsEstimate& estimate);

}  // namespace haptometer::dsp
