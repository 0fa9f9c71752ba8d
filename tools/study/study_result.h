#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "dsp/statistics/moments.h"
#include "dsp/statistics/paired_tests.h"
#include "dsp/statistics/repeated_measures.h"
#include "tools/study/manifest.h"
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

/// Everything that a study answers.
struct StudyResult {
  std::string source;  ///< folder or manifest
  dsp::BandQuestion question;
  StudyTable table;
  std::vector<std::string> ignored;  ///< tables of results that lie among the trials
  bool planned = false;              ///< the contrasts were asked for
  std::vector<Contrast> contrasts;
  std::vector<MissingTrials> missing;
  std::vector<Outlying> outlying;
  FurtherStatistics further;

  /// Works out all that follows from the table; without a planned contrast every condition is
  /// compared with the first. Errors: as CompareConditions.
  [[nodiscard]] Result<void> Compare(const std::vector<PlannedContrast>& wanted);

  /// How many answered trials `is_so` holds of.
  template <typename Predicate>
  [[nodiscard]] std::size_t CountAnswered(const Predicate& is_so) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        table.trials,
        [&](const StudyTrial& trial) { return trial.answered && std::invoke(is_so, trial); }));
  }
};

}  // namespace haptometer::tools
