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
  kOtherTone,       ///< frequency_hz, expected_hz, tolerance_hz
  kOtherAmplitude,  ///< amplitude_m, expected_m, tolerance_m
  kOtherRms,        ///< rms_m, expected_m, tolerance_m
  kChanges,         ///< change, most
  kOtherSource,     ///< source, expected
  kNotDetermined,   ///< quantity: it is expected, and the trial does not give it
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
  std::optional<double> most_change;        ///< of the amplitude over the window, as a share
  std::optional<trial::DataSource> source;  ///< of the data
};

/// Reads "tone=225Hz+-1Hz, amplitude=20um+-2um, rms=14um+-1um, change<5%, source=device"; each at
/// most once. Errors (Cause::kUsage), naming --expect.
[[nodiscard]] Result<Expectation> ParseExpectation(const std::string& text);

/// Where an analysis differs from `expected`; a quantity that it does not give differs as well.
[[nodiscard]] ExpectationFindings DeviationsFrom(const Expectation& expected,
                                                 const dsp::BandAnalysis& analysis,
                                                 const std::vector<trial::DataSource>& sources);

}  // namespace haptometer::tools
