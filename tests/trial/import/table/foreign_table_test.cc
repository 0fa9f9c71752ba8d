// What other programs write: oscilloscopes, DAQs, LabVIEW.
#include "trial/import/table/foreign_table.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using tests::NumbersOf;

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

TEST(ForeignTable, AQuantityByItsUnit) {
  for (const char* header :
       {"t/s\tx/um", "time/s\tx/\u00b5m", "Zeit/s\tx / um", "t/s\tx/(\u03bcm)"}) {
    const Record record = Parsed(std::string(header) + "\n0\t1,5\n0,5\t2,5\n");
    ASSERT_EQ(record.channels.size(), 1U) << header;
    EXPECT_EQ(record.channels[0].name, "x") << header;
    EXPECT_EQ(record.channels[0].role, ChannelRole::kDisplacement) << header;
    EXPECT_REL(record.channels[0].values[1], 2.5e-6, 1e-15, "one product");
    EXPECT_EQ(record.stretches.at(0).rate_hz, 2) << header;
  }
  const Record german = Parsed("t/ms;s/mm;U/V;I/mA\n0;1;2;3\n1;2;3;4\n");
  ASSERT_EQ(german.channels.size(), 3U);
  EXPECT_EQ(german.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_EQ(german.channels[1].role, ChannelRole::kVoltage);
  EXPECT_EQ(german.channels[2].role, ChannelRole::kCurrent);
  EXPECT_REL(german.channels[2].values[1], 4e-3, 1e-15, "one product");
}

TEST(ForeignTable, AQuotientOfUnitsIsNoQuantityByItsUnit) {
  for (const char* name : {"mm/s", "V/s", "mV/V", "N/mm", "g/V", "rad/s", "1/s", "Samples/s",
                           "V/div", "/V", "a/m/s^2"}) {
    const Record record = Parsed(fmt::format("Time (s),{}\n0,1\n1,2\n", name));
    EXPECT_EQ(record.channels.at(0).name, name);
    EXPECT_EQ(record.channels[0].role, ChannelRole::kOther) << name;
    EXPECT_EQ(record.channels[0].unit, "") << name;
  }
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
  EXPECT_EQ(ErrorOf("Time,CH1\n0,1\n1,2\n"),
            "f.csv: column 'Time' does not state its unit: in s there are 1 rows per second, in ms "
            "1000; name it time_s, time_ms or time_us, or give <columns>");
  EXPECT_EQ(ErrorOf("a,b\n0,001,1,5\n0,002,1,6\n"),
            "f.csv: line 2: has 4 cells under 2 names: either cells '0' and '001', or one number "
            "0,001; separate cells with semicolons, or write decimal points");
  EXPECT_EQ(
      ErrorOf("time_s;voltage_v\n0;1,234\n0.5;2\n"),
      "f.csv: line 2: '1,234' may be a decimal comma or group thousands, as '0.5' has a point; "
      "write all numbers with points and without grouping");
  EXPECT_THAT(ErrorOf("time_s,voltage_v\n0,1\n1,2\n", {.rate_hz = 1000.0}),
              HasSubstr("its times give 1 rows per second and <rate> gives 1000 Hz"));
}

TEST(ForeignTable, ACommaThatMayGroupThousandsIsRefusedUntilANumberShowsWhatItIs) {
  EXPECT_EQ(
      ErrorOf("Time (us);Laser (um)\n0;999\n100;30,123\n200;-1,500\n"),
      "f.csv: line 3: '30,123' may be a decimal comma or group thousands, and no other number "
      "shows which; write all numbers with points and without grouping");
  EXPECT_THAT(ErrorOf("time_us\tdisplacement_nm\n0\t30,123\n100\t+30,124\n"),
              HasSubstr("line 2: '30,123' may be a decimal comma"));
  EXPECT_THAT(ErrorOf("Time (s),Laser (um)\n0,\"1,234\"\n1,\"1,235\"\n"),
              HasSubstr("line 2: '1,234' may be a decimal comma"));
  for (const char* shown : {"0,123", "-0,123", "12,5", "1,2345", "1,234e0", "1234,567"}) {
    const Record record = Parsed(fmt::format("Time (us);Laser (um)\n0;{}\n100;30,123\n", shown));
    EXPECT_REL(record.channels.at(0).values.at(1), 30.123e-6, 1e-15, "one product") << shown;
  }
  // a time, a time of day or a column that is left out shows it as well
  EXPECT_EQ(Parsed("Time (ms);Coil (V)\n0,0;1,234\n0,1;1,235\n").channels.at(0).values.at(0),
            1.234);
  EXPECT_EQ(
      Parsed("Time;Coil (V)\n12:00:00,0;1,234\n12:00:00,5;1,235\n").channels.at(0).values.at(0),
      1.234);
  EXPECT_EQ(Parsed("0;1,234;0,5\n1;1,235;0,5\n", {.columns = {"time_s", "voltage_v", "-"}})
                .channels.at(0)
                .values.at(0),
            1.234);
}

TEST(ForeignTable, APointThatMayGroupThousandsBesideDecimalCommasIsRefused) {
  EXPECT_EQ(
      ErrorOf("Time (s);Laser (um)\n0,1;1.234\n0,2;2.345\n"),
      "f.csv: line 2: '1.234' may be a decimal point or group thousands, as '0,1' has a comma; "
      "write all numbers with points and without grouping");
  EXPECT_EQ(Parsed("Time (s);Coil (V)\n0,1;1.234\n0,2;0.345\n").channels.at(0).values.at(0), 1.234);
  EXPECT_EQ(Parsed("Time (s);Coil (V)\n1;1.234\n2;2.345\n").channels.at(0).values.at(0), 1.234);
}

TEST(ForeignTable, AStatedRateThatMayGroupThousandsIsNoClock) {
  for (const char* text : {"Sample Rate,\"100,000 Hz\"\nCH1 (V),CH2 (V)\n0.5,1\n1.5,2\n",
                           "Sample Rate,100,000 Hz\nCH1 (V),CH2 (V)\n0.5,1\n1.5,2\n",
                           "Sample Rate:\t100,000 Hz\nCH1 (V)\tCH2 (V)\n0.5\t1\n1.5\t2\n"}) {
    EXPECT_EQ(ErrorOf(text),
              "f.csv: states 100,000 by 'Sample Rate', which may have a decimal sign or group "
              "thousands; give the rows per second (<rate>)");
    EXPECT_EQ(Parsed(text, {.rate_hz = 1e5}).stretches.at(0).rate_hz, 1e5);
  }
  const std::string points = "Sampling Rate;5.000 Hz\nCH1 (V);CH2 (V)\n";
  EXPECT_THAT(ErrorOf(points + "0;1\n1,5;2\n"), HasSubstr("states 5.000 by 'Sampling Rate'"));
  EXPECT_EQ(Parsed(points + "0.5;1\n1.5;2\n").stretches.at(0).rate_hz, 5);
}

TEST(ForeignTable, AStatedRateOfOneMeaningIsAClockWhateverItsSign) {
  for (const char* rate : {"0,500 Hz", "0,5 Hz", "5,000e-1 Hz"}) {
    const Record record =
        Parsed(fmt::format("Sample Rate:\t{}\nCH1 (V)\tCH2 (V)\n0\t1\n1,5\t2\n", rate));
    EXPECT_EQ(record.stretches.at(0).rate_hz, 0.5) << rate;
  }
  // a second statement shows the meaning of the first
  EXPECT_EQ(Parsed("Sample Rate:\t5,000 Hz\nSample Interval:\t0.2\nCH1 (V)\tCH2 (V)\n0\t1\n1\t2\n")
                .stretches.at(0)
                .rate_hz,
            5);
}

TEST(ForeignTable, AStatedRateThatMayGroupThousandsGivesNoUnitOfTheTimes) {
  const std::string rows = "Time\tCH1 (V)\n0\t1\n0.1\t2\n0.2\t3\n";
  EXPECT_THAT(ErrorOf("Sample Rate:\t10,000 Hz\n" + rows),
              HasSubstr("column 'Time' does not state its unit"));
  EXPECT_REL(Parsed("Sample Rate:\t10000 Hz\n" + rows).stretches.at(0).rate_hz, 10'000, 1e-9,
             "printed times");
}

constexpr const char* kTraces =
    "\"TraceName\",\"CH1   \",\"CH2   \"\n\"VUnit\",\"mV\",\"V\"\n"
    "\"HResolution\",2.0e-01,2.0e-01\n\"HOffset\",-10,-10\n";

TEST(ForeignTable, TheIntervalOfTracesIsInTheirUnit) {
  const Record record = Parsed(std::string(kTraces) + "\"HUnit\",\"ms\",\"ms\"\n\n1,2\n3,4\n5,6\n");
  EXPECT_REL(record.stretches.at(0).rate_hz, 5000, 1e-12, "one product");
  EXPECT_REL(record.stretches.at(0).start_s, -10e-3, 1e-12, "one product");
  EXPECT_EQ(
      ErrorOf(std::string(kTraces) + "\"HUnit\",\"Hz\",\"Hz\"\n\n1,2\n3,4\n"),
      "f.csv: has 'HUnit' Hz, which is no time; save the channels as waveforms over the time");
}

TEST(ForeignTable, TheLastKeyOfTracesIsNoLineOfNames) {
  const Record record =
      Parsed(std::string(kTraces) + "\"HUnit\",\"ms\",\"ms\"\n\n,1,2,\n,3,4,\n,5,6,\n");
  ASSERT_EQ(record.channels.size(), 2);
  EXPECT_EQ(record.channels[0].name, "CH1");
  EXPECT_REL(record.channels[0].values[0], 1e-3, 1e-15, "one product");
  EXPECT_EQ(record.channels[1].name, "CH2");
  EXPECT_EQ(record.channels[1].role, ChannelRole::kVoltage);
}

TEST(ForeignTable, ADateAndATimeOfDay) {
  for (const char* date : {"2024-05-06", "06.05.2024", "5/6/24"}) {
    const Record record =
        Parsed(fmt::format("Date,Time,Coil (V)\n{0},12:00:00.0000,1\n{0},12:00:00.0002,2\n"
                           "{0},12:00:00.0004,3\n",
                           date));
    ASSERT_EQ(record.channels.size(), 1) << date;
    EXPECT_REL(record.stretches.at(0).rate_hz, 5000, 1e-6, "printed times");
    EXPECT_EQ(record.channels[0].values, (std::vector<double>{1, 2, 3}));
  }
  const Record midnight = Parsed(
      "Datum;Uhrzeit;Coil (V)\n06.05.2024;23:59:59,5;1\n07.05.2024;00:00:00,0;2\n"
      "07.05.2024;00:00:00,5;3\n");
  EXPECT_REL(midnight.stretches.at(0).rate_hz, 2, 1e-9, "printed times");
}

// a first column of times of day needs no name that means time
TEST(ForeignTable, ATimeOfDayUnderAnyName) {
  for (const char* name : {"Uhrzeit", "Zeitstempel", "heure"}) {
    const Record record = Parsed(
        fmt::format("{};Coil (V)\n12:00:00,0000;1\n12:00:00,0002;2\n12:00:00,0004;3\n", name));
    ASSERT_EQ(record.channels.size(), 1) << name;
    EXPECT_REL(record.stretches.at(0).rate_hz, 5000, 1e-6, "printed times");
  }
}

TEST(ForeignTable, EachMidnightAddsADay) {
  // every seven hours from 20 o'clock on: 63 hours later it is the third day's 11 o'clock
  std::string text = "Date,Time,Coil (V)\n";
  for (int i = 0; i < 10; ++i) {
    const int hours = 20 + 7 * i;
    text += fmt::format("2024-05-{:02},{:02}:00:00,{}\n", 6 + hours / 24, hours % 24, i);
  }
  const Record record = Parsed(text);
  EXPECT_TRUE(record.raw_times_s.empty());
  ASSERT_EQ(record.stretches.size(), 1U);
  EXPECT_EQ(record.stretches[0].rows, 10U);
  EXPECT_REL(record.stretches[0].rate_hz, 1 / 25'200.0, 1e-12, "whole seconds");
  EXPECT_EQ(TimeOf(record, 9) - TimeOf(record, 0), 63 * 3600);
}

// a time of day that falls by more than twelve hours is the next day's
TEST(ForeignTable, AMidnightIsAFallOfMoreThanHalfADay) {
  const auto text = [](const char* first, const char* second) {
    return fmt::format("Time,Coil (V)\n{}:00,1\n{}:01,2\n{}:00,3\n{}:01,4\n", first, first, second,
                       second);
  };
  const Record record = Parsed(text("18:00", "05:59"));
  ASSERT_EQ(record.rows, 4U);
  EXPECT_EQ(TimeOf(record, 2) - TimeOf(record, 0), 12 * 3600 - 60);
  EXPECT_THAT(ErrorOf(text("18:00", "06:01")), HasSubstr("its times begin again at line 4"));
}

// rows a millisecond apart, the second three behind the given dates' change
std::string OnTwoDays(const char* form, std::string_view first, std::string_view second) {
  std::string text = form;
  for (int i = 0; i < 6; ++i) {
    const bool is_date_apart = text.starts_with("Date,");
    text += fmt::format("{}{}10:00:00.{:03},{}\n", i < 3 ? first : second,
                        is_date_apart ? ',' : ' ', i, i);
  }
  return text;
}

TEST(ForeignTable, DaysBetweenDatesAreNotLost) {
  for (const char* form : {"Date,Time,Coil (V)\n", "DateTime,Coil (V)\n"}) {
    // over the leap day
    const Record record = Parsed(OnTwoDays(form, "2024-02-28", "2024-03-01"));
    ASSERT_EQ(record.rows, 6U);
    EXPECT_NEAR(TimeOf(record, 5) - TimeOf(record, 0), 2 * 86'400 + 0.005, 1e-9);
    // dates that run backwards
    EXPECT_THAT(ErrorOf(OnTwoDays(form, "2024-02-03", "2024-02-01")),
                HasSubstr("its times begin again at line 5"));
    EXPECT_EQ(ErrorOf(OnTwoDays(form, "02/01/2024", "02/03/2024")),
              "f.csv: line 5: the date changes from '02/01/2024' to '02/03/2024', and the number "
              "of days between them is not clear; write the dates as yyyy-mm-dd");
  }
}

TEST(ForeignTable, AnEarlierTimeOfALaterDayIsLater) {
  const Record record = Parsed(
      "timestamp,Coil (V)\n2024-02-01T10:00:00.5Z,1\n2024-02-01T10:00:01.0Z,2\n"
      "2024-02-03T09:00:00.5Z,3\n2024-02-03T09:00:01.0Z,4\n");
  ASSERT_EQ(record.rows, 4U);
  EXPECT_NEAR(TimeOf(record, 2) - TimeOf(record, 0), 47 * 3600, 1e-6);
}

TEST(ForeignTable, WhatIsMissingIsAskedFor) {
  EXPECT_THAT(ErrorOf("CH1,CH2\n0,1\n1,2\n"),
              HasSubstr("no column is a time and no line above states the sample interval"));
  EXPECT_THAT(ErrorOf("0,1\n1,2\n", {.columns = {"time_s"}}),
              HasSubstr("names 1 columns where f.csv has 2"));
  EXPECT_THAT(ErrorOf("0,1\n1,2\n", {.columns = {"time_s", "voltage_v"}, .scale_m = 1.0}),
              HasSubstr("no column is one; say <columns> time_s,displacement"));
  EXPECT_THAT(ErrorOf("0,1\n1,2\n", {.columns = {"time", "voltage_v"}}),
              HasSubstr("column 'time' does not state its unit"));
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
            "f.csv: has no two lines of numbers for <columns> to name; give a file with a row of "
            "numbers a line, separated by commas, semicolons, tabs or blanks");
}

TEST(ForeignTable, TimesAgainstAStatedRateAreADoubt) {
  for (const char* words : {"# nominal_rate_hz = 1000", "# sampling 1 kHz", "# rate = 1000 Hz",
                            "# sample_rate_hz = 1000"}) {
    Findings findings;
    const auto record =
        ParseCsv(std::string(words) + "\ntime_s,voltage_v\n0,1\n1,2\n2,3\n", "f", {}, &findings);
    ASSERT_TRUE(record);
    EXPECT_EQ(record->stretches.at(0).rate_hz, 1);
    ASSERT_EQ(findings.list().size(), 1) << words;
    EXPECT_EQ(NumbersOf(findings, FindingKind::kTimesInOtherUnit), "rate_hz=1 stated_hz=1000");
  }
  Findings findings;
  EXPECT_TRUE(ParseCsv("# rate = 1000 Hz\ntime_s,voltage_v\n0,1\n0.001,2\n", "f", {}, &findings));
  EXPECT_TRUE(ParseCsv("# drive 225 Hz\ntime_s,voltage_v\n0,1\n1,2\n", "f", {}, &findings));
  EXPECT_THAT(findings.list(), IsEmpty());
}

TEST(ForeignTable, TimesAndHeaderThatContradictEachOtherAreRefusedUntilTheRateIsSaid) {
  const std::string text = "Sample Interval,1e-3\nTime (s),CH1 (V)\n0,1\n1,2\n2,3\n";
  EXPECT_EQ(ErrorOf(text),
            "f.csv: its times give 1 rows per second and 'Sample Interval' gives 1000; give the "
            "right one as <rate>");
  EXPECT_REL(Parsed(text, {.rate_hz = 1000.0}).stretches.at(0).rate_hz, 1000, 1e-12, "header");
  EXPECT_REL(Parsed(text, {.rate_hz = 1.0}).stretches.at(0).rate_hz, 1, 1e-12, "times");
  EXPECT_THAT(ErrorOf(text, {.rate_hz = 7.0}), HasSubstr("<rate> gives 7 Hz"));
  EXPECT_THAT(ErrorOf("Sample Interval,1e-3\nSample Rate,1e6\nCH1 (V)\n1\n2\n"),
              HasSubstr("states two sample intervals: 0.001 s by 'Sample Interval' and 1e-06 s"));
}

TEST(ForeignTable, ARateThatIsSaidReplacesTheHeadersWhereThereAreNoTimes) {
  const std::string text = "Sample Interval,1e-3\nCH1 (V)\n1\n2\n3\n";
  EXPECT_REL(Parsed(text).stretches.at(0).rate_hz, 1000, 1e-12, "header");
  Findings findings;
  const auto record = ParseCsv(text, "f", {.rate_hz = 500.0}, &findings);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->stretches.at(0).rate_hz, 500);
  EXPECT_EQ(NumbersOf(findings, FindingKind::kRateReplaced),
            "rate_hz=500 stated_hz=1000 stated_by=Sample Interval");
}

// rows a step of 1 apart, in the unit in which they come at the rate that is said
TEST(ForeignTable, TheUnitOfTheTimesIsTheOneOfTheRateToOnePercent) {
  const std::string text = "Time,CH1 (V)\n0,1\n1,2\n2,3\n";
  for (const double rate_hz : {1.0, 1e3, 1e6, 1e9}) {
    EXPECT_REL(Parsed(text, {.rate_hz = rate_hz}).stretches.at(0).rate_hz, rate_hz, 1e-12,
               "one product");
    EXPECT_REL(Parsed(text, {.rate_hz = 1.0099 * rate_hz}).stretches.at(0).rate_hz, rate_hz, 1e-12,
               "one product");
    for (const double factor : {1.0101, 0.9899}) {
      EXPECT_THAT(ErrorOf(text, {.rate_hz = factor * rate_hz}),
                  HasSubstr("column 'Time' does not state its unit"));
    }
  }
}

TEST(ForeignTable, RowsThatTheHeaderPromisesAndDoesNotHoldAreADoubt) {
  const auto found = [](int stated) {
    Findings findings;
    EXPECT_TRUE(ParseCsv(fmt::format("Record Length,{}\nTime (s),CH1 (V)\n0,1\n1,2\n2,3\n", stated),
                         "f", {}, &findings));
    return NumbersOf(findings, FindingKind::kStatedRowsDiffer);
  };
  EXPECT_EQ(found(3), "none");
  EXPECT_EQ(found(4), "stated_rows=4 rows=3");
  EXPECT_EQ(found(2), "stated_rows=2 rows=3");
}

TEST(ForeignTable, IsLookedForInAThousandLines) {
  const auto is_found = [](int words) {
    std::string text;
    for (int i = 0; i < words; ++i) text += "word\n";
    const auto found = FindTableBeginning(text + "1,2\n3,4\n");
    EXPECT_TRUE(!found || found->line == static_cast<std::size_t>(words));
    return found.has_value();
  };
  EXPECT_TRUE(is_found(998));
  EXPECT_FALSE(is_found(999));
}

// 0, 1, ... above numbers that are not whole: a header where a number differs by 1 or more
TEST(ForeignTable, NumbersOfColumnsDifferByOneFromAReading) {
  const auto rows = [](const char* first) {
    const std::string text = fmt::format("0,1\n0.5,{}\n1.5,2.5\n2.5,2.5\n", first);
    return Parsed(text, {.columns = {"time_s", "displacement_mm"}}).rows;
  };
  EXPECT_EQ(rows("1.995"), 4U);
  EXPECT_EQ(rows("2.0"), 3U);
  EXPECT_EQ(rows("0.005"), 4U);
  EXPECT_EQ(rows("0.0"), 3U);
}

TEST(ForeignTable, AStatedUnitIsOfAllChannelsOrOfEachInTurn) {
  const auto first_values = [](const char* key, const char* names) {
    const Record record = Parsed(fmt::format("{}\nTime (s),{}\n0,1,2,3\n1,1,2,3\n", key, names));
    std::vector<double> values;
    for (const Channel& channel : record.channels) values.push_back(channel.values.at(0));
    return values;
  };
  EXPECT_THAT(first_values("Vertical Units,mV", "A,B,C"), ElementsAre(1e-3, 2e-3, 3e-3));
  EXPECT_THAT(first_values("Vertical Units,mV,V,kV", "A,B,C"), ElementsAre(1e-3, 2, 3e3));
  EXPECT_THAT(first_values("VUnit,mV,V,kV", "A (uV),B,C"), ElementsAre(1e-6, 2, 3e3));
  EXPECT_THAT(first_values("YUnits,mV,kV", "A,B,C"), ElementsAre(1e-3, 2e3, 3)) << "of two";
}

TEST(ForeignTable, AChannelIsChosenByANameOfItsOwn) {
  EXPECT_THAT(ErrorOf("Time (s),A (V),A (V)\n0,1,2\n1,3,4\n", {.channel = "a"}),
              HasSubstr("f.csv: has several channels called 'a' (its channels: A, A); give "
                        "<columns>, with - for the others"));
}

TEST(ForeignTable, TimesThatGoBackEverywhereAreNone) {
  std::string text;
  for (int k = 0; k < 100; ++k) text += fmt::format("{},{}\n", k * 7 % 10, k);
  EXPECT_THAT(ErrorOf(text, {.columns = {"time_s", "displacement_mm"}}),
              HasSubstr("the column is no time, or the rows are out of order; name "
                        "the columns in the order of the file (<columns>)"));
}

TEST(ForeignTable, TimesThatBeginAgainAreSegmentsOrRowsOutOfOrder) {
  const std::string text = "Time (s),CH1 (V)\n0,1\n1,2\n2,3\n0,4\n1,5\n2,6\n";
  EXPECT_EQ(ErrorOf(text),
            "f.csv: its times begin again at line 5: either 2 segments, whose times are not "
            "stated, or rows out of order; read one of them (<segment> 1 to 2), or sort the rows");
  EXPECT_EQ(Parsed(text, {.segment = 2}).channels.at(0).values, (std::vector<double>{4, 5, 6}));
  EXPECT_THAT(ErrorOf("Time (s),CH1 (V)\n0,1\n1,2\n0,4\n", {.segment = 2}),
              HasSubstr("line 4: is a segment of one row"));
}

TEST(ForeignTable, TimesThatRepeatWithoutAGridBehindThemAreRefused) {
  EXPECT_THAT(
      ErrorOf("Time (s),CH1 (V)\n0,1\n0,2\n1,3\n"),
      HasSubstr(
          "1 of 3 rows has the time of the row before (first in line 3), and no uniform grid"));
  std::string burst = "Time (s),CH1 (V)\n";
  for (int i = 0; i < 40; ++i) burst += i % 20 < 10 ? "0.001,1\n" : "";
  for (int i = 0; i < 40; ++i) burst += "0.5,1\n";
  EXPECT_THAT(ErrorOf(burst), HasSubstr("no uniform grid explains it"));
}

TEST(ForeignTable, EmptyRowsAtTheEndArePassedOverAndInTheMiddleNot) {
  EXPECT_EQ(Parsed("Time (s),CH1 (V)\n0,1\n1,2\n,,\n").rows, 2);
  EXPECT_EQ(Parsed("Time (s),CH1 (V)\n0,1\n1,2\n\n\n").rows, 2);
  EXPECT_THAT(ErrorOf("CH1 (V),CH2 (V)\n0,1\n1,2\n,\n3,4\n", {.rate_hz = 10.0}),
              HasSubstr("line 4: has empty cells alone between rows that have no times"));
}

TEST(ForeignTable, WhatASpreadsheetMadeOfANumberIsNamed) {
  EXPECT_THAT(
      ErrorOf("Time (s);CH1 (V)\n0;1,5\n1;2,5\n2;1.234.567\n"),
      HasSubstr("line 4: '1.234.567' is not a number (column 'CH1'): a spreadsheet may have"));
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

// --- lines above the rows ------------------------------------------------------------------------

TEST(ForeignTable, NamesAboveBlanksHaveASeparatorOfTheirOwn) {
  for (const char* names : {"Time (s)\tCH 1 A (V)", "Time (s);CH 1 A (V)", "Time (s),CH 1 A (V)",
                            "Time (s)  CH 1 A (V)", "Time (s)   CH 1 A (V)"}) {
    const Record record = Parsed(std::string(names) + "\n0 1\n1 2\n");
    ASSERT_EQ(record.channels.size(), 1U) << names;
    EXPECT_EQ(record.channels[0].name, "CH 1 A") << names;
    EXPECT_EQ(record.channels[0].role, ChannelRole::kVoltage);
  }
  // blanks give two cells too: "Time (s);CH" and "1 (V)"
  for (const char* names : {"Time (s)\tCH 1 (V)", "Time (s);CH 1 (V)", "Time (s),CH 1 (V)"}) {
    const Record record = Parsed(std::string(names) + "\n0 1\n1 2\n");
    ASSERT_EQ(record.channels.size(), 1U) << names;
    EXPECT_EQ(record.channels[0].name, "CH 1") << names;
  }
  // a comma within brackets separates nothing
  EXPECT_EQ(Parsed("Time(s) Position(x,y)\n0 1\n1 2\n").channels.at(0).name, "Position(x,y)");
  EXPECT_THAT(ErrorOf("Time (s) CH 1 (V)\n0 1\n1 2\n"), HasSubstr("no line names its 2 columns"));
}

TEST(ForeignTable, SeparatorsBehindTheNamesAndAnEmptyCommentAreNothing) {
  for (const char* head :
       {"Time (s),CH1 (V),,\n", "Time (s),CH1 (V)\n#\n", "Time (s),CH1 (V)\n# a,b\n",
        "Time (s),CH1 (V)\n# displacement,voltage\n"}) {
    const Record record = Parsed(std::string(head) + "0,1\n1,2\n");
    ASSERT_EQ(record.channels.size(), 1U) << head;
    EXPECT_EQ(record.channels[0].name, "CH1") << head;
  }
  // a comment with the name of a time is a header; words with an equals sign are a note
  EXPECT_EQ(Parsed("words\n# time, A (V)\n0,1\n1,2\n", {.rate_hz = 1.0}).channels.at(0).name, "A");
  const Record record = Parsed("a=b,5\nc,7\nTime (s),CH1 (V)\n0,1\n1,2\n");
  EXPECT_THAT(record.metadata.notes, ElementsAre("a=b,5"));
  EXPECT_EQ(record.metadata.fields.at("table.c"), "7");
}

// a line of numbers of another width or separator is none of the rows
TEST(ForeignTable, ALineOfNumbersUnlikeTheRowsBelongsToTheWords) {
  const ImportOptions two{.columns = {"time_s", "voltage_v"}};
  EXPECT_EQ(Parsed("0,1\n0;1\n1;2\n", two).rows, 2U);
  EXPECT_EQ(Parsed("0,1,2\n0,1\n1,2\n", two).rows, 2U);
}

TEST(ForeignTable, KeysStandBesideTwoRowsAtLeast) {
  const ImportOptions tds{.format = TableFormat::kTektronixTds};
  const Record record = Parsed(
      "Record Length,3,,0,1\nSource,CH2,,4,2\nYOffset,,,8,3\n,x,,12,4\n",
      {.columns = {"-", "-", "-", "time_s", "voltage_v"}, .format = TableFormat::kTektronixTds});
  EXPECT_EQ(record.metadata.fields.at("table.Source"), "CH2");
  EXPECT_FALSE(record.metadata.fields.contains("table.YOffset"));
  EXPECT_FALSE(record.metadata.fields.contains("table."));
  // a row without a number there has no key
  const Record later = Parsed("Record Length,3,,0,1\nSource,CH2,,4,2\nNote,x,,,3\nProbe,10,,12,4\n",
                              {.columns = {"-", "-", "-", "-", "voltage_v"},
                               .rate_hz = 1.0,
                               .format = TableFormat::kTektronixTds});
  EXPECT_EQ(later.rows, 4U);
  EXPECT_EQ(later.metadata.fields.at("table.Probe"), "10");
  EXPECT_FALSE(later.metadata.fields.contains("table.Note"));
  for (const char* text :
       {"Record Length,3,,x,1\nSource,CH2,,4,2\n", "Record Length,3,,0,1\nSource,CH2,,x,2\n",
        "Record Length,3,,0\n", "Record Length,3,,0,1\nSource,CH2,,4,2,7\n"}) {
    EXPECT_THAT(ErrorOf(std::string(text) + "\n", tds), HasSubstr("tektronix-tds")) << text;
  }
  // lines are counted from the file's first
  EXPECT_THAT(ErrorOf("Record Length,3,,0,1\nSource,CH2,,4,2\nNote,x,,8\n",
                      {.columns = {"-", "-", "-", "time_s", "voltage_v"},
                       .format = TableFormat::kTektronixTds}),
              HasSubstr("line 3"));
}

TEST(ForeignTable, ColumnsThatContradictEachOtherAreNone) {
  EXPECT_THAT(ErrorOf("Time (s),Time (s),CH1 (V)\n0,0,1\n1,1,2\n"),
              HasSubstr("two columns are times"));
  const std::string rows = "0,1,2\n1,3,4\n";
  // a scale is about a channel of its quantity, or about the only one
  EXPECT_THAT(ErrorOf(rows, {.columns = {"time_s", "a", "b"}, .scale_m = 2.0}),
              HasSubstr("is about a displacement, and no column is one"));
  const Record record = Parsed(rows, {.columns = {"time_s", "voltage", "b"}, .scale_v = 2.0});
  EXPECT_THAT(record.channels.at(0).values, ElementsAre(2, 6));
  EXPECT_THAT(record.channels.at(1).values, ElementsAre(2, 4));
  EXPECT_THAT(ErrorOf(rows, {.columns = {"time_s", "voltage", "b"}, .scale_m = 2.0}),
              HasSubstr("column 'voltage' does not state its unit"));
}

TEST(ForeignTable, StatusesOfAllStayBesideOneChannel) {
  const Record record =
      Parsed("time_s,voltage_v,current_a,status\n0,1,2,ok\n1,3,4,over\n", {.channel = "current"});
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kCurrent);
  EXPECT_EQ(record.channels[0].values[0], 2);
  EXPECT_EQ(record.channels[0].statuses[1], SampleStatus::kOver);
}

}  // namespace
}  // namespace haptometer::trial
