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

TEST(RigolSequence, RowNumbersAreNamedByTheirTitleOrTheirUnit) {
  for (const char* head : {"X,CH1,Start,Increment\nNo,Volt,1,0.25\n",
                           "No,CH1,Start,Increment\nSequence,Volt,1,0.25\n"}) {
    const Record record = Parsed(std::string(head) + "0,5\n1,6\n2,7\n");
    ASSERT_EQ(record.channels.size(), 1U) << head;
    EXPECT_THAT(record.channels[0].values, ElementsAre(5, 6, 7));
    EXPECT_EQ(record.stretches.at(0).start_s, 1);
    EXPECT_EQ(record.stretches[0].rate_hz, 4);
  }
  const Record values = Parsed("A,CH1,Start,Increment\nVolt,Volt,1,0.25\n0,5\n1,6\n2,7\n");
  EXPECT_EQ(values.channels.size(), 2U) << "a first column that is a channel";
  const Record upper = Parsed("CH1V,CH2V,t0 = -2S, tInc = 0.5 S\n1.5,2,\n2.5,3,\n");
  EXPECT_EQ(upper.stretches.at(0).start_s, -2);
  EXPECT_EQ(upper.stretches[0].rate_hz, 2);
  const auto alone = ParseCsv("1,2\n3,4\n", "f", {.format = TableFormat::kRigolSequence});
  ASSERT_FALSE(alone);
  EXPECT_THAT(alone.error().Text(), HasSubstr("has no Start and Increment beside its names"));
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
  for (const auto& [start, interval] : {std::pair{"0.5000000001", "0.25"},
                                        {"0.5", "0.2500000001"},
                                        {"", "0.25"},
                                        {"0.5", "0"},
                                        {"inf", "0.25"}}) {
    EXPECT_THAT(ErrorOf(Pxi(start, interval)),
                HasSubstr("has channels of different clocks, or one without"))
        << start << " " << interval;
  }
}

// the samples that are stated, against the three that are there
TEST(NiPxi, ItsSampleCountIsAWholeNumberOfRows) {
  const auto found = [](const char* count) {
    Findings findings;
    (void)Parsed(fmt::format("Meta data\nPhysical channel,Sample Interval,Start Time,Sample "
                             "Count\nA,0.25,0.5,{}\n\nData\nA\n1\n3\n5\n",
                             count),
                 &findings);
    return NumbersOf(findings, FindingKind::kStatedRowsDiffer);
  };
  EXPECT_EQ(found("3"), "none");
  EXPECT_EQ(found("4"), "stated_rows=4 rows=3");
  EXPECT_EQ(found("1"), "stated_rows=1 rows=3");
  EXPECT_EQ(found("999999999999999"), "stated_rows=999999999999999 rows=3");
  for (const char* none : {"0", "0.5", "-3", "1e15", "inf", "many", ""}) {
    EXPECT_EQ(found(none), "none") << none;
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
  EXPECT_EQ(found("late", "12:00:48.5"), "apart_s=1");
  EXPECT_EQ(found("12:00:46.5", "12:00:46"), "none") << "behind the first";
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

TEST(TektronixTds, ItsChannelNeedsNoSourceAndItsTimesNoUnit) {
  const Record record = Parsed("Record Length,3,,0,1\nHorizontal Units,V,,4,2\nNote,x,,8,3\n");
  EXPECT_EQ(record.channels.at(0).name, "channel_1");
  EXPECT_EQ(record.channels[0].unit, "");
  EXPECT_REL(record.stretches.at(0).rate_hz, 0.25, 1e-12, "printed times");
}

TEST(Saleae, LevelsAreZeroOneAndX) {
  const auto found = [](const char* rows, FindingKind kind) {
    Findings findings;
    (void)Parsed(std::string("Time [s],A0\n") + rows, &findings);
    return findings.Has(kind);
  };
  for (const char* rows : {"0,0\n1,1\n", "0,X\n1,x\n", "0,1\n1,\n"}) {
    EXPECT_TRUE(found(rows, FindingKind::kTransitionsOnly)) << rows;
    EXPECT_FALSE(found(rows, FindingKind::kValueUnitAssumed)) << rows;
  }
  for (const char* rows : {"0,0\n1,2\n", "0,0.5\n1,1\n", "0,00\n1,1\n"}) {
    EXPECT_FALSE(found(rows, FindingKind::kTransitionsOnly)) << rows;
    EXPECT_TRUE(found(rows, FindingKind::kValueUnitAssumed)) << rows;
  }
  // levels of a channel with a unit are voltages
  Findings findings;
  const ImportOptions saleae{.format = TableFormat::kSaleae};
  ASSERT_TRUE(ParseCsv("Time [s],A [mV]\n0,0\n1,1\n", "f", saleae, &findings));
  EXPECT_FALSE(findings.Has(FindingKind::kTransitionsOnly));
  const Record record = Parsed("Time [s],trigger,A0\n0,0.5,0.5\n1,2,2\n");
  EXPECT_EQ(record.channels.at(0).unit, "") << "a trigger has no unit";
  EXPECT_EQ(record.channels.at(1).unit, "V");
}

TEST(Lecroy, ALineOfASegmentHasANumberAndAStart) {
  const auto text = [](const char* comments) {
    return fmt::format(
        "LECROYWP715Zi-A,1\nSegments,2,SegmentSize,2\n{}Time,Ampl\n0,1\n1,2\n0,3\n1,4\n", comments);
  };
  const std::string both = "#1,22-Jan-2015 11:35:11,0\n#2,22-Jan-2015 11:35:11,8\n";
  for (const char* other : {"", "# words\n", "#3,9\n", "#x,22-Jan-2015,9\n",
                            "#3,22-Jan-2015,late\n", "#3,22-Jan-2015,inf\n"}) {
    const Record record = Parsed(text((both + other).c_str()));
    ASSERT_EQ(record.stretches.size(), 2U) << other;
    EXPECT_EQ(record.stretches[1].start_s, 8) << other;
  }
  EXPECT_THAT(ErrorOf(text((both + "#3,22-Jan-2015,9\n").c_str())),
              HasSubstr("its times begin again at line 9"));
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

TEST(Hantek, WhatStandsInOneLineIsATable) {
  const std::string head = "#CHANNEL:CH1\n#CLOCK=20.0uS\nonly words\n";
  const Record record = Parsed(head + "CH1 (V),CH2 (V)\n1,2\n3,4\n");
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_REL(record.stretches.at(0).rate_hz, 50'000, 1e-12, "one quotient");
  // numbers above the first channel belong to none
  EXPECT_EQ(JoinHantekBlocks("1\n2\n#CHANNEL:CH1\n3\n", "f").value(), std::nullopt);
  EXPECT_EQ(JoinHantekBlocks("", "f").value(), std::nullopt);
}

TEST(Hantek, AChannelWithoutATitleHasItsNumber) {
  EXPECT_EQ(JoinHantekBlocks("#CHANNEL:A\n#UNITS:V\n#words\n1\n\n2\n#\n3\n4\n", "f").value(),
            "#CHANNEL:A\n#UNITS:V\n#words\nA [V]\tCH2\n1\t3\n2\t4\n");
}

}  // namespace
}  // namespace haptometer::trial
