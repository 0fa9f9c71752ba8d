#include "dsp/analysis/rms_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;

// white noise of variance 1 through a narrow or the default band, `rows` of it, edges cut off
std::vector<double> Coloured(std::size_t rows, const BandPass& band, Noise& noise) {
  std::vector<double> samples(rows + 2000);
  for (double& x : samples) x = noise();
  const std::vector<double> filtered = FilterZeroPhase(Designed(band, kRateHz), samples);
  return {filtered.begin() + 1000, filtered.begin() + 1000 + static_cast<std::ptrdiff_t>(rows)};
}

// of white noise of variance 1: integral of |H|^4 over Nyquist, and of |H|^8
struct Shape {
  double mean_square = 0;
  double bandwidth_hz = 0;
};
Shape ShapeOf(const BandPass& band) {
  const FilterDesign design = Designed(band, kRateHz);
  double first = 0;
  double second = 0;
  for (int k = 0; k < 10'000; ++k) {
    const double power = std::pow(Magnitude(design, 0.1 * k + 0.05), 4);
    first += 0.1 * power;
    second += 0.1 * power * power;
  }
  return {first / (kRateHz / 2), first * first / second};
}

TEST(BandNoise, PowerVarianceAndBandwidthOfColouredNoise) {
  for (const BandPass& band : {BandPass{}, BandPass{2, 100, 140, Corners::kWhole}}) {
    Noise noise(3);
    const Shape shape = ShapeOf(band);
    double mean_square = 0;
    double bandwidth_hz = 0;
    for (int k = 0; k < 40; ++k) {
      const BandNoise measured = MeasureNoise(Coloured(2000, band, noise), kRateHz, 1000);
      const NoisePower& power = measured.power;
      mean_square += power.mean_square / 40;
      // (integral of S)^2 / integral of S^2
      bandwidth_hz += power.mean_square * power.mean_square / power.variance * measured.bin_hz / 40;
    }
    EXPECT_REL(mean_square, shape.mean_square, 0.05, "40 windows of 2 B degrees");
    EXPECT_REL(bandwidth_hz, shape.bandwidth_hz, 0.15, "40 windows of few bins");
  }
}

// 311 samples of white noise of variance 1, whose bins are those of 300: 2 / 311 is the variance of
// the mean square of all of them.
TEST(BandNoise, VarianceOfSamplesThatDoNotTransformFast) {
  Noise noise(11);
  double variance = 0;
  constexpr int kRepetitions = 4000;
  for (int k = 0; k < kRepetitions; ++k) {
    std::vector<double> samples(311);
    for (double& sample : samples) sample = noise();
    const BandNoise measured = MeasureNoise(samples, kRateHz, kRateHz / 2);
    EXPECT_EQ(measured.bin_hz, kRateHz / 300);
    variance += measured.power.variance / kRepetitions;
  }
  EXPECT_REL(variance, 2.0 / 311, 0.015,
             "0.3 % of 150 bins 4000 times, 1 % of the bin at half the rate; 300 for 311 is 3.7 %");
}

TEST(BandNoise, TheBinsOfASineAddUpToItsMeanSquare) {
  const BandNoise measured =
      MeasureNoise(Samples(kRateHz, 2000, 0, {{2, 150, 0.3}}), kRateHz, 1000);
  EXPECT_REL(measured.power.mean_square, 2.0, 1e-13, "whole periods");
  EXPECT_REL(measured.bins[150], 2.0, 1e-13, "all of it in one bin");
  EXPECT_ABS(measured.DensityNear(150, 20, 500), 0, 1e-25, "the line itself is left out");
}

TEST(BandNoise, PoolingWeighsByLength) {
  const std::vector<WeightedPower> windows{{{4, 0.5}, 1}, {{1, 0.1}, 3}};
  const NoisePower pooled = Pooled(windows);
  EXPECT_REL(pooled.mean_square, 7.0 / 4, 1e-15, "by hand");
  EXPECT_REL(pooled.variance, (0.5 + 0.9) / 16, 1e-15, "by hand");
}

TEST(RmsEstimate, AFloorIsTakenOffInPower) {
  // 9 um over a floor of 5.9 um reads 10.8 um
  BandPower power;
  power.tone_mean_square = 81e-12;
  power.rest = {5.9e-6 * 5.9e-6, 1e-26};
  power.floor = NoisePower{5.9e-6 * 5.9e-6, 1e-26};
  const RmsEstimate estimate = EstimateRms(power, {});
  EXPECT_REL(estimate.as_measured_m, 10.8e-6, 5e-3, "the facts' digits");
  EXPECT_REL(*estimate.floor_m, 5.9e-6, 1e-15, "as given");
  EXPECT_REL(estimate.rms_m, 9e-6, 1e-14, "closed form");
  EXPECT_REL(estimate.standard_uncertainty_m, std::sqrt(2e-26) / 18e-6, 1e-12, "u / (2 RMS)");
  EXPECT_FALSE(estimate.below_floor);
  ASSERT_EQ(estimate.budget.size(), 2U);
}

TEST(RmsEstimate, BelowTheFloorOnlyALimitIsKnown) {
  BandPower power;
  power.rest = {1, 0.01};
  power.floor = NoisePower{1.05, 0.01};
  const RmsEstimate estimate = EstimateRms(power, {});
  EXPECT_TRUE(estimate.below_floor);
  EXPECT_EQ(estimate.rms_m, 0);
  EXPECT_EQ(estimate.lower_m, 0);
  EXPECT_GT(estimate.at_most_m, 0.3);
  EXPECT_LT(estimate.at_most_m, 0.6);
}

TEST(RmsEstimate, AFloorAboveAllThatWasMeasuredIsNotTheRecords) {
  BandPower power;
  power.tone_mean_square = 0.5;
  power.rest = {1, 0.0001};
  power.floor = NoisePower{4, 0.0001};
  const RmsEstimate estimate = EstimateRms(power, {});
  EXPECT_TRUE(estimate.floor_contradicts);
  EXPECT_GE(estimate.at_most_m, std::sqrt(0.5)) << "the tone is there";
  power.floor = NoisePower{1.5, 0.0001};
  EXPECT_FALSE(EstimateRms(power, {}).floor_contradicts);
}

// a tone in the floor: its power scatters as much as it is large
TEST(RmsEstimate, BelowAnUncertainFloorTheLimitIsWhatWasMeasured) {
  BandPower power;
  power.tone_mean_square = 0.5;
  power.rest = {1, 100};
  power.floor = NoisePower{40, 1600};
  const RmsEstimate estimate = EstimateRms(power, {});
  EXPECT_TRUE(estimate.below_floor);
  EXPECT_REL(estimate.at_most_m, estimate.as_measured_m, 1e-15, "no more power than that");
}

TEST(RmsEstimate, TheGainDividesTheToneOnly) {
  BandPower power;
  power.tone_mean_square = 0.25;
  power.rest = {0.1, 0};
  power.sensor_gain = 0.5;
  EXPECT_REL(EstimateRms(power, {}).rms_m, std::sqrt(1.1), 1e-15, "0.25 / 0.25 + 0.1");
}

TEST(RmsEstimate, BoundsAreRectanglesAndCoverThemselves) {
  BandPower power;
  power.tone_mean_square = 1;
  const std::vector<RmsBound> bounds{{RmsCause::kBelowBand, 0.01}};
  const RmsEstimate estimate = EstimateRms(power, bounds);
  EXPECT_REL(estimate.standard_uncertainty_m, 0.01 / std::numbers::sqrt3, 1e-12, "a rectangle");
  EXPECT_LT(estimate.lower_m, 0.99);
  EXPECT_GT(estimate.upper_m, 1.01);
  EXPECT_REL(estimate.at_most_m - 1, 1.6448536269514722 * 0.01 / std::numbers::sqrt3, 1e-9,
             "one-sided 95 %; a difference of nearly equal numbers");
  EXPECT_EQ(estimate.budget.back().evaluation, Evaluation::kBound);
}

// u_total^2 = u^2 + (RMS u_gain)^2, as a line of the budget, and the interval in squares
TEST(RmsEstimate, TheSensorsGainAddsInSquares) {
  BandPower power;
  power.tone_mean_square = 1;
  power.tone_variance = 1e-4;
  const RmsEstimate without = EstimateRms(power, {});
  RmsEstimate with = without;
  AddGainUncertainty(0.005, with);
  EXPECT_REL(with.standard_uncertainty_m, std::hypot(without.standard_uncertainty_m, 0.005), 1e-15,
             "the same sum");
  EXPECT_EQ(with.budget.back().cause, RmsCause::kCalibration);
  EXPECT_EQ(with.budget.back().evaluation, Evaluation::kStated);
  EXPECT_REL(with.budget.back().standard_uncertainty_m, 0.005, 1e-15, "RMS 1");
  EXPECT_REL(1 - with.lower_m, std::hypot(1 - without.lower_m, 1.959963984540054 * 0.005), 1e-12,
             "differences of nearly equal numbers");
  EXPECT_REL(with.upper_m - 1,
             std::hypot(without.upper_m - 1, 1.959963984540054 * 0.005 * without.upper_m), 1e-12,
             "differences of nearly equal numbers");
  EXPECT_GT(with.at_most_m, without.at_most_m);
  EXPECT_EQ(with.rms_m, without.rms_m);
}

// 2000 seeds: noise alone, and noise less a floor measured over a third of the time
TEST(RmsEstimate, ARestOfLessThanItsOwnScatterHasAnEnd) {
  // a tone without noise: what it leaves is a difference of rounding's size, its scatter is larger
  for (const double rest : {0.0, 1e-20, 1e-16}) {
    const BandPower power{
        .tone_mean_square = 1e-10, .tone_variance = 1e-28, .rest = {rest, 1e-30}, .floor = {}};
    // 97.5 % point of t with 96 degrees; 2.5 % point of chi-squared with 4, both from tables
    const double tone = 1.98498 * 1e-14;
    const double above = std::sqrt(2.0) * 1e-15 * (4 / 0.484419 - 1);
    EXPECT_REL(EstimateRms(power, {}).upper_m, std::sqrt(1e-10 + rest + std::hypot(tone, above)),
               2e-8, "t to 4 digits (Cornish and Fisher), on 1e-4 of the value");
  }
}

TEST(RmsEstimate, IntervalsCoverThePopulation) {
  const Shape shape = ShapeOf({});
  Noise noise(11);
  int covered = 0;
  int covered_above_floor = 0;
  constexpr int kSeeds = 2000;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const std::vector<double> rows = Coloured(1000, {}, noise);
    const std::span all(rows);
    const BandNoise on = MeasureNoise(all.first(500), kRateHz, 1000);
    const BandNoise off = MeasureNoise(all.subspan(700, 300), kRateHz, 1000);
    BandPower power;
    power.rest = on.power;
    const RmsEstimate plain = EstimateRms(power, {});
    const double truth = std::sqrt(shape.mean_square);
    if (plain.lower_m <= truth && truth <= plain.upper_m) ++covered;
    // the same noise 1.6 times stronger while the drive is on
    power.rest = {2.56 * on.power.mean_square, 6.5536 * on.power.variance};
    power.floor = off.power;
    const RmsEstimate less = EstimateRms(power, {});
    const double rest = std::sqrt(1.56 * shape.mean_square);
    if (less.lower_m <= rest && rest <= less.upper_m) ++covered_above_floor;
  }
  // 2000 repetitions know a rate of 95 % to 0.5 %
  EXPECT_ABS(100.0 * covered / kSeeds, 95, 2, "the bar");
  EXPECT_ABS(100.0 * covered_above_floor / kSeeds, 95, 2, "the bar");
}

}  // namespace
}  // namespace haptometer::dsp
