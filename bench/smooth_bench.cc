// What smooth nonlinear effects cost by SmoothMotion, for 0.05 s of the adapter scene at 10 kHz
// from rest, set-up included, by tolerance. Counters: error, of the worst state at any
// output over its largest value, against the exact motion where there is one, else against a run at
// 1e-12; estimate, what the run itself says (then its second run is in the time); steps,
// evaluations. And periodic motions by shooting.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "sim/linear/linear_model.h"
#include "sim/periodic_motion.h"
#include "sim/smooth/smooth_system.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr Eigen::Index kOutputs = 500;

Scene FromRest(Scene scene) {
  scene.start = Start::kRest;
  return scene;
}

TravelStops Rigid() { return {.gap_up_m = 0.3e-3, .gap_down_m = 0.3e-3, .restitution = 0.5}; }

// what a run is about
struct Case {
  PiecewiseEffects piecewise{};
  SmoothEffects smooth{};
  double inductance_h = 130e-6;
};

const Case kLinear{};
const Case kSlowCoil{.inductance_h = 27.0 / 2e3};  // not stiff: R/L = 2000/s
const Case kStops{.piecewise = {.stops = Rigid()}};
const Case kSpring{.smooth = {.spring = StiffeningSpring{3e9}}};
const Case kSpringAndHeat{.smooth = {.spring = StiffeningSpring{3e9},
                                     .heating = CoilHeating{.heat_capacity_j_per_k = 1e-3,
                                                            .thermal_resistance_k_per_w = 100}}};
const Case kAll{.piecewise = {.stops = Rigid(), .contact_loss = ContactLoss{0.07}},
                .smooth = kSpringAndHeat.smooth};

Scene SceneOf(const Case& that) {
  Scene scene = FromRest(tests::AdapterScene());
  scene.actuator.inductance_h = that.inductance_h;
  return scene;
}

template <typename Motion>
Eigen::MatrixXd Samples(Motion& motion) {
  Eigen::MatrixXd samples(7, kOutputs);
  for (Eigen::Index i = 0; i < kOutputs; ++i) {
    motion.Next();
    samples.col(i) = motion.Positions();
  }
  return samples;
}

SmoothMotion MotionOf(const Case& that, const SmoothSettings& settings) {
  const Scene scene = SceneOf(that);
  return {AssembleSmooth(scene, that.piecewise, that.smooth), scene.drive, PiecewiseStartOf(scene),
          1e4, settings};
}

Eigen::MatrixXd Reference(const Case& that) {
  if (that.smooth.spring || that.smooth.heating) {
    SmoothMotion motion = MotionOf(that, {.tolerance = 1e-12});
    return Samples(motion);
  }
  const Scene scene = SceneOf(that);
  PiecewiseMotion motion(AssemblePiecewise(scene, that.piecewise), scene.drive,
                         PiecewiseStartOf(scene), 1e4);
  return Samples(motion);
}

// range(0): digits of the tolerance
void Ladder(benchmark::State& state, const Case& that) {
  const Eigen::MatrixXd reference = Reference(that);
  const SmoothSettings settings{.tolerance = std::pow(10.0, -static_cast<double>(state.range(0)))};
  Eigen::MatrixXd samples;
  SolverWork work;
  for (auto _ : state) {
    SmoothMotion motion = MotionOf(that, settings);
    samples = Samples(motion);
    work = motion.work();
  }
  const Eigen::VectorXd largest = reference.cwiseAbs().rowwise().maxCoeff();
  const Eigen::VectorXd apart = (samples - reference).cwiseAbs().rowwise().maxCoeff();
  state.counters["error"] = apart.cwiseQuotient(largest).maxCoeff();
  state.counters["steps"] = static_cast<double>(work.steps);
  state.counters["evaluations"] = static_cast<double>(work.evaluations);
}

void Rungs(benchmark::internal::Benchmark* bench) {
  bench->DenseRange(2, 10, 2)->Unit(benchmark::kMicrosecond);
}

BENCHMARK_CAPTURE(Ladder, linear, kLinear)->Apply(Rungs);
BENCHMARK_CAPTURE(Ladder, slow_coil, kSlowCoil)->Apply(Rungs);
BENCHMARK_CAPTURE(Ladder, rigid_stops, kStops)->Apply(Rungs);
BENCHMARK_CAPTURE(Ladder, spring, kSpring)->Apply(Rungs);
BENCHMARK_CAPTURE(Ladder, spring_and_heat, kSpringAndHeat)->Apply(Rungs);
BENCHMARK_CAPTURE(Ladder, all, kAll)->Apply(Rungs);

void Search(benchmark::State& state, const PeriodMap& map, const PeriodPoint& start) {
  PeriodicSearch search;
  for (auto _ : state) search = FindPeriodicMotion(map, start);
  state.counters["played"] = static_cast<double>(search.periods_played);
  if (!search.found) return;
  state.counters["drive_periods"] = search.found->drive_periods;
  state.counters["multiplier"] = std::abs(search.found->multipliers(0));
}

void SearchExact(benchmark::State& state, const Scene& scene, const PiecewiseEffects& effects) {
  const PeriodMap map(AssemblePiecewise(scene, effects), scene.drive);
  Search(state, map, map.PointOf(0, PiecewiseStartOf(scene).x));
}

const Scene kAdapterScene = FromRest(tests::AdapterScene());
const Scene kDirectScene = FromRest(tests::DirectScene());
const PiecewiseEffects kOwnWeight{.contact_loss = ContactLoss{2e-3 * 9.80665}};

BENCHMARK_CAPTURE(SearchExact, linear, kAdapterScene, PiecewiseEffects{})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(SearchExact, rigid_stops, kAdapterScene, kStops.piecewise)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(SearchExact, contact_period_2, kDirectScene, kOwnWeight)
    ->Unit(benchmark::kMillisecond);

// range(0): digits of the tolerance
void SearchSmooth(benchmark::State& state, const Case& that) {
  const Scene scene = SceneOf(that);
  const PeriodMap map(AssembleSmooth(scene, that.piecewise, that.smooth), scene.drive,
                      {.tolerance = std::pow(10.0, -static_cast<double>(state.range(0)))});
  Search(state, map, map.PointOf(0, PiecewiseStartOf(scene).x));
}
BENCHMARK_CAPTURE(SearchSmooth, spring, kSpring)->Arg(4)->Arg(8)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(SearchSmooth, spring_and_heat, kSpringAndHeat)
    ->Arg(8)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace haptometer::sim
