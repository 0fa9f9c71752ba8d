#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/document/document.h"
#include "tools/results/trial_results.h"
#include "tools/study/study_table.h"

namespace haptometer::tools {

/// The trials of a study as they are asked for on a command line.
struct StudyWords {
  std::string source{};  ///< a folder or a manifest
  std::vector<std::string> contrasts{};
  std::string pattern{};
  cli::BandWords band{};
  std::string floor{};
  cli::ImportWords import{};
  std::optional<ResultsWords> results{};  ///< of a verb that keeps results
  std::optional<std::int64_t> threads{};
};
/// Declares the options of those words, but for source, contrasts and results.
void DeclareStudy(cli::Options& options, StudyWords& words);

/// What `haptometer study` answers; `check` is called before any trial is analysed, with the scene
/// that the session's source plays (empty: none). Errors: as cli::RecordingsIn, SessionFolder::Read
/// and CompareConditions; those of the words and of `check`.
[[nodiscard]] Result<StudyResult> AnswerStudy(
    const StudyWords& words,
    const std::function<Result<void>(const std::string& scene)>& check = nullptr);

/// The verb `study compare`; argv[1] is its second word.
int RunStudyCompare(int argc, const char* const* argv);

/// Results of a study against earlier ones.
struct ResultsComparison {
  std::size_t equal = 0;                   ///< numbers, names and lists of numbers
  std::vector<std::string> differences{};  ///< a sentence each
};

/// Compares what `study --json` printed, `earlier`, with a document of now. Equal are texts that
/// are the same and numbers within 1e-9 of the larger; findings and provenance are not compared,
/// and keys of earlier versions are known. Errors (Cause::kCannotAnswer), naming `where`: it is no
/// JSON object.
[[nodiscard]] Result<ResultsComparison> CompareResults(std::string_view earlier,
                                                       const std::string& where,
                                                       const document::Document& now);

}  // namespace haptometer::tools
