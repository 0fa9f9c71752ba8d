// A table whose last line was cut off, as a copy that was interrupted leaves it.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "trial/import/readers.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

// rows of a time and a voltage of five digits, and a last line
std::string Table(int rows, const std::string& last, const std::string& end = "\n") {
  std::string text = "time_s,voltage_v" + end;
  for (int k = 0; k < rows; ++k) text += fmt::format("{:.4f},{:.5f}{}", k * 1e-4, 0.1 * k, end);
  return text + last;
}

TEST(CutLine, HasFewerCellsOrFewerDigitsThanTheRowsAboveIt) {
  for (const char* cut : {"0.0100,0.1234", "0.0100,0", "0.0100,-", "0.0100,", "0.0100", "0"}) {
    EXPECT_TRUE(IsLastLineCutOff(Table(100, cut))) << cut;
    EXPECT_TRUE(IsLastLineCutOff(Table(8, cut, "\r\n"))) << cut;
    EXPECT_FALSE(IsLastLineCutOff(Table(7, cut))) << "too few rows to compare with";
    EXPECT_FALSE(IsLastLineCutOff(Table(100, std::string(cut) + "\n"))) << "it has its line end";
  }
  EXPECT_FALSE(IsLastLineCutOff(Table(100, "0.0100,0.12345"))) << "whole but for its line end";
  EXPECT_FALSE(IsLastLineCutOff(Table(100, "")));
  EXPECT_FALSE(IsLastLineCutOff(""));
  EXPECT_FALSE(IsLastLineCutOff("0.1"));
}

// of numbers that are printed without their last zeros some are shorter
TEST(CutLine, OfNumbersOfSeveralLengthsNoneIs) {
  EXPECT_FALSE(IsLastLineCutOff("0.5\n" + Table(62, "0.0100,0.5").substr(17)))
      << "a row without a second cell stands above";
  EXPECT_FALSE(IsLastLineCutOff(Table(20, "0.0020,0.5\n") + Table(40, "0.01,0.1").substr(17)));
  EXPECT_TRUE(IsLastLineCutOff(Table(20, "0.0020,0.5\n") + Table(64, "0.01,0.12").substr(17)))
      << "64 rows above it are longer";
}

TEST(CutLine, IsLeftOutWithADoubt) {
  Findings findings;
  const auto record = ParseCsv(Table(100, "0.0100,9"), "t.csv", {}, &findings);
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_EQ(record->rows, 100U);
  ASSERT_TRUE(findings.Has(FindingKind::kLastLineCutOff));
  EXPECT_EQ(std::get<std::int64_t>(findings.list().front().numbers.at(0).value), 102);
  const auto whole = ParseCsv(Table(100, "0.0100,9.00000"), "t.csv", {}, &findings);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->channels.at(0).values.back(), 9);
}

// SCPI 1999.0, volume 1, 7.2.1.4 and 7.2.1.5
TEST(ScpiNumbers, StandForInfinityAndForNone) {
  EXPECT_EQ(ReadScpiNoNumber(9.91e37), SampleStatus::kInvalid);
  EXPECT_EQ(ReadScpiNoNumber(9.9e37), SampleStatus::kOver);
  EXPECT_EQ(ReadScpiNoNumber(-9.9e37), SampleStatus::kUnder);
  EXPECT_FALSE(ReadScpiNoNumber(9.8e37));
  EXPECT_FALSE(ReadScpiNoNumber(0));
  Findings findings;
  const auto record =
      ParseCsv("time_s,voltage_v\n0,1\n1,9.91E+37\n2,-9.9E+37\n3,2\n", "t.csv", {}, &findings);
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_EQ(record->channels.at(0).statuses,
            (std::vector{SampleStatus::kOk, SampleStatus::kInvalid, SampleStatus::kUnder,
                         SampleStatus::kOk}));
}

}  // namespace
}  // namespace haptometer::trial
