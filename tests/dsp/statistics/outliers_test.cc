#include "dsp/statistics/outliers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/dsp/statistics/table_of.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using Groups = std::vector<std::vector<double>>;

Groups Alike(const Groups& groups, double value) {
  Groups alike = groups;
  for (std::vector<double>& group : alike) {
    for (double& one : group) one = value;
  }
  return alike;
}

// groups {0, 0, 3}, {1, 3}, {5}: means 1, 2; SS = 6 + 2 on 3 degrees of freedom. Of the 3: r = 2,
// 1 - h = 2/3, s^2 = (8 - 6) / 2 = 1, t = 2 / sqrt(2/3) = 2.449490; of 4 values (a pair is one)
// 4 P(|T(2)| >= t) with P = 1 - t / sqrt(2 + t^2)
TEST(OutliersOfGroups, AreByTheExternallyStudentizedResidual) {
  const Groups groups{{0, 0, 3}, {1, 3}, {5}};
  const double t = std::sqrt(6.0);
  const double p = 4 * (1 - t / std::sqrt(2 + t * t));
  EXPECT_TRUE(OutliersOfGroups(groups, Alike(groups, 1e-9), p * (1 - 1e-9)).empty());
  const auto found = OutliersOfGroups(groups, Alike(groups, 1e-9), p * (1 + 1e-9));
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].group, 0U);
  EXPECT_EQ(found[0].place, 2U);
  EXPECT_REL(found[0].deviation, 3, 1e-14, "3 against the mean of the others");
  EXPECT_REL(found[0].t, t, 1e-14, "rounding");
  EXPECT_REL(found[0].p, p, 1e-13, "closed form of two degrees of freedom");
  EXPECT_TRUE(OutliersOfGroups(groups, Alike(groups, 10), 0.5).empty()) << "within the least";
}

TEST(OutliersOfGroups, AreFoundBehindEachOtherAndInPairsTogether) {
  Noise noise(7);
  Groups groups(20);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (std::size_t i = 0; i < (g == 5 ? 2U : 3U); ++i) {
      groups[g].push_back(static_cast<double>(g) + 0.05 * noise());
    }
  }
  EXPECT_TRUE(OutliersOfGroups(groups, Alike(groups, 0.01), 0.01).empty());
  groups[3][1] += 2;
  groups[5][0] -= 1;
  groups[9][2] += 0.5;
  const auto found = OutliersOfGroups(groups, Alike(groups, 0.01), 0.01);
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0].group, 3U);
  EXPECT_EQ(found[1].group, 5U) << "which of a pair it is cannot be known";
  EXPECT_EQ(found[2].group, 5U);
  EXPECT_EQ(found[3].group, 9U) << "hidden by the first";
}

TEST(OutliersOfTable, NamesTheCellThatFitsNeitherSubjectNorCondition) {
  Noise noise(4);
  CompleteTable table(8, 4);
  CompleteTable least(8, 4);
  for (std::size_t s = 0; s < 8; ++s) {
    for (std::size_t c = 0; c < 4; ++c) {
      table.At(s, c) = static_cast<double>(s * s + 10 * c) + 0.1 * noise();
      least.At(s, c) = 0.01;
    }
  }
  EXPECT_TRUE(OutliersOfTable(table, least, 0.05).empty());
  table.At(3, 2) += 2;
  table.At(6, 0) -= 1.5;
  const auto found = OutliersOfTable(table, least, 0.05);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].group, 3U);
  EXPECT_EQ(found[0].place, 2U);
  EXPECT_ABS(found[0].deviation, 2, 0.4, "the scatter, and the other outlier over its row's share");
  EXPECT_EQ(found[1].group, 6U);
  // of two conditions both cells of the subject
  const CompleteTable two = TableOf(4, 2, {0, 1, 0, 1.01, 0, 0.99, 0, 3});
  const auto pair = OutliersOfTable(two, TableOf(4, 2, std::vector<double>(8, 1e-3)), 0.05);
  ASSERT_EQ(pair.size(), 2U);
  EXPECT_EQ(pair[0].group, 3U);
  EXPECT_TRUE(
      OutliersOfTable(TableOf(2, 2, {0, 1, 0, 9}), TableOf(2, 2, {1, 1, 1, 1}), 0.5).empty());
}

// false alarms a study, of normal values: at most what is stated, and not far below it
TEST(OutliersOfGroups, FalseAlarmsAreAsStated) {
  const int studies = tests::Repetitions(tests::kIsSanitized ? 100 : 2000);
  for (const auto& [cells, repeats] : {std::pair(32, 3), std::pair(8, 5), std::pair(6, 2)}) {
    Noise noise(11);
    int alarms = 0;
    for (int k = 0; k < studies; ++k) {
      Groups groups(static_cast<std::size_t>(cells));
      for (std::vector<double>& group : groups) {
        const double mean = 3 * noise();
        for (int i = 0; i < repeats; ++i) group.push_back(mean + 0.05 * noise());
      }
      alarms += static_cast<int>(!OutliersOfGroups(groups, Alike(groups, 1e-9), 0.05).empty());
    }
    RecordProperty("false_alarms_per_10000", alarms * 10000 / studies);
    const double deviation = std::sqrt(0.05 * 0.95 / studies);
    EXPECT_LE(alarms, studies * (0.05 + 3 * deviation)) << cells << " x " << repeats;
    EXPECT_GE(alarms, studies * (0.04 - 3 * deviation)) << "Bonferroni loses less than a fifth";
  }
}

// A cell of 9 beside a residual of 1, 0, -1 / 0, 0, 0 / -1, 0, 1 that is orthogonal to it: r = 4,
// 1 - h = 4/9, SS = 36 + 4, s^2 = (40 - 36) / 3, t = 4 / sqrt(4/9 4/3) on three degrees of freedom
TEST(OutliersOfTable, AreByTheExternallyStudentizedResidual) {
  const CompleteTable table = TableOf(3, 3, {11, 20, 29, 40, 59, 60, 69, 80, 91});
  const double t = std::sqrt(27.0);
  const double p = 9 * StudentTwoSidedP(t, 3);
  const CompleteTable least = TableOf(3, 3, std::vector<double>(9, 1e-3));
  EXPECT_TRUE(OutliersOfTable(table, least, p * (1 - 1e-9)).empty());
  const auto found = OutliersOfTable(table, least, p * (1 + 1e-9));
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].group, 1U);
  EXPECT_EQ(found[0].place, 1U);
  EXPECT_REL(found[0].deviation, 9, 1e-13, "rounding");
  EXPECT_REL(found[0].t, t, 1e-12, "rounding of values of 90");
  EXPECT_REL(found[0].p, p, 1e-12, "rounding of values of 90");
  // a least deviation of twice s halves t
  const CompleteTable wide = TableOf(3, 3, std::vector<double>(9, 2 * std::sqrt(4.0 / 3)));
  const double of_wide = 9 * StudentTwoSidedP(t / 2, 3);
  const auto still = OutliersOfTable(table, wide, 1);
  ASSERT_FALSE(still.empty());
  EXPECT_REL(still[0].t, t / 2, 1e-12, "rounding of values of 90");
  EXPECT_REL(still[0].p, std::min(1.0, of_wide), 1e-12, "rounding of values of 90");
}

}  // namespace
}  // namespace haptometer::dsp
