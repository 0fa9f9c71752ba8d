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
