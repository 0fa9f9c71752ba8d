#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "tools/acquire/recording.h"
#include "tools/acquire/sensor_options.h"
#include "tools/session/session_plan.h"
#include "trial/import/import_options.h"

namespace haptometer::tools {

/// The words of a source with the files and folders that they name as full paths, so that the plan
/// means the same from every directory: those behind --from-folder, --port, --profile and
/// --calibration, where they are there, and a scene's.
[[nodiscard]] std::vector<std::string> WithFullPaths(std::vector<std::string> words);

/// The scene that the plan's source plays; empty of another source.
[[nodiscard]] std::string SceneOf(const SessionPlan& plan);

/// A folder into which another program writes a file for each trial.
struct FolderSource {
  std::string folder;
  std::string pattern = "*";      ///< of the files' names, as a shell's (fnmatch)
  double unchanged_s = 2;         ///< a file that has not changed for this time is complete
  trial::ImportOptions import{};  ///< how its tables are read
};

/// The source of a plan, read: a sensor, as acquire's own options state it, or a folder.
struct SessionSource {
  SensorOptions sensor;
  RecordingPlan plan;
  std::optional<FolderSource> folder;  ///< in place of the sensor
};

/// Reads SessionPlan::source; `verb` stands before what is reported. A word that is no option of
/// acquire is reported on stderr at once; its error has no words. Other errors (Cause::kUsage): an
/// option that the session decides itself (file, labels, end), or acquire's; a folder without a
/// name.
[[nodiscard]] Result<SessionSource> ReadSource(const SessionPlan& plan, std::string_view verb);

/// What can be known of a source before the first recording: the scene or trial that it plays is
/// readable; the folder exists and is not `session_folder`. Errors: as OpenSensor; Cause::kUsage
/// for the folder.
[[nodiscard]] Result<void> CheckSource(const SessionSource& source,
                                       const std::string& session_folder);

/// Its name in messages: "stream /dev/ttyUSB0", "scene lra.toml", "folder daq, *.csv".
[[nodiscard]] std::string NameOf(const SessionSource& source);

}  // namespace haptometer::tools
