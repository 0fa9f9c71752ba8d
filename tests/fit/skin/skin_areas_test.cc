#include "fit/skin/skin_areas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <utility>
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

TEST(AreaLaw, NeedsAreasThatAreATenthApart) {
  const auto law = [](double ratio) {
    return FitAreaLaw({{1e-5, 600, 0.05, {}}, {ratio * 1e-5, 700, 0.05, {}}}, {});
  };
  EXPECT_FALSE(law(1.0995));
  EXPECT_TRUE(law(1.1005));
  EXPECT_REL(law(1.1005)->coverage_95, 1.96, 1e-15, "two points leave no scatter");
  EXPECT_EQ(law(1.1005)->birge_ratio, 0);
}

TEST(AreaLaw, ScattersBeyondTheUpperTwentiethOfChiSquare) {
  // areas a factor e apart whose logarithms lie +-off beside a line: chi^2 = (1 + 4 + 1) off^2/u^2
  // with 1 degree of freedom, 3.841459 of which is exceeded once in 20 (1.959964^2)
  const double u = 0.05;
  const double limit = 1.959963984540054 * u / std::sqrt(6.0);
  const auto law = [u](double off) {
    std::vector<AreaPoint> points;
    for (const auto& [k, share] : {std::pair(-1, 1), std::pair(0, -2), std::pair(1, 1)}) {
      points.push_back({1e-5 * std::exp(k), 600 * std::exp(0.3 * k + share * off), u, {}});
    }
    return *FitAreaLaw(points, {});
  };
  const AreaLaw within = law(0.995 * limit);
  EXPECT_FALSE(within.scatters);
  EXPECT_REL(within.exponent, 0.3, 1e-12, "the rest is orthogonal");
  EXPECT_REL(within.birge_ratio, 0.995 * 1.959963984540054, 1e-9, "rounding of logarithms");
  EXPECT_REL(within.standard_uncertainty, u / std::sqrt(2.0), 1e-12, "by hand");
  EXPECT_REL(within.coverage_95, 1.96, 1e-15, "a normal distribution");
  const AreaLaw beyond = law(1.005 * limit);
  EXPECT_TRUE(beyond.scatters);
  EXPECT_REL(beyond.standard_uncertainty, beyond.birge_ratio * u / std::sqrt(2.0), 1e-12,
             "by hand");
  EXPECT_REL(beyond.coverage_95, 12.7062047361747, 1e-9, "Student's t, 1 degree, qt(0.975, 1)");
}

TEST(AreaDependence, HoldsTheEndsOfItsInterval) {
  AreaDependence dependence{};
  dependence.lower_95 = 0.2;
  dependence.upper_95 = 0.4;
  EXPECT_TRUE(Holds(dependence, 0.2));
  EXPECT_TRUE(Holds(dependence, 0.4));
  EXPECT_FALSE(Holds(dependence, 0.199));
  EXPECT_FALSE(Holds(dependence, 0.401));
}

// a contact of some area whose Ks and Bs are known to 3 and 4 %
SkinFit Contact(double area_mm2, double stiffness, double damping) {
  SkinFit contact;
  contact.area_m2 = area_mm2 * 1e-6;
  contact.stiffness = {.value = stiffness,
                       .standard_uncertainty = 0.03 * stiffness,
                       .at_most = {},
                       .unit = "N/m",
                       .determined = true};
  contact.damping = {.value = damping,
                     .standard_uncertainty = 0.04 * damping,
                     .at_most = {},
                     .unit = "N s/m",
                     .determined = true};
  // none of the actuator's numbers moves them
  contact.influences.resize(8);
  return contact;
}

TEST(SkinAreas, IntervalsAreThoseOfBothConstants) {
  const auto areas = FitSkinAreas({Contact(10, 800, 1), Contact(40, 1400, 1.5)});
  ASSERT_TRUE(areas.stiffness && areas.damping);
  // an exponent of two points: u = sqrt(2) u(ln) / ln 4
  const auto expect = [](const AreaDependence& found, double exponent, double share) {
    const double half = 1.96 * share * std::sqrt(2.0) / std::log(4);
    EXPECT_REL(found.law.exponent, exponent, 1e-12, "closed form");
    EXPECT_REL(found.lower_95, exponent - half, 1e-12, "closed form");
    EXPECT_REL(found.upper_95, exponent + half, 1e-12, "closed form");
    EXPECT_EQ(found.holds_one_third, std::abs(exponent - 1.0 / 3) < half);
  };
  expect(*areas.stiffness, std::log(1.75) / std::log(4), 0.03);
  expect(*areas.damping, std::log(1.5) / std::log(4), 0.04);
  EXPECT_FALSE(areas.stiffness->holds_one_third) << "0.404 +- 0.060";
  EXPECT_TRUE(areas.damping->holds_one_third) << "0.292 +- 0.080";
}

TEST(SkinAreas, TheThesissFormulaHoldsFromOneToAHundredSquareMillimetres) {
  const auto exponent_of = [](double least_mm2, double most_mm2) {
    return FitSkinAreas({Contact(least_mm2, 800, 1), Contact(most_mm2, 1400, 1.5)})
        .stiffness->thesis_text;
  };
  EXPECT_TRUE(exponent_of(1.001, 99.9));
  EXPECT_FALSE(exponent_of(0.999, 50));
  EXPECT_FALSE(exponent_of(2, 100.1));
  // stiffness from 600 to 2000 N/m in a line with the cube root of the area, from 1 to 100 mm2
  const auto line = [](double mm2) {
    return 600 + 1400 * (std::cbrt(mm2) - 1) / (std::cbrt(100.0) - 1);
  };
  EXPECT_REL(*exponent_of(8, 64), std::log(line(64) / line(8)) / std::log(8), 1e-9, "closed form");
}

TEST(SkinAreas, WhatIsNotDeterminedOrHasNoAreaDoesNotCount) {
  auto faint = Contact(20, 5000, 9);
  faint.stiffness.determined = false;
  auto unstated = Contact(20, 5000, 9);
  unstated.area_m2.reset();
  const auto areas = FitSkinAreas({Contact(10, 800, 1), faint, unstated, Contact(40, 1400, 1.5)});
  EXPECT_REL(areas.stiffness->law.exponent, std::log(1.75) / std::log(4), 1e-12, "two areas");
  EXPECT_GT(areas.damping->law.birge_ratio, 0) << "three areas";
}

TEST(SkinAreas, AnActuatorsErrorMovesTheExponentByTheDifferenceOfItsInfluences) {
  auto small = Contact(10, 800, 1);
  auto large = Contact(40, 1400, 1.5);
  small.influences[4].stiffness_percent_per_percent = 0.9;
  large.influences[4].stiffness_percent_per_percent = 1.6;
  small.influences[4].damping_percent_per_percent = 1.1;
  large.influences[4].damping_percent_per_percent = 0.7;
  small.influences[0].stiffness_percent_per_percent = -0.2;
  large.influences[0].stiffness_percent_per_percent = 0.3;
  for (auto* contact : {&small, &large}) {
    contact->actuator_covariance[0][0] = 9e-4;
    contact->actuator_covariance[4][4] = 25e-4;
    contact->actuator_covariance[0][4] = contact->actuator_covariance[4][0] = 7.5e-4;
  }
  const auto areas = FitSkinAreas({small, large});
  ASSERT_TRUE(areas.stiffness && areas.damping);
  // 3 % of Mv and 5 % of Km, correlated by a half
  const double by_mass = 0.03 * 0.5 / std::log(4);
  const double by_constant = 0.05 * 0.7 / std::log(4);
  const double given =
      std::sqrt(by_mass * by_mass + by_constant * by_constant + 2 * 0.5 * by_mass * by_constant);
  EXPECT_REL(areas.stiffness->law.combined_standard_uncertainty,
             std::hypot(0.03 * std::sqrt(2.0) / std::log(4), given), 1e-12, "closed form");
  EXPECT_REL(areas.damping->law.combined_standard_uncertainty,
             std::hypot(0.04 * std::sqrt(2.0), 0.05 * 0.4) / std::log(4), 1e-12, "closed form");
}

TEST(SkinAreas, TheThesissExponentsAreThoseOfItsTextAndItsTable) {
  const auto areas = FitSkinAreas({Contact(8, 800, 1), Contact(64, 1400, 1.5)});
  ASSERT_TRUE(areas.stiffness && areas.damping);
  for (const auto range : {sim::SkinRange::kText, sim::SkinRange::kTable}) {
    const auto least = sim::SkinUnderArea(8e-6, range);
    const auto most = sim::SkinUnderArea(64e-6, range);
    const bool is_text = range == sim::SkinRange::kText;
    const auto& stiffness = is_text ? areas.stiffness->thesis_text : areas.stiffness->thesis_table;
    const auto& damping = is_text ? areas.damping->thesis_text : areas.damping->thesis_table;
    EXPECT_REL(*stiffness, std::log(most.stiffness_n_per_m / least.stiffness_n_per_m) / std::log(8),
               1e-12, "closed form");
    EXPECT_REL(*damping, std::log(most.damping_n_s_per_m / least.damping_n_s_per_m) / std::log(8),
               1e-12, "closed form");
  }
}

TEST(AreaLaw, PointsCountByTheReciprocalsOfTheirVariances) {
  // logarithms 0, 1 and 3 of the areas with weights 1, 4 and 1: mean 7/6, spread 29/6
  const double values[]{500, 700, 900};
  std::vector<AreaPoint> points{{1e-6, values[0], 0.1, {}},
                                {std::exp(1) * 1e-6, values[1], 0.05, {}},
                                {std::exp(3) * 1e-6, values[2], 0.1, {}}};
  const auto law = FitAreaLaw(points, {});
  ASSERT_TRUE(law);
  const double weights[]{-7.0 / 29, -4.0 / 29, 11.0 / 29};
  double exponent = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_REL(law->weights[k], weights[k], 1e-12, "by hand");
    exponent += weights[k] * std::log(values[k]);
  }
  EXPECT_REL(law->exponent, exponent, 1e-12, "by hand");
  const double level = (std::log(500) + 4 * std::log(700) + std::log(900)) / 6;
  EXPECT_REL(law->at_one_mm2, std::exp(level - exponent * 7 / 6), 1e-12, "by hand");
  EXPECT_REL(law->standard_uncertainty / std::max(law->scatters ? law->birge_ratio : 1.0, 1.0),
             0.1 / std::sqrt(29.0 / 6), 1e-12, "by hand");
}

}  // namespace
}  // namespace haptometer::fit
