#include "dsp/analysis/rms_estimate.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "dsp/statistics/distributions.h"

namespace haptometer::dsp {
namespace {

constexpr double kNormal95 = 1.959963984540054;   // two-sided
constexpr double kNormal90 = 1.6448536269514722;  // two-sided; one-sided 95 %
// of a density that is the mean of 48 bins
constexpr double kToneDegrees = 96;

// chi-squared is normal then, to 1e-3 of a standard deviation
constexpr double kManyDegrees = 1e6;

// how far a value's limits lie below and above it
struct Reach {
  double below = 0;
  double above = 0;
};

double NormalOf(double probability) { return probability < 0.04 ? kNormal95 : kNormal90; }

// No periodogram has fewer degrees of freedom than its one line would (band_noise.h). Where mean
// square and variance say so, the first is a difference of larger numbers, and the second alone
// tells how far it reaches.
constexpr double kLeastDegrees = 4;

// of a noise power, by chi-squared; `probability` is that of either tail
Reach ReachOf(const NoisePower& power, double probability) {
  if (!(power.variance > 0)) return {};
  const NoisePower own{std::max(power.mean_square, std::sqrt(kLeastDegrees / 2 * power.variance)),
                       power.variance};
  const double degrees = own.degrees_of_freedom();
  if (degrees > kManyDegrees) {
    const double reach = NormalOf(probability) * std::sqrt(own.variance);
    return {reach, reach};
  }
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

Reach ReachOf(const BandPower& power, double gain_square, double normal, double probability) {
  const Reach rest = ReachOf(power.rest, probability);
  const Reach floor = power.floor ? ReachOf(*power.floor, probability) : Reach{};
  const double tone = StudentOf(normal) * std::sqrt(power.tone_variance) / gain_square;
  return {std::sqrt(tone * tone + rest.below * rest.below + floor.above * floor.above),
          std::sqrt(tone * tone + rest.above * rest.above + floor.below * floor.below)};
}

double RootOf(double mean_square) { return std::sqrt(std::max(0.0, mean_square)); }

}  // namespace

RmsEstimate EstimateRms(const BandPower& power, std::span<const RmsBound> bounds) {
  HAPTOMETER_CHECK(power.sensor_gain > 0, "gain {}", power.sensor_gain);
  const double gain_square = power.sensor_gain * power.sensor_gain;
  const double floor = power.floor ? power.floor->mean_square : 0;
  const Sum sum{power.tone_mean_square / gain_square + power.rest.mean_square - floor,
                power.tone_variance / (gain_square * gain_square) + power.rest.variance,
                power.floor ? power.floor->variance : 0};

  RmsEstimate estimate;
  estimate.as_measured_m = RootOf(power.tone_mean_square + power.rest.mean_square);
  if (power.floor) estimate.floor_m = std::sqrt(floor);
  estimate.rms_m = RootOf(sum.value);
  const Reach reach = ReachOf(power, gain_square, kNormal95, 0.025);
  const Reach one_sided = ReachOf(power, gain_square, kNormal90, 0.05);
  estimate.below_floor = power.floor && sum.value <= one_sided.below;
  estimate.floor_contradicts = power.floor && sum.value + reach.above < 0;
  const double lower = RootOf(sum.value - reach.below);
  const double upper = RootOf(sum.value + reach.above);

  // from mean squares to the RMS: u / (2 RMS); where the RMS is not told from 0, the interval's
  const bool known = sum.value > reach.below && estimate.rms_m > 0;
  const double random =
      known ? sum.deviation() / (2 * estimate.rms_m) : (upper - lower) / (2 * kNormal95);
  const double total = sum.deviation();
  const auto share = [&](double variance) {
    return total > 0 ? random * std::sqrt(variance) / total : 0;
  };
  estimate.budget.push_back({"noise", Evaluation::kStatistical, share(sum.variance),
                             "residual periodogram after subtraction of the sine fit"});
  if (power.floor) {
    estimate.budget.push_back({"noise floor", Evaluation::kStatistical, share(sum.floor_variance),
                               "scatter of the floor that is subtracted"});
  }
  // an error of the RMS behind the filter, in terms of the RMS that is stated
  const double scale = known ? estimate.as_measured_m / (gain_square * estimate.rms_m) : 1;
  double bound_square = 0;
  for (const RmsBound& bound : bounds) {
    const double u = scale * bound.half_width_m / std::numbers::sqrt3;
    bound_square += u * u;
    estimate.budget.push_back({bound.name, Evaluation::kBound, u, bound.how});
  }
  estimate.standard_uncertainty_m = std::hypot(random, std::sqrt(bound_square));
  const double widening = kNormal95 * std::sqrt(bound_square);
  estimate.lower_m = std::max(0.0, estimate.rms_m - std::hypot(estimate.rms_m - lower, widening));
  estimate.upper_m = estimate.rms_m + std::hypot(upper - estimate.rms_m, widening);
  const double least = std::max({0.0, sum.value, power.tone_mean_square / gain_square});
  estimate.at_most_m =
      estimate.rms_m + std::hypot(std::sqrt(least + one_sided.above) - estimate.rms_m,
                                  kNormal90 * std::sqrt(bound_square));
  return estimate;
}

}  // namespace haptometer::dsp
