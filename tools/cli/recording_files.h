#pragma once

#include <string>
#include <vector>

#include "base/error.h"

namespace haptometer::cli {

/// A file of a folder that may hold a trial.
struct RecordingFile {
  std::string path;
  /// A table of results among recordings, to be ignored: a CSV whose header names band RMS, matched
  /// voltages, subjects, or frequencies without a time.
  bool is_table = false;
};

/// All recordings (.bin, .csv, .lvm, in capitals too) in a folder and the folders in it, sorted by
/// path; without links to another of them, names that begin with a point, and lost+found.
/// Errors: kFailed: a folder cannot be listed, so that recordings would be missing;
/// kCannotAnswer: there is no recording.
[[nodiscard]] Result<std::vector<RecordingFile>> RecordingsIn(const std::string& folder);

}  // namespace haptometer::cli
