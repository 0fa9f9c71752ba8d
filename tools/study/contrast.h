#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dsp/statistics/moments.h"
#include "dsp/statistics/paired_tests.h"
#include "tools/study/planned_contrast.h"
#include "tools/study/study_table.h"

namespace haptometer::tools {

/// One condition against another, subject by subject.
struct Contrast {
  PlannedContrast planned;
  std::vector<std::string> left_out;  ///< subjects that lack one of the two
  dsp::OneSample difference;          ///< of the subjects' means, in m; n = 0: nobody has both
  std::optional<double> p_holm;       ///< of difference.test->p, over all contrasts
  std::optional<dsp::GeometricRatio> ratio;  ///< of the subjects' geometric means
  std::optional<dsp::EffectSize> effect;
  std::optional<double> sign_flip_p;
  std::optional<dsp::RatioOfMeans> ratio_of_means;
};

/// The contrasts, in their order, with Holm's correction over those that can be tested.
/// Errors (Cause::kUsage): a condition that no trial has, with the nearest.
[[nodiscard]] Result<std::vector<Contrast>> CompareConditions(
    const StudyTable& table, const std::vector<PlannedContrast>& planned);

}  // namespace haptometer::tools
