// The half width of each error bound of a window whose numbers are given, against its closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "dsp/readings/digitisation.h"
#include "tests/dsp/analysis/window/made_window.h"
#include "tests/dsp/findings.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRms = 0.8e-6;
constexpr double kRound = 1e-13;

// of the cause; 0 where there is no such bound
double HalfWidth(const MeasuredWindow& window, RmsCause cause) {
  const std::vector<RmsBound> bounds = BoundsOf(window).value();
  for (const RmsBound& bound : bounds) {
    if (bound.cause == cause) return bound.half_width_m;
  }
  return 0;
}

// a window of 2 s with an RMS of 0.8 um
struct Bounded : MadeWindow {
  Bounded() : MadeWindow(TwoSeconds()) { window.numbers.power.mean_square = kRms * kRms; }
};

TEST(WindowBounds, WhatLeaksFromBelowAddsItsPowerAndItsBeat) {
  Bounded made;
  made.window.numbers.below_band = BelowBand{.frequency_hz = 8, .leaked_rms_m = 2e-8};
  // 12 Hz below the corner for 2 s
  EXPECT_REL(HalfWidth(made.window, RmsCause::kBelowBand),
             4e-16 / (2 * kRms) + 2e-8 / (kPi * 12 * 2), kRound, "rounding");
  // of 10 ms, in which the beat is no smaller than the leak
  made.window.rows = 100;
  EXPECT_REL(HalfWidth(made.window, RmsCause::kBelowBand), 4e-16 / (2 * kRms) + 2e-8, kRound,
             "rounding");
}

TEST(WindowBounds, StepsOfTheSourceAddInSquaresUnlessTheyAreLarge) {
  for (const double step_m : {1e-7, 1e-4}) {
    Bounded made;
    made.window.step_m = step_m;
    // step^2 / 12 over 5 kHz, 480 Hz of which are the band
    const double in_band = step_m / std::sqrt(12.0) * std::sqrt(480 / 5e3);
    const double expected = step_m < 1e-6 ? in_band * in_band / (2 * kRms) : in_band;
    EXPECT_REL(HalfWidth(made.window, RmsCause::kQuantisation), expected, kRound, "rounding");
    made.window.steps_m = 1.01 * expected;
    EXPECT_EQ(HalfWidth(made.window, RmsCause::kQuantisation), 1.01 * expected);
    made.window.steps_m = 0.99 * expected;
    EXPECT_REL(HalfWidth(made.window, RmsCause::kQuantisation), expected, kRound, "the larger one");
  }
}

TEST(WindowBounds, EndsOfTheFilter) {
  Bounded made;
  EXPECT_EQ(HalfWidth(made.window, RmsCause::kBridged), 0);
  EXPECT_REL(HalfWidth(made.window, RmsCause::kFilterEnds), 1e-4 * kRms, kRound, "kSettledError");
  // nothing is divided by an RMS of 0
  made.window.numbers.power.mean_square = 0;
  EXPECT_TRUE(BoundsOf(made.window).value().empty());
}

// Of the two samples that the window holds. Of errors that are independent 480 Hz of 5 kHz lie in
// the band, of those with ten times their squares as covariances at most all.
TEST(WindowBounds, InterpolationAddsItsPowerInTheBandAndItsProductWithTheTone) {
  Bounded made;
  made.chosen.begin = 100;
  made.window.rows = 5000;
  for (const double covariance : {1.0, 20.0}) {
    made.segments.parts[0].bridges = {
        {.sample = 99, .error_square = 1, .covariance_sum = 1},
        {.sample = 100, .error_square = 4e-16, .covariance_sum = covariance * 4e-16},
        {.sample = 5099, .error_square = 3e-16, .covariance_sum = covariance * 3e-16},
        {.sample = 5100, .error_square = 1, .covariance_sum = 1}};
    const double in_band = covariance < 10 ? 7e-16 * 480 / 5000 : 7e-16;
    EXPECT_REL(HalfWidth(made.window, RmsCause::kBridged),
               (in_band / (2 * kRms) + 2 * std::sqrt(2 * covariance * 7e-16)) / 5000, kRound,
               "rounding");
  }
}

// The mean of a1 a2 cos(2 pi df t) over T is a1 a2 / (pi df T) at most. A multiple of the tone is
// within a bin, here 0.5 Hz, of it and has none.
TEST(WindowBounds, ASecondToneBeatsUnlessItIsAHarmonic) {
  Bounded made;
  made.window.numbers.tone.emplace().fit = {.frequency_hz = 100, .amplitude = 1e-6};
  const auto beat = [&](double frequency_hz) {
    made.window.second = SineFit{.frequency_hz = frequency_hz, .amplitude = 1e-7};
    return HalfWidth(made.window, RmsCause::kBeat);
  };
  const auto closed_form = [](double apart_hz) {
    return 1e-6 * 1e-7 / (2 * kRms * kPi * apart_hz * 2);
  };
  EXPECT_EQ(HalfWidth(made.window, RmsCause::kBeat), 0);
  EXPECT_REL(beat(130), closed_form(30), kRound, "rounding");
  EXPECT_REL(beat(30), closed_form(70), kRound, "below the tone, no multiple");
  EXPECT_REL(beat(200.502), closed_form(100.502), kRound, "beyond a bin of the harmonic");
  EXPECT_EQ(beat(200.498), 0);
  EXPECT_EQ(beat(299.502), 0);
  made.window.numbers.tone.reset();
  EXPECT_EQ(beat(130), 0);
}

// mean square of the signal's samples [begin, end)
double MeanSquareOf(const BandSignal& signal, std::size_t begin, std::size_t end) {
  std::vector<double> samples(end - begin);
  EXPECT_TRUE(signal.Read(begin, samples));
  double sum = 0;
  for (const double x : samples) sum += x * x;
  return sum / static_cast<double>(samples.size());
}

// the amplitude of a tone falls by half over the record
std::vector<double> Falling() {
  std::vector<double> values = TwoSeconds();
  for (std::size_t k = 0; k < values.size(); ++k) values[k] *= 1 - static_cast<double>(k) / 40e3;
  return values;
}

// 0.2 um^2 of what was measured is hum, which no number but this one holds
TEST(WindowBounds, EdgesAreAPeriodOfTheLowerCornerAtEachEnd) {
  MadeWindow made(Falling());
  constexpr double kHum = 2e-13;
  const auto edges = [&](std::size_t rows) {
    made.window.rows = rows;
    made.window.numbers.power.mean_square = MeanSquareOf(made.signal, 0, rows) - kHum;
    made.window.hum_square = kHum;
    return HalfWidth(made.window, RmsCause::kDriveEdges);
  };
  EXPECT_EQ(edges(20'000), 0) << "no drive";
  made.chosen.part.from_drive = true;
  for (const std::size_t rows : {20'000U, 2000U}) {
    // 500 rows are a period of 20 Hz
    const double change = std::sqrt(MeanSquareOf(made.signal, 500, rows - 500)) -
                          std::sqrt(MeanSquareOf(made.signal, 0, rows));
    EXPECT_REL(edges(rows), std::abs(change), 1e-9, "a difference of sums in another order");
  }
  EXPECT_EQ(edges(1999), 0) << "less than four periods";
}

TEST(WindowBounds, WhatMayBeBumpsIsLeftOutToSeeTheChange) {
  MadeWindow made(Falling());
  made.chosen.part.from_drive = true;
  made.chosen.may_be_bumps = {{2000, 9000}};
  const double whole = MeanSquareOf(made.signal, 0, 20'000);
  made.window.numbers.power.mean_square = whole;
  const double between = (20'000 * whole - 7000 * MeanSquareOf(made.signal, 2000, 9000)) / 13'000;
  const double inside = MeanSquareOf(made.signal, 500, 19'500);
  EXPECT_REL(
      HalfWidth(made.window, RmsCause::kDriveEdges),
      std::hypot(std::sqrt(between) - std::sqrt(whole), std::sqrt(inside) - std::sqrt(whole)), 1e-9,
      "a difference of sums in another order");
}

// A step of height h has the density 2 h^2 / (2 pi f)^2 over the window; a share s of the power
// changes the RMS by s / 2 of it.
TEST(WindowBounds, StepsWithinTheWindowAddTheirPower) {
  Bounded made;
  made.window.numbers.part.first_row = 100;
  made.window.numbers.part.rows = 20'000;
  const auto steps = [&](std::size_t row) {
    made.analysis.faults.list = {{FaultKind::kStep, row, 1, 5e-6}};
    return HalfWidth(made.window, RmsCause::kSteps);
  };
  const double power = 2 * 25e-12 / (4 * kPi * kPi) * (1 / 20.0 - 1 / 500.0) / 2;
  EXPECT_REL(steps(100), power / (2 * kRms), kRound, "rounding");
  EXPECT_EQ(steps(99), 0);
  EXPECT_EQ(steps(20'100), 0);
}

TEST(WindowBounds, TheFootIsHalfOrAllThatIsThere) {
  Bounded made;
  made.window.beside.foot_mean_square = 4e-14;
  made.window.beside.below_mean_square = 2e-14;
  const auto foot = [&] { return HalfWidth(made.window, RmsCause::kFoot); };
  EXPECT_EQ(foot(), 0) << "no drive";
  made.chosen.part.from_drive = true;
  EXPECT_EQ(foot(), 0) << "nothing was subtracted";
  made.window.numbers.floor = NoiseFloor{.power = {}, .from = NoiseSource::kBeside};
  EXPECT_REL(foot(), (4e-14 + 1e-14) / (2 * kRms), kRound, "nothing was subtracted above 20 Hz");
  for (const NoiseSource from : {NoiseSource::kQuiet, NoiseSource::kFile}) {
    made.window.numbers.floor->from = from;
    EXPECT_REL(foot(), (2e-14 + 1e-14) / (2 * kRms), kRound, "half of both");
  }
}

// A stated window is measured as it is, whatever its amplitude does.
TEST(WindowBounds, OfAStatedWindowNoChangeOfTheAmplitudeCounts) {
  Bounded made;
  made.chosen.part.from_drive = true;
  made.chosen.part.state.drift = 0.3;
  made.window.numbers.tone.emplace().fit = {.frequency_hz = 100, .amplitude = 1e-6};
  made.window.second = SineFit{.frequency_hz = 130, .amplitude = 1e-7};
  EXPECT_GT(HalfWidth(made.window, RmsCause::kDrift), 0);
  EXPECT_GT(HalfWidth(made.window, RmsCause::kBeat), 0);
  for (const WindowChoice choice : {WindowChoice::kAll, WindowChoice::kGiven}) {
    made.question.choice = choice;
    EXPECT_EQ(HalfWidth(made.window, RmsCause::kDrift), 0);
    EXPECT_EQ(HalfWidth(made.window, RmsCause::kBeat), 0);
    EXPECT_EQ(HalfWidth(made.window, RmsCause::kDriveEdges), 0);
  }
}

TEST(WindowBounds, HumIsHalfOffUnlessAPauseShowsIt) {
  Bounded made;
  made.chosen.part.from_drive = true;
  for (const double hum_square : {3e-14, -3e-14}) {
    made.window.hum_square = hum_square;
    made.window.numbers.floor.reset();
    EXPECT_REL(HalfWidth(made.window, RmsCause::kHum), 0.5 * 3e-14 / (2 * kRms), kRound, "half");
    made.window.numbers.floor = NoiseFloor{.power = {}, .from = NoiseSource::kQuiet};
    EXPECT_REL(HalfWidth(made.window, RmsCause::kHum), 0.01 * 3e-14 / (2 * kRms), kRound,
               "1 % of the power");
  }
}

// Beyond 2 %, and beyond 3.29 of its standard uncertainties.
TEST(WindowBounds, ADriftThatIsCertainAddsHalfOfItself) {
  Bounded made;
  made.chosen.part.from_drive = true;
  const auto drift = [&](double change, double uncertainty) {
    made.chosen.part.state.drift = change;
    made.chosen.part.state.drift_uncertainty = uncertainty;
    return HalfWidth(made.window, RmsCause::kDrift);
  };
  EXPECT_REL(drift(0.04, 0.0121), 0.02 * kRms, kRound, "0.0398 < 0.04");
  EXPECT_REL(drift(-0.04, 0.0121), 0.02 * kRms, kRound, "of either sign");
  EXPECT_EQ(drift(0.04, 0.0122), 0) << "0.0401 > 0.04";
  EXPECT_EQ(drift(0.0199, 0), 0);
  EXPECT_REL(drift(0.0201, 0), 0.01005 * kRms, kRound, "rounding");
}

// a drive of `amplitude_m` in steps of 0.1 um and noise of `noise_m` before the rounding
struct Rounded : MadeWindow {
  Rounded(double amplitude_m, double noise_m) : MadeWindow(TwoSeconds()) {
    chosen.part.from_drive = true;
    window.step_m = kStep;
    window.power.tone_mean_square = amplitude_m * amplitude_m / 2;
    window.numbers.tone.emplace().fit.frequency_hz = 104.3;
    // up to 5 kHz, with the rounding's own
    window.beside.upper_density = (noise_m * noise_m + kStep * kStep / 12) / 5e3;
    EXPECT_TRUE(BoundSteps(window));
  }
  static constexpr double kStep = 1e-7;
};

double RoundingBound(double amplitude_m, double noise_m) {
  // the band holds harmonics up to the fourth of 104.3 Hz
  return std::hypot(QuantisationBound(Rounded::kStep, amplitude_m, noise_m, 4),
                    CommensurateBound(Rounded::kStep, amplitude_m, noise_m, 104.3 / 10e3, 20'000));
}

TEST(BoundSteps, TakesTheNoiseThatIsAboveTheRoundings) {
  for (const double noise_m : {0.01e-6, 0.03e-6, 0.05e-6}) {
    Rounded made(0.23e-6, noise_m);
    EXPECT_REL(made.window.steps_m, RoundingBound(0.23e-6, noise_m), 1e-9,
               "the noise is a difference of squares");
  }
  EXPECT_LT(RoundingBound(0.23e-6, 0.05e-6), 0.3 * RoundingBound(0.23e-6, 0.03e-6));
  // no drive: no bound
  MadeWindow none(TwoSeconds());
  none.window.step_m = 1e-7;
  ASSERT_TRUE(BoundSteps(none.window));
  EXPECT_EQ(none.window.steps_m, 0);
}

TEST(BoundSteps, ADoubtIsBeyondTwoPercentOfTheDrive) {
  constexpr double kAmplitude = 0.23e-6;
  const double rms = kAmplitude / std::numbers::sqrt2;
  // more noise leaves less: the noise at which 2 % are left
  double less = 0.001e-6;
  double more = 0.1e-6;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (less + more);
    (RoundingBound(kAmplitude, middle) > 0.02 * rms ? less : more) = middle;
  }
  const Rounded quiet(kAmplitude, less * 0.999);
  const Finding doubt = FirstOf(quiet.analysis.findings, FindingKind::kQuantised);
  EXPECT_EQ(doubt.severity, Severity::kDoubt);
  EXPECT_REL(NumberOf(doubt, "share"), quiet.window.steps_m / rms, kRound, "rounding");
  EXPECT_REL(NumberOf(doubt, "share"), 0.02, 0.01, "0.1 % of the noise");
  EXPECT_EQ(NumberOf(doubt, "step_m"), 1e-7);
  const Rounded noisy(kAmplitude, more * 1.001);
  EXPECT_FALSE(noisy.analysis.findings.Has(FindingKind::kQuantised));
}

// noise that is kept, of 0.6 and of twice the RMS, leaves 0.8 of it and nothing
TEST(WindowBounds, NoiseThatIsKeptIsTakenOffInPower) {
  Bounded made;
  EXPECT_EQ(HalfWidth(made.window, RmsCause::kNoiseKept), 0);
  for (const double share : {0.6, 2.0}) {
    made.window.numbers.kept_noise_m = share * kRms;
    EXPECT_REL(HalfWidth(made.window, RmsCause::kNoiseKept), (share < 1 ? 0.2 : 1) * kRms, kRound,
               "rounding");
    const std::vector<RmsBound> bounds = BoundsOf(made.window).value();
    for (const RmsBound& bound : bounds) {
      EXPECT_EQ(bound.only_below, bound.cause == RmsCause::kNoiseKept);
    }
  }
}

}  // namespace
}  // namespace haptometer::dsp
