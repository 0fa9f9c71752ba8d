#include "sim/linear/linear_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/linear/steady_state.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

// Newton's third law: whatever the states, the forces between the bodies sum to zero, so the total
// momentum changes by the skin's force alone.
TEST(LinearModel, KeepsMomentum) {
  for (const Scene& scene : {tests::AdapterScene(), tests::DirectScene()}) {
    const LinearModel model = AssembleModel(scene);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(model.states(), 0.3, -1.7);
    const Eigen::VectorXd rate = model.a * x;
    double force_n = scene.actuator.moving_mass_kg * rate(LinearModel::kMoverVelocity);
    double case_kg = scene.actuator.case_mass_kg;
    if (scene.adapter) {
      case_kg += scene.adapter->motor_side_mass_kg;
      force_n += scene.adapter->skin_side_mass_kg * rate(model.skin_velocity());
    }
    force_n += case_kg * rate(LinearModel::kCaseVelocity);
    const double skin_n = -scene.skin.stiffness_n_per_m * x(model.skin()) -
                          scene.skin.damping_n_s_per_m * x(model.skin_velocity());
    EXPECT_REL(force_n, skin_n, 5e-15, "springs of kN cancel in the sum");
  }
}

// What rounding left out is kept where it counts: the coil's forces are equal and opposite to the
// 64 bits of long double, for a spring whose entries of double leave over 1e-16 of 0.2 N.
TEST(LinearModel, KeepsWhatRoundingLeavesOutOfAStiffMover) {
  Scene scene = tests::AdapterScene();
  EXPECT_EQ(AssembleModel(scene).a_rest.size(), 0);
  scene.actuator.stiffness_n_per_m = 1e11;
  for (const double inductance_h : {130e-6, 0.0}) {
    scene.actuator.inductance_h = inductance_h;
    const LinearModel model = AssembleModel(scene);
    ASSERT_EQ(model.a_rest.rows(), model.states());
    const auto entry = [&](Eigen::Index row, Eigen::Index column) {
      return static_cast<long double>(model.a(row, column)) +
             static_cast<long double>(model.a_rest(row, column));
    };
    const auto mover_kg = static_cast<long double>(scene.actuator.moving_mass_kg);
    const auto case_kg = static_cast<long double>(scene.actuator.case_mass_kg) +
                         static_cast<long double>(scene.adapter->motor_side_mass_kg);
    // on the mover's position and velocity (and the current) nothing but the pair acts
    for (const Eigen::Index column : {Eigen::Index{0}, Eigen::Index{1}, model.states() - 1}) {
      if (column == model.skin_velocity()) continue;
      const long double mover_n = mover_kg * entry(1, column);
      const long double left_n = mover_n + case_kg * entry(3, column);
      EXPECT_LE(std::abs(left_n), 2e-19L * std::abs(mover_n)) << column;
    }
  }
}

// w = sqrt(Kv (1/Mv + 1/Mc1)) of mover and case alone
TEST(LinearModel, KeepsRoundingOfMoversAboveTheStatedFrequency) {
  Scene scene = tests::AdapterScene();
  const double inverse_kg = 1 / 1.4e-3 + 1 / 0.85e-3;
  for (const double part : {0.996, 1.004}) {
    const double w = part * 2e4;
    scene.actuator.stiffness_n_per_m = w * w / inverse_kg;
    EXPECT_EQ(AssembleModel(scene).a_rest.size() > 0, part > 1);
  }
  // without the adapter's motor side, and against a case that is held
  scene.adapter.reset();
  scene.actuator.stiffness_n_per_m = 0.992 * 4e8 / (1 / 1.4e-3 + 1 / 0.6e-3);
  EXPECT_EQ(AssembleModel(scene).a_rest.size(), 0);
  scene.grip.holds = true;
  scene.actuator.stiffness_n_per_m = 0.992 * 4e8 * 1.4e-3;
  EXPECT_EQ(AssembleModel(scene).a_rest.size(), 0);
  scene.actuator.stiffness_n_per_m = 1.008 * 4e8 * 1.4e-3;
  EXPECT_GT(AssembleModel(scene).a_rest.size(), 0);
}

// The power that the back EMF takes from the coil is the power that the force pair puts in.
TEST(LinearModel, CouplesCoilAndBodiesReciprocally) {
  const Scene scene = tests::AdapterScene();
  const LinearModel model = AssembleModel(scene);
  const double mv = scene.actuator.moving_mass_kg;
  const double mc1 = scene.actuator.case_mass_kg + scene.adapter->motor_side_mass_kg;
  const double l = scene.actuator.inductance_h;
  EXPECT_EQ(model.a(6, 1) * l, -model.a(1, 6) * mv);
  EXPECT_REL(model.a(6, 3) * l, -model.a(3, 6) * mc1, 2e-16, "rounding");
  EXPECT_EQ(model.b(6) * l, 1);
  EXPECT_EQ(model.b.head(6), Eigen::VectorXd::Zero(6));
}

// Without inductance the coil is a damper Km^2/R and a force Km v/R, and its current is no state.
TEST(LinearModel, WithoutInductanceHasNoStateForTheCurrent) {
  Scene scene = tests::AdapterScene();
  const Eigen::Index with = AssembleModel(scene).states();
  scene.actuator.inductance_h = 0;
  const LinearModel model = AssembleModel(scene);
  EXPECT_EQ(model.states(), with - 1);
  EXPECT_EQ(model.skin(), 4);
  const Actuator& motor = scene.actuator;
  Actuator damped = motor;
  damped.damping_n_s_per_m += motor.force_constant_n_per_a * motor.force_constant_n_per_a / 27;
  damped.inductance_h = 1;  // what its coil does stays in the seventh state
  const Eigen::MatrixXd expected = AssembleModel(damped, scene.adapter, scene.skin).a;
  EXPECT_ABS((model.a - expected.topLeftCorner(6, 6)).cwiseAbs().maxCoeff(), 0, 2e-13,
             "rounding of entries up to 4e3 1/s");
  EXPECT_REL(model.b(1) * motor.moving_mass_kg, -motor.force_constant_n_per_a / 27, 3e-16,
             "rounding");
  EXPECT_REL(model.b(3) * 0.85e-3, motor.force_constant_n_per_a / 27, 3e-16, "rounding");
  // R i = v - Km (va - vv)
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(6, 0.3, -1.7);
  EXPECT_REL(model.current_row.dot(x) + model.current_per_volt * 5, (5 - (x(3) - x(1))) / 27, 5e-16,
             "rounding");
  // four states suffice without an adapter
  scene.adapter.reset();
  EXPECT_EQ(AssembleModel(scene).states(), 4);
  EXPECT_EQ(AssembleModel(scene).skin(), LinearModel::kCase);
}

// Without springs, dampers and current every body keeps its velocity.
TEST(LinearModel, OfPositionsIsTheVelocities) {
  const LinearModel model = AssembleModel(tests::AdapterScene());
  for (const Eigen::Index position : {LinearModel::kMover, LinearModel::kCase, model.skin()}) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(7);
    row(position + 1) = 1;
    EXPECT_EQ(model.a.row(position).transpose(), row);
  }
}

TEST(LinearModel, WithoutAnAdapterHasTheCaseOnTheSkin) {
  const LinearModel model = AssembleModel(tests::ConeScene());
  EXPECT_EQ(model.states(), 5);
  EXPECT_EQ(model.skin(), LinearModel::kCase);
  EXPECT_EQ(StateOf(model, SensorTarget::kSkin), StateOf(model, SensorTarget::kCase));
  EXPECT_EQ(StateOf(model, SensorTarget::kMover), LinearModel::kMover);
  const LinearModel with = AssembleModel(tests::AdapterScene());
  EXPECT_EQ(StateOf(with, SensorTarget::kSkin), 4);
  EXPECT_EQ(StateOf(with, SensorTarget::kCase), LinearModel::kCase);
}

// An adapter so stiff that it is a rod is the bare case with both masses added to it.
TEST(LinearModel, WithARigidAdapterIsTheHeavierCase) {
  Scene rigid = tests::AdapterScene();
  rigid.adapter->stiffness_n_per_m = 1e12;
  Scene heavy = tests::ConeScene();
  heavy.actuator.case_mass_kg += 0.25e-3 + 4.35e-3;
  const SteadyState one = SolveSteadyState(rigid);
  const SteadyState other = SolveSteadyState(heavy);
  EXPECT_REL(one.skin_rms_m, other.skin_rms_m, 3e-8, "the rod gives by forces of 1e4 N/m in 1e12");
  EXPECT_REL(one.power_w, other.power_w, 3e-8, "the same");
}

TEST(LinearModelDeath, NeedsMasses) {
  Scene scene = tests::ConeScene();
  scene.actuator.case_mass_kg = 0;
  EXPECT_DEATH(static_cast<void>(AssembleModel(scene)), "check failed");
  scene = tests::ConeScene();
  scene.actuator.moving_mass_kg = 0;
  EXPECT_DEATH(static_cast<void>(AssembleModel(scene)), "check failed");
  scene = tests::AdapterScene();
  scene.adapter->skin_side_mass_kg = 0;
  EXPECT_DEATH(static_cast<void>(AssembleModel(scene)), "check failed");
}

TEST(LinearModelDeath, NeedsAResistanceAndNoNegativeInductance) {
  Scene scene = tests::ConeScene();
  scene.actuator.resistance_ohm = 0;
  EXPECT_DEATH(static_cast<void>(AssembleModel(scene)), "check failed");
  scene.actuator.resistance_ohm = 1e-9;
  EXPECT_EQ(AssembleModel(scene).states(), 5);
  scene.actuator.inductance_h = -1e-9;
  EXPECT_DEATH(static_cast<void>(AssembleModel(scene)), "check failed");
}

TEST(LinearModelDeath, HoldsNoCaseUnderAnAdapter) {
  Scene scene = tests::AdapterScene();
  scene.grip.holds = true;
  EXPECT_DEATH(static_cast<void>(AssembleModel(scene)), "check failed");
}

}  // namespace
}  // namespace haptometer::sim
