#include "fit/calibration/outliers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <random>
#include <vector>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

// n points of y = x with uncertain y, of which those at `wrong` have another y
std::vector<LinePoint> Exact(std::size_t n, const std::vector<std::size_t>& wrong = {}) {
  std::vector<LinePoint> points;
  for (std::size_t i = 0; i < n; ++i) {
    points.push_back({static_cast<double>(i), static_cast<double>(i), 0, 1});
  }
  // errors of 20 to 110, no two of which lie on a line with the same points
  for (std::size_t k = 0; k < wrong.size(); ++k) {
    const auto number = static_cast<double>(k + 1);
    points[wrong[k]].y += (k % 2 == 0 ? 20 : -30) * number + 0.37 * number * number;
  }
  return points;
}

std::vector<std::size_t> Places(const std::optional<Outliers>& outliers) {
  std::vector<std::size_t> places;
  if (!outliers) return places;
  for (const Outlier& outlier : outliers->points) places.push_back(outlier.point);
  return places;
}

// `count` places spread over n points
std::vector<std::size_t> Spread(std::size_t n, std::size_t count) {
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < count; ++k) places.push_back((2 * k + 1) * n / (2 * count));
  return places;
}

TEST(Outliers, AreThreeOrOneLessThanHalfAtMost) {
  for (const std::size_t n : {4U, 5U, 6U, 7U, 8U, 9U, 12U, 21U, 50U}) {
    const std::size_t most = std::min<std::size_t>(3, n / 2 - 1);
    for (std::size_t count = 1; count <= most; ++count) {
      const auto wrong = Spread(n, count);
      EXPECT_EQ(Places(FindOutliers(Exact(n, wrong), Scatter::kFromResiduals)), wrong)
          << count << " of " << n;
    }
    const auto more = FindOutliers(Exact(n, Spread(n, most + 1)), Scatter::kFromResiduals);
    EXPECT_LE(Places(more).size(), most) << n;
  }
  EXPECT_FALSE(FindOutliers(Exact(3, {1}), Scatter::kFromResiduals)) << "a line of two points";
}

// A distance matters from a thousandth of the span of y on, wherever y lies.
TEST(Outliers, OfExactPointsMatterByTheSpanOfThem) {
  for (const double off : {0.9e-2, 1.1e-2}) {
    std::vector<LinePoint> points;
    for (int i = 0; i <= 10; ++i) points.push_back({1.0 * i, 1000.0 + i, 0, 1});
    points[4].y += off;
    EXPECT_EQ(Places(FindOutliers(points, Scatter::kFromResiduals)).size(), off > 1e-2 ? 1U : 0U)
        << off;
  }
}

// Eight points of y = x whose residuals +-1 leave the line where it is, and one in their middle
// that lies `distance` off. The usual regression: s^2 = 8/6, and the line is known to s/sqrt(8)
// there.
std::vector<LinePoint> OneOff(double distance, double y_uncertainty) {
  constexpr double kSigns[]{1, -1, -1, 1, 1, -1, -1, 1};
  std::vector<LinePoint> points;
  for (int k = 0; k < 8; ++k) {
    const double x = 100 * (k - 3.5);
    points.push_back({x, x + kSigns[k], 0, y_uncertainty});
  }
  points.push_back({0, distance, 0, y_uncertainty});
  return points;
}

// Student's two-sided probability with 6 degrees of freedom (Abramowitz and Stegun, 26.7.4)
double StudentOfSix(double t) {
  const double angle = std::atan(t / std::sqrt(6.0));
  const double square = std::pow(std::cos(angle), 2);
  return 1 - std::sin(angle) * (1 + square / 2 + 3 * square * square / 8);
}

double Normal(double t) { return std::erfc(t / std::sqrt(2.0)); }

// where a probability that falls is 1 % of three outliers among nine points
double Critical(double (*probability)(double)) {
  double low = 0;
  double high = 100;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (low + high) / 2;
    (9 * probability(middle) > kOutlierByChance / 3 ? low : high) = middle;
  }
  return low;
}

TEST(Outliers, BeginWhereChanceOfAnyPointEnds) {
  // by the residuals: t = distance / hypot(s, s/sqrt(8)), s^2 = 8/6
  const double by_scatter = Critical(StudentOfSix) * std::sqrt(8.0 / 6 * (1 + 1.0 / 8));
  EXPECT_FALSE(FindOutliers(OneOff(0.995 * by_scatter, 1), Scatter::kFromResiduals));
  EXPECT_EQ(Places(FindOutliers(OneOff(1.005 * by_scatter, 1), Scatter::kFromResiduals)),
            std::vector<std::size_t>{8});
  // as stated: 1.5 in place of s, and a normal distribution
  const double stated = Critical(Normal) * 1.5 * std::sqrt(1 + 1.0 / 8);
  EXPECT_FALSE(FindOutliers(OneOff(0.995 * stated, 1.5), Scatter::kStated));
  EXPECT_EQ(Places(FindOutliers(OneOff(1.005 * stated, 1.5), Scatter::kStated)),
            std::vector<std::size_t>{8});
}

TEST(Outliers, AreReportedWithTheirDistancesAndTheOthersScatter) {
  const auto outliers = FindOutliers(OneOff(-40, 1), Scatter::kFromResiduals);
  ASSERT_TRUE(outliers);
  EXPECT_REL(outliers->points.at(0).distance, -40.0, 1e-12, "rounding");
  EXPECT_REL(outliers->scatter, 1.0, 1e-12, "eight residuals of 1");
  EXPECT_REL(outliers->others.slope, 1.0, 1e-12, "rounding");
  EXPECT_EQ(outliers->kept.size(), 8U);
}

TEST(Outliers, LieFartherThanAThousandthOfTheOthersRange) {
  // exact points from 0 to 8 without the one in the middle
  const auto found = [](double distance) {
    auto points = Exact(9);
    points[4].y += distance;
    return Places(FindOutliers(points, Scatter::kFromResiduals));
  };
  EXPECT_TRUE(found(0.995 * 8e-3).empty());
  EXPECT_EQ(found(1.005 * 8e-3), std::vector<std::size_t>{4});
  EXPECT_EQ(found(-1.005 * 8e-3), std::vector<std::size_t>{4});
}

TEST(Outliers, BeyondWhatIsStatedTheScatterOfTheOthersDecides) {
  // residuals of +-1 that are stated as 0.1: the same limit as without a statement
  const double by_scatter = Critical(StudentOfSix) * std::sqrt(8.0 / 6 * (1 + 1.0 / 8));
  EXPECT_FALSE(FindOutliers(OneOff(0.995 * by_scatter, 0.1), Scatter::kStated));
  EXPECT_EQ(Places(FindOutliers(OneOff(1.005 * by_scatter, 0.1), Scatter::kStated)),
            std::vector<std::size_t>{8});
}

// squares that the usual regression leaves of the points that are not left out
double SquaresWithout(const std::vector<bool>& is_left, const std::vector<LinePoint>& points) {
  double count = 0;
  double x = 0;
  double y = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_left[i]) continue;
    ++count;
    x += points[i].x;
    y += points[i].y;
  }
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_left[i]) continue;
    xx += std::pow(points[i].x - x / count, 2);
    xy += (points[i].x - x / count) * (points[i].y - y / count);
    yy += std::pow(points[i].y - y / count, 2);
  }
  return yy - xy * xy / xx;
}

// the `count` points without which the others lie nearest to their line, of all choices
std::vector<std::size_t> LeastTrimmedLeaves(std::size_t count,
                                            const std::vector<LinePoint>& points) {
  std::vector<bool> is_left(points.size());
  std::fill_n(is_left.rbegin(), count, true);
  std::vector<bool> best = is_left;
  while (std::next_permutation(is_left.begin(), is_left.end())) {
    if (SquaresWithout(is_left, points) < SquaresWithout(best, points)) best = is_left;
  }
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < best.size(); ++i) {
    if (best[i]) places.push_back(i);
  }
  return places;
}

TEST(Outliers, OfAsManyAsThereMayBeAreThoseOfAllChoices) {
  // 6 to 9 points far from y = 0, as of a sensor whose zero lies elsewhere; the outliers lie on a
  // line of their own, 10 to 90 away
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int number = 0; number < 400; ++number) {
    const std::size_t n = 6 + static_cast<std::size_t>(number % 4);
    const std::size_t most = std::min<std::size_t>(3, n / 2 - 1);
    std::vector<LinePoint> points(n);
    std::vector<bool> is_wrong(n);
    std::fill_n(is_wrong.begin(), most, true);
    std::shuffle(is_wrong.begin(), is_wrong.end(), random);
    const double slope = 1 + share(random);
    const double shift = 50 + 20 * share(random);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = 20 * share(random);
      const double y = is_wrong[i] ? shift + slope * x : x;
      points[i] = {x, 1000 + y + 0.01 * share(random), 0, 1};
    }
    const auto expected = LeastTrimmedLeaves(most, points);
    EXPECT_EQ(Places(FindOutliers(points, Scatter::kFromResiduals)), expected) << number;
  }
}

}  // namespace
}  // namespace haptometer::fit
