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
#include "tools/document/keys.h"
#include "tools/study/study_document.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Item;
using document::Key;
using document::ListOf;
using document::MemberOf;
using document::Range;
using document::Section;
using document::Value;

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
  HAPTOMETER_TRY(CheckContrasts(planned, settings.conditions));
  std::vector<MatchedContrast> contrasts;
  contrasts.reserve(planned.size());
  std::vector<MatchedRatio*> ratios;
  ratios.reserve(planned.size());
  for (const PlannedContrast& pair : planned) {
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

// --- the document ---

namespace {

// --- findings ---

// tests that are not possible, missing settings, and the assumption behind the power
StudyFindings FindingsOf(const MatchingResult& result) {
  StudyFindings findings;
  AddLabelsAlike("subject", result.subjects, findings);
  AddLabelsAlike("condition", Mapped<std::string>(result.conditions, &MatchedCondition::name),
                 findings);
  for (const MatchedCondition& condition : result.conditions) {
    RefuseUntested(condition.name, condition.overall.log_ratio, findings);
  }
  for (const MatchedContrast& contrast : result.contrasts) {
    const auto& overall = contrast.overall;
    RefuseUntested(NameOf(contrast.planned), overall ? overall->log_ratio : dsp::OneSample{},
                   findings);
  }
  for (const MissingSetting& missing : result.missing) {
    FindingOf<StudyFinding> finding{
        .kind = StudyFinding::kNoSetting,
        .numbers = {{"reference_v", missing.reference_v}},
        .subject = fmt::format("subject {}, {} at {:g} V", missing.subject, missing.condition,
                               missing.reference_v)};
    // a subject with one start only: its bias by the start remains in the mean
    if (!missing.started.empty()) {
      finding.kind = StudyFinding::kOneStart;
      finding.numbers.emplace_back("missing", missing.started);
    }
    findings.Add(std::move(finding));
  }
  if (!result.planned && !result.contrasts.empty()) {
    findings.Note(StudyFinding::kContrastsNotPlanned,
                  {{"control", result.contrasts.front().planned.control}});
  }
  findings.Note(StudyFinding::kPowerByVoltage);
  return findings;
}

// --- sections ---

// reduction 1 - r^power of a ratio r; the ends of the interval change places
void AddReduction(Section& section, const Key& key, const dsp::OneSample& log_ratio, int power) {
  Item& item = AddRatio(section, key, log_ratio);
  const double ratio = std::exp(log_ratio.mean);
  const auto reduction = [&](double of) { return 1 - std::pow(of, power); };
  if (log_ratio.n > 0) item.value = reduction(ratio);
  // u(1 - r^p) = p r^(p - 1) u(r)
  if (item.standard_uncertainty) *item.standard_uncertainty *= power * std::pow(ratio, power - 1);
  if (item.interval) {
    item.interval = Range{reduction(item.interval->upper), reduction(item.interval->lower)};
  }
}

void AddRatioItems(Section& section, const MatchedRatio& ratio) {
  section.Add({"reference_v", "reference", document::kVolt}, ratio.reference_v);
  section.Add(kN, ratio.log_ratio.n);
  AddRatio(section, kRatio, ratio.log_ratio);
  // voltage: p = 1; power by the square of the voltage: p = 2
  AddReduction(section, {"reduction", "voltage reduction", document::kShare, Form::kInterval},
               ratio.log_ratio, 1);
  AddReduction(section, {"power_saving", "power saving", document::kShare, Form::kInterval},
               ratio.log_ratio, 2);
  AddTest(section, "t of ln(ratio)", ratio.log_ratio.test, ratio.p_holm);
}

Section LevelsSection() {
  return {.name = "levels",
          .heading = "levels",
          .shape = Section::Shape::kTable,
          .detail = Detail::kAll};
}

Section OverallSection(const MatchedRatio* overall) {
  Section section{.name = "overall", .is_known = overall != nullptr};
  if (overall != nullptr) AddRatioItems(section, *overall);
  return section;
}

// bias by the start: ratio of settings that started high to those that started low
Section StartSection(const std::optional<dsp::OneSample>& log_ratio) {
  const dsp::OneSample known = log_ratio.value_or(dsp::OneSample{});
  Section section{.name = "started_high_over_low", .is_known = log_ratio.has_value()};
  section.Add({kN.name}, known.n);
  Key key = kRatio;
  key.label = "started high / low";
  AddRatio(section, key, known);
  section.Add(kP, MemberOf(known.test, &dsp::StudentTest::p));
  return section;
}

Section MatchedConditionSection(const MatchedCondition& condition) {
  Section levels = LevelsSection();
  for (const MatchedLevel& level : condition.levels) {
    // mean and standard deviation of the matched voltage over subjects, V
    Section& row = levels.sections.emplace_back();
    AddRatioItems(row, level.ratio);
    row.Add({"matched_mean_v", "matched", document::kVolt}, level.matched_v.mean,
            StandardUncertaintyOf(level.matched_v));
    row.Add({"matched_standard_deviation_v", "sd", document::kVolt},
            level.matched_v.standard_deviation)
        .resolution = ResolutionBy(StandardUncertaintyOf(level.matched_v));
  }
  Section section{.heading = condition.name + ": matched voltage against the reference"};
  section.Add(document::kName, condition.name);
  section.sections = {OverallSection(&condition.overall), StartSection(condition.start_log_ratio),
                      std::move(levels)};
  return section;
}

Section MatchedContrastSection(const MatchedContrast& contrast) {
  Section levels = LevelsSection();
  for (const MatchedRatio& level : contrast.levels) {
    AddRatioItems(levels.sections.emplace_back(), level);
  }
  Section section{.heading = NameOf(contrast.planned) + ": their matched voltages"};
  section.Add(kTreatment, contrast.planned.treatment);
  section.Add(kControl, contrast.planned.control);
  Item& left_out = section.Add(kLeftOutSubjects, contrast.left_out);
  if (!contrast.left_out.empty()) left_out.note = "no level in both";
  section.sections = {OverallSection(contrast.overall ? &*contrast.overall : nullptr),
                      std::move(levels)};
  return section;
}

}  // namespace

document::Document MatchingDocument(const MatchingResult& result, bool has_figures) {
  document::Document document{
      .verb = "study",
      .title = fmt::format(
          "{}: {}, {}; geometric means of matched / reference, one value a subject", result.source,
          Counted(result.settings, "setting"), Counted(result.subjects.size(), "subject"))};
  Section& root = document.root;
  root.sources = {document::DataSource::kImported};
  root.Add(document::kFile, result.source);
  root.Add(kUnitOfAnalysis, document::kSubject.name);
  root.Add(document::kSettings, result.settings);
  root.Add({kSubjects.name}, result.subjects);
  root.Add(kContrastsPlanned, result.planned);
  root.sections = {ListOf({.name = kConditions.name, .shape = Section::Shape::kArray},
                          result.conditions, MatchedConditionSection),
                   ListOf({.name = kContrasts.name, .shape = Section::Shape::kArray},
                          result.contrasts, MatchedContrastSection)};
  if (has_figures) {
    root.figures = {
        {.caption = "matched against reference voltage", .panels = MatchingPanels(result)}};
  }
  document::AddFindings(root, FindingsOf(result));
  return document;
}

std::vector<plot::Panel> MatchingPanels(const MatchingResult& result) {
  std::vector<plot::Panel> panels;
  panels.reserve(result.conditions.size());
  double most_v = 0;
  for (const MatchedCondition& condition : result.conditions) {
    plot::Panel panel;
    // a key in the first panel serves all
    const bool is_first = panels.empty();  // the one with a key
    plot::Series points{is_first ? "mean and standard deviation over subjects" : "",
                        plot::Style{.mark = plot::Mark::kErrorBars, .colour = plot::kBlue}};
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
    panel.series.push_back(
        // the line matched = reference
        {is_first ? "equal" : "", plot::Lines(plot::kGrey, 1, 2), points.x, points.x});
    for (std::size_t k = 0; k < points.x.size(); ++k) {
      most_v = std::max({most_v, points.x[k], points.y[k] + points.y_error[k]});
    }
    panel.series.push_back(std::move(points));
    panels.push_back(std::move(panel));
  }
  // one axis of voltages for all conditions
  for (plot::Panel& panel : panels) panel.y_range = {0, 1.05 * most_v};
  return panels;
}

}  // namespace haptometer::tools
