#include "sim/period_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/piecewise/piecewise_scene.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

Scene Steady(Scene scene) {
  scene.start = Start::kSteady;
  return scene;
}

// modes whose last state is 1 throughout, as that of a flight, in which the preload pushes
std::vector<std::size_t> ModesWithAConstant(const PiecewiseLinearSystem& system) {
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < system.modes.size(); ++k) {
    const Mode& mode = system.modes[k];
    const Eigen::Index last = mode.a.rows() - 1;
    const bool rests = mode.a.row(last).isZero(0) && mode.b(last) == 0;
    if (mode.positions.size() > 0 && rests) places.push_back(k);
  }
  return places;
}

TEST(PeriodMap, HasNoCoordinateForAStateThatIsAlwaysOne) {
  const Scene scene = tests::DirectScene();
  const PiecewiseLinearSystem system =
      AssemblePiecewise(scene, {.contact_loss = ContactLoss{0.07}});
  const PeriodMap map(system, scene.drive);
  const std::vector<std::size_t> places = ModesWithAConstant(system);
  ASSERT_FALSE(places.empty()) << "a flight has one";
  for (const std::size_t mode : places) {
    const Eigen::Index n = system.modes[mode].a.rows();
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, 2, 3);
    x(n - 1) = 1;
    const PeriodPoint point = map.PointOf(mode, x);
    EXPECT_EQ(point.mode, mode);
    EXPECT_EQ(point.x, x.head(n - 1));
    const PiecewiseStart start = map.StartOf(point);
    EXPECT_EQ(start.mode, mode);
    EXPECT_EQ(start.x, x);
  }
  const Eigen::VectorXd all = Eigen::VectorXd::LinSpaced(system.modes[0].a.rows(), 2, 3);
  EXPECT_EQ(map.PointOf(0, all).x, all);
  EXPECT_EQ(map.StartOf({.mode = 0, .x = all}).x, all);
}

TEST(PeriodMap, MeansOfTheSteadyMotionAreItsPhasors) {
  for (const Scene& scene : {Steady(tests::AdapterScene()), Steady(tests::DirectScene())}) {
    const LinearModel model = AssembleModel(scene);
    const SteadyState steady = SolveSteadyState(scene);
    const PeriodMap map(AssemblePiecewise(scene, {}), scene.drive);
    const PiecewiseStart start = PiecewiseStartOf(scene);
    const auto step = map.After(map.PointOf(start.mode, start.x), 3, true);
    ASSERT_TRUE(step && step->means);
    const PeriodMeans& means = *step->means;
    ASSERT_EQ(means.mean_squares.size(), model.states()) << "the travel stands by itself";
    ASSERT_EQ(means.largest.size(), model.states());
    for (Eigen::Index k = 0; k < model.states(); ++k) {
      const double peak = std::abs(steady.phasors(k));
      EXPECT_REL(means.mean_squares(k), peak * peak / 2, 1e-11, "rounding of the sums");
      EXPECT_LE(means.largest(k), peak * (1 + 1e-11));
      EXPECT_GE(means.largest(k), peak * std::cos(std::numbers::pi / 64)) << "64 looks a period";
    }
    EXPECT_REL(means.travel_mean_square, std::pow(steady.mover_peak_m, 2) / 2, 1e-11, "rounding");
    EXPECT_REL(means.power_w, steady.power_w, 1e-11, "rounding of the sums");
    EXPECT_REL(means.coil_w, scene.actuator.resistance_ohm * std::pow(steady.current_rms_a, 2),
               1e-11, "rounding of the sums");
    EXPECT_EQ(means.events, 0U);
    EXPECT_ABS((step->point.x - start.x).cwiseQuotient(map.ScaleOf(step->point)).norm(), 0, 1e-11,
               "it repeats itself");
  }
}

// one period after the other is all of them at once
TEST(PeriodMap, ShowsEachPeriodOnce) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  const PeriodMap map(AssemblePiecewise(scene, {}), scene.drive);
  const PiecewiseStart rest = PiecewiseStartOf(scene);
  const PeriodPoint begin = map.PointOf(rest.mode, rest.x);
  for (const bool with_means : {false, true}) {
    std::vector<PeriodPoint> seen;
    const auto all =
        map.After(begin, 5, with_means, [&](const PeriodPoint& point) { seen.push_back(point); });
    ASSERT_TRUE(all);
    EXPECT_EQ(all->means.has_value(), with_means);
    ASSERT_EQ(seen.size(), 5U);
    PeriodPoint point = begin;
    for (const PeriodPoint& next : seen) {
      point = map.After(point, 1)->point;
      EXPECT_ABS((point.x - next.x).cwiseQuotient(map.ScaleOf(next)).norm(), 0, 1e-11, "rounding");
    }
    EXPECT_EQ(all->point.x, seen.back().x);
  }
}

// what nothing moves has a scale too, so that quotients are numbers
TEST(PeriodMap, HasAScaleForEachCoordinate) {
  Scene scene = tests::ConeScene();
  scene.drive.amplitude_v = 0;
  const PeriodMap still(AssemblePiecewise(scene, {}), scene.drive);
  const Eigen::Index n = AssembleModel(scene).states();
  EXPECT_GT(still.ScaleOf({.mode = 0, .x = Eigen::VectorXd::Zero(n)}).minCoeff(), 0);
  const Scene driven = Steady(tests::ConeScene());
  const PeriodMap map(AssemblePiecewise(driven, {}), driven.drive);
  const PiecewiseStart start = PiecewiseStartOf(driven);
  const Eigen::VectorXd scale = map.ScaleOf(map.PointOf(0, start.x));
  EXPECT_TRUE((scale.array() >= start.x.cwiseAbs().array()).all());
}

// the last coordinate is the coil's rise
TEST(PeriodMap, OfACoilThatHeatsHasItsRise) {
  const Scene scene = tests::ConeScene();
  const CoilHeating heating{.heat_capacity_j_per_k = 1, .thermal_resistance_k_per_w = 10};
  const PeriodMap map(AssembleSmooth(scene, {}, {.heating = heating}), scene.drive, {});
  EXPECT_TRUE(map.heats());
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(AssembleModel(scene).states(), 1, 2);
  const PeriodPoint point = map.PointOf(0, x, 12.5);
  ASSERT_EQ(point.x.size(), x.size() + 1);
  EXPECT_EQ(point.x.head(x.size()), x);
  EXPECT_EQ(point.x(x.size()), 12.5);
  EXPECT_EQ(map.StartOf(point).x, x);
  // not below the stationary rise of a motion of that size: Rth R I^2 / 2 of a sine and more
  const PeriodPoint cold = map.PointOf(0, PiecewiseStartOf(Steady(scene)).x, 0);
  const double rms_a = SolveSteadyState(scene).current_rms_a;
  EXPECT_GE(map.ScaleOf(cold)(x.size()), 10 * scene.actuator.resistance_ohm * rms_a * rms_a);
}

}  // namespace
}  // namespace haptometer::sim
