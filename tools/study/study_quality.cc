#include "tools/study/study_quality.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "dsp/statistics/repeated_measures.h"
#include "tools/study/counted.h"

namespace haptometer::tools {
namespace {

// of an answered trial's RMS, as it states it
double RelativeUncertainty(const StudyTrial& trial) {
  return trial.rms_uncertainty_m.value_or(0) / *trial.rms_m;
}

double RelativeUncertainty(const StudyTable& table, const Cell& cell) {
  std::vector<double> all(cell.trials.size());
  std::ranges::transform(cell.trials, all.begin(),
                         [&](std::size_t i) { return RelativeUncertainty(table.trials[i]); });
  return dsp::Median(std::move(all));
}

void AppendOutlyingTrials(const StudyTable& table, std::vector<Outlying>& outlying) {
  std::vector<std::vector<double>> all;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    for (std::size_t c = 0; c < table.conditions.size(); ++c) all.push_back(table.Logs(s, c));
  }
  const double scatter = std::max(kLeastScatter, dsp::RobustWithinDeviation(all).value_or(0));
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    for (std::size_t c = 0; c < table.conditions.size(); ++c) {
      const std::vector<double>& logs = all[s * table.conditions.size() + c];
      if (logs.size() < 3) continue;
      const double median = dsp::Median(logs);
      for (std::size_t i = 0; i < logs.size(); ++i) {
        const StudyTrial& trial = table.trials[table.cells[s][c].trials[i]];
        const double scale = std::max(scatter, RelativeUncertainty(trial));
        const double score = std::abs(logs[i] - median) / scale;
        if (score <= kOutlyingScore) continue;
        outlying.push_back({table.subjects[s], table.conditions[c], trial.file,
                            std::exp(logs[i] - median), score});
      }
    }
  }
}

void AppendOutlyingCells(const StudyTable& table, std::vector<Outlying>& outlying) {
  std::vector<std::size_t> whole;
  dsp::CompleteTable medians = table.Complete(&Cell::mean_log, &whole);
  if (medians.subjects() < 4 || medians.conditions() < 3) return;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    for (std::size_t c = 0; c < medians.conditions(); ++c) {
      medians.At(row, c) = dsp::Median(table.Logs(whole[row], c));
    }
  }
  const dsp::CompleteTable left = dsp::MedianPolish(medians);
  const double scatter = std::max(kLeastScatter, dsp::DeviationOfPolished(left));
  for (std::size_t row = 0; row < whole.size(); ++row) {
    for (std::size_t c = 0; c < medians.conditions(); ++c) {
      const double scale =
          std::max(scatter, RelativeUncertainty(table, table.cells[whole[row]][c]));
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

std::vector<Deviation> FindDeviations(const StudyTable& table) {
  std::vector<Deviation> deviations;
  std::size_t answered = 0;
  for (const StudyTrial& trial : table.trials) {
    if (!trial.answered) continue;
    ++answered;
    for (const std::string& what : trial.deviations) {
      auto known = std::ranges::find(deviations, what, &Deviation::what);
      if (known == deviations.end()) known = deviations.insert(known, Deviation{what, {}, false});
      known->files.push_back(trial.file);
    }
  }
  for (Deviation& deviation : deviations) deviation.all = deviation.files.size() == answered;
  return deviations;
}

std::string Describe(const Deviation& deviation) {
  if (deviation.all && deviation.files.size() > 1) {
    return fmt::format("{}: all {} trials", deviation.what, deviation.files.size());
  }
  return fmt::format("{}: {}", deviation.what, fmt::join(deviation.files, ", "));
}

std::vector<Outlying> FindOutlying(const StudyTable& table) {
  std::vector<Outlying> outlying;
  AppendOutlyingTrials(table, outlying);
  AppendOutlyingCells(table, outlying);
  return outlying;
}

}  // namespace haptometer::tools
