#include "tools/study/contrast.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/nearest.h"
#include "dsp/statistics/multiple.h"
#include "dsp/statistics/permutation.h"

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
  std::vector<double> p;
  for (const Contrast& contrast : contrasts) {
    if (contrast.difference.test) p.push_back(contrast.difference.test->p);
  }
  const std::vector<double> adjusted = dsp::HolmAdjusted(p);
  auto next = adjusted.begin();
  for (Contrast& contrast : contrasts) {
    if (contrast.difference.test) contrast.p_holm = *next++;
  }
}

Error NoSuchCondition(const StudyTable& table, const std::string& name) {
  const std::string nearest = Nearest(name, table.conditions);
  return {Cause::kUsage, name, "is the condition of no trial",
          nearest.empty() ? fmt::format("the trials have {}", fmt::join(table.conditions, ", "))
                          : fmt::format("did you mean {}?", nearest)};
}

}  // namespace

Result<std::vector<Contrast>> CompareConditions(const StudyTable& table,
                                                const std::vector<PlannedContrast>& planned) {
  std::vector<Contrast> contrasts;
  contrasts.reserve(planned.size());
  for (const PlannedContrast& pair : planned) {
    const auto treatment = table.Condition(pair.treatment);
    const auto control = table.Condition(pair.control);
    if (!treatment) return std::unexpected(NoSuchCondition(table, pair.treatment));
    if (!control) return std::unexpected(NoSuchCondition(table, pair.control));
    contrasts.push_back(Compare(table, pair, *treatment, *control));
  }
  CorrectByHolm(contrasts);
  return contrasts;
}

std::vector<PlannedContrast> AllAgainstTheFirst(const StudyTable& table) {
  std::vector<PlannedContrast> planned;
  planned.reserve(table.conditions.size());
  for (std::size_t c = 1; c < table.conditions.size(); ++c) {
    planned.push_back({table.conditions[c], table.conditions[0]});
  }
  return planned;
}

}  // namespace haptometer::tools
