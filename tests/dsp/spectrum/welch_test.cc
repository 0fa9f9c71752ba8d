#include "dsp/spectrum/welch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "dsp/statistics/moments.h"
#include "tests/dsp/signals.h"
#include "tests/dsp/spectrum/scipy_welch.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

std::vector<double> IntegerNoise(std::size_t count, std::uint64_t x) {
  std::vector<double> values(count);
  for (double& value : values) {
    x = (1103515245 * x + 12345) % (std::uint64_t{1} << 31);
    value = static_cast<double>(x) / 0x1p31 - 0.5;
  }
  return values;
}

std::vector<double> GaussianNoise(std::size_t count, Noise& noise) {
  std::vector<double> values(count);
  for (double& x : values) x = noise();
  return values;
}

void ExpectTable(std::span<const double> actual, std::span<const double> expected) {
  ASSERT_EQ(actual.size(), expected.size());
  double scale = 0;
  double worst = 0;
  for (const double x : expected) scale = std::max(scale, std::abs(x));
  for (std::size_t k = 0; k < actual.size(); ++k) {
    worst = std::max(worst, std::abs(actual[k] - expected[k]) / scale);
  }
  EXPECT_ABS(worst, 0, 1e-14, "rounding of two transforms, of the largest bin");
}

TEST(Welch, IsSciPys) {
  const std::vector<double> x = IntegerNoise(500, 1);
  const auto density = [&](WindowShape window, double overlap, Detrend detrend) {
    return WelchSpectrum(x, {1000, 64, window, overlap, detrend}).value().density;
  };
  using scipy_welch::kBlackmanHarrisMean;
  ExpectTable(density(WindowShape::kRectangular, 0, Detrend::kMean), scipy_welch::kRectangularMean);
  ExpectTable(density(WindowShape::kHann, 0.5, Detrend::kMean), scipy_welch::kHannMean);
  ExpectTable(density(WindowShape::kHamming, 0.25, Detrend::kNothing),
              scipy_welch::kHammingNothing);
  ExpectTable(density(WindowShape::kBlackmanHarris, 0.75, Detrend::kMean), kBlackmanHarrisMean);
  ExpectTable(density(WindowShape::kFlatTop, 0.75, Detrend::kMean), scipy_welch::kFlatTopMean);
}

TEST(Welch, CrossSpectrumAndCoherenceAreSciPys) {
  const std::vector<double> x = IntegerNoise(500, 1);
  std::vector<double> y = IntegerNoise(500, 7);
  for (std::size_t k = 0; k < y.size(); ++k) y[k] += 3 * x[(k + 498) % 500];
  const CrossSpectrum cross = WelchCrossSpectrum(x, y, {1000, 64}).value();
  std::vector<double> real;
  std::vector<double> imaginary;
  for (const std::complex<double>& bin : cross.cross) {
    real.push_back(bin.real());
    imaginary.push_back(bin.imag());
  }
  ExpectTable(real, scipy_welch::kCrossReal);
  ExpectTable(imaginary, scipy_welch::kCrossImaginary);
  ExpectTable(Coherence(cross), scipy_welch::kCoherence);
}

TEST(Welch, WindowsAreTheLiteratures) {
  // Heinzel et al. 2002: bandwidth in bins and amplitude error halfway between bins in dB
  struct Row {
    WindowShape shape;
    double bandwidth;
    double flatness_db;
  };
  for (const Row& row :
       {Row{WindowShape::kRectangular, 1, -3.9224}, Row{WindowShape::kHann, 1.5, -1.4236},
        Row{WindowShape::kHamming, 1.3628, -1.7514},
        Row{WindowShape::kBlackmanHarris, 2.0044, -0.8256},
        Row{WindowShape::kFlatTop, 3.8832, -0.0039}}) {
    const std::vector<double> window = WindowValues(row.shape, 4096);
    EXPECT_ABS(NoiseBandwidthBins(window), row.bandwidth, 5e-5, "printed with four decimals");
    std::complex<double> between = 0;
    for (std::size_t n = 0; n < window.size(); ++n) {
      between += window[n] * std::polar(1.0, std::numbers::pi * static_cast<double>(n) / 4096);
    }
    const double ratio = std::abs(between) / (4096 * Mean(window));
    // HFT90D's greatest error lies within the bin; halfway it is not above it
    if (row.shape == WindowShape::kFlatTop) {
      EXPECT_LE(std::abs(20 * std::log10(ratio)), 0.0039 + 5e-5);
    } else {
      EXPECT_ABS(20 * std::log10(ratio), row.flatness_db, 5e-5, "printed with four decimals");
    }
  }
}

TEST(Welch, IsParsevals) {
  Noise noise(2);
  const std::vector<double> x = GaussianNoise(1000, noise);
  // one segment, no window, nothing taken off: the mean square exactly
  for (const std::size_t size : {1000U, 999U}) {
    const auto spectrum = WelchSpectrum(
        std::span(x).first(size), {1000, size, WindowShape::kRectangular, 0, Detrend::kNothing});
    const double sum = std::reduce(spectrum->density.begin(), spectrum->density.end(), 0.0);
    const double rms = Rms(std::span(x).first(size));
    EXPECT_REL(sum * spectrum->grid.resolution_hz, rms * rms, 1e-14, "rounding");
    EXPECT_REL(RmsWithin(*spectrum, 0, 500), rms, 2e-3,
               "half of the last bin of an even size lies beyond");
  }
}

TEST(Welch, AToneIsItsAmplitudeAndItsRms) {
  const std::vector<double> x = Samples(1000, 4000, 5, {{3, 125, 0.3}});
  for (const WindowShape shape : {WindowShape::kRectangular, WindowShape::kHann,
                                  WindowShape::kBlackmanHarris, WindowShape::kFlatTop}) {
    const auto spectrum = WelchSpectrum(x, {1000, 400, shape}).value();
    EXPECT_REL(AmplitudeSpectrum(spectrum)[50], 3, 1e-12, "whole periods, on a bin: rounding");
    EXPECT_REL(RmsWithin(spectrum, 100, 150), 3 / std::numbers::sqrt2, 1e-12, "the main lobe");
  }
  const std::vector<double> between = Samples(1000, 4000, 0, {{3, 126.25, 0.3}});
  const auto flat = WelchSpectrum(between, {1000, 400, WindowShape::kFlatTop}).value();
  EXPECT_REL(AmplitudeSpectrum(flat)[50], 3, 5e-4, "-0.0039 dB");
}

TEST(Welch, IntervalsHoldTheTrueDensityOfWhiteNoise) {
  // 2000 records of 19 half-overlapping segments; density 2 / rate
  constexpr int kRecords = 2000;
  Noise noise(31);
  int held = 0;
  double level = 0;
  for (int r = 0; r < kRecords; ++r) {
    const auto x = GaussianNoise(160, noise);
    const auto spectrum = WelchSpectrum(x, {1000, 16, WindowShape::kHann, 0.5}).value();
    EXPECT_EQ(spectrum.grid.segments, 19U);
    const double density = spectrum.density[4];
    level += density / kRecords;
    held +=
        density * spectrum.grid.lower_factor <= 2e-3 && 2e-3 <= density * spectrum.grid.upper_factor
            ? 1
            : 0;
  }
  EXPECT_NEAR(held, 1900, 40) << "95 % +- 2 % of 2000";
  EXPECT_REL(level, 2e-3, 0.03, "four deviations: 4 sqrt(2 / (36 x 2000))");
}

TEST(Welch, DegreesOfFreedomCountOverlap) {
  const std::vector<double> x(10'000, 1.0);
  // no overlap: two a segment; Hann, half: r_1 = (1/6)^2, so 2 K / (1 + 2 (1 - 1/K) / 36)
  EXPECT_EQ(WelchSpectrum(x, {1000, 1000, WindowShape::kHann, 0})->grid.degrees_of_freedom, 20);
  EXPECT_REL(WelchSpectrum(x, {1000, 1000})->grid.degrees_of_freedom,
             38 / (1 + 2 * (1 - 1.0 / 19) / 36), 1e-12, "closed form");
}

TEST(Welch, CoherenceOfNothingInCommonIsTwoOverTheFreedom) {
  Noise noise(9);
  double mean = 0;
  double freedom = 0;
  constexpr int kRecords = 200;
  for (int r = 0; r < kRecords; ++r) {
    const auto x = GaussianNoise(1024, noise);
    const auto y = GaussianNoise(1024, noise);
    const auto cross = WelchCrossSpectrum(x, y, {1000, 128}).value();
    mean += Coherence(cross)[20] / kRecords;
    freedom = cross.grid.degrees_of_freedom;
  }
  EXPECT_REL(mean, 2 / freedom, 0.3, "four deviations of 200 of an exponential");
}

TEST(Welch, WhatCannotBeAskedIsRefused) {
  std::vector<double> x(100, 1.0);
  EXPECT_FALSE(WelchSpectrum(x, {1000, 101}));
  EXPECT_FALSE(WelchSpectrum(x, {1000, 1}));
  EXPECT_TRUE(WelchSpectrum(x, {1000, 2}));
  EXPECT_FALSE(WelchSpectrum(x, {1000, 10, WindowShape::kHann, 1}));
  EXPECT_TRUE(WelchSpectrum(x, {1000, 10, WindowShape::kHann, 0.99}));
  EXPECT_TRUE(WelchSpectrum(x, {1000, 10, WindowShape::kHann, 0}));
  EXPECT_FALSE(WelchSpectrum(x, {1000, 10, WindowShape::kHann, -0.01}));
  EXPECT_FALSE(WelchSpectrum({}, {1000, 10}));
  x[50] = std::nan("");
  const auto refused = WelchSpectrum(x, {1000, 10});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().Text().find("not finite"), std::string::npos);
}

TEST(Spectrogram, AveragesToTheSpectrumAndShowsWhen) {
  std::vector<double> x = Samples(1000, 4000, 0, {{1, 100, 0}});
  const std::vector<double> later = Samples(1000, 4000, 0, {{1, 200, 0}});
  std::copy(later.begin() + 2000, later.end(), x.begin() + 2000);
  const WelchOptions options{1000, 200};
  const Spectrogram parts = MakeSpectrogram(x, options).value();
  const PowerSpectrum whole = WelchSpectrum(x, options).value();
  ASSERT_EQ(parts.density.size(), whole.grid.segments);
  double worst = 0;
  for (std::size_t k = 0; k < whole.density.size(); ++k) {
    double sum = 0;
    for (const auto& segment : parts.density) sum += segment[k];
    worst = std::max(worst,
                     std::abs(sum / static_cast<double>(parts.density.size()) - whole.density[k]));
  }
  EXPECT_ABS(worst, 0, 1e-16, "rounding of 0.07 at most");
  EXPECT_REL(parts.start_s, 0.0995, 1e-15, "the middle of 200 samples");
  EXPECT_REL(parts.step_s, 0.1, 1e-15, "half a segment");
  EXPECT_GT(parts.density.front()[20], 1e6 * parts.density.front()[40]);
  EXPECT_GT(parts.density.back()[40], 1e6 * parts.density.back()[20]);
}

// bins of 2 Hz about their frequencies, of density 1, 2, 3 ...: the ends count by the share inside
TEST(Welch, RmsWithinTakesTheShareOfTheBinsAtBothEnds) {
  PowerSpectrum spectrum;
  spectrum.grid.resolution_hz = 2;
  for (int k = 0; k < 10; ++k) spectrum.density.push_back(k + 1);
  // 5.5 to 7 Hz of bin 3, 7 to 9 Hz of bin 4, 9 to 9.5 Hz of bin 5
  EXPECT_REL(RmsWithin(spectrum, 5.5, 9.5), std::sqrt(1.5 * 4 + 2 * 5 + 0.5 * 6), 1e-14,
             "rounding");
  EXPECT_REL(RmsWithin(spectrum, 6.2, 6.4), std::sqrt(0.2 * 4), 1e-13, "within one bin");
  EXPECT_EQ(RmsWithin(spectrum, 30, 40), 0) << "beyond the last";
}

// size 10, overlap 0.75: steps of 2.5 samples, rounded to 3
TEST(Welch, SegmentsAreThoseThatFit) {
  const std::vector<double> x(100, 1.0);
  const auto count = [&](std::size_t samples, double overlap) {
    return WelchSpectrum(std::span(x).first(samples), {1000, 10, WindowShape::kHann, overlap})
        ->grid.segments;
  };
  EXPECT_EQ(count(10, 0.75), 1U);
  EXPECT_EQ(count(12, 0.75), 1U);
  EXPECT_EQ(count(13, 0.75), 2U);
  EXPECT_EQ(count(29, 0), 2U);
  EXPECT_EQ(count(30, 0), 3U);
  EXPECT_EQ(count(100, 0.99), 91U) << "one sample at least";
}

// chi-squared of two degrees of freedom has quantiles -2 ln(1 - p)
TEST(Welch, TheIntervalOfOneSegmentIsExponentials) {
  const auto spectrum = WelchSpectrum(std::vector<double>(64, 1.0), {1000, 64});
  ASSERT_TRUE(spectrum);
  EXPECT_EQ(spectrum->grid.degrees_of_freedom, 2);
  EXPECT_REL(spectrum->grid.lower_factor, -1 / std::log(0.025), 1e-12, "closed form");
  EXPECT_REL(spectrum->grid.upper_factor, -1 / std::log(0.975), 1e-12, "closed form");
  EXPECT_REL(spectrum->grid.noise_bandwidth_hz, 1.5 * 1000 / 64, 1e-14, "Hann's 1.5 bins");
}

TEST(Welch, CoherenceWithNothingIsNoNumber) {
  const std::vector<double> x = IntegerNoise(500, 1);
  const CrossSpectrum cross = WelchCrossSpectrum(x, std::vector<double>(500), {1000, 64}).value();
  EXPECT_TRUE(std::isnan(Coherence(cross)[10]));
}

}  // namespace
}  // namespace haptometer::dsp
