#include "sim/piecewise/piecewise_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/piecewise/piecewise_scene.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kGravity = 9.81;
constexpr SineDrive kNoDrive{};

Eigen::VectorXd State(std::initializer_list<double> values) {
  return Eigen::Map<const Eigen::VectorXd>(values.begin(),
                                           static_cast<Eigen::Index>(values.size()));
}

// a mass of 1 kg at height h over the floor, x = [h, v, 1]; at rest only the constant is left
PiecewiseLinearSystem Ball(double restitution) {
  Mode flight{.name = "flight",
              .a = Eigen::MatrixXd::Zero(3, 3),
              .b = Eigen::VectorXd::Zero(3),
              .positions = {},
              .stored_j = Eigen::MatrixXd::Zero(3, 3),
              .current_row = Eigen::RowVectorXd::Zero(3)};
  flight.a(0, 1) = 1;
  flight.a(1, 2) = -kGravity;
  flight.stored_j(1, 1) = 0.5;
  flight.stored_j(0, 2) = flight.stored_j(2, 0) = kGravity / 2;
  flight.guards = {{.row = Eigen::RowVectorXd::Unit(3, 0), .offset = 0, .transition = 0}};
  Mode rest{.name = "rest",
            .a = Eigen::MatrixXd::Zero(1, 1),
            .b = Eigen::VectorXd::Zero(1),
            .positions = Eigen::Vector3d::Unit(2),
            .stored_j = Eigen::MatrixXd::Zero(1, 1),
            .current_row = Eigen::RowVectorXd::Zero(1)};
  Transition impact{.name = "impact",
                    .mode = 0,
                    .map = Eigen::Vector3d(1, -restitution, 1).asDiagonal(),
                    .shift = Eigen::VectorXd::Zero(3)};
  impact.departure = Departure{.guard = 0, .order = restitution > 0 ? std::size_t{1} : 2};
  impact.bounce = Bounce{.restitution = restitution, .rest_height = 1e-14, .rest_via = 1};
  Transition stay{.name = "rest",
                  .mode = 1,
                  .map = Eigen::RowVector3d::Unit(2),
                  .shift = Eigen::VectorXd::Zero(1)};
  return {.modes = {flight, rest}, .transitions = {impact, stay}, .dissipating_elements = {}};
}

// x'' = -w^2 x from x = 0, x' = w: x = sin w t, under guards of x
PiecewiseLinearSystem Swing(double omega, const std::vector<Guard>& guards) {
  Mode mode{.name = "swing",
            .a = Eigen::MatrixXd::Zero(2, 2),
            .b = Eigen::VectorXd::Zero(2),
            .positions = {},
            .stored_j = Eigen::MatrixXd::Identity(2, 2) / 2,
            .current_row = Eigen::RowVectorXd::Zero(2)};
  mode.a(0, 1) = omega;
  mode.a(1, 0) = -omega;
  mode.guards = guards;
  // an event turns to a mode of the same motion that knows no guards
  Mode after = mode;
  after.guards.clear();
  const Transition pass{.name = "pass",
                        .mode = 1,
                        .map = Eigen::Matrix2d::Identity(),
                        .shift = Eigen::Vector2d::Zero()};
  return {.modes = {mode, after}, .transitions = {pass}, .dissipating_elements = {}};
}

void RunTo(PiecewiseMotion& motion, std::uint64_t index) {
  while (motion.index() < index && !motion.stalled_at_s()) motion.Next();
}

TEST(PiecewiseMotion, ABouncingBallFollowsTheClosedForm) {
  constexpr double e = 0.7;
  PiecewiseMotion ball(Ball(e), kNoDrive, {.x = State({1, 0, 1})}, 100, true);
  RunTo(ball, 400);
  const double first_s = std::sqrt(2 / kGravity);
  double expected_s = first_s, flight_s = 2 * first_s;
  ASSERT_GT(ball.events().size(), 30U);
  for (std::size_t k = 0; k + 1 < ball.events().size(); ++k) {
    EXPECT_ABS(ball.events()[k].time_s, expected_s, 1e-14, "rounding of times near 2 s");
    flight_s *= e;
    expected_s += flight_s;
  }
  const double zeno_s = first_s * (1 + e) / (1 - e);
  EXPECT_REL(ball.events().back().time_s, zeno_s, 1e-14, "a sum of some forty flights");
  EXPECT_EQ(ball.events().back().transition, 1U);
  EXPECT_EQ(ball.mode(), 1U);
  EXPECT_EQ(ball.Positions()(0), 0);
  EXPECT_LT(ball.Ledger().Imbalance(), 1e-14);
  EXPECT_REL(ball.Ledger().impact_j, kGravity, 1e-14, "all of the fall's energy");
}

TEST(PiecewiseMotion, ABallWithoutReboundRestsAtOnceAndAPerfectOneNever) {
  PiecewiseMotion dead(Ball(0), kNoDrive, {.x = State({1, 0, 1})}, 100);
  RunTo(dead, 100);
  ASSERT_EQ(dead.events().size(), 2U);
  EXPECT_REL(dead.events()[1].time_s, std::sqrt(2 / kGravity), 1e-15, "one event");

  PiecewiseMotion perfect(Ball(1), kNoDrive, {.x = State({1, 0, 1})}, 100, true);
  RunTo(perfect, 10000);
  const double first_s = std::sqrt(2 / kGravity);
  for (std::size_t k = 0; k < perfect.events().size(); ++k) {
    EXPECT_REL(perfect.events()[k].time_s, first_s * (2 * static_cast<double>(k) + 1), 2e-13,
               "rounding of a hundred bounces adds up");
  }
  EXPECT_EQ(perfect.events().size(), 111U);
  EXPECT_LT(perfect.Ledger().Imbalance(), 1e-12);
}

TEST(PiecewiseMotion, AlmostPerfectBouncesAlsoComeToRest) {
  constexpr double e = 0.98;
  PiecewiseMotion ball(Ball(e), kNoDrive, {.x = State({1e-3, 0, 1})}, 100);
  RunTo(ball, 200);
  EXPECT_REL(ball.events().back().time_s, std::sqrt(2e-3 / kGravity) * (1 + e) / (1 - e), 1e-11,
             "six hundred bounces, each from the one before");
  EXPECT_EQ(ball.mode(), 1U);
}

TEST(PiecewiseMotion, AGrazeIsDecidedAndTimed) {
  constexpr double omega = 2 * std::numbers::pi * 225;
  for (const double rate_hz : {1e4, 317.0, 40.0}) {
    for (const double part : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13}) {
      for (const double sign : {-1.0, 1.0}) {
        const double gap = 1 + sign * part;
        const Guard guard{.row = -Eigen::RowVectorXd::Unit(2, 0), .offset = gap, .transition = 0};
        PiecewiseMotion motion(Swing(omega, {guard}), kNoDrive, {.x = State({0, 1})}, rate_hz);
        RunTo(motion, static_cast<std::uint64_t>(std::ceil(0.004 * rate_hz)));
        ASSERT_EQ(motion.events().size(), sign < 0 ? 1U : 0U) << part << " at " << rate_hz << " Hz";
        if (sign > 0) continue;
        const double before_peak = std::acos(gap);
        const double time_s = (std::numbers::pi / 2 - before_peak) / omega;
        const double speed = omega * std::sin(before_peak);
        EXPECT_ABS(motion.events()[0].time_s, time_s, std::max(1e-15, 1e-15 / speed),
                   "rounding of the state over the speed of crossing, A = 1");
      }
    }
  }
}

// x = sin w t reflected at +-wall, asked for every 0.1 s
void ExpectReflections(double wall, double tolerance_s, const char* reason) {
  constexpr double omega = 2 * std::numbers::pi * 225;
  const Guard up{.row = -Eigen::RowVectorXd::Unit(2, 0), .offset = wall, .transition = 0};
  const Guard down{.row = Eigen::RowVectorXd::Unit(2, 0), .offset = wall, .transition = 1};
  PiecewiseLinearSystem system = Swing(omega, {up, down});
  system.transitions[0].mode = 0;
  system.transitions[0].map = Eigen::Vector2d(1, -1).asDiagonal();
  system.transitions[0].departure = Departure{.guard = 0};
  system.transitions.push_back(system.transitions[0]);
  system.transitions[1].departure = Departure{.guard = 1};
  PiecewiseMotion motion(system, kNoDrive, {.x = State({0, 1})}, 10);
  RunTo(motion, 10);
  const double to_wall_s = std::asin(wall) / omega;
  EXPECT_EQ(motion.events().size(),
            static_cast<std::size_t>(std::floor(1 / (2 * to_wall_s) - 0.5)) + 1);
  for (std::size_t k = 0; k < motion.events().size(); ++k) {
    EXPECT_EQ(motion.events()[k].transition, k % 2);
    EXPECT_ABS(motion.events()[k].time_s, (2 * static_cast<double>(k) + 1) * to_wall_s, tolerance_s,
               reason);
  }
}

TEST(PiecewiseMotion, EveryCrossingWithinAStepIsFound) {
  ExpectReflections(0.9, 1e-12, "the bar for events; 450 of them, each from the one before");
  ExpectReflections(0.999999, 1e-10, "the bar for grazes; crossed at 1.4e-3 of the speed");
}

TEST(PiecewiseMotion, NearlyAndTrulySimultaneousEventsKeepTheirOrder) {
  constexpr double omega = 2 * std::numbers::pi * 225;
  for (const double apart : {1e-3, 1e-9, 1e-13, 0.0, -1e-13, -1e-9, -1e-3}) {
    const Guard one{.row = -Eigen::RowVectorXd::Unit(2, 0), .offset = 0.5, .transition = 0};
    const Guard two{.row = -Eigen::RowVectorXd::Unit(2, 0), .offset = 0.5 + apart, .transition = 1};
    PiecewiseLinearSystem system = Swing(omega, {one, two});
    // after either, the other is still guarded; after both, none
    const Mode none = system.modes[1];
    Mode only_one = none, only_two = none;
    only_one.guards = {one};
    only_two.guards = {two};
    only_one.guards[0].transition = only_two.guards[0].transition = 2;
    system.modes = {system.modes[0], only_two, only_one, none};
    system.transitions.resize(3, system.transitions[0]);
    system.transitions[1].mode = 2;
    system.transitions[2].mode = 3;
    PiecewiseMotion motion(system, kNoDrive, {.x = State({0, 1})}, 300);
    RunTo(motion, 1);
    ASSERT_EQ(motion.events().size(), 2U) << apart;
    EXPECT_EQ(motion.events()[0].transition, apart >= 0 ? 0U : 1U) << apart;
    const double first = std::min(0.5, 0.5 + apart), second = std::max(0.5, 0.5 + apart);
    EXPECT_ABS(motion.events()[0].time_s, std::asin(first) / omega, 1e-17,
               "a dozen products, eps/w each");
    EXPECT_ABS(motion.events()[1].time_s, std::asin(second) / omega, 1e-17,
               "a dozen products, eps/w each");
  }
}

TEST(PiecewiseMotion, AnEndlessToAndFroIsSaidToStall) {
  // two modes that each hand over to the other at once
  PiecewiseLinearSystem system =
      Swing(1, {{.row = -Eigen::RowVectorXd::Unit(2, 0), .offset = 0.5, .transition = 0}});
  system.modes[1].guards = {
      {.row = -Eigen::RowVectorXd::Unit(2, 0), .offset = 0.4, .transition = 1}};
  system.modes[0].guards[0].offset = 0.5;
  system.transitions.push_back(system.transitions[0]);
  system.transitions[1].mode = 0;
  PiecewiseMotion motion(system, kNoDrive, {.x = State({0, 1})}, 100);
  RunTo(motion, 100);
  ASSERT_TRUE(motion.stalled_at_s().has_value());
  EXPECT_REL(*motion.stalled_at_s(), std::asin(0.5), 1e-14, "where the first event was");
  EXPECT_EQ(motion.stall_reason(), FindingKind::kEventsWithoutEnd);
}

TEST(PiecewiseMotion, WhatIsTooFastForItsOutputsIsSaidToStall) {
  // a wall that is nearly reached in each of 1e9 swings between two outputs
  const Guard wall{.row = -Eigen::RowVectorXd::Unit(2, 0), .offset = 1.001, .transition = 0};
  constexpr double omega = 2 * std::numbers::pi * 1e9;
  PiecewiseMotion motion(Swing(omega, {wall}), kNoDrive, {.x = State({0, 1})}, 1);
  RunTo(motion, 2);
  ASSERT_TRUE(motion.stalled_at_s().has_value());
  EXPECT_EQ(motion.stall_reason(), FindingKind::kBodiesTooFast);
  EXPECT_GT(*motion.stalled_at_s(), 0);
  EXPECT_LT(*motion.stalled_at_s(), 1);
  EXPECT_TRUE(motion.events().empty());
}

TEST(PiecewiseMotion, AMillionCyclesKeepTheirEnergy) {
  // at 100 outputs a second; the bench takes 10 000
  constexpr double omega = 2 * std::numbers::pi * 225;
  PiecewiseMotion motion(Swing(omega, {}), kNoDrive, {.x = State({0, 1})}, 100, true);
  RunTo(motion, 444444);
  EXPECT_LT(motion.Ledger().Imbalance(), 1e-9);
  EXPECT_ABS(motion.x()(0), std::sin(std::fmod(225 * 4444.44, 1.0) * 2 * std::numbers::pi), 1e-8,
             "phase of a million cycles: eps w t");
}

TEST(PiecewiseMotion, RoundingDoesNotPileUp) {
  constexpr double omega = 2 * std::numbers::pi * 225;
  PiecewiseMotion motion(Swing(omega, {}), kNoDrive, {.x = State({0, 1})}, 1e4);
  RunTo(motion, 1 << 17);
  const long double phase_rad = static_cast<long double>(omega) * (0x1p17L / 1e4L);
  EXPECT_ABS(motion.x()(0), static_cast<double>(std::sin(phase_rad)), 1e-14,
             "computed anew in long double after every 2^14 outputs");
}

}  // namespace
// PiecewiseMotion::NextUnwatched: many outputs at once are those asked for one by one.
namespace {

// as many outputs at once as there are, of seven at first
Eigen::MatrixXd InBlocks(PiecewiseMotion& motion, Eigen::Index count) {
  Eigen::MatrixXd samples(motion.x().size(), count);
  Eigen::Index done = 0;
  while (done < count) {
    double voltage_v = 0;
    const Eigen::Index taken = motion.NextUnwatched(
        done < 7 ? 7 - done : count - done, [&](Eigen::Index i, const auto& x, double now_v) {
          samples.col(done + i) = x;
          voltage_v = now_v;
        });
    if (taken == 0) {
      motion.Next();
      samples.col(done++) = motion.Positions();
      continue;
    }
    done += taken;
    EXPECT_EQ(motion.Positions(), samples.col(done - 1));
    EXPECT_EQ(motion.Inputs()(kVoltage), voltage_v);
  }
  return samples;
}

Eigen::MatrixXd OneByOne(PiecewiseMotion& motion, Eigen::Index count) {
  Eigen::MatrixXd samples(motion.x().size(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    motion.Next();
    samples.col(i) = motion.Positions();
  }
  return samples;
}

std::unique_ptr<PiecewiseMotion> MotionOf(double inductance_h, const PiecewiseEffects& effects,
                                          double origin_s) {
  Scene scene = tests::AdapterScene();
  scene.actuator.inductance_h = inductance_h;
  scene.start = Start::kRest;
  const OutputGrid grid{.rate_hz = 1e4, .origin_s = origin_s};
  return std::make_unique<PiecewiseMotion>(AssemblePiecewise(scene, effects), scene.drive,
                                           PiecewiseStartOf(scene), grid);
}

// across a renewal of the state, and after a start between two outputs
TEST(UnwatchedOutputs, AreThoseOfOneByOne) {
  for (const double inductance_h : {130e-6, 0.0}) {
    for (const double origin_s : {0.0, -0.3e-4}) {
      const auto single = MotionOf(inductance_h, {}, origin_s);
      const auto many = MotionOf(inductance_h, {}, origin_s);
      EXPECT_EQ(InBlocks(*many, 20000), OneByOne(*single, 20000));
      EXPECT_EQ(many->index(), 20000U);
    }
  }
}

TEST(UnwatchedOutputs, AreNoneWhereThereAreGuards) {
  const PiecewiseEffects stops{
      .stops = TravelStops{.gap_up_m = 0.5e-3, .gap_down_m = 0.5e-3, .restitution = 0.5}};
  const auto motion = MotionOf(130e-6, stops, 0);
  const auto fail = [](Eigen::Index, const auto&, double) { FAIL() << "an output unwatched"; };
  EXPECT_EQ(motion->NextUnwatched(10, fail), 0);
  EXPECT_EQ(motion->index(), 0U);
}

}  // namespace
}  // namespace haptometer::sim
