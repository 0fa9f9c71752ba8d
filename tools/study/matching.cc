#include "tools/study/matching.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "base/text.h"
#include "dsp/statistics/moments.h"
#include "dsp/statistics/paired_tests.h"
#include "tools/cli/json.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/cli/uncertain_number.h"
#include "tools/study/text_table.h"

// study matching FILE.csv: voltages set until two vibrations felt alike.

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "study matching";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary =
        "How much lower a matched voltage is than its reference, level by level, and what "
        "power that saves.",
    .examples = {"haptometer study matching fixtures/matching.csv --contrast ia1:stock",
                 "haptometer study matching settings.csv --plot matching.svg",
                 "haptometer study matching settings.csv --json"}};

// 3 where a condition or contrast cannot be tested at all
int StatusOf(const MatchingResult& result) {
  for (const MatchedCondition& condition : result.conditions) {
    if (!condition.overall.log_ratio.test) return ExitStatus(Cause::kCannotAnswer);
  }
  for (const MatchedContrast& contrast : result.contrasts) {
    if (!contrast.overall || !contrast.overall->log_ratio.test) {
      return ExitStatus(Cause::kCannotAnswer);
    }
  }
  return 0;
}

}  // namespace

int RunStudyMatching(int argc, const char* const* argv) {
  cli::Options options(kText);
  std::string file;
  std::string plot;
  std::vector<std::string> words;
  options.Positional("file", &file, "CSV with reference_v,condition,subject,matched_v,started");
  options.Repeated("--contrast", &words, "TREATMENT:CONTROL",
                   "A planned contrast; may be repeated (default: every condition against the "
                   "first)");
  options.Output("--plot", &plot, "FILE.svg|png|pdf", "Draw matched against reference voltage");
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (!plot.empty()) {
    if (auto drawable = plot::CheckPlotPath(plot); !drawable) {
      return cli::ReportError(kVerb, drawable.error());
    }
  }
  const auto contrasts = ParseContrasts(words);
  if (!contrasts) return cli::ReportError(kVerb, contrasts.error());
  const auto table =
      ReadTextTable(file, {"reference_v", "condition", "subject", "matched_v", "started"});
  if (!table) return cli::ReportError(kVerb, table.error());
  const auto result = AnalyzeMatching(*table, *contrasts);
  if (!result) return cli::ReportError(kVerb, result.error());
  cli::Print(options.json() ? MatchingJson(*result) : MatchingText(*result));
  if (!plot.empty()) {
    if (auto drawn = plot::DrawPanels(plot, MatchingPanels(*result)); !drawn) {
      return cli::ReportError(kVerb, drawn.error());
    }
  }
  return StatusOf(*result);
}

namespace {

// ln(matched / reference) of the settings of one subject at one level
struct Halves {
  std::vector<double> high;
  std::vector<double> low;

  [[nodiscard]] bool is_whole() const { return !high.empty() && !low.empty(); }
  // each start counts alike, however often it was asked
  [[nodiscard]] double mean() const {
    if (high.empty()) return dsp::Mean(low);
    if (low.empty()) return dsp::Mean(high);
    return (dsp::Mean(high) + dsp::Mean(low)) / 2;
  }
};

using Levels = std::map<double, std::map<std::string, Halves>>;  // level, subject

struct Settings {
  std::vector<std::string> conditions;  // in the order of the file
  std::vector<std::string> subjects;    // in the order of the file
  std::map<std::string, Levels> of;     // by condition
};

void AppendOnce(std::vector<std::string>& names, const std::string& name) {
  if (std::ranges::find(names, name) == names.end()) names.push_back(name);
}

Result<Settings> Sort(const TextTable& table) {
  const auto reference = NumbersOf(table, "reference_v");
  if (!reference) return std::unexpected(reference.error());
  const auto matched = NumbersOf(table, "matched_v");
  if (!matched) return std::unexpected(matched.error());
  Settings settings;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const std::string where = fmt::format("{}:{}", table.name, table.lines[i]);
    if (!((*reference)[i] > 0) || !((*matched)[i] > 0)) {
      return CannotAnswer(where, "has a voltage that is not above 0", "mend that line");
    }
    const std::string& started = table.columns.at("started")[i];
    if (started != "high" && started != "low") {
      return CannotAnswer(where, fmt::format("started '{}'", started), "write high or low");
    }
    const std::string& condition = table.columns.at("condition")[i];
    const std::string& subject = table.columns.at("subject")[i];
    if (condition.empty() || subject.empty()) {
      return CannotAnswer(where, "has no condition or subject", "mend that line");
    }
    AppendOnce(settings.conditions, condition);
    AppendOnce(settings.subjects, subject);
    Halves& halves = settings.of[condition][(*reference)[i]][subject];
    (started == "high" ? halves.high : halves.low)
        .push_back(std::log((*matched)[i] / (*reference)[i]));
  }
  return settings;
}

// one logarithm of a ratio by level and subject
using LogRatios = std::map<double, std::map<std::string, double>>;

LogRatios LogRatiosOf(const Levels& levels) {
  LogRatios logs;
  for (const auto& [level, subjects] : levels) {
    for (const auto& [subject, halves] : subjects) logs[level][subject] = halves.mean();
  }
  return logs;
}

// where both have a setting
LogRatios Differences(const LogRatios& treatment, const LogRatios& control) {
  LogRatios differences;
  for (const auto& [level, subjects] : treatment) {
    const auto other = control.find(level);
    if (other == control.end()) continue;
    for (const auto& [subject, log] : subjects) {
      const auto found = other->second.find(subject);
      if (found != other->second.end()) differences[level][subject] = log - found->second;
    }
  }
  return differences;
}

std::vector<double> ValuesOf(const std::map<std::string, double>& subjects) {
  std::vector<double> values;
  values.reserve(subjects.size());
  for (const auto& [subject, value] : subjects) values.push_back(value);
  return values;
}

MatchedRatio LevelOf(double reference_v, const std::map<std::string, double>& subjects) {
  return {reference_v, dsp::TestMean(ValuesOf(subjects))};
}

dsp::OneSample MatchedVoltage(double reference_v, const std::map<std::string, double>& subjects) {
  std::vector<double> volts = ValuesOf(subjects);
  for (double& value : volts) value = reference_v * std::exp(value);
  return dsp::TestMean(volts);
}

using BySubject = std::map<std::string, std::vector<double>>;

// one mean a subject
dsp::OneSample TestSubjectMeans(const BySubject& by_subject) {
  std::vector<double> means;
  means.reserve(by_subject.size());
  for (const auto& [subject, logs] : by_subject) means.push_back(dsp::Mean(logs));
  return dsp::TestMean(means);
}

BySubject BySubjectOf(const LogRatios& logs) {
  BySubject by_subject;
  for (const auto& [level, subjects] : logs) {
    for (const auto& [subject, log] : subjects) by_subject[subject].push_back(log);
  }
  return by_subject;
}

// over subjects, the mean of ln(high / low) of the levels that have both starts
std::optional<dsp::OneSample> StartOf(const Levels& levels) {
  BySubject by_subject;
  for (const auto& [level, subjects] : levels) {
    for (const auto& [subject, halves] : subjects) {
      if (!halves.is_whole()) continue;
      by_subject[subject].push_back(dsp::Mean(halves.high) - dsp::Mean(halves.low));
    }
  }
  if (by_subject.empty()) return std::nullopt;
  return TestSubjectMeans(by_subject);
}

void CorrectByHolm(const std::vector<MatchedRatio*>& ratios) {
  std::vector<std::optional<double>> p(ratios.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (const auto& test = ratios[i]->log_ratio.test) p[i] = test->p;
  }
  const auto adjusted = dsp::HolmOverTested(p);
  for (std::size_t i = 0; i < p.size(); ++i) ratios[i]->p_holm = adjusted[i];
}

MatchedCondition ConditionOf(const std::string& name, const Levels& levels) {
  MatchedCondition condition;
  condition.name = name;
  const LogRatios logs = LogRatiosOf(levels);
  condition.levels.reserve(logs.size());
  std::vector<MatchedRatio*> ratios;
  ratios.reserve(logs.size());
  for (const auto& [level, subjects] : logs) {
    condition.levels.push_back({LevelOf(level, subjects), MatchedVoltage(level, subjects)});
    ratios.push_back(&condition.levels.back().ratio);
  }
  CorrectByHolm(ratios);
  // each subject's mean over the levels it has
  condition.overall = {{}, TestSubjectMeans(BySubjectOf(logs))};
  condition.start_log_ratio = StartOf(levels);
  return condition;
}

MatchedContrast ContrastOf(const PlannedContrast& planned, const Settings& settings) {
  MatchedContrast contrast;
  contrast.planned = planned;
  const LogRatios logs = Differences(LogRatiosOf(settings.of.at(planned.treatment)),
                                     LogRatiosOf(settings.of.at(planned.control)));
  contrast.levels.reserve(logs.size());
  std::vector<MatchedRatio*> ratios;
  ratios.reserve(logs.size());
  for (const auto& [level, subjects] : logs) {
    contrast.levels.push_back(LevelOf(level, subjects));
    ratios.push_back(&contrast.levels.back());
  }
  CorrectByHolm(ratios);
  const BySubject by_subject = BySubjectOf(logs);
  if (!by_subject.empty()) contrast.overall = {{}, TestSubjectMeans(by_subject)};
  for (const std::string& subject : settings.subjects) {
    if (!by_subject.contains(subject)) contrast.left_out.push_back(subject);
  }
  return contrast;
}

// with Holm's correction over those that can be tested
Result<std::vector<MatchedContrast>> ContrastsOf(const std::vector<PlannedContrast>& planned,
                                                 const Settings& settings) {
  std::vector<MatchedContrast> contrasts;
  contrasts.reserve(planned.size());
  std::vector<MatchedRatio*> ratios;
  ratios.reserve(planned.size());
  for (const PlannedContrast& pair : planned) {
    if (auto known = CheckConditions(pair, settings.conditions); !known) {
      return std::unexpected(known.error());
    }
    contrasts.push_back(ContrastOf(pair, settings));
    if (auto& overall = contrasts.back().overall) ratios.push_back(&*overall);
  }
  CorrectByHolm(ratios);
  return contrasts;
}

void NameMissing(const Settings& settings, const std::string& condition,
                 std::vector<std::string>& missing) {
  for (const auto& [level, subjects] : settings.of.at(condition)) {
    for (const std::string& subject : settings.subjects) {
      const auto found = subjects.find(subject);
      const auto name = [&](std::string_view what) {
        missing.push_back(
            fmt::format("subject {}, {} at {:g} V: {}", subject, condition, level, what));
      };
      if (found == subjects.end()) {
        name("no setting");
      } else if (!found->second.is_whole()) {
        name(found->second.high.empty() ? "none started high; the other counts by itself"
                                        : "none started low; the other counts by itself");
      }
    }
  }
}

}  // namespace

double MatchedRatio::ratio() const { return std::exp(log_ratio.mean); }

std::optional<dsp::Interval> MatchedRatio::ratio_interval() const {
  if (!log_ratio.test) return std::nullopt;
  return dsp::Interval{std::exp(log_ratio.test->mean.lower), std::exp(log_ratio.test->mean.upper)};
}

Result<MatchingResult> AnalyzeMatching(const TextTable& table,
                                       const std::vector<PlannedContrast>& planned) {
  auto settings = Sort(table);
  if (!settings) return std::unexpected(settings.error());
  MatchingResult result;
  result.source = Printable(table.name);
  result.settings = table.rows();
  result.conditions.reserve(settings->conditions.size());
  for (const std::string& name : settings->conditions) {
    result.conditions.push_back(ConditionOf(name, settings->of.at(name)));
    NameMissing(*settings, name, result.missing);
  }
  result.planned = !planned.empty();
  auto contrasts =
      ContrastsOf(result.planned ? planned : AllAgainstTheFirst(settings->conditions), *settings);
  if (!contrasts) return std::unexpected(contrasts.error());
  result.contrasts = *std::move(contrasts);
  result.subjects = std::move(settings->subjects);
  return result;
}

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
