#include "dsp/readings/clean_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kRateHz = 5e3;
constexpr double kTruthM = 20e-6 / std::numbers::sqrt2;

// 20 um with noise of 0.2 um
std::vector<double> Vibration(std::size_t count, std::uint64_t seed, double tone_hz = 175) {
  std::vector<double> values = Samples(kRateHz, count, 0.03, {{20e-6, tone_hz}});
  Noise noise(seed);
  for (double& x : values) x += 2e-7 * noise();
  return values;
}

// a record and what is left of it; the record must outlive the rows
struct Cleaned {
  explicit Cleaned(trial::Record given) : record(std::move(given)) {}

  trial::Record record;
  trial::RecordRows rows{record};
  CleanChannel clean = Clean(rows, 0).value();
};

// rows of `record` that `keep` says stay, as the times of a table without the others give them
template <typename Keep>
trial::Record WithRows(const trial::Record& record, const Keep& keep) {
  trial::Record left = record;
  left.stretches.clear();
  left.channels[0].values.clear();
  left.channels[0].statuses.clear();
  bool follows = false;
  for (std::size_t row = 0; row < record.rows; ++row) {
    if (!keep(row)) {
      follows = false;
      continue;
    }
    if (!follows) {
      left.stretches.push_back(
          {left.channels[0].values.size(), 0, static_cast<double>(row) / kRateHz, kRateHz, 0});
    }
    follows = true;
    ++left.stretches.back().rows;
    left.channels[0].values.push_back(record.channels[0].values[row]);
    left.channels[0].statuses.push_back(SampleStatus::kOk);
  }
  left.rows = left.channels[0].values.size();
  return left;
}

TEST(CleanRows, AbsentRowsAreMissingValues) {
  for (const std::size_t every : {std::size_t{97}, std::size_t{1500}}) {
    trial::Record missing = RecordOf(Vibration(15'000, 1), kRateHz);
    const auto keep = [&](std::size_t row) { return row % every != every / 2; };
    const trial::Record absent = WithRows(missing, keep);
    for (std::size_t row = 0; row < missing.rows; ++row) {
      if (keep(row)) continue;
      missing.channels[0].values[row] = std::numeric_limits<double>::quiet_NaN();
      missing.channels[0].statuses[row] = SampleStatus::kLate;
    }
    const auto one = AnalyzeBand(missing, {});
    const auto other = AnalyzeBand(absent, {});
    ASSERT_TRUE(one && other && one->answered && other->answered) << every;
    // the rate is a quotient of times, rounded once
    EXPECT_REL(other->numbers->rms.rms_m, one->numbers->rms.rms_m, 1e-12, "rounding of the rate");
    EXPECT_REL(other->numbers->rms.upper_m, one->numbers->rms.upper_m, 1e-9, "the same");
    EXPECT_EQ(other->record.bridged, one->record.bridged);
    EXPECT_EQ(other->record.segments, 1U);
    EXPECT_EQ(other->faults.Count(FaultKind::kStep), 0U);
    EXPECT_EQ(other->record.rows, absent.rows);
    EXPECT_LT(other->numbers->rms.lower_m, kTruthM);
    EXPECT_GT(other->numbers->rms.upper_m, kTruthM);
  }
}

TEST(CleanRows, StretchesOnOtherClocksStayApart) {
  trial::Record record = RecordOf(Vibration(4000, 2), kRateHz);
  // a gap of 7.5 rows, and one of 8 rows at another rate
  record.stretches = {{0, 1000, 0, kRateHz, 0},
                      {1000, 1000, 1007.5 / kRateHz, kRateHz, 0},
                      {2000, 2000, 2015.5 / kRateHz, 1.001 * kRateHz, 0}};
  const Cleaned cleaned(record);
  const CleanChannel& clean = cleaned.clean;
  EXPECT_FALSE(clean.rows->AnyAbsent());
  EXPECT_EQ(clean.segments.parts.size(), 3U);
}

TEST(CleanRows, ReadingsThatAStreamLostAreMissingValues) {
  // on one line, as the counts of a stream place them
  trial::Record stream = WithRows(RecordOf(Vibration(15'000, 1), kRateHz),
                                  [](std::size_t row) { return row % 500 != 250; });
  stream.timing = trial::Timing::kArrival;
  const Cleaned counted(stream);
  EXPECT_EQ(counted.clean.segments.parts.size(), 1U);
  EXPECT_EQ(counted.clean.segments.bridged, 30U);
  // a gap whose length is only known by arrival is no whole number of rows
  for (std::size_t k = 0; k < stream.stretches.size(); ++k) {
    stream.stretches[k].start_s += 0.05 * static_cast<double>(k) / kRateHz;
  }
  EXPECT_EQ(Cleaned(stream).clean.segments.parts.size(), 31U);
  // polled readings have times of their own
  stream.timing = trial::Timing::kPolled;
  EXPECT_EQ(Cleaned(stream).clean.segments.parts.size(), 31U);
}

TEST(CleanRows, RowsOfTheSource) {
  const trial::Record whole = RecordOf(Vibration(4000, 3), kRateHz);
  const Cleaned cleaned(WithRows(whole, [](std::size_t row) { return row < 1000 || row > 1004; }));
  const CleanChannel& clean = cleaned.clean;
  ASSERT_TRUE(clean.rows->AnyAbsent());
  EXPECT_EQ(clean.rows->head().rows, 4000U);
  EXPECT_EQ(clean.rows->RowOf(999), 999U);
  EXPECT_EQ(clean.rows->RowOf(1002), 1000U);
  EXPECT_EQ(clean.rows->RowOf(1005), 1000U);
  EXPECT_EQ(clean.rows->RowOf(3999), 3994U);
  EXPECT_TRUE(clean.rows->IsAbsent(1004));
  EXPECT_FALSE(clean.rows->IsAbsent(1005));
}

// -99.998 and its like in any unit, rails, and values beyond 50 mm
TEST(CleanRows, CodesOfNoReadingAreExcluded) {
  struct Case {
    double value_m;
    SampleStatus status;
    double offset_m;
  };
  for (const Case& one :
       {Case{-99.998e-3, SampleStatus::kInvalid, 0.03}, Case{99.999e-3, SampleStatus::kOver, 0.03},
        Case{-99.999e-3, SampleStatus::kUnder, 0.03}, Case{-999.98e-6, SampleStatus::kInvalid, 0},
        Case{999.99e-6, SampleStatus::kOver, 0}, Case{0.2, SampleStatus::kOver, 0.03},
        Case{31.5e-3, SampleStatus::kOver, 0.03}}) {
    for (const std::size_t rows : {5U, 60U, 700U}) {
      trial::Record record = RecordOf(Vibration(15'000, 2), kRateHz);
      for (double& x : record.channels[0].values) x += one.offset_m - 0.03;
      for (std::size_t k = 0; k < rows; ++k) {
        record.channels[0].values[(k * 7919) % 15'000] = one.value_m;
      }
      const auto analysis = AnalyzeBand(record, {});
      ASSERT_TRUE(analysis && analysis->answered) << one.value_m << " " << rows;
      EXPECT_EQ(analysis->record.by_status[static_cast<std::size_t>(one.status)], rows);
      EXPECT_LE(analysis->numbers->rms.lower_m, kTruthM) << one.value_m << " " << rows;
      EXPECT_GE(analysis->numbers->rms.upper_m, kTruthM) << one.value_m << " " << rows;
      EXPECT_REL(analysis->numbers->rms.rms_m, kTruthM, 0.01, "5 % of the rows interpolated");
    }
  }
}

TEST(CleanRows, MotionThatSitsAtOneValueIsNoCode) {
  // a square wave, a pulse without noise, a drive that pauses, a rail far from nothing
  std::vector<double> square(10'000);
  std::vector<double> pulses(10'000, 0.03);
  std::vector<double> gated = Samples(kRateHz, 10'000, 0.03, {{20e-6, 175}});
  for (std::size_t k = 0; k < square.size(); ++k) {
    square[k] = 0.03 + ((k / 25) % 2 == 0 ? 20e-6 : -20e-6);
    if (k % 500 < 5) pulses[k] += 1e-3;
    if (k > 3000) gated[k] = 0.03;
  }
  // five values a period, of which two differ in their last digit
  std::vector<double> five(10'000);
  for (std::size_t k = 0; k < five.size(); ++k) {
    five[k] = 20e-6 * std::sin(0.4 * std::numbers::pi * static_cast<double>(k % 5));
    if (k % 10 == 2) five[k] += 1e-20;
  }
  for (const auto& values : {square, pulses, gated, five}) {
    EXPECT_TRUE(Cleaned(RecordOf(values, kRateHz)).clean.codes.empty());
  }
}

TEST(CleanRows, SpikesNeverReachTheNumber) {
  for (const double height_m : {2e-4, -1e-3, 10e-3}) {
    for (std::size_t seed = 1; seed <= 4; ++seed) {
      trial::Record record = RecordOf(Vibration(15'000, seed), kRateHz);
      for (std::size_t row = 600 + seed; row < 15'000; row += 1777) {
        record.channels[0].values[row] += height_m;
        if (seed % 2 == 0) record.channels[0].values[row + 1] += height_m;
      }
      const auto analysis = AnalyzeBand(record, {});
      ASSERT_TRUE(analysis && analysis->answered);
      EXPECT_EQ(analysis->faults.Count(FaultKind::kSpike), 9U);
      EXPECT_LE(analysis->numbers->rms.lower_m, kTruthM) << height_m;
      EXPECT_GE(analysis->numbers->rms.upper_m, kTruthM) << height_m;
      EXPECT_REL(analysis->numbers->rms.rms_m, kTruthM, 2e-3, "noise and 18 interpolated rows");
    }
  }
}

// square waves, drives that are switched, and bumps, with noise and without: of 30 records two have
// a row excluded
TEST(CleanRows, SharpMotionIsNoSpike) {
  std::size_t excluded = 0;
  for (std::size_t seed = 1; seed <= 10; ++seed) {
    const double noise_m = seed % 2 == 0 ? 0 : 1e-7;
    const double tone_hz = 60 + 20 * static_cast<double>(seed);
    std::vector<double> square = Samples(kRateHz, 15'000, 0, {{20e-6, tone_hz / 2, 0.1}});
    std::vector<double> gated = Samples(kRateHz, 15'000, 0, {{20e-6, tone_hz, 1}});
    std::vector<double> bump = Samples(kRateHz, 15'000, 0, {{20e-6, tone_hz}});
    Noise noise(seed);
    for (std::size_t k = 0; k < square.size(); ++k) {
      square[k] = (square[k] < 0 ? -20e-6 : 20e-6) + noise_m * noise();
      if (k < 5000 || k > 12'000) gated[k] = 0;
      gated[k] += noise_m * noise();
      const double t_s = (static_cast<double>(k) - 7500) / kRateHz;
      if (t_s > 0)
        bump[k] += 20e-6 * std::exp(-t_s / 0.05) * std::sin(2 * std::numbers::pi * 30 * t_s);
      bump[k] += noise_m * noise();
    }
    for (const auto& values : {square, gated, bump}) {
      // an edge in the last three rows cannot be told from a spike
      const Cleaned cleaned(RecordOf(values, kRateHz));
      excluded += static_cast<std::size_t>(std::ranges::count_if(
          cleaned.clean.faults.excluded, [](const RowRange& range) { return range.end < 14'997; }));
    }
  }
  // two of the noise-free bumps: 0.2 um at the kink where 40 um move
  EXPECT_LE(excluded, 2U);
}

TEST(CleanRows, HeldReadingsAreMissingValues) {
  trial::Record record = RecordOf(Vibration(15'000, 8), kRateHz);
  auto& values = record.channels[0].values;
  for (std::size_t k = 1; k < 50; ++k) values[7000 + k] = values[7000];
  const auto analysis = AnalyzeBand(record, {});
  ASSERT_TRUE(analysis && analysis->answered);
  EXPECT_EQ(analysis->record.bridged, 49U);
  EXPECT_EQ(analysis->record.segments, 1U);
  EXPECT_GT(analysis->numbers->part.window.duration_s(), 2.0);
  EXPECT_LE(analysis->numbers->rms.lower_m, kTruthM);
  EXPECT_GE(analysis->numbers->rms.upper_m, kTruthM);
}

// 1000 rows up and down between `least` and `least` + 100 `step`, with `count` of them at `value`
std::size_t CodesAmong(double least, double step, double value, std::size_t count) {
  std::vector<double> values(1000);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::size_t turn = k % 200;
    values[k] = least + step * static_cast<double>(turn <= 100 ? turn : 200 - turn);
  }
  for (std::size_t k = 0; k < count; ++k) values[(50 + 7 * k) % 1000] = value;
  const Cleaned cleaned(RecordOf(values, kRateHz));
  for (const NoReadingCode& code : cleaned.clean.codes) EXPECT_EQ(code.rows, count);
  return cleaned.clean.codes.size();
}

// 0.1 mm of motion: a rail is 1 mm from it, three times
TEST(CleanRows, ARailIsTenTimesFromWhatTheOthersSpan) {
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.0301 + 9.95e-4, 3), 0U);
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.0301 + 10.05e-4, 3), 1U);
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.0301 + 10.05e-4, 2), 0U) << "twice";
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.03 - 9.95e-4, 3), 0U);
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.03 - 10.05e-4, 3), 1U);
}

TEST(CleanRows, AReadingBeyondFiftyMillimetresIsACode) {
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.0301 + 0.0497, 1), 0U);
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.0301 + 0.0503, 1), 1U);
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.03 - 0.0497, 1), 0U);
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.03 - 0.0503, 1), 1U);
}

TEST(CleanRows, FourNinesOrThreeAndAnEightAreACode) {
  for (const double sign : {1.0, -1.0}) {
    const double least = sign > 0 ? 0 : -3e-4;
    EXPECT_EQ(CodesAmong(least, 3e-6, sign * 9.998e-4, 1), 1U) << sign;
    EXPECT_EQ(CodesAmong(least, 3e-6, sign * 9.999e-4, 1), 1U) << sign;
    EXPECT_EQ(CodesAmong(least, 3e-6, sign * 9.9998e-4, 1), 1U) << sign;
    EXPECT_EQ(CodesAmong(least, 3e-6, sign * 9.997e-4, 1), 0U) << sign;
    EXPECT_EQ(CodesAmong(least, 3e-6, sign * 9.989e-4, 1), 0U) << sign;
    EXPECT_EQ(CodesAmong(least, 3e-6, sign * 9.99e-4, 1), 0U) << "three";
    // a gap of 0.505 and of 0.495 mm beside what spans 0.5 mm
    EXPECT_EQ(CodesAmong(sign > 0 ? -5.1e-6 : -494.9e-6, 5e-6, sign * 999.9e-6, 1), 1U) << sign;
    EXPECT_EQ(CodesAmong(sign > 0 ? 4.9e-6 : -504.9e-6, 5e-6, sign * 999.9e-6, 1), 0U) << sign;
  }
}

TEST(CleanRows, ACodeIsInLessThanHalfOfTheRows) {
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.2, 499), 1U);
  EXPECT_EQ(CodesAmong(0.03, 1e-6, 0.2, 500), 0U);
}

// two stretches of 1000 rows; whether they are one with `gap_rows` between them
bool AreOneClock(double gap_rows, double second_rate_hz, trial::Timing timing) {
  trial::Record record = RecordOf(std::vector<double>(2000, 0.03), kRateHz);
  record.timing = timing;
  record.stretches = {{0, 1000, 0, kRateHz, 0},
                      {1000, 1000, (1000 + gap_rows) / kRateHz, second_rate_hz, 0}};
  const trial::RecordRows rows(record);
  const CleanRows clean(rows, 0);
  EXPECT_EQ(clean.AnyAbsent(), clean.head().stretches.size() == 1);
  return clean.AnyAbsent();
}

TEST(CleanRows, OneClockIsATenthOfARowAndOneRate) {
  using enum trial::Timing;
  EXPECT_TRUE(AreOneClock(8.099, kRateHz, kUniform));
  EXPECT_FALSE(AreOneClock(8.101, kRateHz, kUniform));
  EXPECT_TRUE(AreOneClock(7.901, kRateHz, kUniform));
  EXPECT_FALSE(AreOneClock(7.899, kRateHz, kUniform));
  EXPECT_TRUE(AreOneClock(8, kRateHz * (1 + 0.99e-4), kUniform));
  EXPECT_FALSE(AreOneClock(8, kRateHz * (1 + 1.01e-4), kUniform));
  EXPECT_FALSE(AreOneClock(8, kRateHz * (1 - 1.01e-4), kUniform));
  // counted readings lie on one line
  EXPECT_TRUE(AreOneClock(8 + 0.9e-6, kRateHz, kArrival));
  EXPECT_FALSE(AreOneClock(8 + 1.1e-6, kRateHz, kArrival));
  EXPECT_FALSE(AreOneClock(8, kRateHz * (1 + 1e-9), kArrival));
}

TEST(CleanRows, OneRowToAsManyAsThereAreMayBeAbsent) {
  using enum trial::Timing;
  EXPECT_FALSE(AreOneClock(0.05, kRateHz, kUniform));
  EXPECT_TRUE(AreOneClock(0.95, kRateHz, kUniform));
  EXPECT_TRUE(AreOneClock(2000, kRateHz, kUniform));
  EXPECT_FALSE(AreOneClock(2001, kRateHz, kUniform));
}

TEST(CleanRows, TheRateOfJoinedStretchesIsByTheFirstRowAndTheLast) {
  trial::Record record = RecordOf(std::vector<double>(2000, 0.03), kRateHz);
  record.stretches = {{0, 1000, 0, kRateHz, 0}, {1000, 1000, 1008.08 / kRateHz, kRateHz, 0}};
  const trial::RecordRows rows(record);
  const CleanRows clean(rows, 0);
  ASSERT_EQ(clean.head().stretches.size(), 1U);
  EXPECT_EQ(clean.head().rows, 2008U);
  EXPECT_REL(clean.head().stretches[0].rate_hz, kRateHz * 2007 / 2007.08, 1e-13, "rounding");
}

// Rows are looked at 1024 at a time: the first of the next ones, and the last, count once.
TEST(CleanRows, EveryRowOfARailCountsOnce) {
  for (const std::size_t row : {1023U, 1024U, 2047U, 2048U}) {
    for (const std::size_t times : {2U, 3U}) {
      std::vector<double> values(3000);
      for (std::size_t k = 0; k < values.size(); ++k) {
        const std::size_t turn = k % 200;
        values[k] = 0.03 + 1e-6 * static_cast<double>(turn <= 100 ? turn : 200 - turn);
      }
      for (std::size_t k = 0; k < times; ++k) values[k == 0 ? row : 500 * k + 7] = 0.04;
      const Cleaned cleaned(RecordOf(values, kRateHz));
      ASSERT_EQ(cleaned.clean.codes.size(), times - 2) << row << ' ' << times;
      for (const NoReadingCode& code : cleaned.clean.codes) EXPECT_EQ(code.rows, 3U);
    }
  }
}

// 40 rows of one code and 3 of another, in blocks that are passed over on several threads
TEST(CleanRows, EachCodeHasItsOwnRows) {
  trial::Record record = RecordOf(Vibration(200'000, 5), kRateHz);
  auto& values = record.channels[0].values;
  for (std::size_t k = 0; k < 40; ++k) values[(k * 7919) % values.size()] = -9.999e-3;
  for (std::size_t k = 1; k < 4; ++k) values[50'001 * k] = 9.9999;
  for (const int threads : {1, 3}) {
    const trial::RecordRows rows(record);
    const CleanChannel clean = Clean(rows, 0, threads).value();
    ASSERT_EQ(clean.codes.size(), 2U);
    EXPECT_EQ(clean.codes[0].rows, 40U);
    EXPECT_EQ(clean.codes[1].rows, 3U);
  }
}

// 1600 spikes are excluded and interpolated; what is clipped beside them, at 7000 peaks, is the
// same
TEST(CleanRows, WhatIsClippedBesideManySpikesIsTheSame) {
  std::vector<double> values = Vibration(200'000, 6);
  for (double& x : values) x = std::min(std::round(x / 1e-8) * 1e-8, 0.030015);
  const Cleaned plain(RecordOf(values, kRateHz));
  std::size_t spikes = 0;
  for (std::size_t row = 200; row < values.size() - 200; row += 124) {
    // away from the peaks
    if (values[row] > 0.03) continue;
    values[row] -= 3e-4;
    ++spikes;
  }
  const Cleaned cleaned(RecordOf(values, kRateHz));
  const Faults& faults = cleaned.clean.faults;
  EXPECT_EQ(faults.Count(FaultKind::kSpike), spikes);
  EXPECT_EQ(faults.Count(FaultKind::kHeld), 0U);
  EXPECT_GT(faults.Count(FaultKind::kClipped), 6 * kMostListed);
  EXPECT_EQ(faults.Rows(FaultKind::kClipped), plain.clean.faults.Rows(FaultKind::kClipped));
  EXPECT_EQ(ClippedRows(faults, 150'000, 10'000), ClippedRows(plain.clean.faults, 150'000, 10'000));
}

// three spikes near each other, of which some are found once the others are excluded
TEST(CleanRows, TheFirstOfEachKindAreListed) {
  std::vector<double> values = Vibration(200'000, 7);
  for (std::size_t row = 200; row < values.size() - 200; row += 150) {
    for (const std::size_t beside : {0U, 3U, 5U}) values[row + beside] += 3e-4;
  }
  const Faults faults = Cleaned(RecordOf(values, kRateHz)).clean.faults;
  EXPECT_GT(faults.Count(FaultKind::kSpike), kMostListed);
  EXPECT_EQ(std::ranges::count(faults.list, FaultKind::kSpike, &Fault::kind), 1000);
}

// at the end of the range: clipped, unless it is a spike, which is excluded
TEST(CleanRows, ASpikeThatReachesTheRangeIsNotClipped) {
  trial::Record record = RecordOf(Vibration(15'000, 7), kRateHz);
  record.channels[0].range_max = 0.031;
  record.channels[0].values[7000] = 0.031;
  const Faults faults = Cleaned(record).clean.faults;
  EXPECT_EQ(faults.Count(FaultKind::kSpike), 1U);
  EXPECT_EQ(faults.Count(FaultKind::kClipped), 0U);
  EXPECT_EQ(ClippedRows(faults, 0, 15'000), 0U);
}

}  // namespace
}  // namespace haptometer::dsp
