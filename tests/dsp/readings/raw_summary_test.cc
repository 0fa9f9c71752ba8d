#include "dsp/readings/raw_summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "dsp/statistics/moments.h"
#include "tests/dsp/records.h"
#include "tests/dsp/row_blocks.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

// fed `rows_at_once` rows at a time
RawSummary Summarized(const trial::Record& record, std::size_t rows_at_once) {
  RawSummarizer summarizer(record);
  const trial::Channel& channel = record.channels[0];
  ForEachBlock(channel.values, channel.statuses, rows_at_once, 0,
               [&](const RowBlock& block) { summarizer.Feed(block, summarizer.LookAt(block)); });
  return summarizer.Finish();
}

trial::Record Holed() {
  trial::Record record = RecordOf(Samples(10e3, 10'007, 0.03, {{5e-4, 8.3}, {1e-6, 100}}), 10e3);
  for (std::size_t row = 0; row < record.rows; row += 11) {
    record.channels[0].statuses[row] = SampleStatus::kOver;
    record.channels[0].values[row] = 99;
  }
  record.channels[0].values[5] = std::numeric_limits<double>::infinity();
  std::fill_n(record.channels[0].statuses.begin() + 400, 40, SampleStatus::kLate);
  return record;
}

std::vector<double> Measured(const trial::Record& record, std::size_t begin, std::size_t end) {
  std::vector<double> values;
  for (std::size_t row = begin; row < std::min(end, record.rows); ++row) {
    const double value = record.channels[0].values[row];
    if (IsMeasurement(record.channels[0].statuses[row]) && std::isfinite(value)) {
      values.push_back(value);
    }
  }
  return values;
}

TEST(RawSummary, IsThatOfTheMeasuredRows) {
  const trial::Record record = Holed();
  const RawSummary summary = Summarized(record, record.rows);
  const std::vector<double> measured = Measured(record, 0, record.rows);
  EXPECT_EQ(summary.measured, measured.size());
  EXPECT_REL(summary.mean, Mean(measured), 3e-16, "one rounding more");
  EXPECT_EQ(summary.least, std::ranges::min(measured));
  EXPECT_EQ(summary.most, std::ranges::max(measured));
  // cells of 4 ms; two of them hold nothing
  ASSERT_EQ(summary.cell_rows, 40U);
  ASSERT_EQ(summary.cell_means.size(), 251U);
  EXPECT_TRUE(std::isnan(summary.cell_means[10]));
  for (std::size_t k = 0; k < summary.cell_means.size(); ++k) {
    if (k == 10) continue;
    EXPECT_REL(summary.cell_means[k], Mean(Measured(record, 40 * k, 40 * (k + 1))), 3e-16,
               "one rounding more");
  }
}

TEST(RawSummary, BlocksChangeNoBit) {
  const trial::Record record = Holed();
  const RawSummary whole = Summarized(record, record.rows);
  for (const std::size_t size : {1U, 7U, 4096U}) {
    const RawSummary parts = Summarized(record, size);
    EXPECT_EQ(parts.mean, whole.mean);
    EXPECT_EQ(parts.least, whole.least);
    EXPECT_EQ(parts.most, whole.most);
    ASSERT_EQ(parts.cell_means.size(), whole.cell_means.size());
    for (std::size_t k = 0; k < whole.cell_means.size(); ++k) {
      EXPECT_TRUE(parts.cell_means[k] == whole.cell_means[k] ||
                  (std::isnan(parts.cell_means[k]) && std::isnan(whole.cell_means[k])));
    }
  }
}

TEST(RawSummary, NothingMeasuredIsNoNumber) {
  trial::Record record = RecordOf({1, 2, 3}, 10e3);
  record.channels[0].statuses.assign(3, SampleStatus::kOver);
  const RawSummary summary = Summarized(record, 3);
  EXPECT_EQ(summary.measured, 0U);
  EXPECT_TRUE(std::isnan(summary.mean) && std::isnan(summary.least) && std::isnan(summary.most));
}

TEST(RawSummary, BillionsOfRowsHaveMillionsOfCells) {
  trial::Record head;
  head.rows = 5'000'000'000;
  head.stretches = {{0, head.rows, 0, 10e3, 0}};
  EXPECT_EQ(RawSummarizer(head).Finish().cell_rows, 4769U);
}

// 4 ms, or as long as it takes for 2^20 of them
TEST(RawSummary, CellsAreOfFourMillisecondsOrOfAMillionthOfTheRows) {
  const auto cell_rows = [](std::size_t rows, double rate_hz) {
    trial::Record head;
    head.rows = rows;
    head.stretches = {{0, rows, 0, rate_hz, 0}};
    return RawSummarizer(head).Finish().cell_rows;
  };
  EXPECT_EQ(cell_rows(5000, 499.9), 1U);
  EXPECT_EQ(cell_rows(5000, 500), 2U);
  EXPECT_EQ(cell_rows(5000, 749.9), 2U);
  EXPECT_EQ(cell_rows(5000, 750), 3U);
  EXPECT_EQ(cell_rows(30, 10e3), 30U) << "no longer than the record";
  EXPECT_EQ(cell_rows(std::size_t{1} << 20U, 100), 1U);
  EXPECT_EQ(cell_rows((std::size_t{1} << 20U) + 1, 100), 2U);
}

// the highest rate of all stretches counts
TEST(RawSummary, CellsAreThoseOfTheFastestStretch) {
  trial::Record head;
  head.rows = 3000;
  head.stretches = {{0, 1000, 0, 500, 0}, {1000, 1000, 9, 1000, 0}, {2000, 1000, 19, 750, 0}};
  EXPECT_EQ(RawSummarizer(head).Finish().cell_rows, 4U);
}

// 400 rows are ten cells of 4 ms, 401 one more; of no rows there is none
TEST(RawSummary, NoCellIsEmpty) {
  for (const auto& [rows, cells] : {std::pair{400U, 10U}, {401U, 11U}, {399U, 10U}, {40U, 1U}}) {
    const trial::Record record = RecordOf(std::vector<double>(rows, 0.03), 10e3);
    for (const std::size_t at_once : {std::size_t{7}, record.rows}) {
      const RawSummary summary = Summarized(record, at_once);
      ASSERT_EQ(summary.cell_means.size(), cells) << rows;
      EXPECT_EQ(summary.cell_means.back(), 0.03);
      EXPECT_EQ(summary.measured, rows);
    }
  }
  EXPECT_TRUE(RawSummarizer(trial::Record{}).Finish().cell_means.empty());
}

}  // namespace
}  // namespace haptometer::dsp
