// The oracle is the exhaustive search over all partitions.
#include "dsp/statistics/change_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

// squares about the mean of a segment, by sums from the first value on
SegmentCost SquaresAboutTheMean(const std::vector<double>& values) {
  std::vector<double> sums{0};
  std::vector<double> squares{0};
  for (const double value : values) {
    sums.push_back(sums.back() + value);
    squares.push_back(squares.back() + value * value);
  }
  return [sums, squares](std::size_t first, std::size_t end) {
    const double sum = sums[end] - sums[first];
    return squares[end] - squares[first] - sum * sum / static_cast<double>(end - first);
  };
}

double CostOf(const std::vector<std::size_t>& borders, double penalty, const SegmentCost& cost_of) {
  double cost = penalty * static_cast<double>(borders.size() - 2);
  for (std::size_t k = 0; k + 1 < borders.size(); ++k) cost += cost_of(borders[k], borders[k + 1]);
  return cost;
}

// bit k of a number: whether a segment begins at k + 1
double CheapestOfAll(std::size_t count, double penalty, const SegmentCost& cost_of) {
  double cheapest = std::numeric_limits<double>::infinity();
  for (unsigned bits = 0; bits < 1U << (count - 1); ++bits) {
    std::vector<std::size_t> borders{0};
    for (std::size_t k = 0; k + 1 < count; ++k) {
      if ((bits >> k & 1U) != 0) borders.push_back(k + 1);
    }
    borders.push_back(count);
    cheapest = std::min(cheapest, CostOf(borders, penalty, cost_of));
  }
  return cheapest;
}

TEST(ChangePoints, AreTheCheapestOfAllPartitions) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int repetition = 0; repetition < 200; ++repetition) {
    std::vector<double> values(2 + random() % 9);
    double level = 0;
    for (double& value : values) {
      if (random() % 4 == 0) level = 3 * normal(random);
      value = level + normal(random);
    }
    const SegmentCost cost_of = SquaresAboutTheMean(values);
    const auto borders = CheapestPartition(values.size(), 3, cost_of);
    EXPECT_EQ(borders.front(), 0U);
    EXPECT_EQ(borders.back(), values.size());
    EXPECT_REL(CostOf(borders, 3, cost_of), CheapestOfAll(values.size(), 3, cost_of), 1e-9,
               "differences of sums");
  }
}

// a border of pieces stays only where it pays
TEST(ChangePoints, OfManyValuesAreThoseOfTheValues) {
  std::vector<double> values(5000, 1.0);
  for (std::size_t k = 3000; k < values.size(); ++k) values[k] = 2;
  EXPECT_EQ(CheapestPartition(values.size(), 3, SquaresAboutTheMean(values)),
            (std::vector<std::size_t>{0, 3000, 5000}));
}

// A step between the pieces of 2048 values: one segment costs 1024 height^2 more than two, so the
// border stays where that is more than the penalty.
TEST(ChangePoints, ABorderOfPiecesStaysWhereItPaysMoreThanThePenalty) {
  constexpr double kPenalty = 3;
  for (const double share : {0.99, 1.01}) {
    std::vector<double> values(4096, 0.0);
    const double height = std::sqrt(share * kPenalty / 1024);
    for (std::size_t k = 2048; k < values.size(); ++k) values[k] = height;
    const auto borders = CheapestPartition(values.size(), kPenalty, SquaresAboutTheMean(values));
    EXPECT_EQ(borders.size(), share > 1 ? 3U : 2U) << share;
  }
}

// n values of 0 and n of the height: n height^2 / 2 less for a border
TEST(ChangePoints, ABorderCostsThePenalty) {
  for (const double share : {0.99, 1.01}) {
    std::vector<double> values(8, 0.0);
    std::fill(values.begin() + 4, values.end(), std::sqrt(share * 5 / 2));
    const auto borders = CheapestPartition(values.size(), 5, SquaresAboutTheMean(values));
    EXPECT_EQ(borders.size(), share > 1 ? 3U : 2U) << share;
  }
}

// Segments that cost nothing are never given up: of n values every one of n (n + 1) / 2 is a
// candidate.
TEST(ChangePoints, AsksForTheCostOfEverySegmentOnce) {
  constexpr std::size_t kCount = 60;
  std::vector<int> asked(kCount * (kCount + 1), 0);
  const SegmentCost nothing = [&](std::size_t first, std::size_t end) {
    EXPECT_LT(first, end);
    EXPECT_LE(end, kCount);
    if (first < end && end <= kCount) ++asked[first * (kCount + 1) + end];
    return 0.0;
  };
  EXPECT_EQ(CheapestPartition(kCount, 3, nothing), (std::vector<std::size_t>{0, kCount}));
  EXPECT_EQ(std::ranges::max(asked), 1) << "none twice";
  EXPECT_EQ(std::ranges::count(asked, 1), static_cast<std::ptrdiff_t>(kCount * (kCount + 1) / 2));
}

TEST(ChangePoints, OfOneValueAndOfNoneAreTheEnds) {
  const SegmentCost nothing = [](std::size_t, std::size_t) { return 0.0; };
  EXPECT_EQ(CheapestPartition(1, 3, nothing), (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(CheapestPartition(0, 3, nothing), (std::vector<std::size_t>{0}));
}

// where all cost nothing, every segment of a piece of 2048 values is asked for, and none longer
TEST(ChangePoints, PiecesAreOf2048Values) {
  constexpr std::size_t kCount = 2060;
  std::size_t longest = 0;
  const SegmentCost nothing = [&](std::size_t first, std::size_t end) {
    if (end - first < kCount) longest = std::max(longest, end - first);
    return 0.0;
  };
  EXPECT_EQ(CheapestPartition(kCount, 3, nothing), (std::vector<std::size_t>{0, kCount}));
  EXPECT_EQ(longest, 2048U);
}

}  // namespace
}  // namespace haptometer::dsp
