#include "tools/study/further_statistics.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "dsp/statistics/moments.h"
#include "dsp/statistics/regression.h"
#include "dsp/statistics/repeated_measures.h"

namespace haptometer::tools {
namespace {

ConditionSummary Summarize(const StudyTable& table, std::size_t condition) {
  ConditionSummary summary;
  summary.name = table.conditions[condition];
  std::vector<double> means;
  std::vector<double> logs;
  std::vector<std::vector<double>> cells;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    const Cell& cell = table.cells[s][condition];
    if (cell.rms_m.empty()) continue;
    summary.trials += cell.trials.size();
    means.push_back(*cell.mean_m());
    logs.push_back(*cell.mean_log());
    cells.push_back(table.Logs(s, condition));
  }
  if (means.empty()) return summary;
  summary.subjects = dsp::TestMean(means);
  summary.geometric_m = std::exp(dsp::Mean(logs));
  summary.repeats = dsp::AssessRepeats(cells);
  return summary;
}

// the trials of a subject in the order of their start, or nothing where one has none
std::optional<std::vector<std::size_t>> ByStart(const StudyTable& table, std::size_t subject) {
  std::vector<std::size_t> order;
  std::set<std::string> starts;
  for (const Cell& cell : table.cells[subject]) {
    for (const std::size_t trial : cell.trials) {
      const std::string& start = table.trials[trial].utc_start;
      if (start.empty() || !starts.insert(start).second) return std::nullopt;
      order.push_back(trial);
    }
  }
  std::ranges::sort(order, {}, [&](std::size_t i) { return table.trials[i].utc_start; });
  return order;
}

// place of each trial in its subject's order; by repeats where a start is not known
std::vector<double> PlacesOf(const StudyTable& table, bool* by_start) {
  std::vector<double> places(table.trials.size());
  *by_start = true;
  for (std::size_t s = 0; s < table.subjects.size() && *by_start; ++s) {
    const auto order = ByStart(table, s);
    *by_start = order.has_value();
    for (std::size_t i = 0; *by_start && i < order->size(); ++i) {
      places[(*order)[i]] = static_cast<double>(i);
    }
  }
  if (*by_start) return places;
  for (const auto& row : table.cells) {
    for (const Cell& cell : row) {
      std::vector<std::size_t> order = cell.trials;
      std::ranges::sort(order, {}, [&](std::size_t i) {
        const std::string& repeat = table.trials[i].repeat;
        return std::pair(repeat.size(), repeat);
      });
      for (std::size_t i = 0; i < order.size(); ++i) places[order[i]] = static_cast<double>(i);
    }
  }
  return places;
}

// slope of ln(RMS) over place, both about their cell's mean
std::optional<double> SlopeOf(const StudyTable& table, std::size_t subject,
                              const std::vector<double>& places) {
  std::vector<dsp::Points> cells(table.conditions.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    cells[c].y = table.Logs(subject, c);
    for (const std::size_t i : table.cells[subject][c].trials) cells[c].x.push_back(places[i]);
  }
  return dsp::SlopeWithinGroups(cells);
}

std::optional<OrderTrend> TrendOf(const StudyTable& table) {
  OrderTrend trend;
  const std::vector<double> places = PlacesOf(table, &trend.by_start);
  std::vector<double> slopes;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    if (const auto slope = SlopeOf(table, s, places)) slopes.push_back(*slope);
  }
  if (slopes.empty()) return std::nullopt;
  trend.per_trial = dsp::TestMean(slopes);
  return trend;
}

}  // namespace

FurtherStatistics DescribeFurther(const StudyTable& table) {
  FurtherStatistics further;
  further.conditions.reserve(table.conditions.size());
  for (std::size_t c = 0; c < table.conditions.size(); ++c) {
    further.conditions.push_back(Summarize(table, c));
  }
  std::vector<std::size_t> whole;
  const dsp::CompleteTable means = table.Complete(&Cell::mean_m, &whole);
  further.whole_subjects = whole.size();
  further.anova = dsp::AnalyzeRepeatedMeasures(means);
  further.log_anova = dsp::AnalyzeRepeatedMeasures(table.Complete(&Cell::mean_log, &whole));
  if (means.subjects() >= 2 && means.conditions() >= 2) {
    const std::vector<double> bars = dsp::MoreyHalfWidths(means);
    for (std::size_t c = 0; c < bars.size(); ++c) further.conditions[c].morey_m = bars[c];
  }
  further.trend = TrendOf(table);
  return further;
}

}  // namespace haptometer::tools
