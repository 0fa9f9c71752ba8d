#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dsp/statistics/moments.h"
#include "dsp/statistics/repeated_measures.h"
#include "tools/study/study_table.h"

namespace haptometer::tools {

/// One condition by itself.
struct ConditionSummary {
  std::string name;
  std::size_t trials = 0;                   ///< answered
  dsp::OneSample subjects;                  ///< of the subjects' means, in m; n = 0: none
  std::optional<double> geometric_m;        ///< exp of the mean over subjects of their mean log
  std::optional<double> morey_m;            ///< half the within-subject error bar
  std::optional<dsp::Reliability> repeats;  ///< of ln(RMS)
};

/// How the RMS changes from a subject's first trial to its last.
struct OrderTrend {
  bool by_start = false;     ///< by the recordings' UTC start; else by the number of the repeat
  dsp::OneSample per_trial;  ///< over subjects: slope of ln(RMS) about its cell's mean, per trial
};

/// What --all adds.
struct FurtherStatistics {
  std::vector<ConditionSummary> conditions;
  std::size_t whole_subjects = 0;  ///< that have all conditions: what anova and Morey bars use
  std::optional<dsp::RepeatedMeasuresAnova> anova;      ///< of the subjects' means
  std::optional<dsp::RepeatedMeasuresAnova> log_anova;  ///< of the subjects' mean logarithms
  std::optional<OrderTrend> trend;
};

[[nodiscard]] FurtherStatistics DescribeFurther(const StudyTable& table);

}  // namespace haptometer::tools
