#include "fit/skin/skin_areas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "sim/skin/skin.h"
#include "tests/fit/pulls.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

// ln Ks over ln A with the stated uncertainties
TEST(AreaLaw, IsTheWeightedStraightLine) {
  std::vector<AreaPoint> points;
  for (const double mm2 : {1.0, 5.0, 20.0, 80.0}) {
    points.push_back({mm2 * 1e-6, 600 * std::cbrt(mm2), 0.05, {1.0, 0.0}});
  }
  const auto law = FitAreaLaw(points, {{4e-4, 0}, {0, 0.25}});
  ASSERT_TRUE(law);
  EXPECT_REL(law->exponent, 1.0 / 3, 1e-14, "a power law is a straight line");
  EXPECT_REL(law->at_one_mm2, 600.0, 1e-14, "its constant");
  EXPECT_EQ(law->standard_uncertainty, law->combined_standard_uncertainty)
      << "an input that moves all alike moves no exponent";
  EXPECT_FALSE(law->scatters);
  // inputs that move the exponent by 1 each, fully correlated
  for (auto& point : points) {
    const double slope = std::log(point.area_m2 / 1e-6);
    point.input_responses = {slope, slope};
  }
  const auto moved = FitAreaLaw(points, {{4e-4, 4e-4}, {4e-4, 4e-4}});
  EXPECT_REL(moved->combined_standard_uncertainty, std::hypot(law->standard_uncertainty, 0.04),
             1e-12, "0.02 + 0.02");
  // 1/sqrt(sum (ln A - mean)^2) * u, by hand: ln 1, 5, 20, 80
  EXPECT_REL(law->standard_uncertainty, 0.05 / 3.2518364, 1e-6, "by hand");
  EXPECT_FALSE(FitAreaLaw({points[0]}, {}));
  EXPECT_FALSE(FitAreaLaw({points[0], points[0]}, {}));
}

TEST(AreaLaw, ScatterBeyondChanceWidensIt) {
  std::vector<AreaPoint> points;
  const double factors[]{1.2, 0.8, 1.15, 0.9, 1.1};
  for (int k = 0; k < 5; ++k) {
    points.push_back({std::pow(3, k) * 1e-6, 600 * factors[k], 0.02, {}});
  }
  const auto law = FitAreaLaw(points, {});
  ASSERT_TRUE(law);
  EXPECT_TRUE(law->scatters);
  EXPECT_GT(law->coverage_95, 3) << "Student with 3 degrees of freedom";
  EXPECT_REL(law->standard_uncertainty, law->birge_ratio * 0.02 / (std::log(3) * std::sqrt(10.0)),
             1e-12, "by hand");
}

TEST(AreaLaw, TheThesissFormulaIsNoPurePowerLaw) {
  // between 1 and 100 mm2 it runs from 600 to 2000: mean slope ln(10/3)/ln(100)
  std::vector<AreaPoint> points;
  std::vector<double> thesis;
  for (const double mm2 : {1.0, 100.0}) {
    points.push_back({mm2 * 1e-6, 1000, 0.05, {}});
    thesis.push_back(sim::SkinUnderArea(mm2 * 1e-6, sim::SkinRange::kText).stiffness_n_per_m);
  }
  const auto law = FitAreaLaw(points, {});
  ASSERT_TRUE(law);
  EXPECT_REL(ExponentOf(*law, thesis), std::log(2000.0 / 600) / std::log(100.0), 1e-12,
             "closed form");
}

TEST(AreaLaw, ErrorsAreAsStated) {
  const int repetitions = tests::Repetitions(2000);
  tests::Pulls pulls;
  int covered = 0;
  for (int k = 0; k < repetitions; ++k) {
    std::mt19937_64 engine(static_cast<unsigned>(k) + 1);
    std::normal_distribution<double> noise;
    std::vector<AreaPoint> points;
    for (const double mm2 : {1.0, 3.0, 10.0, 30.0, 80.0}) {
      const double u = 0.02 + 0.001 * mm2;
      points.push_back({mm2 * 1e-6, 600 * std::cbrt(mm2) * std::exp(u * noise(engine)), u, {}});
    }
    const auto law = FitAreaLaw(points, {});
    ASSERT_TRUE(law);
    pulls.Add(law->exponent, 1.0 / 3, law->combined_standard_uncertainty);
    const double half = law->coverage_95 * law->combined_standard_uncertainty;
    covered += std::abs(law->exponent - 1.0 / 3) < half ? 1 : 0;
  }
  std::printf("coverage %.3f\n", static_cast<double>(covered) / repetitions);
  EXPECT_ABS(pulls.mean(), 0.0, 0.15, "unbiased");
  EXPECT_GE(pulls.deviation(), 0.9);
  EXPECT_LE(pulls.deviation(), 1.1);
  EXPECT_GE(covered, 0.93 * repetitions);
}

}  // namespace
}  // namespace haptometer::fit
