#include "tools/study/matching.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "base/mapped.h"
#include "base/text.h"
#include "dsp/statistics/paired_tests.h"

namespace haptometer::tools {
namespace {

// ln(matched / reference) of the settings of one subject at one level
struct Halves {
  std::vector<double> high;
  std::vector<double> low;

  [[nodiscard]] bool is_whole() const { return !high.empty() && !low.empty(); }
  // both starts have equal weight, independent of the number of settings of each
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

// order of first appearance: the first condition is the control without a plan
void AppendOnce(std::vector<std::string>& names, const std::string& name) {
  if (std::ranges::find(names, name) == names.end()) names.push_back(name);
}

// settings by condition, level and subject, as ln(matched / reference)
Result<Settings> Sort(const TextTable& table) {
  HAPTOMETER_LET(const auto reference, NumbersOf(table, "reference_v"));
  HAPTOMETER_LET(const auto matched, NumbersOf(table, "matched_v"));
  Settings settings;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const std::string where = fmt::format("{}:{}", table.name, table.lines[i]);
    // logarithms need voltages above 0
    if (!(reference[i] > 0) || !(matched[i] > 0)) {
      return CannotAnswer(where, "has a voltage that is not above 0", "correct that line");
    }
    const std::string& started = table.columns.at("started")[i];
    if (started != "high" && started != "low") {
      return CannotAnswer(where, fmt::format("started '{}'", started), "write high or low");
    }
    const std::string& condition = table.columns.at("condition")[i];
    const std::string& subject = table.columns.at("subject")[i];
    if (condition.empty() || subject.empty()) {
      return CannotAnswer(where, "has no condition or subject", "correct that line");
    }
    AppendOnce(settings.conditions, condition);
    AppendOnce(settings.subjects, subject);
    Halves& halves = settings.of[condition][reference[i]][subject];
    (started == "high" ? halves.high : halves.low).push_back(std::log(matched[i] / reference[i]));
  }
  return settings;
}

// one logarithm of a ratio by level and subject
using LogRatios = std::map<double, std::map<std::string, double>>;

// mean log ratio of the settings, or with `of_starts` started high minus started low, if both exist
LogRatios LogRatiosOf(const Levels& levels, bool of_starts = false) {
  LogRatios logs;
  for (const auto& [level, subjects] : levels) {
    for (const auto& [subject, halves] : subjects) {
      if (!of_starts) logs[level][subject] = halves.mean();
      if (of_starts && halves.is_whole()) {
        logs[level][subject] = dsp::Mean(halves.high) - dsp::Mean(halves.low);
      }
    }
  }
  return logs;
}

// treatment minus control for subjects that have both at a level
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

// t test over the subjects of a level, of value(ln of the ratio)
template <typename Function>
dsp::OneSample TestLevel(const std::map<std::string, double>& subjects, const Function& value) {
  return dsp::TestMean(Mapped(subjects, [&](const auto& of) { return value(of.second); }));
}

// Holm's step-down correction over the ratios that have a test
void CorrectByHolm(const std::vector<MatchedRatio*>& ratios) {
  std::vector<std::optional<double>> p(ratios.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (const auto& test = ratios[i]->log_ratio.test) p[i] = test->p;
  }
  const auto adjusted = dsp::HolmOverTested(p);
  for (std::size_t i = 0; i < p.size(); ++i) ratios[i]->p_holm = adjusted[i];
}

// t tests of the levels, with Holm's correction over them
std::vector<MatchedRatio> LevelsOf(const LogRatios& logs) {
  std::vector<MatchedRatio> levels;
  levels.reserve(logs.size());
  for (const auto& [level, subjects] : logs) {
    levels.push_back({level, TestLevel(subjects, std::identity())});
  }
  std::vector<MatchedRatio*> all(levels.size());
  std::ranges::transform(levels, all.begin(), [](MatchedRatio& level) { return &level; });
  CorrectByHolm(all);
  return levels;
}

// one mean per subject over its levels; n = 0 without subjects
// a subject counts once in the test, with any number of levels
dsp::OneSample TestSubjects(const LogRatios& logs) {
  std::map<std::string, std::vector<double>> by_subject;
  for (const auto& [level, subjects] : logs) {
    for (const auto& [subject, log] : subjects) by_subject[subject].push_back(log);
  }
  const auto means = Mapped(by_subject, [](const auto& of) { return dsp::Mean(of.second); });
  return means.empty() ? dsp::OneSample{} : dsp::TestMean(means);
}

// ratios per level and over all levels, and the bias by the start
MatchedCondition ConditionOf(const std::string& name, const Levels& levels) {
  MatchedCondition condition{.name = name};
  const LogRatios logs = LogRatiosOf(levels);
  for (const MatchedRatio& level : LevelsOf(logs)) {
    const double reference_v = *level.reference_v;
    // matched voltage in V: reference x ratio
    const auto volts = [&](double log) { return reference_v * std::exp(log); };
    condition.levels.push_back({level, TestLevel(logs.at(reference_v), volts)});
  }
  condition.overall = {{}, TestSubjects(logs)};
  const dsp::OneSample start = TestSubjects(LogRatiosOf(levels, true));
  if (start.n > 0) condition.start_log_ratio = start;
  return condition;
}

MatchedContrast ContrastOf(const PlannedContrast& planned, const Settings& settings) {
  const LogRatios logs = Differences(LogRatiosOf(settings.of.at(planned.treatment)),
                                     LogRatiosOf(settings.of.at(planned.control)));
  MatchedContrast contrast{.planned = planned, .levels = LevelsOf(logs)};
  if (!logs.empty()) contrast.overall = {{}, TestSubjects(logs)};
  // subjects without a level in both conditions
  for (const std::string& subject : settings.subjects) {
    const auto has = [&](const auto& level) { return level.second.contains(subject); };
    if (std::ranges::none_of(logs, has)) contrast.left_out.push_back(subject);
  }
  return contrast;
}

// contrasts with Holm's correction over those that have a test
Result<std::vector<MatchedContrast>> ContrastsOf(const std::vector<PlannedContrast>& planned,
                                                 const Settings& settings) {
  std::vector<MatchedContrast> contrasts;
  contrasts.reserve(planned.size());
  std::vector<MatchedRatio*> ratios;
  ratios.reserve(planned.size());
  for (const PlannedContrast& pair : planned) {
    HAPTOMETER_TRY(CheckConditions(pair, settings.conditions));
    contrasts.push_back(ContrastOf(pair, settings));
    if (auto& overall = contrasts.back().overall) ratios.push_back(&*overall);
  }
  CorrectByHolm(ratios);
  return contrasts;
}

// settings without which a subject's mean is of fewer levels, or of one start only
void NameMissing(const Settings& settings, const std::string& condition,
                 std::vector<MissingSetting>& missing) {
  for (const auto& [level, subjects] : settings.of.at(condition)) {
    for (const std::string& subject : settings.subjects) {
      const auto found = subjects.find(subject);
      if (found == subjects.end()) {
        missing.push_back({subject, condition, level, ""});
      } else if (!found->second.is_whole()) {
        missing.push_back({subject, condition, level, found->second.high.empty() ? "high" : "low"});
      }
    }
  }
}

}  // namespace

double MatchedRatio::ratio() const { return std::exp(log_ratio.mean); }

// exp of the interval of the mean logarithm
std::optional<dsp::Interval> MatchedRatio::ratio_interval() const {
  if (!log_ratio.test) return std::nullopt;
  return dsp::Interval{std::exp(log_ratio.test->mean.lower), std::exp(log_ratio.test->mean.upper)};
}

Result<MatchingResult> AnalyzeMatching(const TextTable& table,
                                       const std::vector<PlannedContrast>& planned) {
  HAPTOMETER_LET(auto settings, Sort(table));
  MatchingResult result;
  result.source = Printable(table.name);
  result.settings = table.rows();
  result.conditions.reserve(settings.conditions.size());
  for (const std::string& name : settings.conditions) {
    result.conditions.push_back(ConditionOf(name, settings.of.at(name)));
    NameMissing(settings, name, result.missing);
  }
  result.planned = !planned.empty();
  // without a plan: each condition against the first of the file
  auto contrasts =
      ContrastsOf(result.planned ? planned : AllAgainstTheFirst(settings.conditions), settings);
  if (!contrasts) return std::unexpected(contrasts.error());
  result.contrasts = *std::move(contrasts);
  result.subjects = std::move(settings.subjects);
  return result;
}

}  // namespace haptometer::tools
