#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "tools/document/document.h"
#include "tools/study/study_table.h"

namespace haptometer::tools {

/// What `haptometer study FOLDER` answers without options. Errors: as cli::RecordingsIn,
/// SessionFolder::Read and CompareConditions.
[[nodiscard]] Result<StudyResult> StudyOfFolder(const std::string& folder);

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
