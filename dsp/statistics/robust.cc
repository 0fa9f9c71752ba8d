#include "dsp/statistics/robust.h"

#include <algorithm>
#include <cmath>

#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {

double Median(std::vector<double> values) {
  HAPTOMETER_CHECK(!values.empty(), "no values");
  std::ranges::sort(values);
  const std::size_t middle = values.size() / 2;
  if (values.size() % 2 == 1) return values[middle];
  return values[middle - 1] + (values[middle] - values[middle - 1]) / 2;
}

std::optional<double> RobustWithinDeviation(std::span<const std::vector<double>> cells) {
  std::vector<double> deviations;
  deviations.reserve(cells.size());
  for (const std::vector<double>& cell : cells) {
    if (cell.size() < 2) continue;
    const auto df = static_cast<double>(cell.size() - 1);
    deviations.push_back(StandardDeviation(cell) / std::sqrt(ChiSquareQuantile(0.5, df) / df));
  }
  if (deviations.empty()) return std::nullopt;
  const double median = Median(std::move(deviations));
  return median > 0 ? std::optional(median) : std::nullopt;
}

CompleteTable MedianPolish(const CompleteTable& table) {
  constexpr int kSweeps = 20;
  CompleteTable left = table;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t c = 0; c < left.conditions(); ++c) {
      const double effect = Median(left.Condition(c));
      for (std::size_t s = 0; s < left.subjects(); ++s) left.At(s, c) -= effect;
    }
    for (std::size_t s = 0; s < left.subjects(); ++s) {
      const auto values = left.Subject(s);
      const double effect = Median({values.begin(), values.end()});
      for (std::size_t c = 0; c < left.conditions(); ++c) left.At(s, c) -= effect;
    }
  }
  return left;
}

double DeviationFromMedianAbsolute(std::span<const double> values) {
  constexpr double kNormal = 1.482602218505602;  // 1 / the 75 % point of the normal distribution
  std::vector<double> sizes(values.size());
  std::ranges::transform(values, sizes.begin(), [](double x) { return std::abs(x); });
  return kNormal * Median(std::move(sizes));
}

}  // namespace haptometer::dsp
