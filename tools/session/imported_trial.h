#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "base/clock.h"
#include "base/error.h"
#include "tools/session/attempt.h"
#include "tools/session/watched_folder.h"

namespace haptometer::tools {

/// The trial that `file` of the folder becomes; reads the file into memory and never writes it.
///
/// Rows, channels and metadata are those that trial::ReadRecording gives. The header states the
/// file's name, size, SHA-256 and time of modification in the fields `import.file`, `import.bytes`,
/// `import.sha256` and `import.modified_ns`, and that the data are imported, unless the file itself
/// states another source. Time counts from the first row. Doubts of the importer are doubts of the
/// attempt. A file that cannot be read makes an attempt that is BAD, with the reason.
[[nodiscard]] AttemptSource ImportOf(const FolderSource& source, const FolderFile& file,
                                     Clock& clock, std::string command_line);

/// How the next file of a folder is waited for.
struct FolderWait {
  double longest_s;
  const std::atomic<bool>& stop;
  std::function<void(const std::string&)> found;  ///< gets the file's name and its cell, in words
};

/// Waits for the next complete file and makes it an attempt of `cell`, or of the cell of the file
/// that it continues. Errors: Cause::kCannotAnswer where none came in time, or `stop` was set; as
/// WatchedFolder::Examine and MakeAttempt.
[[nodiscard]] Result<AttemptOutcome> ImportAttempt(SessionFolder& session, const SessionCell& cell,
                                                   const FolderSource& source,
                                                   const FolderWait& wait,
                                                   std::string command_line);

}  // namespace haptometer::tools
