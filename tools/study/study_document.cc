#include "tools/study/study_document.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tools/cli/csv_cell.h"
#include "tools/cli/json.h"
#include "tools/cli/uncertain_number.h"
#include "tools/document/findings_dsp.h"
#include "tools/study/study_result.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::ordered_json;

Json IntervalJson(const std::optional<dsp::Interval>& interval) {
  if (!interval) return nullptr;
  return {cli::NumberOrNull(interval->lower), cli::NumberOrNull(interval->upper)};
}

// t, df, p and interval of a test under `prefix`
void FillTest(const dsp::OneSample& sample, Json& json) {
  const auto& test = sample.test;
  json["t"] = test ? Json(test->t) : Json(nullptr);
  json["df"] = test ? Json(test->df) : Json(nullptr);
  json["p"] = test ? Json(test->p) : Json(nullptr);
}

std::optional<dsp::Interval> IntervalOf(const dsp::OneSample& sample) {
  return sample.test ? std::optional(sample.test->mean) : std::nullopt;
}

Json ContrastJson(const Contrast& contrast) {
  Json json{{"treatment", contrast.planned.treatment},
            {"control", contrast.planned.control},
            {"n", contrast.difference.n},
            {"left_out_subjects", contrast.left_out}};
  const auto& ratio = contrast.ratio;
  json["ratio"] = ratio ? Json(ratio->ratio) : Json(nullptr);
  json["ratio_interval"] = IntervalJson(ratio ? ratio->interval : std::nullopt);
  json["ratio_p"] = ratio && ratio->log_ratio.test ? Json(ratio->log_ratio.test->p) : Json(nullptr);
  FillTest(contrast.difference, json);
  json["p_holm"] = cli::NumberOrNull(contrast.p_holm);
  json["mean_difference_m"] =
      contrast.difference.n > 0 ? Json(contrast.difference.mean) : Json(nullptr);
  json["mean_difference_interval_m"] = IntervalJson(IntervalOf(contrast.difference));
  const auto& effect = contrast.effect;
  json["d_z"] = effect ? Json(effect->d_z) : Json(nullptr);
  json["hedges_g"] = effect ? Json(effect->hedges_g) : Json(nullptr);
  json["effect_interval"] = IntervalJson(effect ? effect->interval : std::nullopt);
  json["d_av"] = effect ? Json(effect->d_av) : Json(nullptr);
  json["sign_flip_p"] = cli::NumberOrNull(contrast.sign_flip_p);
  const auto& means = contrast.ratio_of_means;
  json["ratio_of_means"] = means ? Json(means->ratio) : Json(nullptr);
  json["ratio_of_means_interval"] = IntervalJson(means ? means->interval : std::nullopt);
  json["ratio_of_means_unbounded"] = means ? Json(!means->interval) : Json(nullptr);
  return json;
}

Json ConditionJson(const ConditionSummary& condition) {
  const bool any = condition.subjects.n > 0;
  Json json{{"name", condition.name},
            {"subjects", condition.subjects.n},
            {"trials", condition.trials},
            {"mean_m", any ? Json(condition.subjects.mean) : Json(nullptr)},
            {"standard_deviation_m", cli::NumberOrNull(condition.subjects.standard_deviation)},
            {"mean_interval_m", IntervalJson(IntervalOf(condition.subjects))},
            {"geometric_mean_m", cli::NumberOrNull(condition.geometric_m)},
            {"morey_half_width_m", cli::NumberOrNull(condition.morey_m)}};
  const auto& repeats = condition.repeats;
  json["icc"] = repeats ? Json(repeats->icc) : Json(nullptr);
  json["icc_interval"] = repeats ? IntervalJson(repeats->interval) : Json(nullptr);
  json["within_cell_variation"] =
      repeats ? Json(dsp::VariationOfLogs(repeats->within_sd)) : Json(nullptr);
  return json;
}

Json AnovaJson(const std::optional<dsp::RepeatedMeasuresAnova>& anova, std::size_t subjects) {
  if (!anova) return nullptr;
  return {{"subjects", subjects},
          {"f", anova->f},
          {"df_conditions", anova->df_conditions},
          {"df_error", anova->df_error},
          {"p", anova->p},
          {"greenhouse_geisser_epsilon", anova->greenhouse_geisser},
          {"p_greenhouse_geisser", anova->p_greenhouse_geisser},
          {"partial_eta_squared", anova->partial_eta_squared}};
}

Json TrendJson(const std::optional<OrderTrend>& trend) {
  if (!trend) return nullptr;
  Json json{{"order", trend->by_start ? "utc_start" : "repeat"},
            {"subjects", trend->per_trial.n},
            {"log_slope_per_trial", trend->per_trial.mean},
            {"log_slope_interval", IntervalJson(IntervalOf(trend->per_trial))}};
  FillTest(trend->per_trial, json);
  return json;
}

Json TrialJson(const StudyTrial& trial) {
  return {{"file", trial.file},
          {"subject", cli::TextOrNull(trial.subject)},
          {"condition", cli::TextOrNull(trial.condition)},
          {"repeat", cli::TextOrNull(trial.repeat)},
          {"answered", trial.answered},
          {"reasons", trial.reasons},
          {"deviations", trial.deviations},
          {"band_rms_m", cli::NumberOrNull(trial.rms_m)},
          {"band_rms_standard_uncertainty_m", cli::NumberOrNull(trial.rms_uncertainty_m)}};
}

Json OutlyingJson(const Outlying& outlying) {
  return {{"subject", outlying.subject},
          {"condition", outlying.condition},
          {"file", cli::TextOrNull(outlying.file)},
          {"times", outlying.times},
          {"robust_standard_deviations", outlying.score}};
}

Json MissingJson(const MissingTrials& missing) {
  return {{"subject", missing.subject},
          {"condition", missing.condition},
          {"answered", missing.answered},
          {"expected", missing.expected}};
}

Json FloorJson(const std::optional<dsp::NoiseFloor>& floor) {
  if (!floor) return nullptr;
  return {{"file", floor->source},
          {"rms_m", std::sqrt(floor->power.mean_square)},
          {"duration_s", floor->duration_s}};
}

template <typename List, typename ToJson>
Json ListJson(const List& list, const ToJson& to_json) {
  Json json = Json::array();
  for (const auto& element : list) json.push_back(to_json(element));
  return json;
}

}  // namespace

std::string StudyJson(const StudyResult& study) {
  const dsp::BandPass& band = study.question.band;
  Json json{{"study", study.source},
            {"band",
             {{"lower_hz", band.lower_hz},
              {"upper_hz", band.upper_hz},
              {"order", band.order},
              {"corner", band.corners == dsp::Corners::kWhole ? "whole" : "each"}}},
            {"floor", FloorJson(study.question.floor)},
            {"unit_of_analysis", "subject"},
            {"subjects", study.table.subjects}};
  json["conditions"] = ListJson(study.further.conditions, ConditionJson);
  json["contrasts_planned"] = study.planned;
  json["contrasts"] = ListJson(study.contrasts, ContrastJson);
  json["anova"] = AnovaJson(study.further.anova, study.further.whole_subjects);
  json["anova_of_logarithms"] = AnovaJson(study.further.log_anova, study.further.whole_subjects);
  json["trend"] = TrendJson(study.further.trend);
  json["missing"] = ListJson(study.missing, MissingJson);
  json["outlying"] = ListJson(study.outlying, OutlyingJson);
  json["trials"] = ListJson(study.table.trials, TrialJson);
  return cli::JsonText(json);
}

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
    if (deviation.what == document::kAmplitudeNotVerified) {
      Append(text, "", std::string(document::kAveragingRemedy));
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

namespace {

std::string NumberCell(const std::optional<double>& number) {
  return number ? fmt::format("{:.17g}", *number) : std::string();
}

bool IsOutlying(const StudyResult& study, const StudyTrial& trial) {
  for (const Outlying& outlying : study.outlying) {
    if (outlying.file == trial.file) return true;
  }
  return false;
}

}  // namespace

std::string LongTable(const StudyResult& study) {
  std::string text =
      "subject,condition,repeat,band_rms_m,band_rms_standard_uncertainty_m,answered,outlying,"
      "remarks,file\n";
  for (const StudyTrial& trial : study.table.trials) {
    std::vector<std::string> remarks = trial.reasons;
    remarks.insert(remarks.end(), trial.deviations.begin(), trial.deviations.end());
    fmt::format_to(
        std::back_inserter(text), "{},{},{},{},{},{:d},{:d},{},{}\n", cli::CellOf(trial.subject),
        cli::CellOf(trial.condition), cli::CellOf(trial.repeat), NumberCell(trial.rms_m),
        NumberCell(trial.rms_uncertainty_m), trial.answered, IsOutlying(study, trial),
        cli::CellOf(fmt::format("{}", fmt::join(remarks, "; "))), cli::CellOf(trial.file));
  }
  return text;
}

std::string WideTable(const StudyResult& study) {
  std::string text = "subject";
  for (const std::string& condition : study.table.conditions) {
    fmt::format_to(std::back_inserter(text), ",{},{}", cli::CellOf(condition + "_mean_m"),
                   cli::CellOf(condition + "_trials"));
  }
  text += '\n';
  for (std::size_t s = 0; s < study.table.subjects.size(); ++s) {
    text += cli::CellOf(study.table.subjects[s]);
    for (const Cell& cell : study.table.cells[s]) {
      fmt::format_to(std::back_inserter(text), ",{},{}", NumberCell(cell.mean_m()),
                     cell.trials.size());
    }
    text += '\n';
  }
  return text;
}

namespace {

void AppendContrasts(const StudyResult& study, std::string& text) {
  std::vector<std::string> names;
  names.reserve(study.contrasts.size());
  for (const Contrast& contrast : study.contrasts) {
    names.push_back(
        fmt::format("{} against {}", contrast.planned.treatment, contrast.planned.control));
  }
  fmt::format_to(
      std::back_inserter(text),
      "{} ({}) {} tested with two-sided paired t tests of the subjects' means, with exact p values "
      "corrected by Holm's method over {} test{}. Mean differences are given with 95 % confidence "
      "intervals; ratios are geometric means over subjects of the ratios of the subjects' "
      "geometric "
      "means, with intervals from the paired t on logarithms; effect sizes are d_z and Hedges' g "
      "(exact correction) with intervals of the population's effect from the noncentral t "
      "distribution.",
      study.planned ? "Planned contrasts" : "All conditions against the first, unplanned",
      fmt::join(names, "; "), names.size() == 1 ? "was" : "were", names.size(),
      names.size() == 1 ? "" : "s");
}

// what was taken off as noise
std::string FloorText(const std::optional<dsp::NoiseFloor>& floor) {
  if (!floor) {
    return "The noise of the trial's own quiet part was subtracted in power where it had one";
  }
  return fmt::format(
      "The noise of a drive-off trial ({:.3g} um RMS in the band over {:.3g} s, {}) was subtracted "
      "in power",
      std::sqrt(floor->power.mean_square) * 1e6, floor->duration_s, floor->source);
}

void AppendExceptions(const StudyResult& study, std::string& text) {
  std::string list;
  for (const StudyTrial& trial : study.table.trials) {
    if (!trial.answered) {
      fmt::format_to(std::back_inserter(list), "- {}: no value ({})\n", trial.file,
                     fmt::join(trial.reasons, "; "));
    }
  }
  for (const Deviation& deviation : FindDeviations(study.table)) {
    fmt::format_to(std::back_inserter(list), "- {}\n", Describe(deviation));
  }
  for (const MissingTrials& missing : study.missing) {
    fmt::format_to(std::back_inserter(list), "- subject {} in {}: {} of {}\n", missing.subject,
                   missing.condition, missing.answered, Counted(missing.expected, "trial"));
  }
  for (const Outlying& outlying : study.outlying) {
    fmt::format_to(std::back_inserter(list),
                   "- {}, subject {} in {}: outlying ({:.3g} times, {:.1f} robust standard "
                   "deviations), kept\n",
                   outlying.file.empty() ? "all its trials" : outlying.file, outlying.subject,
                   outlying.condition, outlying.times, outlying.score);
  }
  text += list.empty() ? "\nNo trial differs from this.\n"
                       : "\nTrials that differ from this:\n\n" + list;
}

}  // namespace

std::string MethodsText(const StudyResult& study) {
  const dsp::BandPass& band = study.question.band;
  const auto answered = std::ranges::count_if(study.table.trials, &StudyTrial::answered);
  std::string text = "## Methods\n\n";
  fmt::format_to(
      std::back_inserter(text),
      "Displacement was band-passed from {:g} to {:g} Hz with a Butterworth filter of order {} "
      "applied forward and backward (zero phase; -3 dB at the corners of {}){}. Motion below the "
      "band was modelled and taken out first where too little would have settled otherwise. The "
      "root-mean-square (RMS) was taken over the longest steady part of the drive that had settled "
      "(all that had settled where no drive stood out), shortened to whole periods of its "
      "strongest tone. {}, and the sensor's gain at the tone was divided out where its averaging "
      "was on record; {} are in no stated uncertainty. "
      "{} of {} of {} in {} ({}) gave a value. The unit of analysis was the subject: {}. ",
      band.lower_hz, band.upper_hz, band.order,
      band.corners == dsp::Corners::kWhole ? "both passes together" : "each pass",
      study.question.may_lower_order ? ", its order lowered where a trial was too short for it"
                                     : "",
      FloorText(study.question.floor), dsp::kNotInBudget, answered,
      Counted(study.table.trials.size(), "trial"), Counted(study.table.subjects.size(), "subject"),
      Counted(study.table.conditions.size(), "condition"), fmt::join(study.table.conditions, ", "),
      study.table.repeats > 1
          ? fmt::format("up to {} trials of a subject in a condition were averaged first",
                        study.table.repeats)
          : "each subject gave one trial in a condition");
  if (!study.contrasts.empty()) AppendContrasts(study, text);
  fmt::format_to(
      std::back_inserter(text),
      " Trials farther than {:g} robust standard deviations from their cell, and cells as far from "
      "what subject and condition let expect, were named but not removed (a standard deviation "
      "counted for no less than {:g} % and no less than the stated uncertainty). Computed with "
      "haptometer study.\n",
      kOutlyingScore, 100 * kLeastScatter);
  AppendExceptions(study, text);
  return text;
}

namespace {

// the means as bars, their standard deviations over subjects, and each subject as a point
void AppendCondition(const StudyResult& study, std::size_t condition, double x,
                     plot::Panel& panel) {
  const ConditionSummary& summary = study.further.conditions[condition];
  panel.ticks.push_back({x, summary.name});
  if (summary.subjects.n == 0) return;
  const double mean_um = summary.subjects.mean / kUm;
  panel.series.push_back(
      {"", plot::Style{.mark = plot::Mark::kBoxes, .colour = plot::kBlue}, {x}, {mean_um}, {}});
  if (const auto& sd = summary.subjects.standard_deviation) {
    panel.series.push_back({"",
                            plot::Style{plot::Mark::kErrorBars, plot::kBlack, 1.5, 1, 0.7},
                            {x},
                            {mean_um},
                            {*sd / kUm}});
  }
  plot::Series points{"", plot::Points(plot::kOrange, 0.5), {}, {}, {}};
  const auto& cells = study.table.cells;
  for (std::size_t s = 0; s < cells.size(); ++s) {
    const auto mean_m = cells[s][condition].mean_m();
    if (!mean_m) continue;
    // beside each other, in the order of the subjects
    const double share = (static_cast<double>(s) + 0.5) / static_cast<double>(cells.size());
    points.x.push_back(x + 0.3 * (share - 0.5));
    points.y.push_back(*mean_m / kUm);
  }
  panel.series.push_back(std::move(points));
}

plot::Panel EmptyPanel(std::string title) {
  plot::Panel panel;
  panel.title = std::move(title);
  panel.y_label = "RMS displacement / um";
  panel.y_from_zero = true;
  return panel;
}

}  // namespace

std::vector<plot::Panel> StudyPanels(const StudyResult& study) {
  constexpr std::string_view kWhat = "mean and standard deviation over subjects; points: subjects";
  std::vector<plot::Panel> panels;
  for (const Contrast& contrast : study.contrasts) {
    panels.push_back(EmptyPanel(fmt::format("{} against {}: {}", contrast.planned.treatment,
                                            contrast.planned.control, kWhat)));
    double x = 0;
    for (const auto& name : {contrast.planned.control, contrast.planned.treatment}) {
      AppendCondition(study, *study.table.Condition(name), x++, panels.back());
    }
  }
  if (!panels.empty()) return panels;
  panels.push_back(EmptyPanel(std::string(kWhat)));
  for (std::size_t c = 0; c < study.table.conditions.size(); ++c) {
    AppendCondition(study, c, static_cast<double>(c), panels.back());
  }
  return panels;
}

namespace {

constexpr int kDigits = 4;  // at least

}  // namespace

std::string WithCi(double value, const std::optional<dsp::Interval>& interval,
                   std::string_view otherwise, const PrintedUnit& unit) {
  const std::string name = unit.name.empty() ? "" : fmt::format(" {}", unit.name);
  if (!interval) return fmt::format("{:.{}g}{} ({})", value / unit.size, kDigits, name, otherwise);
  const double lower = interval->lower / unit.size;
  const double upper = interval->upper / unit.size;
  return fmt::format("{1:.{0}g}{2} (95 % CI {3:.{0}g} to {4:.{0}g})",
                     cli::DigitsOf(lower, upper, kDigits), value / unit.size, name, lower, upper);
}

}  // namespace haptometer::tools
