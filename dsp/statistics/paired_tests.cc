#include "dsp/statistics/paired_tests.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

// covariance: sum of (a - mean a)(b - mean b) over n - 1
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
  // paired t of ln a - ln b; exp of its mean and interval gives the ratio
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
  // quadratic in rho: square rho^2 - 2 half rho + rest = 0, c = t_crit^2 / n
  const double critical = StudentCritical(n - 1);
  const double c = critical * critical / n;
  // mean(b) does not differ from zero: the ratio has no bounded interval
  const double square = mean_b * mean_b - c * Covariance(b, b);
  if (!(square > 0)) return result;  // unbounded
  const double half = mean_a * mean_b - c * Covariance(a, b);
  const double rest = mean_a * mean_a - c * Covariance(a, a);
  const double root = std::sqrt(std::max(0.0, half * half - square * rest));
  result.interval = Interval{(half - root) / square, (half + root) / square};
  return result;
}

double HedgesCorrection(double df) {
  HAPTOMETER_CHECK(df > 1, "{} degrees of freedom", df);
  // by logarithms, since Gamma overflows above 171
  return std::exp(std::lgamma(df / 2) - std::lgamma((df - 1) / 2)) / std::sqrt(df / 2);
}

std::optional<EffectSize> EffectOfPairs(std::span<const double> a, std::span<const double> b) {
  const OneSample difference = ComparePairs(a, b);
  if (difference.n < 3 || !difference.test) return std::nullopt;
  EffectSize effect;
  // d_z over the deviation of the differences, d_av over the mean of both deviations
  effect.d_z = difference.mean / *difference.standard_deviation;
  effect.hedges_g = HedgesCorrection(difference.test->df) * effect.d_z;
  effect.d_av = difference.mean / ((StandardDeviation(a) + StandardDeviation(b)) / 2);
  // noncentrality = effect sqrt(n), so the interval of the effect is that over sqrt(n)
  if (const auto delta = NoncentralityInterval(difference.test->t, difference.test->df)) {
    const double root = std::sqrt(static_cast<double>(difference.n));
    effect.interval = Interval{delta->lower / root, delta->upper / root};
  }
  return effect;
}

namespace {

// the sum with the signs of `flips`, bit i for value i
double SignedSum(std::span<const double> values, std::uint32_t flips) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += ((flips >> i) & 1U) != 0 ? -values[i] : values[i];
  }
  return sum;
}

}  // namespace

std::optional<double> SignFlipP(std::span<const double> differences) {
  const std::size_t n = differences.size();
  if (n == 0 || n > kMostSignFlips) return std::nullopt;
  // sums within 1e-12 of all magnitudes count as equal: they differ by rounding only
  double all = 0;
  for (const double difference : differences) all += std::abs(difference);
  const double reached = std::abs(SignedSum(differences, 0)) - 1e-12 * all;
  // the sign of the last value is kept: changing all signs changes no |sum|
  const std::uint32_t choices = 1U << (n - 1);
  std::uint32_t as_large = 0;
  for (std::uint32_t flips = 0; flips < choices; ++flips) {
    if (std::abs(SignedSum(differences, flips)) >= reached) ++as_large;
  }
  return static_cast<double>(as_large) / choices;
}

// p(k) = max over j <= k of min(1, (m - j + 1) p(j)), in order of size
std::vector<double> HolmAdjusted(std::span<const double> p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // equal p values come out alike in either order
  std::ranges::sort(order, {}, [&](std::size_t i) { return p[i]; });
  std::vector<double> adjusted(p.size());
  double largest = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double scaled = static_cast<double>(p.size() - k) * p[order[k]];
    largest = std::max(largest, std::min(1.0, scaled));
    adjusted[order[k]] = largest;
  }
  return adjusted;
}

std::vector<std::optional<double>> HolmOverTested(std::span<const std::optional<double>> p) {
  std::vector<double> tested;
  // tests without a p value neither count nor receive one
  tested.reserve(p.size());
  for (const std::optional<double>& one : p) {
    if (one) tested.push_back(*one);
  }
  const std::vector<double> of_tested = HolmAdjusted(tested);
  std::vector<std::optional<double>> adjusted(p.size());
  auto next = of_tested.begin();
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p[i]) adjusted[i] = *next++;
  }
  return adjusted;
}

}  // namespace haptometer::dsp
