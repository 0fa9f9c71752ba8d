#include "dsp/statistics/paired.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// mean of (a - mean a)(b - mean b), with n - 1
double Covariance(std::span<const double> a, std::span<const double> b) {
  const double mean_a = Mean(a);
  const double mean_b = Mean(b);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
  return sum / (static_cast<double>(a.size()) - 1);
}

}  // namespace

OneSample ComparePairs(std::span<const double> a, std::span<const double> b) {
  HAPTOMETER_CHECK(a.size() == b.size() && !a.empty(), "{} and {} values", a.size(), b.size());
  std::vector<double> differences(a.size());
  std::ranges::transform(a, b, differences.begin(), std::minus<>());
  return TestMean(differences);
}

std::optional<GeometricRatio> RatioOfPairs(std::span<const double> a, std::span<const double> b) {
  HAPTOMETER_CHECK(a.size() == b.size() && !a.empty(), "{} and {} values", a.size(), b.size());
  const auto is_not_positive = [](double x) { return !(x > 0); };
  if (std::ranges::any_of(a, is_not_positive) || std::ranges::any_of(b, is_not_positive)) {
    return std::nullopt;
  }
  std::vector<double> logs(a.size());
  std::ranges::transform(a, b, logs.begin(), [](double x, double y) { return std::log(x / y); });
  GeometricRatio ratio;
  ratio.log_ratio = TestMean(logs);
  ratio.ratio = std::exp(ratio.log_ratio.mean);
  if (const auto& test = ratio.log_ratio.test) {
    ratio.interval = Interval{std::exp(test->mean.lower), std::exp(test->mean.upper)};
  }
  return ratio;
}

std::optional<RatioOfMeans> CompareMeans(std::span<const double> a, std::span<const double> b) {
  HAPTOMETER_CHECK(a.size() == b.size(), "{} and {} values", a.size(), b.size());
  if (a.size() < 2) return std::nullopt;
  const auto n = static_cast<double>(a.size());
  const double mean_a = Mean(a);
  const double mean_b = Mean(b);
  if (mean_b == 0) return std::nullopt;
  RatioOfMeans result{.ratio = mean_a / mean_b, .interval = std::nullopt};
  const double critical = StudentCritical(n - 1);
  const double c = critical * critical / n;
  const double square = mean_b * mean_b - c * Covariance(b, b);
  if (!(square > 0)) return result;  // unbounded
  const double half = mean_a * mean_b - c * Covariance(a, b);
  const double rest = mean_a * mean_a - c * Covariance(a, a);
  const double root = std::sqrt(std::max(0.0, half * half - square * rest));
  result.interval = Interval{(half - root) / square, (half + root) / square};
  return result;
}

}  // namespace haptometer::dsp
