#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "dsp/statistics/moments.h"
#include "dsp/statistics/paired_tests.h"
#include "dsp/statistics/repeated_measures.h"
#include "tools/plot/gnuplot.h"
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
  bool planned = false;  ///< the contrasts were asked for
  std::vector<Contrast> contrasts;
  std::vector<MissingTrials> missing;
  std::vector<Outlying> outlying;
  FurtherStatistics further;
};

/// What people read: conditions, contrasts, what is missing or stands apart; with `all` the rest.
[[nodiscard]] std::string StudyText(const StudyResult& study, bool all);

/// docs/reference/study.md has the schema.
[[nodiscard]] std::string StudyJson(const StudyResult& study);

/// A row a trial, in the order of the files.
[[nodiscard]] std::string LongTable(const StudyResult& study);
/// A row a subject: mean, and number of trials, of each condition.
[[nodiscard]] std::string WideTable(const StudyResult& study);

/// The paragraph for the paper: what was measured, left out, tested and corrected, with every trial
/// that differs from it.
[[nodiscard]] std::string MethodsText(const StudyResult& study);

/// Bars of the conditions' means with standard deviations over subjects, the subjects as points: a
/// panel a contrast.
[[nodiscard]] std::vector<plot::Panel> StudyPanels(const StudyResult& study);

/// What differs between an earlier document and this one, a sentence each: values beyond 1e-9
/// relative, keys that are gone. New keys are no difference. Errors (Cause::kCannotAnswer):
/// `earlier` is no JSON.
[[nodiscard]] Result<std::vector<std::string>> CompareDocuments(const std::string& earlier,
                                                                const std::string& now);

}  // namespace haptometer::tools
