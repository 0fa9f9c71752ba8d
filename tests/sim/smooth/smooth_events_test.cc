#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "sim/smooth/smooth_motion.h"
#include "sim/smooth/smooth_system.h"
#include "tests/residual.h"
#include "tests/sim/smooth_scenes.h"
#include "tests/sim/thesis_scenes.h"

// Events of a SmoothMotion that are hard to see or to leave behind.
namespace haptometer::sim {
namespace {

using tests::Alone;
using tests::DrawnApart;
using tests::ReducedMass;
using tests::RunTo;

// d = A cos w t over a gap, both ways
SmoothMotion Reaching(double gap_m, double tolerance) {
  Scene scene = Alone();
  const TravelStops stops{.gap_down_m = gap_m, .stiffness_n_per_m = 1e-3};
  return {AssembleSmooth(scene, {.stops = stops}, {}),
          scene.drive,
          DrawnApart(scene, 0.5e-3),
          200,
          {.tolerance = tolerance}};
}

TEST(SmoothEvents, AGrazeIsDecidedAndTwoCrossingsWithinAStepAreSeen) {
  const double w = std::sqrt(2800 / ReducedMass(Alone()));
  for (const double part : {1e-3, 1e-5, 1e-7, 1e-8}) {
    // far within half a period of 1.2 ms: 0.04 of w t at 1e-3, 1.4e-4 at 1e-8
    SmoothMotion reached = Reaching(0.5e-3 * (1 - part), 1e-10);
    RunTo(reached, 1);  // 5 ms are two periods
    EXPECT_EQ(reached.events().size(), 4U) << part;
    const double first_s = (std::numbers::pi - std::acos(1 - part)) / w;
    if (!reached.events().empty()) {
      EXPECT_ABS(reached.events()[0].time_s, first_s, 1e-13 / std::sqrt(part),
                 "1e-10 of A over the speed, which is sqrt(2 part) w A");
    }
    SmoothMotion missed = Reaching(0.5e-3 * (1 + part), 1e-10);
    RunTo(missed, 1);
    EXPECT_TRUE(missed.events().empty()) << part;
  }
}

// a mass of 1 kg at height h over the floor, x = [h, v, 1]; at rest only the constant is left
SmoothSystem Ball(double restitution) {
  constexpr double kGravity = 9.81;
  Mode flight{.name = "flight",
              .a = Eigen::MatrixXd::Zero(3, 3),
              .b = Eigen::VectorXd::Zero(3),
              .positions = {},
              .stored_j = Eigen::MatrixXd::Zero(3, 3),
              .current_row = Eigen::RowVectorXd::Zero(3)};
  flight.a(0, 1) = 1;
  flight.a(1, 2) = -kGravity;
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
  return {.linear = {
              .modes = {flight, rest}, .transitions = {impact, stay}, .dissipating_elements = {}}};
}

TEST(SmoothEvents, ABouncingBallComesToRest) {
  const double first_s = std::sqrt(2 / 9.81);
  for (const double e : {0.0, 0.7, 0.98}) {
    for (const double tolerance : {1e-4, 1e-9}) {
      SmoothMotion ball(Ball(e), {}, {.x = Eigen::Vector3d(1, 0, 1)}, 100,
                        {.tolerance = tolerance});
      RunTo(ball, 100 * static_cast<std::uint64_t>(2 + first_s * (1 + e) / (1 - e)));
      EXPECT_FALSE(ball.stall_reason()) << e;
      EXPECT_EQ(ball.mode(), 1U) << e;
      EXPECT_EQ(ball.Positions()(0), 0);
      // a height that is wrong by the tolerance is a flight wrong by sqrt(2 h/g), and all after it
      EXPECT_ABS(ball.events().back().time_s, first_s * (1 + e) / (1 - e),
                 tolerance + std::sqrt(2 * tolerance / 9.81) * e / (1 - e),
                 "Zeno's time, t1 (1 + e)/(1 - e)");
      EXPECT_LT(ball.events().size(), 1000U);
    }
  }
}

// bounces below 0.1 m are not played: the ball rests when they would have ended
TEST(SmoothEvents, WhatBouncesLowRestsAtTheEndOfItsBounces) {
  const double first_s = std::sqrt(2 / 9.81), e = 0.7;
  SmoothSystem system = Ball(e);
  system.linear.transitions[0].bounce->rest_height = 0.1;
  SmoothMotion ball(system, {}, {.x = Eigen::Vector3d(1, 0, 1)}, 100, {.tolerance = 1e-9});
  RunTo(ball, 300);
  ASSERT_LT(ball.events().size(), 6U);
  EXPECT_REL(ball.events().back().time_s, first_s * (1 + e) / (1 - e), 1e-7, "Zeno's time");
  EXPECT_EQ(ball.events().back().guard_rate, 0);
}

TEST(SmoothEvents, AnEndlessToAndFroIsSaidToStall) {
  // two modes that each hand over to the other at once
  SmoothSystem system = Ball(0);
  Mode& flight = system.linear.modes[0];
  flight.guards[0].offset = -0.5;
  system.linear.modes[1] = flight;
  system.linear.modes[1].guards[0].transition = 1;
  system.linear.modes[1].guards[0].offset = -0.6;
  system.linear.transitions[0] = {.name = "to",
                                  .mode = 1,
                                  .map = Eigen::Matrix3d::Identity(),
                                  .shift = Eigen::Vector3d::Zero()};
  system.linear.transitions[1] = system.linear.transitions[0];
  system.linear.transitions[1].mode = 0;
  SmoothMotion motion(system, {}, {.x = Eigen::Vector3d(1, 0, 1)}, 100, {.tolerance = 1e-9});
  RunTo(motion, 100);
  ASSERT_TRUE(motion.stalled_at_s().has_value());
  EXPECT_EQ(motion.stall_reason(), FindingKind::kEventsWithoutEnd);
  EXPECT_REL(*motion.stalled_at_s(), std::sqrt(1 / 9.81), 1e-8, "where the first event was");
  // after a restart it stalls after as many
  const std::size_t events = motion.events().size();
  motion.Restart({.x = Eigen::Vector3d(1, 0, 1)}, 0);
  EXPECT_FALSE(motion.stalled_at_s());
  RunTo(motion, 100);
  EXPECT_EQ(motion.events().size(), events);
}

// p' = 1 is set back by `apart_s` whenever it comes to 1/2; 151 times, counted by the second state
SmoothSystem Ticking(double apart_s) {
  SmoothSystem system = Ball(0);
  Mode& ticking = system.linear.modes[0];
  ticking.a = Eigen::MatrixXd::Zero(3, 3);
  ticking.a(0, 2) = 1;
  Mode quiet = ticking;
  quiet.guards.clear();
  ticking.guards = {{.row = Eigen::RowVector3d(-1, 0, 0), .offset = 0.5, .transition = 0},
                    {.row = Eigen::RowVector3d(0, -1, 0), .offset = 150.5, .transition = 1}};
  system.linear.modes[1] = quiet;
  system.linear.transitions[0] = {.name = "back",
                                  .mode = 0,
                                  .map = Eigen::Matrix3d::Identity(),
                                  .shift = Eigen::Vector3d(-apart_s, 1, 0)};
  system.linear.transitions[1] = {.name = "end",
                                  .mode = 1,
                                  .map = Eigen::Matrix3d::Identity(),
                                  .shift = Eigen::Vector3d::Zero()};
  return system;
}

TEST(SmoothEvents, EventsWithin2ToTheMinus40OfAnOutputStepAreAStall) {
  for (const double rate_hz : {1.0, 4.0}) {
    const double limit_s = 0x1p-40 / rate_hz;
    const auto motion_of = [&](double apart_s) {
      return SmoothMotion(Ticking(apart_s), {}, {.x = Eigen::Vector3d(0.4, 0, 1)}, rate_hz,
                          {.tolerance = 1e-12});
    };
    SmoothMotion crowded = motion_of(0.99 * limit_s);
    RunTo(crowded, 1);
    EXPECT_EQ(crowded.stall_reason(), FindingKind::kEventsWithoutEnd);
    EXPECT_EQ(crowded.events().size(), 101U);
    SmoothMotion apart = motion_of(1.01 * limit_s);
    RunTo(apart, 1);
    EXPECT_FALSE(apart.stall_reason());
    EXPECT_EQ(apart.events().size(), 152U);
  }
}

TEST(SmoothEvents, WhatIsNotANumberStalls) {
  SmoothSystem system = Ball(0.5);
  SmoothMotion broken(system, {}, {.x = Eigen::Vector3d(std::nan(""), 0, 1)}, 100, {});
  RunTo(broken, 10);
  EXPECT_EQ(broken.stall_reason(), FindingKind::kSolverStopped);
  // a guard that is not one never fires
  system.linear.modes[0].guards[0].offset = std::nan("");
  SmoothMotion falling(system, {}, {.x = Eigen::Vector3d(1, 0, 1)}, 100, {});
  RunTo(falling, 100);
  EXPECT_EQ(falling.events().size(), 0U);
  EXPECT_REL(falling.x()(0), 1 - 9.81 / 2, 1e-8, "free fall");
}

}  // namespace
}  // namespace haptometer::sim
