#include "sim/piecewise/piecewise_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/linear/excitation.h"
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
  // at 11250 Hz the peak is in the middle of an output step
  for (const double rate_hz : {1e4, 11250.0, 317.0, 40.0}) {
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
  EXPECT_EQ(motion.events().size(), 101U) << "a hundred, each at once after the one before";
}

// p' = 1 is set back by `apart_s` whenever it comes to 1/2; 151 times, counted by the second state
PiecewiseLinearSystem Ticking(double apart_s) {
  Mode ticking{.name = "ticking",
               .a = Eigen::MatrixXd::Zero(3, 3),
               .b = Eigen::VectorXd::Zero(3),
               .positions = {},
               .stored_j = Eigen::MatrixXd::Zero(3, 3),
               .current_row = Eigen::RowVectorXd::Zero(3)};
  ticking.a(0, 2) = 1;
  Mode quiet = ticking;
  ticking.guards = {{.row = Eigen::RowVector3d(-1, 0, 0), .offset = 0.5, .transition = 0},
                    {.row = Eigen::RowVector3d(0, -1, 0), .offset = 150.5, .transition = 1}};
  const Transition back{.name = "back",
                        .mode = 0,
                        .map = Eigen::Matrix3d::Identity(),
                        .shift = Eigen::Vector3d(-apart_s, 1, 0)};
  const Transition end{.name = "end",
                       .mode = 1,
                       .map = Eigen::Matrix3d::Identity(),
                       .shift = Eigen::Vector3d::Zero()};
  return {.modes = {ticking, quiet}, .transitions = {back, end}, .dissipating_elements = {}};
}

TEST(PiecewiseMotion, EventsWithin2ToTheMinus40OfAnOutputStepAreAStall) {
  for (const double rate_hz : {1.0, 4.0}) {
    const double limit_s = 0x1p-40 / rate_hz;
    PiecewiseMotion crowded(Ticking(0.99 * limit_s), kNoDrive, {.x = State({0.4, 0, 1})}, rate_hz);
    RunTo(crowded, 1);
    EXPECT_EQ(crowded.stall_reason(), FindingKind::kEventsWithoutEnd);
    EXPECT_EQ(crowded.events().size(), 101U);
    PiecewiseMotion apart(Ticking(1.01 * limit_s), kNoDrive, {.x = State({0.4, 0, 1})}, rate_hz);
    RunTo(apart, 1);
    EXPECT_FALSE(apart.stall_reason());
    EXPECT_EQ(apart.events().size(), 152U);
    EXPECT_EQ(apart.mode(), 1U);
  }
}

TEST(PiecewiseMotion, RestartLeavesNoTrace) {
  const double apart_s = 0.99 * 0x1p-40;
  PiecewiseMotion crowded(Ticking(apart_s), kNoDrive, {.x = State({0.4, 0, 1})}, 1);
  for (int run = 0; run < 2; ++run) {
    RunTo(crowded, 1);
    EXPECT_EQ(crowded.stall_reason(), FindingKind::kEventsWithoutEnd);
    EXPECT_EQ(crowded.events().size(), 101U);
    crowded.Restart({.x = State({0.4, 0, 1})});
    EXPECT_FALSE(crowded.stall_reason() || crowded.stalled_at_s());
    EXPECT_EQ(crowded.index(), 0U);
    EXPECT_EQ(crowded.steps(), 0);
  }
  PiecewiseMotion used(Ball(0.7), kNoDrive, {.x = State({1, 0, 1})}, 100);
  PiecewiseMotion fresh(Ball(0.7), kNoDrive, {.x = State({1, 0, 1})}, 100);
  RunTo(used, 260);
  EXPECT_EQ(used.mode(), 1U);
  used.Restart({.x = State({1, 0, 1})});
  for (std::uint64_t i = 1; i <= 300; ++i) {
    RunTo(used, i);
    RunTo(fresh, i);
    ASSERT_EQ(used.x(), fresh.x()) << i;
  }
  EXPECT_EQ(used.events().size(), fresh.events().size());
}

// output 0 lies less than a step before the beginning, or there
TEST(PiecewiseMotion, HandsOutTheOutputsFromTheFirstOnOrBehindItsBegin) {
  constexpr double omega = 300, rate_hz = 1000;
  for (const double before : {0.0, 0.3, 0.999}) {
    PiecewiseMotion motion(Swing(omega, {}), kNoDrive, {.x = State({0, 1})},
                           OutputGrid{.rate_hz = rate_hz, .origin_s = -before / rate_hz});
    EXPECT_EQ(motion.x()(0), 0);
    for (std::uint64_t i = 1; i <= 5; ++i) {
      RunTo(motion, i);
      const double t_s = (static_cast<double>(i) - before) / rate_hz;
      EXPECT_ABS(motion.x()(0), std::sin(omega * t_s), 2e-15, "rounding of some dozen steps");
    }
  }
  const auto begin = [](double origin_s) {
    return PiecewiseMotion(Swing(omega, {}), kNoDrive, {.x = State({0, 1})},
                           OutputGrid{.rate_hz = rate_hz, .origin_s = origin_s})
        .index();
  };
  EXPECT_DEATH(static_cast<void>(begin(-1 / rate_hz)), "check failed");
  EXPECT_DEATH(static_cast<void>(begin(1e-9)), "check failed");
}

TEST(PiecewiseMotion, MayJudgeTwoMillionIntervalsAndTenAnOutput) {
  EXPECT_EQ(PiecewiseMotion::MostSteps(0), 2e6);
  EXPECT_EQ(PiecewiseMotion::MostSteps(300), 2e6 + 3000);
}

// x' = w [0, 1; -1, 0] x of two swings, of which a number's extremes are wanted
PiecewiseLinearSystem TwoSwings(double one, double other) {
  Mode mode{.name = "two",
            .a = Eigen::MatrixXd::Zero(4, 4),
            .b = Eigen::VectorXd::Zero(4),
            .positions = {},
            .stored_j = Eigen::MatrixXd::Zero(4, 4),
            .current_row = Eigen::RowVectorXd::Zero(4)};
  mode.a(0, 1) = one;
  mode.a(1, 0) = -one;
  mode.a(2, 3) = other;
  mode.a(3, 2) = -other;
  mode.watched = {{.row = Eigen::RowVector4d(1, 0, 0.6, 0), .offset = 0.1}};
  return {.modes = {mode}, .transitions = {}, .dissipating_elements = {}};
}

// several extremes in an output step, as dense samples of the closed form show them
TEST(PiecewiseMotion, RangesHoldEveryExtremeBetweenOutputs) {
  constexpr double one = 19, other = 46;
  constexpr int kSamples = 4000;
  for (const double rate_hz : {2.0, 7.0, 30.0}) {
    PiecewiseMotion motion(TwoSwings(one, other), kNoDrive, {.x = State({0, 1, 0, 1})}, rate_hz);
    for (int step = 0; step < 12; ++step) {
      ValueRange expected;
      for (int k = 0; k <= kSamples; ++k) {
        const double t_s = (step + static_cast<double>(k) / kSamples) / rate_hz;
        expected.Include(std::sin(one * t_s) + 0.6 * std::sin(other * t_s) + 0.1);
      }
      motion.ForgetRanges();
      motion.Next();
      const ValueRange& found = motion.Ranges()[0];
      // (h/2)^2 / 2 of the curvature of 1600 between samples
      const double between = 1700 / (8 * rate_hz * rate_hz * kSamples * kSamples);
      EXPECT_GE(found.largest, expected.largest - 1e-14) << "rounding";
      EXPECT_LE(found.largest, expected.largest + between + 1e-14);
      EXPECT_LE(found.least, expected.least + 1e-14) << "rounding";
      EXPECT_GE(found.least, expected.least - between - 1e-14);
    }
  }
}

// of a swing that is driven, v' = -w x + b u, and of 2 v as its only position
TEST(PiecewiseMotion, RatesAreThoseOfModeAndInputs) {
  PiecewiseLinearSystem system = Swing(30, {});
  system.modes[0].b(1) = 0.25;
  for (const bool with_positions : {false, true}) {
    if (with_positions) system.modes[0].positions = Eigen::RowVector2d(0, 2);
    const SineDrive drive{.amplitude_v = 8, .frequency_hz = 3};
    PiecewiseMotion motion(system, drive, {.x = State({0.5, 1})}, 100);
    RunTo(motion, 7);
    const double volt = 8 * std::sin(2 * std::numbers::pi * 0.21);
    const double rate = -30 * motion.x()(0) + 0.25 * volt;
    const Eigen::VectorXd rates = motion.Rates();
    EXPECT_REL(rates(with_positions ? 0 : 1), with_positions ? 2 * rate : rate, 1e-13, "rounding");
    EXPECT_EQ(rates.size(), with_positions ? 1 : 2);
  }
}

// -------------------------------------------------------------------- the error that events leave

// the beginning's rounding of 2^-50; after 64 outputs that of 64 steps, as if all had one sign
TEST(PiecewiseMotion, BeforeAnyEventTheErrorIsCarriedOver64Outputs) {
  PiecewiseMotion motion(Swing(2 * std::numbers::pi * 225, {}), kNoDrive, {.x = State({0, 1})}, 1e4,
                         true);
  const auto error = [&] {
    return std::hypot(motion.ErrorOf(Eigen::RowVector2d(1, 0)),
                      motion.ErrorOf(Eigen::RowVector2d(0, 1)));
  };
  EXPECT_REL(error(), 64 * 0x1p-50, 1e-15, "64 deviations");
  RunTo(motion, 63);
  EXPECT_REL(error(), 64 * 0x1p-50, 1e-15, "not carried yet");
  // terms of 1 to 1.5 in each of two states
  constexpr double kSteps = 64 * 64 * 0x1p-53;
  RunTo(motion, 64);
  EXPECT_GT(error(), kSteps);
  EXPECT_LT(error(), 2.2 * kSteps);
  // and again, the first turned along
  RunTo(motion, 128);
  EXPECT_GT(error(), std::numbers::sqrt2 * kSteps);
  EXPECT_LT(error(), 2.2 * std::numbers::sqrt2 * kSteps);
}

// a swing that is reflected once at a wall, and the error of [x, v] a whole output later
double ErrorBehindAWall(double wall, double rate_hz) {
  const Guard guard{.row = -Eigen::RowVectorXd::Unit(2, 0), .offset = wall, .transition = 0};
  PiecewiseLinearSystem system = Swing(2 * std::numbers::pi * 225, {guard});
  system.transitions[0].map = Eigen::Vector2d(1, -1).asDiagonal();
  PiecewiseMotion motion(system, kNoDrive, {.x = State({0, 1})}, rate_hz, true);
  while (motion.events().empty() && motion.index() < 100) motion.Next();
  EXPECT_EQ(motion.events().size(), 1U);
  // the motion behind the wall only turns it
  return std::hypot(motion.ErrorOf(Eigen::RowVector2d(1, 0)),
                    motion.ErrorOf(Eigen::RowVector2d(0, 1)));
}

// an event is located to a tick of 2^-50 of a step, in which the guard falls by w v; the jump of
// the rates over that, f+ - R f- = -2 w [v, x], makes [2, 2 x/v] of it
TEST(PiecewiseMotion, AnEventsErrorHoldsTheTickToWhichItIsLocated) {
  const double tick_s = 0x1p-50 / 10, omega = 2 * std::numbers::pi * 225;
  EXPECT_REL(ErrorBehindAWall(0.9, 10), 64 * 2 * tick_s * omega, 0.05,
             "64 deviations; rounding of the steps of 0.1 s, a fifth of it, squared");
}

// x = 1, v = sqrt(2 part): the saltation takes errors of x by 2/v; those of x are 2^-50 of the
// steps that locate an event and 2^-51 of the guard's two terms; within the first output step
TEST(PiecewiseMotion, BeforeAGrazeAnEventsErrorGrowsAsTheInverseSpeed) {
  const double speed = std::sqrt(2 * 1e-9);
  EXPECT_REL(ErrorBehindAWall(1 - 1e-9, 800), 64 * 2 / speed * std::hypot(0x1p-50, 0x1p-51), 0.02,
             "ticks, and x less than 1");
}

// within a twentieth of g'^2 / (2 g'') of the guard's error e = 64 x 2^-50 an event may not come at
// all: its time is unknown by sqrt(2 e) / w, in which the rates' jump of 2 w counts twice
TEST(PiecewiseMotion, AtAGrazeAnEventsErrorIsThatOfItsTime) {
  EXPECT_REL(ErrorBehindAWall(1 - 1e-13, 800), 4 * std::sqrt(2 * 64 * 0x1p-50), 0.02,
             "x less than 1, and rounding of what follows");
}

// a wall that a swing misses by so much, behind an event that leaves all as it is
double ErrorBehindAMissedWall(double missed_by) {
  const Guard begin{.row = Eigen::RowVectorXd::Unit(2, 1), .offset = -0.5, .transition = 0};
  const Guard wall{
      .row = -Eigen::RowVectorXd::Unit(2, 0), .offset = 1 + missed_by, .transition = 1};
  PiecewiseLinearSystem system = Swing(2 * std::numbers::pi * 225, {begin});
  system.modes[1].guards = {wall};
  system.transitions.push_back(system.transitions[0]);
  system.transitions[1].map = Eigen::Vector2d(1, -1).asDiagonal();
  PiecewiseMotion motion(system, kNoDrive, {.x = State({0, 1})}, 1e5, true);
  RunTo(motion, 120);
  EXPECT_EQ(motion.events().size(), 1U);
  return motion.ErrorOf(Eigen::RowVector2d(0, 1));
}

// the same without an event before it
double ErrorBehindAWallMissedFirst(double missed_by) {
  const Guard wall{
      .row = -Eigen::RowVectorXd::Unit(2, 0), .offset = 1 + missed_by, .transition = 0};
  PiecewiseLinearSystem system = Swing(2 * std::numbers::pi * 225, {wall});
  system.transitions[0].mode = 0;
  system.transitions[0].map = Eigen::Vector2d(1, -1).asDiagonal();
  PiecewiseMotion motion(system, kNoDrive, {.x = State({0, 1})}, 1e5, true);
  RunTo(motion, 128);
  EXPECT_TRUE(motion.events().empty());
  return motion.ErrorOf(Eigen::RowVector2d(0, 1));
}

// with 444 outputs a period the quintic through a step has the least value to 2e-16
TEST(PiecewiseMotion, AWallThatIsMissedWithinTheErrorMayHaveBeenMet) {
  for (const auto& error_behind : {ErrorBehindAMissedWall, ErrorBehindAWallMissedFirst}) {
    // the reflection is sqrt(2 e) / w long, e some 1e-13 behind a hundred steps: 4 sqrt(2 e) of v
    EXPECT_GT(error_behind(5e-14), 1e-7);
    EXPECT_LT(error_behind(5e-14), 1e-5);
    EXPECT_LT(error_behind(1e-10), 1e-11);
  }
}

// r' = k h of a ball at height h: the flights that are not played would have moved it by k I,
// I = 2/3 u^3 / g^2 / (1 - e^3) the integral of all their heights
TEST(PiecewiseMotion, BouncesThatAreNotPlayedAreAnErrorOfWhatTheyMove) {
  constexpr double e = 0.5, k = 0.3;
  PiecewiseLinearSystem system = Ball(e);
  Mode& flight = system.modes[0];
  flight.a = Eigen::MatrixXd::Zero(4, 4);
  flight.a(0, 1) = 1;
  flight.a(1, 3) = -kGravity;
  flight.a(2, 0) = k;
  flight.b = Eigen::VectorXd::Zero(4);
  flight.stored_j = Eigen::MatrixXd::Zero(4, 4);
  flight.current_row = Eigen::RowVectorXd::Zero(4);
  flight.guards[0].row = Eigen::RowVectorXd::Unit(4, 0);
  system.modes[1] = {.name = "rest",
                     .a = Eigen::MatrixXd::Zero(2, 2),
                     .b = Eigen::VectorXd::Zero(2),
                     .positions = Eigen::MatrixXd::Identity(4, 4).rightCols(2),
                     .stored_j = Eigen::MatrixXd::Zero(2, 2),
                     .current_row = Eigen::RowVectorXd::Zero(2)};
  system.transitions[0].map = Eigen::Vector4d(1, -e, 1, 1).asDiagonal();
  system.transitions[0].shift = Eigen::VectorXd::Zero(4);
  // from 1 m the first bounce is e^2 = 0.25 m high
  system.transitions[0].bounce->rest_height = 0.26;
  system.transitions[1].map = Eigen::MatrixXd::Identity(4, 4).bottomRows(2);
  system.transitions[1].shift = Eigen::VectorXd::Zero(2);
  PiecewiseMotion ball(system, kNoDrive, {.x = State({1, 0, 0, 1})}, 2, true);
  RunTo(ball, 1);
  ASSERT_EQ(ball.mode(), 1U);
  const double speed = e * std::sqrt(2 * kGravity);
  const double integral = 2 * std::pow(speed, 3) / (3 * kGravity * kGravity) / (1 - e * e * e);
  EXPECT_REL(ball.ErrorOf(Eigen::RowVectorXd::Unit(4, 2)), 64 * k * integral, 1e-12, "rounding");
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

// one sine of the drive from phase 0, and nothing else that acts or is counted
TEST(UnwatchedOutputs, AreThoseOfTheDrivesSineAlone) {
  const auto taken = [](const Drive& drive, const std::vector<Tone>& finger, bool with_energy) {
    Scene scene = tests::AdapterScene();
    scene.start = Start::kRest;
    scene.drive = drive;
    scene.finger.tones = finger;
    const auto motion = [&] {
      return std::make_unique<PiecewiseMotion>(AssemblePiecewise(scene, {}),
                                               Excitation(drive, finger), PiecewiseStartOf(scene),
                                               OutputGrid{.rate_hz = 1e4}, with_energy);
    };
    EXPECT_EQ(InBlocks(*motion(), 300), OneByOne(*motion(), 300));
    return motion()->NextUnwatched(10, [](Eigen::Index, const auto&, double) {});
  };
  const Drive sine{.amplitude_v = 5, .frequency_hz = 225};
  const auto tones = [](std::vector<Tone> of) {
    return Drive{.kind = DriveKind::kTones, .tones = std::move(of)};
  };
  EXPECT_EQ(taken(sine, {}, false), 10);
  EXPECT_EQ(taken(tones({{5, 225, 0}}), {}, false), 10);
  EXPECT_EQ(taken(sine, {}, true), 0);
  EXPECT_EQ(taken(sine, {{1e-6, 9, 0}}, false), 0);
  EXPECT_EQ(taken(tones({{5, 225, 0.1}}), {}, false), 0);
  EXPECT_EQ(taken(tones({{5, 225, 0}, {1, 60, 0}}), {}, false), 0);
  Drive other = sine;
  other.offset_v = 0.1;
  EXPECT_EQ(taken(other, {}, false), 0);
  (other = sine).kind = DriveKind::kBurst;
  other.rise_s = 0.02;
  EXPECT_EQ(taken(other, {}, false), 0) << "its amplitude rises";
  // 213 outputs of a sine, which end between two, and then what falls
  other.rise_s = 0;
  other.hold_s = 0.02134;
  other.fall_s = 0.002;
  EXPECT_EQ(taken(other, {}, false), 10);
  other.start_s = 1.03e-3;
  EXPECT_EQ(taken(other, {}, false), 0) << "it begins later";
}

}  // namespace
}  // namespace haptometer::sim
