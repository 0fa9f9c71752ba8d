#include <algorithm>
#include <cmath>
#include <set>

#include "dsp/statistics/moments.h"
#include "dsp/statistics/paired_tests.h"
#include "dsp/statistics/regression.h"
#include "dsp/statistics/repeated_measures.h"
#include "tools/study/study_table.h"

namespace haptometer::tools {
namespace {

// one value a subject that has both conditions
struct Pairs {
  std::vector<double> treatment;
  std::vector<double> control;
};

std::vector<double> Differences(const Pairs& pairs) {
  std::vector<double> differences(pairs.treatment.size());
  std::ranges::transform(pairs.treatment, pairs.control, differences.begin(), std::minus<>());
  return differences;
}

Contrast Compare(const StudyTable& table, const PlannedContrast& planned, std::size_t treatment,
                 std::size_t control) {
  Contrast contrast;
  contrast.planned = planned;
  Pairs means;
  Pairs geometric;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    const Cell& a = table.cells[s][treatment];
    const Cell& b = table.cells[s][control];
    if (a.rms_m.empty() || b.rms_m.empty()) {
      contrast.left_out.push_back(table.subjects[s]);
      continue;
    }
    means.treatment.push_back(*a.mean_m());
    means.control.push_back(*b.mean_m());
    geometric.treatment.push_back(std::exp(*a.mean_log()));
    geometric.control.push_back(std::exp(*b.mean_log()));
  }
  if (means.treatment.empty()) return contrast;
  contrast.difference = dsp::ComparePairs(means.treatment, means.control);
  contrast.ratio = dsp::RatioOfPairs(geometric.treatment, geometric.control);
  contrast.effect = dsp::EffectOfPairs(means.treatment, means.control);
  contrast.ratio_of_means = dsp::CompareMeans(means.treatment, means.control);
  contrast.sign_flip_p = dsp::SignFlipP(Differences(means));
  return contrast;
}

void CorrectByHolm(std::vector<Contrast>& contrasts) {
  std::vector<std::optional<double>> p(contrasts.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (const auto& test = contrasts[i].difference.test) p[i] = test->p;
  }
  const auto adjusted = dsp::HolmOverTested(p);
  for (std::size_t i = 0; i < p.size(); ++i) contrasts[i].p_holm = adjusted[i];
}

}  // namespace

Result<std::vector<Contrast>> CompareConditions(const StudyTable& table,
                                                const std::vector<PlannedContrast>& planned) {
  std::vector<Contrast> contrasts;
  contrasts.reserve(planned.size());
  for (const PlannedContrast& pair : planned) {
    if (auto known = CheckConditions(pair, table.conditions); !known) {
      return std::unexpected(known.error());
    }
    contrasts.push_back(
        Compare(table, pair, *table.Condition(pair.treatment), *table.Condition(pair.control)));
  }
  CorrectByHolm(contrasts);
  return contrasts;
}

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

Result<void> StudyResult::Compare(const std::vector<PlannedContrast>& wanted) {
  planned = !wanted.empty();
  auto compared = CompareConditions(table, planned ? wanted : AllAgainstTheFirst(table.conditions));
  if (!compared) return std::unexpected(compared.error());
  contrasts = *std::move(compared);
  missing = FindMissing(table);
  outlying = FindOutlying(table);
  further = DescribeFurther(table);
  return {};
}

}  // namespace haptometer::tools
