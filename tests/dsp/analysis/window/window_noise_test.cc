// The noise that is taken off a window's power, against closed forms and direct sums.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "tests/dsp/analysis/window/made_window.h"
#include "tests/dsp/findings.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRound = 1e-13;

// a window of 2 s with 1 um^2 in it, beside noise of 1e-4 um^2/Hz
struct Measured : MadeWindow {
  Measured() : MadeWindow(TwoSeconds()) {
    window.numbers.power = {1e-12, 3e-27};
    window.density = 1e-16;
  }
};

TEST(TakeFloor, OfAFileIsTakenOffInPower) {
  Measured made;
  made.question.floor = NoiseFloor{.power = {4e-14, 1e-30}, .duration_s = 0.5, .file = "off"};
  ASSERT_TRUE(TakeFloor(made.window));
  const BandPower& power = made.window.power;
  EXPECT_REL(power.tone_mean_square, 0.96e-12, kRound, "the rest of it");
  // 2 drive S / T
  EXPECT_REL(power.tone_variance, 2 * 0.96e-12 * 1e-16 / 2, kRound, "beat with the noise");
  EXPECT_EQ(power.rest.mean_square, 4e-14);
  EXPECT_REL(power.rest.variance, 1e-30 * 0.5 / 2, kRound, "as the floor, over 2 s");
  ASSERT_TRUE(power.floor && made.window.numbers.floor);
  EXPECT_EQ(power.floor->mean_square, 4e-14);
  EXPECT_EQ(power.floor->variance, 1e-30);
  EXPECT_EQ(made.window.numbers.floor->file, "off");
}

TEST(TakeFloor, AFloorAboveTheWindowLeavesNoDrive) {
  Measured made;
  made.question.floor = NoiseFloor{.power = {1.5e-12, 1e-30}, .duration_s = 2};
  ASSERT_TRUE(TakeFloor(made.window));
  EXPECT_EQ(made.window.power.tone_mean_square, 0);
  EXPECT_EQ(made.window.power.tone_variance, 0);
  EXPECT_EQ(made.window.power.rest.mean_square, 1e-12);
  EXPECT_EQ(made.window.power.floor->mean_square, 1.5e-12);
}

// The mean squares of rest and floor cancel; what is wrong in them is divided by the gain squared.
TEST(TakeFloor, WithTheSensorsGainTheErrorsOfTheNoiseGrow) {
  Measured made;
  made.window.power.sensor_gain = 0.5;
  made.question.floor = NoiseFloor{.power = {4e-14, 1e-30}, .duration_s = 2};
  ASSERT_TRUE(TakeFloor(made.window));
  EXPECT_REL(made.window.power.rest.variance, 16e-30, kRound, "1 / 0.5^4");
  EXPECT_REL(made.window.power.floor->variance, 16e-30, kRound, "the same");
}

// Broadband vibration beats with the floor's mean density, integral of S^2 df over that of S.
TEST(TakeFloor, WithoutADensityThatOfTheFloorCounts) {
  Measured made;
  made.window.density.reset();
  made.question.floor = NoiseFloor{.power = {4e-14, 1e-30}, .duration_s = 3};
  ASSERT_TRUE(TakeFloor(made.window));
  EXPECT_REL(made.window.power.tone_mean_square, 0.96e-12, kRound, "the rest of it");
  EXPECT_REL(made.window.power.tone_variance, 2 * 0.96e-12 * (1e-30 * 3 / 4e-14) / 2, kRound,
             "2 drive S / T");
  EXPECT_EQ(made.window.power.floor->mean_square, 4e-14);
}

// Without a drive, a pause and a file nothing is subtracted: the RMS holds noise, which may be as
// dense throughout as in the quietest part of the band.
TEST(TakeFloor, OfUnknownNoiseNothingIsSubtracted) {
  Measured made;
  made.window.density.reset();
  made.window.beside.is_known = true;
  made.window.beside.power = {0.9e-12, 1e-27};
  made.window.beside.flat_mean_square = 3e-14;
  made.window.beside.least_density = 6e-17;
  ASSERT_TRUE(TakeFloor(made.window));
  EXPECT_FALSE(made.window.power.floor);
  EXPECT_FALSE(made.window.numbers.floor);
  EXPECT_EQ(made.window.power.tone_mean_square, 0);
  EXPECT_EQ(made.window.power.rest.mean_square, 1e-12);
  EXPECT_REL(made.window.power.rest.variance, (2 * 1e-12 - 3e-14) * 6e-17 / 2, kRound,
             "2 vibration S / T + noise S / T");
  EXPECT_REL(made.window.numbers.kept_noise_m, std::sqrt(3e-14), kRound, "the flat noise");
  // and motion below the band and in its foot, but no more than there is
  made.window.beside.below_mean_square = 2e-14;
  made.window.beside.foot_mean_square = 5e-14;
  ASSERT_TRUE(TakeFloor(made.window));
  EXPECT_REL(made.window.numbers.kept_noise_m, std::sqrt(10e-14), kRound, "all three");
  EXPECT_REL(made.window.power.rest.variance, (2 * 1e-12 - 10e-14) * 6e-17 / 2, kRound,
             "their beat with the vibration");
  made.window.beside.below_mean_square = 93e-14;
  ASSERT_TRUE(TakeFloor(made.window));
  EXPECT_EQ(made.window.numbers.kept_noise_m, 1e-6) << "all";
  // where no part of the band is known, all may be noise
  made.window.beside.is_known = false;
  ASSERT_TRUE(TakeFloor(made.window));
  EXPECT_REL(made.window.numbers.kept_noise_m, 1e-6, kRound, "all");
  EXPECT_EQ(made.window.power.rest.variance, 3e-27);
}

// In a stated window what is beside the drive is noise where it is flat beside a steady tone; else
// it may be vibration, which is not subtracted.
TEST(TakeFloor, InAStatedWindowOnlyFlatNoiseBesideASteadyToneIsSubtracted) {
  const auto source = [](WindowChoice choice, bool is_steady, double beside_square) {
    Measured made;
    made.question.choice = choice;
    made.chosen.part.from_drive = true;
    made.chosen.part.state.is_steady = is_steady;
    made.window.numbers.tone.emplace();
    made.window.beside.is_known = true;
    made.window.beside.power = {beside_square, 1e-28};
    made.window.beside.flat_mean_square = 4e-14;
    EXPECT_TRUE(TakeFloor(made.window));
    if (made.window.numbers.floor) return std::sqrt(made.window.numbers.floor->power.mean_square);
    EXPECT_EQ(made.window.power.rest.mean_square, 1e-12) << "nothing is subtracted";
    return -made.window.numbers.kept_noise_m;
  };
  // 3.29 standard deviations of 1e-14 m2 above the flat noise
  const double flat = 4e-14 + 3.28e-14;
  const double more = 4e-14 + 3.30e-14;
  EXPECT_EQ(source(WindowChoice::kAuto, false, more), std::sqrt(more));
  EXPECT_EQ(source(WindowChoice::kGiven, true, flat), std::sqrt(flat));
  EXPECT_EQ(source(WindowChoice::kAll, true, flat), std::sqrt(flat));
  EXPECT_EQ(source(WindowChoice::kGiven, true, more), -std::sqrt(more)) << "beside the tone";
  EXPECT_EQ(source(WindowChoice::kAll, false, flat), -std::sqrt(4e-14)) << "no tone: the flat part";
}

TEST(TakeFloor, BesideADriveTheSpectrumGivesIt) {
  Measured made;
  made.chosen.part.from_drive = true;
  made.window.beside.power = {5e-14, 7e-30};
  made.window.beside.variance_of_rest = 2e-30;
  ASSERT_TRUE(TakeFloor(made.window));
  const BandPower& power = made.window.power;
  EXPECT_REL(power.tone_mean_square, 0.95e-12, kRound, "the rest of it");
  EXPECT_EQ(power.rest.mean_square, 5e-14);
  EXPECT_EQ(power.rest.variance, 2e-30);
  EXPECT_EQ(power.floor->mean_square, 5e-14);
  EXPECT_EQ(power.floor->variance, 0) << "the window's own noise";
  EXPECT_EQ(made.window.numbers.floor->from, NoiseSource::kBeside);
  EXPECT_EQ(made.window.numbers.floor->power.variance, 7e-30);
  EXPECT_EQ(made.window.numbers.floor->duration_s, 2);
}

std::vector<double> NoiseOf(double rms_m, std::size_t count) {
  Noise noise(7);
  std::vector<double> values(count);
  for (double& value : values) value = rms_m * noise();
  return values;
}

// 3 s of noise, in which the drive is said to be
struct Quiet : MadeWindow {
  Quiet() : MadeWindow(NoiseOf(1e-7, 30'000)) {
    chosen.part.from_drive = true;
    window.numbers.power = {1e-12, 0};
    window.density = 1e-16;
    window.numbers.residual_rms_m = 1;
  }

  // the floor where the drive is off in `quiet`
  const NoiseFloor& Floor(std::vector<TimeWindow> quiet) {
    chosen.part.quiet = std::move(quiet);
    EXPECT_TRUE(TakeFloor(window));
    return *window.numbers.floor;
  }
  [[nodiscard]] NoisePower PowerOf(std::size_t begin, std::size_t end) const {
    std::vector<double> samples(end - begin);
    EXPECT_TRUE(signal.Read(begin, samples));
    return MeasureNoise(samples, 10e3, 750).power;
  }
};

// Two periods of 20 Hz are 0.1 s; an interval counts from half of that on.
TEST(NoiseOfQuiet, NeedsTwoPeriodsOfTheLowerCorner) {
  Quiet made;
  EXPECT_EQ(made.Floor({{1.0, 1.0996}}).from, NoiseSource::kBeside);
  EXPECT_EQ(made.Floor({{1.0, 1.1004}}).from, NoiseSource::kQuiet);
  EXPECT_REL(made.Floor({{1.0, 1.1004}}).duration_s, 0.1004, 1e-12, "rows");
  EXPECT_EQ(made.Floor({{1.0, 1.0498}, {1.2, 1.2498}, {1.4, 1.4498}}).from, NoiseSource::kBeside);
  EXPECT_EQ(made.Floor({{1.0, 1.0502}, {1.2, 1.2502}}).from, NoiseSource::kQuiet);
}

TEST(NoiseOfQuiet, IsPooledByDuration) {
  Quiet made;
  const NoiseFloor& floor = made.Floor({{1.0, 1.1}, {1.2, 1.5}});
  const NoisePower first = made.PowerOf(10'000, 11'000);
  const NoisePower second = made.PowerOf(12'000, 15'000);
  EXPECT_REL(floor.power.mean_square, (first.mean_square + 3 * second.mean_square) / 4, kRound,
             "rounding");
  EXPECT_REL(floor.power.variance, (first.variance + 9 * second.variance) / 16, kRound, "rounding");
  EXPECT_REL(floor.duration_s, 0.4, kRound, "rounding");
  ASSERT_EQ(floor.quiet.size(), 2U);
  EXPECT_REL(floor.quiet[1].begin_s, 1.2, kRound, "rounding");
  EXPECT_REL(floor.quiet[1].end_s, 1.5, kRound, "rounding");
}

// An interval of which a tenth is more than all that the drive leaves in its window is disturbed.
TEST(NoiseOfQuiet, IsLeftOutWhereItIsTenTimesWhatTheDriveLeaves) {
  Quiet made;
  const double mean_square = made.PowerOf(10'000, 15'000).mean_square;
  made.window.numbers.residual_rms_m = std::sqrt(0.0995 * mean_square);
  EXPECT_EQ(made.Floor({{1.0, 1.5}}).from, NoiseSource::kBeside);
  made.window.numbers.residual_rms_m = std::sqrt(0.1005 * mean_square);
  EXPECT_EQ(made.Floor({{1.0, 1.5}}).from, NoiseSource::kQuiet);
}

// Edges of what is clipped ring for 2.5 periods of 20 Hz: 1250 rows.
TEST(NoiseOfQuiet, IsLeftOutBesideWhatIsClipped) {
  Quiet made;
  const auto from = [&](std::size_t row) {
    made.analysis.faults.clipped = {{row, row + 1}};
    return made.Floor({{1.0, 1.5}}).from;
  };
  EXPECT_EQ(from(8749), NoiseSource::kQuiet);
  EXPECT_EQ(from(8750), NoiseSource::kBeside);
  EXPECT_EQ(from(12'000), NoiseSource::kBeside);
  EXPECT_EQ(from(16'249), NoiseSource::kBeside);
  EXPECT_EQ(from(16'250), NoiseSource::kQuiet);
}

// What the drive leaves of its tone in a pause is no noise, and said beyond 5 uncertainties.
TEST(NoiseOfQuiet, WhatIsLeftOfTheDriveIsSaidAndNoNoise) {
  std::vector<double> values = NoiseOf(1e-8, 30'000);
  const std::vector<double> tone = Samples(10e3, 30'000, 0, {{5e-8, 200, 0.3}});
  for (std::size_t k = 0; k < values.size(); ++k) values[k] += tone[k];
  MadeWindow made(std::move(values));
  made.chosen.part.from_drive = true;
  made.chosen.part.quiet = {{1.0, 2.0}};
  made.window.numbers.power = {1e-12, 0};
  made.window.numbers.residual_rms_m = 1;
  made.window.density = 1e-16;
  made.window.numbers.tone.emplace().fit.frequency_hz = 200;
  made.window.numbers.tone->fit.amplitude = 1.1e-7;
  ASSERT_TRUE(TakeFloor(made.window));
  const Finding note = FirstOf(made.analysis.findings, FindingKind::kQuietHasDrive);
  EXPECT_EQ(note.severity, Severity::kNote);
  EXPECT_EQ(NumberOf(note, "frequency_hz"), 200);
  // a tenth of the noise of 10 nm is in the band: u = 10 nm sqrt(2 / 10 000)
  EXPECT_ABS(NumberOf(note, "amplitude_m"), 5e-8, 6e-10, "four uncertainties of the noise");
  // of 480 Hz of 5 kHz
  EXPECT_REL(std::sqrt(made.window.numbers.floor->power.mean_square), 1e-8 * std::sqrt(0.096), 0.15,
             "2 B T = 960 values: four times 2.3 %, and the skirts of the filter");
  // with half of its amplitude the drive is on there
  made.window.numbers.tone->fit.amplitude = 0.9e-7;
  ASSERT_TRUE(TakeFloor(made.window));
  EXPECT_EQ(made.window.numbers.floor->from, NoiseSource::kBeside);
}

// What is more than all that was measured in the window is another state of the record.
TEST(NoiseOfQuiet, IsLeftOutWhereItIsMoreThanTheWindow) {
  Quiet made;
  const double mean_square = made.PowerOf(10'000, 15'000).mean_square;
  made.window.numbers.power.mean_square = 0.999 * mean_square;
  EXPECT_EQ(made.Floor({{1.0, 1.5}}).from, NoiseSource::kBeside);
  made.window.numbers.power.mean_square = 1.001 * mean_square;
  EXPECT_EQ(made.Floor({{1.0, 1.5}}).from, NoiseSource::kQuiet);
}

// ---- MeasurePower of a window whose samples were read before.

// a tone of 1 um at 150 Hz in noise of 0.1 um; the window is 1.5 s of 2 s that are fitted
struct Powered : MadeWindow {
  explicit Powered(bool has_tone, std::size_t row_count = 15'000) : MadeWindow(ToneInNoise()) {
    chosen.begin = 5000;
    chosen.end = 25'000;
    window.samples = SamplesOf(window).value();
    window.rows = row_count;
    if (has_tone) window.numbers.tone.emplace().fit = *ToneOf(window);
    EXPECT_TRUE(MeasurePower(window));
  }
  static std::vector<double> ToneInNoise() {
    std::vector<double> values = NoiseOf(1e-7, 30'000);
    const std::vector<double> tone = Samples(10e3, 30'000, 0, {{1e-6, 150, 0.3}});
    for (std::size_t k = 0; k < values.size(); ++k) values[k] += tone[k];
    return values;
  }
  [[nodiscard]] std::vector<double> Rows() const {
    std::vector<double> samples(15'000);
    EXPECT_TRUE(signal.Read(5000, samples));
    return samples;
  }
};

TEST(MeasurePower, IsOfTheWindowItsVarianceOfTheFittedSamples) {
  const Powered made(false);
  double square = 0;
  for (const double x : made.Rows()) square += x * x / 15'000;
  const NoisePower& power = made.window.numbers.power;
  EXPECT_REL(power.mean_square, square, 1e-12, "order of the sums");
  const BandNoise fitted =
      MeasureNoise(made.window.samples.values_m, made.window.samples.rate_hz, 750);
  EXPECT_REL(power.variance,
             fitted.power.variance * made.window.samples.duration_s() / made.window.duration_s(),
             1e-13, "of a time that is shorter by that");
  EXPECT_GT(made.window.samples.duration_s() / made.window.duration_s(), 1.3);
  // without a tone all is rest
  EXPECT_REL(made.window.numbers.residual_rms_m, std::sqrt(fitted.power.mean_square), 1e-13,
             "rounding");
  const auto [least, most] = std::ranges::minmax(made.Rows());
  EXPECT_EQ(made.window.numbers.peak_to_peak_m, most - least);
}

TEST(MeasurePower, OfAToneTheRestIsWhatItLeaves) {
  const Powered made(true);
  const MeasuredWindow& window = made.window;
  const TonePower split =
      SplitTone(window.samples, window.numbers.tone->fit, {}, window.duration_s());
  EXPECT_REL(window.numbers.residual_rms_m, std::sqrt(split.rest.power.mean_square), 1e-13,
             "rounding");
  EXPECT_EQ(window.tone_variance, split.variance);
  // the tone explains nine tenths: its density is the one beside it
  ASSERT_TRUE(window.density);
  EXPECT_EQ(*window.density, split.density);
  EXPECT_REL(*window.density, 1e-14 / 5e3, 0.6, "48 bins know it to 14 %, four times");
}

// What a tone that stands alone leaves is the noise, known but for what lay beyond it and for the
// part of the window that was not fitted: none of 1.5 s, 0.5 s of 2.5 s.
TEST(MeasurePower, OfAToneAloneTheRestIsTheNoise) {
  for (const std::size_t rows : {15'000UZ, 25'000UZ}) {
    const Powered made(true, rows);
    const MeasuredWindow& window = made.window;
    const FilterDesign& design = made.signal.design();
    const TonePower split =
        SplitTone(window.samples, window.numbers.tone->fit, {}, window.duration_s());
    const double tone_hz = window.numbers.tone->fit.frequency_hz;
    std::vector<FrequencyRange> ranges;
    for (const double n : {1, 2, 3}) ranges.push_back({n * tone_hz - 8, n * tone_hz + 8});
    const NoiseBeside beside =
        MeasureNoiseBeside(window.samples.values_m, window.samples.rate_hz, design, {}, ranges);
    const NoisePower beyond = BeyondNoise(split.rest, beside, design, {}, ranges);
    const double left = split.rest.power.mean_square - beyond.mean_square;
    ASSERT_LT(left - beside.power.mean_square, 3.29 * std::sqrt(beside.variance_of_rest));
    EXPECT_REL(window.beside.power.mean_square, left, kRound, "rounding");
    const double not_fitted = rows == 25'000 ? 1 - window.samples.duration_s() / 2.5 : 0;
    EXPECT_REL(window.beside.variance_of_rest,
               beyond.variance + not_fitted * beside.variance_of_rest, 1e-12, "rounding");
  }
}

// Hum is no part of the window's power; a drive without a tone has the density at its frequency,
// behind both passes of the filter.
TEST(MeasurePower, HumIsTakenOffAndADriveHasADensity) {
  MadeWindow made(Powered::ToneInNoise());
  made.chosen.part.from_drive = true;
  made.chosen.part.state.from_hz = 22;
  made.chosen.part.state.to_hz = 23;
  made.window.samples = SamplesOf(made.window).value();
  ASSERT_TRUE(MeasurePower(made.window));
  const double whole = made.window.numbers.power.mean_square;
  const double gain = std::pow(std::norm(Response(made.signal.design(), 22)), 2);
  EXPECT_LT(gain, 0.9) << "else nothing is shown";
  ASSERT_TRUE(made.window.density);
  EXPECT_REL(*made.window.density, made.window.beside.DensityAt(22) * gain, 1e-13, "rounding");
  made.window.hum_square = 0.2 * whole;
  ASSERT_TRUE(MeasurePower(made.window));
  EXPECT_REL(made.window.numbers.power.mean_square, 0.8 * whole, 1e-13, "rounding");
  made.window.hum_square = 1.2 * whole;
  ASSERT_TRUE(MeasurePower(made.window));
  EXPECT_EQ(made.window.numbers.power.mean_square, 0) << "never below";
}

}  // namespace
}  // namespace haptometer::dsp
