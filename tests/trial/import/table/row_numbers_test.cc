// A column that numbers the rows: where its numbers jump, rows are missing.
#include "trial/import/table/row_numbers.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using ::testing::HasSubstr;
using tests::NumbersOf;

ImportOptions At100Hz() { return {.rate_hz = 100.0}; }

// a table below `name` with these numbers and a voltage that counts the rows
std::string Table(const std::string& name, const std::vector<int>& numbers) {
  std::string text = name + ",CH1 (V)\n";
  for (std::size_t i = 0; i < numbers.size(); ++i) text += fmt::format("{},{}.5\n", numbers[i], i);
  return text;
}

struct Read {
  Record record{};
  Findings findings{};
};
Read Parsed(const std::string& text, const ImportOptions& options = At100Hz()) {
  Read read;
  auto record = ParseCsv(text, "f.csv", options, &read.findings);
  EXPECT_TRUE(record) << record.error().Text();
  if (record) read.record = *std::move(record);
  return read;
}

// 40 and 41 are missing, and 60
std::vector<int> Jumping(int first, int step) {
  std::vector<int> numbers;
  for (int i = 0; i < 100; ++i) {
    if (i != 40 && i != 41 && i != 60) numbers.push_back(first + i * step);
  }
  return numbers;
}

TEST(RowNumbers, JumpsAreMissingRows) {
  for (const char* name : {"Sample", "No.", "Nr", "Index", "Point", "sample number", "\"#\"", ""}) {
    for (const auto& [first, step] : {std::pair(0, 1), {1, 1}, {500, 10}}) {
      const auto [record, findings] = Parsed(Table(name, Jumping(first, step)));
      ASSERT_EQ(record.channels.size(), 1U) << name;
      ASSERT_EQ(record.stretches.size(), 3U) << name;
      EXPECT_EQ(record.stretches[1].first_row, 40U);
      EXPECT_EQ(record.stretches[1].rows, 18U);
      EXPECT_EQ(record.stretches[2].rows, 39U);
      EXPECT_REL(record.stretches[1].start_s, 0.42, 1e-15, "one division");
      EXPECT_REL(record.stretches[2].start_s, 0.61, 1e-15, "one division");
      EXPECT_EQ(NumbersOf(findings, FindingKind::kRowsMissing), "missing=3 places=2 line=42");
    }
  }
}

TEST(RowNumbers, EvenStepsChangeNothing) {
  for (const int step : {1, 2, 1000}) {
    std::vector<int> numbers;
    for (int i = 0; i < 50; ++i) numbers.push_back(7 + step * i);
    const auto [record, findings] = Parsed(Table("Index", numbers));
    ASSERT_EQ(record.stretches.size(), 1U);
    EXPECT_EQ(record.stretches[0].rows, 50U);
    EXPECT_FALSE(findings.Has(FindingKind::kRowsMissing));
    EXPECT_FALSE(findings.Has(FindingKind::kRowNumbersUneven));
  }
}

// whole milliseconds of 700 rows/s: three of seven steps are 2
TEST(RowNumbers, TimesInWholeUnitsAreDoubted) {
  std::vector<int> times_ms;
  for (int i = 0; i < 140; ++i) times_ms.push_back(i * 10 / 7);
  const auto [record, findings] = Parsed(Table("Index", times_ms));
  ASSERT_EQ(record.stretches.size(), 1U);
  EXPECT_EQ(record.stretches[0].rows, 140U);
  EXPECT_TRUE(findings.Has(FindingKind::kRowNumbersUneven));
}

// the number of a sample of material, beside its readings
TEST(RowNumbers, ANumberThatStaysIsNoChannel) {
  const auto [record, findings] = Parsed("Sample,Reading (um)\n1,0.5\n1,2.5\n1,3.5\n");
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_EQ(record.stretches.at(0).rows, 3U);
}

TEST(RowNumbers, AFirstReadingOfZeroIsNoColumnNumber) {
  const auto [record, findings] = Parsed("displacement_um\n0\n2.599\n5.154\n7.6\n");
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_EQ(record.channels[0].name, "displacement");
  EXPECT_EQ(record.stretches.at(0).rows, 4U);
}

// falling, repeated, begun again, and half a step
TEST(RowNumbers, NumbersThatDoNotGoOnAreDoubted) {
  for (const std::vector<int>& numbers :
       {std::vector{5, 4, 3, 2}, {1, 2, 2, 3}, {1, 2, 3, 1}, {0, 2, 4, 5}}) {
    const auto [record, findings] = Parsed(Table("Sample", numbers));
    ASSERT_EQ(record.stretches.size(), 1U);
    EXPECT_EQ(record.stretches[0].rows, 4U);
    const auto doubt =
        std::ranges::find(findings.list(), FindingKind::kRowNumbersUneven, &Finding::kind);
    ASSERT_NE(doubt, findings.list().end());
    EXPECT_EQ(doubt->severity, Severity::kDoubt);
  }
  EXPECT_EQ(NumbersOf(Parsed(Table("Nr", {1, 2, 2, 3})).findings, FindingKind::kRowNumbersUneven),
            "line=4");
}

// a place without a number is none of a row that is missing
TEST(RowNumbers, ACellWithoutANumberIsDoubted) {
  const auto [record, findings] = Parsed("Sample;U (V)\n1;0\n2;1\n;2\n4;3\n");
  EXPECT_EQ(record.stretches.size(), 1U);
  EXPECT_EQ(NumbersOf(findings, FindingKind::kRowNumbersUneven), "line=4");
}

TEST(RowNumbers, TimesDecideWhereThereAreTimes) {
  const auto [record, findings] =
      Parsed("Sample,Time (s),CH1 (V)\n1,0,1\n2,0.01,2\n5,0.02,3\n6,0.03,4\n");
  EXPECT_EQ(record.stretches.size(), 1U);
  EXPECT_FALSE(findings.Has(FindingKind::kRowsMissing));
}

// a first column that is called so and does not count is a channel
TEST(RowNumbers, OtherNumbersAreAChannel) {
  EXPECT_EQ(Parsed("Point,CH1 (V)\n0.5,1\n0.75,2\n").record.channels.size(), 2U);
  EXPECT_EQ(Parsed("Sample\n511\n513\n").record.channels.size(), 1U);
}

TEST(RowNumbers, AColumnWithoutANameIsNamedByTheOptions) {
  std::string text = Table("", Jumping(1, 1));
  text.erase(0, text.find('\n') + 1);
  ImportOptions options = At100Hz();
  options.columns = {"sample", "voltage_v"};
  EXPECT_EQ(Parsed(text, options).record.stretches.size(), 3U);
  // - leaves it out
  options.columns = {"-", "voltage_v"};
  EXPECT_EQ(Parsed(text, options).record.stretches.size(), 1U);
  const auto refused = ParseCsv(text, "f.csv", At100Hz());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(), HasSubstr("or <columns> sample,voltage_v where it numbers"));
}

}  // namespace
}  // namespace haptometer::trial
