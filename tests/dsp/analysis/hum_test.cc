// FindHum against records with known hum, drives that look like hum, and noise.
#include "dsp/analysis/hum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "dsp/readings/segments.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;
constexpr double kNoiseM = 20e-9;
const std::vector<Sine> kHum{{0.2e-6, 50.02, 0.4}, {0.05e-6, 100.04, 1}, {0.1e-6, 150.06, 2}};

enum class Drive { kNone, kContinuous, kGated };

// 10 s of hum, noise and a drive of 1 um, gated or not.
std::vector<double> Displacement(const std::vector<Sine>& hum, Drive drive, double drive_hz,
                                 double duration_s = 10) {
  const auto count = static_cast<std::size_t>(duration_s * kRateHz);
  std::vector<double> values = Samples(kRateHz, count, 0.03, hum);
  const std::vector<double> tone = Samples(kRateHz, count, 0, {{1e-6, drive_hz, 0.3}});
  Noise noise(5);
  for (std::size_t k = 0; k < count; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    const bool on = drive == Drive::kContinuous ||
                    (drive == Drive::kGated && t_s > 0.3 * duration_s && t_s < 0.7 * duration_s);
    values[k] += kNoiseM * noise() + (on ? tone[k] : 0);
  }
  return values;
}

std::vector<SteadyLine> HumIn(std::vector<double> values,
                              std::optional<double> stated_hz = std::nullopt) {
  const BandPass band;
  const trial::Record record = RecordOf(std::move(values), kRateHz);
  const trial::RecordRows rows(record);
  const Segments segments = SplitAtHoles(rows, 0, {}).value();
  const Segment& segment = segments.parts.at(0);
  const BandSignal signal =
      BandSignal::Filter({rows, 0, segment}, Designed(band, kRateHz), 1).value();
  const auto lines = FindHum(signal, band, stated_hz);
  EXPECT_TRUE(lines);
  return lines ? *lines : std::vector<SteadyLine>{};
}

// The sum of lines at `t_s`: what is subtracted from 0, of samples at 1 Hz.
double ValueAt(const std::vector<SteadyLine>& lines, double t_s) {
  std::vector<double> sample{0};
  SubtractLines(lines, 1, t_s, sample);
  return -sample[0];
}

// Each line within 1 % and 2 mHz of what the filter passes, in phase where the windows lie.
void ExpectLines(const std::vector<SteadyLine>& lines, const std::vector<Sine>& truth) {
  const FilterDesign design = Designed({}, kRateHz);
  ASSERT_EQ(lines.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double passed = truth[k].amplitude * std::norm(Response(design, truth[k].frequency_hz));
    EXPECT_REL(lines[k].amplitude_m(), passed, 0.01, "noise of 20 nm over 10 s: 0.3 nm of 50 nm");
    EXPECT_ABS(lines[k].frequency_hz, truth[k].frequency_hz, 2e-3,
               "phases of windows 5 s apart, 0.01 rad each");
    // amplitude sin(2 pi f t + phase) at 5 s, the middle
    const double value = ValueAt({lines[k]}, 5.0);
    EXPECT_ABS(value / passed,
               std::sin(2 * std::numbers::pi * truth[k].frequency_hz * 5 + truth[k].phase_rad),
               0.02, "phase of a window");
  }
}

TEST(SteadyLine, IsASineAndItsAmplitude) {
  const SteadyLine line{50, 3, -4};
  EXPECT_REL(line.amplitude_m(), 5.0, 1e-15, "a root");
  const double phase = 2 * std::numbers::pi * 50 * 0.123;
  EXPECT_REL(
      ValueAt({line, {60, 0, 1}}, 0.123),
      3 * std::cos(phase) - 4 * std::sin(phase) + std::sin(2 * std::numbers::pi * 60 * 0.123),
      1e-13, "phase of 46 rad");
  EXPECT_EQ(ValueAt({}, 1), 0);
}

TEST(FindHum, MeasuresHumAndItsHarmonicsBesideADrive) {
  for (const Drive drive : {Drive::kNone, Drive::kGated, Drive::kContinuous}) {
    ExpectLines(HumIn(Displacement(kHum, drive, 225)), kHum);
  }
}

TEST(FindHum, MeasuresHumOfSixtyHertz) {
  const std::vector<Sine> hum{{0.2e-6, 59.97, 0.4}, {0.05e-6, 119.94, 1}};
  ExpectLines(HumIn(Displacement(hum, Drive::kGated, 225)), hum);
}

// Twenty times stronger and 8.3 Hz away: a window of 5 s without taper would add 15 % of the hum.
TEST(FindHum, ADriveNearTheMainsDoesNotReachIt) {
  const std::vector<Sine> weak{{0.05e-6, 50.02, 0.4}};
  ExpectLines(HumIn(Displacement(weak, Drive::kContinuous, 58.3)), weak);
}

// A drive that happens to be a multiple of the mains is stronger than the hum's fundamental.
TEST(FindHum, ADriveAtTwiceTheMainsIsNotClaimed) {
  const std::vector<Sine> weak{{0.05e-6, 50.0, 0.4}};
  for (const Drive drive : {Drive::kGated, Drive::kContinuous}) {
    for (const SteadyLine& line : HumIn(Displacement(weak, drive, 100))) {
      EXPECT_LT(std::abs(line.frequency_hz - 50), 0.1);
    }
  }
}

TEST(FindHum, AGatedDriveAtTheMainsFrequencyIsNoHum) {
  EXPECT_TRUE(HumIn(Displacement({}, Drive::kGated, 50)).empty());
  EXPECT_TRUE(HumIn(Displacement({}, Drive::kGated, 60)).empty());
}

TEST(FindHum, ADriveBesideTheMainsIsNoHum) {
  for (const double drive_hz : {48.0, 52.0, 58.0, 62.0, 225.0}) {
    EXPECT_TRUE(HumIn(Displacement({}, Drive::kContinuous, drive_hz)).empty()) << drive_hz;
    EXPECT_TRUE(HumIn(Displacement({}, Drive::kGated, drive_hz)).empty()) << drive_hz;
  }
}

// A drive that is known to be at a multiple of the mains: its line is not to be told from hum.
TEST(FindHum, MainsOfWhichTheStatedDriveIsAMultipleAreNotSought) {
  const std::vector<double> values = Displacement(kHum, Drive::kGated, 225);
  EXPECT_TRUE(HumIn(values, 50.0).empty());
  EXPECT_TRUE(HumIn(values, 200.7).empty());
  EXPECT_FALSE(HumIn(values, 201.5).empty());
  EXPECT_FALSE(HumIn(values, 225.0).empty());
}

// Many bursts: each window of half the record has the same share of them.
TEST(FindHum, BurstsAtTheMainsFrequencyAreNoHum) {
  for (const double on_s : {0.5, 1.0}) {
    std::vector<double> values = Displacement({}, Drive::kNone, 225);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double t_s = static_cast<double>(k) / kRateHz;
      if (std::fmod(t_s, 2 * on_s) > on_s) continue;
      values[k] += 1e-6 * std::sin(2 * std::numbers::pi * 50 * t_s);
    }
    EXPECT_TRUE(HumIn(values).empty()) << on_s;
  }
}

// 9 s of hum that begins after 1 s, beside lines 5 bins of a short window (9 s / 16) above and
// below. Of both sides the quieter one is the noise: lines on both may hide a pause, one on a side
// may not.
TEST(FindHum, APauseIsSeenUnlessBothSidesAreNoisy) {
  const double away_hz = 5 * 16 / 9.0;
  const auto is_found = [&](double below_m, double above_m) {
    std::vector<double> values =
        Samples(kRateHz, 18'000, 0.03, {{below_m, 50 - away_hz, 1}, {above_m, 50 + away_hz, 2}});
    const std::vector<double> hum = Samples(kRateHz, 18'000, 0, {{1e-6, 50, 0.4}});
    for (std::size_t k = 2000; k < values.size(); ++k) values[k] += hum[k];
    return !HumIn(values).empty();
  };
  EXPECT_FALSE(is_found(0, 0));
  EXPECT_FALSE(is_found(0.5e-6, 0));
  EXPECT_FALSE(is_found(0, 0.5e-6));
  EXPECT_TRUE(is_found(0.5e-6, 0.5e-6));
}

// A bump of 0.5 mm hides hum for half a second, and turns its phase over the record: hum is not
// found, and its two states on either side of the bump are no drive, for no state has less than
// half the power.
TEST(HumBesideABump, IsNoDriveUnlessStated) {
  std::vector<double> values =
      Displacement({{1.4e-6, 49.99, 0.4}, {0.1e-6, 99.98, 1}}, Drive::kNone, 225, 8);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double since_s = static_cast<double>(k) / kRateHz - 2.2;
    if (since_s < 0) continue;
    values[k] += 500e-6 * std::exp(-since_s / 0.1) * std::sin(2 * std::numbers::pi * 15 * since_s);
  }
  const trial::Record record = RecordOf(values, kRateHz);
  const auto unstated = AnalyzeBand(record, {});
  ASSERT_TRUE(unstated);
  EXPECT_FALSE(unstated->answered);
  EXPECT_THAT(RefusalsIn(unstated->findings), ::testing::ElementsAre(FindingKind::kMainsFrequency));
  BandQuestion question;
  question.drive_frequency_hz = 50;
  const auto stated = AnalyzeBand(record, question);
  ASSERT_TRUE(stated);
  EXPECT_TRUE(stated->answered);
}

TEST(FindHum, NothingIsSoughtBelowOneSecond) {
  EXPECT_TRUE(HumIn(Displacement(kHum, Drive::kNone, 225, 0.95)).empty());
}

// Error rate, measured: 0 of 200 records of 2 s of white noise (below 1.5 % with 95 % confidence).
TEST(FindHum, NoiseAloneHasNone) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 20 : 200);
  int found = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    Noise noise(static_cast<std::uint64_t>(seed));
    std::vector<double> values(4000);
    for (double& value : values) value = 1e-6 * noise();
    found += HumIn(values).empty() ? 0 : 1;
  }
  std::printf("[rate] hum found in white noise: %d of %d\n", found, repetitions);
  EXPECT_LE(found, repetitions / 1000);  // none of the first 1000
}

// Hum alone in 1 s and a reading less than that.
TEST(FindHum, IsSoughtFromOneSecondOn) {
  const std::vector<double> second = Samples(kRateHz, 2000, 0.03, {{2e-6, 50, 0.4}});
  EXPECT_TRUE(HumIn({second.begin(), second.end() - 1}).empty());
  EXPECT_FALSE(HumIn(second).empty());
}

// The mains is off by 60 mHz at most (1.2e-3 of 50 Hz).
TEST(FindHum, BesideTheMainsIsNone) {
  for (const double off_hz : {-0.062, -0.058, 0.058, 0.062}) {
    const std::vector<Sine> hum{{0.2e-6, 50 + off_hz, 0.4}};
    EXPECT_EQ(HumIn(Displacement(hum, Drive::kNone, 225)).size(), std::abs(off_hz) < 0.06 ? 1U : 0U)
        << off_hz;
  }
}

// A multiple that exceeds the fundamental is the drive's own.
TEST(FindHum, AMultipleIsNoStrongerThanTheFundamental) {
  for (const double size : {0.97, 1.03}) {
    const std::vector<Sine> hum{{0.2e-6, 50, 0.4}, {size * 0.2e-6, 150, 1}};
    EXPECT_EQ(HumIn(Displacement(hum, Drive::kNone, 225)).size(), size < 1 ? 2U : 1U) << size;
  }
}

// Multiples up to the tenth, and up to the end of the band.
TEST(FindHum, SeeksMultiplesUpToTheBandsEnd) {
  std::vector<Sine> hum;
  for (int order = 1; order <= 11; ++order) hum.push_back({0.2e-6 / order, 48.0, 0.4 * order});
  for (std::size_t k = 0; k < hum.size(); ++k) {
    hum[k].frequency_hz = 49.97 * static_cast<double>(k + 1);
  }
  // the tenth is at 499.7 Hz
  EXPECT_EQ(HumIn(Displacement(hum, Drive::kNone, 225)).size(), 10U);
  for (std::size_t k = 0; k < hum.size(); ++k) {
    hum[k].frequency_hz = 50.03 * static_cast<double>(k + 1);
  }
  EXPECT_EQ(HumIn(Displacement(hum, Drive::kNone, 225)).size(), 9U) << "500.3 Hz lies above";
}

TEST(IsOfMains, HoldsForMultiplesOfEither) {
  for (const double frequency_hz : {50.0, 60.0, 100.0, 180.0, 250.0, 300.0}) {
    EXPECT_TRUE(IsOfMains(frequency_hz + 0.99, 1)) << frequency_hz;
    EXPECT_TRUE(IsOfMains(frequency_hz - 0.99, 1)) << frequency_hz;
    EXPECT_FALSE(IsOfMains(frequency_hz + 1.01, 1)) << frequency_hz;
    EXPECT_FALSE(IsOfMains(frequency_hz - 1.01, 1)) << frequency_hz;
  }
  EXPECT_FALSE(IsOfMains(0, 1)) << "no multiple: nothing turns";
  EXPECT_FALSE(IsOfMains(0.5, 1));
}

}  // namespace
}  // namespace haptometer::dsp
