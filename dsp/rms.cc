#include "dsp/rms.h"

#include <cmath>

#include "base/check.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kBlock = 128;

// sum of term(x), split at a fixed grid so that only the values decide the rounding
template <typename Term>
double PairwiseSum(std::span<const double> values, const Term& term) {
  if (values.size() <= kBlock) {
    double sum = 0;
    for (const double value : values) sum += term(value);
    return sum;
  }
  const std::size_t blocks = (values.size() + kBlock - 1) / kBlock;
  const std::size_t left = blocks / 2 * kBlock;
  return PairwiseSum(values.first(left), term) + PairwiseSum(values.subspan(left), term);
}

}  // namespace

double Mean(std::span<const double> values) {
  HAPTOMETER_CHECK(!values.empty(), "no values");
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
  // what the rounded mean leaves
  const double rest = PairwiseSum(values, [mean](double x) { return x - mean; });
  return std::sqrt((squares - rest * rest / n) / (n - 1));
}

}  // namespace haptometer::dsp
