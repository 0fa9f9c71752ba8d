#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/document/keys.h"
#include "tools/study/study_document.h"

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
  AddRounded(section, {"residual_deviation_m", "residual standard deviation", document::kMetre},
             fit.residual_deviation, deviation_resolution_m);
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
