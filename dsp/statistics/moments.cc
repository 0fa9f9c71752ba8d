#include "dsp/statistics/moments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

// terms that are summed before sums are added in pairs, and sums that run side by side
constexpr std::size_t kBlock = 128;
constexpr std::size_t kLanes = 8;

// sum of term(x): eight running sums in a block, blocks split at a fixed grid, all added in pairs
template <typename Term>
double PairwiseSum(std::span<const double> values, const Term& term) {
  if (values.size() <= kBlock) {
    std::array<double, kLanes> sums{};
    std::size_t k = 0;
    for (; k + kLanes <= values.size(); k += kLanes) {
// unrolled, the sums stay in registers
#pragma GCC unroll 8
      for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] += term(values[k + lane]);
    }
    for (; k < values.size(); ++k) sums[k % kLanes] += term(values[k]);
    return ((sums[0] + sums[1]) + (sums[2] + sums[3])) +
           ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  }
  // split on the grid of whole blocks
  const std::size_t blocks = (values.size() + kBlock - 1) / kBlock;
  const std::size_t left = blocks / 2 * kBlock;
  return PairwiseSum(values.first(left), term) + PairwiseSum(values.subspan(left), term);
}

}  // namespace

double Mean(std::span<const double> values) {
  HAPTOMETER_CHECK(!values.empty(), "no values");
  // the mean of the deviations from the rough mean corrects its rounding
  const auto n = static_cast<double>(values.size());
  const double rough = PairwiseSum(values, [](double x) { return x; }) / n;
  return rough + PairwiseSum(values, [rough](double x) { return x - rough; }) / n;
}

double Rms(std::span<const double> values) {
  HAPTOMETER_CHECK(!values.empty(), "no values");
  const double squares = PairwiseSum(values, [](double x) { return x * x; });
  return std::sqrt(squares / static_cast<double>(values.size()));
}

double StandardDeviation(std::span<const double> values) {
  HAPTOMETER_CHECK(values.size() >= 2, "{} values", values.size());
  const auto n = static_cast<double>(values.size());
  const double mean = Mean(values);
  const double squares = PairwiseSum(values, [mean](double x) { return (x - mean) * (x - mean); });
  // correction for the rounding of the mean: sum (x - mean) is not exactly zero
  const double rest = PairwiseSum(values, [mean](double x) { return x - mean; });
  return std::sqrt((squares - rest * rest / n) / (n - 1));
}

OneSample TestMean(std::span<const double> values) {
  OneSample sample{.n = values.size(), .mean = Mean(values)};
  // one value has no scatter, equal values no test
  if (sample.n < 2) return sample;
  sample.standard_deviation = StandardDeviation(values);
  if (!(*sample.standard_deviation > 0)) return sample;
  // t = mean / (s / sqrt(n)), interval mean +- t_crit s / sqrt(n)
  const auto n = static_cast<double>(sample.n);
  const double error = *sample.standard_deviation / std::sqrt(n);
  const double reach = StudentCritical(n - 1) * error;
  const double t = sample.mean / error;
  sample.test = {t, n - 1, StudentTwoSidedP(t, n - 1), {sample.mean - reach, sample.mean + reach}};
  return sample;
}

}  // namespace haptometer::dsp
