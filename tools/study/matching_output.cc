#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tools/cli/json.h"
#include "tools/cli/uncertain_number.h"
#include "tools/study/matching_result.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::ordered_json;

// 1 - x of an interval's ends: they change places
std::optional<dsp::Interval> Reduction(const std::optional<dsp::Interval>& ratio) {
  if (!ratio) return std::nullopt;
  return dsp::Interval{1 - ratio->upper, 1 - ratio->lower};
}

std::optional<dsp::Interval> PowerSaving(const std::optional<dsp::Interval>& ratio) {
  if (!ratio) return std::nullopt;
  return dsp::Interval{1 - ratio->upper * ratio->upper, 1 - ratio->lower * ratio->lower};
}

// "35.0 % (95 % CI 32.1 to 37.8 %)"
std::string Percent(double value, const std::optional<dsp::Interval>& interval) {
  if (!interval) return fmt::format("{:.1f} % (interval not determined)", 100 * value);
  const double lower = 100 * interval->lower;
  const double upper = 100 * interval->upper;
  return fmt::format("{1:.{0}f} % (95 % CI {2:.{0}f} to {3:.{0}f} %)",
                     cli::DecimalsOf(lower, upper, 1), 100 * value, lower, upper);
}

std::string TestText(const MatchedRatio& ratio) {
  if (!ratio.log_ratio.test) return "not tested";
  const auto& test = *ratio.log_ratio.test;
  std::string text = fmt::format("t({:g}) = {:.4g}, p = {:.3g}", test.df, test.t, test.p);
  if (ratio.p_holm) text += fmt::format(", after Holm {:.3g}", *ratio.p_holm);
  return text;
}

void AppendRatio(const MatchedRatio& ratio, std::string& text) {
  const std::string name =
      ratio.reference_v ? fmt::format("{:g} V", *ratio.reference_v) : "all levels";
  fmt::format_to(std::back_inserter(text), "    {:<14}{} lower, n = {}: {}\n", name,
                 Percent(1 - ratio.ratio(), Reduction(ratio.ratio_interval())), ratio.log_ratio.n,
                 TestText(ratio));
}

void AppendPowerSaving(const MatchedRatio& ratio, std::string& text) {
  const double r = ratio.ratio();
  fmt::format_to(std::back_inserter(text),
                 "    {:<14}{}, 1 - r^2: as power goes with the voltage squared\n", "power saving",
                 Percent(1 - r * r, PowerSaving(ratio.ratio_interval())));
}

void AppendContrast(const MatchedContrast& contrast, std::string& text) {
  fmt::format_to(std::back_inserter(text), "  {} against {}: their matched voltages\n",
                 contrast.planned.treatment, contrast.planned.control);
  if (!contrast.left_out.empty()) {
    fmt::format_to(std::back_inserter(text), "    {:<14}subject {}: no level in both\n", "without",
                   fmt::join(contrast.left_out, ", "));
  }
  if (!contrast.overall) return;
  for (const MatchedRatio& level : contrast.levels) AppendRatio(level, text);
  AppendRatio(*contrast.overall, text);
  AppendPowerSaving(*contrast.overall, text);
}

Json IntervalJson(const std::optional<dsp::Interval>& interval) {
  if (!interval) return nullptr;
  return {interval->lower, interval->upper};
}

Json RatioJson(const MatchedRatio& ratio) {
  const auto& test = ratio.log_ratio.test;
  const auto interval = ratio.ratio_interval();
  return {{"reference_v", cli::NumberOrNull(ratio.reference_v)},
          {"n", ratio.log_ratio.n},
          {"ratio", ratio.ratio()},
          {"ratio_interval", IntervalJson(interval)},
          {"reduction", 1 - ratio.ratio()},
          {"reduction_interval", IntervalJson(Reduction(interval))},
          {"power_saving", 1 - ratio.ratio() * ratio.ratio()},
          {"power_saving_interval", IntervalJson(PowerSaving(interval))},
          {"t", test ? Json(test->t) : Json(nullptr)},
          {"df", test ? Json(test->df) : Json(nullptr)},
          {"p", test ? Json(test->p) : Json(nullptr)},
          {"p_holm", cli::NumberOrNull(ratio.p_holm)}};
}

Json ContrastJson(const MatchedContrast& contrast) {
  Json levels = Json::array();
  for (const MatchedRatio& level : contrast.levels) levels.push_back(RatioJson(level));
  return {{"treatment", contrast.planned.treatment},
          {"control", contrast.planned.control},
          {"left_out_subjects", contrast.left_out},
          {"levels", std::move(levels)},
          {"overall", contrast.overall ? RatioJson(*contrast.overall) : Json(nullptr)}};
}

Json ConditionJson(const MatchedCondition& condition) {
  Json levels = Json::array();
  for (const MatchedLevel& level : condition.levels) {
    Json json = RatioJson(level.ratio);
    json["matched_mean_v"] = level.matched_v.mean;
    json["matched_standard_deviation_v"] = cli::NumberOrNull(level.matched_v.standard_deviation);
    levels.push_back(std::move(json));
  }
  const auto& start = condition.start_log_ratio;
  Json start_json = nullptr;
  if (start) {
    start_json = {{"n", start->n},
                  {"ratio", std::exp(start->mean)},
                  {"p", start->test ? Json(start->test->p) : Json(nullptr)}};
    start_json["ratio_interval"] =
        start->test ? Json{std::exp(start->test->mean.lower), std::exp(start->test->mean.upper)}
                    : Json(nullptr);
  }
  return {{"name", condition.name},
          {"levels", std::move(levels)},
          {"overall", RatioJson(condition.overall)},
          {"started_high_over_low", std::move(start_json)}};
}

}  // namespace

std::string MatchingText(const MatchingResult& result) {
  std::string text =
      fmt::format("{}: {} settings, {} subjects; ratios are geometric means, one value a subject\n",
                  result.source, result.settings, result.subjects.size());
  for (const MatchedCondition& condition : result.conditions) {
    fmt::format_to(std::back_inserter(text), "  {}: matched voltage against the reference\n",
                   condition.name);
    for (const MatchedLevel& level : condition.levels) AppendRatio(level.ratio, text);
    AppendRatio(condition.overall, text);
    AppendPowerSaving(condition.overall, text);
    if (const auto& start = condition.start_log_ratio; start && start->test) {
      const double lower = std::exp(start->test->mean.lower);
      const double upper = std::exp(start->test->mean.upper);
      fmt::format_to(std::back_inserter(text),
                     "    {1:<14}settings that started high are {2:.{0}g} times those that started "
                     "low (95 % CI {3:.{0}g} to {4:.{0}g})\n",
                     cli::DigitsOf(lower, upper, 3), "start", std::exp(start->mean), lower, upper);
    }
  }
  for (const MatchedContrast& contrast : result.contrasts) AppendContrast(contrast, text);
  if (!result.planned && !result.contrasts.empty()) {
    fmt::format_to(std::back_inserter(text),
                   "  no contrast was planned: every condition against {} (--contrast)\n",
                   result.contrasts.front().planned.control);
  }
  for (const std::string& missing : result.missing) {
    fmt::format_to(std::back_inserter(text), "  missing: {}\n", missing);
  }
  return text;
}

std::string MatchingJson(const MatchingResult& result) {
  Json conditions = Json::array();
  for (const MatchedCondition& condition : result.conditions) {
    conditions.push_back(ConditionJson(condition));
  }
  Json contrasts = Json::array();
  for (const MatchedContrast& contrast : result.contrasts) {
    contrasts.push_back(ContrastJson(contrast));
  }
  return cli::JsonText({{"file", result.source},
                        {"unit_of_analysis", "subject"},
                        {"settings", result.settings},
                        {"subjects", result.subjects},
                        {"conditions", std::move(conditions)},
                        {"contrasts_planned", result.planned},
                        {"contrasts", std::move(contrasts)},
                        {"missing", result.missing}});
}

std::vector<plot::Panel> MatchingPanels(const MatchingResult& result) {
  std::vector<plot::Panel> panels;
  panels.reserve(result.conditions.size());
  for (const MatchedCondition& condition : result.conditions) {
    plot::Panel panel;
    const bool is_first = panels.empty();  // the one with a key
    plot::Series points{is_first ? "mean and standard deviation over subjects" : "",
                        plot::Style{.mark = plot::Mark::kErrorBars, .colour = plot::kBlue},
                        {},
                        {},
                        {}};
    for (const MatchedLevel& level : condition.levels) {
      const double reference_v = *level.ratio.reference_v;
      points.x.push_back(reference_v);
      panel.ticks.push_back({reference_v, fmt::format("{:g}", reference_v)});
      points.y.push_back(level.matched_v.mean);
      points.y_error.push_back(level.matched_v.standard_deviation.value_or(0));
    }
    panel.title = condition.name;
    panel.x_label = "reference / V";
    panel.y_label = "matched / V";
    panel.y_from_zero = true;
    panel.series.push_back(
        {is_first ? "equal" : "", plot::Lines(plot::kGrey, 1, 2), points.x, points.x, {}});
    panel.series.push_back(std::move(points));
    panels.push_back(std::move(panel));
  }
  return panels;
}

}  // namespace haptometer::tools
