#pragma once

#include <vector>

#include "base/error.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/reproduce/thesis_row.h"
#include "tools/study/linearity_result.h"
#include "tools/study/matching_result.h"
#include "tools/study/study_result.h"

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

}  // namespace haptometer::tools
