#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "dsp/analysis/band_question.h"
#include "dsp/analysis/rms_estimate.h"
#include "dsp/analysis/sensor_gain.h"
#include "dsp/findings.h"
#include "tools/document/document.h"

/// What dsp's findings say, and other results of it that are no numbers.
namespace haptometer::document {

/// What is said of a trial whose sensor's averaging is not known, and how to make it known.
inline constexpr std::string_view kAmplitudeNotVerified =
    "amplitude not verified: sensor averaging unknown";
inline constexpr std::string_view kAveragingRemedy =
    "state it in the header of a CSV, as '# averages = 16' and '# sampling_s = 0.00033' "
    "(haptometer "
    "trial export FILE -o OUT.csv makes one of any trial)";

/// The finding in words, its subject before them.
[[nodiscard]] std::string TextOf(const dsp::Finding& finding);

/// The refusals in words.
[[nodiscard]] std::vector<std::string> RefusalsOf(const dsp::Findings& findings);

/// The first refusal in words; empty where there is none.
[[nodiscard]] std::string RefusalOf(const dsp::Findings& findings);

/// Where a noise level is from: the name of its file, "0.000 s to 0.375 s of the record", or "the
/// spectrum beside the drive".
[[nodiscard]] std::string SourceOf(const dsp::NoiseFloor& floor);

/// "16 averages at 0.33 ms", "no averaging", "averaging unknown", each with ", each reading held
/// for 5 rows" where that is so.
[[nodiscard]] std::string TextOf(const dsp::SensorAveraging& sensor);

/// A cause of an RMS's uncertainty: "noise", "periodogram of what the tone leaves".
struct CauseText {
  std::string_view name;
  std::string_view how;  ///< it is evaluated
};
[[nodiscard]] CauseText TextOf(dsp::RmsCause cause);

}  // namespace haptometer::document
