// Drives that are hard to see beside what else a record holds: mains hum, gaps, a dead channel,
// other rates and bands. As in unsettled_drive_test.cc the numbers are the drive's, or there are
// none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kHiddenRmsM = 10e-6;

// a tone of 10 um RMS and its voltage of 1 V, on for a part of a record
struct Driven {
  double rate_hz = 5e3;
  double record_s = 3;
  TimeWindow on;
  double tone_hz = 200;
  double hum_hz = 50;
  double hum_m = 0;  // RMS
  double tremor_m = 0;
  double noise_m = 5e-8;  // RMS
};

trial::Channel VoltageOf(const trial::Record& record, std::vector<double> values) {
  trial::Channel channel = record.channels[0];
  channel.name = "voltage";
  channel.role = trial::ChannelRole::kVoltage;
  channel.unit = "V";
  channel.values = std::move(values);
  return channel;
}

trial::Record DrivenRecord(const Driven& driven) {
  const auto rows = static_cast<std::size_t>(std::lround(driven.record_s * driven.rate_hz));
  std::vector<double> voltage = Samples(driven.rate_hz, rows, 0, {{1, driven.tone_hz, 0.7}});
  std::vector<double> values =
      Samples(driven.rate_hz, rows, 0.03,
              {{driven.hum_m * std::numbers::sqrt2, driven.hum_hz, 0.3}, {driven.tremor_m, 7, 1}});
  Noise noise(11);
  for (std::size_t k = 0; k < rows; ++k) {
    const double t_s = static_cast<double>(k) / driven.rate_hz;
    if (t_s < driven.on.begin_s || t_s >= driven.on.end_s) voltage[k] = 0;
    values[k] += kHiddenRmsM * std::numbers::sqrt2 * voltage[k] + driven.noise_m * noise();
  }
  trial::Record record = RecordOf(std::move(values), driven.rate_hz);
  record.channels.push_back(VoltageOf(record, std::move(voltage)));
  return record;
}

trial::Record WithoutChannel(trial::Record record) {
  record.channels.resize(1);
  return record;
}

// the rows from `begin_s` to `end_s` were never recorded
trial::Record WithGap(const trial::Record& record, double begin_s, double end_s) {
  const double rate_hz = record.stretches[0].rate_hz;
  const auto first = static_cast<std::size_t>(std::lround(begin_s * rate_hz));
  const auto last = static_cast<std::size_t>(std::lround(end_s * rate_hz));
  trial::Record cut = record;
  cut.rows = record.rows - (last - first);
  cut.stretches = {{0, first, 0, rate_hz, 0}, {first, cut.rows - first, end_s, rate_hz, 0}};
  for (trial::Channel& channel : cut.channels) {
    const auto at = [&](auto& of, std::size_t k) {
      return of.begin() + static_cast<std::ptrdiff_t>(k);
    };
    channel.values.erase(at(channel.values, first), at(channel.values, last));
    channel.statuses.erase(at(channel.statuses, first), at(channel.statuses, last));
  }
  return cut;
}

// the drive's own RMS or, where the hum could not be taken off, that of both
void ExpectNoPause(const BandAnalysis& analysis, const Driven& driven, const std::string& what) {
  if (!analysis.answered) return;
  const double rms_m = analysis.numbers->rms.rms_m;
  const double both_m = std::hypot(kHiddenRmsM, driven.hum_m);
  EXPECT_TRUE(std::abs(rms_m / kHiddenRmsM - 1) < 0.1 || std::abs(rms_m / both_m - 1) < 0.1)
      << what << ": " << rms_m << " m, " << static_cast<int>(analysis.numbers->part.why.kind);
}

struct HumRow {
  double hum_hz = 0;
  double hum_of_drive = 0;  // RMS
  TimeWindow on;
};

class DriveBesideHum : public ::testing::TestWithParam<HumRow> {};

TEST_P(DriveBesideHum, IsNotHiddenByIt) {
  for (const double tone_hz : {110.0, 180.0, 250.0}) {
    Driven driven;
    driven.on = GetParam().on;
    driven.tone_hz = tone_hz;
    driven.hum_hz = GetParam().hum_hz;
    driven.hum_m = GetParam().hum_of_drive * kHiddenRmsM;
    const BandAnalysis analysis = Answer(WithoutChannel(DrivenRecord(driven)));
    ExpectNoPause(analysis, driven, std::to_string(tone_hz));
    // what has settled of 0.4 s in the middle is enough for an answer
    if (driven.on.begin_s == 1.2) {
      EXPECT_TRUE(analysis.answered) << tone_hz;
    }
  }
}

std::vector<HumRow> HumRows() {
  std::vector<HumRow> rows;
  for (const double hum_hz : {50.0, 60.0}) {
    for (const double hum_of_drive : {0.1, 0.2, 0.5, 1.0, 2.0}) {
      for (const TimeWindow& on : {TimeWindow{0, 0.1}, TimeWindow{0.04, 0.25}, TimeWindow{1.2, 1.6},
                                   TimeWindow{1.4, 1.5}, TimeWindow{2.8, 2.95}}) {
        rows.push_back({hum_hz, hum_of_drive, on});
      }
    }
  }
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Of, DriveBesideHum, ::testing::ValuesIn(HumRows()), [](const auto& row) {
  return std::to_string(std::lround(row.param.hum_hz)) + "Hz_" +
         std::to_string(std::lround(100 * row.param.hum_of_drive)) + "percent_from_" +
         std::to_string(std::lround(1e3 * row.param.on.begin_s)) + "ms";
});

// what follows the gap is nothing but the drive: of the first two, nothing settles
TEST(DriveBehindAGap, IsRefusedWhereNothingOfItSettles) {
  for (const double drive_s : {0.06, 0.2, 0.4}) {
    Driven driven;
    driven.record_s = 2.5 + drive_s;
    driven.on = {2.5, 2.5 + drive_s};
    const trial::Record record = WithGap(DrivenRecord(driven), 2.0, 2.5);
    const BandAnalysis by_channel = Answer(record);
    const BandAnalysis by_tone = Answer(WithoutChannel(record));
    ASSERT_FALSE(by_channel.answered) << drive_s;
    ASSERT_FALSE(by_tone.answered) << drive_s;
    for (const BandAnalysis& analysis : {by_channel, by_tone}) {
      using enum FindingKind;
      EXPECT_THAT(RefusalsIn(analysis.findings),
                  ::testing::ElementsAre(::testing::AnyOf(kNothingSteady, kNoDrive)));
    }
  }
}

TEST(DriveBehindAGap, IsAnsweredWhereItHasSettled) {
  Driven driven;
  driven.record_s = 4;
  driven.on = {2.5, 4};
  const trial::Record record = WithGap(DrivenRecord(driven), 2.0, 2.5);
  for (const BandAnalysis& analysis : {Answer(record), Answer(WithoutChannel(record))}) {
    ASSERT_TRUE(analysis.answered);
    EXPECT_REL(analysis.numbers->rms.rms_m, kHiddenRmsM, 0.002, "a steady tone within the band");
    EXPECT_GT(analysis.numbers->part.window.duration_s(), 0.3);
  }
}

TEST(AGap, AloneIsNoDrive) {
  Driven driven;
  driven.tremor_m = 3e-4;
  const trial::Record pause = WithGap(DrivenRecord(driven), 2.0, 2.5);
  for (const BandAnalysis& none : {Answer(pause), Answer(WithoutChannel(pause))}) {
    EXPECT_THAT(RefusalsIn(none.findings), ::testing::ElementsAre(FindingKind::kNoDrive));
  }
  driven.on = {0, 3};
  const BandAnalysis steady = Answer(WithGap(DrivenRecord(driven), 2.0, 2.5));
  ASSERT_TRUE(steady.answered);
  EXPECT_EQ(steady.numbers->part.why.kind, FindingKind::kOneState);
}

// one step of the channel's resolution from 2 s to 2.6 s, in one of so many rows
std::vector<double> Flicker(const trial::Record& record, std::size_t every) {
  std::vector<double> values(record.rows, 0);
  for (std::size_t k = 10000; k < 13000; k += every) values[k] = 1e-3;
  return values;
}

TEST(DeadChannel, IsNoDriveHoweverItFlickers) {
  for (const std::size_t every :
       {std::size_t{1}, std::size_t{2}, std::size_t{7}, std::size_t{150}}) {
    Driven driven;
    driven.on = {0, 3};
    trial::Record steady = DrivenRecord(driven);
    steady.channels[1].values = Flicker(steady, every);
    const BandAnalysis all = Answer(steady);
    ASSERT_TRUE(all.answered) << every;
    EXPECT_EQ(all.numbers->part.why.kind, FindingKind::kOneState) << every;
    EXPECT_REL(all.numbers->rms.rms_m, kHiddenRmsM, 0.002, "a steady tone within the band");

    driven.on = {0.5, 1.5};
    trial::Record gated = DrivenRecord(driven);
    gated.channels[1].values = Flicker(gated, every);
    const BandAnalysis part = Answer(gated);
    ASSERT_TRUE(part.answered) << every;
    EXPECT_REL(part.numbers->rms.rms_m, kHiddenRmsM, 0.002, "a steady tone within the band");
    EXPECT_FALSE(part.numbers->delay) << every;
  }
}

// the generator's voltage was recorded 0.3 s and 0.5 s early: the window is the vibration's
TEST(DelayedChannel, LeavesTheWindowToTheVibration) {
  Driven driven;
  driven.record_s = 4;
  driven.on = {1, 3};
  driven.tone_hz = 175;
  const trial::Record record = DrivenRecord(driven);
  const BandAnalysis alone = Answer(WithoutChannel(record));
  for (const double early_s : {0.3, 0.5}) {
    trial::Record shifted = record;
    std::vector<double>& volts = shifted.channels[1].values;
    std::ranges::rotate(volts, volts.begin() + std::lround(early_s * driven.rate_hz));
    const BandAnalysis analysis = Answer(shifted);
    ASSERT_TRUE(analysis.answered);
    EXPECT_EQ(analysis.numbers->part.window.begin_s, alone.numbers->part.window.begin_s);
    EXPECT_EQ(analysis.numbers->part.window.end_s, alone.numbers->part.window.end_s);
    EXPECT_REL(analysis.numbers->rms.rms_m, kHiddenRmsM, 0.002, "a steady tone within the band");
    ASSERT_TRUE(analysis.numbers->delay);
    EXPECT_NEAR(analysis.numbers->delay->delay_s, early_s,
                2 * analysis.numbers->delay->uncertainty_s);
    EXPECT_LT(analysis.numbers->delay->uncertainty_s, 1e-3);
    EXPECT_TRUE(analysis.findings.Has(FindingKind::kDriveDelayed));
    EXPECT_FALSE(analysis.findings.Has(FindingKind::kDriveContradicted));
  }
}

// The vibration goes on after the voltage is off: a doubt, and the window ends with the voltage.
TEST(ContradictingChannel, IsADoubtAndCutsTheWindow) {
  Driven driven;
  driven.record_s = 4;
  driven.on = {1, 3};
  trial::Record record = DrivenRecord(driven);
  std::vector<double>& volts = record.channels[1].values;
  std::fill(volts.begin() + std::lround(2.5 * driven.rate_hz), volts.end(), 0.0);
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  EXPECT_TRUE(analysis.findings.Has(FindingKind::kDriveContradicted));
  EXPECT_LT(analysis.numbers->part.window.end_s, 2.75);
  EXPECT_REL(analysis.numbers->rms.rms_m, kHiddenRmsM, 0.002, "a steady tone within the band");
}

// it says no more than a dead one does, but the displacement agrees
TEST(OnOffChannel, IsADrive) {
  Driven driven;
  driven.on = {1, 2};
  trial::Record record = DrivenRecord(driven);
  for (std::size_t k = 0; k < record.rows; ++k) {
    record.channels[1].values[k] = k >= 5000 && k < 10000 ? 5 : 0;
  }
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  EXPECT_FALSE(analysis.findings.Has(FindingKind::kDriveContradicted));
  EXPECT_REL(analysis.numbers->rms.rms_m, kHiddenRmsM, 0.002, "a steady tone within the band");
}

// a window needs two periods of the lower corner between the blocks in which the drive is switched
TEST(ShortDriveByItsChannel, IsAnsweredWhereAWindowFits) {
  Driven driven;
  for (const double drive_s : {0.13, 0.17, 0.3, 0.4}) {
    for (const double begin_s : {1.0, 1.374, 1.41}) {
      driven.on = {begin_s, begin_s + drive_s};
      const BandAnalysis analysis = Answer(DrivenRecord(driven));
      EXPECT_EQ(analysis.answered, drive_s >= 0.3) << drive_s << " s from " << begin_s << " s";
      if (!analysis.answered) continue;
      EXPECT_REL(analysis.numbers->rms.rms_m, kHiddenRmsM, 0.01,
                 "what the filter makes of its ends")
          << drive_s << " s from " << begin_s << " s";
      EXPECT_GE(analysis.numbers->part.window.begin_s, begin_s);
      EXPECT_LE(analysis.numbers->part.window.end_s, begin_s + drive_s);
    }
  }
}

struct RateRow {
  double rate_hz = 0;
  double lower_hz = 0;
  double upper_hz = 0;
  double least_drive_s = 0.04;
  double record_s = 3;
};

class DriveAtARate : public ::testing::TestWithParam<RateRow> {
 protected:
  static BandAnalysis Answered(const Driven& driven) {
    BandQuestion question;
    question.band.lower_hz = GetParam().lower_hz;
    question.band.upper_hz = GetParam().upper_hz;
    return Answer(WithoutChannel(DrivenRecord(driven)), question);
  }

  static Driven Record() {
    Driven driven;
    driven.rate_hz = GetParam().rate_hz;
    driven.record_s = GetParam().record_s;
    driven.tremor_m = 3e-4;
    return driven;
  }
};

TEST_P(DriveAtARate, IsNotHiddenByItsPause) {
  for (const double drive_s : {GetParam().least_drive_s, 0.25}) {
    for (const double begin_s : {0.0, GetParam().record_s - drive_s}) {
      for (const double tone_hz : {140.0, 230.0}) {
        Driven driven = Record();
        if (driven.rate_hz > 1e5 && tone_hz > 200) continue;  // takes a second each
        driven.tone_hz = tone_hz;
        driven.on = {begin_s, begin_s + drive_s};
        ExpectNoPause(Answered(driven), driven,
                      std::to_string(begin_s) + " s, " + std::to_string(drive_s) + " s, " +
                          std::to_string(tone_hz) + " Hz");
      }
    }
  }
}

TEST_P(DriveAtARate, IsNotSeenWhereThereIsNone) {
  Driven driven = Record();
  for (const double noise_m : {5e-8, 2e-6}) {
    driven.noise_m = noise_m;
    EXPECT_THAT(RefusalsIn(Answered(driven).findings),
                ::testing::ElementsAre(FindingKind::kNoDrive))
        << noise_m;
  }
  driven.on = {0, driven.record_s};
  const BandAnalysis steady = Answered(driven);
  ASSERT_TRUE(steady.answered);
  EXPECT_REL(steady.numbers->rms.rms_m, kHiddenRmsM, 0.025,
             "noise of 2 um: 0.6 % of the drive at 1 kHz, four times");
  EXPECT_GT(steady.numbers->part.window.duration_s(), driven.record_s / 3);
}

INSTANTIATE_TEST_SUITE_P(
    In, DriveAtARate,
    ::testing::Values(RateRow{1e3, 20, 390}, RateRow{2e3, 20, 500}, RateRow{1e4, 20, 500},
                      RateRow{392e3, 20, 500, 0.04, 1.0},

                      // what is taken out below 80 Hz takes shorter ones at a record's ends along
                      RateRow{1e3, 80, 300, 0.08}, RateRow{2e3, 80, 300, 0.08},
                      RateRow{1e4, 80, 300, 0.08}),
    [](const auto& row) {
      return std::to_string(std::lround(row.param.rate_hz)) + "_" +
             std::to_string(std::lround(row.param.lower_hz));
    });

}  // namespace
}  // namespace haptometer::dsp
