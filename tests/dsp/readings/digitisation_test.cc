// The steps of values and repeated ones by construction; the bound of rounding against the Fourier
// series of a rounded sine, its steps taken one by one.
#include "dsp/readings/digitisation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// a tone on slow motion, in noise
std::vector<double> Tone(double rate_hz, double tone_hz, double noise_m) {
  std::vector<double> values = Samples(rate_hz, static_cast<std::size_t>(2 * rate_hz), 0,
                                       {{50e-6, tone_hz, 0.1}, {2e-5, 6}});
  Noise noise(1);
  for (double& x : values) x += noise_m * noise();
  return values;
}

constexpr int kOffsets = 32;  // places of the sine between two steps

// What rounding to steps of 1 makes of c + A cos(theta) + noise of standard deviation s, on average
// over the noise: a step of 1 at each threshold j + 1/2, blurred to a normal distribution function.
double MeanOfRounded(double x, double noise) {
  const double reach = 9 * noise;
  const double low = std::floor(x - reach);
  double mean = low;
  for (double threshold = low + 0.5; threshold < x + reach; ++threshold) {
    mean += std::erfc((threshold - x) / noise / std::numbers::sqrt2) / 2;
  }
  return mean;
}

// Amplitudes of harmonics 1 to `harmonics`. Without noise: of a step at theta_j = acos((j + 1/2 -
// c) / A), (2 / pi) sin(n theta_j) / n. With noise: the midpoint rule over half a period.
std::vector<double> HarmonicsOfRounded(double amplitude, double offset, double noise,
                                       int harmonics) {
  std::vector<double> sums(static_cast<std::size_t>(harmonics));
  if (noise == 0) {
    for (double j = std::floor(offset - amplitude) - 1; j < offset + amplitude + 1; ++j) {
      const double cosine = (j + 0.5 - offset) / amplitude;
      if (std::abs(cosine) >= 1) continue;
      for (int n = 1; n <= harmonics; ++n) {
        sums[static_cast<std::size_t>(n) - 1] +=
            2 / std::numbers::pi * std::sin(n * std::acos(cosine)) / n;
      }
    }
    return sums;
  }
  constexpr int kPoints = 512;
  for (int k = 0; k < kPoints; ++k) {
    const double theta = (k + 0.5) / kPoints * std::numbers::pi;
    const double value = MeanOfRounded(offset + amplitude * std::cos(theta), noise);
    for (int n = 1; n <= harmonics; ++n) {
      sums[static_cast<std::size_t>(n) - 1] += 2.0 / kPoints * value * std::cos(n * theta);
    }
  }
  return sums;
}

// The greatest error of the RMS of harmonics 1 to `harmonics` over all offsets.
double WorstError(double amplitude, double noise, int harmonics) {
  double worst = 0;
  for (int place = 0; place < kOffsets; ++place) {
    double square = 0;
    for (const double harmonic :
         HarmonicsOfRounded(amplitude, static_cast<double>(place) / kOffsets, noise, harmonics)) {
      square += harmonic * harmonic / 2;
    }
    worst = std::max(worst, std::abs(std::sqrt(square) - amplitude / std::numbers::sqrt2));
  }
  return worst;
}

constexpr double kAmplitudes[] = {0.1, 0.3, 0.45, 0.5, 0.55, 0.7, 0.9,  1.0,  1.1,
                                  1.3, 1.5, 1.8,  2.2, 2.7,  3.5, 5.25, 7.75, 12.1};

TEST(StepOf, IsTheStepOfRoundedSamples) {
  for (const double step : {1e-8, 2.5e-7, 1.0}) {
    for (const double offset : {0.0, 0.03, -0.3 * step}) {
      std::vector<double> values;
      for (const double code : {0, 3, 4, 4, 9, -2, -1, 6}) values.push_back(offset + code * step);
      EXPECT_REL(StepOf(values), step, 1e-8, "0.03 is rounded to 3e-18, 3e-10 of a step of 1e-8");
    }
  }
}

TEST(StepOf, IsNothingOfOtherSamples) {
  EXPECT_EQ(StepOf({}), 0);
  EXPECT_EQ(StepOf(std::vector<double>{0.5}), 0);
  EXPECT_EQ(StepOf(std::vector<double>(9, 0.5)), 0);
  EXPECT_EQ(StepOf(std::vector<double>{0, 2, 5, 7}), 1);  // changes of 2 and of 3
  EXPECT_EQ(StepOf(std::vector<double>{0, 1, 2.05, 3.05}), 0);
  // the values of few phases: changes of 3 to 7, differences of 1 and 2
  EXPECT_EQ(StepOf(std::vector<double>{0, 7, 3, kNaN, 9, 2, 7}), 1);
  EXPECT_EQ(StepOf(Samples(10e3, 1000, 0, {{1e-6, 225}})), 0);
  std::vector<double> values(1000);
  Noise noise(1);
  for (double& value : values) value = noise();
  EXPECT_EQ(StepOf(values), 0);
}

// the rows of a record that asks its source every 1/`ratio` of a new reading
std::vector<double> Repeated(const std::vector<double>& fresh, double ratio) {
  std::vector<double> rows;
  for (std::size_t k = 0; static_cast<double>(k) / ratio < static_cast<double>(fresh.size()); ++k) {
    rows.push_back(fresh[static_cast<std::size_t>(static_cast<double>(k) / ratio)]);
  }
  return rows;
}

TEST(RepeatedShare, IsThatOfASlowerSource) {
  for (const double tone_hz : {80.0, 175.3, 300.3, 440.3}) {
    for (const double step : {0.0, 1e-7}) {
      std::vector<double> fresh = Samples(2000, 4000, 0, {{20e-6, tone_hz}});
      Noise noise(3);
      for (double& x : fresh) {
        x += 2e-8 * noise();
        if (step > 0) x = std::round(x / step) * step;
      }
      EXPECT_ABS(RepeatedShare(fresh), 0, 0, "new readings only");
      for (const double ratio : {1.3, 2.0, 2.5, 3.0, 4.0, 10.0}) {
        // equal readings by chance add 1 % at most where a step is as small as a change
        EXPECT_ABS(RepeatedShare(Repeated(fresh, ratio)), 1 - 1 / ratio, step > 0 ? 0.02 : 1e-3,
                   "one in `ratio` is new");
      }
      // without a measurement in every seventh row
      std::vector<double> missing = Repeated(fresh, 3);
      for (std::size_t k = 0; k < missing.size(); k += 7) missing[k] = kNaN;
      EXPECT_GT(RepeatedShare(missing), 0.4);
    }
  }
}

// rounding to steps as large as the motion, a tone whose phases lie on either side of its extremes,
// rails and pauses
TEST(RepeatedShare, IsNoneOfOtherEqualSamples) {
  for (const double step : {1e-7, 1e-6, 1e-5}) {
    for (const double noise_m : {0.0, 1e-7, 1e-6}) {
      for (const double tone_hz : {20.0, 80.0, 175.3, 440.3}) {
        std::vector<double> values = Tone(5000, tone_hz, noise_m);
        for (double& x : values) x = std::round(x / step) * step;
        EXPECT_EQ(RepeatedShare(values), 0) << step << ' ' << noise_m << ' ' << tone_hz;
      }
    }
  }
  EXPECT_EQ(RepeatedShare(Samples(5000, 5000, 0, {{20e-6, 250, std::numbers::pi / 20}})), 0);
  std::vector<double> values = Tone(5000, 175.3, 2e-8);
  for (double& x : values) x = std::min(x, 2e-5);
  EXPECT_EQ(RepeatedShare(values), 0);
  std::fill(values.begin(), values.begin() + 5000, 0.0);
  EXPECT_EQ(RepeatedShare(values), 0);
  EXPECT_EQ(RepeatedShare({}), 0);
}

// Over 18 amplitudes, 6 levels of noise, 32 offsets; `harmonics` 1 is the tone alone.
TEST(QuantisationBound, HoldsTheErrorOfEveryRoundedSine) {
  for (const int harmonics : {1, 2, 5}) {
    for (const double noise : {0.0, 0.05, 0.1, 0.2, 0.3, 0.5}) {
      for (const double amplitude : kAmplitudes) {
        const double worst = WorstError(amplitude, noise, harmonics);
        const double bound = QuantisationBound(1, amplitude, noise, harmonics);
        // terms of the series below 1e-6 of a step are left out
        EXPECT_GE(bound, worst - 1e-6) << amplitude << ' ' << noise << ' ' << harmonics;
      }
    }
  }
}

// The offset is not known, the phases of the series' terms neither: their absolute values are
// summed. Compared with the greatest error of all amplitudes within half a step, at which the
// terms' phases differ, this is at most three times too much.
TEST(QuantisationBound, IsAtMostThreeTimesTheWorstError) {
  for (const int harmonics : {1, 5}) {
    for (const double noise : {0.0, 0.1, 0.3}) {
      for (const double amplitude : {0.75, 1.3, 2.2, 3.5, 7.75}) {
        double worst = 0;
        for (double near = amplitude - 0.5; near <= amplitude + 0.5; near += 0.125) {
          worst = std::max(worst, WorstError(near, noise, harmonics));
        }
        const double bound = QuantisationBound(1, amplitude, noise, harmonics);
        EXPECT_LE(bound, 3 * worst) << amplitude << ' ' << noise << ' ' << harmonics;
      }
    }
  }
}

TEST(QuantisationBound, ScalesWithTheStep) {
  for (const double amplitude : kAmplitudes) {
    EXPECT_EQ(QuantisationBound(0x1p-20, amplitude * 0x1p-20, 0x1p-23, 3),
              0x1p-20 * QuantisationBound(1, amplitude, 0x1p-3, 3));
  }
  EXPECT_EQ(QuantisationBound(0, 1e-6, 0, 3), 0);
}

TEST(QuantisationBound, NoiseOfHalfAStepLeavesAHundredthOfAStep) {
  for (const double amplitude : kAmplitudes) {
    EXPECT_LE(QuantisationBound(1, amplitude, 0.5, 5), 1e-2);
  }
}

// 9 cycles in 200 samples, as 225 Hz at 5 kHz, are 200 phases: rounded sines that differ in offset
// and phase scatter by no more than is stated
TEST(CommensurateBound, HoldsTheScatterOfRoundedSinesOfFewPhases) {
  constexpr std::size_t kSamples = 10'000;
  constexpr int kSines = 300;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const double amplitude : {5.3, 20.7, 60.3, 100.0}) {
    for (const double cycles : {9.0 / 200, 3.0 / 64, 7.0 / 30, 0.5 * (std::sqrt(5) - 1)}) {
      double square = 0;
      for (int k = 0; k < kSines; ++k) {
        const double phase = uniform(random);
        const double offset = uniform(random);
        double in_phase = 0;
        for (std::size_t n = 0; n < kSamples; ++n) {
          const double sine = std::sin(2 * std::numbers::pi *
                                       std::fmod(cycles * static_cast<double>(n) + phase, 1));
          in_phase += std::round(amplitude * sine + offset) * sine;
        }
        square += 0.5 * std::pow(2 * in_phase / kSamples - amplitude, 2);
      }
      const double bound = std::hypot(QuantisationBound(1, amplitude, 0, 1),
                                      CommensurateBound(1, amplitude, 0, cycles, kSamples));
      // a rectangle; 300 sines have their deviation to 4 %
      EXPECT_LE(std::sqrt(square / kSines), 1.12 * bound / std::numbers::sqrt3)
          << amplitude << ' ' << cycles;
    }
  }
  EXPECT_LT(CommensurateBound(1, 60, 0, 0.5 * (std::sqrt(5) - 1), kSamples), 0.011);
  EXPECT_LT(CommensurateBound(1, 60, 0.5, 0.25, kSamples), 0.01) << "noise of half a step";
  EXPECT_EQ(CommensurateBound(0, 60, 0, 0.25, kSamples), 0);
}

// The first terms of the series; with noise of 0.3 steps the fourth is exp(-28) of a step. The
// tone's own error counts in full, the second harmonic's by its power.
TEST(QuantisationBound, IsTheSeriesOfJacobiAndAnger) {
  const double step = 2e-7;
  const double amplitude = 3.3 * step;
  const auto error = [&](int n) {
    double sum = 0;
    for (int k = 1; k <= 3; ++k) {
      const double left = std::exp(-2 * std::pow(std::numbers::pi * k * 0.3, 2)) / k;
      sum += left * std::abs(std::cyl_bessel_j(n, 2 * std::numbers::pi * k * 3.3));
    }
    return 2 * step / std::numbers::pi * sum;
  };
  const double first = error(1) / std::numbers::sqrt2;
  EXPECT_REL(QuantisationBound(step, amplitude, 0.3 * step, 1), first, 1e-4,
             "terms of 1e-6 are left out");
  const double power = 0.5 * error(2) * error(2);
  const double second = std::min(std::sqrt(power), power / (std::numbers::sqrt2 * amplitude));
  EXPECT_REL(QuantisationBound(step, amplitude, 0.3 * step, 2), first + second, 1e-4,
             "terms of 1e-6 are left out");
}

// P phases: q / (2 sqrt(P)), noise s takes exp(-2 pi^2 s^2 / q^2) of it
TEST(CommensurateBound, IsTheClosedFormOfItsPhases) {
  EXPECT_REL(CommensurateBound(1e-6, 60e-6, 0, 0.25, 10'000), 1e-6 / 4, 1e-14, "four phases");
  EXPECT_REL(CommensurateBound(1e-6, 60e-6, 0, 9.0 / 200, 10'000), 1e-6 / (2 * std::sqrt(200.0)),
             1e-6, "200 phases, and what rounding lacks of whole cycles");
  EXPECT_REL(CommensurateBound(1, 60, 0.2, 0.25, 10'000),
             0.25 * std::exp(-2 * std::pow(0.2 * std::numbers::pi, 2)), 1e-14, "noise");
  // one phase lacks 1e-6 cycles a sample: 1 + N 1e-6 2 pi A / q phases
  EXPECT_REL(CommensurateBound(1, 2, 0, 1e-6, 10'000),
             0.5 / std::sqrt(1 + 0.01 * 2 * std::numbers::pi * 2), 1e-9, "drifting phases");
  EXPECT_REL(CommensurateBound(1, 60, 0, 0.5 * (std::sqrt(5) - 1), 16), 0.5 / 4, 1e-14,
             "no more phases than samples");
  EXPECT_EQ(CommensurateBound(1, 60, 0, 0.25, 0), 0);
}

// 3 of 103 changes are none, within motion of 10 steps a row: 2.9 %; 2 are 1.9 %
TEST(RepeatedShare, IsOfTwoPercentAtLeast) {
  for (const int repeats : {1, 2, 3}) {
    std::vector<double> values;
    for (int k = 0; k < 101; ++k) {
      values.push_back(10 * k + k % 3);
      if (k % 30 == 15 && k / 30 < repeats) values.push_back(values.back());
    }
    const double share = repeats / (100.0 + repeats);
    EXPECT_REL(RepeatedShare(values) + 1, share < 0.02 ? 1 : 1 + share, 1e-14, "rounding")
        << repeats;
  }
}

TEST(StepOf, AllowsAHundredthOfAStepAndAnEighthOfTheLeastChange) {
  EXPECT_EQ(StepOf(std::vector<double>{0, 1, 2.0098}), 1);
  EXPECT_EQ(StepOf(std::vector<double>{0, 1, 2.0102}), 0);
  // changes of 8 and 9, and of 9 and 10 steps
  EXPECT_EQ(StepOf(std::vector<double>{0, 8, 17}), 1);
  EXPECT_EQ(StepOf(std::vector<double>{0, 9, 19}), 0);
}

}  // namespace
}  // namespace haptometer::dsp
