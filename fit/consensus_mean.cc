#include "fit/consensus_mean.h"

#include <algorithm>
#include <cmath>

#include "dsp/statistics/distributions.h"
#include "fit/uncertainty.h"

namespace haptometer::fit {
namespace {

// the sums over w = 1/(u^2 + t^2)
struct Sums {
  double weights = 0;
  double mean = 0;
  double squares = 0;         // F = sum w (x - m)^2
  double weighted_twice = 0;  // -dF/dt^2 = sum w^2 (x - m)^2
};

Sums SumsWith(const std::vector<Estimate>& estimates, double between) {
  Sums sums;
  // an estimate without noise has a variance of rounding errors only
  const auto weight = [between](const Estimate& estimate) {
    return 1 / (std::max(estimate.variance, 1e-30) + between);
  };
  for (const Estimate& estimate : estimates) {
    const double w = weight(estimate);
    sums.weights += w;
    sums.mean += (estimate.value - sums.mean) * w / sums.weights;
  }
  for (const Estimate& estimate : estimates) {
    const double w = weight(estimate);
    const double part = w * std::pow(estimate.value - sums.mean, 2);
    sums.squares += part;
    sums.weighted_twice += w * part;
  }
  return sums;
}

// F and its slope, the groups' means being their own
Sums SumsOver(const std::vector<std::vector<Estimate>>& groups, double between) {
  Sums sums;
  for (const auto& group : groups) {
    const Sums own = SumsWith(group, between);
    sums.squares += own.squares;
    sums.weighted_twice += own.weighted_twice;
  }
  return sums;
}

}  // namespace

ConsensusMean ConsensusOf(const std::vector<Estimate>& estimates) {
  // the mean of weights 1/u^2, which is the answer where the noise explains the scatter
  const Sums alone = SumsWith(estimates, 0);
  ConsensusMean consensus{.value = alone.mean, .variance = 1 / alone.weights};
  if (estimates.size() < 2) return consensus;
  const auto degrees = static_cast<double>(estimates.size() - 1);
  consensus.birge_ratio = std::sqrt(alone.squares / degrees);
  consensus.between_variance = BetweenVariance({estimates}, degrees);
  const Sums sums = SumsWith(estimates, consensus.between_variance);
  consensus.value = sums.mean;
  consensus.variance = 1 / sums.weights;
  consensus.scatter_variance = consensus.variance - 1 / alone.weights;
  return consensus;
}

double SquaresOf(const std::vector<std::vector<Estimate>>& groups, double between_variance) {
  return SumsOver(groups, between_variance).squares;
}

double BetweenVariance(const std::vector<std::vector<Estimate>>& groups, double squares) {
  // Newton's steps for 1/F: it rises with t^2 and is concave, so that each step approaches the root
  // from below; for one group of equal u, or of two estimates, the first one reaches it
  constexpr int kMostSteps = 100;
  constexpr double kClose = 1e-12;
  double between = 0;
  Sums sums = SumsOver(groups, between);
  for (int step = 0; step < kMostSteps && sums.squares > squares * (1 + kClose); ++step) {
    between += (sums.squares / squares - 1) * sums.squares / sums.weighted_twice;
    sums = SumsOver(groups, between);
  }
  return between;
}

double StudentSquares(double degrees) {
  return degrees * std::pow(kCoverage95 / dsp::StudentCritical(degrees), 2);
}

}  // namespace haptometer::fit
