#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/statistics/distributions.h"
#include "tools/calibrate/calibration_answer.h"
#include "tools/document/keys.h"
#include "tools/fit/fit_document.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Item;
using document::Section;

constexpr document::Key kGainKey{"gain_m_per_v", "gain", document::kMetrePerVolt};
constexpr document::Unit kVoltPerVolt{"", "V/V", {{{1, "V/V"}}}};
constexpr document::Unit kSquareMetrePerVolt{"_m2_per_v", "m2/V", {{{1, "m2/V"}}}};

// value +- coverage u, and a relative uncertainty common to all points
void AddUncertain(Section& section, const document::Key& key, double value, double uncertainty,
                  double coverage, double common = 0) {
  Item& item = section.Add(key.As(Form::kInterval), value, std::hypot(uncertainty, common));
  const double half = std::hypot(coverage * uncertainty, dsp::kNormalCritical * common);
  item.interval = document::Range{value - half, value + half};
}

Section LineSection(const CalibrationAnswer& answer) {
  Section section;
  const fit::StraightLine& line = answer.fit.line;
  AddUncertain(section, kGainKey, line.slope, line.slope_uncertainty, line.coverage_95,
               answer.scale_uncertainty * std::abs(line.slope));
  AddUncertain(section, document::kOffsetM, line.intercept, line.intercept_uncertainty,
               line.coverage_95);
  Item& share = section.Add({"gain_relative_standard_uncertainty",
                             "relative standard uncertainty of the gain", document::kShare},
                            answer.RelativeUncertainty());
  ShowDigits(share, 2);
  share.note = answer.fit.is_curved ? "linearity included" : "";
  Item& farthest = section.Add({"nonlinearity_m", "largest deviation", document::kMetre},
                               answer.fit.nonlinearity);
  ShowDigits(farthest, 3);
  farthest.note = fmt::format("of {}", answer.NameOf(answer.fit.farthest));
  Item& difference =
      section.Add({"hysteresis_m", "rising less falling", document::kMetre, Form::kUncertain},
                  document::MemberOf(answer.fit.hysteresis, &fit::Hysteresis::difference));
  if (answer.fit.hysteresis) {
    difference.standard_uncertainty = answer.fit.hysteresis->standard_uncertainty;
  }
  section.Add(document::kPoints, answer.measured.points.size());
  const auto [least, most] = std::ranges::minmax(answer.measured.points, {}, &fit::LinePoint::x);
  section.Add({"calibrated_v", "range of the input", document::kVolt},
              document::Range{least.x, most.x});
  section.Add({"bad_above_v", "no reading above", document::kVolt}, answer.BadAboveV()).note =
      answer.BadAboveV() ? "the error level of a +-5 V output is 5.5 V" : "";
  return section;
}

// the amplifier as reference: its volts over those of the DAQ
Section DaqSection(const CalibrationAnswer& answer) {
  Section section{.is_known = answer.daq.has_value()};
  const fit::StraightLine line = answer.daq ? answer.daq->line : fit::StraightLine{};
  AddUncertain(section, {"daq_gain", "amplifier's volts per volt of the DAQ", kVoltPerVolt},
               line.slope, line.slope_uncertainty, line.coverage_95);
  AddUncertain(section, {"daq_offset_v", "and at 0 V of the DAQ", document::kVolt}, line.intercept,
               line.intercept_uncertainty, line.coverage_95);
  section.Add({"amplifier_head", "head"}, document::TextOrNotKnown(answer.measured.reference.head));
  section.Add(document::kSource, document::TextOrNotKnown(answer.measured.reference.source));
  return section;
}

Section DetailSection(const CalibrationAnswer& answer) {
  Section section{.detail = Detail::kAll};
  const fit::StraightLine& line = answer.fit.line;
  ShowDigits(section.Add({"gain_offset_covariance_m2_per_v", "covariance of gain and offset",
                          kSquareMetrePerVolt},
                         line.covariance),
             3);
  section.Add(document::kDegreesOfFreedom, line.degrees_of_freedom);
  section.Add({"gain_coverage_factor", "coverage factor"}, line.coverage_95);
  section.Add(document::kBirgeRatio, answer.measured.scatter == fit::Scatter::kStated
                                         ? document::Value(line.birge_ratio)
                                         : document::Value());
  section.Add({"local_gain_relative_standard_uncertainty",
               "by which the gain differs within the range", document::kShare},
              answer.fit.local_slope_uncertainty);
  section.Add({"sensor_averages", "averages of the sensor"}, answer.averaging.averages);
  section.Add({"sensor_sampling_s", "their period", document::kSecond},
              answer.averaging.sampling_s);
  return section;
}

Section CheckSection(const CalibrationAnswer& answer) {
  Section section{.name = "comparison",
                  .heading = "against the calibration file",
                  .is_known = answer.check.has_value()};
  if (!answer.check) return section;
  const CalibrationCheck& check = *answer.check;
  section.Add({document::kFile.name, "file"}, check.file);
  section.Add({kGainKey.name, "its gain", document::kMetrePerVolt}, check.stated.scale);
  section.Add({"gain_normalized_error", "normalised error of the gain (k = 2)"}, check.gain_error)
      .resolution = 0.01;
  section.Add({document::kAgrees.name, "agrees"}, check.Agrees());
  section.Add({"shift_m", "shift of the zero", document::kMetre}, check.shift_m);
  section.Add({"shift_normalized_error", "normalised error of it (k = 2)"}, check.shift_error)
      .resolution = 0.01;
  return section;
}

Section PointsSection(const CalibrationAnswer& answer) {
  Section table{.name = "calibration_points",
                .heading = "points",
                .shape = Section::Shape::kTable,
                .detail = Detail::kAll};
  for (std::size_t i = 0; i < answer.measured.points.size(); ++i) {
    const fit::LinePoint& point = answer.measured.points[i];
    Section row;
    row.Add({"displacement_m", "displacement", document::kMetre}, point.y);
    row.Add({"voltage_v", "input", document::kVolt}, point.x);
    ShowDigits(row.Add({"residual_m", "residual", document::kMetre}, answer.fit.line.residuals[i]),
               3);
    const int direction = answer.fit.directions[i];
    row.Add({"approached", "approached"}, direction == 0  ? document::Value()
                                          : direction > 0 ? document::Value("rising")
                                                          : document::Value("falling"));
    table.sections.push_back(std::move(row));
  }
  return table;
}

// points by how they were approached; `y` in the unit of the axis
template <typename Value>
void AddPointSeries(plot::Panel& panel, const CalibrationAnswer& answer, const Value& y) {
  plot::Series first{"first point", plot::Points(plot::kBlack, 0.7)};
  plot::Series rising{"rising", plot::Points(plot::kBlue, 0.7)};
  plot::Series falling{"falling", plot::Points(plot::kOrange, 0.7)};
  for (std::size_t i = 0; i < answer.measured.points.size(); ++i) {
    const int direction = answer.fit.directions[i];
    plot::Series& series = direction == 0 ? first : direction > 0 ? rising : falling;
    series.x.push_back(answer.measured.points[i].x);
    series.y.push_back(y(i));
  }
  for (plot::Series* series : {&first, &rising, &falling}) {
    if (!series->x.empty()) panel.series.push_back(std::move(*series));
  }
  if (!answer.fit.outliers) return;
  for (const auto& [point, distance] : answer.fit.outliers->points) {
    panel.series.push_back(
        {fmt::format("{}, off the others", answer.NameOf(point)),
         {.mark = plot::Mark::kPoints, .colour = plot::kBlack, .size = 1.6, .point = 6},
         {answer.measured.points[point].x},
         {y(point)}});
  }
}

// the points on their line, and below, with the same axis of the input, their distance from it
document::Figure CalibrationFigure(const CalibrationAnswer& answer) {
  constexpr int kSteps = 100;
  const fit::StraightLine& line = answer.fit.line;
  plot::Panel whole{.title = "calibration line",
                    .x_label = "input / V",
                    .y_label = "displacement / mm",
                    .has_margins = true};
  plot::Panel residuals{.title = "distance of the points from the line",
                        .x_label = "input / V",
                        .y_label = "residual / um",
                        .has_margins = true};
  plot::Series of_line{"line", plot::Lines(plot::kGrey)};
  plot::Series zero{"line", plot::Lines(plot::kGrey)};
  plot::Series upper{"95 % interval of the line", plot::Lines(plot::kDarkGrey, 1, 2)};
  plot::Series lower{"", plot::Lines(plot::kDarkGrey, 1, 2)};
  const auto [least, most] = std::ranges::minmax(answer.measured.points, {}, &fit::LinePoint::x);
  for (int k = 0; k <= kSteps; ++k) {
    const double x = std::lerp(least.x, most.x, static_cast<double>(k) / kSteps);
    const double half_m = line.coverage_95 * line.UncertaintyAt(x);
    for (plot::Series* series : {&of_line, &zero, &upper, &lower}) series->x.push_back(x);
    of_line.y.push_back(1e3 * (line.intercept + line.slope * x));
    zero.y.push_back(0);
    upper.y.push_back(1e6 * half_m);
    lower.y.push_back(-1e6 * half_m);
  }
  const double margin = (most.x - least.x) / 20;
  for (plot::Panel* panel : {&whole, &residuals}) {
    panel->x_range = {least.x - margin, most.x + margin};
  }
  whole.series = {std::move(of_line)};
  residuals.series = {std::move(zero), std::move(upper), std::move(lower)};
  AddPointSeries(whole, answer, [&](std::size_t i) { return 1e3 * answer.measured.points[i].y; });
  AddPointSeries(residuals, answer, [&](std::size_t i) { return 1e6 * line.residuals[i]; });
  return {.caption = "Points and residuals of the calibration. Excluded rows are not drawn.",
          .panels = {std::move(whole), std::move(residuals)}};
}

void AddPointFindings(Section& root, const CalibrationAnswer& answer) {
  const CalibrationPoints& measured = answer.measured;
  if (!measured.error_level.empty()) {
    root.Find(Severity::kDoubt, "error-level",
              fmt::format("+5.5 V is the error level of the amplifier's output (no target, or an "
                          "error), and off the line of the others: line {} excluded",
                          fmt::join(measured.error_level, ", ")),
              {{"points", measured.error_level.size()}});
  }
  if (!measured.at_rail.empty()) {
    root.Find(Severity::kDoubt, "at-rail",
              fmt::format("at the end of the DAQ's range: line {} excluded",
                          fmt::join(measured.at_rail, ", ")),
              {{"points", measured.at_rail.size()}});
  }
  if (!measured.windows) return;
  const ReferencePoints& windows = *measured.windows;
  if (windows.error_level > 0) {
    root.Find(Severity::kDoubt, "error-level",
              "the amplifier's output stood at +5.5 V, its error level (no target, or an error), "
              "which is no reading: {windows} window{windows s} excluded",
              {{"windows", windows.error_level}});
  }
  if (windows.at_rail > 0) {
    root.Find(Severity::kDoubt, "at-rail",
              "at the end of the DAQ's range: {windows} window{windows s} excluded",
              {{"windows", windows.at_rail}});
  }
  if (windows.points.size() < measured.wanted) {
    root.Find(Severity::kDoubt, "fewer-points", "{points} of {wanted} points were measured",
              {{"points", windows.points.size()}, {"wanted", measured.wanted}});
  }
  root.Find(Severity::kNote, "against-amplifier",
            "against the amplifier's own readings: its linearity and scale (see its data sheet) "
            "are in no uncertainty unless --reference-uncertainty states them");
}

// displacements that no laser sensor measures: of another unit
void AddReferenceFindings(Section& root, const CalibrationAnswer& answer) {
  constexpr double kMostRangeM = 2;
  const auto [least, most] = std::ranges::minmax(answer.measured.points, {}, &fit::LinePoint::y);
  const double range_m = most.y - least.y;
  if (range_m <= kMostRangeM) return;
  root.Find(Severity::kDoubt, "displacement-unit",
            "the displacements extend over {range_m}, more than a laser sensor measures: is the "
            "column in um? Name it displacement_um",
            {{"range_m", range_m}});
}

// the volts or millivolts of a DAQ as the other
void AddUnitFindings(Section& root, const CalibrationAnswer& answer) {
  constexpr double kMilli = 1e-3;
  // above the factor of any divider at a DAQ's input, below that of milli
  constexpr double kLargestRatio = 30;
  double most_v = 0;
  for (const fit::LinePoint& point : answer.measured.points) {
    most_v = std::max(most_v, std::abs(point.x));
  }
  if (answer.daq) {
    const double ratio = std::abs(answer.daq->line.slope);
    if (ratio > 1 / kLargestRatio && ratio < kLargestRatio) return;
    root.Find(
        Severity::kDoubt, "input-unit",
        fmt::format("the amplifier puts out {{ratio}} V for 1 V of the DAQ: --input must give "
                    "V, does it give {}?",
                    ratio < 1 ? "mV" : "another unit"),
        {{"ratio", ratio}});
  } else if (most_v > trial::kMostOutputV) {
    root.Find(Severity::kDoubt, "input-unit",
              "the input reaches {most_v}, more than an analog output gives: is the column in mV? "
              "Name it voltage_mv",
              {{"most_v", most_v}});
  } else if (most_v < kMilli * trial::kMostOutputV) {
    root.Find(Severity::kDoubt, "input-unit",
              "the input reaches {most_v} only, a thousandth of an analog output: is the column in "
              "V? Name it voltage_v",
              {{"most_v", most_v}});
  }
}

// a doubt each
void AddOutliers(Section& root, const CalibrationAnswer& answer) {
  const fit::Outliers& outliers = *answer.fit.outliers;
  const std::size_t count = outliers.points.size();
  const std::string those = count == 1 ? "it" : fmt::format("the {} such points", count);
  for (const fit::Outlier& outlier : outliers.points) {
    root.Find(Severity::kDoubt, "outlier",
              answer.NameOf(outlier.point) +
                  " lies {distance_m} from the line of the others, which scatter by {scatter_m}: a "
                  "typing error, or a target that slipped? The gain is {gain_m_per_v} with " +
                  those + " and {gain_without_m_per_v} without " + (count == 1 ? "it" : "them") +
                  "; correct it, or leave it out",
              {{"point", outlier.point + 1},
               {"distance_m", outlier.distance},
               {"scatter_m", outliers.scatter},
               {"gain_m_per_v", answer.fit.line.slope},
               {"gain_without_m_per_v", outliers.others.slope}});
  }
}

void AddFitFindings(Section& root, const CalibrationAnswer& answer) {
  const fit::CalibrationFit& fit = answer.fit;
  if (fit.outliers) AddOutliers(root, answer);
  if (fit.line.is_beyond_stated) {
    root.Find(Severity::kDoubt, "beyond-stated",
              "the points scatter {ratio} times as far as their stated uncertainties explain: the "
              "uncertainties are taken from the scatter",
              {{"ratio", fit.line.birge_ratio}});
  }
  if (answer.measured.scatter == fit::Scatter::kFromResiduals && !answer.daq) {
    root.Find(
        Severity::kNote, "scatter-of-voltage",
        "no uncertainties are stated: that of the displacements is neglected, and the noise of "
        "the voltage is the scatter about the line");
  }
  if (fit.is_curved) {
    root.Find(Severity::kDoubt, "curved",
              "the points lie on a curve: the gain differs by {share %} (RMS) within the range, "
              "which its uncertainty includes; a smaller range has less",
              {{"share", fit.local_slope_uncertainty}});
  }
  if (fit.slip) {
    root.Find(Severity::kDoubt, "slip",
              "from " + answer.NameOf(fit.slip->point) +
                  " on the points lie {step_m} off the line of those before: a target that "
                  "slipped? The gain is {gain_m_per_v} with all and {gain_without_m_per_v} by two "
                  "parallel lines; measure again",
              {{"point", fit.slip->point + 1},
               {"step_m", fit.slip->step},
               {"gain_m_per_v", fit.line.slope},
               {"gain_without_m_per_v", fit.slip->slope}});
  }
  if (fit.hysteresis && fit.hysteresis->is_significant) {
    root.Find(Severity::kDoubt, "hysteresis",
              "rising and falling points differ by {difference_m}: play of the stage, or a target "
              "that creeps; approach all points from one side",
              {{"difference_m", fit.hysteresis->difference}});
  }
  if (!answer.check) return;
  const CalibrationCheck& check = *answer.check;
  if (!check.gain_error) {
    root.Find(Severity::kRefusal, "check-not-determined",
              "{file}: whether its gain still holds is not determined: neither its points nor "
              "today's scatter, so that no difference is explained; state --voltage-uncertainty",
              {{"file", check.file}});
  } else if (!*check.Agrees()) {
    root.Find(Severity::kDoubt, "calibration-changed",
              fmt::format("{{file}}: its gain is no longer valid: |E_n| = {:.2f} > 1",
                          std::abs(*check.gain_error)),
              {{"file", check.file}, {"normalized_error", *check.gain_error}});
  }
  if (check.shift_error && !(std::abs(*check.shift_error) <= 1)) {
    root.Find(Severity::kDoubt, "zero-shifted",
              "the zero has shifted by {shift_m}, which changes positions and no vibration",
              {{"shift_m", check.shift_m}});
  }
}

}  // namespace

document::Document CalibrationDocument(const CalibrationAnswer& answer, const std::string& path) {
  document::Document document{.verb = "calibrate",
                              .title = fmt::format("Calibration from {}", path)};
  Section& root = document.root;
  if (answer.measured.windows) {
    root.sources = trial::SourcesOf(answer.measured.reference, {.closed = true});
  } else {
    root.sources = {document::DataSource::kImported};
  }
  root.sections = {LineSection(answer), DaqSection(answer), CheckSection(answer),
                   DetailSection(answer), PointsSection(answer)};
  root.figures.push_back(CalibrationFigure(answer));
  AddUnitFindings(root, answer);
  AddReferenceFindings(root, answer);
  AddPointFindings(root, answer);
  AddFitFindings(root, answer);
  return document;
}

}  // namespace haptometer::tools
