// Numbers of a window's tone from those of its fit; the oracle is the closed form of each.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "tests/dsp/analysis/window/made_window.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRound = 1e-13;
constexpr double kFrequency = 22.4;  // near the corner, so that the filter's gain is not 1

// a window of 2 s with a fit of 1 um
struct Fitted : MadeWindow {
  Fitted() : MadeWindow(TwoSeconds()) {
    window.numbers.tone.emplace().fit = {.frequency_hz = kFrequency,
                                         .amplitude = 1e-6,
                                         .frequency_uncertainty_hz = 1e-4,
                                         .amplitude_uncertainty = 2e-9,
                                         .phase_uncertainty_rad = 3e-3};
    window.numbers.power.mean_square = 0.64e-12;
    gain = std::norm(Response(signal.design(), kFrequency));
  }
  const ToneNumbers& Finished() {
    FinishTone(window);
    return *window.numbers.tone;
  }
  double gain = 0;
};

TEST(FinishTone, FilterAndSensorAreDividedOut) {
  Fitted made;
  made.window.power.sensor_gain = 0.6;
  const ToneNumbers& tone = made.Finished();
  EXPECT_LT(made.gain, 0.95) << "else nothing is shown";
  EXPECT_REL(tone.fit.amplitude, 1e-6 / made.gain, kRound, "two passes");
  EXPECT_REL(tone.fit.amplitude_uncertainty, 2e-9 / made.gain, kRound, "the same");
  EXPECT_REL(tone.amplitude_m, 1e-6 / made.gain / 0.6, kRound, "the sensor's gain");
  EXPECT_REL(tone.amplitude_uncertainty_m, 2e-9 / made.gain / 0.6, kRound, "the same");
  EXPECT_REL(tone.sine_rms_m, 1e-6 / std::numbers::sqrt2, kRound, "behind the filter");
  EXPECT_REL(tone.share_of_rms, 1 / (0.8 * std::numbers::sqrt2), kRound, "of 0.8 um");
  const double turn = 2 * kPi * kFrequency;
  EXPECT_REL(tone.velocity_m_per_s, turn * tone.amplitude_m, kRound, "rounding");
  EXPECT_REL(tone.acceleration_m_per_s2, turn * turn * tone.amplitude_m, kRound, "rounding");
}

// Student's 97.5 % point of 96 degrees of freedom is 1.98498, from tables.
TEST(FinishTone, IntervalsAreNinetyFivePercentOfStudents) {
  Fitted made;
  const ToneNumbers& tone = made.Finished();
  const double u = tone.amplitude_uncertainty_m;
  constexpr double kDigits = 5e-5;  // four digits of the quantile
  EXPECT_REL(tone.amplitude_upper_m - tone.amplitude_m, 1.98498 * u, kDigits, "four digits");
  EXPECT_REL(tone.amplitude_m - tone.amplitude_lower_m, 1.98498 * u, kDigits, "four digits");
  EXPECT_REL(tone.frequency_upper_hz - kFrequency, 1.98498e-4, kDigits, "four digits");
  EXPECT_REL(kFrequency - tone.frequency_lower_hz, 1.98498e-4, kDigits, "four digits");
}

// Var(a^2 / 2) = a^2 u^2: noise of which the variance is nine times what the fit took for white.
TEST(FinishTone, NoiseNearTheToneScalesAllUncertainties) {
  Fitted made;
  made.window.tone_variance = 36e-18 * 1e-12;
  const SineFit& fit = made.Finished().fit;
  EXPECT_REL(fit.amplitude_uncertainty, 6e-9 / made.gain, kRound, "three times 2 nm");
  EXPECT_REL(fit.frequency_uncertainty_hz, 3e-4, kRound, "the same factor");
  EXPECT_REL(fit.phase_uncertainty_rad, 9e-3, kRound, "the same factor");
}

// A line of RMS l moves the fit over T by 2 l / T (1 / D + 1 / D'), its frequency by 6 / (A T) of
// that, D and D' 2 pi times the distances of the line and of its mirror.
TEST(FinishTone, WhatLeaksFromBelowIsUncertain) {
  Fitted made;
  made.window.numbers.below_band = BelowBand{.frequency_hz = 8, .leaked_rms_m = 1e-7};
  const SineFit& fit = made.Finished().fit;
  const double moved_m = 2 * 1e-7 / 2 / (2 * kPi) * (1 / (kFrequency - 8) + 1 / (kFrequency + 8));
  const double turned_hz = 6 / (1e-6 * 2) * moved_m / (2 * kPi);
  EXPECT_REL(fit.amplitude_uncertainty, std::hypot(2e-9, moved_m) / made.gain, kRound, "rounding");
  EXPECT_REL(fit.frequency_uncertainty_hz, std::hypot(1e-4, turned_hz), kRound, "rounding");
  // at the first sample, 1 s from the middle
  EXPECT_REL(fit.phase_uncertainty_rad, std::hypot(3e-3, moved_m / 1e-6, 2 * kPi * turned_hz),
             kRound, "rounding");
}

// The bound is one: of all phases of tone and line, no error is larger than sqrt(2) times it, and
// some are about as large.
TEST(FinishTone, WhatLeaksMovesAFitByNoMoreThanThat) {
  constexpr double kLine = 1e-8;
  double worst_m = 0;
  double worst_hz = 0;
  for (int k = 0; k < 24; ++k) {
    const double phase = kPi * k / 12;
    const auto values = Samples(1e3, 2000, 0, {{1e-6, kFrequency, 0.7}, {kLine, 8.2, phase}});
    const SineFit fit = FitSine(values, {1e3, 0, 0}, kFrequency);
    ASSERT_TRUE(fit.converged);
    worst_m = std::max(worst_m, std::abs(fit.amplitude - 1e-6));
    worst_hz = std::max(worst_hz, std::abs(fit.frequency_hz - kFrequency));
  }
  Fitted made;
  made.window.numbers.tone->fit.amplitude_uncertainty = 0;
  made.window.numbers.tone->fit.frequency_uncertainty_hz = 0;
  made.window.numbers.below_band =
      BelowBand{.frequency_hz = 8.2, .leaked_rms_m = kLine / std::numbers::sqrt2};
  const SineFit& fit = made.Finished().fit;
  const double most_m = std::numbers::sqrt2 * fit.amplitude_uncertainty * made.gain;
  const double most_hz = std::numbers::sqrt2 * fit.frequency_uncertainty_hz;
  // the parts of a period at both ends decide how much of it is reached
  EXPECT_LE(worst_m, 1.02 * most_m);
  EXPECT_GE(worst_m, 0.3 * most_m);
  EXPECT_LE(worst_hz, 1.02 * most_hz);
  EXPECT_GE(worst_hz, 0.3 * most_hz);
}

// each end of 2 s may be off by 10 us
TEST(FinishTone, TheRateIsAsUncertainAsTheTimesOfBothEnds) {
  Fitted made;
  made.segments.parts[0].time_uncertainty_s = 1e-5;
  EXPECT_REL(made.Finished().fit.frequency_uncertainty_hz,
             std::hypot(1e-4, kFrequency * std::numbers::sqrt2 * 1e-5 / 2), kRound, "rounding");
}

// A half width of the RMS is one of the amplitude, a rectangle.
TEST(FinishTone, StepsAreARectangle) {
  Fitted made;
  made.window.steps_m = 3e-9;
  EXPECT_REL(made.Finished().fit.amplitude_uncertainty,
             std::sqrt(4e-18 + 2 * 9e-18 / 3) / made.gain, kRound, "2 a^2 / 3");
}

// The drive of a wide interval (beyond 2.5 % to either side) is the tone at least.
TEST(FinishTone, AWideIntervalReachesToTheToneAlone) {
  const auto lower = [](double upper_m, bool from_drive) {
    Fitted made;
    made.chosen.part.from_drive = from_drive;
    made.window.numbers.rms.rms_m = 0.8e-6;
    made.window.numbers.rms.lower_m = 0.79e-6;
    made.window.numbers.rms.upper_m = upper_m;
    (void)made.Finished();
    return made.window.numbers.rms.lower_m;
  };
  EXPECT_EQ(lower(0.8299e-6, true), 0.79e-6);
  EXPECT_EQ(lower(0.8301e-6, false), 0.79e-6);
  // of the sine's RMS, less 1.98498 of its uncertainty of 0.2 %
  EXPECT_REL(lower(0.8301e-6, true), (1 - 1.98498 * 2e-3) * 1e-6 / std::numbers::sqrt2, 1e-6,
             "four digits of 0.4 %");
}

// A tone of 5 um amplitude stood beside an RMS of 3.1 um at most.
TEST(FinishTone, AnUpperLimitHoldsTheTone) {
  const auto limit = [](std::optional<double> tone_of_floor_hz, double at_most_m) {
    Fitted made;
    made.window.numbers.floor = NoiseFloor{.power = {}, .file = "off"};
    made.window.numbers.floor->tone_hz = tone_of_floor_hz;
    made.window.numbers.rms.below_floor = true;
    made.window.numbers.rms.at_most_m = made.window.numbers.rms.upper_m = at_most_m;
    (void)made.Finished();
    EXPECT_EQ(made.window.numbers.rms.upper_m, made.window.numbers.rms.at_most_m);
    return made.window.numbers.rms.at_most_m;
  };
  EXPECT_REL(limit({}, 0.1e-6), (1 + 1.985 * 2e-3) * 1e-6 / std::numbers::sqrt2, 1e-5,
             "digits of the factor");
  EXPECT_EQ(limit({}, 0.9e-6), 0.9e-6);
  EXPECT_EQ(limit(kFrequency, 0.1e-6), 0.1e-6) << "subtracted with the floor";
}

TEST(FinishTone, AnIntervalThatHoldsTheToneStays) {
  Fitted made;
  made.chosen.part.from_drive = true;
  made.window.numbers.rms.rms_m = 0.7e-6;
  made.window.numbers.rms.lower_m = 0.6e-6;
  made.window.numbers.rms.upper_m = 0.8e-6;
  (void)made.Finished();
  EXPECT_EQ(made.window.numbers.rms.lower_m, 0.6e-6) << "the sine alone has 0.7 um";
}

// the tone of 2 s of 3 um at 200 Hz beside 2.9 um and `third_m`, whose drive moves by `moved_hz`
std::optional<SineFit> ToneOfMoving(double moved_hz, double third_m, bool from_drive = true,
                                    double coherence = 1) {
  MadeWindow made(TwoSeconds());
  made.window.samples = {Samples(10e3, 20'000, 0, {{3e-6, 200}, {2.9e-6, 311}, {third_m, 157}}),
                         10e3};
  made.chosen.part.from_drive = from_drive;
  made.chosen.part.state.coherence = coherence;
  made.chosen.part.state.from_hz = 200;
  made.chosen.part.state.to_hz = 200 + moved_hz;
  return ToneOf(made.window);
}

// Five bins of 0.5 Hz.
TEST(ToneOf, ADriveThatMovesByFiveBinsHasNoneUnlessASineHoldsHalfOfIt) {
  EXPECT_TRUE(ToneOfMoving(2.48, 0.8e-6)) << "moves by less than five bins";
  EXPECT_FALSE(ToneOfMoving(2.52, 0.8e-6)) << "3^2 < 2.9^2 + 0.8^2";
  EXPECT_FALSE(ToneOfMoving(-2.52, 0.8e-6)) << "of either sign";
  EXPECT_TRUE(ToneOfMoving(2.52, 0.75e-6)) << "3^2 > 2.9^2 + 0.75^2";
}

TEST(ToneOf, OnlyAClearDriveMoves) {
  EXPECT_FALSE(ToneOfMoving(10, 0.8e-6));
  EXPECT_TRUE(ToneOfMoving(10, 0.8e-6, false));
  EXPECT_FALSE(ToneOfMoving(10, 0.8e-6, true, 0.905));
  EXPECT_TRUE(ToneOfMoving(10, 0.8e-6, true, 0.895));
}

// The second tone is taken out before the first is fitted; nearer than five bins of 0.5 Hz it is
// the tone's own change.
TEST(ToneOf, IsFittedWithoutASecondOne) {
  for (const double apart_hz : {2.3, 2.8, 40.7}) {
    MadeWindow made(TwoSeconds());
    made.window.samples = {Samples(10e3, 20'000, 0, {{3e-6, 200.1}, {3e-7, 200.1 + apart_hz, 1}}),
                           10e3};
    const auto tone = ToneOf(made.window);
    ASSERT_TRUE(tone) << apart_hz;
    EXPECT_EQ(made.window.second.has_value(), apart_hz > 2.5) << apart_hz;
    if (apart_hz < 10) continue;
    EXPECT_REL(made.window.second->frequency_hz, 240.8, 1e-5,
               "leakage of the first, 1e-3 of a bin");
    EXPECT_REL(made.window.second->amplitude, 3e-7, 0.02, "leakage of the first");
    EXPECT_REL(tone->frequency_hz, 200.1, 1e-8, "what is left of the second one");
  }
}

// 5 um at 60 Hz: its multiples up to the tenth, as far as they are observable.
TEST(DescribeHarmonics, AreThoseThatAreObservableUpToTheTenth) {
  MadeWindow made(Samples(10e3, 20'000, 0, {{5e-6, 60, 0.3}, {2e-7, 120, 1}}));
  made.window.numbers.tone.emplace().fit.frequency_hz = 60;
  const auto count = [&](double observable_hz) {
    made.window.numbers.harmonics.reset();
    made.analysis.record.observable_upper_hz = observable_hz;
    EXPECT_TRUE(DescribeHarmonics(made.window));
    const auto& found = made.window.numbers.harmonics;
    return found ? found->harmonics.size() : 0;
  };
  EXPECT_EQ(count(119.9), 0U);
  EXPECT_EQ(count(120.1), 2U);
  EXPECT_EQ(count(179.9), 2U);
  EXPECT_EQ(count(3900), 10U);
  EXPECT_REL(made.window.numbers.harmonics->harmonics[1].amplitude, 2e-7, 1e-9, "whole periods");
}

}  // namespace
}  // namespace haptometer::dsp
