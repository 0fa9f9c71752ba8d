#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/cli/uncertain_number.h"
#include "tools/study/counted.h"
#include "tools/study/interval_text.h"
#include "tools/study/study_result.h"

namespace haptometer::tools {
namespace {

constexpr double kUm = 1e-6;  // in metres
constexpr PrintedUnit kInUm{kUm, "um"};

void Append(std::string& text, std::string_view label, const std::string& content) {
  fmt::format_to(std::back_inserter(text), "    {:<16}{}\n", label, content);
}

std::string TestText(const Contrast& contrast) {
  if (!contrast.difference.test) return "not determined: fewer than 2 subjects, or no spread";
  const dsp::StudentTest& test = *contrast.difference.test;
  return fmt::format("t({:g}) = {:.4g}, p = {:.3g}, after Holm {:.3g}", test.df, test.t, test.p,
                     *contrast.p_holm);
}

void AppendFurther(const Contrast& contrast, std::string& text) {
  if (contrast.effect) Append(text, "d_av", fmt::format("{:.4g}", contrast.effect->d_av));
  Append(text, "ratio's p",
         contrast.ratio && contrast.ratio->log_ratio.test
             ? fmt::format("{:.3g} (paired t of logarithms)", contrast.ratio->log_ratio.test->p)
             : "not determined");
  Append(text, "sign flips",
         contrast.sign_flip_p ? fmt::format("p = {:.3g}, exact over 2^{} choices",
                                            *contrast.sign_flip_p, contrast.difference.n)
                              : "not determined: more than 20 subjects");
  if (contrast.ratio_of_means) {
    Append(text, "ratio of means",
           WithCi(contrast.ratio_of_means->ratio, contrast.ratio_of_means->interval, "unbounded") +
               ", by Fieller");
  }
}

void AppendContrast(const Contrast& contrast, bool all, std::string& text) {
  fmt::format_to(std::back_inserter(text), "  {} against {}, n = {}\n", contrast.planned.treatment,
                 contrast.planned.control, Counted(contrast.difference.n, "subject"));
  if (!contrast.left_out.empty()) {
    Append(
        text, "without",
        fmt::format("subject {}: one of the two is missing", fmt::join(contrast.left_out, ", ")));
  }
  if (contrast.difference.n == 0) return;
  if (contrast.ratio) {
    Append(text, "ratio",
           WithCi(contrast.ratio->ratio, contrast.ratio->interval, "not determined") +
               ", of geometric means");
  }
  Append(text, "paired t", TestText(contrast));
  const auto& test = contrast.difference.test;
  Append(text, "difference",
         WithCi(contrast.difference.mean, test ? std::optional(test->mean) : std::nullopt,
                "not determined", kInUm));
  if (contrast.effect) {
    Append(text, "effect size",
           fmt::format("d_z {:.4g}, Hedges g {}; the interval is of the population's mean "
                       "difference / sd",
                       contrast.effect->d_z,
                       WithCi(contrast.effect->hedges_g, contrast.effect->interval,
                              "interval not determined")));
  }
  if (all) AppendFurther(contrast, text);
}

void AppendConditions(const StudyResult& study, std::string& text) {
  const auto& conditions = study.further.conditions;
  std::size_t width = 9;
  for (const ConditionSummary& condition : conditions) {
    width = std::max(width, condition.name.size());
  }
  fmt::format_to(std::back_inserter(text), "  {:<{}} {:>8} {:>8} {:>10} {:>10} {:>17}\n",
                 "condition", width, "subjects", "trials", "mean / um", "sd / um",
                 "geom. mean / um");
  for (const ConditionSummary& condition : conditions) {
    const auto& sd = condition.subjects.standard_deviation;
    const bool any = condition.subjects.n > 0;
    fmt::format_to(std::back_inserter(text), "  {:<{}} {:>8} {:>8} {:>10} {:>10} {:>17}\n",
                   condition.name, width, condition.subjects.n, condition.trials,
                   any ? fmt::format("{:.4g}", condition.subjects.mean / kUm) : "-",
                   sd ? fmt::format("{:.4g}", *sd / kUm) : "-",
                   any ? fmt::format("{:.4g}", *condition.geometric_m / kUm) : "-");
  }
}

void AppendAnova(const StudyResult& study, std::string& text) {
  if (const auto& anova = study.further.anova) {
    Append(text, "ANOVA",
           fmt::format("repeated measures, {} subjects: F({:g}, {:g}) = {:.4g}, p = {:.3g}; "
                       "Greenhouse-Geisser epsilon {:.3f}, p = {:.3g}; partial eta^2 {:.3f}",
                       study.further.whole_subjects, anova->df_conditions, anova->df_error,
                       anova->f, anova->p, anova->greenhouse_geisser, anova->p_greenhouse_geisser,
                       anova->partial_eta_squared));
  } else {
    Append(text, "ANOVA", "not determined: fewer than 2 subjects have all conditions");
  }
}

void AppendTrend(const StudyResult& study, std::string& text) {
  const auto& trend = study.further.trend;
  if (!trend) return;
  const std::string_view order = trend->by_start ? "UTC start" : "number of the repeat";
  const auto& test = trend->per_trial.test;
  const double percent = 100 * std::expm1(trend->per_trial.mean);
  if (!test) {
    Append(text, "trend",
           fmt::format("{:+.3g} % a trial, by {} (interval not determined)", percent, order));
    return;
  }
  const double lower = 100 * std::expm1(test->mean.lower);
  const double upper = 100 * std::expm1(test->mean.upper);
  Append(
      text, "trend",
      fmt::format("{1:+.{0}g} % a trial, by {2} (95 % CI {3:+.{0}g} to {4:+.{0}g} %, p = {5:.3g})",
                  cli::DigitsOf(lower, upper, 3), percent, order, lower, upper, test->p));
}

void AppendAll(const StudyResult& study, std::string& text) {
  text += "  all conditions\n";
  AppendAnova(study, text);
  for (const ConditionSummary& condition : study.further.conditions) {
    if (condition.morey_m) {
      Append(text, "error bar",
             fmt::format("{} +-{:.4g} um, within subjects (Cousineau, Morey): for differences, no "
                         "interval of the mean",
                         condition.name, *condition.morey_m / kUm));
    }
  }
  for (const ConditionSummary& condition : study.further.conditions) {
    if (!condition.repeats) continue;
    const auto& [lower, upper] = condition.repeats->interval;
    Append(text, "repeats",
           fmt::format("{1}: ICC(1,1) {2:.{0}f} (95 % CI {3:.{0}f} to {4:.{0}f}), variation within "
                       "cells {5:.2g} %",
                       cli::DecimalsOf(lower, upper, 3), condition.name, condition.repeats->icc,
                       lower, upper, 100 * dsp::VariationOfLogs(condition.repeats->within_sd)));
  }
  AppendTrend(study, text);
}

std::string OutlyingText(const Outlying& outlying) {
  return fmt::format(
      "{}subject {} in {}: {:.3g} times what {} lets expect, {:.1f} robust standard "
      "deviations; it counts all the same",
      outlying.file.empty() ? "" : outlying.file + ", ", outlying.subject, outlying.condition,
      outlying.times, outlying.file.empty() ? "subject and condition" : "its cell", outlying.score);
}

void AppendQuality(const StudyResult& study, std::string& text) {
  for (const StudyTrial& trial : study.table.trials) {
    if (!trial.answered && !trial.error) {
      Append(text, "not answered",
             fmt::format("{}: {}", trial.file, fmt::join(trial.reasons, "; ")));
    }
  }
  for (const Deviation& deviation : FindDeviations(study.table)) {
    Append(text, "differs", Describe(deviation));
    if (deviation.what == dsp::kAmplitudeNotVerified) {
      Append(text, "", std::string(dsp::kAveragingRemedy));
    }
  }
  for (const MissingTrials& missing : study.missing) {
    Append(text, "missing",
           fmt::format("subject {} in {}: {} of {}", missing.subject, missing.condition,
                       missing.answered, Counted(missing.expected, "trial")));
  }
  for (const Outlying& outlying : study.outlying) {
    Append(text, "outlying", OutlyingText(outlying));
  }
}

}  // namespace

std::string StudyText(const StudyResult& study, bool all) {
  std::string text = fmt::format("{}: {}, {}, {}; RMS within {:g}-{:g} Hz, one mean a subject\n",
                                 study.source, Counted(study.table.trials.size(), "trial"),
                                 Counted(study.table.subjects.size(), "subject"),
                                 Counted(study.table.conditions.size(), "condition"),
                                 study.question.band.lower_hz, study.question.band.upper_hz);
  if (const auto& floor = study.question.floor) {
    fmt::format_to(std::back_inserter(text),
                   "  noise floor of {:.3g} um RMS ({}) taken off in power\n",
                   std::sqrt(floor->power.mean_square) / kUm, floor->source);
  }
  AppendConditions(study, text);
  if (!study.planned && !study.contrasts.empty()) {
    fmt::format_to(std::back_inserter(text),
                   "  no contrast was planned: every condition against {}, the first in order "
                   "(--contrast TREATMENT:CONTROL names others)\n",
                   study.table.conditions[0]);
  }
  for (const Contrast& contrast : study.contrasts) AppendContrast(contrast, all, text);
  if (all) AppendAll(study, text);
  std::string quality;
  AppendQuality(study, quality);
  if (!quality.empty()) text += "  to know\n" + quality;
  return text;
}

}  // namespace haptometer::tools
