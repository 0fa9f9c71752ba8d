// The oracle is the closed form: sums of tones, at the jittered times and at the grid's.
#include "dsp/readings/regular_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kRateHz = 10e3;
constexpr double kPeriodS = 1 / kRateHz;
constexpr double kUpperHz = 500;

double Motion(double t_s) {
  return 0.03 + 1e-6 * std::sin(2 * std::numbers::pi * 225 * t_s + 1) +
         1e-6 * std::sin(2 * std::numbers::pi * 500 * t_s);
}

// readings at (k + jitter) / rate for each k of `places`
trial::Record Jittered(const std::vector<double>& places, double jitter_periods) {
  Noise noise(7);
  std::vector<double> values;
  std::vector<double> times_s;
  for (const double place : places) {
    const double off = std::clamp(noise(), -2.5, 2.5);
    times_s.push_back((place + jitter_periods * off) * kPeriodS);
    values.push_back(Motion(times_s.back()));
  }
  trial::Record record = RecordOf(values, kRateHz);
  record.timing = trial::Timing::kPolled;
  record.raw_times_s = times_s;
  record.times_are_known = true;
  return record;
}

std::vector<double> Counted(std::size_t count) {
  std::vector<double> places;
  for (std::size_t k = 0; k < count; ++k) places.push_back(static_cast<double>(k));
  return places;
}

double WorstError(const trial::Record& record) {
  double worst = 0;
  for (std::size_t row = 0; row < record.rows; ++row) {
    if (std::isnan(record.channels[0].values[row])) continue;
    const double error = record.channels[0].values[row] - Motion(TimeOf(record, row));
    worst = std::max(worst, std::abs(error));
  }
  return worst;
}

TEST(RegularGrid, SmallJitterIsTakenOutWithinTheBound) {
  for (const double jitter : {0.001, 0.02, 0.1}) {
    const auto grid = OnRegularGrid(Jittered(Counted(5000), jitter), kUpperHz);
    ASSERT_FALSE(grid.refusal);
    EXPECT_EQ(grid.record.rows, 5000U);
    EXPECT_EQ(grid.record.timing, trial::Timing::kUniform);
    EXPECT_EQ(grid.dropped, 0U);
    EXPECT_EQ(grid.left_out, 0U);
    // the slope's uncertainty is jitter sqrt(12) / n^1.5 of a period
    EXPECT_REL(grid.rate_hz, kRateHz, 5 * jitter * std::sqrt(12) / std::pow(5000, 1.5),
               "five times the slope's uncertainty");
    EXPECT_REL(grid.jitter_s, jitter * kPeriodS, 0.06, "5000 values; cut at 2.5 sd");
    // two tones of 1 um, and rounding at 30 mm
    EXPECT_ABS(WorstError(grid.record), 0, 2e-6 * grid.error_bound + 1e-16, "the stated bound");
    // left alone, jitter would add 2 pi f s
    EXPECT_LT(grid.error_bound, 2 * std::numbers::pi * kUpperHz * grid.jitter_s / 50);
  }
}

TEST(RegularGrid, TheBoundIsNotTooFarFromTheError) {
  // a tone at the upper corner itself
  trial::Record record = Jittered(Counted(5000), 0.1);
  for (std::size_t row = 0; row < record.rows; ++row) {
    record.channels[0].values[row] =
        std::sin(2 * std::numbers::pi * 1500 * record.raw_times_s[row]);
  }
  const auto tone = OnRegularGrid(record, 1500);
  ASSERT_FALSE(tone.refusal);
  double worst = 0;
  for (std::size_t row = 0; row < tone.record.rows; ++row) {
    const double t_s = TimeOf(tone.record, row);
    worst = std::max(worst, std::abs(tone.record.channels[0].values[row] -
                                     std::sin(2 * std::numbers::pi * 1500 * t_s)));
  }
  EXPECT_LT(worst, tone.error_bound);
  EXPECT_GT(worst, tone.error_bound / 10);
}

TEST(RegularGrid, DroppedReadingsAreHolesAndNotJitter) {
  std::vector<double> places;
  for (int k = 0; k < 3000; ++k) {
    // two lost in a row now and then, fifty once
    if (k % 500 == 77 || k % 500 == 78 || (k >= 2000 && k < 2050)) continue;
    places.push_back(k);
  }
  const auto grid = OnRegularGrid(Jittered(places, 0.02), kUpperHz);
  ASSERT_FALSE(grid.refusal);
  EXPECT_EQ(grid.dropped, 62U);
  // six pairs and the fifty, each behind a stretch; twelve rows are lost before the fifty
  ASSERT_EQ(grid.record.stretches.size(), 8U);
  EXPECT_EQ(grid.record.stretches[1].first_row, 77U);
  EXPECT_EQ(grid.record.stretches[5].first_row, 1992U);
  EXPECT_ABS(grid.record.stretches[5].start_s, 0.205, 1e-3 * kPeriodS, "the line's uncertainty");
  EXPECT_EQ(grid.record.rows, 2938U);
  EXPECT_ABS(WorstError(grid.record), 0, 2e-6 * grid.error_bound + 1e-16, "the stated bound");
}

TEST(RegularGrid, ReadingsWithoutAMeasurementStaySo) {
  trial::Record record = Jittered(Counted(200), 0.05);
  record.channels[0].statuses[50] = SampleStatus::kOver;
  record.channels[0].values[60] = std::numeric_limits<double>::infinity();
  const auto grid = OnRegularGrid(record, kUpperHz);
  ASSERT_FALSE(grid.refusal);
  EXPECT_EQ(grid.record.channels[0].statuses[50], SampleStatus::kOver);
  EXPECT_TRUE(std::isnan(grid.record.channels[0].values[50]));
  EXPECT_TRUE(std::isnan(grid.record.channels[0].values[60]));
  EXPECT_ABS(WorstError(grid.record), 0, 2e-6 * grid.error_bound + 1e-16, "the stated bound");
}

TEST(RegularGrid, LargeJitterIsRefused) {
  const auto grid = OnRegularGrid(Jittered(Counted(2000), 0.25), kUpperHz);
  ASSERT_TRUE(grid.refusal);
  EXPECT_EQ(grid.refusal->kind, FindingKind::kTimesTooUneven);
}

// intervals then lie between half a period and 1.6: what is late is not dropped
TEST(RegularGrid, JitterOfAQuarterPeriodDropsNothing) {
  const std::vector<double> all = Counted(20'000);
  std::vector<double> some;
  for (const double k : all) {
    if (std::fmod(k, 100) != 50) some.push_back(k);
  }
  for (const auto& places : {all, some}) {
    const auto grid = OnRegularGrid(Jittered(places, 0.12), kUpperHz);
    ASSERT_FALSE(grid.refusal);
    EXPECT_EQ(grid.dropped, all.size() - places.size());
    EXPECT_REL(grid.rate_hz, kRateHz, 1e-6, "12 / (sqrt(12) 20 000^1.5) of a period");
    EXPECT_REL(grid.jitter_s, 0.12 * kPeriodS, 0.03, "of 20 000 clamped values");
    EXPECT_ABS(WorstError(grid.record), 0, 2e-6 * grid.error_bound + 1e-16, "the stated bound");
  }
}

// what is refused is refused by the numbers that are true
TEST(RegularGrid, JitterIsStatedAsItIsWhereItIsRefused) {
  const auto grid = OnRegularGrid(Jittered(Counted(20'000), 0.2), kUpperHz);
  ASSERT_TRUE(grid.refusal);
  EXPECT_REL(NumberOf(*grid.refusal, "jitter_s"), 0.2 * kPeriodS, 0.03, "clamped at 2.5");
  EXPECT_REL(NumberOf(*grid.refusal, "largest_jitter_s"), 0.5 * kPeriodS, 2e-2,
             "the clamp; the line is known to 0.003 periods at its ends");
}

TEST(RegularGrid, OfRowsIsThatOfTheirRecord) {
  const trial::Record record = Jittered(Counted(500), 0.05);
  const auto grid = OnRegularGrid(trial::RecordRows(record), kUpperHz);
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->record.channels[0].values,
            OnRegularGrid(record, kUpperHz).record.channels[0].values);
}

// each channel by itself: of two with the same readings twice as many are left out, and none is
// refused
TEST(RegularGrid, ASecondChannelIsNotChargedWithTheFirstOnesReadings) {
  const trial::Record one = Jittered(Counted(2000), 0.05);
  double upper_hz = 2000;
  std::size_t left_out = 0;
  for (; left_out < 700; upper_hz += 25) {
    const auto grid = OnRegularGrid(one, upper_hz);
    ASSERT_FALSE(grid.refusal) << upper_hz;
    left_out = grid.left_out;
  }
  trial::Record two = one;
  two.channels.push_back(one.channels[0]);
  const auto grid = OnRegularGrid(two, upper_hz - 25);
  EXPECT_FALSE(grid.refusal);
  EXPECT_EQ(grid.left_out, 2 * left_out);
}

TEST(RegularGrid, TooFewReadingsForTheBandAreRefused) {
  const auto grid = OnRegularGrid(Jittered(Counted(2000), 0.05), 4500);
  ASSERT_TRUE(grid.refusal);
  EXPECT_EQ(grid.refusal->kind, FindingKind::kReadingsTooFarApart);
  EXPECT_EQ(tests::NumbersOf(*grid.refusal).substr(0, 14), "upper_hz=4500 ");
  const auto short_grid = OnRegularGrid(Jittered(Counted(3), 0.01), kUpperHz);
  ASSERT_TRUE(short_grid.refusal);
  EXPECT_EQ(short_grid.refusal->kind, FindingKind::kFewUnevenTimes);
}

// the motion at `times_s`
trial::Record AtTimes(const std::vector<double>& times_s) {
  std::vector<double> values;
  values.reserve(times_s.size());
  for (const double t_s : times_s) values.push_back(Motion(t_s));
  trial::Record record = RecordOf(values, kRateHz);
  record.timing = trial::Timing::kPolled;
  record.raw_times_s = times_s;
  record.times_are_known = true;
  return record;
}

// even times, one of them `late_periods` late
trial::Record WithOneLate(std::size_t count, double late_periods) {
  std::vector<double> times_s;
  for (const double place : Counted(count)) times_s.push_back(place * kPeriodS);
  times_s[count / 2] += late_periods * kPeriodS;
  return AtTimes(times_s);
}

TEST(RegularGrid, AReadingDroppedAtTheBeginIsSeen) {
  for (const std::size_t dropped : {1U, 2U, 3U}) {
    std::vector<double> places = Counted(500);
    places.erase(places.begin() + static_cast<std::ptrdiff_t>(dropped));
    const auto grid = OnRegularGrid(Jittered(places, 0.01), kUpperHz);
    ASSERT_FALSE(grid.refusal);
    EXPECT_EQ(grid.dropped, 1U) << dropped;
    ASSERT_EQ(grid.record.stretches.size(), 2U) << dropped;
    EXPECT_EQ(grid.record.stretches[1].first_row, dropped);
    EXPECT_ABS(grid.record.stretches[1].start_s, (static_cast<double>(dropped) + 1) * kPeriodS,
               0.01 * kPeriodS, "the line's uncertainty");
  }
}

// late and early by a fifth in an order that shares nothing with a line: eight rows less two
TEST(RegularGrid, JitterIsTheDeviationAboutTheLine) {
  constexpr double kOff[] = {1, -1, -1, 1, 1, -1, -1, 1};
  std::vector<double> times_s;
  for (std::size_t k = 0; k < 8; ++k) {
    times_s.push_back(100 + (static_cast<double>(k) + 0.2 * kOff[k]) * kPeriodS);
  }
  const auto grid = OnRegularGrid(AtTimes(times_s), 10);
  ASSERT_FALSE(grid.refusal);
  constexpr const char* kReason = "rounding of 100 s, 1.4e-14 s";
  EXPECT_REL(grid.rate_hz, kRateHz, 1e-9, kReason);
  EXPECT_REL(grid.jitter_s, 0.2 * kPeriodS * std::sqrt(8.0 / 6), 1e-8, kReason);
  EXPECT_REL(grid.largest_jitter_s, 0.2 * kPeriodS, 1e-8, kReason);
  EXPECT_ABS(grid.record.stretches[0].start_s, 100, 1e-12, kReason);
}

TEST(RegularGrid, ATimeMayBeNearlyHalfAPeriodFromItsPlace) {
  EXPECT_FALSE(OnRegularGrid(WithOneLate(2000, 0.448), 100).refusal);
  const auto grid = OnRegularGrid(WithOneLate(2000, 0.452), 100);
  ASSERT_TRUE(grid.refusal);
  EXPECT_EQ(grid.refusal->kind, FindingKind::kTimesTooUneven);
  EXPECT_REL(NumberOf(*grid.refusal, "largest_jitter_s"), 0.452 * kPeriodS, 1e-3,
             "the line moves by 1 / 2000 of it");
}

// places whose clock goes wrong by up to `periods`, slowly, as one that is set right again
std::vector<double> Drifting(std::size_t count, double periods) {
  std::vector<double> places;
  for (std::size_t k = 0; k < count; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(count);
    places.push_back(static_cast<double>(k) + periods * std::sin(2 * std::numbers::pi * share));
  }
  return places;
}

TEST(RegularGrid, AClockThatDriftsIsInterpolatedToEvenTimes) {
  for (const double jitter : {0.0, 0.02}) {
    const auto grid = OnRegularGrid(Jittered(Drifting(20000, 6), jitter), kUpperHz);
    ASSERT_FALSE(grid.refusal);
    EXPECT_EQ(grid.dropped, 0U);
    EXPECT_EQ(grid.left_out, 0U);
    EXPECT_EQ(grid.record.stretches.size(), 1U);
    // 6 sin(2 pi u) less its line -(36/pi) (u - 1/2) is largest at the ends: 18/pi = 5.73
    EXPECT_NEAR(grid.drift_s, 18 / std::numbers::pi * kPeriodS, 0.1 * kPeriodS);
    EXPECT_NEAR(grid.jitter_s, jitter * kPeriodS, 0.05 * kPeriodS);
    // two tones of 1 um, and rounding at 30 mm
    EXPECT_ABS(WorstError(grid.record), 0, 2e-6 * grid.error_bound + 1e-16, "the stated bound");
    EXPECT_LT(grid.error_bound, 1e-3);
  }
  // 0.3 periods from an even grid are jitter
  EXPECT_EQ(OnRegularGrid(Jittered(Drifting(20000, 0.3), 0), kUpperHz).drift_s, 0);
}

// behind a long pause a clock has any place between two of the grid's
TEST(RegularGrid, AClockThatDriftsMayPauseForAnyTime) {
  for (const double pause : {1000.0, 1000.2, 1000.45, 1000.5, 1000.7, 7.2e7 + 0.48}) {
    auto places = Drifting(20000, 6);
    for (std::size_t k = 9000; k < places.size(); ++k) places[k] += pause;
    const auto grid = OnRegularGrid(Jittered(places, 0.01), kUpperHz);
    ASSERT_FALSE(grid.refusal) << pause;
    EXPECT_EQ(grid.record.stretches.size(), 2U) << pause;
    EXPECT_NEAR(static_cast<double>(grid.record.rows), 20000, 14) << pause;
  }
}

TEST(RegularGrid, ReadingsDroppedFromADriftingClockStayHoles) {
  auto places = Drifting(20000, 6);
  places.erase(places.begin() + 7000, places.begin() + 7040);
  trial::Record record = Jittered(places, 0.01);
  record.channels[0].statuses[12000] = SampleStatus::kLate;
  record.channels[0].values[12000] = std::numeric_limits<double>::quiet_NaN();
  const auto grid = OnRegularGrid(record, kUpperHz);
  ASSERT_FALSE(grid.refusal);
  EXPECT_EQ(grid.dropped, 40U);
  ASSERT_EQ(grid.record.stretches.size(), 2U);
  EXPECT_NEAR(grid.record.stretches[1].start_s - grid.record.stretches[0].start_s,
              places[7000] * kPeriodS, 2 * kPeriodS);
  EXPECT_ABS(WorstError(grid.record), 0, 2e-6 * grid.error_bound + 1e-16, "the stated bound");
  EXPECT_EQ(grid.readings, 19960U);
  // the period of the line, of which the sine takes (36/pi)/n
  EXPECT_REL(grid.rate_hz, kRateHz / (1 - 36 / std::numbers::pi / 20000), 1e-5, "40 rows missing");
  // one row is late where one reading is
  EXPECT_EQ(std::ranges::count(grid.record.channels[0].statuses, SampleStatus::kLate), 1);
}

// Of four points, two before the late one and one behind it, the remainder is w^4 / 4! 2 p^3 d.
TEST(RegularGrid, TheBoundIsCauchysRemainder) {
  const double w = 2 * std::numbers::pi * 100 * kPeriodS;
  const auto grid = OnRegularGrid(WithOneLate(4000, 0.3), 100);
  ASSERT_FALSE(grid.refusal);
  EXPECT_EQ(grid.points, 4U);
  EXPECT_REL(grid.error_bound, std::pow(w, 4) / 24 * 2 * 0.3, 2e-3, "the line's 1 / 4000");
}

TEST(RegularGrid, ARowIsLeftOutWhereItsBoundIsAboveAThousandth) {
  for (const double share : {0.99, 1.01}) {
    const double w = std::pow(share * 1e-3 * 24 / (2 * 0.3), 0.25);
    const auto grid = OnRegularGrid(WithOneLate(4000, 0.3), w / (2 * std::numbers::pi) * kRateHz);
    ASSERT_FALSE(grid.refusal);
    ASSERT_EQ(grid.points, 4U) << "of the other rows the bound is below 1e-6";
    EXPECT_EQ(grid.left_out, share > 1 ? 1U : 0U) << share;
    EXPECT_EQ(std::isnan(grid.record.channels[0].values[2000]), share > 1);
  }
}

// times at 3 kHz that a spreadsheet rounded to milliseconds, and one time for all
TEST(RegularGrid, TimesThatRepeatAreRefused) {
  std::vector<double> rounded;
  for (int k = 0; k < 30'000; ++k) rounded.push_back(1e-3 * std::floor(k / 3.0));
  for (const auto& times_s : {rounded, std::vector<double>(1000, 0.25)}) {
    const RegularGrid grid = OnRegularGrid(AtTimes(times_s), 10);
    ASSERT_TRUE(grid.refusal);
    EXPECT_EQ(grid.refusal->kind, FindingKind::kTimesTooUneven);
  }
}

TEST(RegularGrid, NeedsFourRows) {
  EXPECT_TRUE(OnRegularGrid(AtTimes({0, kPeriodS, 2 * kPeriodS}), 10).refusal);
  EXPECT_FALSE(OnRegularGrid(AtTimes({0, kPeriodS, 2 * kPeriodS, 3 * kPeriodS}), 10).refusal);
}

}  // namespace
}  // namespace haptometer::dsp
