// Rules of dsp/analysis/decision_limits.h that no other test fails without.
#include "dsp/analysis/decision_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;

void AddNoise(std::uint64_t seed, double noise_m, std::vector<double>* values) {
  Noise noise(seed);
  for (double& value : *values) value += noise_m * noise();
}

// 0.4 um, 0.3 um in 6 s, in noise of 1 um (white, up to 1 kHz), which no block of 50 ms shows
trial::Record FaintTone(double tone_hz, double duration_s) {
  std::vector<double> values = Samples(kRateHz, static_cast<std::size_t>(duration_s * kRateHz),
                                       0.03, {{duration_s < 2 ? 0.4e-6 : 0.3e-6, tone_hz}});
  AddNoise(7, 1e-6, &values);
  return RecordOf(std::move(values), kRateHz);
}

// Of either length, and unless the drive is stated to be there.
TEST(FaintTone, AtAMultipleOfTheMainsIsRefused) {
  for (const double duration_s : {1.5, 6.0}) {
    for (const double tone_hz : {150.0, 180.0, 299.7}) {
      const BandAnalysis analysis = Answer(FaintTone(tone_hz, duration_s));
      EXPECT_FALSE(analysis.answered) << tone_hz << " Hz in " << duration_s << " s";
      EXPECT_THAT(RefusalsIn(analysis.findings),
                  ::testing::ElementsAre(FindingKind::kMainsFrequency));
      BandQuestion stated;
      stated.drive_frequency_hz = tone_hz;
      EXPECT_TRUE(Answer(FaintTone(tone_hz, duration_s), stated).answered) << tone_hz;
    }
    EXPECT_TRUE(Answer(FaintTone(155.4, duration_s)).answered) << duration_s;
  }
}

// 10 um RMS at 225 Hz from 2 s to 4 s of 6 s, and what else there is
std::vector<double> GatedDrive() {
  std::vector<double> values(12'000, 0.03);
  for (std::size_t k = 4000; k < 8000; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    values[k] += 10e-6 * std::numbers::sqrt2 * std::sin(2 * std::numbers::pi * 225 * t_s);
  }
  return values;
}

// A bump of 8 um at 70 Hz that decays in 30 ms has ten times the power of the noise of 0.2 um over
// the interval from 4.1 s on.
TEST(QuietInterval, IsCutWhereABumpIs) {
  std::vector<double> values = GatedDrive();
  AddNoise(3, 0.2e-6, &values);
  const BandAnalysis plain = Answer(RecordOf(values, kRateHz));
  for (std::size_t k = 10'000; k < values.size(); ++k) {
    const double t_s = static_cast<double>(k - 10'000) / kRateHz;
    values[k] += 8e-6 * std::exp(-t_s / 0.03) * std::sin(2 * std::numbers::pi * 70 * t_s);
  }
  const BandAnalysis bumped = Answer(RecordOf(std::move(values), kRateHz));
  ASSERT_TRUE(plain.answered && bumped.answered);
  EXPECT_REL(*bumped.numbers->rms.floor_m, *plain.numbers->rms.floor_m, 0.1,
             "noise of 3 s over 480 Hz: 2 % of its RMS, less of it after the cut");
  for (const TimeWindow& quiet : bumped.numbers->floor->quiet) {
    EXPECT_TRUE(quiet.end_s < 5 || quiet.begin_s > 5.06) << quiet.begin_s << ' ' << quiet.end_s;
  }
}

// bumps of `height_m` at 30 Hz that decay in 90 ms, at each time
void AddBumps(std::initializer_list<double> times_s, double height_m, std::vector<double>& values) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    for (const double from_s : times_s) {
      const double t_s = static_cast<double>(k) / kRateHz - from_s;
      if (t_s < 0) continue;
      values[k] += height_m * std::exp(-t_s / 0.09) * std::sin(2 * std::numbers::pi * 30 * t_s);
    }
  }
}

// All but the first 0.3 s of the drive is bumped: beside each other the bumps are the rule, beside
// the pause they are none. The interval holds both, and is a doubt.
TEST(Bumps, ThatFillMostOfAWindowWidenItsInterval) {
  std::vector<double> values = GatedDrive();
  AddBumps({2.3, 2.6, 2.9, 3.2, 3.5, 3.8}, 28e-6, values);
  AddNoise(3, 2e-6, &values);
  const BandAnalysis analysis = Answer(RecordOf(std::move(values), kRateHz));
  ASSERT_TRUE(analysis.answered);
  const RmsEstimate& rms = analysis.numbers->rms;
  EXPECT_GT(rms.rms_m, 10.5e-6) << "the bumps are in it";
  EXPECT_LE(rms.lower_m, 10e-6);
  EXPECT_TRUE(analysis.findings.Has(FindingKind::kWideInterval));
}

// In noise of 1e-4 of the drive a bump stands out for so long as the filter rings, most of the
// window, but counts in a part of it only.
TEST(Bumps, InAQuietRecordAreExcluded) {
  std::vector<double> values = GatedDrive();
  AddBumps({2.8}, 8e-6, values);
  AddNoise(3, 1e-9, &values);
  const BandAnalysis analysis = Answer(RecordOf(std::move(values), kRateHz));
  ASSERT_TRUE(analysis.answered);
  EXPECT_FALSE(analysis.numbers->excluded.empty());
  EXPECT_REL(analysis.numbers->rms.rms_m, 10e-6, 3e-4,
             "a bump above 2e-3 of the level is excluded");
}

// The pause behind the drive is bumped throughout: not its noise is subtracted, but that beside the
// drive.
TEST(QuietInterval, IsLeftOutWhereItIsBumpedThroughout) {
  std::vector<double> values = GatedDrive();
  values.resize(10'400);
  values.erase(values.begin(), values.begin() + 4000);
  AddBumps({2.3, 2.6, 2.9}, 15e-6, values);
  AddNoise(3, 1e-9, &values);
  const BandAnalysis analysis = Answer(RecordOf(std::move(values), kRateHz));
  ASSERT_TRUE(analysis.answered);
  EXPECT_EQ(analysis.numbers->floor->from, NoiseSource::kBeside);
  EXPECT_REL(analysis.numbers->rms.rms_m, 10e-6, 3e-4, "noise of 1e-4 of it");
}

// Tremor at the end of a sensor's range: the edges of what is clipped are no noise of the drive's
// window, in which nothing is clipped.
TEST(QuietInterval, IsLeftOutWhereTremorIsClipped) {
  std::vector<double> values = GatedDrive();
  for (std::size_t k = 0; k < values.size(); ++k) {
    // 0.15 mm at 7 Hz, a third of it while the drive is on
    const double t_s = static_cast<double>(k) / kRateHz;
    const double level = 1 - std::clamp(std::min(t_s - 1.2, 4.8 - t_s) / 0.4, 0.0, 1.0) * 2 / 3;
    values[k] += 150e-6 * level * std::sin(2 * std::numbers::pi * 7 * t_s);
  }
  AddNoise(5, 0.02e-6, &values);
  for (double& value : values) value = std::min(value, 0.03 + 130e-6);
  const BandAnalysis analysis = Answer(RecordOf(std::move(values), kRateHz));
  ASSERT_TRUE(analysis.answered);
  const RmsEstimate& rms = analysis.numbers->rms;
  EXPECT_TRUE(analysis.findings.Has(FindingKind::kClipped));
  EXPECT_LE(rms.lower_m, 10e-6);
  EXPECT_GE(rms.upper_m, 10e-6);
  EXPECT_LT(*rms.floor_m, 0.1e-6);
}

// 10 um in noise of 0.5 to 10 um, half of whose intervals are 0.2 % to 4 % of the RMS: the doubt is
// there if and only if the interval is wide, and the levels lie close enough to show the limit.
TEST(WideInterval, IsADoubtBeyondTwoAndAHalfPercent) {
  std::size_t just_below = 0;
  std::size_t just_above = 0;
  for (double noise_m = 0.5e-6; noise_m < 10e-6; noise_m *= 1.04) {
    std::vector<double> values = Samples(kRateHz, 6000, 0.03, {{10e-6, 217.3}});
    AddNoise(11, noise_m, &values);
    const BandAnalysis analysis = Answer(RecordOf(std::move(values), kRateHz));
    ASSERT_TRUE(analysis.answered) << noise_m;
    const RmsEstimate& rms = analysis.numbers->rms;
    const double share = 0.5 * (rms.upper_m - rms.lower_m) / rms.rms_m;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kWideInterval), share > 0.025) << share;
    just_below += share > 0.022 && share <= 0.025 ? 1 : 0;
    just_above += share > 0.025 && share <= 0.028 ? 1 : 0;
  }
  EXPECT_GT(just_below, 0U);
  EXPECT_GT(just_above, 0U);
}

// Clipped at 0.9 of its amplitude, a seventh of a tone is missing.
TEST(WindowClipped, IsALowerLimit) {
  for (const double limit : {0.9, 1.1}) {
    std::vector<double> values = Samples(20e3, 60'000, 0.03, {{10e-6, 225, 0.3}});
    for (double& value : values) value = std::min(value, 0.03 + limit * 10e-6);
    const BandAnalysis analysis = Answer(RecordOf(std::move(values), 20e3));
    EXPECT_EQ(analysis.answered, limit > 1);
    ASSERT_TRUE(analysis.numbers);
    EXPECT_EQ(analysis.numbers->is_lower_limit, limit < 1);
    if (limit > 1) continue;
    EXPECT_THAT(RefusalsIn(analysis.findings), ::testing::ElementsAre(FindingKind::kWindowClipped));
    EXPECT_LT(analysis.numbers->rms.lower_m, 10e-6 / std::numbers::sqrt2);
  }
}

// With 13 samples a period the flat tops look like spikes beside noise: what stands in for these
// must not hide the rail.
TEST(WindowClipped, IsFoundBetweenSpikes) {
  std::vector<double> values = Samples(2000, 4000, 0, {{20e-6, 150.3}});
  Noise noise(5);
  for (double& value : values) value = std::min(value + 2e-8 * noise(), 18e-6);
  const BandAnalysis analysis = Answer(RecordOf(std::move(values), 2000));
  ASSERT_TRUE(analysis.findings.Has(FindingKind::kSpikes));
  EXPECT_THAT(RefusalsIn(analysis.findings), ::testing::ElementsAre(FindingKind::kWindowClipped));
}

// A tenth of a percent of the window: single rows at the sensor's rail, which it says.
TEST(WindowClipped, IsALowerLimitBeyondATenthOfAPercent) {
  const std::vector<double> values = Samples(20e3, 60'000, 0.03, {{10e-6, 225, 0.3}});
  const std::size_t rows = Answer(RecordOf(values, 20e3)).numbers->part.rows;
  const auto most = static_cast<std::size_t>(1e-3 * static_cast<double>(rows));
  for (const std::size_t clipped : {most, most + 1}) {
    trial::Record record = RecordOf(values, 20e3);
    for (std::size_t k = 0; k < clipped; ++k) {
      record.channels[0].statuses[15'000 + 400 * k] = trial::SampleStatus::kClipped;
    }
    const BandAnalysis analysis = Answer(record);
    ASSERT_TRUE(analysis.numbers);
    EXPECT_EQ(analysis.numbers->part.rows, rows);
    EXPECT_EQ(analysis.numbers->is_lower_limit, clipped > most);
    EXPECT_EQ(analysis.answered, clipped == most);
    if (clipped == most) continue;
    EXPECT_REL(NumberOf(analysis.findings, FindingKind::kWindowClipped, "share"),
               static_cast<double>(clipped) / static_cast<double>(rows), 1e-12, "rounding");
  }
}

}  // namespace
}  // namespace haptometer::dsp
