#include "tools/study/contrast.h"

#include <algorithm>
#include <cmath>

#include "dsp/statistics/paired_tests.h"

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

}  // namespace haptometer::tools
