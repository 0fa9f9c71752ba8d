// MeasureNoiseBeside against noise of known density: its stated variances, tones, red noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <vector>

#include "dsp/analysis/band_noise.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;
constexpr std::size_t kEdge = 600;   // 0.3 s: six periods of the lower corner
constexpr std::size_t kSize = 3000;  // 1.5 s
constexpr double kToneHz = 225.3;

// Noise of variance 1 before the band's filter, made red by x[n] = red x[n-1] + e[n].
std::vector<double> FilteredNoise(const FilterDesign& design, double red, std::uint64_t seed) {
  Noise noise(seed);
  std::vector<double> values(kSize + 2 * kEdge);
  double last = noise();
  for (double& value : values) {
    last = red * last + std::sqrt(1 - red * red) * noise();
    value = last;
  }
  const std::vector<double> all = FilterZeroPhase(design, values);
  return {all.begin() + kEdge, all.end() - kEdge};
}

// One-sided density of that noise before the filter, and its mean square behind both passes.
double Density(double red, double frequency_hz) {
  const double cosine = std::cos(2 * std::numbers::pi * frequency_hz / kRateHz);
  return 2 / kRateHz * (1 - red * red) / (1 + red * red - 2 * red * cosine);
}
double MeanSquare(const FilterDesign& design, double red) {
  constexpr int kSteps = 4000;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double frequency_hz = (k + 0.5) / kSteps * kRateHz / 2;
    sum += std::pow(Magnitude(design, frequency_hz), 4) * Density(red, frequency_hz);
  }
  return sum * kRateHz / 2 / kSteps;
}

double MeanSquareOf(const std::vector<double>& values) {
  const double rms = Rms(values);
  return rms * rms;
}

const std::vector<FrequencyRange> kBesideTone{{kToneHz - 8, kToneHz + 8}};

// Coverage of two standard uncertainties, 95.4 % of a normal distribution: 0.93 to 0.97. 1000
// repetitions know it to 0.7 %.
void ExpectTwoSigma(const char* name, int held, int repetitions) {
  const double share = static_cast<double>(held) / repetitions;
  std::printf("[coverage] %s: %.4f\n", name, share);
  EXPECT_GE(share, 0.93) << name;
  EXPECT_LE(share, 0.97) << name;
}

TEST(NoiseBeside, WhiteNoiseLiesWithinItsVariances) {
  const BandPass band;
  const FilterDesign design = Designed(band, kRateHz);
  const double truth = MeanSquare(design, 0);
  const int repetitions = Repetitions(tests::kIsSanitized ? 200 : 1000);
  int held = 0;
  int rest_held = 0;
  double sum = 0;
  double density_sum = 0;
  int below = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    const std::vector<double> values = FilteredNoise(design, 0, static_cast<std::uint64_t>(seed));
    const NoiseBeside noise = MeasureNoiseBeside(values, kRateHz, design, band, kBesideTone);
    const double estimate = noise.power.mean_square;
    const double rest = MeanSquareOf(values) - estimate;
    held += std::abs(estimate - truth) <= 2 * std::sqrt(noise.power.variance) ? 1 : 0;
    rest_held += std::abs(rest) <= 2 * std::sqrt(noise.variance_of_rest) ? 1 : 0;
    sum += estimate;
    density_sum += noise.DensityAt(300);
    below += noise.upper_density <= Density(0, 300) ? 1 : 0;
  }
  ExpectTwoSigma("mean square of white noise", held, repetitions);
  ExpectTwoSigma("mean square of the window less that of the noise", rest_held, repetitions);
  // One standard uncertainty down: 84 % of a normal distribution, and 89 % of two parts, whose mean
  // scatters less by the sqrt(pi / 2) that a median is given; known to 2.4 % by 200 records.
  const double share = static_cast<double>(below) / repetitions;
  std::printf("[coverage] density of the upper half: %.4f\n", share);
  EXPECT_GE(share, 0.84 - 0.05);
  EXPECT_LE(share, 0.89 + 0.05);
  // 8.5 % of one estimate (2.08 x 2 / 576 bins), four times; skirts of the filter
  const double scatter = 4 * 0.085 / std::sqrt(repetitions);
  EXPECT_REL(sum / repetitions, truth, scatter, "scatter of the mean");
  EXPECT_REL(density_sum / repetitions, Density(0, 300), 2 * scatter, "a quarter of the bins");
}

// Beyond noise there is nothing in noise, but for its stated variance, and a line of 25 times the
// noise in its bin wherever it lies: u(a^2 / 2) = a sqrt(S / T).
TEST(BeyondNoise, IsThePowerOfLinesAndOfADrivesReach) {
  const BandPass band;
  const FilterDesign design = Designed(band, kRateHz);
  const double line_m = std::sqrt(2 * 25 * Density(0, 300) * kRateHz / kSize);
  const int repetitions = Repetitions(tests::kIsSanitized ? 200 : 1000);
  int held = 0;
  double sum = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    std::vector<double> values = FilteredNoise(design, 0, static_cast<std::uint64_t>(seed));
    const auto beyond = [&] {
      return BeyondNoise(MeasureNoise(values, kRateHz, NoiseReachHz(band)),
                         MeasureNoiseBeside(values, kRateHz, design, band, kBesideTone), design,
                         band, kBesideTone);
    };
    const NoisePower none = beyond();
    held += std::abs(none.mean_square) <= 2 * std::sqrt(none.variance) ? 1 : 0;
    const std::vector<double> line = Samples(kRateHz, kSize, 0, {{line_m, 301.2, 0.37 * seed}});
    for (std::size_t k = 0; k < kSize; ++k) values[k] += line[k];
    sum += beyond().mean_square - none.mean_square;
  }
  ExpectTwoSigma("power beyond noise in the reach of a drive", held, repetitions);
  // scatter 0.28 of the line; of one between two bins a tenth lies beyond the three about it
  EXPECT_REL(sum / repetitions, line_m * line_m / 2, 0.12, "what lies in farther bins");
}

// The tone is 80 dB above the noise in its bin; the window's side lobes are 12 dB below that.
TEST(NoiseBeside, ExcludedTonesChangeNothing) {
  const BandPass band;
  const FilterDesign design = Designed(band, kRateHz);
  std::vector<double> values = FilteredNoise(design, 0, 7);
  const NoiseBeside without = MeasureNoiseBeside(values, kRateHz, design, band, kBesideTone);
  const std::vector<double> tone = Samples(kRateHz, kSize, 0, {{100, kToneHz, 1}});
  for (std::size_t k = 0; k < kSize; ++k) values[k] += tone[k];
  const NoiseBeside with = MeasureNoiseBeside(values, kRateHz, design, band, kBesideTone);
  EXPECT_REL(with.power.mean_square, without.power.mean_square, 1e-2, "side lobes of -92 dB");
  EXPECT_REL(with.power.variance, without.power.variance, 2e-2, "the square of that");
  EXPECT_EQ(with.parts.size(), without.parts.size());
}

// A median: lines that fill less than half of a part change it little.
TEST(NoiseBeside, ALineThatIsNotExcludedChangesLittle) {
  const BandPass band;
  const FilterDesign design = Designed(band, kRateHz);
  std::vector<double> values = FilteredNoise(design, 0, 8);
  const double without = MeasureNoiseBeside(values, kRateHz, design, band, {}).power.mean_square;
  const std::vector<double> tone = Samples(kRateHz, kSize, 0, {{10, kToneHz, 1}});
  for (std::size_t k = 0; k < kSize; ++k) values[k] += tone[k];
  EXPECT_REL(MeasureNoiseBeside(values, kRateHz, design, band, {}).power.mean_square, without, 0.08,
             "8 of 114 bins raise a part's median by 13 %, a sixth of the band; scatter twice");
}

// The red noise of this test falls by a factor of 300 between the corners.
TEST(NoiseBeside, RedNoiseIsMeasuredToFivePercent) {
  const BandPass band;
  const FilterDesign design = Designed(band, kRateHz);
  for (const double red : {0.5, 0.9}) {
    const int repetitions = Repetitions(300);
    double sum = 0;
    for (int seed = 1; seed <= repetitions; ++seed) {
      const auto values = FilteredNoise(design, red, static_cast<std::uint64_t>(seed));
      sum += MeasureNoiseBeside(values, kRateHz, design, band, kBesideTone).power.mean_square;
    }
    EXPECT_REL(sum / repetitions, MeanSquare(design, red), 0.05,
               "a density within a ratio of 1.5 in frequency is taken for its median");
  }
}

TEST(NoiseBeside, ScalesWithTheSamples) {
  const BandPass band;
  const FilterDesign design = Designed(band, kRateHz);
  std::vector<double> values = FilteredNoise(design, 0.5, 9);
  const NoiseBeside one = MeasureNoiseBeside(values, kRateHz, design, band, kBesideTone);
  for (double& value : values) value *= 0x1p-20;
  const NoiseBeside small = MeasureNoiseBeside(values, kRateHz, design, band, kBesideTone);
  EXPECT_EQ(small.power.mean_square, 0x1p-40 * one.power.mean_square);
  EXPECT_EQ(small.power.variance, 0x1p-80 * one.power.variance);
  EXPECT_EQ(small.variance_of_rest, 0x1p-80 * one.variance_of_rest);
  EXPECT_EQ(small.foot_mean_square, 0x1p-40 * one.foot_mean_square);
  EXPECT_EQ(small.below_mean_square, 0x1p-40 * one.below_mean_square);
}

// ---- Bins made by hand: 1 Hz apart, all of the noise's density of 2 but for what a test adds.

BandNoise FlatRest() {
  BandNoise rest;
  rest.bin_hz = 1;
  rest.bins.assign(751, 0.0);
  return rest;
}

NoiseBeside FlatNoise() {
  NoiseBeside beside;
  beside.parts = {{20, 100}, {100, 500}};
  beside.densities = {2, 2};
  return beside;
}

double PowerGainAt(double frequency_hz) {
  return std::pow(Magnitude(Designed({}, kRateHz), frequency_hz), 4);
}

// What lies in the drive's range counts, its ends included, and nothing beside it.
TEST(BeyondNoise, TakesTheBinsOfTheDrivesRange) {
  BandNoise rest = FlatRest();
  for (const std::size_t k : {199U, 200U, 205U, 206U}) rest.bins[k] = 3;
  const std::vector<FrequencyRange> drive{{200, 205}};
  const NoisePower beyond = BeyondNoise(rest, FlatNoise(), Designed({}, kRateHz), {}, drive);
  // bins 200 and 205 of 3, and noise of 2 in all six; next to the filter's gain of 1
  double noise = 0;
  double squares = 0;
  for (int k = 200; k <= 205; ++k) {
    noise += 2 * PowerGainAt(k);
    squares += std::pow(2 * PowerGainAt(k), 2);
  }
  EXPECT_REL(beyond.mean_square, 6 - noise, 1e-12, "rounding");
  // w is 5 bins of 128
  EXPECT_REL(beyond.variance, squares * (1 + 2.08 * 2 * 5 / 128), 1e-12, "rounding");
}

// A line is half of 5^2 times the noise, and what lies beside it belongs to it.
TEST(BeyondNoise, TakesLinesOfTwelveAndAHalfTimesTheNoise) {
  const std::vector<FrequencyRange> drive{{200, 200.5}};
  const FilterDesign design = Designed({}, kRateHz);
  const auto beyond = [&](std::size_t bin, double size) {
    BandNoise rest = FlatRest();
    rest.bins[bin] = size;
    // the drive's own bin holds nothing
    return BeyondNoise(rest, FlatNoise(), design, {}, drive).mean_square + 2 * PowerGainAt(200);
  };
  EXPECT_ABS(beyond(300, 24.9), 0, 1e-12, "less than 12.5 x 2");
  const double beside = 2 * (PowerGainAt(299) + PowerGainAt(300) + PowerGainAt(301));
  EXPECT_REL(beyond(300, 25.1), 25.1 - beside, 1e-9, "three bins; the filter's gain is 1 - 1e-6");
  // at the ends of the band, where the filter leaves half of the power
  EXPECT_REL(beyond(20, 100), 100 - 2 * (PowerGainAt(20) + PowerGainAt(21)), 1e-9, "from 20 Hz on");
  EXPECT_REL(beyond(500, 100), 100 - 2 * (PowerGainAt(499) + PowerGainAt(500)), 1e-9,
             "up to 500 Hz");
  EXPECT_ABS(beyond(18, 100), 0, 1e-12, "below the band, and not beside it");
}

TEST(NoiseBeside, ADensityIsThatOfItsPart) {
  NoiseBeside noise;
  EXPECT_EQ(noise.DensityAt(100), 0);
  noise.parts = {{20, 30}, {30, 45}, {45, 60}};
  noise.densities = {1, 2, 3};
  EXPECT_EQ(noise.DensityAt(10), 1);
  EXPECT_EQ(noise.DensityAt(29.9), 1);
  EXPECT_EQ(noise.DensityAt(30), 2);
  EXPECT_EQ(noise.DensityAt(44.9), 2);
  EXPECT_EQ(noise.DensityAt(45), 3);
  EXPECT_EQ(noise.DensityAt(600), 3);
}

// Parts are half as wide again as where they begin, and 16 Hz or 128 bins at most.
TEST(NoiseBeside, PartsCoverTheBandOnce) {
  const BandPass band;
  for (const std::size_t size : {kSize, std::size_t{40'000}}) {
    const std::vector<double> none(size, 0.0);
    const NoiseBeside noise =
        MeasureNoiseBeside(none, kRateHz, Designed(band, kRateHz), band, kBesideTone);
    const double widest_hz = std::max(16.0, 128 * kRateHz / static_cast<double>(size));
    double from_hz = band.lower_hz;
    for (const FrequencyRange& part : noise.parts) {
      EXPECT_EQ(part.from_hz, from_hz);
      EXPECT_REL(part.to_hz, std::min({1.5 * from_hz, from_hz + widest_hz, band.upper_hz}), 1e-15,
                 "rounding");
      from_hz = part.to_hz;
    }
    EXPECT_REL(from_hz, band.upper_hz, 1e-3, "the last thousandth of the band is no part");
  }
}

// Integral of the filter's gain for power, both passes, in steps of a thousandth.
double Passed(const FrequencyRange& range) {
  constexpr int kSteps = 1000;
  const double step_hz = (range.to_hz - range.from_hz) / kSteps;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) sum += PowerGainAt(range.from_hz + (k + 0.5) * step_hz);
  return sum * step_hz;
}

// Densities before the filter of the bins of a range that are not beside the tone, where `behind`
// stands behind it in all of them.
std::vector<double> BeforeTheFilter(double behind, const FrequencyRange& range) {
  constexpr double kBinHz = kRateHz / kSize;
  std::vector<double> bins;
  for (double k = std::ceil(range.from_hz / kBinHz); k * kBinHz < range.to_hz; ++k) {
    const double at_hz = k * kBinHz;
    if (at_hz >= kBesideTone[0].from_hz && at_hz <= kBesideTone[0].to_hz) continue;
    bins.push_back(behind / PowerGainAt(at_hz));
  }
  std::ranges::sort(bins);
  return bins;
}

// An impulse has one density, 2 w^2 / (rate sum of w^2), in all bins. Of n of them the upper median
// is ln 2 + 1 / n of the mean, and 1 / n more where n is even; var = 2.08 x 2 / n of a part's
// power, and 1 / n less of what is left of the window's own noise.
TEST(NoiseBeside, OfAnImpulseIsItsDefinition) {
  const BandPass band;
  std::vector<double> impulse(kSize, 0.0);
  impulse[1400] = 3;
  const NoiseBeside noise =
      MeasureNoiseBeside(impulse, kRateHz, Designed(band, kRateHz), band, kBesideTone);
  const std::vector<double> weights = BlackmanHarris(kSize);
  const double behind =
      2 * std::pow(3 * weights[1400], 2) / (kRateHz * kSize * MeanSquareOf(weights));
  constexpr double kTaper = 1e-6;  // digits of the taper's mean square
  const auto beyond = [&](const FrequencyRange& range) {
    double sum = 0;
    for (const double bin : BeforeTheFilter(behind, range)) {
      sum += behind * (1 - noise.densities[0] / bin) * kRateHz / kSize;
    }
    return std::max(0.0, sum);
  };
  EXPECT_REL(noise.below_mean_square, beyond({8, 20}), kTaper, "0.4 of the corner to the corner");
  EXPECT_EQ(noise.foot_mean_square, 0) << "half of the first part's bins are below their median";
  double mean_square = noise.below_mean_square;
  double variance = 0;
  double of_rest = 0;
  double least = 1;
  double width_hz = 0;
  for (std::size_t k = 0; k < noise.parts.size(); ++k) {
    const FrequencyRange& part = noise.parts[k];
    const std::vector<double> bins = BeforeTheFilter(behind, part);
    const auto n = static_cast<double>(bins.size());
    const double upper = bins.size() % 2 == 0 ? 1 : 0;
    const double density = bins[bins.size() / 2] / (std::numbers::ln2 + (1 + upper) / n);
    EXPECT_REL(noise.densities[k], density, kTaper, "the taper");
    const bool is_last = k + 1 == noise.parts.size();
    const double passed_hz = Passed({k == 0 ? 8 : part.from_hz, is_last ? 750 : part.to_hz});
    width_hz += passed_hz;
    mean_square += density * passed_hz;
    variance += 2.08 * 2 / n * std::pow(density * passed_hz, 2);
    of_rest += (2.08 * 2 - 1) / n * std::pow(density * passed_hz, 2);
    least = std::min(least, density * (1 + 3.29 * std::sqrt(2.08 * 2 / n)));
  }
  constexpr double kSteps = 2e-3;  // sixteen steps over a corner: measured 1.4e-3
  EXPECT_REL(noise.power.mean_square, mean_square, kSteps, "the integral's steps");
  EXPECT_REL(noise.power.variance, variance, kSteps, "the integral's steps");
  EXPECT_REL(noise.variance_of_rest, of_rest, kSteps, "the integral's steps");
  EXPECT_REL(noise.least_density, least, kTaper, "the taper");
  EXPECT_REL(noise.flat_mean_square, least * width_hz, kSteps, "the integral's steps");
}

// A sine of 1 in nothing: all of its half is beyond noise, below the corner, in the lowest part, or
// in none of both.
TEST(NoiseBeside, MotionBelowAndInTheFootIsBeyondNoise) {
  const BandPass band;
  const FilterDesign design = Designed(band, kRateHz);
  const auto measured = [&](double frequency_hz) {
    return MeasureNoiseBeside(Samples(kRateHz, 20'000, 0, {{1, frequency_hz, 0.3}}), kRateHz,
                              design, band, kBesideTone);
  };
  constexpr double kSides = 1e-6;  // side lobes of -92 dB
  EXPECT_REL(measured(14.3).below_mean_square, 0.5, kSides, "8 Hz to 20 Hz");
  EXPECT_ABS(measured(14.3).foot_mean_square, 0, kSides, "side lobes");
  EXPECT_REL(measured(25.2).foot_mean_square, 0.5, kSides, "20 Hz to 30 Hz");
  EXPECT_ABS(measured(25.2).below_mean_square, 0, kSides, "side lobes");
  EXPECT_REL(measured(8.6).below_mean_square, 0.5, kSides, "six bins of 0.1 Hz within");
  EXPECT_ABS(measured(7.4).below_mean_square, 0, kSides, "six bins beyond 0.4 of the corner");
  EXPECT_ABS(measured(33).foot_mean_square + measured(33).below_mean_square, 0, kSides, "neither");
}

// A part of which fewer than eight bins are left takes the density of the next one: above it, or
// below where there is none above.
TEST(NoiseBeside, APartThatIsExcludedTakesItsNeighboursDensity) {
  const BandPass band;
  const FilterDesign design = Designed(band, kRateHz);
  const std::vector<double> values = FilteredNoise(design, 0.9, 5);
  const auto measured = [&](const FrequencyRange& excluded) {
    return MeasureNoiseBeside(values, kRateHz, design, band, std::vector{excluded});
  };
  const NoiseBeside all = measured({0, 0});
  ASSERT_GE(all.parts.size(), 4U);
  const std::size_t last = all.parts.size() - 1;
  EXPECT_NE(all.densities[1], all.densities[2]);
  const double bin_hz = kRateHz / kSize;
  // all but eight bins of part 1, and all but seven
  const double first = std::ceil(all.parts[1].from_hz / bin_hz);
  for (const double left : {8.0, 7.0}) {
    const NoiseBeside some = measured({(first + left - 0.5) * bin_hz, all.parts[1].to_hz});
    EXPECT_TRUE(some.is_known);
    EXPECT_EQ(some.densities[1] == all.densities[2], left < 8) << left;
    EXPECT_EQ(some.densities[0], all.densities[0]);
  }
  const NoiseBeside above = measured({all.parts[last].from_hz, 1000});
  EXPECT_EQ(above.densities[last], all.densities[last - 1]);
  EXPECT_FALSE(measured({0, 1000}).is_known);
}

// Terms of Harris's table; the mean of the window is the first of them, its mean square that of
// all.
TEST(BlackmanHarris, HasTheTermsOfItsTable) {
  constexpr std::size_t kCount = 1000;
  const std::vector<double> weights = BlackmanHarris(kCount);
  double sum = 0;
  double squares = 0;
  for (std::size_t k = 0; k < kCount; ++k) {
    const double turn = 2 * std::numbers::pi * (static_cast<double>(k) + 0.5) / kCount;
    EXPECT_ABS(weights[k],
               0.35875 - 0.48829 * std::cos(turn) + 0.14128 * std::cos(2 * turn) -
                   0.01168 * std::cos(3 * turn),
               1e-14, "rounding");
    sum += weights[k];
    squares += weights[k] * weights[k];
  }
  EXPECT_REL(sum / kCount, 0.35875, 1e-13, "the cosines' sums are 0");
  EXPECT_REL(squares / kCount, 0.2579635, 1e-6, "seven digits of the constant that is taken");
}

}  // namespace
}  // namespace haptometer::dsp
