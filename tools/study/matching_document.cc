#include <fmt/core.h>

#include <cmath>

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

// --- findings ---

// tests that are not possible, missing settings, and the assumption behind the power
StudyFindings FindingsOf(const MatchingResult& result) {
  StudyFindings findings;
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
      .title = fmt::format("{}: {} settings, {} subjects; geometric means of matched / reference, "
                           "one value a subject",
                           result.source, result.settings, result.subjects.size())};
  Section& root = document.root;
  root.sources = {document::DataSource::kImported};
  root.Add(document::kFile, result.source);
  root.Add(kUnitOfAnalysis, document::kSubject.name);
  root.Add({"settings"}, result.settings);
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
    panel.y_from_zero = true;
    panel.series.push_back(
        // the line matched = reference
        {is_first ? "equal" : "", plot::Lines(plot::kGrey, 1, 2), points.x, points.x});
    panel.series.push_back(std::move(points));
    panels.push_back(std::move(panel));
  }
  return panels;
}

}  // namespace haptometer::tools
