#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "tools/study/manifest.h"

namespace haptometer::tools {

/// A recording of a study, and what is said of it from outside; the file's own labels count where
/// `labels` has none.
struct TrialFile {
  std::string path;
  std::map<std::string, std::string> labels;  ///< of subject, condition, repeat
  std::optional<Error> error;                 ///< its name does not fit the pattern
};

/// Labels in a file's name: "{subject}_{condition}_{repeat}" against the name without its ending,
/// with "/" in the pattern against as many folders above it. A label matches as little as it can,
/// and never a "/". Nothing where the name does not fit.
[[nodiscard]] std::optional<std::map<std::string, std::string>> LabelsOf(
    const std::string& path, const std::string& pattern);

/// Whether `pattern` is one: known names in braces, each once, at least one. Errors
/// (Cause::kUsage).
[[nodiscard]] Result<void> CheckPattern(const std::string& pattern);

/// All recordings (.bin, .csv, .lvm) in a folder and the folders in it, by name. Errors
/// (Cause::kCannotAnswer): there is none.
[[nodiscard]] Result<std::vector<TrialFile>> FilesInFolder(const std::string& folder,
                                                           const std::string& pattern);

/// The files of a manifest's [[trials]]; without any, those in the manifest's folder. Errors
/// (Cause::kCannotAnswer): a glob that finds nothing, a file in two groups.
[[nodiscard]] Result<std::vector<TrialFile>> FilesOfManifest(const std::string& path,
                                                             const Manifest& manifest);

}  // namespace haptometer::tools
