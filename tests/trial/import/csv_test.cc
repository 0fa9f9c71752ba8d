#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/export/export.h"
#include "trial/import/readers.h"
#include "trial/import/table/csv_header.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Record Parsed(std::string_view text) {
  auto record = ParseCsv(text, "f.csv");
  EXPECT_TRUE(record) << record.error().Text();
  return record ? std::move(*record) : Record{};
}

std::string ErrorOf(std::string_view text) {
  const auto record = ParseCsv(text, "f.csv");
  if (record) return "was read";
  EXPECT_EQ(record.error().cause, Cause::kCannotAnswer);
  EXPECT_FALSE(record.error().remedy.empty());
  return record.error().Text();
}

std::string Exported(const Record& record) {
  std::string text;
  EXPECT_TRUE(WriteCsv(record, [&](std::string_view piece) -> Result<void> {
    text += piece;
    return {};
  }));
  return text;
}

TEST(Csv, RolesAndUnitsComeFromTheNames) {
  const Record record = Parsed(
      "Time_ms,displacement_um,voltage_mV,current_a,displacement_2_mm,trigger,pressure\n"
      "0,1,2,3,4,1,5\n"
      "0.5,-1,2,3,4,0,5\n");
  ASSERT_EQ(record.channels.size(), 6);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_EQ(record.channels[0].unit, "m");
  EXPECT_REL(record.channels[0].values[1], -1e-6, 1e-15, "one product");
  EXPECT_REL(record.channels[1].values[0], 2e-3, 1e-15, "one product");
  EXPECT_EQ(record.Find(ChannelRole::kCurrent)->values[0], 3);
  EXPECT_EQ(record.channels[3].role, ChannelRole::kDisplacement);
  EXPECT_REL(record.channels[3].values[0], 4e-3, 1e-15, "one product");
  EXPECT_EQ(record.channels[4].role, ChannelRole::kTrigger);
  EXPECT_EQ(record.channels[5].role, ChannelRole::kOther);
  EXPECT_EQ(record.channels[5].name, "pressure");
  EXPECT_REL(record.stretches.at(0).rate_hz, 2000, 1e-15, "printed times");
}

TEST(Csv, CommentLinesLandInTheMetadata) {
  const Record record = Parsed(
      "\xef\xbb\xbf# case = held\r\n# load_ohm = inf\r\n#drive_frequency_hz=225\r\n"
      "# averages = 16\r\n# label.subject = 3\r\n# made by hand\r\n\r\n"
      "time_s,voltage_v\r\n0,1\r\n1,2\r\n# end\r\n");
  EXPECT_EQ(record.metadata.fields.at("case"), "held");
  EXPECT_EQ(record.metadata.fields.at("load_ohm"), "inf");
  EXPECT_EQ(record.metadata.drive_frequency_hz, 225);
  EXPECT_EQ(record.metadata.averages, 16);
  EXPECT_EQ(record.metadata.labels.at("subject"), "3");
  EXPECT_EQ(record.metadata.notes, (std::vector<std::string>{"made by hand", "end"}));
  EXPECT_EQ(record.metadata.source, "imported");
  EXPECT_EQ(record.rows, 2);
}

TEST(Csv, SemicolonsTabsAndDecimalCommas) {
  for (const char* text :
       {"time_s;voltage_v\n0,0;1,5\n0,5;-2e-3\n", "time_s\tvoltage_v\n0,0\t+1,5\n0.5\t-2e-3\n",
        "\"time_s\", \"voltage_v\"\n0, 1.5\n 0.5 ,\"-2e-3\""}) {
    const Record record = Parsed(text);
    ASSERT_EQ(record.rows, 2);
    EXPECT_EQ(record.channels[0].values[0], 1.5);
    EXPECT_EQ(record.channels[0].values[1], -2e-3);
    EXPECT_EQ(TimeOf(record, 1), 0.5);
  }
}

TEST(Csv, EmptyCellsAndNanAreInvalidAndStatusesAreRead) {
  const Record record = Parsed(
      "time_s,displacement_m,voltage_v,status_1\n"
      "0,1,,ok\n1,nan,2,ok\n2,3,inf,over\n3,4,4,repeated\n4,,5,late\n");
  const auto& displacement = record.channels[0];
  using enum SampleStatus;
  EXPECT_EQ(displacement.statuses,
            (std::vector<SampleStatus>{kOk, kInvalid, kOver, kRepeated, kLate}));
  EXPECT_TRUE(std::isnan(displacement.values[2]));
  EXPECT_EQ(displacement.values[3], 4);
  EXPECT_EQ(record.channels[1].statuses,
            (std::vector<SampleStatus>{kInvalid, kOk, kOver, kOk, kOk}));
  const Record all = Parsed("time_s,displacement_m,voltage_v,status\n0,1,1,under\n1,1,1,ok\n");
  EXPECT_EQ(all.channels[1].statuses[0], kUnder);
  EXPECT_EQ(all.channels[0].statuses[0], kUnder);
}

// times n / rate printed with `format`
std::string Printed(double rate_hz, int rows, const char* format) {
  std::string text = "time_s,voltage_v\n";
  for (int i = 0; i < rows; ++i) text += fmt::format(fmt::runtime(format), i / rate_hz) + ",0\n";
  return text;
}

TEST(Csv, WordsInPlaceOfANumberAreStatuses) {
  std::string text = "time_s,displacement_mm\n0,1\n";
  std::vector<SampleStatus> statuses{SampleStatus::kOk};
  const auto add = [&](std::initializer_list<const char*> words, SampleStatus status) {
    for (const char* word : words) {
      text += fmt::format("{},{}\n", statuses.size(), word);
      statuses.push_back(status);
    }
  };
  add({"OVER", "ol", "inf", "1.#INF", "+FFFFFFF"}, SampleStatus::kOver);
  add({"-OVER", "-inf", "-1.#INF", "-FFFFFFF"}, SampleStatus::kUnder);
  add({"", "NaN", "nan", "-nan", "1.#QNAN", "-1.#IND", "null", "None", "NA", "----", "--.--"},
      SampleStatus::kInvalid);
  // the same in a table of another program
  for (const char* head : {"time_s,displacement_mm", "Time (s),Laser (mm)"}) {
    const Record record = Parsed(std::string(head) + text.substr(text.find('\n')) + "100,2\n");
    EXPECT_EQ(record.channels.at(0).values.back(), 2e-3);
    auto read = record.channels[0].statuses;
    read.pop_back();
    EXPECT_EQ(read, statuses) << head;
  }
  EXPECT_THAT(ErrorOf("time_s,displacement_mm\n0,1\n1,.\n"), HasSubstr("'.' is not a number"));
}

TEST(Csv, GridsAreRebuiltWhereThePrintedDigitsExplainTheTimes) {
  for (const char* format : {"{}", "{:.6f}", "{:.4f}", "{:g}", "{:.3e}", "{:.9e}"}) {
    const Record record = Parsed(Printed(3000, 998, format));
    ASSERT_EQ(record.stretches.size(), 1) << format;
    EXPECT_TRUE(record.raw_times_s.empty()) << format;
    EXPECT_REL(record.stretches[0].rate_hz, 3000, 2e-4, "half of the fourth decimal over 0.33 s");
  }
  EXPECT_REL(Parsed(Printed(3000, 1000, "{}")).stretches[0].rate_hz, 3000, 1e-15, "whole doubles");
}

TEST(Csv, OtherTimesAreKeptBesideTheirMeanLine) {
  std::string text = "time_s,voltage_v\n";
  for (int i = 0; i < 100; ++i) text += fmt::format("{:.6f},0\n", i * 1e-2 + (i % 3) * 1e-4);
  const Record record = Parsed(text);
  ASSERT_EQ(record.raw_times_s.size(), 100);
  EXPECT_EQ(record.raw_times_s[1], 0.0101);
  EXPECT_REL(record.stretches.at(0).rate_hz, 100, 1e-5, "jitter of 0.1 ms over 1 s");
  EXPECT_REL(record.stretches[0].time_uncertainty_s, 0.82e-4, 0.02, "sqrt(2/3) of 0.1 ms");
}

// the host stalls for 1.5 s of 4: what waited arrives at once, and lies on the line that is stated
TEST(Csv, AStallOfTheHostKeepsTheStatedLines) {
  std::string text = "# times = arrived\n# stretch = 0 400 0 100 1e-6\ntime_s,displacement_m\n";
  for (int row = 0; row < 400; ++row) {
    const double time_s = row >= 100 && row < 250 ? 2.5 : row * 0.01;
    text += fmt::format("{:.3f},{}\n", time_s, row % 7);
  }
  const Record record = Parsed(text);
  ASSERT_EQ(record.stretches.size(), 1U);
  EXPECT_EQ(record.stretches[0].rate_hz, 100);
  EXPECT_EQ(record.stretches[0].time_uncertainty_s, 1e-6) << "as stated, not fitted";
}

TEST(Csv, LinesOfOneBurstShareTheirArrivalTime) {
  const std::string rows = "time_s,displacement_m\n0,1\n0,2\n0.002,3\n0.002,4\n0.004,5\n";
  const Record record = Parsed("# times = arrived\n# stretch = 0 5 0 1000 1e-6\n" + rows);
  EXPECT_EQ(record.rows, 5U);
  EXPECT_EQ(record.timing, Timing::kArrival);
  EXPECT_EQ(record.raw_times_s, (std::vector<double>{0, 0, 0.002, 0.002, 0.004}));
  EXPECT_EQ(record.stretches.at(0).rate_hz, 1000);
  EXPECT_FALSE(ParseCsv(rows, "f.csv")) << "a clocked source's times grow";
}

TEST(Csv, GapsBecomeStretches) {
  std::string text = "time_s,voltage_v\n";
  for (int i = 0; i < 100; ++i) {
    if (i != 30 && (i < 70 || i >= 90)) text += fmt::format("{:.3f},0\n", i * 1e-3);
  }
  const Record record = Parsed(text);
  EXPECT_TRUE(record.raw_times_s.empty());
  ASSERT_EQ(record.stretches.size(), 3);
  EXPECT_EQ(record.stretches[1].first_row, 30);
  EXPECT_EQ(record.stretches[1].start_s, 0.031);
  EXPECT_EQ(record.stretches[2].first_row, 69);
  for (const Stretch& stretch : record.stretches) {
    EXPECT_REL(stretch.rate_hz, 1000, 1e-15, "one clock for all");
  }
}

TEST(Csv, WhatCannotBeReadIsExplained) {
  EXPECT_EQ(ErrorOf("0,1\n1,2\n"),
            "f.csv: no line names its 2 columns: the first may be a time (1 rows per second in s, "
            "1000 in ms) or a channel like the others; give <columns> time_s,voltage_v, or "
            "<columns> voltage_v,voltage_2_v with <rate>, or <columns> sample,voltage_v where it "
            "numbers the rows");
  EXPECT_THAT(ErrorOf("name,age\nbob,3\n"), HasSubstr("no time column"));
  EXPECT_EQ(ErrorOf("time,voltage_v\n0,1\n"),
            "f.csv: column 'time' does not state its unit; name it time_s, time_ms or time_us");
  EXPECT_THAT(ErrorOf("time_s,displacement\n0,1\n"), HasSubstr("name it displacement_m, displ"));
  EXPECT_THAT(ErrorOf("time_s,voltage_mm\n0,1\n"), HasSubstr("name it voltage_v"));
  EXPECT_THAT(ErrorOf("time_s\n0\n1\n"), HasSubstr("no column beside the time"));
  EXPECT_THAT(ErrorOf("time_s,time_ms,voltage_v\n0,1\n"), HasSubstr("two columns are named time"));
  EXPECT_THAT(ErrorOf("time_s,voltage_v,status_2\n0,1,ok\n"), HasSubstr("is not there"));
  EXPECT_EQ(ErrorOf("time_s,voltage_v\n0,1\n1,abc\n"),
            "f.csv: line 3: 'abc' is not a number (column 'voltage'); leave the cell empty where "
            "there is no value, or remove the column");
  EXPECT_EQ(ErrorOf("# a\n\ntime_s,voltage_v\n0,1\n1,2,3\n"),
            "f.csv: line 5: has 3 cells where the columns are 2; complete or remove the line");
  EXPECT_EQ(ErrorOf("time_s,voltage_v\n0,1\n1,2\n1,3\n"),
            "f.csv: 1 of 3 rows has the time of the row before (first in line 4), and no uniform "
            "grid explains it; print the times with more digits, or remove these rows; only where "
            "no row is missing, leave the times out (<columns>) and give <rate>");
  EXPECT_EQ(ErrorOf("time_s,voltage_v\n0,1\n1,2\n0.5,3\n"),
            "f.csv: line 4: time 0.5 s does not grow (the row before is at 1 s); sort the rows, or "
            "print the times with more digits");
  EXPECT_THAT(ErrorOf("time_s,voltage_v\n0,1\nnan,2\n"), HasSubstr("line 3: 'nan' is not a time"));
  EXPECT_THAT(ErrorOf("time_s,voltage_v\n0,1\n,2\n"), HasSubstr("line 3: '' is not a time"));
  EXPECT_THAT(ErrorOf("time_s,voltage_v\n0,1\n"), HasSubstr("holds 1 row; a measurement needs"));
  EXPECT_THAT(ErrorOf("time_s,voltage_v\n"), HasSubstr("holds 0 rows"));
  EXPECT_THAT(ErrorOf("# only = comments\n"), HasSubstr("holds no columns"));
  EXPECT_THAT(ErrorOf("time_s,voltage_v,status\n0,1,fine\n"), HasSubstr("'fine' is not a status"));
  EXPECT_EQ(ErrorOf("# averages = many\ntime_s,voltage_v\n0,1\n"),
            "f.csv: line 1: 'averages = many' is not a number; write a plain number in the unit "
            "that the key names");
}

TEST(Csv, EditedExportsAreNotTrustedToTheirStretchLines) {
  std::string text = Exported(Parsed(Printed(1000, 50, "{}")));
  EXPECT_THAT(text, HasSubstr("# stretch = 0 50 0 "));
  const std::size_t row = text.find("\n0.01,");
  text.erase(row, text.find('\n', row + 1) - row);
  const Record edited = Parsed(text);
  EXPECT_EQ(edited.rows, 49);
  EXPECT_EQ(edited.stretches.size(), 2);
}

TEST(Csv, AnExportSaysWhatThereIs) {
  const Record record = Parsed("time_ms,displacement_um,status\n0,1,ok\n500,,late\n1000,3,ok\n");
  EXPECT_EQ(Exported(record),
            "# source = imported\n# times = grid\n# stretch = 0 3 0 2 0\n"
            "# channel.1.name = displacement\n"
            "time_s,displacement_m,status\n0,1e-06,ok\n0.5,,late\n1,3e-06,ok\n");
}

TEST(Csv, EachPrefixOfAUnitIsItsFactor) {
  const Record record = Parsed(
      "time_ns,displacement_nm,displacement_2_cm,current_ma,current_2_ua,voltage_uv,voltage_2_kv\n"
      "0,1,2,3,4,5,6\n500,1,2,3,4,5,6\n");
  ASSERT_EQ(record.channels.size(), 6U);
  const std::vector<double> factors{1e-9, 1e-2, 1e-3, 1e-6, 1e-6, 1e3};
  for (std::size_t c = 0; c < factors.size(); ++c) {
    EXPECT_REL(record.channels[c].values[0], static_cast<double>(c + 1) * factors[c], 4e-16,
               "one product");
  }
  EXPECT_EQ(record.channels[2].role, ChannelRole::kCurrent);
  EXPECT_EQ(record.channels[2].unit, "A");
  EXPECT_REL(record.stretches.at(0).rate_hz, 2e6, 1e-15, "printed times");
}

TEST(Csv, NumbersOfTheMetadataAreRead) {
  const Record record = Parsed(
      "# sampling_s = 1e-4\n# nominal_rate_hz = 2\n# drive_frequency_hz = 225\n"
      "# drive_amplitude_v = 1.5\n# tare_m = -0.25\n# averages = "
      "1\ntime_s,voltage_v\n0,1\n0.5,2\n");
  EXPECT_EQ(record.metadata.sampling_s, 1e-4);
  EXPECT_EQ(record.metadata.nominal_rate_hz, 2);
  EXPECT_EQ(record.metadata.drive_frequency_hz, 225);
  EXPECT_EQ(record.metadata.drive_amplitude_v, 1.5);
  EXPECT_EQ(record.metadata.tare_m, -0.25);
  EXPECT_EQ(record.metadata.averages, 1);
}

TEST(Csv, AveragesAreAWholeNumberUpToABillion) {
  const auto text = [](const char* averages) {
    return fmt::format("# averages = {}\ntime_s,voltage_v\n0,1\n1,2\n", averages);
  };
  EXPECT_EQ(Parsed(text("1e9")).metadata.averages, 1'000'000'000);
  for (const char* averages : {"0", "-1", "1.5", "1000000001"}) {
    EXPECT_THAT(
        ErrorOf(text(averages)),
        HasSubstr(fmt::format("'averages = {}' is no count of readings; write a whole number "
                              "from 1 to 1000000000",
                              averages)));
  }
  for (const char* averages : {"nan", "inf"}) {
    EXPECT_THAT(ErrorOf(text(averages)),
                HasSubstr(fmt::format("'averages = {}' is not a number", averages)));
  }
}

TEST(Csv, WhatIsSaidOfAChannelIsKept) {
  const Record record = Parsed(
      "# channel.1.unit = N\n# channel.1.range_min = -0.5\n# channel.1.range_max = 0.75\n"
      "# channel.1.resolution = 1e-6\n# channel.2.unit = N\n# channel.2.range_min = low\n"
      "time_s,force,voltage_v\n0,1,2\n1,2,3\n");
  EXPECT_EQ(record.channels.at(0).unit, "N");
  EXPECT_EQ(record.channels[0].range_min, -0.5);
  EXPECT_EQ(record.channels[0].range_max, 0.75);
  EXPECT_EQ(record.channels[0].resolution, 1e-6);
  EXPECT_EQ(record.channels.at(1).unit, "V") << "its name states it";
  EXPECT_EQ(record.channels[1].range_min, -std::numeric_limits<double>::infinity());
}

// --- a column that looks like the times ----------------------------------------------------------

// times that fall at once, above eight or fewer rows in whose second column numbers grow by 1 from
// 3 on, but for the fifth, which is `late`
std::string FallingTimes(int rows_below, double late) {
  std::string text = "time_s,displacement_m,voltage_v\n9,0,0.5\n8,1,0.5\n";
  for (int i = 0; i < rows_below; ++i) {
    text += fmt::format("{},{},0.5\n", 7 - i, 3 + (i == 4 ? i + late : i));
  }
  return text;
}

TEST(Csv, AColumnThatGrowsEvenlyIsNamedWhereTheTimesFall) {
  constexpr const char* kHint =
      "time 8 s does not grow (the row before is at 9 s); column 2 grows in even steps as times do";
  // steps of 1 s to 5 %, in eight rows
  EXPECT_THAT(ErrorOf(FallingTimes(8, 0.0495)), HasSubstr(kHint));
  EXPECT_THAT(ErrorOf(FallingTimes(8, -0.0495)), HasSubstr(kHint));
  EXPECT_THAT(ErrorOf(FallingTimes(8, 0.0505)), HasSubstr("sort the rows"));
  EXPECT_THAT(ErrorOf(FallingTimes(8, -0.0505)), HasSubstr("sort the rows"));
  EXPECT_THAT(ErrorOf(FallingTimes(7, 0)), HasSubstr("sort the rows"));
  // the last column, with and without an end of the last line
  std::string two = "time_s,displacement_m\n";
  for (int i = 0; i < 10; ++i) two += fmt::format("{},{}\n", 9 - i, i);
  EXPECT_THAT(ErrorOf(two), HasSubstr("column 2 grows in even steps"));
  two.pop_back();
  EXPECT_THAT(ErrorOf(two), HasSubstr("column 2 grows in even steps"));
}

TEST(Csv, TheColumnOfTheTimesIsNotTheOneThatLooksLikeThem) {
  // below the fall the times grow evenly themselves
  std::string text = "time_s,displacement_m,voltage_v\n9,0,7\n";
  for (int i = 0; i < 9; ++i) text += fmt::format("{},{},{}\n", i, i * i, 7 - i);
  EXPECT_THAT(ErrorOf(text), HasSubstr("time 0 s does not grow (the row before is at 9 s); sort "
                                       "the rows"))
      << "neither squares nor a column that falls";
}

TEST(Csv, AUnitThatTheColumnsReplaceIsFoundWithBothFactors) {
  const std::string text = "Time (s),Laser (um),Coil (V),Grip\n0,1,2,3\n1,2,3,4\n";
  const auto found = [&](const std::vector<std::string>& columns) {
    Findings findings;
    EXPECT_TRUE(ParseCsv(text, "f.csv", {.columns = columns}, &findings));
    return tests::NumbersOf(findings, FindingKind::kUnitOverridden);
  };
  EXPECT_EQ(found({"time_s", "displacement_mm", "voltage_v", "grip"}),
            "column=2 file_factor=1e-06 file_unit=m given_factor=0.001 given_unit=m");
  EXPECT_EQ(found({"time_ms", "displacement_um", "voltage_v", "grip"}),
            "column=1 file_factor=1 file_unit=s given_factor=0.001 given_unit=s");
  EXPECT_EQ(found({"time_s", "displacement_um", "current_a", "-"}),
            "column=3 file_factor=1 file_unit=V given_factor=1 given_unit=A");
  EXPECT_EQ(found({"time_s", "laser", "-", "voltage_v"}), "none");
}

TEST(Csv, AUnitThatIsNotKnownIsDoubtedAsOthersAre) {
  const auto found = [](const std::string& header, const ImportOptions& options) {
    Findings findings;
    EXPECT_TRUE(ParseCsv(header + "\n0,1\n1,2\n", "f.csv", options, &findings)) << header;
    EXPECT_LE(tests::DoubtsOf(findings).size(), 1U);
    return tests::NumbersOf(findings, FindingKind::kUnitOverridden);
  };
  const ImportOptions told{.columns = {"time_s", "displacement_um"}};
  for (const char* unit : {"mm/s", "m/s^2", "N", "a.u.", "in"}) {
    const std::string numbers =
        fmt::format("column=2 unknown_unit={} given_factor=1e-06 given_unit=m", unit);
    EXPECT_EQ(found(fmt::format("Time (s),Laser ({})", unit), told), numbers);
    EXPECT_EQ(found(fmt::format("Time,Laser\n(s),({})", unit), told), numbers);
  }
  EXPECT_EQ(found("Time (s),Laser (mil)", told),
            "column=2 file_factor=2.54e-05 file_unit=m given_factor=1e-06 given_unit=m");
  // no unit, words, Siglent's word for none, and a channel that is told no unit
  for (const char* header : {"Time (s),Laser", "Time (s),Laser (left side)",
                             "Time (s),Laser (filtered)", "Time (s),Laser [CH1]", "Second,Value"}) {
    EXPECT_EQ(found(header, told), "none") << header;
  }
  EXPECT_EQ(found("Time (s),Laser (N)", {.columns = {"time_s", "force"}}), "none");
  EXPECT_EQ(
      found("Time (s),Laser (counts)", {.columns = {"time_s", "displacement"}, .scale_m = 2e-6}),
      "none")
      << "the scale states what a count is";
}

// --- one meaning of time_s -----------------------------------------------------------------------

// a record of three rows, whose raw times lie beside a straightened grid
Record Straightened(Timing timing) {
  Record record = Parsed("time_s,displacement_m\n0,1\n0.25,2\n0.5,3\n");
  record.timing = timing;
  record.stretches = {{.rows = 3, .start_s = 0.125, .rate_hz = 4, .time_uncertainty_s = 1e-3}};
  record.raw_times_s = {0.13, 0.36, 0.63};
  return record;
}

TEST(Csv, ArrivalTimesStandBesideTheStraightenedOnes) {
  for (const Timing timing : {Timing::kArrival, Timing::kPolled}) {
    const Record record = Straightened(timing);
    const std::string text = Exported(record);
    EXPECT_THAT(text, HasSubstr("\ntime_s,arrival_s,displacement_m\n0.125,0.13,1\n0.375,0.36,2\n"
                                "0.625,0.63,3\n"));
    const Record again = Parsed(text);
    EXPECT_EQ(again.timing, timing);
    EXPECT_EQ(again.raw_times_s, record.raw_times_s);
    ASSERT_EQ(again.stretches.size(), 1);
    for (std::size_t row = 0; row < 3; ++row) EXPECT_EQ(TimeOf(again, row), TimeOf(record, row));
    ASSERT_EQ(again.channels.size(), 1) << "an arrival time is no channel";
    EXPECT_EQ(Exported(again), text);
  }
}

TEST(Csv, TimesThatAreKnownAreTheTimes) {
  Record record = Straightened(Timing::kPolled);
  record.times_are_known = true;
  const std::string text = Exported(record);
  EXPECT_THAT(text, HasSubstr("\ntime_s,displacement_m\n0.13,1\n0.36,2\n0.63,3\n"));
  const Record again = Parsed(text);
  EXPECT_TRUE(again.times_are_known);
  EXPECT_EQ(again.raw_times_s, record.raw_times_s);
  EXPECT_EQ(Exported(again), text);
}

TEST(Csv, ExportsOfEarlierVersionsAreReadAsTheyWere) {
  const Record record = Parsed(
      "# times = polled\n# stretch = 0 3 0.125 4 0.001\ntime_s,displacement_m\n0.13,1\n0.36,2\n"
      "0.63,3\n");
  EXPECT_EQ(record.timing, Timing::kPolled);
  EXPECT_EQ(record.raw_times_s, (std::vector<double>{0.13, 0.36, 0.63}));
  EXPECT_EQ(TimeOf(record, 1), 0.375);
}

TEST(Csv, ArrivalTimesWithoutAWordOnTheirKindAreLeftOut) {
  const Record record = Parsed("time_s,arrival_s,displacement_m\n0,0.01,1\n0.5,0.56,2\n1,1.02,3\n");
  EXPECT_TRUE(record.raw_times_s.empty());
  EXPECT_EQ(record.stretches.at(0).rate_hz, 2);
  EXPECT_EQ(record.channels.size(), 1);
}

// bounded before any of it is split, so that the memory is a small multiple of the text
TEST(CsvBounds, LinesOfTooManyCellsOrBytesAreRefusedWithTheirPlace) {
  const auto told = [](const std::string& text) {
    const auto record = ParseCsv(text, "x.csv");
    return record ? std::string() : record.error().Text();
  };
  const std::string rows = "time_s,displacement_m\n0,1\n1e-3,2\n";
  for (const char separator : {',', ';', '\t'}) {
    EXPECT_EQ(told(rows + std::string(kMostColumns, separator) + "\n"),
              "x.csv: line 4: has more than 4096 columns; is it a table of measurements?");
  }
  EXPECT_EQ(told(std::string(kMostLineBytes + 1, 'a') + rows),
            "x.csv: line 1: is longer than 1 MiB; is it a table of measurements?");
  std::string comments;
  for (std::size_t k = 0; k <= kMostHeaderLines; ++k) comments += "# a\n";
  EXPECT_EQ(told(comments + rows),
            "x.csv: line 100001: is the last of more than 100000 comments; is it a table of "
            "measurements?");
  EXPECT_EQ(told("# " + std::string(kMostLineBytes - 2, ',').substr(0, 4000) + "\n" + rows), "");
}

TEST(CsvBounds, AWideTableIsRead) {
  std::string header = "time_s";
  std::string first = "0";
  std::string second = "1e-3";
  for (int k = 0; k < 1000; ++k) {
    header += fmt::format(",ch{}_v", k);
    first += ",1";
    second += ",2";
  }
  const auto record = ParseCsv(header + "\n" + first + "\n" + second + "\n", "x.csv");
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_EQ(record->channels.size(), 1000U);
}

// columns times blank lines would be far more memory than the text
TEST(CsvBounds, BlankLinesReserveNoRows) {
  std::string blank;
  blank.resize(30'000'000, '\n');
  std::string header = "time_s";
  std::string row = "0";
  for (int k = 0; k < 4000; ++k) {
    header += fmt::format(",ch{}_v", k);
    row += ",1";
  }
  const auto record =
      ParseCsv(header + "\n" + row + "\n1e-3" + row.substr(1) + "\n" + blank, "x.csv");
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_EQ(record->rows, 2U);
}

// --- names, comments and rows --------------------------------------------------------------------

TEST(CsvNames, AStatusHasTheNumberOfAChannelFromOneOn) {
  const auto column = [](const char* cell) { return ReadCsvColumn(cell, "f").value(); };
  EXPECT_EQ(column("Status_12").kind, CsvColumnKind::kStatus);
  EXPECT_EQ(column("status_12").channel, 12U);
  EXPECT_EQ(column("status").channel, 0U);
  for (const char* cell : {"status_0", "status_", "status_x", "status_2x", "status_-1"}) {
    EXPECT_EQ(column(cell).kind, CsvColumnKind::kValue) << cell;
    EXPECT_EQ(column(cell).name, cell);
  }
  EXPECT_THAT(ErrorOf("time_s,arrival_s,arrival_s,voltage_v\n0,1,1,2\n1,2,2,3\n"),
              HasSubstr("two columns are named arrival_s"));
}

TEST(CsvNames, AQuantityInAnotherUnitHasANumberAlone) {
  const auto channel = [](ChannelRole role, const char* unit) {
    Channel made;
    made.role = role;
    made.unit = unit;
    return made;
  };
  using enum ChannelRole;
  EXPECT_THAT(
      CsvColumnNames({channel(kDisplacement, "m"), channel(kDisplacement, "mm"),
                      channel(kDisplacement, "m"), channel(kVoltage, "V"), channel(kCurrent, "mA"),
                      channel(kTrigger, ""), channel(kTrigger, "V"), channel(kOther, "V"),
                      channel(kCurrent, "A")}),
      ElementsAre("displacement_m", "channel_2", "displacement_3_m", "voltage_v", "channel_5",
                  "trigger", "trigger_2", "channel_8", "current_2_a"));
}

TEST(CsvComments, NumbersOfTheMetadataAreFinite) {
  for (const char* line : {"# sampling_s = often", "# nominal_rate_hz = inf",
                           "# drive_amplitude_v = nan", "# tare_m = none", "# averages = inf"}) {
    CsvComments comments;
    const auto read = ReadCsvComment(line, "f: line 1", &comments);
    ASSERT_FALSE(read) << line;
    EXPECT_EQ(read.error().Text(), fmt::format("f: line 1: '{}' is not a number; write a plain "
                                               "number in the unit that the key names",
                                               line + 2));
  }
}

TEST(CsvComments, EachFactOfTheMetadataHasALine) {
  Metadata metadata;
  EXPECT_EQ(CsvMetadataLines(metadata), "");
  metadata.sampling_s = 0.1;
  metadata.drive_frequency_hz = 225;
  metadata.averages = 16;
  metadata.tare_m = -1e-3;
  metadata.labels["subject"] = "S1";
  metadata.fields["case"] = "held";
  metadata.fields["nothing"] = "";
  metadata.notes = {"one"};
  EXPECT_EQ(CsvMetadataLines(metadata),
            "# sampling_s = 0.1\n# drive_frequency_hz = 225\n# averages = 16\n# tare_m = -0.001\n"
            "# label.subject = S1\n# case = held\n# note = one\n");
  CsvComments comments;
  ASSERT_TRUE(ReadCsvComment("# note = one", "f", &comments));
  ASSERT_TRUE(ReadCsvComment("#  two ", "f", &comments));
  EXPECT_THAT(comments.metadata.notes, ElementsAre("one", "two"));
}

TEST(Csv, AScaleAloneReadsTheFileAnew) {
  const std::string text = "time_s,a\n0,1\n1,2\n";
  for (const bool is_metres : {true, false}) {
    ImportOptions options;
    (is_metres ? options.scale_m : options.scale_v) = 3.0;
    const auto record = ParseCsv(text, "f", options);
    ASSERT_TRUE(record) << record.error().Text();
    EXPECT_EQ(record->channels.at(0).unit, is_metres ? "m" : "V");
    EXPECT_EQ(record->channels[0].values[1], 6);
  }
  Findings findings;
  ASSERT_TRUE(ParseCsv("Time (s),A (mm)\n0,1\n1,2\n", "f", {.scale_m = 2.0}, &findings));
  EXPECT_EQ(tests::NumbersOf(findings, FindingKind::kUnitOverridden),
            "column=2 file_factor=0.001 file_unit=m given_factor=2 given_unit=m");
}

// rows of another width below a time that falls show no column of times
TEST(Csv, ARowOfAnotherWidthEndsTheSearchForTheTimes) {
  std::string text = "time_s,displacement_m\n";
  for (int i = 0; i < 10; ++i) text += fmt::format("{},{}\n", 9 - i, i);
  EXPECT_THAT(ErrorOf(text), HasSubstr("column 2 grows in even steps"));
  text.replace(text.find("3,6"), 3, "3,6,0");
  EXPECT_THAT(ErrorOf(text), HasSubstr("does not grow (the row before is at 9 s); sort the rows"));
}

}  // namespace
}  // namespace haptometer::trial
