// Tables that came as numbers: names, statuses, times and what of them is refused.
#include "trial/import/number_table.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"
#include "tests/trial/trial_file.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Columns = std::vector<NumberColumn>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Result<Recording> Read(Columns columns, const ImportOptions& options = {},
                       std::optional<double> rate_hz = {}) {
  return ReadNumberTable({.columns = std::move(columns), .rate_hz = rate_hz}, FileKind::kNpy, "f",
                         options);
}

Recording Parsed(Columns columns, const ImportOptions& options = {},
                 std::optional<double> rate_hz = {}) {
  auto recording = Read(std::move(columns), options, rate_hz);
  EXPECT_TRUE(recording) << recording.error().Text();
  return recording ? std::move(*recording) : Recording{};
}

std::string ErrorOf(Columns columns, const ImportOptions& options = {},
                    std::optional<double> rate_hz = {}) {
  const auto recording = Read(std::move(columns), options, rate_hz);
  return recording ? "was read" : recording.error().Text();
}

const NumberColumn kTimes{.name = "time_s", .values = {0, 0.25, 0.5}};
const NumberColumn kLaser{.name = "displacement_mm", .values = {1, 2, 3}};

TEST(NumberTable, NamesCarryRoleUnitAndFactor) {
  const Recording read = Parsed({kTimes, kLaser, {.name = "pressure", .values = {7, 8, 9}}});
  const Record& record = read.record;
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_EQ(record.channels[0].unit, "m");
  EXPECT_THAT(record.channels[0].values, ElementsAre(1e-3, 2e-3, 3e-3));
  EXPECT_EQ(record.channels[1].role, ChannelRole::kOther);
  EXPECT_THAT(record.channels[1].values, ElementsAre(7, 8, 9));
  EXPECT_EQ(record.stretches.at(0).rate_hz, 4);
  EXPECT_EQ(read.report.rows, 3U);
  EXPECT_EQ(read.report.next_row, 3U);
  EXPECT_TRUE(read.report.closed);
  EXPECT_FALSE(read.report.is_export);
}

TEST(NumberTable, ThereIsOneRowForEachColumnAndTwoAtLeast) {
  EXPECT_EQ(ErrorOf({}), "f: holds no column of numbers");
  EXPECT_THAT(ErrorOf({kTimes, {.name = "a", .values = {1, 2}}}),
              HasSubstr("f: has columns of 3 and of 2 numbers"));
  EXPECT_THAT(ErrorOf({{.name = "a", .values = {1}}}, {.rate_hz = 1.0}),
              HasSubstr("holds 1 row; a measurement needs at least two"));
  EXPECT_THAT(ErrorOf({{.name = "a"}}, {.rate_hz = 1.0}), HasSubstr("holds 0 rows"));
  EXPECT_EQ(Parsed({{.name = "a", .values = {1, 2}}}, {.rate_hz = 8.0}).record.rows, 2U);
}

TEST(NumberTable, NumbersThatAreNoneAreInvalid) {
  using enum SampleStatus;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  NumberColumn column{.name = "displacement_2_mm", .values = {1, kNan, kInf, 1e308, 2}};
  const Record record = Parsed({column}, {.rate_hz = 8.0, .scale_m = 10.0}).record;
  EXPECT_THAT(record.channels.at(0).statuses, ElementsAre(kOk, kInvalid, kInvalid, kInvalid, kOk));
  EXPECT_EQ(record.channels[0].values[4], 20);
  EXPECT_TRUE(std::isnan(record.channels[0].values[3])) << "beyond a double";
  // what the file says of a value stays
  column.statuses = {kRepeated, kClipped, kRepeated, kOver, kClipped};
  const Record stated = Parsed({column}, {.rate_hz = 8.0}).record;
  EXPECT_THAT(stated.channels.at(0).statuses,
              ElementsAre(kRepeated, kClipped, kInvalid, kOver, kClipped));
  EXPECT_TRUE(std::isnan(stated.channels[0].values[4]));
}

// --- statuses ------------------------------------------------------------------------------------

NumberColumn StatusesOf(const std::string& column, std::vector<double> numbers) {
  return {.name = column + "_status", .values = std::move(numbers)};
}

// one scale for the one channel that is read, as of a CSV
TEST(NumberTable, AScaleIsThatOfTheChannelThatIsRead) {
  const NumberColumn other{.name = "displacement_um", .values = {7, 8, 9}};
  const Recording read =
      Parsed({kTimes, kLaser, other}, {.scale_m = 2.0, .channel = "displacement_mm"});
  ASSERT_EQ(read.record.channels.size(), 1U);
  EXPECT_THAT(read.record.channels[0].values, ElementsAre(2, 4, 6));
}

TEST(NumberTable, StatusesAreWholeNumbersBelowNine) {
  using enum SampleStatus;
  const Record record = Parsed({kTimes, kLaser, StatusesOf("displacement_mm", {8, 0, 1})}).record;
  EXPECT_THAT(record.channels.at(0).statuses, ElementsAre(kBadFrame, kOk, kRepeated));
  EXPECT_TRUE(std::isnan(record.channels[0].values[0]));
  EXPECT_EQ(record.channels[0].values[2], 3e-3);
  for (const double bad : {9.0, -1.0, 0.5, kNan}) {
    EXPECT_EQ(ErrorOf({kTimes, kLaser, StatusesOf("displacement_mm", {0, bad, 0})}),
              "f: row 2 of column 'displacement_mm_status' is no status; statuses are whole "
              "numbers from 0 to 8")
        << bad;
  }
}

TEST(NumberTable, StatusesAreOfTheirOwnChannel) {
  using enum SampleStatus;
  const NumberColumn coil{.name = "voltage_v", .values = {4, kNan, 6}};
  const Record record = Parsed({StatusesOf("voltage_v", {2, 0, 0}), kTimes, kLaser, coil}).record;
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_THAT(record.channels[0].statuses, ElementsAre(kOk, kOk, kOk));
  EXPECT_THAT(record.channels[1].statuses, ElementsAre(kOver, kInvalid, kOk))
      << "a missing value is no measurement";
  EXPECT_THAT(ErrorOf({kTimes, kLaser, StatusesOf("time_s", {0, 0, 0})}),
              HasSubstr("column 'time_s_status' is about a channel that is not there; there are 1 "
                        "channels, counted from 1"));
}

TEST(NumberTable, TheColumnsOfTheUserNumberTheirStatuses) {
  using enum SampleStatus;
  const Columns columns{
      {.values = {0, 0.25}}, {.values = {1, 2}}, {.values = {3, 4}}, {.values = {4, 0}}};
  const Record second =
      Parsed(columns, {.columns = {"time_s", "displacement_m", "voltage_v", "status_2"}}).record;
  EXPECT_THAT(second.channels.at(0).statuses, ElementsAre(kOk, kOk));
  EXPECT_THAT(second.channels.at(1).statuses, ElementsAre(kInvalid, kOk));
  const Record all =
      Parsed(columns, {.columns = {"time_s", "displacement_m", "voltage_v", "status"}}).record;
  EXPECT_THAT(all.channels.at(0).statuses, ElementsAre(kInvalid, kOk));
  EXPECT_THAT(all.channels.at(1).statuses, ElementsAre(kInvalid, kOk));
  EXPECT_THAT(ErrorOf(columns, {.columns = {"time_s", "displacement_m", "voltage_v", "status_3"}}),
              HasSubstr("is about a channel that is not there"));
}

// --- times ---------------------------------------------------------------------------------------

TEST(NumberTable, ATimeThatFallsOrIsNoneIsNamedByItsRow) {
  const auto error = [](std::vector<double> times) {
    return ErrorOf({{.name = "time_ms", .values = std::move(times)}, kLaser});
  };
  EXPECT_EQ(error({0, 500, 250}),
            "f: its time in row 3 is 0.25 s, which is before that of the row above; sort its rows, "
            "or name another column time_s in <columns>");
  EXPECT_THAT(error({kNan, 500, 750}),
              HasSubstr("its time in row 1 is nan s, which is no time; sort its rows"));
  EXPECT_THAT(error({0, 0, 250}), HasSubstr("1 of 3 rows has the time of the row before (first in "
                                            "line 2), and no uniform grid explains it"));
}

TEST(NumberTable, TheRateIsTheFilesOrTheUsers) {
  const Record file = Parsed({kLaser}, {}, 50).record;
  EXPECT_REL(file.stretches.at(0).rate_hz, 50, 3e-16, "two quotients");
  EXPECT_EQ(file.stretches[0].rows, 3U);
  EXPECT_EQ(file.metadata.nominal_rate_hz, std::nullopt);
  const Recording users = Parsed({kLaser}, {.rate_hz = 20.0}, 50);
  EXPECT_EQ(users.record.stretches.at(0).rate_hz, 20);
  EXPECT_EQ(users.record.metadata.nominal_rate_hz, 20);
  EXPECT_EQ(tests::NumbersOf(users.report.findings, FindingKind::kRateReplaced),
            "rate_hz=20 stated_hz=50 stated_by=sample rate");
  EXPECT_THAT(ErrorOf({kLaser}), HasSubstr("has no column of times and states no rate"));
  // times of 4 Hz against 1 % more or less
  EXPECT_EQ(Parsed({kTimes, kLaser}, {.rate_hz = 4.039}).record.stretches.at(0).rate_hz, 4);
  EXPECT_EQ(Parsed({kTimes, kLaser}, {.rate_hz = 3.961}).record.stretches.at(0).rate_hz, 4);
  EXPECT_THAT(ErrorOf({kTimes, kLaser}, {.rate_hz = 4.042}),
              HasSubstr("its times give 4 rows per second and <rate> gives 4.042 Hz"));
  EXPECT_THAT(ErrorOf({kTimes, kLaser}, {.rate_hz = 3.959}), HasSubstr("<rate> gives 3.959 Hz"));
}

// whole numbers have no digits that were rounded: a microsecond off 1 s is on no grid
TEST(NumberTable, WholeNumbersAreExactTimes) {
  const auto raw = [](bool is_count, double late) {
    return Parsed(
               {{.name = "time_ns", .values = {0, 1e9 + late, 2e9}, .is_count = is_count}, kLaser})
        .record.raw_times_s.size();
  };
  // a millionth of the interval alone
  EXPECT_EQ(raw(true, 995), 0U);
  EXPECT_EQ(raw(true, 1005), 3U);
  // floats of all digits are beside it by 2^-24 of 4 s, of the row and of the ends: 477 ns
  EXPECT_EQ(raw(false, 1470), 0U);
  EXPECT_EQ(raw(false, 1485), 3U);
}

TEST(NumberTable, OneSegmentAndOneLayoutAreKnown) {
  EXPECT_EQ(Parsed({kTimes, kLaser}, {.segment = 1}).record.rows, 3U);
  EXPECT_THAT(ErrorOf({kTimes, kLaser}, {.segment = 2}), HasSubstr("has 1 segment"));
  EXPECT_THAT(ErrorOf({kTimes, kLaser}, {.segment = 0}), HasSubstr("has 1 segment"));
  const Recording read = Parsed({kTimes, kLaser}, {.format = TableFormat::kLecroy});
  EXPECT_TRUE(read.report.findings.Has(FindingKind::kFormatNotUsed));
}

TEST(NumberTable, ColumnsHaveNames) {
  EXPECT_EQ(Parsed({{.values = {1, 2}}}, {.rate_hz = 1.0}).record.channels.at(0).name, "channel_1");
  EXPECT_THAT(ErrorOf({{.values = {1, 2}}, {.values = {1, 2}}}, {.rate_hz = 1.0}),
              HasSubstr("does not name its 2 columns"));
  EXPECT_THAT(ErrorOf({kTimes, kTimes, kLaser}), HasSubstr("two columns are named time"));
  EXPECT_THAT(ErrorOf({kTimes}), HasSubstr("no column beside the time holds values"));
  EXPECT_EQ(ErrorOf({kTimes, kLaser}, {.columns = {"time_s"}}),
            "<columns>: names 1 columns where f has 2; name each from the left, - for one to leave "
            "out");
  // times of arrival beside the others are passed over
  const NumberColumn arrival{.name = "arrival_s", .values = {5, 6, 7}};
  EXPECT_EQ(Parsed({arrival, kTimes, kLaser}).record.channels.size(), 1U);
}

TEST(NumberTable, TheFirstRowThatRepeatsATimeIsNamed) {
  EXPECT_THAT(ErrorOf({{.name = "time_s", .values = {0, 0, 0.25, 0.25}},
                       {.name = "voltage_v", .values = {1, 2, 3, 4}}}),
              HasSubstr("2 of 4 rows have the time of the row before (first in line 2)"));
}

TEST(NumberTable, VoltsBecomeADisplacementByACalibration) {
  const ScratchDirectory directory;
  const std::string path = directory.File("c.toml");
  std::ofstream(path) << "[displacement]\nscale_m_per_v = 0.001\noffset_m = 0.5\n";
  const Record record =
      Parsed({kTimes, {.name = "voltage_v", .values = {1, 2, 3}}}, {.calibration = path}).record;
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_THAT(record.channels[0].values, ElementsAre(0.501, 0.502, 0.503));
}

// --- matrices ------------------------------------------------------------------------------------

std::vector<std::vector<double>> Table(std::size_t rows, std::size_t columns, bool is_by_row,
                                       std::size_t named) {
  std::vector<double> numbers(rows * columns);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      numbers[is_by_row ? r * columns + c : c * rows + r] = static_cast<double>(10 * r + c);
    }
  }
  ImportOptions options;
  options.columns.assign(named, "a");
  const auto table =
      ColumnsOfMatrix(std::move(numbers), rows, columns, is_by_row, "m", "f", options);
  EXPECT_TRUE(table) << table.error().Text();
  std::vector<std::vector<double>> values;
  for (const NumberColumn& column : *table) values.push_back(column.values);
  return values;
}

TEST(Matrices, HaveTheirColumnsAlongTheSideWithAsManyNames) {
  using Values = std::vector<std::vector<double>>;
  for (const bool is_by_row : {true, false}) {
    EXPECT_EQ(Table(2, 3, is_by_row, 3), (Values{{0, 10}, {1, 11}, {2, 12}}));
    EXPECT_EQ(Table(2, 3, is_by_row, 2), (Values{{0, 1, 2}, {10, 11, 12}}));
    // the second side where both have it
    EXPECT_EQ(Table(2, 2, is_by_row, 2), (Values{{0, 10}, {1, 11}}));
    EXPECT_EQ(Table(1, 3, is_by_row, 0), (Values{{0, 1, 2}}));
    EXPECT_EQ(Table(3, 1, is_by_row, 0), (Values{{0, 10, 20}}));
  }
  const auto none = ColumnsOfMatrix({1, 2, 3, 4, 5, 6}, 2, 3, true, "m", "f", {.columns = {"a"}});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().Text(), HasSubstr("f: is a matrix of 2 x 3 numbers without names"));
}

TEST(Matrices, OfOneSideHaveTheirOwnName) {
  const auto column = ColumnsOfMatrix({1, 2}, 1, 2, true, "laser", "f", {});
  ASSERT_TRUE(column);
  ASSERT_EQ(column->size(), 1U);
  EXPECT_EQ(column->front().name, "laser");
}

}  // namespace
}  // namespace haptometer::trial
