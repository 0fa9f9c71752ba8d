#include "tools/study/matching_result.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/text.h"
#include "dsp/statistics/moments.h"
#include "dsp/statistics/paired_tests.h"

namespace haptometer::tools {
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

}  // namespace haptometer::tools
