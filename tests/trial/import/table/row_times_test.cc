// Which rows of a table are when: stated clocks against printed times, segments, rates of the user.
#include "trial/import/table/row_times.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"
#include "trial/import/table/csv_header.h"

namespace haptometer::trial {
namespace {

using tests::NumbersOf;

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string ErrorOf(const std::string& text, const ImportOptions& options = {}) {
  const auto record = ParseCsv(text, "f.csv", options);
  return record ? "was read" : record.error().Text();
}

// --- rates that are said -------------------------------------------------------------------------

TEST(RowTimes, TheUsersRateIsTheTimesToOnePercent) {
  Record record;
  record.stretches = {{.rows = 2, .rate_hz = 1}, {.rows = 3}};
  const auto is_taken = [&](double rate_hz) {
    record.stretches[1].rate_hz = rate_hz;
    return CheckRate("f", {.rate_hz = 1000}, record).has_value();
  };
  EXPECT_TRUE(is_taken(1009.9));
  EXPECT_FALSE(is_taken(1010.1));
  EXPECT_TRUE(is_taken(990.1));
  EXPECT_FALSE(is_taken(989.9));
  EXPECT_TRUE(CheckRate("f", {}, record)) << "no rate is said";
}

// a rate that differs from the header's by more than 0.1 % comes without the header's start
TEST(RowTimes, ARateOfTheUserReplacesTheHeadersBeyondAThousandth) {
  const TimeWords words{.clock = StatedClock{.interval_s = 1e-3, .start_s = 0.5, .from = "XInc"}};
  for (const double rate_hz : {1000.9, 999.1}) {
    Findings findings;
    const Stretch stretch = UniformTimes(words, {.rate_hz = rate_hz}, 7, &findings);
    EXPECT_EQ(stretch.rows, 7U);
    EXPECT_EQ(stretch.rate_hz, rate_hz);
    EXPECT_EQ(stretch.start_s, 0.5);
    EXPECT_TRUE(findings.list().empty());
  }
  for (const double rate_hz : {1001.1, 998.9}) {
    Findings findings;
    const Stretch stretch = UniformTimes(words, {.rate_hz = rate_hz}, 7, &findings);
    EXPECT_EQ(stretch.rate_hz, rate_hz);
    EXPECT_EQ(stretch.start_s, 0);
    EXPECT_EQ(NumbersOf(findings, FindingKind::kRateReplaced),
              fmt::format("rate_hz={} stated_hz=1000 stated_by=XInc", rate_hz));
  }
}

TEST(RowTimes, AHeaderWithoutAStartPutsTheFirstRowAtZero) {
  Findings findings;
  const TimeWords words{.clock = StatedClock{.interval_s = 0.125, .from = "XInc"}};
  const Stretch stretch = UniformTimes(words, {}, 3, &findings);
  EXPECT_EQ(stretch.rate_hz, 8);
  EXPECT_EQ(stretch.start_s, 0);
  EXPECT_TRUE(findings.Has(FindingKind::kStartAssumed));
}

CsvRows::Segment SegmentAt(const std::vector<double>& times_s) {
  CsvRows::Segment segment{.rows = times_s.size(), .line = 1};
  for (const double time_s : times_s) segment.times.AddCount(time_s);
  return segment;
}

Result<Record> TimesOf(const std::vector<double>& times_s, const StatedClock& clock,
                       const ImportOptions& options = {}, Findings* findings = nullptr) {
  std::vector<std::size_t> left_out;
  Findings ignored;
  return ReadSegmentTimes("f", {.clock = clock}, options, SegmentAt(times_s), &left_out,
                          findings != nullptr ? findings : &ignored);
}

// three rows at about 1000 Hz, far from what their digits explain
TEST(RowTimes, PrintedTimesContradictTheHeaderBeyondAThousandth) {
  const StatedClock clock{.interval_s = 1e-3, .start_s = {}, .from = "XInc"};
  for (const double rate_hz : {1000.9, 999.1}) {
    const auto record = TimesOf({0, 1 / rate_hz, 2 / rate_hz}, clock);
    ASSERT_TRUE(record) << record.error().Text();
    EXPECT_REL(record->stretches.at(0).rate_hz, rate_hz, 1e-14, "rounding of the quotient");
  }
  for (const double rate_hz : {1001.1, 998.9}) {
    const auto record = TimesOf({0, 1 / rate_hz, 2 / rate_hz}, clock);
    ASSERT_FALSE(record);
    EXPECT_THAT(record.error().Text(),
                HasSubstr(fmt::format("f: its times give {} rows per second and 'XInc' gives 1000",
                                      rate_hz)));
  }
}

TEST(RowTimes, TheUsersRateDecidesForTheTimesWithinOnePercent) {
  const StatedClock clock{.interval_s = 1e-3, .start_s = {}, .from = "XInc"};
  for (const double said_hz : {1.0099, 0.9902}) {
    Findings findings;
    const auto record = TimesOf({5, 6, 7}, clock, {.rate_hz = said_hz}, &findings);
    ASSERT_TRUE(record) << record.error().Text();
    EXPECT_REL(record->stretches.at(0).rate_hz, 1, 1e-14, "rounding of the quotient");
    EXPECT_EQ(NumbersOf(findings, FindingKind::kRateContradicted),
              "rate_hz=1 stated_hz=1000 stated_by=XInc");
  }
  for (const double said_hz : {1.0103, 0.9898}) {
    const auto record = TimesOf({5, 6, 7}, clock, {.rate_hz = said_hz});
    ASSERT_TRUE(record) << record.error().Text();
    EXPECT_EQ(record->stretches.at(0).rate_hz, 1000) << "the header's";
    EXPECT_EQ(record->stretches[0].start_s, 5) << "at the first row's time";
    EXPECT_EQ(record->stretches[0].rows, 3U);
  }
}

TEST(StretchLines, HaveFiveNumbersThatDescribeRows) {
  const auto stretches = [](const std::string& numbers) {
    CsvComments comments;
    EXPECT_TRUE(ReadCsvComment("# stretch = " + numbers, "f", &comments));
    return comments.stretches;
  };
  const auto whole = stretches("7 3 -0.5 4  0.25");
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_EQ(whole[0].first_row, 7U);
  EXPECT_EQ(whole[0].rows, 3U);
  EXPECT_EQ(whole[0].start_s, -0.5);
  EXPECT_EQ(whole[0].rate_hz, 4);
  EXPECT_EQ(whole[0].time_uncertainty_s, 0.25);
  for (const char* sound : {"0 1 0 1e-9 0", "999999999999999 1 0 1 0", "0 999999999999999 0 1 0"}) {
    EXPECT_EQ(stretches(sound).size(), 1U) << sound;
  }
  for (const char* damaged :
       {"", "0 3 0 4", "0 3 0 4 0 0", "0 3 a 4 0", "-1 3 0 4 0", "1e15 3 0 4 0", "0 0 0 4 0",
        "0 1e15 0 4 0", "0 3 inf 4 0", "0 3 nan 4 0", "0 3 0 0 0", "0 3 0 -4 0", "0 3 0 4 -1"}) {
    EXPECT_TRUE(stretches(damaged).empty()) << damaged;
  }
}

// --- segments ------------------------------------------------------------------------------------

// `sizes.size()` segments with times 0, 1, 2, ... below a line of names
std::string Segments(const std::vector<int>& sizes) {
  std::string text = "Time (s),CH1 (V)\n";
  for (const int size : sizes) {
    for (int i = 0; i < size; ++i) text += fmt::format("{},0.25\n", i);
  }
  return text;
}

TEST(Segments, MoreThanTenOfFewerThanTenRowsAreNone) {
  std::vector<int> sizes(11, 10);
  EXPECT_THAT(ErrorOf(Segments(sizes)),
              HasSubstr("its times begin again at line 12: either 11 segments"));
  sizes.back() = 9;
  EXPECT_EQ(ErrorOf(Segments(sizes)),
            "f.csv: its times go back in 10 places, the first in line 12: the column is no time, "
            "or the rows are out of order; name the columns in the order of the file (<columns>): "
            "are two exchanged?");
  EXPECT_THAT(ErrorOf(Segments(std::vector<int>(10, 2))),
              HasSubstr("its times begin again at line 4: either 10 segments"));
}

TEST(Segments, OneOfThemIsCountedFromOne) {
  const std::string text = Segments({2, 3});
  EXPECT_THAT(ErrorOf(text, {.segment = 0}), HasSubstr("has 2 segments"));
  EXPECT_THAT(ErrorOf(text, {.segment = 3}), HasSubstr("has 2 segments"));
  EXPECT_THAT(ErrorOf(Segments({3}), {.segment = 2}), HasSubstr("has 1 segment;"));
  EXPECT_EQ(ParseCsv(text, "f", {.segment = 1}).value().rows, 2U);
  EXPECT_EQ(ParseCsv(text, "f", {.segment = 2}).value().rows, 3U);
}

std::string TwoOfALecroy(double second_start_s) {
  return fmt::format(
      "LECROYWP715Zi-A,1,Waveform\nSegments,2,SegmentSize,3\nSegment,TrigTime,TimeSinceSegment1\n"
      "#1,22-Jan-2015 11:35:11,0\n#2,22-Jan-2015 11:35:11,{}\nTime,Ampl\n"
      "-1,1\n0,2\n1,3\n-1,4\n0,5\n1,6\n",
      second_start_s);
}

// the first ends at 1 s, and the second begins 1 s before its stated time
TEST(Segments, OneBeginsBehindTheEndOfTheOneBefore) {
  EXPECT_THAT(ErrorOf(TwoOfALecroy(2)),
              HasSubstr("states that segment 2 begins before the one ahead of it ends"));
  const auto record = ParseCsv(TwoOfALecroy(2.0078125), "f");
  ASSERT_TRUE(record) << record.error().Text();
  ASSERT_EQ(record->stretches.size(), 2U);
  EXPECT_EQ(record->stretches[1].start_s, 1.0078125);
}

Record Part(double start_s, double rate_hz, std::size_t rows) {
  Record part;
  part.rows = rows;
  part.stretches = {{.rows = rows, .start_s = start_s, .rate_hz = rate_hz}};
  return part;
}

TEST(Segments, TheLastRowOfTheOneBeforeIsItsEnd) {
  SegmentedTimes times;
  EXPECT_TRUE(times.IsBehind(-100));
  // rows at 1, 1.25, 1.5
  ASSERT_TRUE(times.Append(Part(1, 4, 3), 0));
  EXPECT_FALSE(times.IsBehind(1.5));
  EXPECT_TRUE(times.IsBehind(1.5 + 1e-12));
  EXPECT_FALSE(times.Append(Part(1, 4, 3), 0.5));
  EXPECT_TRUE(times.Append(Part(1, 4, 3), 0.625));
}

TEST(Segments, RowsOfAGridBesideUnevenOnesKeepTheirTimes) {
  SegmentedTimes times;
  ASSERT_TRUE(times.Append(Part(1, 4, 3), 0));
  Record uneven = Part(0, 8, 2);
  uneven.raw_times_s = {0, 0.1875};
  ASSERT_TRUE(times.Append(uneven, 2));
  ASSERT_TRUE(times.Append(Part(-1, 2, 2), 4));
  Record record;
  std::move(times).Complete(&record);
  EXPECT_THAT(record.raw_times_s, ElementsAre(1, 1.25, 1.5, 2, 2.1875, 3, 3.5));
  EXPECT_TRUE(record.times_are_known);
  EXPECT_EQ(record.timing, Timing::kPolled);
  ASSERT_EQ(record.stretches.size(), 3U);
  EXPECT_EQ(record.stretches[1].first_row, 3U);
  EXPECT_EQ(record.stretches[1].start_s, 2);
  EXPECT_EQ(record.stretches[2].first_row, 5U);
  EXPECT_EQ(record.stretches[2].start_s, 3);
}

TEST(Segments, GridsAloneHaveNoTimesOfTheirOwn) {
  SegmentedTimes times;
  ASSERT_TRUE(times.Append(Part(0, 4, 3), 0));
  ASSERT_TRUE(times.Append(Part(0, 4, 3), 2));
  Record record;
  std::move(times).Complete(&record);
  EXPECT_TRUE(record.raw_times_s.empty());
  EXPECT_FALSE(record.times_are_known);
  EXPECT_EQ(record.stretches.at(1).first_row, 3U);
}

TEST(RowTimes, TimesTooCloseForARateHaveNone) {
  // the inverse of 1e-320 s is beyond a double
  EXPECT_EQ(ErrorOf("time_s,voltage_v\n0,1\n1e-320,2\n2e-320,3\n"),
            "f.csv: has times that lie too close for a rate to be stated; check the unit of its "
            "time column");
  // rows at one time lie on no line, however many they are
  std::string text = "time_s,voltage_v\n";
  for (int i = 0; i < 20; ++i) text += fmt::format("1.5,{}\n", i);
  EXPECT_THAT(ErrorOf(text), HasSubstr("19 of 20 rows have the time of the row before"));
}

// rows in which each reading stands twice are no clock's, though its digits would explain them
TEST(RowTimes, RowsWrittenTwiceAreNoRowsOfAStatedClock) {
  const auto error_of = [](bool is_twice) {
    std::string text = "Sample Interval,0.5\nTime (s),CH1 (V)\n";
    for (int i = 0; i < 40; ++i) text += fmt::format("{},{}\n", i / 2, is_twice ? i / 2 : i);
    return ErrorOf(text);
  };
  EXPECT_EQ(error_of(false), "was read");
  EXPECT_THAT(error_of(true), HasSubstr("20 of 40 rows repeat the time and the values of the row "
                                        "before (first row 2), as if they were written twice"));
}

TEST(Segments, ATableWithoutTimesIsOne) {
  const std::string text = "CH1 (V),CH2 (V)\n1,2\n3,4\n5,6\n";
  EXPECT_EQ(ParseCsv(text, "f", {.rate_hz = 8.0, .segment = 1}).value().rows, 3U);
  EXPECT_THAT(ErrorOf(text, {.rate_hz = 8.0, .segment = 2}), HasSubstr("has 1 segment;"));
}

TEST(Segments, TimesOfSeveralUnevenOnesFollowEachOther) {
  SegmentedTimes times;
  for (const double shift_s : {0.0, 2.0}) {
    Record uneven = Part(0, 8, 3);
    uneven.raw_times_s = {0, 0.1875, 0.25};
    ASSERT_TRUE(times.Append(uneven, shift_s));
  }
  Record record;
  std::move(times).Complete(&record);
  EXPECT_THAT(record.raw_times_s, ElementsAre(0, 0.1875, 0.25, 2, 2.1875, 2.25));
}

TEST(RowTimes, RowsAreTakenFromEveryChannel) {
  using enum SampleStatus;
  Record record;
  record.rows = 6;
  record.channels = {{.values = {0, 1, 2, 3, 4, 5}, .statuses = {kOk, kOver, kOk, kLate, kOk, kOk}},
                     {.values = {9, 8, 7, 6, 5, 4},
                      .statuses = {kRepeated, kOk, kLate, kRepeated, kRepeated, kLate}}};
  LeaveOutRows({0, 2, 5}, &record);
  EXPECT_EQ(record.rows, 3U);
  EXPECT_THAT(record.channels[0].values, ElementsAre(1, 3, 4));
  EXPECT_THAT(record.channels[0].statuses, ElementsAre(kOver, kLate, kOk));
  EXPECT_THAT(record.channels[1].values, ElementsAre(8, 6, 5));
  EXPECT_THAT(record.channels[1].statuses, ElementsAre(kOk, kRepeated, kRepeated));
}

}  // namespace
}  // namespace haptometer::trial
