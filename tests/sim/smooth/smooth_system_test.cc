#include "sim/smooth/smooth_system.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string_view>

#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr const char* kProbed = "differences of a probe of 2^40 N/m, rounded at that size";

SmoothSystem Sprung(const Scene& scene, const PiecewiseEffects& effects) {
  return AssembleSmooth(scene, effects, {.spring = StiffeningSpring{.cubic_n_per_m3 = 1e9}});
}

// a newton that pulls both together accelerates the mover by -1/Mv and the case by 1/Mc1
TEST(SmoothSystem, ASpringPullsMoverAndCaseTogether) {
  for (const Scene& scene : {tests::AdapterScene(), tests::ConeScene()}) {
    const SmoothSystem system = Sprung(scene, {});
    ASSERT_EQ(system.spring_terms.size(), 1U);
    const SpringTerms& terms = system.spring_terms[0];
    Eigen::VectorXd push = Eigen::VectorXd::Zero(system.linear.modes[0].a.rows());
    push(LinearModel::kMoverVelocity) = 1 / 1.4e-3;
    push(LinearModel::kCaseVelocity) = -1 / CaseSideMass(scene);
    EXPECT_ABS((terms.push - push).cwiseAbs().maxCoeff(), 0, 1e-10, kProbed);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(push.size());
    x(LinearModel::kMover) = 3;
    x(LinearModel::kCase) = 5;
    EXPECT_EQ(terms.deflection.dot(x), -2);
    EXPECT_EQ(system.resistance_ohm, 27);
  }
}

// pressed by d beyond the gap: d'' = -(1/Mv + 1/Mc1) per newton up, and the case is pulled along
TEST(SmoothSystem, ASpringPullsAPadsPenetrationBack) {
  const Scene scene = tests::AdapterScene();
  const double case_kg = CaseSideMass(scene), inverse_kg = 1 / 1.4e-3 + 1 / case_kg;
  const TravelStops pads{.gap_up_m = 2e-4, .gap_down_m = 3e-4, .stiffness_n_per_m = 1e5};
  const SmoothSystem system = Sprung(scene, {.stops = pads});
  ASSERT_EQ(system.spring_terms.size(), 3U);
  for (const std::size_t k : {1U, 2U}) {
    const double side = k == 1 ? 1 : -1, gap_m = k == 1 ? 2e-4 : 3e-4;
    const SpringTerms& terms = system.spring_terms[k];
    EXPECT_REL(terms.push(LinearModel::kMoverVelocity), side * inverse_kg, 1e-11, kProbed);
    EXPECT_REL(terms.push(LinearModel::kCaseVelocity), -1 / case_kg, 1e-11, kProbed);
    Eigen::VectorXd y = Eigen::VectorXd::Zero(terms.push.size());
    y(LinearModel::kMover) = 1e-5;
    y(y.size() - 1) = 1;
    EXPECT_REL(terms.deflection.dot(y), side * (gap_m + 1e-5), 1e-13, "d beyond the gap");
    for (const double pull : terms.guard_pulls) EXPECT_EQ(pull, 0) << "a pad's force is its own";
  }
}

// at rest against a rigid stop the deflection is the gap, and the spring takes its force off the
// force between the two: towards the middle from either side
TEST(SmoothSystem, AtRestTheSpringTakesItsForceOffTheStop) {
  for (const Scene& scene : {tests::AdapterScene(), tests::ConeScene()}) {
    const TravelStops rigid{.gap_up_m = 2e-4, .gap_down_m = 3e-4, .restitution = 0.5};
    const SmoothSystem system = Sprung(scene, {.stops = rigid});
    ASSERT_EQ(system.spring_terms.size(), 3U);
    for (const std::size_t k : {1U, 2U}) {
      const double side = k == 1 ? 1 : -1, gap_m = k == 1 ? 2e-4 : 3e-4;
      const SpringTerms& terms = system.spring_terms[k];
      ASSERT_EQ(terms.guard_pulls.size(), 1U);
      EXPECT_REL(terms.guard_pulls[0], side, 1e-11, kProbed);
      EXPECT_ABS(terms.push.cwiseAbs().maxCoeff(), 0, 1e-10, "both are one body");
      Eigen::VectorXd y = Eigen::VectorXd::Zero(terms.push.size());
      y(y.size() - 1) = 1;
      EXPECT_REL(terms.deflection.dot(y), side * gap_m, 1e-13, "the gap");
    }
  }
}

TEST(SmoothSystem, WithoutASpringHasNoTermsOfOne) {
  const CoilHeating heating{.heat_capacity_j_per_k = 1, .thermal_resistance_k_per_w = 2};
  const SmoothSystem system = AssembleSmooth(tests::AdapterScene(), {}, {.heating = heating});
  EXPECT_TRUE(system.spring_terms.empty());
  EXPECT_EQ(kSceneElements[system.coil_element], std::string_view("coil"));
  EXPECT_EQ(kSceneElements[system.source_element], std::string_view("source"));
}

}  // namespace
}  // namespace haptometer::sim
