#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "tools/acquire/recording.h"
#include "tools/acquire/sensor_options.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_log.h"

namespace haptometer::tools {

/// The source of a plan, read: what acquire's own options say.
struct SessionSource {
  SensorOptions sensor;
  RecordingPlan plan;
};

/// Reads SessionPlan::source. A word that is no option of acquire is reported on stderr at once;
/// its error has no words. Other errors (Cause::kUsage): an option that the session decides itself
/// (file, labels, end), or acquire's.
[[nodiscard]] Result<SessionSource> ReadSource(const SessionPlan& plan);

/// What an attempt gave.
struct AttemptOutcome {
  SessionAttempt attempt;            ///< ended
  std::vector<std::string> reasons;  ///< of CHECK and BAD
  std::optional<double> band_rms_m;
  std::optional<double> tone_hz;
};

/// Records one attempt of `cell` as acquire does, and judges it: the log has a line before the
/// recording and one behind it.
///
/// BAD: interrupted, or analyze has no value for it (of a floor: it has one). CHECK: a value that
/// deviates from the plan's limits, a doubt of analyze other than that the sensor's averaging is
/// unknown, or lost data. Errors: those of the sensor, before the log has a line; Cause::kFailed of
/// the disk, where the log says BAD if it can be written.
[[nodiscard]] Result<AttemptOutcome> RecordAttempt(SessionFolder& session, const SessionCell& cell,
                                                   std::string command_line);

}  // namespace haptometer::tools
