#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_log.h"
#include "tools/session/session_source.h"
#include "trial/trial_format.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {

/// What an attempt gave.
struct AttemptOutcome {
  SessionAttempt attempt;            ///< ended
  std::vector<std::string> reasons;  ///< of CHECK and BAD
  std::optional<double> band_rms_m = {};
  std::optional<double> band_rms_uncertainty_m = {};  ///< standard
  std::optional<double> tone_hz = {};
  std::optional<double> tone_uncertainty_hz = {};  ///< standard
  std::string floor = {};                          ///< the subject's floor that was subtracted
};

/// How the trial of an attempt comes to be: recorded from a sensor, or imported.
struct AttemptSource {
  trial::TrialHeader header;  ///< as the source states it: without plan, cell and attempt
  /// Makes the file with that header. Errors of Cause::kCannotAnswer are a verdict: BAD.
  std::function<Result<acquire::RecordingSummary>(const std::string& path,
                                                  const trial::TrialHeader& header)>
      write;
  std::string origin{};  ///< of an import its file, as TextOf(FolderFile)
};

/// The field of an imported trial that holds the importer's doubts: a reason for CHECK.
inline constexpr std::string_view kImportDoubts = "import.doubts";

/// Who watches a recording, and who may end it.
struct RecordingWatch {
  const std::atomic<bool>& stop;
  std::function<void(const acquire::Reading&)> reading{};  ///< in the reading thread
  std::function<void()> begun{};                           ///< the recording begins
  std::function<void()> recorded{};  ///< the recording has ended, its verdict is to come
};

/// A new trial at `path`, which is there with its whole header at once: until then it has the name
/// with `.new` behind it, so that kill -9 leaves no file without a header to studies. Errors: as
/// trial::TrialWriter::Create.
[[nodiscard]] Result<trial::TrialWriter> CreateTrial(const std::string& path,
                                                     const trial::TrialHeader& header,
                                                     Clock& clock);

/// A recording of `sensor`, which has started; all but `source` must outlive the result. Errors: as
/// LimitsOf.
[[nodiscard]] Result<AttemptSource> RecordingOf(acquire::Sensor& sensor,
                                                const SessionSource& source, Clock& clock,
                                                const RecordingWatch& watch,
                                                std::string command_line);

/// Makes an attempt of `cell` and judges it: the log has a line before it and one behind it.
///
/// The noise of the subject's last GOOD floor is subtracted that is not excluded by hand. BAD: cut
/// short, unreadable, or analyze has no value for it (of a floor: it has one, or tells no noise).
/// CHECK: a value that deviates from the plan's limits, a doubt of analyze other than that the
/// sensor's averaging is unknown or readings are held beside its window, doubts of an importer,
/// lost data, or an end before 90 % of the duration. Errors: Cause::kFailed of the disk; the log
/// then states BAD if it can be written, but for an import, which did not end: its file is imported
/// again.
[[nodiscard]] Result<AttemptOutcome> MakeAttempt(SessionFolder& session, const SessionCell& cell,
                                                 const AttemptSource& source);

/// The verdict on a finished attempt as one of `cell`, by its file and what of the session was
/// there before it; `attempt.verdict` is it, without rejections. One that was cut short, or has no
/// file, keeps its own. Errors: as MakeAttempt.
[[nodiscard]] Result<AttemptOutcome> JudgeAs(const SessionFolder& session,
                                             const SessionAttempt& attempt,
                                             const SessionCell& cell);

/// Opens the sensor of `source`, and makes an attempt of one recording. Errors: those of the
/// sensor, before the log has a line; as MakeAttempt.
[[nodiscard]] Result<AttemptOutcome> RecordAttempt(SessionFolder& session, const SessionCell& cell,
                                                   const SessionSource& source,
                                                   std::string command_line);

}  // namespace haptometer::tools
