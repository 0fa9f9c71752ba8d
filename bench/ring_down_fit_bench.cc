// What fit-lra spends: one evaluation of the closed form, the start values, a whole fit.
#include <benchmark/benchmark.h>

#include <cmath>
#include <limits>
#include <random>

#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/ring_start.h"
#include "sim/ring_down.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/sim/ring_ratios.h"

namespace haptometer {
namespace {

constexpr double kOpen = std::numeric_limits<double>::infinity();

sim::RingDown<double> Circuit(double load_ohm) {
  return sim::RingDown<double>({.stiffness_n_per_m = 2800,
                                .damping_n_s_per_m = 0.0322,
                                .force_constant_squared_n2_per_a2 = 1,
                                .mass_kg = 1.4e-3,
                                .coil_resistance_ohm = 27,
                                .inductance_h = 130e-6,
                                .load_ohm = load_ohm});
}

// `samples` over 0.28 s with 0.5 % of noise
fit::ImpulseRecord Record(double load_ohm, std::size_t samples) {
  const auto circuit = Circuit(load_ohm);
  fit::ImpulseRecord record;
  record.step_s = 0.28 / static_cast<double>(samples);
  record.load_ohm = Quantity{load_ohm, 0};
  record.condition = fit::CaseCondition::kHeld;
  std::mt19937 engine(1);
  std::normal_distribution<double> noise(0, 2e-3);
  for (std::size_t n = 0; n < samples; ++n) {
    const double t = static_cast<double>(n + 1) * record.step_s;
    record.voltage_v.push_back(-0.443 * VoltageRatio(circuit, t) + noise(engine));
  }
  return record;
}

void PolesOfALoadedCircuit(benchmark::State& state) {
  double load_ohm = 33;
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(load_ohm);
    benchmark::DoNotOptimize(Circuit(load_ohm));
  }
}
BENCHMARK(PolesOfALoadedCircuit);

void VoltageOfALoadedCircuit(benchmark::State& state) {
  const auto circuit = Circuit(33);
  double time_s = 0;
  while (state.KeepRunning()) {
    time_s = time_s > 0.25 ? 0 : time_s + 1e-4;
    benchmark::DoNotOptimize(VoltageRatio(circuit, time_s));
  }
}
BENCHMARK(VoltageOfALoadedCircuit);

void StartOfARingDown(benchmark::State& state) {
  const auto record = Record(kOpen, static_cast<std::size_t>(state.range(0)));
  while (state.KeepRunning()) benchmark::DoNotOptimize(fit::FindRingStart(record));
}
BENCHMARK(StartOfARingDown)->Arg(3000)->Arg(100'000)->Unit(benchmark::kMillisecond);

void FitOfAPair(benchmark::State& state) {
  const auto samples = static_cast<std::size_t>(state.range(0));
  const std::vector records{Record(kOpen, samples), Record(33, samples)};
  const fit::ActuatorKnowns knowns{Quantity{1.4e-3, 0}, Quantity{0.6e-3, 0}, Quantity{27, 0},
                                   Quantity{130e-6, 0}};
  while (state.KeepRunning()) benchmark::DoNotOptimize(fit::FitDropTest(records, knowns));
}
BENCHMARK(FitOfAPair)->Arg(3000)->Arg(100'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace haptometer
