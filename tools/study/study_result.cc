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

// values of the subjects that have both conditions, one per subject
struct Pairs {
  std::vector<double> treatment;
  std::vector<double> control;
};

std::vector<double> Differences(const Pairs& pairs) {
  std::vector<double> differences(pairs.treatment.size());
  std::ranges::transform(pairs.treatment, pairs.control, differences.begin(), std::minus<>());
  return differences;
}

// all statistics of one contrast, over subjects
Contrast Compare(const StudyTable& table, const PlannedContrast& planned, std::size_t treatment,
                 std::size_t control) {
  Contrast contrast;
  contrast.planned = planned;
  Pairs means;
  Pairs geometric;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    const Cell& a = table.cells[s][treatment];
    const Cell& b = table.cells[s][control];
    // a subject without one of the conditions is excluded and named
    if (a.rms_m.empty() || b.rms_m.empty()) {
      contrast.left_out.push_back(table.subjects[s]);
      continue;
    }
    // arithmetic means for the difference, geometric ones for the ratio
    means.treatment.push_back(*a.mean_m());
    means.control.push_back(*b.mean_m());
    geometric.treatment.push_back(std::exp(*a.mean_log()));
    geometric.control.push_back(std::exp(*b.mean_log()));
  }
  if (means.treatment.empty()) return contrast;
  // paired t of differences, paired t of logarithms, effect sizes, Fieller, sign flips
  contrast.difference = dsp::ComparePairs(means.treatment, means.control);
  contrast.ratio = dsp::RatioOfPairs(geometric.treatment, geometric.control);
  contrast.effect = dsp::EffectOfPairs(means.treatment, means.control);
  contrast.ratio_of_means = dsp::CompareMeans(means.treatment, means.control);
  contrast.sign_flip_p = dsp::SignFlipP(Differences(means));
  return contrast;
}

// Holm's step-down correction over the contrasts that have a test
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
  HAPTOMETER_TRY(CheckContrasts(planned, table.conditions));
  std::vector<Contrast> contrasts;
  contrasts.reserve(planned.size());
  for (const PlannedContrast& pair : planned) {
    contrasts.push_back(
        Compare(table, pair, *table.Condition(pair.treatment), *table.Condition(pair.control)));
  }
  CorrectByHolm(contrasts);
  return contrasts;
}

namespace {

// mean over subjects, geometric mean and reliability of repeats (ICC) of a condition
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

// a subject's trials in the order of their start; nothing where a start is missing or not unique
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
  // UTC in ISO 8601 sorts as text
  std::ranges::sort(order, {}, [&](std::size_t i) { return table.trials[i].utc_start; });
  return order;
}

// position of each trial in its subject's order, or within its cell by repeat without start times
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
        // shorter first, so that repeat 2 precedes repeat 10
        const std::string& repeat = table.trials[i].repeat;
        return std::pair(repeat.size(), repeat);
      });
      for (std::size_t i = 0; i < order.size(); ++i) places[order[i]] = static_cast<double>(i);
    }
  }
  return places;
}

// slope of ln(RMS) per trial, within cells, so that the conditions' means do not enter
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
  // one slope per subject: t test against 0
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
  // analysis of variance needs subjects with all conditions
  std::vector<std::size_t> whole;
  const dsp::CompleteTable means = table.Complete(&Cell::mean_m, &whole);
  further.whole_subjects = whole.size();
  further.anova = dsp::AnalyzeRepeatedMeasures(means);
  further.log_anova = dsp::AnalyzeRepeatedMeasures(table.Complete(&Cell::mean_log, &whole));
  // error bars within subjects (Morey): without the differences between subjects
  if (means.subjects() >= 2 && means.conditions() >= 2) {
    const std::vector<double> bars = dsp::MoreyHalfWidths(means);
    for (std::size_t c = 0; c < bars.size(); ++c) further.conditions[c].morey_m = bars[c];
  }
  further.trend = TrendOf(table);
  return further;
}

std::vector<Error> StudyResult::Errors() const {
  std::vector<Error> errors;
  for (const StudyTrial& trial : table.trials) {
    if (trial.error) errors.push_back(*trial.error);
  }
  errors.insert(errors.end(), changed.begin(), changed.end());
  return errors;
}

Result<void> StudyResult::Compare(std::vector<PlannedContrast> wanted,
                                  const std::vector<std::string>& expected) {
  planned = !wanted.empty();
  const auto has = [&](const std::string& name) { return table.Condition(name).has_value(); };
  const auto is_known = [&](const std::string& name) {
    return has(name) || std::ranges::count(expected, name) > 0;
  };
  std::erase_if(wanted, [&](const PlannedContrast& pair) {
    if (has(pair.treatment) && has(pair.control)) return false;
    if (!is_known(pair.treatment) || !is_known(pair.control)) return false;
    not_yet.push_back(pair);
    return true;
  });
  HAPTOMETER_LET(contrasts,
                 CompareConditions(table, planned ? wanted : AllAgainstTheFirst(table.conditions)));
  missing = FindMissing(table);
  outlying = FindOutlying(table);
  further = DescribeFurther(table);
  return {};
}

}  // namespace haptometer::tools
