#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "dsp/findings.h"
#include "tools/document/document.h"

/// What dsp's findings say.
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

}  // namespace haptometer::document
