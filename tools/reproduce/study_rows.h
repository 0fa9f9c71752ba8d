#pragma once

#include <filesystem>
#include <vector>

#include "base/error.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/reproduce/thesis_numbers.h"
#include "tools/study/linearity.h"
#include "tools/study/matching.h"
#include "tools/study/study_table.h"

namespace haptometer::tools {

/// The experiments of chapter 3, run by the study code on data that this program makes; the
/// thesis's own were never published.
struct GeneratedStudy {
  StudyResult trials;         ///< 8 subjects x 4 conditions x 3 trials, Figure 3.3
  MatchingResult matching;    ///< Figure 3.4
  LinearityResult linearity;  ///< Figure 3.5
};

/// Makes and analyses all three. Truths: the controls move as the model has them, the prototypes by
/// the thesis's factors more; matched voltages are equal at 1 V, and lower from 2 V on, so that
/// their mean over the levels is the thesis's. Trials go through files in a temporary folder.
/// Errors: no room there; as the study's parts.
[[nodiscard]] Result<GeneratedStudy> RunGeneratedStudy(const ThesisModel& model);

/// The rows that it answers.
[[nodiscard]] std::vector<ThesisRow> StudyRows(const GeneratedStudy& study);

/// A folder of its own below the system's for temporary files, which goes with all it holds.
class TemporaryFolder {
 public:
  /// Errors (Cause::kFailed): it cannot be made.
  [[nodiscard]] static Result<TemporaryFolder> Make();

  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path);

  std::filesystem::path path_;  // empty: handed on
};

}  // namespace haptometer::tools
