// Five ways to the motion of the thesis's scenes, which share no method: the phasor of the steady
// state, the exact time response, shooting, exponential collocation, and csim of Scilab, which the
// thesis used. They agree to what the loosest of them was asked for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "sim/periodic_motion.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/smooth/smooth_system.h"
#include "tests/residual.h"
#include "tests/sim/reference/csim_reference.h"
#include "tests/sim/thesis_scenes.h"
#include "tests/sim/uniform_motion.h"

namespace haptometer::sim {
namespace {

// what collocation is asked for, and what csim comes to in 0.1 s where it is asked for 1e-12 a step
constexpr double kLoosest = 1e-10;
constexpr Eigen::Index kCsimTimes = 20;
constexpr double kCsimRateHz = 200;

Scene From(Start start, Scene scene) {
  scene.start = start;
  return scene;
}

Eigen::VectorXd AmplitudesOf(const Scene& scene) {
  return SolveSteadyState(scene).phasors.cwiseAbs();
}

double WorstApart(const Eigen::VectorXd& one, const Eigen::VectorXd& other,
                  const Eigen::VectorXd& sizes) {
  return (one - other).cwiseAbs().cwiseQuotient(sizes).maxCoeff();
}

SmoothMotion ByCollocation(const Scene& scene, double rate_hz) {
  return {AssembleSmooth(scene, {}, {}), scene.drive, PiecewiseStartOf(scene), rate_hz,
          SmoothSettings{.tolerance = kLoosest}};
}

// ------------------------------------------------------------------------ at phase 0, in the end

// the state at phase 0 of the steady motion by three ways beside the phasor's
void ExpectOneSteadyMotion(const Scene& scene) {
  const SteadyState steady = SolveSteadyState(scene);
  const Eigen::VectorXd phasor = steady.phasors.imag();
  const Eigen::VectorXd sizes = AmplitudesOf(scene);

  const TimeResponse exact(AssembleModel(scene), scene.drive, Start::kRest);
  EXPECT_ABS(WorstApart(exact.StateAt(1.0), phasor, sizes), 0, 1e-12,
             "225 periods from rest, transients down to e^-41");

  const PeriodMap map(AssemblePiecewise(scene, {}), scene.drive);
  const PeriodicSearch search = FindPeriodicMotion(map, map.PointOf(0, 0 * phasor));
  ASSERT_TRUE(search.found.has_value());
  EXPECT_ABS(WorstApart(search.found->point.x, phasor, sizes), 0, 1e-11,
             "the map's 1e-13 over 1 less the largest multiplier, 0.2");

  constexpr int kPeriods = 22;
  SmoothMotion collocation =
      ByCollocation(From(Start::kSteady, scene), scene.drive.frequency_hz / kPeriods);
  collocation.Next();
  EXPECT_ABS(WorstApart(collocation.Positions(), phasor, sizes), 0, kLoosest,
             "what it was asked for");
}

TEST(Agreement, OfTheSteadyMotionOfTheAdapterScene) {
  const Scene scene = tests::AdapterScene();
  ExpectOneSteadyMotion(scene);
  const Eigen::VectorXd phasor = SolveSteadyState(scene).phasors.imag();
  const Eigen::VectorXd csim =
      Eigen::Map<const Eigen::VectorXd>(tests::kCsimAdapterLateTight[0], 7);
  EXPECT_ABS(WorstApart(csim, phasor, AmplitudesOf(scene)), 0, kLoosest, "csim at 1e-12 a step");
}

TEST(Agreement, OfTheSteadyMotionOfTheDirectScene) { ExpectOneSteadyMotion(tests::DirectScene()); }

// ------------------------------------------------------------------------------------- from rest

template <std::size_t kStates>
Eigen::MatrixXd Columns(const double (&csim)[kCsimTimes][kStates]) {
  return Eigen::Map<const Eigen::MatrixXd>(&csim[0][0], kStates, kCsimTimes);
}

Eigen::MatrixXd Exactly(const Scene& scene) {
  const LinearModel model = AssembleModel(scene);
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(model.states());
  return UniformMotion(model, scene.drive, rest, 0, kCsimRateHz, kCsimTimes + 1)
      .rightCols(kCsimTimes);
}

// each state's largest deviation at any of the times over its amplitude
Eigen::VectorXd Apart(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other,
                      const Scene& scene) {
  return (one - other).cwiseAbs().rowwise().maxCoeff().cwiseQuotient(AmplitudesOf(scene));
}

void ExpectOneTransient(const Scene& scene, const Eigen::MatrixXd& csim,
                        const Eigen::MatrixXd& csim_by_itself) {
  const Eigen::MatrixXd exact = Exactly(scene);
  SmoothMotion motion = ByCollocation(From(Start::kRest, scene), kCsimRateHz);
  Eigen::MatrixXd collocation(exact.rows(), kCsimTimes);
  for (Eigen::Index i = 0; i < kCsimTimes; ++i) {
    motion.Next();
    collocation.col(i) = motion.Positions();
  }
  EXPECT_ABS(Apart(collocation, exact, scene).maxCoeff(), 0, kLoosest, "what it was asked for");
  EXPECT_ABS(Apart(csim, exact, scene).maxCoeff(), 0, kLoosest, "csim at 1e-12 a step");

  // its own tolerance of a step is 1e-12 times the sum of |v|/L over 1001 outputs: 2.5e-5 A, which
  // is 1.4e-4 of the current, and much less by the time it has become speed or position
  const Eigen::VectorXd by_itself = Apart(csim_by_itself, exact, scene);
  const Eigen::Index current = exact.rows() - 1;
  for (Eigen::Index k = 0; k < current; k += 2) {
    EXPECT_ABS(by_itself(k), 0, 3e-7, "csim as it comes, positions");
    EXPECT_ABS(by_itself(k + 1), 0, 2e-5, "csim as it comes, speeds");
  }
  EXPECT_ABS(by_itself(current), 0, 1e-3, "csim as it comes, seven steps' worth");
}

TEST(Agreement, OfTheAdapterSceneFromRest) {
  ExpectOneTransient(tests::AdapterScene(), Columns(tests::kCsimAdapterTight),
                     Columns(tests::kCsimAdapter));
}

TEST(Agreement, OfTheDirectSceneFromRest) {
  ExpectOneTransient(tests::DirectScene(), Columns(tests::kCsimDirectTight),
                     Columns(tests::kCsimDirect));
}

}  // namespace
}  // namespace haptometer::sim
