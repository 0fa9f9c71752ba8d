#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "tools/study/study_document.h"

// The figures of a study.

namespace haptometer::tools {
namespace {

constexpr double kUm = 1e-6;                                       // in metres
constexpr double kGap = std::numeric_limits<double>::quiet_NaN();  // ends a line
// contrasts side by side in a panel, so that their names have room
constexpr std::size_t kMostInPanel = 4;

// the ends of an axis that holds all of `values` and `always`, with a margin of 8 %; bars stand on
// their axis
std::pair<double, double> RangeOf(const std::vector<double>& values, double always, bool are_bars) {
  double least = always;
  double most = always;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  const double margin = 0.08 * (most - least);
  return {are_bars ? least : least - margin, most + margin};
}

// mean over subjects as a bar, with the standard deviation
void AddBar(const ConditionSummary& summary, double x, plot::Panel& panel) {
  panel.ticks.push_back({x, summary.name});
  if (summary.subjects.n == 0) return;
  plot::Series& bars = panel.series[0];
  bars.x.push_back(x);
  bars.y.push_back(summary.subjects.mean / kUm);
  if (const auto& sd = summary.subjects.standard_deviation) {
    plot::Series& deviations = panel.series[1];
    deviations.x.push_back(x);
    deviations.y.push_back(summary.subjects.mean / kUm);
    // half the length of the bar: one standard deviation
    deviations.y_error.push_back(*sd / kUm);
  }
}

// each subject's means in these conditions, joined by a line
void AddSubjects(const StudyResult& study, const std::vector<std::size_t>& conditions, double x,
                 plot::Panel& panel) {
  plot::Series& lines = panel.series[2];
  for (const auto& cells : study.table.cells) {
    for (std::size_t k = 0; k < conditions.size(); ++k) {
      const auto mean_m = cells[conditions[k]].mean_m();
      lines.x.push_back(x + static_cast<double>(k));
      lines.y.push_back(mean_m ? *mean_m / kUm : kGap);
    }
    lines.x.push_back(x);
    lines.y.push_back(kGap);
  }
}

// conditions of a contrast beside each other, a contrast beside the next
plot::Panel MeansPanel(const StudyResult& study,
                       const std::vector<std::vector<std::size_t>>& groups) {
  plot::Panel panel{.y_label = "RMS displacement / um"};
  panel.series = {
      {"mean over subjects", {.mark = plot::Mark::kBoxes, .colour = plot::kBlue}},
      {"standard deviation", {plot::Mark::kErrorBars, plot::kBlack, 1.5, 1, 0.7}},
      {"a subject, mean of its trials", {plot::Mark::kLinesPoints, plot::kOrange, 1, 1, 0.5}}};
  double x = 0;
  for (const std::vector<std::size_t>& conditions : groups) {
    AddSubjects(study, conditions, x, panel);
    for (const std::size_t condition : conditions) {
      AddBar(study.further.conditions[condition], x++, panel);
    }
    x += 0.6;
  }
  // a curve without points cannot be drawn
  std::erase_if(panel.series, [](const plot::Series& series) { return series.x.empty(); });
  return panel;
}

// value and 95 % interval of a contrast; nothing where it has no test
struct Interval {
  double value = 0;
  dsp::Interval ends;
};

std::optional<Interval> DifferenceUm(const Contrast& contrast) {
  const auto& test = contrast.difference.test;
  if (!test) return std::nullopt;
  return Interval{contrast.difference.mean / kUm, {test->mean.lower / kUm, test->mean.upper / kUm}};
}

std::optional<Interval> Ratio(const Contrast& contrast) {
  if (!contrast.ratio || !contrast.ratio->log_ratio.test) return std::nullopt;
  const dsp::OneSample& logs = contrast.ratio->log_ratio;
  return Interval{std::exp(logs.mean),
                  {std::exp(logs.test->mean.lower), std::exp(logs.test->mean.upper)}};
}

// the contrasts beside each other, with a line where there is no difference
template <typename IntervalOf>
plot::Panel IntervalsPanel(std::span<const Contrast> contrasts, std::string y_label,
                           double no_difference, const IntervalOf& interval_of) {
  plot::Panel panel{.y_label = std::move(y_label)};
  plot::Series none{"no difference", plot::Lines(plot::kDarkGrey, 1, 2)};
  plot::Series lines{"95 % interval", plot::Lines(plot::kBlue, 2)};
  plot::Series points{"", plot::Points(plot::kBlue, 0.8)};
  double x = 0;
  for (const Contrast& contrast : contrasts) {
    panel.ticks.push_back(
        {x, fmt::format("{}, n = {}", NameOf(contrast.planned), contrast.difference.n)});
    if (const auto interval = interval_of(contrast)) {
      lines.x.insert(lines.x.end(), {x, x, x});
      lines.y.insert(lines.y.end(), {interval->ends.lower, interval->ends.upper, kGap});
      points.x.push_back(x);
      points.y.push_back(interval->value);
    }
    x += 1;
  }
  none.x = {-0.5, x - 0.5};
  none.y = {no_difference, no_difference};
  panel.series = {std::move(none)};
  if (!points.x.empty()) panel.series.insert(panel.series.end(), {lines, points});
  return panel;
}

// one axis for the panels of a quantity
void Align(std::span<plot::Panel> panels, double always, bool are_bars) {
  std::vector<double> values;
  for (const plot::Panel& panel : panels) {
    for (const plot::Series& series : panel.series) {
      for (std::size_t k = 0; k < series.y.size(); ++k) {
        const double error = series.y_error.empty() ? 0 : series.y_error[k];
        values.insert(values.end(), {series.y[k] - error, series.y[k] + error});
      }
    }
  }
  for (plot::Panel& panel : panels) panel.y_range = RangeOf(values, always, are_bars);
}

}  // namespace

std::vector<plot::Panel> StudyPanels(const StudyResult& study) {
  std::vector<std::vector<std::size_t>> groups;
  groups.reserve(study.contrasts.size());
  for (const Contrast& contrast : study.contrasts) {
    groups.push_back({*study.table.Condition(contrast.planned.control),
                      *study.table.Condition(contrast.planned.treatment)});
  }
  // without contrasts: all conditions beside each other
  if (groups.empty()) {
    std::vector<std::size_t> all(study.table.conditions.size());
    for (std::size_t c = 0; c < all.size(); ++c) all[c] = c;
    return {MeansPanel(study, {all})};
  }
  const std::span<const Contrast> contrasts(study.contrasts);
  std::vector<plot::Panel> means;
  std::vector<plot::Panel> differences;
  std::vector<plot::Panel> ratios;
  for (std::size_t first = 0; first < groups.size(); first += kMostInPanel) {
    const std::size_t count = std::min(kMostInPanel, groups.size() - first);
    const auto begin = groups.begin() + static_cast<std::ptrdiff_t>(first);
    means.push_back(MeansPanel(study, {begin, begin + static_cast<std::ptrdiff_t>(count)}));
    differences.push_back(
        IntervalsPanel(contrasts.subspan(first, count), "mean difference / um", 0, DifferenceUm));
    ratios.push_back(
        IntervalsPanel(contrasts.subspan(first, count), "ratio of geometric means", 1, Ratio));
  }
  Align(means, 0, true);
  Align(differences, 0, false);
  Align(ratios, 1, false);
  for (auto* panels : {&differences, &ratios}) {
    means.insert(means.end(), panels->begin(), panels->end());
  }
  return means;
}

}  // namespace haptometer::tools
