#include "fit/adapter/consensus_mean.h"

#include <algorithm>
#include <cmath>

namespace haptometer::fit {
namespace {

// the sums over w = 1/(u^2 + t^2)
struct Sums {
  double weights = 0;
  double mean = 0;
  double squares = 0;         // F = sum w (x - m)^2
  double weighted_twice = 0;  // -dF/dt^2 = sum w^2 (x - m)^2
};

Sums SumsWith(const std::vector<TapEstimate>& estimates, double between) {
  Sums sums;
  // an estimate without noise has a variance of rounding errors only
  const auto weight = [between](const TapEstimate& estimate) {
    return 1 / (std::max(estimate.variance, 1e-30) + between);
  };
  for (const TapEstimate& estimate : estimates) {
    const double w = weight(estimate);
    sums.weights += w;
    sums.mean += (estimate.value - sums.mean) * w / sums.weights;
  }
  for (const TapEstimate& estimate : estimates) {
    const double w = weight(estimate);
    const double part = w * std::pow(estimate.value - sums.mean, 2);
    sums.squares += part;
    sums.weighted_twice += w * part;
  }
  return sums;
}

}  // namespace

ConsensusMean ConsensusOf(const std::vector<TapEstimate>& estimates) {
  // the mean of weights 1/u^2, which is the answer where the noise explains the scatter
  Sums sums = SumsWith(estimates, 0);
  const double alone = 1 / sums.weights;
  ConsensusMean consensus{.value = sums.mean, .variance = alone};
  if (estimates.size() < 2) return consensus;
  const auto degrees = static_cast<double>(estimates.size() - 1);
  consensus.birge_ratio = std::sqrt(sums.squares / degrees);
  // Newton's steps for 1/F = 1/(n - 1): 1/F rises with t^2 and is concave, so that each step
  // approaches the root from below; for equal u, or two estimates, the first one reaches it
  constexpr int kMostSteps = 100;
  constexpr double kClose = 1e-12;
  double& between = consensus.between_variance;
  for (int step = 0; step < kMostSteps && sums.squares > degrees * (1 + kClose); ++step) {
    between += (sums.squares / degrees - 1) * sums.squares / sums.weighted_twice;
    sums = SumsWith(estimates, between);
  }
  consensus.value = sums.mean;
  consensus.variance = 1 / sums.weights;
  consensus.scatter_variance = consensus.variance - alone;
  return consensus;
}

}  // namespace haptometer::fit
