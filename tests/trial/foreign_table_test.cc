// What other programs write: oscilloscopes, DAQs, LabVIEW.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/residual.h"
#include "trial/import/csv.h"
#include "trial/import/lvm.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Record Parsed(std::string_view text, const ImportOptions& options = {}) {
  auto record = ParseCsv(text, "f.csv", options);
  EXPECT_TRUE(record) << record.error().Text();
  return record ? std::move(*record) : Record{};
}

std::string ErrorOf(std::string_view text, const ImportOptions& options = {}) {
  const auto record = ParseCsv(text, "f.csv", options);
  if (record) return "was read";
  EXPECT_FALSE(record.error().remedy.empty());
  return record.error().Text();
}

TEST(ForeignTable, ALineOfUnitsBelowTheNames) {
  // the form of PicoScope's CSV
  const Record record =
      Parsed("Time,Channel A,Channel B\n(ms),(V),(mV)\n\n0.0,1.5,2\n0.5,2.5,-3\n");
  ASSERT_EQ(record.channels.size(), 2);
  EXPECT_EQ(record.channels[0].name, "Channel A");
  EXPECT_EQ(record.channels[0].role, ChannelRole::kVoltage);
  EXPECT_EQ(record.channels[0].values[1], 2.5);
  EXPECT_REL(record.channels[1].values[1], -3e-3, 1e-15, "one product");
  EXPECT_REL(record.stretches.at(0).rate_hz, 2000, 1e-15, "printed times");
}

TEST(ForeignTable, NamesAndUnitsAsWordsAndAPreamble) {
  // the forms of Keysight's and Tektronix's CSV
  const Record words = Parsed("x-axis,1\nsecond,Volt\n-1e-3,1\n0,2\n1e-3,3\n");
  EXPECT_EQ(words.Find(ChannelRole::kVoltage)->values.size(), 3);
  EXPECT_EQ(TimeOf(words, 0), -1e-3);
  const Record preamble = Parsed(
      "Model,TDS2024\nSample Interval,1e-4\nsome words, with, commas\n\nTIME [s],CH1 [V]\n"
      "0,1,\n0.0001,2,\n");
  EXPECT_EQ(preamble.metadata.fields.at("table.Model"), "TDS2024");
  EXPECT_THAT(preamble.metadata.notes, ElementsAre("some words, with, commas"));
  EXPECT_EQ(preamble.channels.at(0).name, "CH1");
  const Record german = Parsed("Zeit [ms];Weg [\xc2\xb5m]\n0;1,5\n1;2,5\n");
  EXPECT_REL(german.Find(ChannelRole::kDisplacement)->values[1], 2.5e-6, 1e-15, "one product");
}

TEST(ForeignTable, ColumnsRateAndScaleOverrideWhatTheFileSays) {
  const Record bare = Parsed("0,1,7\n1,2,8\n", {.columns = {"time_ms", "displacement_um", "-"}});
  ASSERT_EQ(bare.channels.size(), 1);
  EXPECT_REL(bare.channels[0].values[1], 2e-6, 1e-15, "one product");
  EXPECT_REL(bare.stretches.at(0).rate_hz, 1000, 1e-12, "printed times");
  const Record renamed = Parsed(
      "t,x\n0,1\n1,2\n", {.columns = {"-", "displacement"}, .rate_hz = 10'000.0, .scale_m = 5e-3});
  EXPECT_EQ(renamed.channels.at(0).values[1], 1e-2);
  EXPECT_EQ(renamed.stretches.at(0).rate_hz, 10'000);
  EXPECT_TRUE(renamed.raw_times_s.empty());
  const Record agreeing = Parsed("time_s,voltage_v\n0,1\n0.001,2\n", {.rate_hz = 1000.0});
  EXPECT_EQ(agreeing.rows, 2);
}

TEST(ForeignTable, AValueThatItsScaleTakesBeyondADoubleIsInvalid) {
  const Record record =
      Parsed("0,1e308\n1,2\n", {.columns = {"time_s", "displacement"}, .scale_m = 10.0});
  const Channel& channel = record.channels.at(0);
  EXPECT_EQ(channel.statuses,
            (std::vector<SampleStatus>{SampleStatus::kInvalid, SampleStatus::kOk}));
  EXPECT_TRUE(std::isnan(channel.values[0]));
  EXPECT_EQ(channel.values[1], 20);
}

TEST(ForeignTable, WhatHasTwoReadingsIsRefusedWithBoth) {
  EXPECT_EQ(
      ErrorOf("Time,CH1\n0,1\n1,2\n"),
      "f.csv: column 'Time' does not say its unit: in s there are 1 rows a second, in ms 1000; "
      "name it time_s, time_ms or time_us, or say --columns");
  EXPECT_EQ(ErrorOf("a,b\n0,001,1,5\n0,002,1,6\n"),
            "f.csv: line 2: has 4 cells under 2 names: either cells '0' and '001', or one number "
            "0,001; separate cells with semicolons, or write decimal points");
  EXPECT_EQ(
      ErrorOf("time_s;voltage_v\n0;1,234\n0.5;2\n"),
      "f.csv: line 2: '1,234' may be a decimal comma or group thousands, as '0.5' has a point; "
      "write all numbers with points and without grouping");
  EXPECT_THAT(ErrorOf("time_s,voltage_v\n0,1\n1,2\n", {.rate_hz = 1000.0}),
              HasSubstr("its times say 1 rows a second and --rate says 1000 Hz"));
}

TEST(ForeignTable, WhatIsMissingIsAskedFor) {
  EXPECT_THAT(ErrorOf("CH1,CH2\n0,1\n1,2\n"),
              HasSubstr("no column is a time and no line above states the sample interval"));
  EXPECT_THAT(ErrorOf("0,1\n1,2\n", {.columns = {"time_s"}}),
              HasSubstr("names 1 columns where f.csv has 2"));
  EXPECT_THAT(ErrorOf("0,1\n1,2\n", {.columns = {"time_s", "voltage_v"}, .scale_m = 1.0}),
              HasSubstr("no column is one; say --columns time_s,displacement"));
  EXPECT_THAT(ErrorOf("0,1\n1,2\n", {.columns = {"time", "voltage_v"}}),
              HasSubstr("column 'time' does not say its unit"));
  EXPECT_THAT(ErrorOf("0,1\n1,2\n", {.columns = {"time_s", "-"}}),
              HasSubstr("no column beside the time"));
}

TEST(ForeignTable, LinesOfOurOwnMayStandAnywhereAboveTheTable) {
  const Record record = Parsed(
      "# case = held\nModel,TDS\n# load_ohm = 27\n\nTime (s),CH1 (V)\n0,1\n1,2\n# late = 1\n");
  EXPECT_EQ(record.metadata.fields.at("case"), "held");
  EXPECT_EQ(record.metadata.fields.at("load_ohm"), "27");
  EXPECT_EQ(record.metadata.fields.at("late"), "1");
  EXPECT_EQ(record.metadata.fields.at("table.Model"), "TDS");
}

TEST(ForeignTable, FiveDigitsGiveTheRateToTwoPartsInAMillion) {
  // 1.5 us steps under quanta of 10 ns to 10 us: the end points alone tell 33 parts in a million
  constexpr int kRows = 100'000;
  std::string text = "Time(s),CH1(V)\n";
  for (int k = 0; k < kRows; ++k) text += fmt::format("{:.4e},1\n", k * 1.5e-6);
  const Record record = Parsed(text);
  ASSERT_EQ(record.stretches.size(), 1);
  EXPECT_REL(record.stretches[0].rate_hz, 1 / 1.5e-6, 2e-6,
             "ties, one time in twenty, may all round one way: 0.25 us over 0.15 s");
}

TEST(ForeignTable, UnevenTimesCloserThanANanosecondKeepTheirRate) {
  const Record record = Parsed("Time (ns),CH1 (V)\n0.00,1\n0.10,2\n0.25,3\n0.30,4\n");
  EXPECT_EQ(record.raw_times_s.size(), 4);
  EXPECT_REL(record.stretches.at(0).rate_hz, 1 / 0.105e-9, 1e-12, "least squares by hand");
}

TEST(ForeignTable, ColumnsThatAreSaidNeedATable) {
  EXPECT_EQ(ErrorOf("a,b\nc,d\n", {.columns = {"time_s", "voltage_v"}}),
            "f.csv: has no two lines of numbers for --columns to name; give a file with a row of "
            "numbers a line");
}

TEST(ForeignTable, TimesAgainstAStatedRateAreRemarkedUpon) {
  for (const char* words : {"# nominal_rate_hz = 1000", "# sampling 1 kHz", "# rate = 1000 Hz",
                            "# sample_rate_hz = 1000"}) {
    std::vector<std::string> remarks;
    const auto record =
        ParseCsv(std::string(words) + "\ntime_s,voltage_v\n0,1\n1,2\n2,3\n", "f", {}, &remarks);
    ASSERT_TRUE(record);
    EXPECT_EQ(record->stretches.at(0).rate_hz, 1);
    ASSERT_EQ(remarks.size(), 1) << words;
    EXPECT_THAT(remarks[0], HasSubstr("say 1 rows a second where the file states 1000 Hz"));
  }
  std::vector<std::string> remarks;
  EXPECT_TRUE(ParseCsv("# rate = 1000 Hz\ntime_s,voltage_v\n0,1\n0.001,2\n", "f", {}, &remarks));
  EXPECT_TRUE(ParseCsv("# drive 225 Hz\ntime_s,voltage_v\n0,1\n1,2\n", "f", {}, &remarks));
  EXPECT_THAT(remarks, IsEmpty());
}

TEST(ForeignTable, TimesAndHeaderThatContradictEachOtherAreRefusedUntilTheRateIsSaid) {
  const std::string text = "Sample Interval,1e-3\nTime (s),CH1 (V)\n0,1\n1,2\n2,3\n";
  EXPECT_EQ(ErrorOf(text),
            "f.csv: its times say 1 rows a second and 'Sample Interval' says 1000; say which is "
            "right with --rate");
  EXPECT_REL(Parsed(text, {.rate_hz = 1000.0}).stretches.at(0).rate_hz, 1000, 1e-12, "header");
  EXPECT_REL(Parsed(text, {.rate_hz = 1.0}).stretches.at(0).rate_hz, 1, 1e-12, "times");
  EXPECT_THAT(ErrorOf(text, {.rate_hz = 7.0}), HasSubstr("--rate says 7 Hz"));
  EXPECT_THAT(ErrorOf("Sample Interval,1e-3\nSample Rate,1e6\nCH1 (V)\n1\n2\n"),
              HasSubstr("states two sample intervals: 0.001 s by 'Sample Interval' and 1e-06 s"));
}

TEST(ForeignTable, ARateThatIsSaidReplacesTheHeadersWhereThereAreNoTimes) {
  const std::string text = "Sample Interval,1e-3\nCH1 (V)\n1\n2\n3\n";
  EXPECT_REL(Parsed(text).stretches.at(0).rate_hz, 1000, 1e-12, "header");
  std::vector<std::string> remarks;
  const auto record = ParseCsv(text, "f", {.rate_hz = 500.0}, &remarks);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->stretches.at(0).rate_hz, 500);
  EXPECT_THAT(remarks, ::testing::Contains(HasSubstr("--rate 500 Hz replaces 1000 Hz")));
}

TEST(ForeignTable, TimesThatBeginAgainAreSegmentsOrRowsOutOfOrder) {
  const std::string text = "Time (s),CH1 (V)\n0,1\n1,2\n2,3\n0,4\n1,5\n2,6\n";
  EXPECT_EQ(ErrorOf(text),
            "f.csv: its times begin again at line 5: either 2 segments, of which it does not say "
            "when they were, or rows out of order; read one of them (--segment 1 to 2), or sort "
            "the rows");
  EXPECT_EQ(Parsed(text, {.segment = 2}).channels.at(0).values, (std::vector<double>{4, 5, 6}));
  EXPECT_THAT(ErrorOf("Time (s),CH1 (V)\n0,1\n1,2\n0,4\n", {.segment = 2}),
              HasSubstr("line 4: is a segment of one row"));
}

TEST(ForeignTable, TimesThatRepeatWithoutAGridBehindThemAreRefused) {
  EXPECT_THAT(ErrorOf("Time (s),CH1 (V)\n0,1\n0,2\n1,3\n"),
              HasSubstr("1 of 3 times are those of the row before, and no even grid explains it"));
  std::string burst = "Time (s),CH1 (V)\n";
  for (int i = 0; i < 40; ++i) burst += i % 20 < 10 ? "0.001,1\n" : "";
  for (int i = 0; i < 40; ++i) burst += "0.5,1\n";
  EXPECT_THAT(ErrorOf(burst), HasSubstr("no even grid explains it"));
}

TEST(ForeignTable, EmptyRowsAtTheEndArePassedOverAndInTheMiddleNot) {
  EXPECT_EQ(Parsed("Time (s),CH1 (V)\n0,1\n1,2\n,,\n").rows, 2);
  EXPECT_EQ(Parsed("Time (s),CH1 (V)\n0,1\n1,2\n\n\n").rows, 2);
  EXPECT_THAT(ErrorOf("CH1 (V),CH2 (V)\n0,1\n1,2\n,\n3,4\n", {.rate_hz = 10.0}),
              HasSubstr("line 4: has empty cells alone between rows that have no times"));
}

TEST(ForeignTable, WhatASpreadsheetMadeOfANumberIsNamed) {
  EXPECT_THAT(ErrorOf("Time (s);CH1 (V)\n0;1,5\n1;2,5\n2;1.234.567\n"),
              HasSubstr("line 4: '1.234.567' is no number (column 'CH1'): a spreadsheet may have"));
}

TEST(ForeignTable, TheOnlyChannelIsWhatTheScaleIsAbout) {
  const Record record = Parsed("1\n2\n3\n", {.rate_hz = 10.0, .scale_v = 0.5});
  EXPECT_EQ(record.channels.at(0).role, ChannelRole::kVoltage);
  EXPECT_EQ(record.channels[0].values[2], 1.5);
  EXPECT_EQ(record.channels[0].unit, "V");
}

TEST(ForeignTable, AHistogramIsNoWaveform) {
  EXPECT_THAT(ErrorOf("LECROYWP715Zi-A,1,Histogram\nTime,Ampl\n0,1\n1,2\n"),
              HasSubstr("holds a histogram"));
}

TEST(ForeignTable, WordsThatAreNotUtf8AreReadAsWindowsWritesThem) {
  const Record record = Parsed("Zeit (\xb5s);Spannung (mV)\n0;1\n1;2\n");
  EXPECT_REL(record.stretches.at(0).rate_hz, 1e6, 1e-9, "printed times");
}

// --- LabVIEW ------------------------------------------------------------------------------------

// a file with the given header lines, segment lines and rows
std::string Lvm(std::string_view header, std::string_view body) {
  return "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\n" + std::string(header) +
         "Date\t2024/05/06\nTime\t12:00:00.5\n***End_of_Header***\t\n\t\n" + std::string(body);
}

std::string Replaced(std::string text, char from, char to) {
  std::ranges::replace(text, from, to);
  return text;
}

Record ParsedLvm(const std::string& text) {
  EXPECT_TRUE(IsLvm(text));
  auto record = ParseLvm(text, "f.lvm");
  EXPECT_TRUE(record) << record.error().Text();
  return record ? std::move(*record) : Record{};
}

std::string LvmErrorOf(const std::string& text) {
  const auto record = ParseLvm(text, "f.lvm");
  if (record) return "was read";
  EXPECT_EQ(record.error().cause, Cause::kCannotAnswer);
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
              HasSubstr("whose Date and Time do not tell when"));
  EXPECT_THAT(
      LvmErrorOf(Lvm("", kSegment + rows + "Channels\t1\n***End_of_Header***\nX_Value\tA\n0\t1\n")),
      HasSubstr("begins a segment of 1 channels where the first has 2"));
}

TEST(Lvm, WhatCannotBeReadIsExplained) {
  EXPECT_THAT(LvmErrorOf("LabVIEW Measurement\nX_Columns\tOne\n"),
              HasSubstr("header does not end"));
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment + "0\tabc\t1\n")), HasSubstr("'abc' is no number"));
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment + "0\t1\n")),
              HasSubstr("has 2 cells where 3 are needed"));
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment + "0\t1\t1\n0\t1\t1\n")), HasSubstr("does not grow"));
  EXPECT_THAT(LvmErrorOf(Lvm("", "0\t1\n")), HasSubstr("a line of names"));
  EXPECT_THAT(LvmErrorOf(Lvm("", kSegment)), HasSubstr("holds 0 rows"));
  EXPECT_THAT(LvmErrorOf(Lvm("Decimal_Separator\t.\n", kSegment + "0,5\t1\t1\n")),
              HasSubstr("'0,5' is no X value"));
  EXPECT_THAT(LvmErrorOf(Lvm("X_Columns\tNo\n", "X_Value\tA\n\t1\n\t2\n")),
              HasSubstr("neither X values nor a Delta_X"));
}

}  // namespace
}  // namespace haptometer::trial
