#include "dsp/statistics/reliability.h"

#include <cmath>

#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {

std::optional<Reliability> AssessRepeats(std::span<const std::vector<double>> cells) {
  if (cells.size() < 2 || cells[0].size() < 2) return std::nullopt;
  std::vector<double> means;
  means.reserve(cells.size());
  double within = 0;
  for (const std::vector<double>& cell : cells) {
    if (cell.size() != cells[0].size()) return std::nullopt;
    means.push_back(Mean(cell));
    for (const double value : cell) within += (value - means.back()) * (value - means.back());
  }
  const auto n = static_cast<double>(cells.size());
  const auto k = static_cast<double>(cells[0].size());
  within /= n * (k - 1);
  const double sd = StandardDeviation(means);
  if (!(within > 0)) return std::nullopt;
  const double f = k * sd * sd / within;
  const auto icc_of = [k](double ratio) { return (ratio - 1) / (ratio + k - 1); };
  constexpr double kUpper = (1 + kConfidence) / 2;
  Reliability reliability;
  reliability.icc = icc_of(f);
  reliability.interval = {icc_of(f / FisherQuantile(kUpper, n - 1, n * (k - 1))),
                          icc_of(f * FisherQuantile(kUpper, n * (k - 1), n - 1))};
  reliability.within_sd = std::sqrt(within);
  return reliability;
}

double VariationOfLogs(double sd) { return std::sqrt(std::expm1(sd * sd)); }

}  // namespace haptometer::dsp
