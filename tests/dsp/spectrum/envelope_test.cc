#include "dsp/spectrum/envelope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
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
  for (const std::size_t count : {1000U, 999U}) {
    std::vector<double> signal(count);
    for (std::size_t k = 0; k < count; ++k) {
      signal[k] = std::cos(2 * kPi * 9 * static_cast<double>(k) / static_cast<double>(count));
    }
    const auto analytic = AnalyticSignal(signal);
    double worst = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double angle = 2 * kPi * 9 * static_cast<double>(k) / static_cast<double>(count);
      worst = std::max(worst, std::abs(analytic[k] - std::polar(1.0, angle)));
    }
    EXPECT_ABS(worst, 0, 1e-13, "rounding of two transforms and of phases to 57 rad");
  }
}

}  // namespace
}  // namespace haptometer::dsp
