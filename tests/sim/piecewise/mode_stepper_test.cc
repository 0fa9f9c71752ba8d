#include "sim/piecewise/mode_stepper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

#include "sim/linear/excitation.h"
#include "tests/residual.h"

namespace haptometer::sim {
namespace {

constexpr double kOmega = 200;

// x' = w [0, 1; -1, 0] x, which a voltage does not reach
Mode Turning() {
  Mode mode{.name = "turning",
            .a = Eigen::MatrixXd::Zero(2, 2),
            .b = Eigen::VectorXd::Zero(2),
            .positions = {},
            .stored_j = {},
            .current_row = Eigen::RowVectorXd::Zero(2)};
  mode.a(0, 1) = kOmega;
  mode.a(1, 0) = -kOmega;
  return mode;
}

ExcitationShape SlowSine() {
  return ShapeOf(Excitation(SineDrive{.amplitude_v = 1, .frequency_hz = 1}).Piece(0));
}

// bounds hold over 64 / |G|_1 = 0.32 s, to which an output step is halved
TEST(ModeStepper, HalvesAnOutputStepToTheHorizonOfBounds) {
  const ExcitationShape shape = SlowSine();
  const PiecewiseLinearSystem system;
  const auto coarsest = [&](const Mode& mode, double step_s) {
    return ModeStepper(system, mode, shape, 1 / step_s).CoarsestLevel();
  };
  Mode guarded = Turning();
  guarded.guards = {{.row = Eigen::RowVector2d(1, 0), .offset = 2}};
  EXPECT_EQ(coarsest(guarded, 0.319), 0);
  EXPECT_EQ(coarsest(guarded, 0.321), 1);
  EXPECT_EQ(coarsest(guarded, 8 * 0.319), 3);
  EXPECT_EQ(coarsest(guarded, 8 * 0.321), 4);
  EXPECT_EQ(coarsest(Turning(), 0.321), 0) << "nothing is guarded";
  Mode watching = Turning();
  watching.watched = {{.row = Eigen::RowVector2d(1, 0)}};
  const ModeStepper stepper(system, watching, shape, 1 / 0.321);
  EXPECT_EQ(stepper.CoarsestLevel(), 0);
  EXPECT_EQ(stepper.WatchLevel(), 1);
}

// a step of a part of an output turns by w h 2^-level, one over 2^power outputs by w h 2^power
TEST(ModeStepper, StepsOverPartsAndPowersOfAnOutput) {
  const ExcitationShape shape = SlowSine();
  const PiecewiseLinearSystem system;
  const Mode mode = Turning();
  constexpr double kRateHz = 1000;
  ModeStepper stepper(system, mode, shape, kRateHz);
  for (const int level : {0, 1, 7}) {
    const double angle = std::ldexp(kOmega / kRateHz, -level);
    EXPECT_ABS(stepper.Step(level)(0, 0), std::cos(angle), 1e-15, "rounding");
    EXPECT_ABS(stepper.Step(level)(0, 1), std::sin(angle), 1e-15, "rounding");
  }
  for (const std::size_t power : {0U, 5U, 12U}) {
    const double angle = std::ldexp(kOmega / kRateHz, static_cast<int>(power));
    const auto step = stepper.LongStep(power).cast<double>().eval();
    EXPECT_ABS(step(0, 0), std::cos(angle), 2e-16 * (1 + angle), "rounding of the angle");
    EXPECT_ABS(step(0, 1), std::sin(angle), 2e-16 * (1 + angle), "rounding of the angle");
  }
}

TEST(ModeStepperDeath, KnowsNoStepBelowATick) {
  const ExcitationShape shape = SlowSine();
  const PiecewiseLinearSystem system;
  const Mode mode = Turning();
  ModeStepper stepper(system, mode, shape, 1000);
  EXPECT_EQ(stepper.Step(50).rows(), 2);
  EXPECT_DEATH(static_cast<void>(stepper.Step(51)), "check failed");
  EXPECT_DEATH(static_cast<void>(stepper.Step(-1)), "check failed");
}

}  // namespace
}  // namespace haptometer::sim
