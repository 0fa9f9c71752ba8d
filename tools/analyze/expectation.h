#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/finding.h"
#include "base/quantity.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/document/document.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {

/// How a trial differs from what --expect states; each is a doubt, and ends with status 3.
enum class ExpectationFinding : std::uint8_t {
  kOtherTone,         ///< frequency_hz, expected_hz, tolerance_hz
  kOtherAmplitude,    ///< amplitude_m, expected_m, tolerance_m
  kOtherRms,          ///< rms_m, expected_m, tolerance_m
  kOtherDistance,     ///< distance_m, expected_m, tolerance_m
  kOtherScale,        ///< quantity, factor: a factor beyond kOtherScaleFactor from what is expected
  kOtherSign,         ///< distance_m, expected_m
  kChanges,           ///< change, most
  kBadSamples,        ///< share, most
  kShort,             ///< steady_s, least_s
  kTremor,            ///< tremor_m, most_m
  kOtherAveraging,    ///< averages, expected
  kOtherSource,       ///< source, expected
  kOtherThanRepeats,  ///< deviation, most, repeats_m
  kNotDetermined,     ///< quantity: it is expected, and the trial does not give it
};

using ExpectationFindings = Findings<ExpectationFinding>;

/// The words of a kind.
[[nodiscard]] document::Sentence SentenceOf(ExpectationFinding kind);

/// What is expected of a trial; what is absent may be anything. A quantity's uncertainty is the
/// largest difference that is permitted.
struct Expectation {
  std::optional<Quantity> tone_hz;
  std::optional<Quantity> amplitude_m;      ///< of the tone
  std::optional<Quantity> rms_m;            ///< within the band
  std::optional<Quantity> distance_m;       ///< of the target, mean of all samples
  std::optional<double> most_change;        ///< of the amplitude over the window, as a share
  std::optional<double> most_bad;           ///< samples without a measurement, as a share
  std::optional<double> least_steady_s;     ///< length of the window
  std::optional<double> most_tremor_m;      ///< RMS from 3 to 13 Hz
  std::optional<double> averages;           ///< of the sensor, in a reading
  std::optional<double> most_off_repeats;   ///< of the RMS, as a share of the earlier repeats'
  std::optional<trial::DataSource> source;  ///< of the data
};

/// An RMS, amplitude or distance so many times too large or too small is a question of unit, scale
/// or calibration, and no longer one of the vibration.
inline constexpr double kOtherScaleFactor = 3;

/// Reads "tone=225Hz+-1Hz, amplitude=20um+-2um, change<5%, bad<1%, steady>2s, averaging=16,
/// source=device" (docs/reference/analyze.md); each at most once. Errors (Cause::kUsage), naming
/// --expect.
[[nodiscard]] Result<Expectation> ParseExpectation(const std::string& text);

/// Where an analysis differs from `expected`; a quantity that it does not give differs as well.
/// `repeats_m`: what the RMS of earlier repeats is; nothing where there are too few.
[[nodiscard]] ExpectationFindings DeviationsFrom(const Expectation& expected,
                                                 const dsp::BandAnalysis& analysis,
                                                 const std::vector<trial::DataSource>& sources,
                                                 std::optional<double> repeats_m = {});

}  // namespace haptometer::tools
