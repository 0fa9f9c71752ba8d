#include "tools/study/study_quality.h"

#include <cmath>

#include "dsp/statistics/robust.h"

namespace haptometer::tools {
namespace {

void AppendOutlyingTrials(const StudyTable& table, std::vector<Outlying>& outlying) {
  std::vector<std::vector<double>> all;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    for (std::size_t c = 0; c < table.conditions.size(); ++c) all.push_back(table.Logs(s, c));
  }
  const auto deviation = dsp::RobustWithinDeviation(all);
  if (!deviation) return;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    for (std::size_t c = 0; c < table.conditions.size(); ++c) {
      const std::vector<double>& logs = all[s * table.conditions.size() + c];
      if (logs.size() < 3) continue;
      const double median = dsp::Median(logs);
      for (std::size_t i = 0; i < logs.size(); ++i) {
        const double score = std::abs(logs[i] - median) / *deviation;
        if (score <= kOutlyingScore) continue;
        outlying.push_back({table.subjects[s], table.conditions[c],
                            table.trials[table.cells[s][c].trials[i]].file,
                            std::exp(logs[i] - median), score});
      }
    }
  }
}

void AppendOutlyingCells(const StudyTable& table, std::vector<Outlying>& outlying) {
  std::vector<std::size_t> whole;
  dsp::CompleteTable medians = table.Complete(&Cell::mean_log, &whole);
  const auto n = static_cast<double>(medians.subjects());
  const auto k = static_cast<double>(medians.conditions());
  if (n < 4 || k < 3) return;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    for (std::size_t c = 0; c < medians.conditions(); ++c) {
      medians.At(row, c) = dsp::Median(table.Logs(whole[row], c));
    }
  }
  const dsp::CompleteTable left = dsp::MedianPolish(medians);
  const double scale =
      dsp::DeviationFromMedianAbsolute(left.values()) * std::sqrt(n * k / ((n - 1) * (k - 1)));
  if (!(scale > 0)) return;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    for (std::size_t c = 0; c < medians.conditions(); ++c) {
      const double score = std::abs(left.At(row, c)) / scale;
      if (score <= kOutlyingScore) continue;
      outlying.push_back(
          {table.subjects[whole[row]], table.conditions[c], "", std::exp(left.At(row, c)), score});
    }
  }
}

}  // namespace

std::vector<MissingTrials> FindMissing(const StudyTable& table) {
  std::vector<MissingTrials> missing;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    for (std::size_t c = 0; c < table.conditions.size(); ++c) {
      const std::size_t answered = table.cells[s][c].trials.size();
      if (answered == table.repeats && answered > 0) continue;
      missing.push_back({table.subjects[s], table.conditions[c], answered, table.repeats});
    }
  }
  return missing;
}

std::vector<Outlying> FindOutlying(const StudyTable& table) {
  std::vector<Outlying> outlying;
  AppendOutlyingTrials(table, outlying);
  AppendOutlyingCells(table, outlying);
  return outlying;
}

}  // namespace haptometer::tools
