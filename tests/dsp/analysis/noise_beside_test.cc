// MeasureNoiseBeside against noise of known density: its stated variances, tones, red noise.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
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
  for (int seed = 1; seed <= repetitions; ++seed) {
    const std::vector<double> values = FilteredNoise(design, 0, static_cast<std::uint64_t>(seed));
    const NoiseBeside noise = MeasureNoiseBeside(values, kRateHz, design, band, kBesideTone);
    const double estimate = noise.power.mean_square;
    const double rest = MeanSquareOf(values) - estimate;
    held += std::abs(estimate - truth) <= 2 * std::sqrt(noise.power.variance) ? 1 : 0;
    rest_held += std::abs(rest) <= 2 * std::sqrt(noise.variance_of_rest) ? 1 : 0;
    sum += estimate;
    density_sum += noise.DensityAt(300);
  }
  ExpectTwoSigma("mean square of white noise", held, repetitions);
  ExpectTwoSigma("mean square of the window less that of the noise", rest_held, repetitions);
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

}  // namespace
}  // namespace haptometer::dsp
