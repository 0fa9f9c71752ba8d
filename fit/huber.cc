#include "fit/huber.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/statistics/repeated_measures.h"

namespace haptometer::fit {
namespace {

constexpr double kMedianOfNormal = 0.674489750196082;  // of |t|

double Weight(double t) {
  const double size = std::abs(t);
  return size > kHuberBend ? kHuberBend / size : 1;
}

}  // namespace

double RobustScale(std::span<const double> residuals) {
  std::vector<double> sizes(residuals.size());
  std::ranges::transform(residuals, sizes.begin(), [](double r) { return std::abs(r); });
  return dsp::Median(std::move(sizes)) / kMedianOfNormal;
}

std::vector<double> HuberRootWeights(std::span<const double> residuals, double scale) {
  std::vector<double> roots(residuals.size());
  std::ranges::transform(residuals, roots.begin(), [scale](double r) {
    return scale > 0 ? std::sqrt(Weight(r / scale)) : 1;
  });
  return roots;
}

double HuberVariance(std::span<const double> scaled_residuals, std::size_t parameters) {
  double weights = 0;
  double pull_squares = 0;
  double within = 0;
  for (const double t : scaled_residuals) {
    const double weight = Weight(t);
    weights += weight;
    pull_squares += weight * t * weight * t;
    within += std::abs(t) <= kHuberBend ? 1 : 0;
  }
  const auto count = static_cast<double>(scaled_residuals.size());
  const double degrees = std::max(count - static_cast<double>(parameters), 1.0);
  const double share = std::max(within, 1.0) / count;
  return weights / count * pull_squares / degrees / (share * share);
}

}  // namespace haptometer::fit
