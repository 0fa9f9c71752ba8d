#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "tools/study/planned_contrast.h"

namespace haptometer::tools {

/// Recordings that are found alike: [[trials]] of a manifest.
struct TrialGroup {
  std::string files;      ///< a glob, relative to the manifest
  std::string pattern;    ///< labels in the file's name (FilePattern); empty: the manifest's
  std::string subject;    ///< of all these files; empty: from pattern or file
  std::string condition;  ///< the same
  std::string repeat;     ///< the same
};

/// What a study's manifest (TOML, docs/study.md) says; empty where it does not.
struct Manifest {
  std::vector<TrialGroup> groups;
  std::string pattern;
  std::vector<std::string> conditions;  ///< in the order in which they are to be shown
  std::vector<PlannedContrast> contrasts;
  std::string band;  ///< "20-500Hz"
  std::optional<long long> order;
  std::string corner;  ///< "whole" or "each"
  std::string floor;   ///< a drive-off trial, relative to the manifest
};

/// Reads a manifest strictly. Errors: as TomlTable; a contrast that is no pair of two conditions.
[[nodiscard]] Result<Manifest> ReadManifest(const std::string& path);

}  // namespace haptometer::tools
