#include "dsp/statistics/robust.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr int kTables = tests::kIsSanitized ? 5 : 500;

// of kTables tables of normal cells, an effect each
double MeanDeviation(std::size_t subjects, std::size_t conditions) {
  Noise noise(3);
  double sum = 0;
  for (int k = 0; k < kTables; ++k) {
    CompleteTable table(subjects, conditions);
    for (std::size_t s = 0; s < subjects; ++s) {
      for (std::size_t c = 0; c < conditions; ++c) {
        table.At(s, c) = static_cast<double>(s + c) + 0.1 * noise();
      }
    }
    sum += DeviationOfPolished(MedianPolish(table)) / kTables;
  }
  return sum;
}

TEST(DeviationOfPolished, IsTheStandardDeviationOfNormalCells) {
  constexpr const char* kReason = "three deviations of the two means, 500 and 500 or 187 tables";
  constexpr double kFewer = tests::kIsSanitized ? 10 : 1;  // the root of so many fewer tables
  EXPECT_REL(MeanDeviation(4, 3), 0.1, 0.1 * kFewer, kReason);
  EXPECT_REL(MeanDeviation(8, 4), 0.1, 0.05 * kFewer, kReason);
}

TEST(DeviationOfPolished, IsUnmovedByAnOutlier) {
  Noise noise(4);
  CompleteTable table(8, 4);
  for (std::size_t s = 0; s < 8; ++s) {
    for (std::size_t c = 0; c < 4; ++c) table.At(s, c) = noise();
  }
  const double before = DeviationOfPolished(MedianPolish(table));
  table.At(3, 2) = 1e6;
  EXPECT_REL(DeviationOfPolished(MedianPolish(table)), before, 0.3, "one rank of 32");
}

TEST(MedianPolish, TakesOutEffectsAndLeavesTheOutlier) {
  CompleteTable table(5, 3);
  for (std::size_t s = 0; s < 5; ++s) {
    for (std::size_t c = 0; c < 3; ++c) table.At(s, c) = static_cast<double>(s * s + 10 * c);
  }
  table.At(2, 1) += 7;
  const CompleteTable left = MedianPolish(table);
  for (std::size_t s = 0; s < 5; ++s) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_ABS(left.At(s, c), s == 2 && c == 1 ? 7.0 : 0.0, 1e-12, "medians of exact sums");
    }
  }
}

TEST(RobustWithinDeviation, IsUnmovedByOneCell) {
  // two repeats d apart: sd = d / sqrt(2), over the median 0.6745 of |Z|
  std::vector<std::vector<double>> cells{{0, 1}, {5, 6}, {2, 3}};
  const double expected = std::numbers::sqrt2 / 2 / 0.674489750196082;
  EXPECT_REL(RobustWithinDeviation(cells).value(), expected, 1e-13, "normal quantile");
  cells.push_back({0, 100});
  cells.push_back({4});
  EXPECT_REL(RobustWithinDeviation(cells).value(), expected, 1e-13, "normal quantile");
  EXPECT_FALSE(RobustWithinDeviation(std::vector<std::vector<double>>{{1}}));
  EXPECT_FALSE(RobustWithinDeviation(std::vector<std::vector<double>>{{1, 1}}));
}

}  // namespace
}  // namespace haptometer::dsp
