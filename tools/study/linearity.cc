#include "tools/study/linearity.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "base/mapped.h"
#include "base/text.h"
#include "tools/cli/recording_files.h"
#include "tools/document/keys.h"
#include "tools/study/study_document.h"
#include "tools/study/study_table.h"
#include "tools/study/text_table.h"

namespace haptometer::tools {
namespace {

using document::Form;
using document::Item;
using document::Key;
using document::ListOf;
using document::MemberOf;
using document::Range;
using document::Section;
using document::TextOrNotKnown;
using document::Value;

// a CSV with drives and without times, recognised by its header
bool IsSweepTable(const std::string& path) {
  if (std::filesystem::path(path).extension() != ".csv") return false;
  const auto table = ReadTextTable(path, {"drive_v"});
  return table && std::ranges::none_of(table->columns, [](const auto& column) {
           return column.first.starts_with("time");
         });
}

Result<void> TakeTable(const std::string& path, DriveReadings& taken) {
  HAPTOMETER_LET(const auto table, ReadTextTable(path, {"drive_v", "rms_m"}));
  HAPTOMETER_LET(const auto drive, NumbersOf(table, "drive_v"));
  HAPTOMETER_LET(const auto rms, NumbersOf(table, "rms_m"));
  // subject and condition are optional columns
  const auto text = [&](const std::string& column, std::size_t row) {
    const auto found = table.columns.find(column);
    return found == table.columns.end() ? std::string() : found->second[row];
  };
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (drive[i] < 0 || rms[i] < 0) {
      return CannotAnswer(fmt::format("{}:{}", path, table.lines[i]),
                          "has a negative amplitude or RMS", "correct that line");
    }
    taken.readings.push_back({text("subject", i), text("condition", i), drive[i], rms[i]});
  }
  return {};
}

// An error of a trial excludes that trial only. The RMS includes the noise, because
// AnalyzeLinearity subtracts the same floor from all readings.
Result<DriveReading> ReadingOf(const StudyTrial& trial) {
  if (trial.error) return std::unexpected(*trial.error);
  // a trial without a drive is one at 0 V, which states that
  const bool is_off = trial.has_no_drive && trial.drive_v == 0;
  if (!trial.rms_with_floor_m || (trial.has_no_drive && !is_off)) {
    const std::vector<std::string> reasons = ReasonsOf(trial);
    return CannotAnswer(trial.file, reasons.empty() ? "has no RMS" : reasons.front(), "");
  }
  if (!trial.drive_v || !(*trial.drive_v >= 0)) {
    return CannotAnswer(trial.file, "does not state its drive_amplitude_v",
                        "give a table with drive_v,rms_m");
  }
  return DriveReading{trial.subject, trial.condition, *trial.drive_v, *trial.rms_with_floor_m};
}

// what is doubtful of the trials, but for their own noise, in place of which the line's is
// subtracted
StudyFindings FindingsOf(const std::vector<StudyTrial>& trials) {
  StudyFindings all;
  AddDeviations(trials, all);
  StudyFindings findings;
  for (const FindingOf<StudyFinding>& finding : all.list()) {
    const bool is_of_noise = finding.kind == StudyFinding::kNoNoiseCorrection ||
                             finding.kind == StudyFinding::kFloorDoubtful;
    if (!is_of_noise) findings.Add(finding);
  }
  findings.AddAll(FindOtherFrequencies(trials));
  return findings;
}

}  // namespace

Result<DriveFiles> FindDriveFiles(const std::vector<std::string>& words) {
  DriveFiles files;
  for (const std::string& word : words) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(word, ignored)) {
      (IsSweepTable(word) ? files.tables : files.trials).push_back(word);
      continue;
    }
    HAPTOMETER_LET(const auto found, cli::RecordingsIn(word));
    for (const cli::RecordingFile& file : found) {
      (file.is_table ? files.ignored : files.trials).push_back(file.path);
    }
  }
  return files;
}

DriveReadings ReadDriveReadings(const DriveFiles& files, const dsp::BandQuestion& question,
                                const trial::ImportOptions& import) {
  DriveReadings taken;
  std::set<document::DataSource> sources;
  std::vector<std::string> used;
  for (const std::string& path : files.tables) {
    if (auto read = TakeTable(path, taken); !read) {
      taken.errors.push_back(read.error());
      continue;
    }
    // a table's origin is not stated in it
    sources.insert(document::DataSource::kImported);
    used.push_back(path);
  }
  const auto trials =
      Mapped(files.trials, [](const std::string& path) { return TrialFile{.path = path}; });
  const std::vector<StudyTrial> analyzed = AnalyzeTrials(trials, question, import);
  std::vector<StudyTrial> of_readings;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    auto reading = ReadingOf(analyzed[i]);
    if (!reading) {
      taken.errors.push_back(reading.error());
      continue;
    }
    taken.readings.push_back(*std::move(reading));
    sources.insert(analyzed[i].sources.begin(), analyzed[i].sources.end());
    used.push_back(trials[i].path);
    of_readings.push_back(analyzed[i]);
  }
  taken.sources.assign(sources.begin(), sources.end());
  taken.findings = FindingsOf(of_readings);
  AddEqualFiles(used, taken.findings);
  for (const std::string& table : files.ignored) {
    taken.findings.Add({Severity::kNote, StudyFinding::kTableIgnored, {}, Printable(table)});
  }
  return taken;
}

namespace {

// RMS of the readings at 0 V: root of their mean square
std::optional<double> DriveOffRms(const std::vector<DriveReading>& readings) {
  std::vector<double> off;
  for (const DriveReading& reading : readings) {
    if (reading.drive_v == 0) off.push_back(reading.rms_m);
  }
  return off.empty() ? std::nullopt : std::optional(dsp::Rms(off));
}

// line RMS = intercept + slope x drive, after subtraction of the floor in mean square
DriveLine LineOf(const std::vector<DriveReading>& readings, const std::optional<double>& floor_m) {
  DriveLine line;
  line.subject = readings.front().subject;
  line.condition = readings.front().condition;
  // a stated floor overrides the readings at 0 V
  line.floor_m = floor_m ? floor_m : DriveOffRms(readings);
  const double floor_power = line.floor_m ? *line.floor_m * *line.floor_m : 0;
  for (const DriveReading& reading : readings) {
    if (reading.drive_v == 0) continue;
    const double power = reading.rms_m * reading.rms_m - floor_power;
    // at or below the floor no amplitude remains; counted
    if (!(power > 0)) {
      ++line.below_floor;
      continue;
    }
    line.drive_v.push_back(reading.drive_v);
    line.rms_m.push_back(std::sqrt(power));
  }
  // straight line, and parabola for the test of curvature
  line.line = dsp::FitLine(line.drive_v, line.rms_m);
  line.curvature = dsp::FitCurvature(line.drive_v, line.rms_m);
  // full scale: value of the line at the highest drive, m
  if (line.line) {
    const double highest = *std::ranges::max_element(line.drive_v);
    line.full_scale_m = line.line->intercept + line.line->slope * highest;
  }
  return line;
}

}  // namespace

LinearityResult AnalyzeLinearity(const std::vector<DriveReading>& readings,
                                 const std::optional<double>& floor_m) {
  // a line per condition and subject
  std::map<std::pair<std::string, std::string>, std::vector<DriveReading>> groups;
  for (const DriveReading& reading : readings) {
    groups[{reading.condition, reading.subject}].push_back(reading);
  }
  LinearityResult result;
  std::map<std::string, std::vector<double>> slopes;
  std::map<std::string, std::vector<double>> curvatures;
  for (const auto& [name, group] : groups) {
    result.lines.push_back(LineOf(group, floor_m));
    const auto& line = result.lines.back().line;
    if (line) slopes[name.first].push_back(line->slope);
    const auto& curvature = result.lines.back().curvature;
    if (curvature) curvatures[name.first].push_back(curvature->quadratic);
  }
  std::ranges::sort(result.lines, {}, [](const DriveLine& line) {
    return std::pair(NaturalKey(line.condition), NaturalKey(line.subject));
  });
  // means over subjects need two lines of a condition
  for (const auto& [condition, values] : slopes) {
    if (values.size() < 2) continue;
    result.slopes.push_back({condition, dsp::TestMean(values), {}});
    const std::vector<double>& bends = curvatures[condition];
    if (bends.size() >= 2) result.slopes.back().curvature_m_per_v2 = dsp::TestMean(bends);
  }
  return result;
}

// --- the document ---

namespace {

constexpr double kUm = 1e-6;  // in metres

constexpr document::Unit kMetrePerSquareVolt{
    "_m_per_v2", "m/V^2", {{{1e6, "um/V^2"}, {1e3, "mm/V^2"}}}};

// keys of a line and of a mean over subjects
constexpr Key kSlope{"slope_m_per_v", "slope", document::kMetrePerVolt, Form::kInterval};
constexpr Key kCurvature{"curvature_m_per_v2", "curvature", kMetrePerSquareVolt, Form::kInterval};
constexpr Key kCurvatureP{"curvature_p"};

// condition and subject, as far as they are stated
std::string NameOf(const DriveLine& line) {
  std::string name = line.condition;
  if (!line.subject.empty()) name += (name.empty() ? "subject " : ", subject ") + line.subject;
  return name.empty() ? "drive sweep" : name;
}

// a fitted value with its t interval; u = half width / t(df)
Item& AddFitted(Section& section, const Key& key, double value, const dsp::Interval& interval,
                double df) {
  Item& item = section.Add(key, value, StandardUncertaintyOf(interval, df));
  item.interval = interval;
  return item;
}

// slope, value at 0 V and deviations; all not known where there is no line
Section FitSection(const DriveLine& line) {
  // without a line: n = 3 gives the interval a degree of freedom, and all is marked as not known
  const dsp::Line fit = line.line.value_or(dsp::Line{.n = 3});
  const auto df = static_cast<double>(fit.n - 2);
  // deviations below 1e-6 of full scale are rounding
  const double resolution_m = std::abs(line.full_scale_m) * 1e-6;
  Section section{.is_known = line.line.has_value()};
  AddFitted(section, kSlope, fit.slope, fit.slope_interval, df);
  AddFitted(section, {"intercept_m", "RMS at 0 V", document::kMetre, Form::kInterval},
            fit.intercept, fit.intercept_interval, df)
      .resolution = resolution_m;
  section.Add({"r_squared", "R^2"}, fit.r_squared);
  const double deviation_resolution_m =
      std::max(resolution_m, ResolutionBy(fit.residual_deviation));
  section
      .Add({"residual_deviation_m", "residual standard deviation", document::kMetre},
           fit.residual_deviation)
      .resolution = deviation_resolution_m;
  Item& largest = section.Add({"largest_deviation_m", "largest deviation", document::kMetre},
                              fit.largest_deviation);
  largest.resolution = deviation_resolution_m;
  // full scale: the line's value at the highest drive
  const double of_full_scale = fit.largest_deviation / std::abs(line.full_scale_m);
  largest.note = fmt::format("{:.2g} % of full scale", 100 * of_full_scale);
  section.Add({"largest_deviation_of_full_scale"}, of_full_scale);
  return section;
}

Section CurvatureSection(const std::optional<dsp::Curvature>& curvature) {
  const dsp::Curvature known = curvature.value_or(dsp::Curvature{.df = 1});
  Section section{.is_known = curvature.has_value()};
  // points without residuals leave no scatter for a test
  AddFitted(section, kCurvature, known.quadratic, known.interval, known.df).note =
      known.p ? fmt::format("t({:g}) = {:.4g}, p = {:.3g}", known.df, *known.t, *known.p)
              : "not tested, as all points are on the parabola";
  section.Add({"curvature_t"}, known.t);
  section.Add({"curvature_df"}, known.df);
  section.Add(kCurvatureP, known.p);
  return section;
}

// no floor, readings at or below it, too few readings for line or curvature
StudyFindings FindingsOf(const DriveLine& line) {
  StudyFindings findings;
  const auto add = [&](Severity severity, StudyFinding kind, std::size_t readings) {
    findings.Add({severity, kind, {{"readings", readings}}, NameOf(line)});
  };
  if (!line.floor_m) findings.Add({Severity::kNote, StudyFinding::kNoFloor, {}, NameOf(line)});
  if (line.below_floor > 0) {
    add(Severity::kNote, StudyFinding::kReadingsBelowFloor, line.below_floor);
  }
  if (!line.line) {
    add(Severity::kRefusal, StudyFinding::kTooFewReadings, line.rms_m.size());
  } else if (!line.curvature) {
    add(Severity::kNote, StudyFinding::kCurvatureNotDetermined, line.rms_m.size());
  }
  return findings;
}

Section LineSection(const DriveLine& line) {
  Section section{.heading = NameOf(line)};
  section.Add({document::kSubject.name}, TextOrNotKnown(line.subject));
  section.Add({kCondition.name}, TextOrNotKnown(line.condition));
  section.Add(document::kReadings, line.rms_m.size());
  section.Add({"below_floor"}, line.below_floor);
  section.Add({"floor_m", "noise correction", document::kMetre}, line.floor_m).note =
      "RMS, subtracted in mean square";
  section.Add({"drive_v"}, line.drive_v);
  section.Add(document::kRms, line.rms_m);
  section.sections = {FitSection(line), CurvatureSection(line.curvature)};
  document::AddFindings(section, FindingsOf(line));
  return section;
}

// one slope per subject: mean with its t interval
Section SlopeSection(const SlopeOverSubjects& over) {
  const auto bend = over.curvature_m_per_v2.value_or(dsp::OneSample{});
  Section section{.heading = fmt::format("{}{}mean over subjects", over.condition,
                                         over.condition.empty() ? "" : ", ")};
  section.Add({kCondition.name}, TextOrNotKnown(over.condition));
  section.Add(kSubjects, over.slope_m_per_v.n);
  AddMean(section, kSlope, over.slope_m_per_v);
  Item& curvature = AddMean(section, kCurvature, bend);
  if (bend.test) curvature.note = fmt::format("p = {:.3g}", bend.test->p);
  section.Add(kCurvatureP, MemberOf(bend.test, &dsp::StudentTest::p));
  return section;
}

// the names in the lines, each once
std::vector<std::string> NamesOf(const LinearityResult& result, std::string DriveLine::* name) {
  std::set<std::string> names;
  for (const DriveLine& line : result.lines) names.insert(line.*name);
  return {names.begin(), names.end()};
}

}  // namespace

document::Document LinearityDocument(const LinearityResult& result, bool has_figures) {
  document::Document document{.verb = "study", .title = "RMS = RMS at 0 V + slope x drive"};
  Section& root = document.root;
  root.sources = result.sources;
  root.sections = {
      ListOf({.name = "lines", .shape = Section::Shape::kArray}, result.lines, LineSection),
      ListOf({.name = "over_subjects", .shape = Section::Shape::kArray}, result.slopes,
             SlopeSection)};
  if (has_figures) {
    root.figures = {{.caption = "RMS against drive", .panels = LinearityPanels(result)}};
  }
  StudyFindings findings = result.findings;
  AddLabelsAlike("subject", NamesOf(result, &DriveLine::subject), findings);
  AddLabelsAlike("condition", NamesOf(result, &DriveLine::condition), findings);
  document::AddFindings(root, findings);
  return document;
}

std::vector<plot::Panel> LinearityPanels(const LinearityResult& result) {
  constexpr plot::Colour kColours[] = {plot::kBlue, plot::kOrange, plot::kGreen, plot::kPurple};
  plot::Panel panel;
  // the title states whether the noise was subtracted
  const bool is_corrected = std::ranges::any_of(
      result.lines, [](const DriveLine& line) { return line.floor_m.has_value(); });
  panel.title =
      is_corrected ? "readings corrected for noise, and their lines" : "readings and their lines";
  panel.x_label = "drive amplitude / V";
  panel.y_label = "RMS displacement / um";
  panel.y_from_zero = true;
  panel.x_from_zero = true;
  std::size_t number = 0;
  for (const DriveLine& line : result.lines) {
    const plot::Colour colour = kColours[number++ % std::size(kColours)];
    plot::Series points{NameOf(line), plot::Points(colour, 0.7), line.drive_v};
    for (const double rms_m : line.rms_m) points.y.push_back(rms_m / kUm);
    panel.series.push_back(std::move(points));
    if (!line.line) continue;
    // the line from 0 V to the highest drive
    const double high = *std::ranges::max_element(line.drive_v);
    const auto at = [&](double v) { return (line.line->intercept + line.line->slope * v) / kUm; };
    panel.series.push_back({"", plot::Lines(colour), {0, high}, {at(0), at(high)}});
  }
  return {panel};
}

}  // namespace haptometer::tools
