// The band-pass over 2^20 samples at 10 kHz: one causal pass, forward and backward, and what an
// order costs against how well it keeps tremor out.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "dsp/filter/cascade.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;

// 30 mm of distance, 0.5 mm of tremor at 8.3 Hz, 1 um of vibration at 100 Hz
std::vector<double> HandHeld(std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    values[k] = 30e-3 + 0.5e-3 * std::sin(2 * std::numbers::pi * 8.3 * t_s) +
                1e-6 * std::sin(2 * std::numbers::pi * 100 * t_s);
  }
  return values;
}

void CountSamples(benchmark::State& state, std::size_t samples) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(samples));
}

void Causal(benchmark::State& state) {
  const FilterDesign design =
      DesignBandPass({static_cast<int>(state.range(0)), 20, 500}, kRateHz).value();
  const std::vector<double> in = HandHeld(1 << 20);
  std::vector<double> out(in.size());
  Cascade cascade(design);
  for (auto _ : state) {
    cascade.StartFrom(in[0]);
    cascade.Process(in, out);
    benchmark::DoNotOptimize(out.data());
  }
  CountSamples(state, in.size());
}
BENCHMARK(Causal)->DenseRange(2, 8, 2)->Unit(benchmark::kMillisecond);

// `leaked` is the tremor's share of the result, relative to the vibration
void ZeroPhase(benchmark::State& state) {
  const FilterDesign design =
      DesignBandPass({static_cast<int>(state.range(0)), 20, 500}, kRateHz).value();
  const std::vector<double> in = HandHeld(1 << 20);
  for (auto _ : state) benchmark::DoNotOptimize(FilterZeroPhase(design, in));
  CountSamples(state, in.size());
  state.counters["leaked"] =
      500 * std::norm(Response(design, 8.3)) / std::norm(Response(design, 100));
}
BENCHMARK(ZeroPhase)->DenseRange(2, 8, 1)->Unit(benchmark::kMillisecond);

void RootMeanSquare(benchmark::State& state) {
  const std::vector<double> in = HandHeld(1 << 20);
  for (auto _ : state) benchmark::DoNotOptimize(Rms(in));
  CountSamples(state, in.size());
}
BENCHMARK(RootMeanSquare);

void FourParameterFit(benchmark::State& state) {
  const std::vector<double> in = HandHeld(30'000);
  for (auto _ : state) benchmark::DoNotOptimize(FitSine(in, {kRateHz, 0}, 8.31));
  CountSamples(state, in.size());
}
BENCHMARK(FourParameterFit)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace haptometer::dsp
