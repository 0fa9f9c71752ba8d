// The oracle is a loop over single rows; sums are those of kRowLanes lanes, so of the same bytes.
#include "dsp/readings/row_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/instruction_set.h"
#include "dsp/readings/faults.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

const RowKernel& KernelOf(InstructionSet set) {
  if (set == InstructionSet::kAvx512) return kRowKernelAvx512;
  return set == InstructionSet::kAvx2 ? kRowKernelAvx2 : kRowKernelBaseline;
}

// noise on steps, so that neighbours repeat
std::vector<double> Rows(std::size_t count) {
  Noise noise(count);
  std::vector<double> rows(count);
  for (double& x : rows) x = 0.03 + 1e-6 * std::round(0.6 * noise());
  return rows;
}

class EverySet : public testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override {
    if (!IsSupported(GetParam())) GTEST_SKIP() << "this processor has no " << Name(GetParam());
  }
  const RowKernel& kernel() const { return KernelOf(GetParam()); }
};

TEST_P(EverySet, SumsAreThoseOfLanes) {
  for (const std::size_t count : {1U, 7U, 8U, 40U, 1001U}) {
    const std::vector<double> rows = Rows(count);
    double sums[kRowLanes] = {};
    double squares[kRowLanes] = {};
    for (std::size_t k = 0; k < count; ++k) {
      sums[k % kRowLanes] += rows[k] - 0.0299;
      squares[k % kRowLanes] += rows[k] * rows[k];
    }
    const RowSum from = kernel().sum_from(rows.data(), count, 0.0299);
    EXPECT_EQ(from.sum, SumOfLanes(sums));
    EXPECT_EQ(kernel().sum_squares(rows.data(), count).sum, SumOfLanes(squares));
    EXPECT_EQ(from.least, std::ranges::min(rows));
    EXPECT_EQ(from.most, std::ranges::max(rows));
  }
}

TEST_P(EverySet, RepeatsAreCounted) {
  for (const std::size_t count : {2U, 3U, 11U, 256U, 1001U}) {
    const std::vector<double> rows = Rows(count);
    std::size_t equal = 0;
    std::size_t triples = 0;
    double least_change = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < count; ++k) {
      const double change = std::abs(rows[k] - rows[k - 1]);
      if (change > 0) least_change = std::min(least_change, change);
      if (k < 2 || rows[k] != rows[k - 1]) continue;
      ++equal;
      triples += rows[k - 1] == rows[k - 2] ? 1 : 0;
    }
    const RowRepeats repeats = kernel().repeats(rows.data(), count);
    EXPECT_EQ(repeats.equal, equal);
    EXPECT_EQ(repeats.triples, triples);
    EXPECT_EQ(repeats.least, std::ranges::min(rows));
    EXPECT_EQ(repeats.most, std::ranges::max(rows));
    EXPECT_EQ(kernel().least_change(rows.data(), count), least_change);
  }
}

TEST_P(EverySet, LargestErrorIsThatOfTheCubic) {
  for (const std::size_t count : {1U, 8U, 100U, 4096U}) {
    const std::vector<double> rows = Rows(count + 4);
    double largest = 0;
    for (std::size_t k = 2; k < count + 2; ++k) {
      largest = std::max(largest, std::abs(CubicError(rows, k)));
    }
    EXPECT_EQ(kernel().largest_error(rows.data() + 2, count), largest);
  }
}

TEST_P(EverySet, OneThatIsNoNumberIsFound) {
  for (const std::size_t count : {1U, 8U, 77U}) {
    std::vector<double> rows = Rows(count);
    EXPECT_TRUE(kernel().all_finite(rows.data(), count));
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      for (std::size_t at = 0; at < count; ++at) {
        std::vector<double> wrong = rows;
        wrong[at] = bad;
        EXPECT_FALSE(kernel().all_finite(wrong.data(), count)) << at;
      }
    }
  }
}

TEST_P(EverySet, SumsOfWholeNumbersAreExact) {
  std::vector<double> rows;
  for (int n = 1; n <= 40; ++n) {
    rows.push_back(n);
    EXPECT_EQ(kernel().sum_from(rows.data(), rows.size(), 3).sum, 0.5 * n * (n + 1) - 3 * n);
    EXPECT_EQ(kernel().sum_squares(rows.data(), rows.size()).sum, n * (n + 1) * (2 * n + 1) / 6);
  }
}

// rows that are no numbers, or far off, behind those that are asked about
TEST_P(EverySet, WhatFollowsIsNotRead) {
  for (const double beyond : {std::numeric_limits<double>::quiet_NaN(), 1e3}) {
    for (std::size_t count = 2; count <= 40; ++count) {
      SCOPED_TRACE(testing::Message() << beyond << " behind " << count);
      const std::vector<double> alone = Rows(count + 4);
      std::vector<double> rows = alone;
      const std::span<const double> asked = std::span(alone).first(count);
      // the cubic reads two more
      rows.insert(rows.end(), 2 * kRowLanes, beyond);
      EXPECT_EQ(kernel().largest_error(rows.data() + 2, count),
                kernel().largest_error(alone.data() + 2, count));
      std::fill(rows.begin() + static_cast<std::ptrdiff_t>(count), rows.end(), beyond);
      if (std::isnan(beyond)) {
        EXPECT_TRUE(kernel().all_finite(rows.data(), count));
      }
      const RowSum sum = kernel().sum_from(rows.data(), count, 0.03);
      EXPECT_EQ(sum.most, std::ranges::max(asked));
      EXPECT_ABS(sum.sum, 0, 1e-4, "numbers within some micrometres of 0.03");
      EXPECT_LT(kernel().sum_squares(rows.data(), count).sum, 1) << "of 0.03";
      EXPECT_EQ(kernel().repeats(rows.data(), count).most, std::ranges::max(asked));
      EXPECT_LT(kernel().least_change(rows.data(), count), 1) << "of some micrometres";
    }
  }
}

// the one small change, the one repeat and the one extreme at every place of every length
TEST_P(EverySet, WhatIsAtOnePlaceIsFoundThere) {
  for (std::size_t count = 2; count <= 28; ++count) {
    for (std::size_t at = 1; at < count; ++at) {
      SCOPED_TRACE(testing::Message() << at << " of " << count);
      std::vector<double> rows(count);
      for (std::size_t k = 0; k < count; ++k) rows[k] = 10 * static_cast<double>(k % 3);
      rows[at] = rows[at - 1] + 0.5;
      EXPECT_EQ(kernel().least_change(rows.data(), count), 0.5);
      rows[at] = rows[at - 1];
      const RowRepeats pair = kernel().repeats(rows.data(), count);
      EXPECT_EQ(pair.equal, at >= 2 ? 1U : 0U) << "from the third row on";
      EXPECT_EQ(pair.triples, 0U);
      rows[at] = 30;
      EXPECT_EQ(kernel().repeats(rows.data(), count).most, 30);
      EXPECT_EQ(kernel().sum_from(rows.data(), count, 0).most, 30);
      rows[at] = -30;
      EXPECT_EQ(kernel().repeats(rows.data(), count).least, -30);
      EXPECT_EQ(kernel().sum_from(rows.data(), count, 0).least, -30);
      // four equal rows with the one that follows
      if (at < 2) continue;
      rows[at] = rows[at - 1] = rows[at - 2];
      EXPECT_EQ(kernel().repeats(rows.data(), count).triples, at + 1 < count ? 2U : 1U);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(RowKernel, EverySet, testing::ValuesIn(kInstructionSets),
                         [](const auto& set) { return std::string(Name(set.param)); });

}  // namespace
}  // namespace haptometer::dsp
