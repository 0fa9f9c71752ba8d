// Words that one maker's files have: clocks, starts, names of channels, blocks.
#include "trial/import/table/instrument_layouts.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using tests::NumbersOf;

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Record Parsed(const std::string& text, Findings* findings = nullptr) {
  auto record = ParseCsv(text, "f.csv", {}, findings);
  EXPECT_TRUE(record) << record.error().Text();
  return record ? std::move(*record) : Record{};
}

std::string ErrorOf(const std::string& text) {
  const auto record = ParseCsv(text, "f.csv");
  return record ? "was read" : record.error().Text();
}

// --- Rigol ---------------------------------------------------------------------------------------

std::string Sequence(const char* start, const char* increment, int first) {
  std::string text = fmt::format("X,CH1,Start,Increment\nSequence,Volt,{},{}\n", start, increment);
  for (int i = first; i < first + 4; ++i) text += fmt::format("{},0.5\n", i);
  return text;
}

TEST(RigolSequence, ARowsNumberCountsIncrementsFromTheStart) {
  Findings findings;
  const Record record = Parsed(Sequence("-1.5", "0.25", 8), &findings);
  EXPECT_EQ(record.stretches.at(0).rate_hz, 4);
  EXPECT_EQ(record.stretches[0].start_s, 0.5);
  EXPECT_EQ(NumbersOf(findings, FindingKind::kRowsBeginAt), "first=8 earlier_s=2");
  findings = {};
  EXPECT_EQ(Parsed(Sequence("-1.5", "0.25", 0), &findings).stretches.at(0).start_s, -1.5);
  EXPECT_FALSE(findings.Has(FindingKind::kRowsBeginAt));
}

// the steps of the times are rounded to the last bit of 300 001 s
TEST(RigolSequence, TheStatedIncrementIsTheClock) {
  for (const int first : {0, 7, 1'000'003}) {
    const Record record = Parsed(Sequence("0.1", "0.3", first));
    EXPECT_EQ(record.stretches.at(0).rate_hz, 1 / 0.3);
    EXPECT_REL(record.stretches[0].start_s, 0.1 + first * 0.3, 1e-15, "a product and a sum");
    EXPECT_TRUE(record.raw_times_s.empty());
  }
}

TEST(RigolSequence, NeedsAStartAndAnIncrementAboveZero) {
  EXPECT_EQ(Parsed(Sequence("0", "1e-300", 0)).rows, 4U);
  for (const auto& [start, increment] : {std::pair{"", "0.25"},
                                         {"0", ""},
                                         {"0", "0"},
                                         {"0", "-0.25"},
                                         {"inf", "0.25"},
                                         {"0", "inf"},
                                         {"0", "1e-310"}}) {
    EXPECT_THAT(ErrorOf(Sequence(start, increment, 0)),
                HasSubstr("has no Start and Increment beside its names, or invalid ones"))
        << start << " " << increment;
  }
}

TEST(RigolSequence, OneLineHasUnitsAtTheEndsOfTheNames) {
  const Record record = Parsed("CH1V,T,t0 = -2s, tInc = 0.5s\n1.5,2,\n2.5,3,\n");
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[0].name, "CH1");
  EXPECT_EQ(record.channels[0].unit, "V");
  EXPECT_EQ(record.channels[1].name, "T");
  EXPECT_EQ(record.channels[1].unit, "");
  EXPECT_EQ(record.stretches.at(0).rate_hz, 2);
  EXPECT_EQ(record.stretches[0].start_s, -2);
}

// --- National Instruments ------------------------------------------------------------------------

std::string Pxi(const char* second_start, const char* second_interval) {
  return fmt::format(
      "Meta data\nPhysical channel,Sample Interval,Start Time,Sample Count\nA,0.25,0.5,3\n"
      "B,{},{},3\n\nData\nA,B\n1,2\n3,4\n5,6\n",
      second_interval, second_start);
}

TEST(NiPxi, ItsChannelsShareAClock) {
  const Record record = Parsed(Pxi("0.5", "0.25"));
  EXPECT_EQ(record.stretches.at(0).rate_hz, 4);
  EXPECT_EQ(record.stretches[0].start_s, 0.5);
  for (const auto& [start, interval] :
       {std::pair{"0.5000000001", "0.25"}, {"0.5", "0.2500000001"}, {"", "0.25"}, {"0.5", "0"}}) {
    EXPECT_THAT(ErrorOf(Pxi(start, interval)),
                HasSubstr("has channels of different clocks, or one without"))
        << start << " " << interval;
  }
}

TEST(NiElvis, TheLatestStartIsSaid) {
  const auto found = [](const char* second, const char* third) {
    Findings findings;
    (void)Parsed(fmt::format("waveform,A,B,C\nt0,5/7/2021 12:00:47.5,5/7/2021 {},5/7/2021 {}\n"
                             "delta t,0.25,0.25,0.25\n\ntime,A,B,C\n5/7/2021 12:00:47.5,1,2,3\n"
                             "5/7/2021 12:00:47.75,1,2,3\n5/7/2021 12:00:48,1,2,3\n",
                             second, third),
                 &findings);
    return NumbersOf(findings, FindingKind::kChannelsApart);
  };
  EXPECT_EQ(found("12:00:47.5", "12:00:47.5"), "none");
  EXPECT_EQ(found("12:00:47.75", "12:00:47.625"), "apart_s=0.25");
  EXPECT_EQ(found("12:00:47.625", "12:01:47.5"), "apart_s=60");
}

// --- Tektronix and Hantek ------------------------------------------------------------------------

TEST(TektronixTds, TimesHaveTheUnitOfTheHorizontalAxis) {
  const auto text = [](const char* unit) {
    return fmt::format(
        "Record Length,3,,0,1\nSource,CH2,,4,2\nVertical Units,mV,,8,3\nHorizontal "
        "Units,{},,12,4\n",
        unit);
  };
  const Record record = Parsed(text("ms"));
  EXPECT_EQ(record.channels.at(0).name, "CH2");
  EXPECT_THAT(record.channels[0].values, ElementsAre(1e-3, 2e-3, 3e-3, 4e-3));
  EXPECT_REL(record.stretches.at(0).rate_hz, 250, 1e-12, "printed times");
  EXPECT_REL(Parsed(text("s")).stretches.at(0).rate_hz, 0.25, 1e-12, "printed times");
}

std::string Hantek(const char* second_clock, const char* second_values) {
  return fmt::format(
      "#CHANNEL:CH1\n#CLOCK=20.0uS\n#UNITS:V\n\n1\n2\n3\n#CHANNEL:CH2\n#CLOCK={}\n#UNITS:mV\n\n{}",
      second_clock, second_values);
}

TEST(Hantek, BlocksOfOneLengthAndClockAreColumns) {
  const Record record = Parsed(Hantek("20.0uS", "4\n5\n6\n"));
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_THAT(record.channels[0].values, ElementsAre(1, 2, 3));
  EXPECT_THAT(record.channels[1].values, ElementsAre(4e-3, 5e-3, 6e-3));
  EXPECT_EQ(record.channels[1].name, "CH2");
  EXPECT_REL(record.stretches.at(0).rate_hz, 50'000, 1e-12, "one quotient");
  EXPECT_THAT(ErrorOf(Hantek("20.0uS", "4\n5\n")),
              HasSubstr("has blocks of 3 and 2 values, or of other clocks"));
  EXPECT_THAT(ErrorOf(Hantek("10.0uS", "4\n5\n6\n")),
              HasSubstr("has blocks of 3 and 3 values, or of other clocks"));
}

}  // namespace
}  // namespace haptometer::trial
