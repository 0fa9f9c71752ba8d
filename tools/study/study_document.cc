#include "tools/study/study_document.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/document/render.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Item;
using document::Key;
using document::ListOf;
using document::MemberOf;
using document::Range;
using document::Section;
using document::TextOrNotKnown;
using document::Value;

// keys of more than one place
constexpr Key kAnswered{document::kAnswered.name, "with a value"};
constexpr Key kBandRms{document::kBandRms.name, "band RMS", document::kMetre,
                       document::Form::kUncertain};
constexpr Key kOutlying{"outlying"};
constexpr Key kExcluded{"excluded"};
constexpr Key kRecorded{"recorded_utc", "recorded / UTC"};

// --- findings ---

// why trials have no value: errors of files, or refusals of the analysis
StudyFindings RefusalsOf(const StudyResult& study, bool of_errors) {
  StudyFindings findings;
  for (const StudyTrial& trial : study.table.trials) {
    // a file error is printed when it happens, so that it appears among the trials only (--all)
    if (trial.answered || trial.excluded || trial.error.has_value() != of_errors) continue;
    const auto refuse = [&](FindingOf<StudyFinding> finding) {
      finding.subject = trial.file;
      findings.Add(std::move(finding));
    };
    for (const std::string& reason : of_errors ? ReasonsOf(trial) : trial.reasons) {
      refuse({Severity::kRefusal, StudyFinding::kNoValue, {{"reason", reason}}});
    }
    if (of_errors) continue;
    for (const FindingOf<StudyFinding>& finding : trial.findings.list()) refuse(finding);
  }
  return findings;
}

}  // namespace

StudyFindings FindingsOf(const StudyResult& study) {
  StudyFindings findings = RefusalsOf(study, false);
  if (std::ranges::all_of(study.table.trials, [](const auto& one) { return !!one.excluded; })) {
    findings.Refuse(StudyFinding::kAllExcluded, {{"trials", study.table.trials.size()}});
  }
  if (!study.session_damage.empty()) {
    findings.Doubt(StudyFinding::kSessionLogDamaged, {{"what", study.session_damage}});
  }
  for (const std::string& file : study.session_missing) {
    findings.Add({Severity::kDoubt, StudyFinding::kSessionTrialMissing, {}, file});
  }
  // contrasts chosen by the program weaken the tests: every condition against the first
  if (!study.planned && !study.contrasts.empty()) {
    findings.Note(StudyFinding::kContrastsNotPlanned, {{"control", study.table.conditions[0]}});
  }
  for (const PlannedContrast& contrast : study.not_yet) {
    findings.Add({Severity::kNote, StudyFinding::kContrastNotYet, {}, NameOf(contrast)});
  }
  for (const std::string& condition : study.without_trial) {
    findings.Add({Severity::kNote, StudyFinding::kConditionWithoutTrial, {}, condition});
  }
  // a contrast of fewer than two subjects has no test
  for (const Contrast& contrast : study.contrasts) {
    RefuseUntested(NameOf(contrast.planned), contrast.difference, findings);
  }
  const StudyFindings exceptions = ExceptionsOf(study);
  for (const FindingOf<StudyFinding>& finding : exceptions.list()) findings.Add(finding);
  for (const std::string& table : study.ignored) {
    findings.Add({Severity::kNote, StudyFinding::kTableIgnored, {}, table});
  }
  const bool is_stated = study.CountAnswered([](const StudyTrial& trial) {
    return trial.gain_uncertainty.has_value();
  }) > 0;
  findings.Note(is_stated ? StudyFinding::kCalibrationInTrials
                          : StudyFinding::kCalibrationExcluded);
  return findings;
}

namespace {

// --- sections ---

Section BandSection(const dsp::BandPass& band) {
  Section section{.name = document::kBand.name};
  section.Add(document::kLowerHz, band.lower_hz);
  section.Add(document::kUpperHz, band.upper_hz);
  section.Add(document::kOrder, band.order);
  section.Add(document::kCorner, band.corners == dsp::Corners::kWhole ? "whole" : "each");
  section.Add({"", "RMS within", document::kHertz}, Range{band.lower_hz, band.upper_hz}).note =
      "one mean a subject";
  return section;
}

// trials by what they are good for
Section CountsSection(const StudyTable& table) {
  Section section{.name = "counts"};
  const auto add = [&](std::string_view name, std::string_view label, const auto& is_so) {
    const auto count = std::ranges::count_if(table.trials, is_so);
    section.Add(Key{name, count > 0 ? label : ""}, static_cast<std::size_t>(count));
  };
  add(kAnswered.name, "trials with a value", &StudyTrial::answered);
  add("doubtful", "of which doubtful",
      [](const StudyTrial& trial) { return trial.answered && trial.is_doubtful; });
  add("without_drive", "trials without a drive", &StudyTrial::has_no_drive);
  add("without_value", "trials without a value for another reason", [](const StudyTrial& trial) {
    return !trial.answered && !trial.has_no_drive && !trial.excluded;
  });
  add(kExcluded.name, "trials excluded",
      [](const StudyTrial& trial) { return trial.excluded.has_value(); });
  return section;
}

Section FloorSection(const std::optional<dsp::NoiseFloor>& floor) {
  const dsp::NoiseFloor known = floor.value_or(dsp::NoiseFloor{});
  // RMS in m of the noise floor, sqrt of its mean square
  const double rms_m = std::sqrt(known.power.mean_square);
  Section section{.name = "floor", .is_known = floor.has_value()};
  section.Add(document::kFile, known.file);
  section
      // u(rms) = u(mean square) / (2 rms)
      .Add({document::kRms.name, "noise correction", document::kMetre}, rms_m,
           std::sqrt(known.power.variance) / 2 / rms_m)
      .note = fmt::format("RMS of {}, subtracted in mean square", known.file);
  section.Add({document::kDuration.name}, known.duration_s);
  return section;
}

// the floors of a session, each of a subject, in the order of the trials
Section FloorsSection(const StudyTable& table) {
  Section section{
      .name = "subject_floors", .heading = "noise floors", .shape = Section::Shape::kTable};
  std::set<const dsp::NoiseFloor*> known;
  for (const StudyTrial& trial : table.trials) {
    if (!trial.floor || !known.insert(trial.floor.get()).second) continue;
    const double rms_m = std::sqrt(trial.floor->power.mean_square);
    Section& row = section.sections.emplace_back();
    row.Add(document::kSubject, trial.subject);
    row.Add({document::kRms.name, "RMS", document::kMetre}, rms_m,
            std::sqrt(trial.floor->power.variance) / 2 / rms_m);
    row.Add({document::kDuration.name}, trial.floor->duration_s);
    row.Add({document::kFile.name, "file"}, trial.floor->file);
  }
  return section;
}

Section ConditionRow(const ConditionSummary& condition) {
  // digits of mean and standard deviation follow from the standard uncertainty of the mean
  const double resolution = ResolutionBy(StandardUncertaintyOf(condition.subjects));
  const auto& repeats = condition.repeats;
  Section row;
  row.Add(Key{document::kName.name, kCondition.label}, condition.name);
  row.Add(kSubjects, condition.subjects.n);
  row.Add(document::kTrials, condition.trials);
  AddMean(row, {"mean_m", "mean", document::kMetre, document::Form::kInterval}, condition.subjects);
  row.Add({"standard_deviation_m", "sd over subjects", document::kMetre},
          condition.subjects.standard_deviation)
      .resolution = resolution;
  row.Add({"geometric_mean_m", "geometric mean", document::kMetre}, condition.geometric_m)
      .resolution = resolution;
  row.Add({"morey_half_width_m"}, condition.morey_m);
  row.Add({"icc"}, MemberOf(repeats, &dsp::Reliability::icc));
  row.Add({"icc_interval_95"}, MemberOf(repeats, &dsp::Reliability::interval));
  // sd of logarithms s as a relative variation, dimensionless
  row.Add({"within_cell_variation"},
          repeats ? Value(dsp::VariationOfLogs(repeats->within_sd)) : Value());
  return row;
}

// additions of --all to the table of conditions; JSON has the same values in ConditionRow
Section RepeatsRow(const ConditionSummary& condition) {
  const auto& repeats = condition.repeats;
  Section row;
  row.Add({"", kCondition.label}, condition.name);
  row.Add({"", "error bar within subjects (Morey)", document::kMetre}, condition.morey_m)
      .resolution = ResolutionBy(condition.morey_m);
  row.Add({"", "ICC(1,1)"}, MemberOf(repeats, &dsp::Reliability::icc)).resolution = 1e-3;
  row.Add({"", "95 %"}, MemberOf(repeats, &dsp::Reliability::interval)).resolution = 1e-3;
  row.Add({"", "variation within cells", document::kShare},
          repeats ? Value(dsp::VariationOfLogs(repeats->within_sd)) : Value())
      .resolution = 1e-4;
  return row;
}

// additions of --all to a contrast
Section FurtherSection(const Contrast& contrast) {
  const auto& ratio = contrast.ratio;
  const auto& means = contrast.ratio_of_means;
  Section section{.detail = Detail::kAll};
  section.Add({"d_av", "effect size d_av"}, MemberOf(contrast.effect, &dsp::EffectSize::d_av))
      .resolution = 0.01;
  // paired t test of the logarithms: the test of the ratio, not of the difference
  const auto& test = ratio ? ratio->log_ratio.test : std::nullopt;
  section.Add({"ratio_p"}, MemberOf(test, &dsp::StudentTest::p));
  section.Add({"", "of the ratio"},
              test ? Value(fmt::format("p = {:.3g}, paired t of logarithms", test->p)) : Value());
  section.Add({"sign_flip_p"}, contrast.sign_flip_p);
  // exact sign-flip test: 2^n choices of signs, up to 20 subjects
  std::string flips = "not computed, more than 20 subjects";
  if (contrast.sign_flip_p) {
    flips = fmt::format("p = {:.3g}, exact over 2^{} choices", *contrast.sign_flip_p,
                        contrast.difference.n);
  }
  section.Add({"", "sign flips"}, contrast.difference.n > 0 ? Value(flips) : Value());
  std::optional<dsp::Interval> fieller;
  double resolution = 0;
  // a 95 % interval is about 4 standard uncertainties wide
  if (means && means->interval) {
    fieller = means->interval;
    resolution = ResolutionBy((fieller->upper - fieller->lower) / 4);
  }
  Item& of_means =
      section.Add({"ratio_of_means", "ratio of means"}, MemberOf(means, &dsp::RatioOfMeans::ratio));
  of_means.resolution = resolution;
  // Fieller's interval is unbounded where the control's mean does not differ from 0
  if (means && !fieller) of_means.note = "95 %, by Fieller: unbounded, the control's mean may be 0";
  section.Add({"ratio_of_means_interval_95", "95 %, by Fieller"}, fieller).resolution = resolution;
  Item& unbounded = section.Add({"ratio_of_means_unbounded"}, Value());
  if (means) unbounded.value = !means->interval;
  return section;
}

Section ContrastSection(const Contrast& contrast) {
  Section section{.heading = NameOf(contrast.planned)};
  section.Add(kTreatment, contrast.planned.treatment);
  section.Add(kControl, contrast.planned.control);
  section.Add(kN, contrast.difference.n);
  Item& left_out = section.Add(kLeftOutSubjects, contrast.left_out);
  if (!contrast.left_out.empty()) left_out.note = "one of the two conditions is missing";
  // exp of the mean difference of logarithms
  AddRatio(section, kRatio, contrast.ratio ? contrast.ratio->log_ratio : dsp::OneSample{}).note =
      "of geometric means";
  AddMean(section,
          {"mean_difference_m", "mean difference", document::kMetre, document::Form::kInterval},
          contrast.difference);
  // Hedges g with the interval of the population's effect, from the noncentral t
  AddTest(section, "paired t", contrast.difference.test, contrast.p_holm);
  const auto& effect = contrast.effect;
  std::optional<dsp::Interval> population;
  if (effect) population = effect->interval;
  const double resolution =
      population ? ResolutionBy((population->upper - population->lower) / 4) : 0;
  section.Add({"hedges_g", "effect size Hedges g"}, MemberOf(effect, &dsp::EffectSize::hedges_g))
      .resolution = resolution;
  section.Add({"d_z", "effect size d_z"}, MemberOf(effect, &dsp::EffectSize::d_z)).resolution =
      resolution;
  // one interval for both estimates
  Item& interval = section.Add({"effect_interval_95", "95 %"}, population);
  interval.resolution = resolution;
  interval.note = "of the population's mean difference / sd";
  section.sections.push_back(FurtherSection(contrast));
  return section;
}

Section AnovaSection(const Key& key, const std::optional<dsp::RepeatedMeasuresAnova>& anova,
                     std::size_t subjects) {
  const auto known = anova.value_or(dsp::RepeatedMeasuresAnova{});
  Section section{
      .name = key.name, .heading = std::string(key.label), .is_known = anova.has_value()};
  section.Add(kSubjects, subjects);
  section.Add({"f"}, known.f);
  section.Add({"df_conditions"}, known.df_conditions);
  section.Add({"df_error"}, known.df_error);
  section.Add(kP, known.p);
  // F test of repeated measures; p without and with the correction for sphericity
  section.Add({"", "repeated measures"},
              fmt::format("F({:g}, {:g}) = {:.4g}, p = {:.3g}", known.df_conditions, known.df_error,
                          known.f, known.p));
  // epsilon 1: sphericity holds; 1 / (conditions - 1): strongest violation
  section.Add({"greenhouse_geisser_epsilon"}, known.greenhouse_geisser);
  section.Add({"p_greenhouse_geisser"}, known.p_greenhouse_geisser);
  section.Add({"", "Greenhouse-Geisser"},
              fmt::format("epsilon {:.3f}, p = {:.3g}", known.greenhouse_geisser,
                          known.p_greenhouse_geisser));
  section.Add({"partial_eta_squared", "partial eta squared"}, known.partial_eta_squared)
      .resolution = 1e-3;
  return section;
}

Section TrendSection(const std::optional<OrderTrend>& trend) {
  const OrderTrend known = trend.value_or(OrderTrend{});
  const dsp::OneSample& slope = known.per_trial;
  Section section{
      .name = "trend", .heading = "trend over a subject's trials", .is_known = trend.has_value()};
  section.Add(Key{document::kOrder.name, "by"}, known.by_start ? "utc_start" : kRepeat.name);
  section.Add(kSubjects, slope.n);
  AddMean(section, {"log_slope_per_trial", "", document::kNone, document::Form::kInterval}, slope);
  // a slope b of ln(rms) per trial is a relative change exp(b) - 1
  Item& percent = section.Add({"", "change a trial", document::kShare}, std::expm1(slope.mean),
                              StandardUncertaintyOf(slope));
  if (slope.test) {
    percent.interval =
        Range{std::expm1(slope.test->mean.lower), std::expm1(slope.test->mean.upper)};
  }
  AddTest(section, "t over subjects", slope.test);
  return section;
}

Section AllConditions(const StudyResult& study) {
  const FurtherStatistics& further = study.further;
  Section all{.detail = Detail::kAll};
  all.sections = {ListOf({.heading = "repeats and error bars"}, further.conditions, RepeatsRow),
                  AnovaSection({"anova", "all conditions"}, further.anova, further.whole_subjects),
                  AnovaSection({"anova_of_logarithms", "all conditions, logarithms"},
                               further.log_anova, further.whole_subjects),
                  TrendSection(further.trend)};
  StudyFindings findings;
  // subjects that have a value in every condition are too few
  if (!further.anova) {
    findings.Note(StudyFinding::kAnovaNotDetermined, {{"subjects", further.whole_subjects}});
  }
  for (const ConditionSummary& condition : further.conditions) {
    if (condition.repeats || condition.trials == condition.subjects.n) continue;
    findings.Add({Severity::kNote, StudyFinding::kRepeatsNotDetermined, {}, condition.name});
  }
  document::AddFindings(all, findings);
  return all;
}

// kinds of the differences between a trial's analysis and the question
std::vector<std::string> DeviationsOf(const StudyTrial& trial) {
  // refusals are among the reasons
  std::vector<std::string> kinds;
  for (const FindingOf<StudyFinding>& finding : trial.findings.list()) {
    if (finding.severity == Severity::kRefusal) continue;
    kinds.emplace_back(SentenceOf(finding.kind).kind);
  }
  return kinds;
}

// subject, condition and repeat
void AddPlace(const StudyTrial& trial, Section& row) {
  row.Add(document::kSubject, TextOrNotKnown(trial.subject));
  row.Add(kCondition, TextOrNotKnown(trial.condition));
  row.Add(kRepeat, TextOrNotKnown(trial.repeat));
}

// "2026-11-27 00:50:54" of "2026-11-27T00:50:54.936Z"; another text as it is
std::string SecondOf(std::string utc) {
  constexpr std::size_t kToSecond = 19;
  if (utc.size() < kToSecond || utc[10] != 'T') return utc;
  utc[10] = ' ';
  return utc.substr(0, kToSecond);
}

Section TrialRow(const StudyTrial& trial) {
  Section row{.sources = trial.sources};
  row.Add(Key{document::kFile.name, "file"}, trial.file);
  AddPlace(trial, row);
  row.Add({"", "data"}, TextOrNotKnown(document::SourcesText(trial.sources)));
  row.Add({kRecorded.name}, TextOrNotKnown(trial.utc_start));
  row.Add({"", kRecorded.label}, TextOrNotKnown(SecondOf(trial.utc_start)));
  row.Add({document::kSensor.name}, TextOrNotKnown(trial.sensor));
  row.Add(kAnswered, trial.answered);
  row.Add(kExcluded, trial.excluded);
  row.Add(document::kReasons, ReasonsOf(trial));
  row.Add({"deviations", "findings"}, DeviationsOf(trial));
  row.Add(kBandRms, trial.rms_m, trial.rms_uncertainty_m);
  return row;
}

Section MissingRow(const MissingTrials& missing) {
  Section row;
  row.Add({document::kSubject.name}, missing.subject);
  row.Add({kCondition.name}, missing.condition);
  row.Add({kAnswered.name}, missing.answered);
  row.Add({"expected"}, missing.expected);
  return row;
}

Section OutlyingRow(const Outlying& outlying) {
  Section row;
  row.Add({document::kSubject.name}, outlying.subject);
  row.Add({kCondition.name}, outlying.condition);
  row.Add(document::kFile, TextOrNotKnown(outlying.file));
  row.Add({"times"}, outlying.times);
  row.Add({"studentized_residual"}, outlying.t);
  row.Add(kP, outlying.p);
  return row;
}

Section TrialsSection(const StudyResult& study) {
  Section section{.detail = Detail::kAll};
  section.sections.push_back(
      ListOf({.name = document::kTrials.name, .heading = "trials"}, study.table.trials, TrialRow));
  // errors of files were reported when the files were read
  document::AddFindings(section, RefusalsOf(study, true));
  return section;
}

// --- what a page has and a text does not ---

// a contrast as a row, as a paper prints it
Section ContrastRow(const Contrast& contrast) {
  Section row;
  const auto& test = contrast.difference.test;
  const auto interval = [](const auto& of) { return of ? Value(of->mean) : Value(); };
  row.Add({"", "contrast"}, NameOf(contrast.planned));
  row.Add({"", "n"}, contrast.difference.n);
  AddMean(row, {"", "difference", document::kMetre}, contrast.difference);
  row.Add({"", "95 %", document::kMetre}, interval(test),
          StandardUncertaintyOf(contrast.difference));
  const dsp::OneSample logs = contrast.ratio ? contrast.ratio->log_ratio : dsp::OneSample{};
  Value ratios;
  if (logs.test) ratios = Range{std::exp(logs.test->mean.lower), std::exp(logs.test->mean.upper)};
  AddRatio(row, {"", "ratio"}, logs);
  row.Add({"", "95 %"}, ratios, row.items.back().standard_uncertainty);
  row.Add({"", "t"}, MemberOf(test, &dsp::StudentTest::t)).resolution = 0.01;
  row.Add({"", "p, Holm"}, contrast.p_holm).resolution = contrast.p_holm.value_or(0) / 10;
  row.Add({"", "Hedges g"}, MemberOf(contrast.effect, &dsp::EffectSize::hedges_g)).resolution =
      0.01;
  return row;
}

// how many findings of each severity stand below it
Section RemarksCount(const Section& findings) {
  Section section{.heading = "what differs, and what to consider", .detail = Detail::kPage};
  for (const auto& [severity, label] :
       {std::pair(Severity::kRefusal, "not answered"), std::pair(Severity::kDoubt, "doubts"),
        std::pair(Severity::kNote, "notes")}) {
    section.Add({"", label},
                std::ranges::count(findings.findings, severity, &document::Finding::severity));
  }
  return section;
}

Section DesignSection(const StudyResult& study) {
  const StudyTable& table = study.table;
  Section section{.heading = "design", .detail = Detail::kPage};
  const auto list = [](const std::vector<std::string>& names) {
    return fmt::format("{}: {}", names.size(), fmt::join(names, ", "));
  };
  section.Add({"", "subjects"}, list(table.subjects));
  section.Add({"", "conditions"}, list(table.conditions));
  section.Add({"", "trials"}, fmt::format("{}; of a subject in a condition at most {}",
                                          table.trials.size(), table.repeats));
  section.Add({"", "contrasts"}, study.planned ? "planned" : "every condition against the first");
  section.Add({"", "unit of analysis"},
              "the subject: its trials in a condition are averaged first");
  std::set<std::string> starts;
  std::set<std::string> sensors;
  for (const StudyTrial& trial : table.trials) {
    if (!trial.utc_start.empty()) starts.insert(SecondOf(trial.utc_start));
    if (!trial.sensor.empty()) sensors.insert(trial.sensor);
  }
  section.Add({"", "recorded"}, starts.empty() ? Value("not stated")
                                               : Value(fmt::format("{} to {} UTC", *starts.begin(),
                                                                   *starts.rbegin())));
  section.Add({"", "sensor"},
              sensors.empty() ? "not stated" : fmt::format("{}", fmt::join(sensors, ", ")));
  return section;
}

Section ExcludedSection(const StudyResult& study) {
  Section section{
      .heading = "excluded trials", .shape = Section::Shape::kTable, .detail = Detail::kPage};
  for (const StudyTrial& trial : study.table.trials) {
    if (!trial.excluded) continue;
    Section& row = section.sections.emplace_back();
    row.Add({"", "file"}, trial.file);
    AddPlace(trial, row);
    row.Add({"", "reason"}, *trial.excluded);
  }
  return section;
}

Section MethodsSection(const StudyResult& study) {
  Section section{.heading = "methods", .detail = Detail::kPage};
  for (const auto& [label, text] : MethodsOf(study)) section.Add({"", label}, text);
  return section;
}

}  // namespace

// without duplicates, in the order of the enumeration
std::vector<document::DataSource> SourcesOf(const StudyTable& table) {
  std::set<document::DataSource> sources;
  for (const StudyTrial& trial : table.trials) {
    if (trial.answered) sources.insert(trial.sources.begin(), trial.sources.end());
  }
  return {sources.begin(), sources.end()};
}

StudyFindings ExceptionsOf(const StudyResult& study) {
  StudyFindings findings;
  AddDeviations(study.table.trials, findings);
  findings.AddAll(FindOtherFrequencies(study.table.trials));
  // exclusions are the user's own, each with its reason
  for (const StudyTrial& trial : study.table.trials) {
    if (!trial.excluded) continue;
    findings.Add(
        {Severity::kNote, StudyFinding::kExcluded, {{"reason", *trial.excluded}}, trial.file});
  }
  // trials without a drive are named together: a session with the amplifier off has many
  std::vector<std::string> without_drive;
  for (const StudyTrial& trial : study.table.trials) {
    if (trial.has_no_drive) without_drive.push_back(trial.file);
  }
  if (!without_drive.empty()) {
    findings.Add({Severity::kDoubt,
                  StudyFinding::kWithoutDrive,
                  {{"trials", without_drive.size()}, {"of_trials", study.table.trials.size()}},
                  fmt::format("{}", fmt::join(without_drive, ", "))});
  }
  findings.AddAll(study.equal_files);
  AddLabelsAlike("subject", study.table.subjects, findings);
  AddLabelsAlike("condition", study.table.conditions, findings);
  // place of a subject's mean in a message
  const auto cell = [](const auto& of) {
    return fmt::format("subject {} in {}", of.subject, of.condition);
  };
  for (const MissingTrials& missing : study.missing) {
    findings.Add({Severity::kNote,
                  StudyFinding::kTrialsMissing,
                  {{"answered", missing.answered}, {"expected", missing.expected}},
                  cell(missing)});
  }
  // an outlying trial is named by its file, an outlying mean by subject and condition
  for (const Outlying& outlying : study.outlying) {
    const bool is_cell = outlying.file.empty();
    findings.Add({Severity::kDoubt,
                  is_cell ? StudyFinding::kOutlyingCell : StudyFinding::kOutlyingTrial,
                  {{"times", outlying.times}, {"studentized", outlying.t}, {"p", outlying.p}},
                  is_cell ? cell(outlying) : outlying.file});
  }
  return findings;
}

std::vector<std::string> ReasonsOf(const StudyTrial& trial) {
  if (trial.error) return {trial.error->Text()};
  if (trial.excluded) {
    return {
        document::Fill(SentenceOf(StudyFinding::kExcluded).text, {{"reason", *trial.excluded}})};
  }
  std::vector<std::string> reasons = trial.reasons;
  for (const FindingOf<StudyFinding>& finding : trial.findings.list()) {
    if (finding.severity != Severity::kRefusal) continue;
    // a refusal of the study (such as RMS below the noise) as a sentence with its numbers
    reasons.push_back(document::Fill(SentenceOf(finding.kind).text, finding.numbers));
  }
  return reasons;
}

document::Document StudyDocument(const StudyResult& study, bool has_figures) {
  const StudyTable& table = study.table;
  document::Document document{
      .verb = "study",
      .title = fmt::format("{}: {}, {}, {}", study.source, Counted(table.trials.size(), "trial"),
                           Counted(table.subjects.size(), "subject"),
                           Counted(table.conditions.size(), "condition"))};
  Section& root = document.root;
  root.sources = SourcesOf(table);
  root.Add(kStudy, study.source);
  root.Add(kUnitOfAnalysis, document::kSubject.name);
  root.Add({kSubjects.name}, table.subjects);
  root.Add(kContrastsPlanned, study.planned);
  root.sections = {
      BandSection(study.question.band),
      FloorSection(study.question.floor),
      CountsSection(table),
      ListOf({.name = kConditions.name}, study.further.conditions, ConditionRow),
      ListOf({.heading = "contrasts", .detail = Detail::kPage}, study.contrasts, ContrastRow),
      ListOf({.name = kContrasts.name, .shape = Section::Shape::kArray}, study.contrasts,
             ContrastSection),
      FloorsSection(table)};
  if (has_figures) {
    root.sections.push_back(
        {.figures = {
             {.caption = "means of the subjects, and the contrasts with their 95 % intervals",
              .panels = StudyPanels(study)}}});
  }
  Section findings;
  document::AddFindings(findings, FindingsOf(study));
  for (Section& section : std::vector{
           RemarksCount(findings), std::move(findings), DesignSection(study), WideTable(study),
           ExcludedSection(study), MethodsSection(study), AllConditions(study),
           ListOf({.name = "missing"}, study.missing, MissingRow),
           ListOf({.name = kOutlying.name}, study.outlying, OutlyingRow), TrialsSection(study)}) {
    root.sections.push_back(std::move(section));
  }
  return document;
}

// a row per trial, for statistics programs; numbers in SI units
document::Section LongTable(const StudyResult& study) {
  return ListOf({}, study.table.trials, [&](const StudyTrial& trial) {
    const bool is_outlying = std::ranges::count(study.outlying, trial.file, &Outlying::file) > 0;
    std::vector<std::string> remarks = ReasonsOf(trial);
    for (std::string& kind : DeviationsOf(trial)) remarks.push_back(std::move(kind));
    Section row;
    AddPlace(trial, row);
    row.Add(kBandRms, trial.rms_m, trial.rms_uncertainty_m);
    row.Add(kAnswered, static_cast<int>(trial.answered));
    row.Add(kOutlying, static_cast<int>(is_outlying));
    row.Add(kExcluded, static_cast<int>(trial.excluded.has_value()));
    row.Add(document::kDataSources, document::SourcesText(trial.sources));
    row.Add(kRecorded, trial.utc_start);
    row.Add(document::kSensor, trial.sensor);
    row.Add({"remarks"}, fmt::format("{}", fmt::join(remarks, "; ")));
    row.Add(document::kFile, trial.file);
    return row;
  });
}

// a row per subject: mean and number of trials of each condition
document::Section WideTable(const StudyResult& study) {
  Section table{
      .heading = "means of the subjects", .shape = Section::Shape::kTable, .detail = Detail::kPage};
  for (std::size_t s = 0; s < study.table.subjects.size(); ++s) {
    Section& row = table.sections.emplace_back();
    row.Add(document::kSubject, study.table.subjects[s]);
    for (std::size_t c = 0; c < study.table.conditions.size(); ++c) {
      const Cell& cell = study.table.cells[s][c];
      row.Add({study.table.conditions[c] + "_mean_m", study.table.conditions[c], document::kMetre},
              cell.mean_m())
          .resolution = ResolutionBy(StandardUncertaintyOf(study.further.conditions[c].subjects));
      row.Add({study.table.conditions[c] + "_trials"}, cell.trials.size());
    }
  }
  return table;
}

}  // namespace haptometer::tools
