// What the search for an adapter costs: the thesis's grid of 20^5 points, one motion in closed
// form, and the optimum with its proof, also within a travel and a latency. Counters: boxes of the
// proof, what it leaves open, runs of the search.
#include <benchmark/benchmark.h>

#include "sim/linear/motor_source.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/adapter_optimum.h"
#include "sim/tuning/latency_limit.h"
#include "sim/tuning/travel_limit.h"

namespace haptometer::sim {
namespace {

void ThesisGrid(benchmark::State& state) {
  const TuningProblem problem = ThesisProblem();
  for (auto _ : state) benchmark::DoNotOptimize(BestOnGrid(problem, 20));
}
BENCHMARK(ThesisGrid)->Unit(benchmark::kMillisecond);

void OneMotion(benchmark::State& state) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const Skin skin = SkinOf(problem, 1e-6);
  const Adapter adapter{.motor_side_mass_kg = 0.25e-3,
                        .skin_side_mass_kg = 4.35e-3,
                        .stiffness_n_per_m = 8200,
                        .damping_n_s_per_m = 0.01};
  for (auto _ : state) benchmark::DoNotOptimize(MotionOf(source, adapter, skin));
}
BENCHMARK(OneMotion);

void BestPoint(benchmark::State& state) {
  const TuningProblem problem = ThesisProblem();
  for (auto _ : state) benchmark::DoNotOptimize(BestWithinTravel(Objective::kSkinRms, problem, {}));
}
BENCHMARK(BestPoint)->Unit(benchmark::kMillisecond);

// objective, and the gap as a power of ten
void BestPointWithProof(benchmark::State& state) {
  const TuningProblem problem = ThesisProblem();
  const auto objective = static_cast<Objective>(state.range(0));
  const double gap = state.range(1) == 9 ? 1e-9 : state.range(1) == 6 ? 1e-6 : 1e-5;
  AdapterOptimum optimum;
  for (auto _ : state) optimum = FindAdapterOptimum(objective, problem, {}, gap);
  state.SetLabel(std::string(Name(objective)));
  state.counters["boxes"] = static_cast<double>(optimum.boxes);
}
BENCHMARK(BestPointWithProof)
    ->ArgsProduct({{static_cast<int>(Objective::kSkinRms), static_cast<int>(Objective::kStimulus),
                    static_cast<int>(Objective::kSkinPower)},
                   {5, 6, 9}})
    ->Unit(benchmark::kMillisecond);

// the mover's limit in um
void BestPointWithinTravel(benchmark::State& state) {
  TuningProblem problem = ThesisProblem();
  problem.mover_limit_m = 1e-6 * static_cast<double>(state.range(0));
  AdapterOptimum optimum;
  for (auto _ : state) optimum = FindAdapterOptimum(Objective::kSkinRms, problem, {});
  state.counters["boxes"] = static_cast<double>(optimum.boxes);
  state.counters["gap"] = optimum.upper_bound / optimum.value - 1;
}
BENCHMARK(BestPointWithinTravel)->Arg(50)->Arg(200)->Arg(600)->Unit(benchmark::kMillisecond);

void BestPointWithinLatency(benchmark::State& state) {
  const TuningProblem problem = ThesisProblem();
  const AdapterPoint unlimited = BestWithinTravel(Objective::kSkinRms, problem, {}).point;
  PromptBest best;
  for (auto _ : state) best = BestWithinLatency(problem, 2.654e-3, unlimited);
  state.counters["runs"] = static_cast<double>(best.runs);
}
BENCHMARK(BestPointWithinLatency)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace haptometer::sim
