#include "dsp/spectrum/frequency_response.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRateHz = 2000;
constexpr double kResonanceHz = 225;
constexpr double kQuality = 15;
constexpr double kGain = 2e-6;  // m/V at rest

std::complex<double> ClosedForm(double frequency_hz) {
  const double u = frequency_hz / kResonanceHz;
  return kGain / std::complex<double>(1 - u * u, u / kQuality);
}

struct Sweep {
  std::vector<double> drive_v;
  std::vector<double> displacement_m;
};

// 2 V from `from_hz` to `to_hz` in `duration_s`, on a mass and
// spring: Runge and Kutta's fourth order, 20 steps a sample, wrong by (w h)^4/120 = 1e-8
Sweep Swept(double from_hz, double to_hz, double duration_s) {
  constexpr int kSteps = 20;
  const double h = 1 / kRateHz / kSteps;
  const double w = 2 * kPi * kResonanceHz;
  const auto drive = [=](double t_s) {
    return 2 * std::sin(2 * kPi * (from_hz + 0.5 * (to_hz - from_hz) * t_s / duration_s) * t_s);
  };
  using State = std::array<double, 2>;
  const auto slope = [=](const State& s, double t_s) {
    return State{s[1], w * w * (kGain * drive(t_s) - s[0]) - w / kQuality * s[1]};
  };
  const auto ahead = [](const State& s, const State& k, double by) {
    return State{s[0] + by * k[0], s[1] + by * k[1]};
  };
  Sweep sweep;
  State s{};
  const auto samples = static_cast<int>(duration_s * kRateHz);
  for (int n = 0; n < samples; ++n) {
    sweep.drive_v.push_back(drive(n / kRateHz));
    sweep.displacement_m.push_back(s[0]);
    for (int step = 0; step < kSteps; ++step) {
      const double t_s = n / kRateHz + step * h;
      const State a = slope(s, t_s);
      const State b = slope(ahead(s, a, h / 2), t_s + h / 2);
      const State c = slope(ahead(s, b, h / 2), t_s + h / 2);
      const State d = slope(ahead(s, c, h), t_s + h);
      for (std::size_t i = 0; i < 2; ++i) s[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    }
  }
  return sweep;
}

TEST(FrequencyResponse, OfASweptOscillatorIsTheClosedForm) {
  const Sweep sweep = Swept(60, 500, 16);
  // segments of 4 s: sixty times Q / f0
  const auto points =
      MeasureResponse(sweep.drive_v, sweep.displacement_m, {kRateHz, 8000}, 100, 450).value();
  ASSERT_EQ(points.size(), 1401U);
  double worst = 0;
  double least_coherence = 1;
  for (const ResponsePoint& point : points) {
    const std::complex<double> truth = ClosedForm(point.frequency_hz);
    worst = std::max(worst, std::abs(point.response / truth - 1.0));
    least_coherence = std::min(least_coherence, point.coherence);
  }
  EXPECT_ABS(worst, 0, 0.01, "a window of 60 Q / f0: measured");
  EXPECT_GT(least_coherence, 0.999);
  const Resonance found = FitResonance(std::span<const ResponsePoint>(points));
  ASSERT_TRUE(found.converged);
  EXPECT_REL(found.frequency_hz, kResonanceHz, 1e-4, "the window's width: measured");
  EXPECT_REL(found.quality_factor, kQuality, 3e-3, "the window's width: measured");
  EXPECT_REL(found.gain, kGain, 3e-3, "the window's width: measured");
}

TEST(FrequencyResponse, NoiseLowersCoherenceAndIsStated) {
  Sweep sweep = Swept(60, 500, 16);
  Noise noise(3);
  for (double& x : sweep.displacement_m) x += 2e-6 * noise();
  const auto points =
      MeasureResponse(sweep.drive_v, sweep.displacement_m, {kRateHz, 2000}, 100, 450).value();
  int held = 0;
  for (const ResponsePoint& point : points) {
    const std::complex<double> truth = ClosedForm(point.frequency_hz);
    const double off = std::abs(std::abs(point.response) / std::abs(truth) - 1);
    held += off <= 1.96 * point.relative_uncertainty + 0.01 ? 1 : 0;
  }
  EXPECT_GE(held, static_cast<int>(0.9 * static_cast<double>(points.size())))
      << "95 % each, of neighbours that share a window's bins";
  const Resonance found = FitResonance(std::span<const ResponsePoint>(points));
  ASSERT_TRUE(found.converged);
  EXPECT_ABS(found.frequency_hz, kResonanceHz, 4 * found.frequency_uncertainty_hz, "as stated");
  EXPECT_ABS(found.quality_factor, kQuality, 4 * found.quality_factor_uncertainty + 0.15,
             "as stated, and 1 % of the window's width");
}

TEST(FrequencyResponse, WithoutADriveChannelTheSweepIsItsOwn) {
  // 440 Hz in 40 s; late by up to 11 Q / (pi f0) = 0.23 Hz
  const Sweep sweep = Swept(60, 500, 40);
  const auto points = SweptAmplitude(sweep.displacement_m, kRateHz, 80, 480);
  ASSERT_GT(points.size(), 500U);
  double worst = 0;
  double late_hz = 0;
  for (const SweptPoint& point : points) {
    late_hz = std::max(late_hz, std::abs(point.frequency_hz - (60 + 11 * point.time_s)));
    const double truth = 2 * std::abs(ClosedForm(point.frequency_hz));
    worst = std::max(worst, std::abs(point.amplitude / truth - 1));
  }
  EXPECT_ABS(late_hz, 0, 0.3, "Q / (pi f0) seconds of the sweep");
  EXPECT_ABS(worst, 0, 0.02, "on the flank, 0.12 Hz late, in 7.5: measured");
  const Resonance found = FitResonance(std::span<const SweptPoint>(points));
  ASSERT_TRUE(found.converged);
  EXPECT_ABS(found.frequency_hz, kResonanceHz, 0.23, "the stated lateness");
  EXPECT_REL(found.quality_factor, kQuality, 1e-3, "measured");
  EXPECT_REL(found.gain, 2 * kGain, 1e-3, "measured");
}

// exact points about the resonance, with noise
std::vector<ResponsePoint> Points(double relative_noise, Noise& noise) {
  std::vector<ResponsePoint> points;
  points.reserve(60);
  for (int k = 0; k < 60; ++k) {
    const double frequency_hz = 180.0 + 1.5 * k;
    const std::complex<double> truth = std::polar(1.0, 0.4) * ClosedForm(frequency_hz);
    const std::complex<double> error(relative_noise * noise(), relative_noise * noise());
    points.push_back({frequency_hz, truth * (1.0 + error), 1, relative_noise});
  }
  return points;
}

TEST(Resonance, ExactPointsGiveItBack) {
  Noise noise(1);
  const Resonance found = FitResonance(std::span<const ResponsePoint>(Points(0, noise)));
  ASSERT_TRUE(found.converged);
  EXPECT_REL(found.frequency_hz, kResonanceHz, 1e-14, "rounding");
  EXPECT_REL(found.quality_factor, kQuality, 1e-12, "rounding");
  EXPECT_REL(found.gain, kGain, 1e-12, "rounding");
  std::vector<SweptPoint> amplitudes;
  for (const ResponsePoint& point : Points(0, noise)) {
    amplitudes.push_back({0, point.frequency_hz, std::abs(point.response)});
  }
  const Resonance magnitude = FitResonance(std::span<const SweptPoint>(amplitudes));
  ASSERT_TRUE(magnitude.converged);
  EXPECT_REL(magnitude.frequency_hz, kResonanceHz, 1e-14, "rounding");
  EXPECT_REL(magnitude.quality_factor, kQuality, 1e-12, "rounding");
}

TEST(Resonance, IntervalsHoldTheTruth) {
  constexpr int kRepetitions = 2000;
  constexpr double kT116 = 1.9806;  // Student's t, 97.5 %, 2 x 60 - 4 degrees of freedom
  Noise noise(23);
  int frequency = 0;
  int quality = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    const Resonance found = FitResonance(std::span<const ResponsePoint>(Points(0.02, noise)));
    ASSERT_TRUE(found.converged);
    frequency +=
        std::abs(found.frequency_hz - kResonanceHz) <= kT116 * found.frequency_uncertainty_hz ? 1
                                                                                              : 0;
    quality += std::abs(found.quality_factor - kQuality) <= kT116 * found.quality_factor_uncertainty
                   ? 1
                   : 0;
  }
  EXPECT_NEAR(frequency, 1900, 40) << "95 % +- 2 % of 2000";
  EXPECT_NEAR(quality, 1900, 40);
}

TEST(Resonance, IsNotMadeUp) {
  EXPECT_FALSE(FitResonance(std::span<const ResponsePoint>()).converged);
  Noise noise(2);
  const auto points = Points(0, noise);
  EXPECT_FALSE(FitResonance(std::span(points).first(2)).converged) << "four numbers for four";
  EXPECT_FALSE(FitResonance(std::span(points).first(15)).converged)
      << "180 to 201 Hz: the resonance lies outside";
  EXPECT_FALSE(
      MeasureResponse(std::vector<double>(100), std::vector<double>(100), {kRateHz, 100}, 100, 450))
      << "one segment";
  EXPECT_TRUE(SweptAmplitude(std::vector<double>(100), kRateHz, 80, 480).empty());
}

// of one point, chance gives a coherence above 1 - 0.05^(1 / (m - 1)) in 5 %, m = 0.94 segments
TEST(KeepSignificant, OfOnePointIsTheLevelOfFivePercent) {
  constexpr double kSegments = 10;
  const double level = 1 - std::pow(0.05, 1 / (0.94 * kSegments - 1));
  for (const double beside : {-1e-6, 1e-6}) {
    std::vector<ResponsePoint> points(1);
    points[0].coherence = level + beside;
    KeepSignificant(points, kSegments);
    EXPECT_EQ(points.empty(), beside < 0);
  }
}

}  // namespace
}  // namespace haptometer::dsp
