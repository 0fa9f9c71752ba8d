#include "dsp/analysis/rms_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/tone.h"
#include "dsp/statistics/distributions.h"
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
  EXPECT_EQ(estimate.upper_m, estimate.at_most_m) << "one statement";
  // one-sided reach of a mean m of chi-squared with 2 m^2 / variance degrees of freedom
  const double above = 200 / ChiSquareQuantile(0.05, 200) - 1;
  const double below = 1.05 * (1 - 220.5 / ChiSquareQuantile(0.95, 220.5));
  EXPECT_REL(estimate.at_most_m, std::sqrt(std::hypot(above, below)), 1e-12, "rounding");
  // a tone behind a gain of 0.5 has four times the power
  power.tone_mean_square = 0.5;
  power.sensor_gain = 0.5;
  power.rest = {1, 100};
  power.floor = NoisePower{40, 1600};
  EXPECT_REL(EstimateRms(power, {}).at_most_m, std::sqrt(3.0), 1e-15, "no more than was measured");
  // of a floor that exceeds the rest, the tone's power is the least that the limit starts from
  power.rest = {1, 1e-4};
  power.floor = NoisePower{1.5, 1e-4};
  const double rest_above = 2e4 / ChiSquareQuantile(0.05, 2e4) - 1;
  const double floor_below = 1.5 * (1 - 4.5e4 / ChiSquareQuantile(0.95, 4.5e4));
  EXPECT_REL(EstimateRms(power, {}).at_most_m, std::sqrt(2 + std::hypot(rest_above, floor_below)),
             1e-12, "rounding");
}

// however uncertain a rest is, without a floor it is not below one
TEST(RmsEstimate, WithoutAFloorNothingIsBelowIt) {
  BandPower power;
  power.rest = {1, 100};
  const RmsEstimate estimate = EstimateRms(power, {});
  EXPECT_FALSE(estimate.below_floor);
  EXPECT_FALSE(estimate.floor_contradicts);
  EXPECT_FALSE(estimate.floor_m);
  EXPECT_EQ(estimate.rms_m, 1);
  EXPECT_EQ(estimate.budget.size(), 1U);
  // variance alone: mean^2 = 2 variance, four degrees of freedom
  const double mean = std::sqrt(200.0);
  const double above = mean * (4 / ChiSquareQuantile(0.025, 4) - 1);
  EXPECT_EQ(estimate.lower_m, 0);
  EXPECT_REL(estimate.upper_m, std::sqrt(1 + above), 1e-12, "rounding");
  EXPECT_REL(estimate.standard_uncertainty_m, std::sqrt(1 + above) / (2 * 1.959963984540054), 1e-12,
             "of an interval from 0");
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

// Noise that may still be in the RMS can only have made it too large.
TEST(RmsEstimate, NoiseThatIsKeptWidensTheIntervalDownwardsOnly) {
  BandPower power;
  power.rest = {1, 4e-4};
  const std::vector<RmsBound> kept{{RmsCause::kNoiseKept, 0.1, true}};
  const RmsEstimate without = EstimateRms(power, {});
  const RmsEstimate with = EstimateRms(power, kept);
  EXPECT_EQ(with.rms_m, 1);
  EXPECT_EQ(with.upper_m, without.upper_m);
  EXPECT_REL(without.lower_m - with.lower_m, 0.1, 1e-12, "by all of it");
  EXPECT_REL(with.standard_uncertainty_m, std::hypot(0.01, 0.1 / std::numbers::sqrt3), 1e-12,
             "a rectangle");
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

// Half a million degrees of freedom and more: the limits are those of a normal distribution.
constexpr double kSmallVariance = 1e-8;
const double kBoth = std::sqrt(2 * kSmallVariance);  // of rest and floor

RmsEstimate OverFloor(double above) {
  BandPower power;
  power.rest = {1 + above, kSmallVariance};
  power.floor = NoisePower{1, kSmallVariance};
  return EstimateRms(power, {});
}

TEST(RmsEstimate, AFloorIsExceededBeyondItsOneSidedLimit) {
  // one-sided 95 %: 1.644854 standard deviations
  const double limit = 1.644854 * kBoth;
  EXPECT_TRUE(OverFloor(0.995 * limit).below_floor);
  EXPECT_FALSE(OverFloor(1.005 * limit).below_floor);
  // two-sided: 1.959964
  const double contradiction = -1.959964 * kBoth;
  EXPECT_FALSE(OverFloor(0.995 * contradiction).floor_contradicts);
  EXPECT_TRUE(OverFloor(1.005 * contradiction).floor_contradicts);
  EXPECT_TRUE(OverFloor(1.005 * contradiction).below_floor);
}

TEST(RmsEstimate, OfADifferenceLimitsAreThoseOfANormalDistribution) {
  const double above = 10 * kBoth;
  const RmsEstimate estimate = OverFloor(above);
  constexpr double kDigits = 1e-6;  // digits of the quantiles
  EXPECT_REL(estimate.rms_m, std::sqrt(above), kDigits, "the difference");
  EXPECT_REL(estimate.lower_m, std::sqrt(above - 1.959964 * kBoth), kDigits, "two-sided");
  EXPECT_REL(estimate.upper_m, std::sqrt(above + 1.959964 * kBoth), kDigits, "two-sided");
  EXPECT_REL(estimate.at_most_m, std::sqrt(above + 1.644854 * kBoth), kDigits, "one-sided");
  EXPECT_REL(estimate.standard_uncertainty_m, kBoth / (2 * std::sqrt(above)), kDigits,
             "u(rms^2) / (2 rms)");
  ASSERT_EQ(estimate.budget.size(), 2U);
  for (const UncertaintyLine& line : estimate.budget) {
    EXPECT_REL(line.standard_uncertainty_m, estimate.standard_uncertainty_m / std::numbers::sqrt2,
               1e-12, "both have the same variance");
  }
}

// Where the RMS does not differ from 0, its uncertainty is that of the interval's width.
TEST(RmsEstimate, OfNothingTheUncertaintyIsTheIntervals) {
  for (const double share : {0.99, 1.01}) {
    const double above = share * 1.959964 * kBoth;
    const RmsEstimate estimate = OverFloor(above);
    const double expected = share < 1 ? std::sqrt(above + 1.959964 * kBoth) / (2 * 1.959964)
                                      : kBoth / 2 / estimate.rms_m;
    EXPECT_REL(estimate.standard_uncertainty_m, expected, 1e-6, "digits of the quantile");
  }
}

double SquaresOf(const std::vector<UncertaintyLine>& budget) {
  double sum = 0;
  for (const UncertaintyLine& line : budget)
    sum += line.standard_uncertainty_m * line.standard_uncertainty_m;
  return sum;
}

// With all that there may be, of an RMS that is known and of one that is not.
TEST(RmsEstimate, TheBudgetAddsUpInSquares) {
  for (const double tone : {1.0, 1e-3}) {
    BandPower power;
    power.tone_mean_square = tone;
    power.tone_variance = 3e-4;
    power.rest = {0.3, 4e-3};
    power.floor = NoisePower{0.3, 1e-3};
    power.sensor_gain = 0.7;
    const std::vector<RmsBound> bounds{{RmsCause::kBelowBand, 0.02}, {RmsCause::kDrift, 0.03}};
    RmsEstimate estimate = EstimateRms(power, bounds);
    EXPECT_REL(SquaresOf(estimate.budget), std::pow(estimate.standard_uncertainty_m, 2), 1e-13,
               "rounding");
    ASSERT_EQ(estimate.budget.size(), 4U);
    // as their standard deviations: tone / 0.7^4 and rest against the floor
    EXPECT_REL(
        estimate.budget[0].standard_uncertainty_m / estimate.budget[1].standard_uncertainty_m,
        std::sqrt((3e-4 / std::pow(0.7, 4) + 4e-3) / 1e-3), 1e-13, "rounding");
    AddGainUncertainty(0.01, estimate);
    EXPECT_REL(SquaresOf(estimate.budget), std::pow(estimate.standard_uncertainty_m, 2), 1e-13,
               "rounding");
  }
}

// A bound is of the RMS behind the sensor. Of RMS^2 = tone / gain^2 + rest - floor, the square of
// what was measured moves by 2 measured b, and the RMS by measured b / (gain^2 RMS).
TEST(RmsEstimate, ABoundIsConvertedToTheRmsThatIsStated) {
  BandPower power;
  power.tone_mean_square = 1;
  power.rest = {0.44, 0};
  power.floor = NoisePower{0.44, 0};
  power.sensor_gain = 0.5;
  const std::vector<RmsBound> bounds{{RmsCause::kFoot, 0.01}};
  const RmsEstimate estimate = EstimateRms(power, bounds);
  EXPECT_REL(estimate.rms_m, 2.0, 1e-15, "1 / 0.5^2");
  EXPECT_REL(estimate.as_measured_m, 1.2, 1e-15, "nothing taken off");
  const double u = 1.2 / (0.25 * 2) * 0.01 / std::numbers::sqrt3;
  EXPECT_REL(estimate.standard_uncertainty_m, u, 1e-13, "a rectangle");
  constexpr double kNear = 1e-11;  // differences of nearly equal numbers
  EXPECT_REL(estimate.upper_m - 2, 1.959963984540054 * u, kNear, "1.96 of it");
  EXPECT_REL(2 - estimate.lower_m, 1.959963984540054 * u, kNear, "1.96 of it");
}

TEST(RmsEstimate, AGainWidensTheOneSidedLimitByOneSided) {
  BandPower power;
  power.tone_mean_square = 4;
  power.tone_variance = 1e-3;
  const RmsEstimate without = EstimateRms(power, {});
  RmsEstimate with = without;
  AddGainUncertainty(0.02, with);
  EXPECT_REL(with.at_most_m - 2,
             std::hypot(without.at_most_m - 2, 1.644853627 * 0.02 * without.at_most_m), 1e-9,
             "digits of the quantile");
  const Interval limits = WithGain(2, {1.7, 2.4}, 0.1);
  EXPECT_REL(limits.lower, 2 - std::hypot(0.3, 1.959963985 * 0.1 * 2), 1e-9, "of the value");
  EXPECT_REL(limits.upper, 2 + std::hypot(0.4, 1.959963985 * 0.1 * 2.4), 1e-9, "of the limit");
}

// ---- Bins made by hand: bin k, of 2 Hz, holds the square of k.

BandNoise Counted(std::size_t bins) {
  BandNoise noise;
  noise.bin_hz = 2;
  for (std::size_t k = 0; k < bins; ++k) noise.bins.push_back(static_cast<double>(k * k));
  return noise;
}

// the mean of the squares of [from, to), over 2 Hz
double MeanOfSquares(std::initializer_list<std::pair<int, int>> ranges) {
  double sum = 0;
  int count = 0;
  for (const auto& [from, to] : ranges) {
    for (int k = from; k < to; ++k) sum += k * k;
    count += to - from;
  }
  return sum / count / 2;
}

// 24 bins on either side but for the next one: 48 of them, or as many as the band has.
TEST(BandNoise, TheDensityIsOfTwentyFourBinsOnEitherSide) {
  const BandNoise noise = Counted(400);
  const auto near = [&](double frequency_hz) { return noise.DensityNear(frequency_hz, 40, 500); };
  EXPECT_REL(near(200.9), MeanOfSquares({{75, 99}, {102, 126}}), 1e-14, "bin 100");
  EXPECT_REL(near(201.1), MeanOfSquares({{76, 100}, {103, 127}}), 1e-14, "bin 101");
  EXPECT_REL(near(60), MeanOfSquares({{20, 29}, {32, 56}}), 1e-14, "from 40 Hz on");
  EXPECT_REL(near(496), MeanOfSquares({{223, 247}, {250, 251}}), 1e-14, "up to 500 Hz");
  // bins that begin above the lower end of the band, and end below the upper one
  EXPECT_REL(noise.DensityNear(60, 40.1, 499.9), MeanOfSquares({{21, 29}, {32, 56}}), 1e-14, "21");
  EXPECT_REL(Counted(240).DensityNear(470, 40, 500), MeanOfSquares({{210, 234}, {237, 240}}), 1e-14,
             "no more bins than there are");
  EXPECT_EQ(noise.DensityNear(60, 58, 62), 0) << "no bin but the two beside it";
}

TEST(BandNoise, DegreesOfFreedomAreThoseOfMeanAndVariance) {
  EXPECT_REL((NoisePower{3, 0.5}.degrees_of_freedom()), 36.0, 1e-15, "2 x 9 / 0.5");
  EXPECT_TRUE(std::isinf(NoisePower{3, 0}.degrees_of_freedom()));
  EXPECT_EQ(Pooled({}).mean_square, 0);
}

// A tone of 2 um and its second harmonic of 0.5 um in white noise of density S: over T the noise
// has given S / T to each mean square, and its variance a^2 S / T. T is short here, so that it
// counts.
TEST(SplitTone, TakesTheNoisesShareFromEachLine) {
  constexpr std::size_t kCount = 20'000;  // 10 s
  constexpr double kWindowS = 0.01;
  Noise noise(5);
  std::vector<double> samples = Samples(kRateHz, kCount, 0, {{2, 110, 0.3}, {0.5, 220, 1}});
  for (double& x : samples) x += 0.2 * noise();
  const SineFit tone = FitSine(samples, {kRateHz, 480, 0}, 110);
  const Harmonics lines = FitHarmonics(samples, {kRateHz, 480, 0}, tone.frequency_hz, 500);
  ASSERT_EQ(lines.harmonics.size(), 4U);
  ASSERT_FALSE(lines.harmonics[2].stands_out || lines.harmonics[3].stands_out) << "noise";
  const TonePower split = SplitTone({samples, kRateHz}, tone, {}, kWindowS);
  EXPECT_REL(split.density, 0.04 / (kRateHz / 2), 0.6, "48 bins know it to 14 %, four times");
  const double first = std::pow(lines.harmonics[0].amplitude, 2);
  const double second = std::pow(lines.harmonics[1].amplitude, 2);
  const double beside = split.rest.DensityNear(tone.frequency_hz, 20, 500);
  const double density = split.rest.DensityNear(2 * tone.frequency_hz, 20, 500);
  EXPECT_REL(split.mean_square, (first + second) / 2 - (beside + density) / kWindowS, 1e-12,
             "rounding");
  EXPECT_REL(split.variance, (first * beside + second * density) / kWindowS, 1e-12, "rounding");
  // 8 Hz of 10 s are 80 bins on either side
  EXPECT_EQ(split.density, split.rest.DensityNear(tone.frequency_hz, 20, 500, 80));
  EXPECT_REL(split.rest.power.mean_square, 0.04, 0.04, "1 % of 2e4 values, four times");
}

// Sidebands reach over an eighth of the band, 4 Hz, at most, and over one bin at least: of 0.25 s
// that is a bin, of 0.2 s less.
TEST(SplitTone, LeavesOutABinOnEitherSideAtLeast) {
  for (const std::size_t size : {500UZ, 400UZ}) {
    const double bin_hz = kRateHz / static_cast<double>(size);
    const std::vector<double> samples =
        Samples(kRateHz, size, 0, {{2, 216, 0.3}, {0.1, 216 - 2 * bin_hz, 1}, {0.03, 220, 2}});
    const SineFit tone = FitSine(samples, {kRateHz, 32, 0}, 216);
    const TonePower split =
        SplitTone({samples, kRateHz}, tone, {.lower_hz = 200, .upper_hz = 232}, 1);
    ASSERT_EQ(split.rest.bin_hz, bin_hz);
    EXPECT_EQ(split.density, split.rest.DensityNear(tone.frequency_hz, 200, 232, 1)) << size;
    EXPECT_NE(split.density, split.rest.DensityNear(tone.frequency_hz, 200, 232, 2)) << size;
  }
}

// At 100 kHz: the highest power of two that leaves 2500 a second and 4096 samples, and of which
// what folds to 750 Hz or below is 1e-9 in both passes; |H| falls as (500 / f)^N.
TEST(Thinned, LeavesFiveTimesTheUpperCornerAndEnoughSamples) {
  const auto thinned = [](std::vector<double> values, int order) {
    const BandPass band{.order = order};
    return Thinned(std::move(values), 100e3, Designed(band, 100e3), band);
  };
  const auto rate = [&](std::size_t size, int order) {
    return thinned(std::vector<double>(size, 0.0), order).rate_hz;
  };
  EXPECT_EQ(rate(400'000, 8), 100e3 / 32) << "64 would leave 1562 a second";
  EXPECT_EQ(rate(400'000, 6), 100e3 / 16) << "(500 / 2375)^12 is 8e-9, (500 / 5500)^12 3e-13";
  EXPECT_EQ(rate(65'536, 6), 100e3 / 16);
  EXPECT_EQ(rate(16 * 4096 - 1, 6), 100e3 / 8);
  EXPECT_EQ(rate(2 * 4096 - 1, 6), 100e3);
  std::vector<double> counted(8192);
  for (std::size_t k = 0; k < counted.size(); ++k) counted[k] = static_cast<double>(k);
  const ThinnedSamples half = thinned(counted, 6);
  ASSERT_EQ(half.values_m.size(), 4096U);
  EXPECT_EQ(half.values_m[1], 2);
  EXPECT_EQ(half.values_m[4095], 8190);
  EXPECT_REL(half.duration_s(), 4096 / 50e3, 1e-15, "rounding");
}

TEST(RmsEstimate, AGainsUncertaintyIsOfTheRmsAndOfEachLimit) {
  RmsEstimate estimate;
  estimate.rms_m = 2;
  estimate.standard_uncertainty_m = 0.03;
  estimate.lower_m = 1.9;
  estimate.upper_m = 2.2;
  estimate.at_most_m = 2.1;
  AddGainUncertainty(0.01, estimate);
  EXPECT_REL(estimate.budget.back().standard_uncertainty_m, 0.02, 1e-14, "rounding");
  EXPECT_REL(estimate.standard_uncertainty_m, std::hypot(0.03, 0.02), 1e-14, "rounding");
  EXPECT_REL(estimate.lower_m, 2 - std::hypot(0.1, 1.959963984540054 * 0.02), 1e-14, "rounding");
  EXPECT_REL(estimate.upper_m, 2 + std::hypot(0.2, 1.959963984540054 * 0.022), 1e-14, "rounding");
  EXPECT_REL(estimate.at_most_m, 2 + std::hypot(0.1, 1.6448536269514722 * 0.021), 1e-14,
             "rounding");
}

}  // namespace
}  // namespace haptometer::dsp
