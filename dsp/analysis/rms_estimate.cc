#include "dsp/analysis/rms_estimate.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "dsp/statistics/distributions.h"

namespace haptometer::dsp {
namespace {

constexpr double kNormal90 = 1.6448536269514722;  // two-sided; one-sided 95 %
// of a density that is the mean of 48 bins
constexpr double kToneDegrees = 96;

// chi-squared is normal then, to 1e-3 of a standard deviation
constexpr double kManyDegrees = 1e6;

// distances of a value's limits below and above it
struct Reach {
  double below = 0;
  double above = 0;
};

// quantile of the normal distribution for the two tails in use, 0.025 and 0.05
double NormalOf(double probability) { return probability < 0.04 ? kNormalCritical : kNormal90; }

// No periodogram has fewer degrees of freedom than its one line would (band_noise.h). Where mean
// square and variance give fewer, the mean square is a difference of larger numbers, and the
// variance alone determines the limits.
constexpr double kLeastDegrees = 4;

// limits of a noise power by chi-squared; `probability` is that of either tail
Reach ReachOf(const NoisePower& power, double probability) {
  if (!(power.variance > 0)) return {};
  // mean^2 = degrees / 2 variance: the mean that has kLeastDegrees
  const NoisePower own{std::max(power.mean_square, std::sqrt(kLeastDegrees / 2 * power.variance)),
                       power.variance};
  const double degrees = own.degrees_of_freedom();
  if (degrees > kManyDegrees) {
    const double reach = NormalOf(probability) * std::sqrt(own.variance);
    return {reach, reach};
  }
  // nu m / chi2(1 - p) and nu m / chi2(p)
  const double sum = degrees * own.mean_square;
  return {own.mean_square - sum / ChiSquareQuantile(1 - probability, degrees),
          sum / ChiSquareQuantile(probability, degrees) - own.mean_square};
}

// t's quantile by Cornish and Fisher's first term: 4 digits at 96 degrees
double StudentOf(double normal) {
  return normal + (normal * normal * normal + normal) / (4 * kToneDegrees);
}

// the sum's mean square and the reach of its limits
struct Sum {
  double value = 0;
  double variance = 0;
  double floor_variance = 0;

  [[nodiscard]] double deviation() const { return std::sqrt(variance + floor_variance); }
};

// limits of tone + rest - floor by variance estimates recovery: squared distances add
Reach ReachOf(const BandPower& power, double gain_square, double normal, double probability) {
  const Reach rest = ReachOf(power.rest, probability);
  const Reach floor = power.floor ? ReachOf(*power.floor, probability) : Reach{};
  const double tone = StudentOf(normal) * std::sqrt(power.tone_variance) / gain_square;
  return {std::sqrt(tone * tone + rest.below * rest.below + floor.above * floor.above),
          std::sqrt(tone * tone + rest.above * rest.above + floor.below * floor.below)};
}

double RootOf(double mean_square) { return std::sqrt(std::max(0.0, mean_square)); }

// below the floor the one-sided limit is the answer: the interval is from 0 to it
void KeepOneLimit(RmsEstimate& estimate) {
  if (!estimate.below_floor) return;
  estimate.lower_m = 0;
  estimate.upper_m = estimate.at_most_m;
}

}  // namespace

RmsEstimate EstimateRms(const BandPower& power, std::span<const RmsBound> bounds) {
  HAPTOMETER_CHECK(power.sensor_gain > 0, "gain {}", power.sensor_gain);
  // rms^2 = tone / gain^2 + rest - floor, and the variance of each
  const double gain_square = power.sensor_gain * power.sensor_gain;
  const double floor = power.floor ? power.floor->mean_square : 0;
  const Sum sum{power.tone_mean_square / gain_square + power.rest.mean_square - floor,
                power.tone_variance / (gain_square * gain_square) + power.rest.variance,
                power.floor ? power.floor->variance : 0};

  RmsEstimate estimate;
  estimate.as_measured_m = RootOf(power.tone_mean_square + power.rest.mean_square);
  if (power.floor) estimate.floor_m = std::sqrt(floor);
  estimate.rms_m = RootOf(sum.value);
  const Reach reach = ReachOf(power, gain_square, kNormalCritical, 0.025);
  const Reach one_sided = ReachOf(power, gain_square, kNormal90, 0.05);
  // one-sided 95 %: the floor is not exceeded; two-sided: it exceeds the signal
  estimate.below_floor = power.floor && sum.value <= one_sided.below;
  estimate.floor_contradicts = power.floor && sum.value + reach.above < 0;
  const double lower = RootOf(sum.value - reach.below);
  const double upper = RootOf(sum.value + reach.above);

  // u(rms) = u(rms^2) / (2 rms); where the RMS does not differ from 0, from the interval's width
  const bool known = sum.value > reach.below && estimate.rms_m > 0;
  const double random =
      known ? sum.deviation() / (2 * estimate.rms_m) : (upper - lower) / (2 * kNormalCritical);
  const double total = sum.deviation();
  // shares of the budget in proportion to the standard deviations
  const auto share = [&](double variance) {
    return total > 0 ? random * std::sqrt(variance) / total : 0;
  };
  estimate.budget.push_back({RmsCause::kNoise, Evaluation::kStatistical, share(sum.variance)});
  if (power.floor) {
    estimate.budget.push_back(
        {RmsCause::kNoiseFloor, Evaluation::kStatistical, share(sum.floor_variance)});
  }
  // a bound is of the RMS behind filter and sensor: converted to the RMS that is stated
  const double scale = known ? estimate.as_measured_m / (gain_square * estimate.rms_m) : 1;
  double bound_square = 0;
  double both_square = 0;
  double only_below = 0;
  for (const RmsBound& bound : bounds) {
    // rectangular distribution: half width / sqrt(3)
    const double u = scale * bound.half_width_m / std::numbers::sqrt3;
    bound_square += u * u;
    if (bound.only_below) only_below += scale * bound.half_width_m;
    if (!bound.only_below) both_square += u * u;
    estimate.budget.push_back({bound.cause, Evaluation::kBound, u});
  }
  estimate.standard_uncertainty_m = std::hypot(random, std::sqrt(bound_square));
  // bounds widen the interval in squares, by 1.96 of their standard uncertainty
  const double widening = kNormalCritical * std::sqrt(both_square);
  estimate.lower_m =
      std::max(0.0, estimate.rms_m - std::hypot(estimate.rms_m - lower, widening) - only_below);
  estimate.upper_m = estimate.rms_m + std::hypot(upper - estimate.rms_m, widening);
  // the upper limit starts from the tone's power at least, if the floor exceeds the rest
  const double least = std::max({0.0, sum.value, power.tone_mean_square / gain_square});
  double most = least + one_sided.above;
  // noise only adds: however uncertain a floor is that hides the drive, what was measured is a
  // limit
  if (estimate.below_floor) {
    most = std::min(most, power.tone_mean_square / gain_square + power.rest.mean_square);
  }
  estimate.at_most_m = estimate.rms_m + std::hypot(std::sqrt(most) - estimate.rms_m,
                                                   kNormal90 * std::sqrt(both_square));
  KeepOneLimit(estimate);
  return estimate;
}

Interval WithGain(double value, const Interval& limits, double relative) {
  const double reach = kNormalCritical * relative;
  return {value - std::hypot(value - limits.lower, reach * value),
          value + std::hypot(limits.upper - value, reach * limits.upper)};
}

void AddGainUncertainty(double relative, RmsEstimate& estimate) {
  const double of_gain_m = relative * estimate.rms_m;
  estimate.budget.push_back({RmsCause::kCalibration, Evaluation::kStated, of_gain_m});
  estimate.standard_uncertainty_m = std::hypot(estimate.standard_uncertainty_m, of_gain_m);
  const Interval limits = WithGain(estimate.rms_m, {estimate.lower_m, estimate.upper_m}, relative);
  estimate.lower_m = std::max(0.0, limits.lower);
  estimate.upper_m = limits.upper;
  estimate.at_most_m = estimate.rms_m + std::hypot(estimate.at_most_m - estimate.rms_m,
                                                   kNormal90 * relative * estimate.at_most_m);
  KeepOneLimit(estimate);
}

}  // namespace haptometer::dsp
