#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/cli/json.h"
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

}  // namespace haptometer::tools
