#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquire/capability.h"
#include "acquire/findings.h"
#include "acquire/recorder/recorder.h"
#include "acquire/transport/port_list.h"
#include "base/error.h"
#include "tools/document/document.h"
#include "tools/document/keys.h"
#include "trial/findings.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

// keys of a recording, of a check and of a daemon's status
inline constexpr document::Key kBadKey{"bad", "bad"};
inline constexpr document::Key kRepeatedKey{"repeated", "repeated"};
inline constexpr document::Key kLostKey{"lost", "lost to a slow disk"};
inline constexpr document::Key kReconnectsKey{"reconnects", "reconnections"};
inline constexpr document::Key kJitterKey{"jitter_s", "jitter", document::kSecond};

/// What the cleaned time base of a finished recording shows (trial/time_base.h).
struct TimeBaseReview {
  std::uint64_t gaps = 0;    ///< between its segments: single lost lines show here
  double uncertainty_s = 0;  ///< of a row's time, the worst segment's standard deviation
  trial::Findings doubts{};  ///< of the numbers of lines
};

/// Reads a free-running sensor's trial back and fits its time base, which finds losses that the
/// clock alone does not show while they happen. Nothing for other timings, for nothing kept, and
/// beyond a million rows, whose memory would be 100 MB (`trial info` has it then).
/// Cost: about 0.1 us a row.
[[nodiscard]] std::optional<TimeBaseReview> ReviewTimeBase(
    const std::string& file, trial::Timing timing, const acquire::RecordingSummary& summary);

/// What came of a recording; `file` is empty where nothing was kept. `found`: by the sensor, shown
/// with all details.
[[nodiscard]] document::Document RecordingDocument(const std::string& file,
                                                   const trial::Metadata& metadata,
                                                   const acquire::RecordingSummary& summary,
                                                   const std::optional<TimeBaseReview>& time_base,
                                                   const acquire::Findings& found);

/// How far a recording that runs has come: "12.5 s  125000 readings  10000.0/s".
[[nodiscard]] std::string ProgressLine(const acquire::RecordingSummary& summary);

/// The serial ports: what is known of each, and what its latency timer costs a DL-RS1A.
[[nodiscard]] document::Document PortsDocument(const std::vector<acquire::PortInfo>& ports);

/// What is asked of the sensors, from `--band` and `--resolution`. Errors (Cause::kUsage): a band
/// that is none.
[[nodiscard]] Result<acquire::CapabilityQuestion> ReadCapabilityQuestion(
    const std::string& band, std::optional<double> resolution_m);

/// Each known sensor, whether it can answer the question, and why.
[[nodiscard]] document::Document SensorsDocument(const acquire::CapabilityQuestion& question);

}  // namespace haptometer::tools
