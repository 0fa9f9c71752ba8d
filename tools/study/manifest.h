#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/toml.h"
#include "dsp/analysis/band_question.h"

namespace haptometer::tools {

/// What is compared in a planned contrast: the ratio is treatment / control.
struct PlannedContrast {
  std::string treatment;
  std::string control;
};

/// "ia1 against stock".
[[nodiscard]] std::string NameOf(const PlannedContrast& contrast);

/// "ia1:stock". Errors (Cause::kUsage): no pair of two names.
[[nodiscard]] Result<PlannedContrast> ParseContrast(const std::string& word);

/// Each as ParseContrast.
[[nodiscard]] Result<std::vector<PlannedContrast>> ParseContrasts(
    const std::vector<std::string>& words);

/// The key `contrasts` of a table, pairs of treatment and control; what is none is refused there.
[[nodiscard]] std::vector<PlannedContrast> ReadContrasts(TomlTable& table);

/// Every condition against the first: what is compared where nothing was planned.
[[nodiscard]] std::vector<PlannedContrast> AllAgainstTheFirst(
    const std::vector<std::string>& conditions);

/// Errors (Cause::kUsage): one of two is none of `conditions`, with the nearest; a pair of
/// conditions twice, in whichever order, whose test Holm's correction would count twice.
[[nodiscard]] Result<void> CheckContrasts(const std::vector<PlannedContrast>& planned,
                                          const std::vector<std::string>& conditions);

/// Recordings that are found alike: [[trials]] of a manifest.
struct TrialGroup {
  std::string files;      ///< a glob, relative to the manifest
  std::string pattern;    ///< labels in the file's name (FilePattern); empty: the manifest's
  std::string subject;    ///< of all these files; empty: from pattern or file
  std::string condition;  ///< the same
  std::string repeat;     ///< the same
};

/// What a study's manifest (TOML, docs/reference/study.md) says; empty where it does not.
struct Manifest {
  std::vector<TrialGroup> groups;
  std::string pattern;
  std::vector<std::string> conditions;  ///< in the order in which they are to be shown
  bool is_session = false;              ///< of the plan of a session, which may have no trial yet
  std::vector<PlannedContrast> contrasts;
  std::string band;  ///< "20-500Hz"
  std::optional<long long> order;
  std::string corner;  ///< "whole" or "each"
  std::string floor;   ///< a drive-off trial, relative to the manifest
};

/// Reads a manifest strictly. Errors: as TomlTable; a contrast that is no pair of two conditions.
[[nodiscard]] Result<Manifest> ReadManifest(const std::string& path);

/// A recording of a study, and what is said of it from outside; the file's own labels count where
/// `labels` has none.
struct TrialFile {
  std::string path;
  std::map<std::string, std::string> labels{};  ///< of subject, condition, repeat
  std::optional<Error> error{};                 ///< its name does not fit the pattern
  /// The drive-off trial that a session states for it; the study's floor where absent.
  std::shared_ptr<const dsp::NoiseFloor> floor{};
  /// Why its session excludes it, or empty where it counts, whatever its header states but for an
  /// exclusion by hand; absent of a file that no session knows.
  std::optional<std::string> excluded{};
  /// A table of results among recordings (FilesInFolder), to be ignored: no trial.
  bool is_table = false;
};

/// Labels in a file's name: "{subject}_{condition}_{repeat}" against the name without its ending,
/// with "/" in the pattern against as many folders above it. A label matches as little as it can,
/// and never a "/". Nothing where the name does not fit.
[[nodiscard]] std::optional<std::map<std::string, std::string>> LabelsOf(
    const std::string& path, const std::string& pattern);

/// Whether `pattern` is one: known names in braces, each once, at least one. Errors
/// (Cause::kUsage).
[[nodiscard]] Result<void> CheckPattern(const std::string& pattern);

/// The recordings of a folder and the tables of results among them (cli::RecordingsIn), with the
/// labels that `pattern` finds in their names. Errors: as cli::RecordingsIn.
[[nodiscard]] Result<std::vector<TrialFile>> FilesInFolder(const std::string& folder,
                                                           const std::string& pattern);

/// The files of a manifest's [[trials]]; without any, those in the manifest's folder. Errors
/// (Cause::kCannotAnswer): a glob that finds nothing, a file in two groups.
[[nodiscard]] Result<std::vector<TrialFile>> FilesOfManifest(const std::string& path,
                                                             const Manifest& manifest);

}  // namespace haptometer::tools
