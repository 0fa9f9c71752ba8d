#include "dsp/spectrum/envelope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRateHz = 10e3;
constexpr double kToneHz = 225;
constexpr double kOnset_s = 0.2;
const double kOwnRise_s = DemodulateTone(std::vector<double>(400), {kRateHz, kToneHz}).own_rise_s;

// a tone of 5 um whose amplitude is `shape` of the time since kOnset_s, 0 before
std::vector<double> Shaped(const std::function<double(double)>& shape, double phase_rad,
                           std::size_t count = 6000) {
  std::vector<double> signal(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    const double amplitude = t_s < kOnset_s ? 0 : shape(t_s - kOnset_s);
    signal[k] = 5e-6 * amplitude * std::cos(2 * kPi * kToneHz * t_s + phase_rad);
  }
  return signal;
}

double Sudden(double) { return 1; }

std::optional<Edge> OnsetOf(const std::vector<double>& signal) {
  return FindOnset(DemodulateTone(signal, {kRateHz, kToneHz}), {0.02, 0.15, 0.45, 0.55});
}

// the worst deviations over sixteen phases of the tone, in the window's own rise
struct Worst {
  double time = 0;
  double rise = 0;
  int resolved = 0;
};

Worst Deviations(const std::function<double(double)>& shape, double tenth_s, double rise_s) {
  Worst worst;
  for (int phase = 0; phase < 16; ++phase) {
    const auto edge = OnsetOf(Shaped(shape, 2 * kPi * phase / 16));
    EXPECT_TRUE(edge);
    if (!edge) continue;
    const double time = (edge->time_s - kOnset_s - tenth_s) / kOwnRise_s;
    if (std::abs(time) > std::abs(worst.time)) worst.time = time;
    EXPECT_TRUE(!edge->rise_at_most_s || *edge->rise_at_most_s >= rise_s);
    if (!edge->rise_s) continue;
    ++worst.resolved;
    const double rise = (*edge->rise_s - rise_s) / kOwnRise_s;
    if (std::abs(rise) > std::abs(worst.rise)) worst.rise = rise;
  }
  return worst;
}

TEST(Onset, OfASuddenTone) {
  const Worst worst = Deviations(Sudden, 0, 0);
  EXPECT_ABS(worst.time, 0, 0.18, "the stated bound, in the window's own rise");
  EXPECT_EQ(worst.resolved, 0) << "faster than the window";
  RecordProperty("own_rise_us", static_cast<int>(kOwnRise_s * 1e6));
}

TEST(Onset, OfExponentialRises) {
  // 1 - exp(-t/tau) passes 10 % at ln(10/9) tau and takes ln(9) tau = 2.197 tau to 90 %
  for (const double tau_s : {0.0005, 0.001, 0.002, 0.004, 0.008, 0.016, 0.032}) {
    const Worst worst = Deviations([tau_s](double t_s) { return 1 - std::exp(-t_s / tau_s); },
                                   std::log(10.0 / 9) * tau_s, std::log(9) * tau_s);
    EXPECT_ABS(worst.time, 0, 0.18, "the stated bound, in the window's own rise");
    EXPECT_ABS(worst.rise, 0, 0.12, "the stated bound, in the window's own rise");
    EXPECT_EQ(worst.resolved, std::log(9) * tau_s > kOwnRise_s ? 16 : worst.resolved) << tau_s;
  }
}

TEST(Onset, OfStraightRises) {
  for (const double rise_s : {0.001, 0.002, 0.004, 0.008, 0.016, 0.05, 0.1}) {
    const double whole_s = rise_s / 0.8;
    const Worst worst = Deviations([whole_s](double t_s) { return std::min(1.0, t_s / whole_s); },
                                   0.1 * whole_s, rise_s);
    EXPECT_ABS(worst.time, 0, 0.18, "the stated bound, in the window's own rise");
    EXPECT_ABS(worst.rise, 0, 0.12, "the stated bound, in the window's own rise");
  }
}

TEST(Onset, TremorAndOffsetOfAHandDoNotMoveIt) {
  std::vector<double> signal = Shaped(Sudden, 1);
  for (std::size_t k = 0; k < signal.size(); ++k) {
    signal[k] += 0.03 + 50e-6 * std::sin(2 * kPi * 8.3 * static_cast<double>(k) / kRateHz);
  }
  const auto edge = OnsetOf(signal);
  ASSERT_TRUE(edge);
  EXPECT_ABS(edge->time_s, kOnset_s, 3 * edge->time_uncertainty_s, "as stated");
  EXPECT_LT(edge->time_uncertainty_s, 1e-3);
}

TEST(Onset, IntervalsUnderNoiseHoldTheTruth) {
  // noise of 12 % of the amplitude a sample; 500 onsets at every phase
  Noise noise(21);
  int held = 0;
  constexpr int kRecords = 500;
  for (int r = 0; r < kRecords; ++r) {
    std::vector<double> signal = Shaped(Sudden, 0.7 * r, 3000);
    for (double& x : signal) x += 0.6e-6 * noise();
    const auto edge =
        FindOnset(DemodulateTone(signal, {kRateHz, kToneHz}), {0.02, 0.15, 0.23, 0.28});
    ASSERT_TRUE(edge);
    held += std::abs(edge->time_s - kOnset_s) <= 1.96 * edge->time_uncertainty_s ? 1 : 0;
  }
  EXPECT_GE(held, 475) << "95 % of 500: the interval holds a bound";
}

TEST(Onset, IsNotMadeUp) {
  const std::vector<double> quiet(6000, 0.03);
  EXPECT_FALSE(OnsetOf(quiet));
  Noise noise(4);
  std::vector<double> noisy(6000);
  for (double& x : noisy) x = noise();
  EXPECT_FALSE(OnsetOf(noisy));
  const std::vector<double> throughout = Samples(kRateHz, 6000, 0, {{1e-6, kToneHz, 0}});
  EXPECT_FALSE(OnsetOf(throughout)) << "it never was below";
  EXPECT_FALSE(FindOnset({}, {0, 1, 2, 3}));
  const Envelope envelope = DemodulateTone(Shaped(Sudden, 0), {kRateHz, kToneHz});
  EXPECT_FALSE(FindOnset(envelope, {-1, 0.1, 0.4, 0.5})) << "before the record";
}

TEST(Envelope, OfASteadyToneIsItsAmplitude) {
  const std::vector<double> signal =
      Samples(kRateHz, 3000, 0.03, {{5e-6, kToneHz, 0.3}, {1e-6, 3 * kToneHz, 1}});
  const Envelope envelope = DemodulateTone(signal, {kRateHz, kToneHz});
  const auto [least, most] = std::ranges::minmax(envelope.amplitude);
  EXPECT_REL(least, 5e-6, 2e-3, "the third multiple, 0.2 of it, through 133 samples for 133.3");
  EXPECT_REL(most, 5e-6, 2e-3, "the same");
  EXPECT_TRUE(DemodulateTone(std::vector<double>(100), {kRateHz, kToneHz}).amplitude.empty());
  EXPECT_TRUE(DemodulateTone(signal, {kRateHz, 5001}).amplitude.empty());
}

TEST(Envelope, TheAnalyticSignalOfACosineTurnsOnce) {
  // whole periods: exp(j w t), to rounding
  for (const auto& [count, periods] : {std::pair{1000UZ, 9UZ}, {999UZ, 9UZ}, {997UZ, 498UZ}}) {
    std::vector<double> signal(count);
    std::vector<double> angles(count);
    for (std::size_t k = 0; k < count; ++k) {
      angles[k] = 2 * kPi * static_cast<double>(periods * k % count) / static_cast<double>(count);
      signal[k] = std::cos(angles[k]);
    }
    const auto analytic = AnalyticSignal(signal);
    double worst = 0;
    for (std::size_t k = 0; k < count; ++k) {
      worst = std::max(worst, std::abs(analytic[k] - std::polar(1.0, angles[k])));
    }
    EXPECT_ABS(worst, 0, 1e-13, "rounding of two transforms");
  }
}

// An envelope whose power above the quiet part's rises from 0 to 1 in a straight line of amplitude,
// 100 steps of 1 ms from 0.6 s on: it passes 10 %, 50 % and 90 % at 0.61, 0.65 and 0.69 s.
Envelope Ramp(double quiet, double own_rise_s) {
  Envelope envelope{.amplitude = {},
                    .start_s = 0.5,
                    .step_s = 1e-3,
                    .support_s = 16e-3,
                    .own_rise_s = own_rise_s};
  for (int k = 0; k < 400; ++k) {
    envelope.amplitude.push_back(std::hypot(quiet, std::clamp(0.01 * (k - 100), 0.0, 1.0)));
  }
  return envelope;
}

std::optional<Edge> OnsetOfRamp(double quiet, double own_rise_s) {
  return FindOnset(Ramp(quiet, own_rise_s), {0.5, 0.59, 0.75, 0.85});
}

TEST(Onset, OfARampWithoutNoiseIsTheClosedForm) {
  const auto edge = OnsetOfRamp(0, 0.03);
  ASSERT_TRUE(edge && edge->rise_s);
  constexpr const char* kReason = "rounding";
  const double share = std::sqrt(1 - 0.03 * 0.03 / (0.08 * 0.08));
  EXPECT_REL(edge->time_s, 0.65 - 0.04 * share, 1e-12, kReason);
  EXPECT_REL(*edge->rise_s, 0.08 * share, 1e-12, kReason);
  EXPECT_REL(edge->time_uncertainty_s, 0.18 / std::numbers::sqrt3 * 0.03, 1e-12, kReason);
  EXPECT_REL(edge->rise_uncertainty_s, 0.12 / std::numbers::sqrt3 * 0.03, 1e-12, kReason);
  EXPECT_FALSE(edge->rise_at_most_s);
  EXPECT_EQ(edge->low_level, 0.1);
  EXPECT_EQ(edge->quiet_amplitude, 0);
  EXPECT_REL(edge->steady_amplitude, 1, 1e-14, kReason);
}

// one of two parts of noise of RMS 0.02 on a slope of 10 a second: 1.41 ms at each level
TEST(Onset, NoiseOverTheSlopeIsTheUncertaintyOfEachLevel) {
  const auto edge = OnsetOfRamp(0.02, 0);
  ASSERT_TRUE(edge && edge->rise_s);
  const double of_level_s = 0.02 / std::numbers::sqrt2 / 10;
  EXPECT_REL(edge->time_s, 0.61, 1e-9, "no rise of its own to take off");
  EXPECT_REL(*edge->rise_s, 0.08, 1e-9, "rounding");
  EXPECT_REL(edge->rise_uncertainty_s, std::numbers::sqrt2 * of_level_s, 1e-9, "of two levels");
  EXPECT_GE(edge->time_uncertainty_s, of_level_s);
  EXPECT_LE(edge->time_uncertainty_s, 2 * of_level_s);
}

TEST(Onset, TheLowLevelIsThreeTimesTheNoise) {
  const auto edge = OnsetOfRamp(0.05, 0);
  ASSERT_TRUE(edge);
  EXPECT_REL(edge->low_level, 0.15, 1e-9, "rounding");
  EXPECT_REL(edge->time_s, 0.615, 1e-9, "rounding");
  EXPECT_FALSE(edge->rise_s) << "the time from 10 % is not measured";
  EXPECT_FALSE(edge->rise_at_most_s);
  EXPECT_TRUE(OnsetOfRamp(0.0333, 0)->rise_s);
  EXPECT_FALSE(OnsetOfRamp(0.0334, 0)->rise_s);
  EXPECT_TRUE(OnsetOfRamp(0.166, 0));
  EXPECT_FALSE(OnsetOfRamp(0.167, 0)) << "a sixth";
}

// sqrt(0.08^2 - own^2) is 2/3 of own at own = 0.08 / sqrt(13/9)
TEST(Onset, ARiseBelowTwoThirdsOfTheWindowsHasABound) {
  const double limit_s = 0.08 * 3 / std::sqrt(13.0);
  const auto slow = OnsetOfRamp(0, 0.999 * limit_s);
  ASSERT_TRUE(slow);
  EXPECT_TRUE(slow->rise_s && !slow->rise_at_most_s);
  const auto sudden = OnsetOfRamp(0, 1.001 * limit_s);
  ASSERT_TRUE(sudden && sudden->rise_at_most_s);
  EXPECT_FALSE(sudden->rise_s);
  EXPECT_REL(*sudden->rise_at_most_s, 1.001 * limit_s * 2 / 3, 1e-12, "no noise");
  // no longer than the window's own: the half level itself
  EXPECT_REL(OnsetOfRamp(0, 0.081)->time_s, 0.65, 1e-12, "rounding");
}

TEST(Onset, ReadsWithinTheEnvelopeOnly) {
  const Envelope envelope = Ramp(0, 0);
  EXPECT_TRUE(FindOnset(envelope, {0.4999, 0.59, 0.75, 0.8995}));
  EXPECT_FALSE(FindOnset(envelope, {0.4989, 0.59, 0.75, 0.85})) << "a value before the first";
  EXPECT_FALSE(FindOnset(envelope, {0.5, 0.59, 0.75, 0.9001})) << "a value behind the last";
  EXPECT_FALSE(FindOnset(envelope, {0.5102, 0.5108, 0.75, 0.85})) << "no value between";
}

// Of many periods a sudden tone rises as the sum of Hann's weights, x - sin(2 pi x) / (2 pi): from
// 10 % to 90 % in 0.481 of the window.
TEST(Envelope, OwnRiseIsThatOfHannsWeights) {
  double low = 0;
  double high = 0.5;
  for (int step = 0; step < 50; ++step) {
    const double x = 0.5 * (low + high);
    (x - std::sin(2 * kPi * x) / (2 * kPi) < 0.1 ? low : high) = x;
  }
  const double share = 1 - 2 * low;
  const Envelope many = DemodulateTone(std::vector<double>(2000), {kRateHz, 250, 40});
  EXPECT_REL(many.own_rise_s, share * 0.16, 2e-3, "40 periods: the parabola shares little");
  const Envelope three = DemodulateTone(std::vector<double>(400), {kRateHz, kToneHz});
  EXPECT_ABS(three.own_rise_s / three.support_s, 0.48, 0.02, "the stated share of three periods");
}

TEST(Envelope, TimesAreThoseOfTheWindowsMiddles) {
  // three periods of 133.3 samples: 133, in steps of 4
  const Envelope envelope = DemodulateTone(std::vector<double>(300), {kRateHz, kToneHz});
  EXPECT_REL(envelope.start_s, 66e-4, 1e-14, "rounding");
  EXPECT_REL(envelope.step_s, 4e-4, 1e-14, "rounding");
  EXPECT_REL(envelope.support_s, 133e-4, 1e-14, "rounding");
  EXPECT_EQ(envelope.amplitude.size(), 42U) << "(300 - 133) / 4 + 1";
  EXPECT_EQ(DemodulateTone(std::vector<double>(133), {kRateHz, kToneHz}).amplitude.size(), 1U);
  EXPECT_TRUE(DemodulateTone(std::vector<double>(132), {kRateHz, kToneHz}).amplitude.empty());
  // 8 samples a window at least
  EXPECT_FALSE(DemodulateTone(std::vector<double>(100), {kRateHz, 3750}).amplitude.empty());
  EXPECT_TRUE(DemodulateTone(std::vector<double>(100), {kRateHz, 4290}).amplitude.empty());
}

// an amplitude of ((k - 100) / 100)^2 of 1 from value 100 on, 1 from value 200 on
Envelope Parabola() {
  Envelope envelope = Ramp(0, 0);
  for (double& x : envelope.amplitude) x *= x;
  return envelope;
}

// levels pass within chords: 10 % from 0.0961 to 0.1024, 90 % from 0.8836 to 0.9025
TEST(Onset, LevelsArePassedOnChords) {
  const auto edge = FindOnset(Parabola(), {0.5, 0.59, 0.75, 0.85});
  ASSERT_TRUE(edge && edge->rise_s);
  const double low = 131 + 0.0039 / 0.0063;
  const double high = 194 + 0.0164 / 0.0189;
  EXPECT_REL(edge->time_s, 0.5 + 1e-3 * low, 1e-12, "rounding");
  EXPECT_REL(*edge->rise_s, 1e-3 * (high - low), 1e-11, "rounding");
}

// values 0 to 90 and 250 to 350; what lies next to these does not count
TEST(Onset, QuietAndSteadyPartEndWithTheirLastValue) {
  Envelope envelope = Ramp(0, 0);
  envelope.amplitude[91] = 0.3;
  envelope.amplitude[249] = 2;
  envelope.amplitude[351] = 2;
  const auto edge = FindOnset(envelope, {0.5, 0.5905, 0.7495, 0.8505});
  ASSERT_TRUE(edge);
  EXPECT_EQ(edge->quiet_amplitude, 0);
  EXPECT_REL(edge->steady_amplitude, 1, 1e-14, "rounding");
  envelope.amplitude[90] = 0.03;
  envelope.amplitude[350] = 2;
  const auto with = FindOnset(envelope, {0.5, 0.5905, 0.7495, 0.8505});
  ASSERT_TRUE(with);
  const double quiet = 0.03 / std::sqrt(91.0);
  EXPECT_REL(with->quiet_amplitude, quiet, 1e-12, "rounding");
  EXPECT_REL(with->steady_amplitude, std::sqrt(104.0 / 101 - quiet * quiet), 1e-12, "rounding");
}

// Slopes reach an eighth of the window to either side of the low level, at value 110, and half of
// it about the high one, at 190; the ramp is from 100 to 200, and values end at 399.
TEST(Onset, UncertaintyIsOfTheSlopeOverPartsOfTheWindow) {
  constexpr double kQuiet = 0.02;
  constexpr double kOwnRise = 0.03;
  for (const double support : {79.6, 430.0}) {
    Envelope envelope = Ramp(kQuiet, kOwnRise);
    envelope.support_s = 1e-3 * support;
    const auto edge = FindOnset(envelope, {0.5, 0.59, 0.75, 0.85});
    ASSERT_TRUE(edge && edge->rise_s);
    const auto level = [](double k) { return std::clamp(0.01 * (k - 100), 0.0, 1.0); };
    const auto noise_s = [&](double at, double reach) {
      const double before = std::max(0.0, std::floor(at - reach));
      const double after = std::min(399.0, std::ceil(at + reach));
      const double slope = (level(after) - level(before)) / (after - before);
      return kQuiet / std::numbers::sqrt2 / slope * 1e-3;
    };
    const double low = noise_s(110, support / 8);
    const double both = std::hypot(low, noise_s(190, support / 2));
    const auto without_own = [&](double interval, double measured) {
      return interval * std::sqrt(1 - std::pow(kOwnRise / measured, 2));
    };
    const double early = without_own(0.04 + low, 0.08 + both);
    const double late = without_own(0.04 - low, 0.08 - both);
    constexpr const char* kReason = "rounding of roots";
    EXPECT_REL(edge->time_uncertainty_s,
               std::hypot(low, 0.5 * (early - late), 0.18 / std::numbers::sqrt3 * kOwnRise), 1e-9,
               kReason);
    EXPECT_REL(edge->rise_uncertainty_s,
               std::hypot(both * 0.08 / *edge->rise_s, 0.12 / std::numbers::sqrt3 * kOwnRise), 1e-9,
               kReason);
  }
}

// rows of cosine and sine of (X'WX)^-1 X'W by Gauss and Jordan: X is cosine, sine and a parabola of
// eleven samples, W Hann's weights that are 0 just beyond them
using Rows = std::array<std::array<double, 11>, 2>;
Rows LeastSquares(double rad_per_sample) {
  std::array<std::array<double, 5>, 11> x{};
  std::array<double, 11> weights{};
  for (std::size_t k = 0; k < 11; ++k) {
    const double t = static_cast<double>(k) - 5;
    x[k] = {std::cos(rad_per_sample * t), std::sin(rad_per_sample * t), 1, t, t * t};
    weights[k] = std::pow(std::cos(kPi * t / 12), 2);
  }
  // five equations, with the weighted columns as right sides
  std::array<std::array<double, 16>, 5> rows{};
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t k = 0; k < 11; ++k) {
      for (std::size_t j = 0; j < 5; ++j) rows[i][j] += x[k][i] * weights[k] * x[k][j];
      rows[i][5 + k] = x[k][i] * weights[k];
    }
  }
  for (std::size_t i = 0; i < 5; ++i) {
    const double pivot = rows[i][i];
    for (double& value : rows[i]) value /= pivot;
    for (std::size_t other = 0; other < 5; ++other) {
      const double factor = rows[other][i];
      for (std::size_t j = 0; other != i && j < 16; ++j) rows[other][j] -= factor * rows[i][j];
    }
  }
  Rows kernel{};
  for (std::size_t part = 0; part < 2; ++part) {
    for (std::size_t k = 0; k < 11; ++k) kernel[part][k] = rows[part][5 + k];
  }
  return kernel;
}

TEST(Envelope, IsAWeightedLeastSquaresFit) {
  const double w = 2 * kPi * 2.7 / 11;
  const Rows kernel = LeastSquares(w);
  Noise noise(5);
  std::vector<double> signal(11);
  double cosine = 0;
  double sine = 0;
  for (std::size_t k = 0; k < signal.size(); ++k) {
    signal[k] = noise();
    cosine += kernel[0][k] * signal[k];
    sine += kernel[1][k] * signal[k];
  }
  const Envelope found = DemodulateTone(signal, {11, 2.7, 2.7});
  ASSERT_EQ(found.amplitude.size(), 1U);
  EXPECT_REL(found.amplitude[0], std::hypot(cosine, sine), 1e-11, "rounding");
  // the rise of a tone that begins within: half of the kernel along the tone, from 10 to 90 %
  double sum = 0;
  double tenth = 0;
  for (std::size_t k = 0; k < signal.size() && sum < 0.1; ++k) {
    const double angle = w * (static_cast<double>(k) - 5);
    const double part = 0.5 * (kernel[0][k] * std::cos(angle) + kernel[1][k] * std::sin(angle));
    tenth = static_cast<double>(k) + (0.1 - sum) / part;
    sum += part;
  }
  EXPECT_REL(found.own_rise_s, (11 - 2 * tenth) / 11, 1e-11, "rounding");
}

TEST(Envelope, MovesByAThirtySecondOfTheWindow) {
  const std::vector<double> signal(1000);
  EXPECT_REL(DemodulateTone(signal, {48e3, 225}).step_s, 20 / 48e3, 1e-14, "640 samples");
}

}  // namespace
}  // namespace haptometer::dsp
