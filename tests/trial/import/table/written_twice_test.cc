// Rows that were written twice, against the likelihood ratio in trial/import/table/written_twice.h.
#include "trial/import/table/written_twice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace haptometer::trial {
namespace {

// a segment with its only channel
struct Rows {
  std::vector<Channel> channels{Channel{.name = "laser"}};
  CsvRows::Segment segment{};

  // a row at the time of the row before or a new one, with its value or a new one
  void Add(bool has_new_time, bool has_new_value) {
    if (has_new_time) time_s += 1;
    if (has_new_value) value += 1;
    segment.times.AddCount(time_s);
    channels[0].values.push_back(value);
    channels[0].statuses.push_back(SampleStatus::kOk);
    ++segment.rows;
  }

  double time_s = 0;
  double value = 0;
};

// how many rows repeat the time (n) and the values too (m), how many lie beside them (d) and repeat
// the values (u)
struct Counts {
  std::size_t n = 0, m = 0, d = 0, u = 0;
};

// rows with these counts: n pairs, d - n rows of their own behind the first of them; n <= d <= 2 n
Rows RowsOf(const Counts& counts) {
  Rows rows;
  rows.Add(true, true);
  std::size_t beside = 0;
  const auto add_beside = [&] { rows.Add(true, ++beside > counts.u); };
  for (std::size_t pair = 0; pair < counts.n; ++pair) {
    add_beside();
    rows.Add(false, pair >= counts.m);
    if (pair < counts.d - counts.n) add_beside();
  }
  return rows;
}

double Relative(double share, double common) {
  const auto term = [](double a, double b) { return a > 0 ? a * std::log(a / b) : 0; };
  return term(share, common) + term(1 - share, 1 - common);
}

// the logarithm of the likelihood ratio
double Evidence(const Counts& counts) {
  const auto [n, m, d, u] = counts;
  const auto share = [](std::size_t a, std::size_t b) {
    return static_cast<double>(a) / static_cast<double>(b);
  };
  const double common = share(m + u, n + d);
  return static_cast<double>(n) * Relative(share(m, n), common) +
         static_cast<double>(d) * Relative(share(u, d), common);
}

std::size_t CopiesOf(const Counts& counts) {
  Rows rows = RowsOf(counts);
  MarkRowsWrittenTwice(rows.channels, &rows.segment);
  return rows.segment.copies;
}

TEST(WrittenTwice, TheLikelihoodRatioIsAboveAThousand) {
  const double least = std::log(1000.0);
  // within 1 % of the limit, found by a search
  for (const Counts& above : {Counts{12, 6, 19, 0}, {13, 9, 16, 1}, {11, 7, 12, 0}, {5, 5, 5, 0}}) {
    ASSERT_GT(Evidence(above), least);
    ASSERT_LT(Evidence(above), 1.01 * least);
    EXPECT_EQ(CopiesOf(above), above.m) << above.n << " " << above.d;
  }
  for (const Counts& below : {Counts{7, 6, 14, 1}, {9, 8, 14, 2}, {10, 8, 13, 1}, {13, 6, 21, 0}}) {
    ASSERT_LT(Evidence(below), least);
    EXPECT_EQ(CopiesOf(below), 0U) << below.n << " " << below.d;
  }
}

// p (n - m) / (1 - p) <= m / 10 with p = 1/2 and n - m = 10
TEST(WrittenTwice, ChanceExplainsATenthOfThemAtMost) {
  EXPECT_EQ(CopiesOf({.n = 110, .m = 100, .d = 110, .u = 55}), 100U);
  EXPECT_EQ(CopiesOf({.n = 109, .m = 99, .d = 110, .u = 55}), 0U);
}

// `rows` rows, of which every 500th is written twice and the one 100 behind a copy has its value
Rows Sparse(std::size_t rows, std::size_t copies, std::size_t equal) {
  Rows made;
  for (std::size_t i = 0; i < rows; ++i) {
    const bool is_equal = i % 500 == 350 && i / 500 < equal;
    made.Add(true, !is_equal);
    if (i % 500 == 250 && i / 500 < copies) made.Add(false, false);
  }
  return made;
}

TEST(WrittenTwice, AreFoundFromOneOnWhereHardlyAnyOtherRowRepeats) {
  const auto copies_of = [](std::size_t copies, std::size_t equal) {
    Rows rows = Sparse(10'000, copies, equal);
    MarkRowsWrittenTwice(rows.channels, &rows.segment);
    return rows.segment.copies;
  };
  EXPECT_EQ(copies_of(0, 0), 0U);
  EXPECT_EQ(copies_of(1, 0), 1U);
  EXPECT_EQ(copies_of(2, 0), 2U);
  EXPECT_EQ(copies_of(4, 0), 4U);
  // one other beside one copy: may be chance
  EXPECT_EQ(copies_of(1, 1), 0U);
  EXPECT_EQ(copies_of(2, 1), 2U);
}

// of values with few steps, which repeat often, a few rows decide nothing
TEST(WrittenTwice, AreNotFoundAmongFewSteps) {
  for (const std::size_t every : {20U, 90U}) {
    Rows rows;
    for (std::size_t i = 0; i < 10'000; ++i) {
      rows.Add(true, i % every != 0);
      if (i % 3000 == 1511) rows.Add(false, false);
    }
    MarkRowsWrittenTwice(rows.channels, &rows.segment);
    EXPECT_EQ(rows.segment.copies, 0U) << every;
  }
}

TEST(WrittenTwice, MissingReadingsAreEqualAndOtherStatusesAreNot) {
  const Counts counts{.n = 8, .m = 8, .d = 8, .u = 0};
  Rows rows = RowsOf(counts);
  // rows 1 and 2 are the first pair
  rows.channels[0].values[1] = rows.channels[0].values[2] =
      std::numeric_limits<double>::quiet_NaN();
  MarkRowsWrittenTwice(rows.channels, &rows.segment);
  EXPECT_EQ(rows.segment.copies, 8U);
  EXPECT_EQ(rows.segment.first_copy, 2U);
  rows.channels[0].statuses[2] = SampleStatus::kOver;
  MarkRowsWrittenTwice(rows.channels, &rows.segment);
  EXPECT_EQ(rows.segment.copies, 7U);
  EXPECT_EQ(rows.segment.first_copy, 4U) << "the second pair";
  // another channel that goes on
  Channel other{.name = "count"};
  for (std::size_t i = 0; i < rows.segment.rows; ++i) {
    other.values.push_back(static_cast<double>(i));
    other.statuses.push_back(SampleStatus::kOk);
  }
  Rows both = RowsOf(counts);
  both.channels.push_back(other);
  MarkRowsWrittenTwice(both.channels, &both.segment);
  EXPECT_EQ(both.segment.copies, 0U);
}

TEST(WrittenTwice, ASegmentLooksAtItsOwnRows) {
  Rows rows = RowsOf({.n = 6, .m = 6, .d = 6, .u = 0});
  Channel& channel = rows.channels[0];
  channel.values.insert(channel.values.begin(), {7.5, 8.5, 9.5});
  channel.statuses.insert(channel.statuses.begin(), 3, SampleStatus::kOk);
  rows.segment.first_row = 3;
  MarkRowsWrittenTwice(rows.channels, &rows.segment);
  EXPECT_EQ(rows.segment.copies, 6U);
  EXPECT_EQ(rows.segment.first_copy, 2U) << "counted as times count";
}

}  // namespace
}  // namespace haptometer::trial
