#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquire/capability.h"
#include "acquire/recorder/recorder.h"
#include "acquire/transport/port_list.h"
#include "base/error.h"
#include "base/quantity.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// What the cleaned time base of a finished recording says (trial/time_base.h).
struct TimeBaseReview {
  std::uint64_t gaps = 0;    ///< between its stretches: single lost lines show here
  double uncertainty_s = 0;  ///< of a row's time, the worst stretch's standard deviation
};

/// Reads a free-running sensor's trial back and fits its time base, which finds losses that the
/// clock alone does not show while they happen. Nothing for other timings, for nothing kept, and
/// beyond a million rows, whose memory would be 100 MB (`trial info` says it then).
/// Cost: about 0.1 us a row.
[[nodiscard]] std::optional<TimeBaseReview> ReviewTimeBase(
    const std::string& file, trial::Timing timing, const acquire::RecordingSummary& summary);

/// "times are straightened to 0.0045 ms; all are late by one unknown latency, at least 0.098 ms":
/// the second part where the header's field latency_at_least_s tells it.
[[nodiscard]] std::string TimeBaseRemark(const TimeBaseReview& review,
                                         const trial::Metadata& metadata);

/// The last line of a recording: "trial.bin: 30000 readings in 3.000 s (10000.0/s, jitter 0.021
/// ms), 2 bad (1 late, 1 bad_frame), 0 repeated, 0 gaps". Without a file: "nothing kept: ...".
[[nodiscard]] std::string SummaryLine(const std::string& file,
                                      const acquire::RecordingSummary& summary);

/// How far a recording that runs has come: "12.5 s  125000 readings  10000.0/s".
[[nodiscard]] std::string ProgressLine(const acquire::RecordingSummary& summary);

/// The JSON document of `acquire --json` (docs/reference/acquire.md), with a line's end; `file` is
/// null where it is empty.
[[nodiscard]] std::string SummaryJson(const std::string& file, const trial::Metadata& metadata,
                                      const acquire::RecordingSummary& summary,
                                      const std::optional<TimeBaseReview>& time_base);

/// What `acquire --list-ports` prints: a port with what is known of it, and what its latency timer
/// costs a DL-RS1A.
[[nodiscard]] std::string PortListText(const std::vector<acquire::PortInfo>& ports);

/// The same as a JSON document (docs/reference/acquire.md), with a line's end.
[[nodiscard]] std::string PortListJson(const std::vector<acquire::PortInfo>& ports);

/// What is asked of the sensors, from `--band` and `--resolution`. Errors (Cause::kUsage): a band
/// that is none, a resolution that is not above 0.
[[nodiscard]] Result<acquire::CapabilityQuestion> ReadCapabilityQuestion(
    const std::string& band, const std::optional<Quantity>& resolution_m);

/// What `acquire --list-sensors` prints: each known sensor, whether it can answer, and why.
[[nodiscard]] std::string SensorListText(const acquire::CapabilityQuestion& question);

/// The same as a JSON document (docs/reference/acquire.md), with a line's end.
[[nodiscard]] std::string SensorListJson(const acquire::CapabilityQuestion& question);

}  // namespace haptometer::tools
