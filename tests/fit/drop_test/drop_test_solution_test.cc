// Km where the loads show little of it: its interval, its limit.
#include "fit/drop_test/drop_test_solution.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/drop_test_model.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using tests::MakeRecord;
using tests::SyntheticDrop;

// an open and a loaded record; `noise` of the first amplitude that Km = 1 N/A gives
std::vector<ImpulseRecord> Pair(double force_constant_n_per_a, double noise, unsigned seed) {
  SyntheticDrop open;
  open.force_constant_n_per_a = force_constant_n_per_a;
  open.noise_v = noise * tests::SpeedVoltage(open);
  open.seed = 2 * seed + 1;
  SyntheticDrop loaded = open;
  loaded.load_ohm = 33;
  loaded.seed = open.seed + 1;
  return {MakeRecord(open), MakeRecord(loaded)};
}

DropTestFit Fit(const std::vector<ImpulseRecord>& records) {
  const auto fit = FitDropTest(records, tests::ThesisKnowns());
  EXPECT_TRUE(fit) << fit.error().Text();
  return fit.value_or(DropTestFit{});
}

double SquareSum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

// chi^2 above its least, all else fitted, with Km^2 held `away` from its best value
double Rise(const DropTestRoad& road, const DropTestModel& model, double away) {
  const std::size_t column = Index(Shared::kForceConstantSquared);
  std::vector<bool> is_free = UnknownColumns(model, road.problem);
  is_free[column] = false;
  RingDownPoint point = road.point;
  point.shared[column] += away;
  EXPECT_TRUE(road.problem.Minimise(is_free, &point).converged);
  return SquareSum(road.problem.Residuals(point)) - SquareSum(road.problem.Residuals(road.point));
}

TEST(ForceConstant, ItsSquareIsGaussianWhereTheNoiseIsLow) {
  const auto model = MakeDropTestModel(Pair(1, 0.01, 5), tests::ThesisKnowns());
  ASSERT_TRUE(model);
  const DropTestRoad road = Travel(*model, false);
  std::vector<double> weights(road.jacobian.columns, 0.0);
  weights[Index(Shared::kForceConstantSquared)] = 1;
  const double deviation = std::sqrt(Variance(road.seen, weights));
  for (const double away : {-2.0, -1.0, 1.0, 2.0}) {
    EXPECT_REL(Rise(road, *model, away * deviation), away * away, 0.02,
               "curvature of the order of the decay rate's 0.2 %");
  }
}

TEST(ForceConstant, ItsProfileWidthIsWhereChiSquareHasRisen) {
  // of Km known to 10 %, and of one that is lost in the noise
  for (const double force_constant : {1.0, 0.03}) {
    const auto model = MakeDropTestModel(Pair(force_constant, 0.2, 5), tests::ThesisKnowns());
    ASSERT_TRUE(model);
    const DropTestRoad road = Travel(*model, false);
    for (const int side : {-1, 1}) {
      const double width = ProfileWidth(road, *model, side, 1.96);
      EXPECT_REL(Rise(road, *model, side * width), 1.96 * 1.96 * road.variance, 0.02,
                 "twice the 1 % that the search stops at");
    }
  }
}

TEST(ForceConstant, ItsIntervalHoldsTheTruth) {
  const int repetitions = tests::Repetitions(tests::kIsSanitized ? 4 : 100);
  int held = 0;
  for (int k = 0; k < repetitions; ++k) {
    const FittedValue km = Fit(Pair(1, 0.2, static_cast<unsigned>(k))).force_constant;
    if (!km.determined) {
      held += km.at_most.value_or(0) >= 1 ? 1 : 0;
      continue;
    }
    held += km.lower <= 1 && 1 <= km.upper ? 1 : 0;
  }
  // 95 % of 100 within three of its standard deviations
  EXPECT_GE(held, std::lround(repetitions * 0.95 - 3 * std::sqrt(repetitions * 0.95 * 0.05)));
}

TEST(ForceConstant, WhatIsLostInTheNoiseHasALimit) {
  const int repetitions = tests::Repetitions(tests::kIsSanitized ? 4 : 100);
  constexpr double kTruth = 0.05;  // its square is 1/100 of its deviation
  int below = 0;
  int determined = 0;
  for (int k = 0; k < repetitions; ++k) {
    const DropTestFit fit = Fit(Pair(kTruth, 0.2, static_cast<unsigned>(k)));
    EXPECT_TRUE(fit.stiffness.determined && fit.damping.determined) << "Km takes nothing with it";
    determined += fit.force_constant.determined ? 1 : 0;
    if (fit.force_constant.determined) continue;
    ASSERT_TRUE(fit.force_constant.at_most);
    below += *fit.force_constant.at_most >= kTruth ? 1 : 0;
    EXPECT_LT(*fit.force_constant.at_most, 1.2);
  }
  EXPECT_EQ(below + determined, repetitions) << "a limit never lies below the truth here";
  // 2.5 % exceed nothing by chance
  EXPECT_LE(determined, std::lround(repetitions * 0.025 + 3 * std::sqrt(repetitions * 0.025)));
}

TEST(ForceConstant, TheEndsOfItsIntervalAreThoseOfItsSquare) {
  // known to 10 %, where both sides differ
  const auto model = MakeDropTestModel(Pair(1, 0.2, 5), tests::ThesisKnowns());
  ASSERT_TRUE(model);
  const DropTestRoad road = Travel(*model, false);
  const FittedValue km = EvaluateForceConstant(road, *model);
  ASSERT_TRUE(km.determined);
  const double square = km.value * km.value;
  EXPECT_REL(square, road.point.shared[Index(Shared::kForceConstantSquared)], 1e-12, "rounding");
  const double lower = km.lower * km.lower - square;
  const double upper = km.upper * km.upper - square;
  EXPECT_GT(std::abs(upper / lower + 1), 0.02) << "else both sides could be exchanged";
  for (const double away : {lower, upper}) {
    EXPECT_REL(Rise(road, *model, away), 1.96 * 1.96 * road.variance, 0.025,
               "twice the 1 % that the search stops at");
  }
}

// Fits of two drops, and of the same with 100 (R, RL, L, Km^2), which leaves every motion as it is,
// and makes all volts tenfold.
std::array<DropTestFit, 2> OfHundredfoldOhms(double force_constant_n_per_a, double noise) {
  std::array<DropTestFit, 2> fits;
  for (std::size_t k = 0; k < 2; ++k) {
    const double factor = k == 0 ? 1 : 100;
    SyntheticDrop open;
    open.resistance_ohm = 27 * factor;
    open.inductance_h = 130e-6 * factor;
    open.force_constant_n_per_a = force_constant_n_per_a * std::sqrt(factor);
    open.offset_v = 0.01 * std::sqrt(factor);
    open.noise_v = noise * tests::SpeedVoltage(open);
    SyntheticDrop loaded = open;
    loaded.load_ohm = 33 * factor;
    loaded.seed = 2;
    auto knowns = tests::ThesisKnowns();
    knowns.resistance_ohm->value *= factor;
    knowns.inductance_h->value *= factor;
    const auto fit = FitDropTest({MakeRecord(open), MakeRecord(loaded)}, knowns);
    EXPECT_TRUE(fit) << fit.error().Text();
    fits[k] = fit.value_or(DropTestFit{});
  }
  return fits;
}

TEST(ForceConstant, OfHundredfoldOhmsIsTenfoldWithTheSameShares) {
  const auto [one, hundred] = OfHundredfoldOhms(1, 0.1);
  const FittedValue& km = one.force_constant;
  const FittedValue& tenfold = hundred.force_constant;
  ASSERT_TRUE(km.determined);
  ASSERT_TRUE(tenfold.determined) << "its square is 100 +- 10, not a logarithm";
  EXPECT_REL(tenfold.value, 10 * km.value, 1e-7, "the solver's end, in units of the noise");
  EXPECT_REL(tenfold.standard_uncertainty, 10 * km.standard_uncertainty, 1e-5, "the same");
  EXPECT_REL(hundred.damping.value, one.damping.value, 1e-7, "the same");
  EXPECT_REL(hundred.damping.standard_uncertainty, one.damping.standard_uncertainty, 1e-5,
             "the same");
}

TEST(ForceConstant, ItsLimitIsTenfoldWithHundredfoldOhms) {
  const auto [one, hundred] = OfHundredfoldOhms(0.05, 0.2);
  ASSERT_TRUE(one.force_constant.at_most && hundred.force_constant.at_most);
  EXPECT_REL(*hundred.force_constant.at_most, 10 * *one.force_constant.at_most, 1e-4,
             "a half width that is searched to a thousandth, from the same start");
}

TEST(DropTestRoad, ItsIterationsAreThoseOfBothSolutions) {
  const auto model = MakeDropTestModel(Pair(1, 0.01, 5), tests::ThesisKnowns());
  ASSERT_TRUE(model);
  // the first of both, from the start with the start's weights
  RingDownProblem problem = MakeProblem(*model);
  RingDownPoint point = StartPoint(*model, false, &problem);
  const int first = problem.Minimise(UnknownColumns(*model, problem), &point).iterations;
  EXPECT_GT(first, 0);
  EXPECT_GT(Travel(*model, false).solver.iterations, first);
}

TEST(DropTestRoad, OfColouredNoiseTheWeightIsItsDensityAtTheResonance) {
  // noise of one pole at 0.95 in the one record, white noise in the other
  auto records = Pair(1, 0.01, 5);
  std::mt19937_64 engine(3);
  std::normal_distribution<double> white(0, 0.01);
  double coloured = 0;
  for (double& v : records[0].voltage_v) {
    coloured = 0.95 * coloured + white(engine);
    v += coloured;
  }
  const auto model = MakeDropTestModel(records, tests::ThesisKnowns());
  ASSERT_TRUE(model) << model.error().Text();
  const DropTestRoad road = Travel(*model, false);
  ASSERT_TRUE(road.densities[0].is_coloured);
  EXPECT_GT(std::abs(std::log(road.densities[0].ratio)), 0.5) << "else its root is hardly another";
  EXPECT_FALSE(road.densities[1].is_coloured);
  // of each record's noise over its scale, n/(n - p) being common to both
  const auto over_scale = [&](std::size_t r) {
    return road.problem.records()[r].noise_v / road.scales[r];
  };
  EXPECT_REL(over_scale(0) / over_scale(1), std::sqrt(road.densities[0].ratio), 1e-12, "rounding");
}

TEST(ProductAt, IsTheProductOfPowers) {
  const auto model = MakeDropTestModel(Pair(1, 0.01, 5), tests::ThesisKnowns());
  ASSERT_TRUE(model);
  DropTestRoad road = Travel(*model, false);
  road.point.shared = {std::log(3.0), std::log(0.5), 4, std::log(2.0), std::log(27.0)};
  EXPECT_REL(ProductAt(road, {{Shared::kStiffness, 2}, {Shared::kDamping, -1}}), 9 / 0.5, 1e-14,
             "rounding");
  EXPECT_REL(ProductAt(road, {{Shared::kForceConstantSquared, 0.5}, {Shared::kMass, 3}}), 2.0 * 8,
             1e-14, "rounding");
  // d ln(Km) = d(Km^2)/(2 Km^2)
  const auto weights = Weights(road, {{Shared::kForceConstantSquared, 0.5}, {Shared::kMass, 3}});
  EXPECT_EQ(weights[Index(Shared::kForceConstantSquared)], 0.5 / 4);
  EXPECT_EQ(weights[Index(Shared::kMass)], 3);
  EXPECT_EQ(weights[Index(Shared::kStiffness)], 0);
}

TEST(InputBase, OfAReboundIsOneMore) {
  DropTestInput input{.kind = DropTestInput::Kind::kRebound,
                      .name = {},
                      .unit = {},
                      .quantity = {0.25, 0},
                      .records = {}};
  EXPECT_EQ(InputBase(input), 1.25);
  input.kind = DropTestInput::Kind::kHeight;
  EXPECT_EQ(InputBase(input), 0.25);
}

}  // namespace
}  // namespace haptometer::fit
