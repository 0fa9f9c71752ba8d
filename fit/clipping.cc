#include "fit/clipping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace haptometer::fit {
namespace {

constexpr std::size_t kMostCodes = 4096;
constexpr double kCodeTolerance = 0.1;  // of a step: printed decimals round
constexpr double kFewSamples = 2;

std::vector<double> DistinctValues(const std::vector<double>& values) {
  std::vector<double> distinct;
  distinct.reserve(values.size());
  std::ranges::copy_if(values, std::back_inserter(distinct),
                       [](double v) { return std::isfinite(v); });
  std::ranges::sort(distinct);
  distinct.erase(std::ranges::unique(distinct).begin(), distinct.end());
  return distinct;
}

// the most samples at `extreme` within half a period, and in all
struct AtExtreme {
  std::size_t most_together = 0;
  std::size_t all = 0;
};

AtExtreme CountAt(const std::vector<double>& values, double extreme, double period_samples) {
  const auto half = static_cast<std::size_t>(std::max(period_samples / 2, 1.0));
  AtExtreme count;
  std::size_t together = 0;
  for (std::size_t n = 0; n < values.size(); ++n) {
    const bool leaves = n >= half && values[n - half] == extreme;
    together += (values[n] == extreme ? 1U : 0U);
    together -= leaves ? 1U : 0U;
    count.all += values[n] == extreme ? 1U : 0U;
    count.most_together = std::max(count.most_together, together);
  }
  return count;
}

// of all values' differences; 0 where they are no multiples of one, or are too many
double StepBetween(const std::vector<double>& distinct) {
  if (distinct.size() < 2 || distinct.size() > kMostCodes) return 0;
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < distinct.size(); ++k) {
    step = std::min(step, distinct[k] - distinct[k - 1]);
  }
  for (std::size_t k = 1; k < distinct.size(); ++k) {
    const double steps = (distinct[k] - distinct[k - 1]) / step;
    if (std::abs(steps - std::round(steps)) > kCodeTolerance) return 0;
  }
  return step;
}

}  // namespace

double ConverterStep(const std::vector<double>& values_v) {
  return StepBetween(DistinctValues(values_v));
}

std::size_t MaskRails(std::vector<double>& values_v, double period_samples) {
  const auto distinct = DistinctValues(values_v);
  if (distinct.size() < 3) return 0;
  const double step = StepBetween(distinct);
  const double rest = distinct[distinct.size() / 2];
  std::size_t masked = 0;
  for (const double extreme : {distinct.front(), distinct.back()}) {
    const auto count = CountAt(values_v, extreme, period_samples);
    const double amplitude = std::abs(extreme - rest);
    const double share = std::min(step / std::max(amplitude, step), 1.0);
    const double natural =
        step > 0 ? std::acos(1 - share) * period_samples / std::numbers::pi : 0.0;
    const bool together = static_cast<double>(count.most_together) > natural + kFewSamples;
    const bool unrounded = step == 0 && static_cast<double>(count.all) > kFewSamples;
    if (!together && !unrounded) continue;
    masked += count.all;
    std::ranges::replace(values_v, extreme, std::nan(""));
  }
  return masked;
}

}  // namespace haptometer::fit
