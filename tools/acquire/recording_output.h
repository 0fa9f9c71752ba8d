#pragma once

#include <optional>
#include <string>

#include "acquire/recorder/recorder.h"
#include "tools/acquire/time_base_review.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// The last line of a recording: "trial.bin: 30000 readings in 3.000 s (10000.0/s, jitter 0.021
/// ms), 2 bad (1 late, 1 bad_frame), 0 repeated, 0 gaps". Without a file: "nothing kept: ...".
[[nodiscard]] std::string SummaryLine(const std::string& file,
                                      const acquire::RecordingSummary& summary);

/// How far a recording that runs has come: "12.5 s  125000 readings  10000.0/s".
[[nodiscard]] std::string ProgressLine(const acquire::RecordingSummary& summary);

/// The JSON document of `acquire --json` (docs/commands.md), with a line's end; `file` is null
/// where it is empty.
[[nodiscard]] std::string SummaryJson(const std::string& file, const trial::Metadata& metadata,
                                      const acquire::RecordingSummary& summary,
                                      const std::optional<TimeBaseReview>& time_base);

}  // namespace haptometer::tools
