#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "acquire/recorder/recorder.h"
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

}  // namespace haptometer::tools
