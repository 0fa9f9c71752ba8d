// LabVIEW measurement files.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// a file with the given header lines, segment lines and rows
std::string Lvm(std::string_view header, std::string_view body) {
  return "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\n" + std::string(header) +
         "Date\t2024/05/06\nTime\t12:00:00.5\n***End_of_Header***\t\n\t\n" + std::string(body);
}

std::string Replaced(std::string text, char from, char to) {
  std::ranges::replace(text, from, to);
  return text;
}

// `text` with every `from` replaced
std::string Changed(std::string text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

Record ParsedLvm(const std::string& text, const ImportOptions& options = {}) {
  EXPECT_TRUE(IsLvm(text));
  auto record = ParseLvm(text, "f.lvm", options);
  EXPECT_TRUE(record) << record.error().Text();
  return record ? std::move(*record) : Record{};
}

std::string LvmErrorOf(const std::string& text, const ImportOptions& options = {},
                       Cause cause = Cause::kCannotAnswer) {
  const auto record = ParseLvm(text, "f.lvm", options);
  if (record) return "was read";
  EXPECT_EQ(record.error().cause, cause);
  EXPECT_FALSE(record.error().remedy.empty());
  return record.error().Text();
}

const std::string kSegment =
    "Channels\t2\t\nSamples\t3\t3\nY_Unit_Label\tVolts\tmm\nX_Dimension\tTime\tTime\nX0\t0\t0\n"
    "Delta_X\t0.001\t0.001\n***End_of_Header***\t\t\nX_Value\tLaser\tRef\tComment\n";

TEST(Lvm, OneXColumnUnitsNamesAndComments) {
  const Record record =
      ParsedLvm(Lvm("Decimal_Separator\t.\r\nX_Columns\tOne\r\n",
                    kSegment + "0.000\t1.5\t2\tbegun\r\n0.001\t2.5\t\r\n0.002\t-1\t4\t\r\n"));
  ASSERT_EQ(record.rows, 3);
  EXPECT_EQ(record.channels[0].name, "Laser");
  EXPECT_EQ(record.channels[0].role, ChannelRole::kVoltage);
  EXPECT_EQ(record.channels[0].values[1], 2.5);
  EXPECT_EQ(record.channels[1].role, ChannelRole::kDisplacement);
  EXPECT_REL(record.channels[1].values[2], 4e-3, 1e-15, "one product");
  EXPECT_EQ(record.channels[1].statuses[1], SampleStatus::kInvalid);
  EXPECT_REL(record.stretches.at(0).rate_hz, 1000, 1e-12, "printed times");
  EXPECT_THAT(record.metadata.notes, ElementsAre("row 0: begun"));
  EXPECT_EQ(record.metadata.fields.at("lvm.Date"), "2024/05/06");
}

TEST(Lvm, AChannelWithoutANameKeepsItsPlace) {
  const Record record = ParsedLvm(
      Lvm("Decimal_Separator\t.\nX_Columns\tOne\n",
          Changed(kSegment, "Laser", "") + "0.000\t1.5\t2\n0.001\t2.5\t3\n0.002\t-1\t4\n"));
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[0].name, "channel_1");
  EXPECT_EQ(record.channels[0].values[1], 2.5);
  EXPECT_EQ(record.channels[1].name, "Ref");
  EXPECT_REL(record.channels[1].values[2], 4e-3, 1e-15, "one product");
}

TEST(Lvm, DecimalCommasAndCommasBetweenCells) {
  const Record comma = ParsedLvm(Replaced(
      Lvm("Decimal_Separator\t.\nX_Columns\tOne\n", kSegment + "0.000\t1.5\t2\n0.001\t2.5\t3\n"),
      '.', ','));
  EXPECT_EQ(comma.channels.at(0).values.at(1), 2.5);
  const Record cells = ParsedLvm(Replaced(
      Lvm("Decimal_Separator\t.\nX_Columns\tOne\n", kSegment + "0.000\t1.5\t2\n0.001\t2.5\t3\n"),
      '\t', ','));
  EXPECT_EQ(cells.channels.at(0).values.at(1), 2.5);
}

TEST(Lvm, WithoutXTheHeaderGivesTheTimes) {
  for (const char* rows : {"\t1\t2\n\t3\t4\n", "1\t2\n3\t4\n"}) {
    const Record record = ParsedLvm(Lvm("X_Columns\tNo\n", kSegment + rows));
    ASSERT_EQ(record.rows, 2) << rows;
    EXPECT_EQ(record.channels[0].values[1], 3);
    EXPECT_EQ(record.stretches.at(0).rate_hz, 1000);
  }
}

TEST(Lvm, SeveralXColumnsMustAgree) {
  const std::string head =
      "Channels\t2\t\n***End_of_Header***\t\nX_Value\tA\tX_Value\tB\tComment\n";
  const Record record = ParsedLvm(Lvm("X_Columns\tMulti\n", head + "0\t1\t0\t2\n0.5\t3\t0.5\t4\n"));
  EXPECT_EQ(record.channels.at(1).values, (std::vector<double>{2, 4}));
  EXPECT_THAT(LvmErrorOf(Lvm("X_Columns\tMulti\n", head + "0\t1\t0.1\t2\n")),
              HasSubstr("X values of their own (0 and 0.1)"));
}

TEST(Lvm, SegmentsBecomeStretches) {
  const std::string rows = "0.000\t1\t2\n0.001\t2\t3\n0.002\t3\t4\n";
  auto dated = [](std::string segment, const std::string& time) {
    return segment.replace(segment.find("X_Dim"), 0,
                           "Date\t2024/05/06\t2024/05/06\nTime\t" + time + "\n");
  };
  // X goes on
  const Record going = ParsedLvm(
      Lvm("X_Columns\tOne\n", kSegment + rows + "\n" + kSegment + "0.010\t5\t6\n0.011\t7\t8\n"));
  ASSERT_EQ(going.stretches.size(), 2);
  EXPECT_EQ(going.stretches[1].first_row, 3);
  EXPECT_EQ(going.stretches[1].start_s, 0.010);
  // X begins again, and the clock on the wall tells when
  const Record again =
      ParsedLvm(Lvm("X_Columns\tOne\n", dated(kSegment, "12:00:00.5") + rows + "\n" +
                                            dated(kSegment, "12:00:02.75") + rows));
  ASSERT_EQ(again.stretches.size(), 2);
  EXPECT_EQ(again.stretches[1].start_s, 2.25);
  EXPECT_EQ(again.channels[0].values[3], 1);
  // or nothing does
  EXPECT_THAT(LvmErrorOf(Lvm("X_Columns\tOne\n", kSegment + rows + "\n" + kSegment + rows)),
              HasSubstr("whose Date and Time do not state when"));
  EXPECT_THAT(
      LvmErrorOf(Lvm("", kSegment + rows + "Channels\t1\n***End_of_Header***\nX_Value\tA\n0\t1\n")),
      HasSubstr("begins a segment of 1 channels where the first has 2"));
}

TEST(Lvm, WhatCannotBeReadIsExplained) {
  EXPECT_THAT(LvmErrorOf("LabVIEW Measurement\nX_Columns\tOne\n"),
              HasSubstr("header does not end"));
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment + "0\tabc\t1\n")), HasSubstr("'abc' is not a number"));
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment + "0\t1\n")),
              HasSubstr("has 2 cells where 3 are needed"));
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment + "1\t1\t1\n0\t1\t1\n")), HasSubstr("does not grow"));
  EXPECT_THAT(LvmErrorOf(Lvm("", "0\t1\n")), HasSubstr("a line of names"));
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment)), HasSubstr("holds 0 rows"));
  EXPECT_THAT(LvmErrorOf(Lvm("Decimal_Separator\t.\n", kSegment + "0,5\t1\t1\n")),
              HasSubstr("'0,5' is not an X value"));
  EXPECT_THAT(LvmErrorOf(Lvm("X_Columns\tNo\n", "X_Value\tA\n\t1\n\t2\n")),
              HasSubstr("neither X values nor a Delta_X"));
}

// the second segment's X begins again at 0.25 s, 2.25 s on the wall behind the first one's at 0.5 s
TEST(Lvm, ASegmentLiesBehindTheFirstAsItsTimeSays) {
  const auto dated = [](const char* x0, const char* date, const char* time) {
    return Changed(kSegment, "X0\t0\t0",
                   fmt::format("Date\t{}\t{}\nTime\t{}\nX0\t{}\t{}", date, date, time, x0, x0));
  };
  const std::string first =
      dated("0.5", "2024/05/06", "12:00:00.5") + "0.500\t1\t2\n0.501\t2\t3\n0.502\t3\t4\n\n";
  const std::string rows = "0.250\t5\t6\n0.251\t7\t8\n";
  const Record record =
      ParsedLvm(Lvm("", first + dated("0.25", "2024/05/06", "12:00:02.75") + rows));
  ASSERT_EQ(record.stretches.size(), 2U);
  EXPECT_EQ(record.stretches[0].start_s, 0.5);
  EXPECT_EQ(record.stretches[1].start_s, 2.75);
  EXPECT_EQ(record.stretches[1].first_row, 3U);
  // of another day the time alone says nothing
  EXPECT_THAT(LvmErrorOf(Lvm("", first + dated("0.25", "2024/05/07", "12:00:02.75") + rows)),
              HasSubstr("whose Date and Time do not state when"));
}

TEST(Lvm, OneRowIsNoMeasurement) {
  EXPECT_THAT(LvmErrorOf(Lvm("X_Columns\tNo\n", kSegment + "\t1\t2\n")),
              HasSubstr("holds 1 row; a measurement needs at least two"));
}

TEST(Lvm, CommentsAreCountedByTheirRows) {
  const Record record =
      ParsedLvm(Lvm("", kSegment + "0\t1\t2\n0.001\t1\t2\tknocked\n0.002\t1\t2\n\n" + kSegment +
                            "0.1\t1\t2\tagain\n0.101\t1\t2\n"));
  EXPECT_THAT(record.metadata.notes, ElementsAre("row 1: knocked", "row 3: again"));
}

TEST(Lvm, XInTheUnitThatItsNameSays) {
  const std::string text =
      Lvm("", "Channels\t1\n***End_of_Header***\nX_Value\tA\n0\t5\n4\t6\n8\t7\n");
  EXPECT_REL(ParsedLvm(text).stretches.at(0).rate_hz, 0.25, 1e-12, "printed X");
  EXPECT_REL(ParsedLvm(text, {.columns = {"time_ms", "voltage_v"}}).stretches.at(0).rate_hz, 250,
             1e-12, "printed X");
}

// two channels at 1 kHz, the second with an X0 and a Delta_X of its own
std::string WithClock(const char* x0, const char* delta) {
  return Lvm("", Changed(Changed(kSegment, "X0\t0\t0", fmt::format("X0\t0\t{}", x0)),
                         "0.001\t0.001", fmt::format("0.001\t{}", delta)) +
                     "0.000\t1\t2\n0.001\t2\t3\n0.002\t3\t4\n");
}

TEST(Lvm, ChannelsShareAClockToHalfAnIntervalAndAMillionth) {
  for (const char* x0 : {"0.000499", "-0.000499"}) {
    EXPECT_EQ(ParsedLvm(WithClock(x0, "0.001")).channels.size(), 2U) << x0;
  }
  for (const char* x0 : {"0.000501", "-0.000501"}) {
    EXPECT_THAT(LvmErrorOf(WithClock(x0, "0.001")), HasSubstr("have clocks of their own")) << x0;
  }
  for (const char* delta : {"0.00100000099", "0.00099999901"}) {
    EXPECT_EQ(ParsedLvm(WithClock("0", delta)).channels.size(), 2U) << delta;
  }
  for (const char* delta : {"0.00100000101", "0.00099999899"}) {
    EXPECT_THAT(LvmErrorOf(WithClock("0", delta)), HasSubstr("have clocks of their own")) << delta;
  }
}

TEST(Lvm, TwoSamplesHaveAClockAndOneHasNone) {
  const auto text = [](const char* samples, const char* delta) {
    return Lvm("X_Columns\tNo\n",
               fmt::format("Samples\t{}\nDelta_X\t{}\n***End_of_Header***\nX_Value\tA\n\t1\n\t2\n",
                           samples, delta));
  };
  EXPECT_EQ(ParsedLvm(text("2", "0.25")).stretches.at(0).rate_hz, 4);
  EXPECT_EQ(ParsedLvm(text("", "0.25")).stretches.at(0).rate_hz, 4);
  for (const auto& bad :
       {text("1", "0.25"), text("2", "0"), text("2", "-0.25"), text("2", "inf")}) {
    EXPECT_THAT(LvmErrorOf(bad), HasSubstr("neither X values nor a Delta_X above 0"));
  }
}

TEST(Lvm, ARateAgainstTheTimesIsRefused) {
  const std::string text =
      Lvm("", "Channels\t1\nDelta_X\t0.001\n***End_of_Header***\nX_Value\tA\n0\t1\n0.001\t2\n");
  EXPECT_EQ(ParsedLvm(text, {.rate_hz = 1009}).stretches.at(0).rate_hz, 1000) << "within 1 %";
  EXPECT_THAT(LvmErrorOf(text, {.rate_hz = 1011}), HasSubstr("give 1000 rows per second"));
  EXPECT_THAT(LvmErrorOf(text, {.rate_hz = 500}), HasSubstr("<rate> gives 500 Hz"));
}

TEST(Lvm, AThousandAndTwentyFourChannelsAreTaken) {
  const auto text = [](int channels) {
    std::string names = "X_Value";
    std::string row;
    for (int c = 0; c < channels; ++c) {
      names += "\tA";
      row += fmt::format("\t{}", c);
    }
    return Lvm("", "Channels\t1\n***End_of_Header***\n" + names + "\n0" + row + "\n1" + row + "\n");
  };
  const Record record = ParsedLvm(text(1024));
  ASSERT_EQ(record.channels.size(), 1024U);
  EXPECT_EQ(record.channels.back().values[1], 1023);
  EXPECT_THAT(LvmErrorOf(text(1025)), HasSubstr("names no channel, or too many"));
}

// --- the header's clock, and what is said of the columns -----------------------------------------

// two channels with a header each and a row a sample; `x` prints X
std::string TwoChannels(const std::string& header, std::size_t rows,
                        const std::function<std::string(std::size_t)>& x) {
  std::string text = Lvm("Decimal_Separator\t.\nX_Columns\tOne\n",
                         header + "***End_of_Header***\t\t\nX_Value\tA\tB\tComment\n");
  for (std::size_t i = 0; i < rows; ++i) {
    text += fmt::format("{}\t{}\t{}\t\n", x(i), 0.5 + 0.25 * static_cast<double>(i % 8), i);
  }
  return text;
}

constexpr const char* kVolts =
    "Channels\t2\t\nSamples\t4000\t4000\nY_Unit_Label\tVolts\tVolts\nX_Dimension\tTime\tTime\n"
    "X0\t0.0E+0\t0.0E+0\nDelta_X\t2.44140625E-5\t2.44140625E-5\n";

std::string Microseconds(std::size_t i) {
  return fmt::format("{:.6f}", static_cast<double>(i) / 40'960);
}

TEST(Lvm, DeltaXIsTheClockWherePrintedXAgrees) {
  // 40.96 kS/s: cut off instead of rounded, too
  const auto cut = [](std::size_t i) {
    return fmt::format("{:.6f}", std::floor(1e6 * static_cast<double>(i) / 40'960) / 1e6);
  };
  for (const auto& x : {std::function<std::string(std::size_t)>(Microseconds),
                        std::function<std::string(std::size_t)>(cut)}) {
    const Record record = ParsedLvm(TwoChannels(kVolts, 4000, x));
    ASSERT_EQ(record.stretches.size(), 1);
    EXPECT_TRUE(record.raw_times_s.empty());
    EXPECT_EQ(record.stretches[0].rate_hz, 40'960) << "Delta_X is exact in binary";
  }
}

TEST(Lvm, XThatRepeatsForLackOfDigitsIsDeltaXs) {
  const std::string header = Changed(kVolts, "2.44140625E-5", "5.0E-7");
  const Record record = ParsedLvm(TwoChannels(
      header, 4000, [](auto i) { return fmt::format("{:.6f}", 5e-7 * static_cast<double>(i)); }));
  EXPECT_TRUE(record.raw_times_s.empty());
  EXPECT_REL(record.stretches.at(0).rate_hz, 2e6, 1e-12, "Delta_X");
}

TEST(Lvm, XAgainstDeltaXIsRefusedUntilTheRateIsSaid) {
  const std::string text = TwoChannels(
      kVolts, 100, [](auto i) { return fmt::format("{}", 1e-3 * static_cast<double>(i)); });
  EXPECT_THAT(LvmErrorOf(text),
              HasSubstr("its times give 1000 rows per second and 'Delta_X' gives 40960"));
  EXPECT_REL(ParsedLvm(text, {.rate_hz = 1000.0}).stretches.at(0).rate_hz, 1000, 1e-9, "X");
  EXPECT_REL(ParsedLvm(text, {.rate_hz = 40'960.0}).stretches.at(0).rate_hz, 40'960, 1e-9,
             "header");
}

TEST(Lvm, ASingleSampleHasNoDeltaX) {
  // one point a loop, with a time of its own and LabVIEW's default interval
  const std::string header = "Channels\t2\t\nSamples\t1\t1\nDelta_X\t1.0\t1.0\n";
  const Record record = ParsedLvm(TwoChannels(
      header, 50, [](auto i) { return fmt::format("{:.3f}", 0.02 * static_cast<double>(i)); }));
  EXPECT_REL(record.stretches.at(0).rate_hz, 50, 1e-9, "X");
}

TEST(Lvm, HeaderLinesMayComeInAnyOrder) {
  const std::string header =
      "Notes\tcoil, held in a vice\nTest_Name\tring-down\n" + std::string(kVolts);
  const Record record = ParsedLvm(TwoChannels(header, 4000, Microseconds));
  EXPECT_EQ(record.rows, 4000);
  // also before a further segment
  const std::string twice = TwoChannels(header, 40, Microseconds) + "\n" +
                            Changed(header, "X0\t0.0E+0\t0.0E+0", "X0\t1.0\t1.0") +
                            "***End_of_Header***\nX_Value\tA\tB\n1.000000\t1\t2\n1.000024\t1\t2\n";
  EXPECT_EQ(ParsedLvm(twice).stretches.size(), 2);
  const std::string special = "***Start_Special***\nanything, 1\n2\n***End_Special***\n";
  EXPECT_EQ(ParsedLvm(Lvm("", special + kSegment + "0\t1\t1\n0.001\t1\t1\n")).rows, 2);
}

TEST(Lvm, CommasBetweenCellsWithANoteInFront) {
  std::string text = Lvm("Decimal_Separator\t.\nX_Columns\tOne\n",
                         "Notes\tfirst blow\n" + kSegment + "0.000\t1.5\t2\n0.001\t2.5\t3\n");
  EXPECT_EQ(ParsedLvm(Replaced(text, '\t', ',')).channels.at(0).values.at(1), 2.5);
}

TEST(Lvm, OneOfItsChannelsCanBeRead) {
  const std::string text = TwoChannels(kVolts, 4000, Microseconds);
  const Record record = ParsedLvm(text, {.channel = "b"});
  ASSERT_EQ(record.channels.size(), 1);
  EXPECT_EQ(record.channels[0].name, "B");
  EXPECT_EQ(record.channels[0].values.at(7), 7);
  EXPECT_THAT(LvmErrorOf(text, {.channel = "C"}),
              HasSubstr("has no channel called 'C' (its channels: A, B)"));
}

TEST(Lvm, ColumnsAndScalesNameWhatHasNoUnit) {
  const std::string text =
      TwoChannels("Channels\t2\nSamples\t4000\t4000\nDelta_X\t2.44140625E-5\t2.44140625E-5\n", 4000,
                  Microseconds);
  EXPECT_EQ(ParsedLvm(text).channels.at(0).role, ChannelRole::kOther);
  for (const std::vector<std::string>& columns :
       {std::vector<std::string>{"time_s", "voltage_mv", "-"}, {"voltage_mv", "-"}}) {
    const Record record = ParsedLvm(text, {.columns = columns});
    ASSERT_EQ(record.channels.size(), 1);
    EXPECT_EQ(record.channels[0].role, ChannelRole::kVoltage);
    EXPECT_REL(record.channels[0].values.at(1), 0.75e-3, 1e-15, "one product");
  }
  const Record scaled =
      ParsedLvm(text, {.columns = {"-", "-", "displacement"}, .rate_hz = 5000.0, .scale_m = 2e-3});
  EXPECT_EQ(scaled.channels.at(0).values.at(3), 6e-3);
  EXPECT_EQ(scaled.stretches.at(0).rate_hz, 5000) << "X is left out";
  const Record alone = ParsedLvm(text, {.scale_v = 2.0, .channel = "A"});
  EXPECT_EQ(alone.channels.at(0).values.at(1), 1.5);
  EXPECT_THAT(LvmErrorOf(text, {.columns = {"time_s"}}, Cause::kUsage),
              HasSubstr("names 1 columns where f.lvm has 2 channels beside X_Value"));
  EXPECT_THAT(LvmErrorOf(text, {.columns = {"voltage_v", "time_s"}}, Cause::kUsage),
              HasSubstr("'time_s' stands for a channel"));
}

TEST(Lvm, ChannelsOfOtherClocksAreReadOneByOne) {
  std::string text = Lvm("Decimal_Separator\t.\nX_Columns\tOne\n",
                         "Channels\t2\nSamples\t3000\t5\nY_Unit_Label\tVolts\tVolts\n"
                         "X0\t0\t0.5\nDelta_X\t2.5E-5\t0.5\n***End_of_Header***\nX_Value\tA\tB\n");
  for (int i = 0; i < 3000; ++i) {
    text += fmt::format("{:.6f}\t{}\t{}\n", 2.5e-5 * i, i % 7, i < 5 ? fmt::format("{}", i) : "");
  }
  EXPECT_THAT(
      LvmErrorOf(text),
      AllOf(HasSubstr("its channels have clocks of their own: 'A' begins at 0 s with a "
                      "sample every 2.5e-05 s (Delta_X), 'B' at 0.5 s with one every 0.5 s"),
            HasSubstr("<channel>")));
  const Record fast = ParsedLvm(text, {.channel = "A"});
  EXPECT_EQ(fast.rows, 3000);
  EXPECT_REL(fast.stretches.at(0).rate_hz, 40'000, 1e-12, "Delta_X");
  const Record slow = ParsedLvm(text, {.channel = "B"});
  ASSERT_EQ(slow.rows, 5);
  EXPECT_EQ(slow.channels.at(0).values, (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(slow.stretches.at(0).start_s, 0.5);
  EXPECT_EQ(slow.stretches[0].rate_hz, 2);
  EXPECT_TRUE(slow.raw_times_s.empty());
}

// channel A has no interval; those of B and C are compared
TEST(Lvm, ClocksThatDifferAreThoseOfTheirOwnChannels) {
  const auto text = [](const char* third) {
    return Lvm("Decimal_Separator\t.\nX_Columns\tNo\n",
               fmt::format("Channels\t3\nX0\t9\t0.25\t{}\nDelta_X\t0\t0.5\t0.5\n"
                           "***End_of_Header***\nX_Value\tA\tB\tC\n\t1\t2\t3\n\t4\t5\t6\n",
                           third));
  };
  EXPECT_THAT(LvmErrorOf(text("0.75")),
              HasSubstr("'B' begins at 0.25 s with a sample every 0.5 s (Delta_X), 'C' at 0.75 s "
                        "with one every 0.5 s"));
  const Record record = ParsedLvm(text("0.375"));
  EXPECT_EQ(record.stretches.at(0).rate_hz, 2);
  EXPECT_EQ(record.stretches[0].start_s, 0.25);
}

TEST(Lvm, ASpectrumIsNoSignalOverTime) {
  const std::string header = "Channels\t2\nX_Dimension\tFrequency\tFrequency\n";
  EXPECT_THAT(LvmErrorOf(TwoChannels(header, 4, Microseconds)),
              HasSubstr("its X is not a time: X_Dimension is Frequency"));
}

TEST(Lvm, OneSegmentCanBeRead) {
  const std::string rows = "0.000\t1\t2\n0.001\t2\t3\n0.002\t3\t4\n";
  const std::string text =
      Lvm("", kSegment + rows + "\n" + kSegment + "0.000\t5\t6\n0.001\t7\t8\n");
  const Record record = ParsedLvm(text, {.segment = 2});
  EXPECT_EQ(record.channels.at(0).values, (std::vector<double>{5, 7}));
  EXPECT_THAT(LvmErrorOf(text, {.segment = 3}), HasSubstr("has 2 segments"));
  // the comments of its own rows alone
  const std::string noted = Lvm(
      "", kSegment + "0\t1\t2\tone\n0.001\t3\t4\n\n" + kSegment + "0\t5\t6\n0.001\t7\t8\ttwo\n");
  EXPECT_THAT(ParsedLvm(noted, {.segment = 2}).metadata.notes, ElementsAre("row 1: two"));
}

// --- headers and rows that other writers leave ---------------------------------------------------

constexpr const char* kTwoRows = "0.000\t1\t2\n0.001\t3\t4\n";

TEST(Lvm, TheSeparatorIsThatOfTheFirstLineThatHasOne) {
  const std::string text = Lvm("Decimal_Separator\t.\n", kSegment + kTwoRows);
  const auto second_value = [](const std::string& changed) {
    return ParsedLvm(changed).channels.at(0).values.at(1);
  };
  // a first line without a separator, and one with a comma beside the tab
  const std::string bare = Changed(text, "Measurement\t\n", "Measurement\n");
  EXPECT_EQ(second_value(bare), 3);
  EXPECT_EQ(second_value(Replaced(bare, '\t', ',')), 3);
  EXPECT_EQ(second_value(Changed(bare, "Version\t2", "Version\t2,0")), 3);
  EXPECT_EQ(second_value(Changed(bare, "Version\t2", "Version")), 3);
  EXPECT_EQ(second_value(Changed(text, "Measurement\t\n", "Measurement\t,\n")), 3);
  EXPECT_EQ(second_value(text.substr(0, text.size() - 1)), 3) << "the last line does not end";
}

TEST(Lvm, KeysWithoutAValueAndLinesOfStarsAreNothing) {
  const Record record = ParsedLvm(Lvm(
      "Operator\t\nProject\tcoil\n",
      "***End_of_Header***\t\n***Other***\n" + kSegment + kTwoRows + "***End_of_Header***\t\n"));
  EXPECT_EQ(record.rows, 2U);
  EXPECT_FALSE(record.metadata.fields.contains("lvm.Operator"));
  EXPECT_FALSE(record.metadata.fields.contains("lvm.LabVIEW Measurement"));
  EXPECT_EQ(record.metadata.fields.at("lvm.Project"), "coil");
  EXPECT_EQ(record.metadata.source, "imported");
  EXPECT_THAT(LvmErrorOf(Lvm("", "***Start_Special***\n" + kSegment + kTwoRows)),
              HasSubstr("holds 0 rows"))
      << "a block that does not end";
  EXPECT_THAT(LvmErrorOf(""), HasSubstr("f.lvm: line 0: is empty"));
}

// the first line is a key, too
TEST(Lvm, AHeaderHasAHundredThousandKeysAtMost) {
  std::string text = "LabVIEW Measurement\t\n";
  for (int i = 0; i < 100'001; ++i) text += std::to_string(i) + "\t1\n";
  EXPECT_THAT(LvmErrorOf(text), HasSubstr("f.lvm: line 100001: the header has too many lines"));
}

TEST(Lvm, ChannelsHaveNamesUnitsAndNoPlaceBehindTheLast) {
  const auto text = [](const char* names, const char* rows) {
    return Lvm(
        "", Changed(Changed(kSegment, "Laser\tRef\tComment", names), "Volts\tmm", "Volts") + rows);
  };
  // separators behind the names, and one unit for two channels
  const Record record = ParsedLvm(text("A\tB\t\t", kTwoRows));
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[0].unit, "V");
  EXPECT_EQ(record.channels[1].unit, "");
  EXPECT_EQ(record.channels[1].role, ChannelRole::kOther);
  EXPECT_THAT(LvmErrorOf(text("\t", kTwoRows)), HasSubstr("names no channel, or too many"));
  // behind them a comment has its place
  const Record noted = ParsedLvm(text("A\t\tComment", "0\t1\t2\tone\n0.001\t3\t4\n"));
  ASSERT_EQ(noted.channels.size(), 2U);
  EXPECT_EQ(noted.channels[1].name, "channel_2");
  EXPECT_THAT(noted.metadata.notes, ElementsAre("row 0: one"));
}

TEST(Lvm, OneValueOfAKeyIsThatOfEachChannel) {
  const std::string one = Changed(kSegment, "0.001\t0.001", "0.25");
  const Record record = ParsedLvm(Lvm("X_Columns\tNo\n", one + "\t1\t2\n\t3\t4\n"));
  EXPECT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.stretches.at(0).rate_hz, 4);
}

TEST(Lvm, WithoutXAndDeltaXTheRateIsTheUsers) {
  const std::string text =
      Lvm("X_Columns\tNo\n", "Channels\t1\n***End_of_Header***\nX_Value\tA\n\t1\n\t2\n");
  EXPECT_EQ(ParsedLvm(text, {.rate_hz = 50}).stretches.at(0).rate_hz, 50);
  EXPECT_EQ(ParsedLvm(text, {.rate_hz = 50}).metadata.nominal_rate_hz, 50);
  // a start that is none leaves no clock
  EXPECT_THAT(LvmErrorOf(Lvm("X_Columns\tNo\n",
                             Changed(kSegment, "X0\t0\t0", "X0\tinf\tinf") + "\t1\t2\n\t3\t4\n")),
              HasSubstr("neither X values nor a Delta_X above 0"));
  EXPECT_THAT(LvmErrorOf(Lvm("X_Columns\tNo\n", kSegment + "\t1\n")),
              HasSubstr("has 2 cells where 3 are needed"));
}

TEST(Lvm, XIsAFiniteNumberOfAllItsColumns) {
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment + "inf\t1\t2\n")), HasSubstr("'inf' is not an X value"));
  EXPECT_THAT(LvmErrorOf(Lvm("X_Columns\tMulti\n",
                             "Channels\t2\t\n***End_of_Header***\t\n"
                             "X_Value\tA\tX_Value\tB\n0\t1\tx\t2\n")),
              HasSubstr("X values of their own (0 and x)"));
}

TEST(Lvm, ColumnsThatAreSaidAreXAndChannels) {
  const std::string text = Lvm("", kSegment + kTwoRows);
  EXPECT_THAT(LvmErrorOf(text, {.columns = {"voltage_v", "a", "b"}}, Cause::kUsage),
              HasSubstr("'voltage_v' stands for X_Value, which is the time"));
  EXPECT_THAT(LvmErrorOf(text, {.columns = {"-", "-"}}), HasSubstr("no column is left"));
  EXPECT_THAT(
      LvmErrorOf(Lvm("X_Columns\tNo\n", kSegment + kTwoRows), {.columns = {"a"}}, Cause::kUsage),
      HasSubstr("names 1 columns where f.lvm has 2 channels; name"));
  EXPECT_THAT(LvmErrorOf(text, {.segment = 2}), HasSubstr("has 1 segment;"));
  Findings findings;
  ASSERT_TRUE(ParseLvm(text, "f", {.format = TableFormat::kLecroy}, &findings));
  EXPECT_TRUE(findings.Has(FindingKind::kFormatNotUsed));
}

// a segment of one channel that states `samples`, with `rows` rows a millisecond apart
std::string OneChannel(int samples, int rows) {
  std::string text = fmt::format(
      "Channels\t1\nSamples\t{}\nX0\t0\nDelta_X\t0.001\n***End_of_Header***\nX_Value\tLaser\n",
      samples);
  for (int i = 0; i < rows; ++i) text += fmt::format("{:.6f}\t{:.6f}\n", i * 1e-3, std::sin(i));
  return text;
}

Findings FoundInLvm(const std::string& body) {
  Findings findings;
  const auto record = ParseLvm(Lvm("X_Columns\tOne\n", body), "f.lvm", {}, &findings);
  EXPECT_TRUE(record) << record.error().Text();
  return findings;
}

TEST(Lvm, ALastLineThatWasCutOffIsLeftOut) {
  const std::string whole = OneChannel(200, 200);
  EXPECT_TRUE(FoundInLvm(whole).list().empty());
  EXPECT_TRUE(FoundInLvm(whole.substr(0, whole.size() - 1)).list().empty()) << "the line end alone";
  for (const std::size_t cut : {6U, 11U}) {
    const std::string text = whole.substr(0, whole.size() - cut);
    EXPECT_TRUE(FoundInLvm(text).Has(FindingKind::kLastLineCutOff)) << cut;
    EXPECT_EQ(ParsedLvm(Lvm("X_Columns\tOne\n", text)).rows, 199U);
  }
}

TEST(Lvm, RowsThatAreNotItsSamplesAreDoubted) {
  for (const int samples : {150, 250}) {
    const Findings findings = FoundInLvm(OneChannel(samples, 200));
    EXPECT_EQ(findings.list().size(), 1U);
    EXPECT_EQ(tests::NumbersOf(findings, FindingKind::kStatedRowsDiffer),
              fmt::format("stated_rows={} rows=200", samples));
  }
  // two writes of 100 samples below one header
  EXPECT_TRUE(FoundInLvm(OneChannel(100, 200)).list().empty());
}

// a second channel of another clock is read to its Samples, or to the last row
TEST(Lvm, SamplesEndAChannelOfAnotherClock) {
  const auto rows = [](const char* samples) {
    const std::string text =
        Lvm("", Changed(Changed(kSegment, "0.001\t0.001", "0.001\t0.5"), "Samples\t3\t3", samples) +
                    "0\t1\t2\n0.001\t3\t4\n0.002\t5\t6\n");
    const Record record = ParsedLvm(text, {.channel = "Ref"});
    EXPECT_EQ(record.stretches.at(0).rate_hz, 2);
    EXPECT_EQ(record.channels.at(0).values.size(), record.rows);
    return record.rows;
  };
  EXPECT_EQ(rows("Samples\t3\t2"), 2U);
  EXPECT_EQ(rows("Samples\t3\t3"), 3U);
  EXPECT_EQ(rows("Samples\t3\t4"), 3U);
  EXPECT_EQ(rows("Notes\tnone"), 3U);
}

// the wall tells where a segment lies if both segments state a time of day
TEST(Lvm, ASegmentWithoutATimeOfDayHasNoPlace) {
  const auto error_of = [](const char* first, const char* second) {
    const std::string rows = "0.000\t1\t2\n0.001\t2\t3\n0.002\t3\t4\n";
    const auto at = [](const char* time) {
      return Changed(kSegment, "X_Dim", fmt::format("Time\t{}\nX_Dim", time));
    };
    return LvmErrorOf(Lvm("", at(first) + rows + at(second) + rows));
  };
  EXPECT_EQ(error_of("12:00:00", "12:00:01"), "was read");
  for (const auto& [first, second] :
       {std::pair{"noon", "12:00:01"}, {"12:00:00", "noon"}, {"12:00:01", "12:00:00"}}) {
    EXPECT_THAT(error_of(first, second), HasSubstr("whose Date and Time do not state when"));
  }
}

}  // namespace
}  // namespace haptometer::trial
