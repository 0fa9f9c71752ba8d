// What tones, harmonics and spectra of 2^20 samples at 10 kHz cost.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "dsp/spectrum/envelope.h"
#include "dsp/spectrum/kinematics.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"
#include "dsp/spectrum/welch.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;

// 1 um at 225 Hz, a tenth of it at 450 Hz
std::vector<double> Vibration() {
  std::vector<double> values(1 << 20);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double phase = 2 * std::numbers::pi * 225 * static_cast<double>(k) / kRateHz;
    values[k] = 1e-6 * std::sin(phase) + 1e-7 * std::sin(2 * phase);
  }
  return values;
}

template <typename Work>
void Run(benchmark::State& state, const Work& work) {
  const std::vector<double> in = Vibration();
  for (auto _ : state) benchmark::DoNotOptimize(work(in));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(in.size()));
}

void FitKnownSine(benchmark::State& state) {
  Run(state, [](const auto& in) { return FitSineAt(in, {kRateHz, 0, 1}, 225); });
}
BENCHMARK(FitKnownSine)->Unit(benchmark::kMillisecond);

void FindTone(benchmark::State& state) {
  Run(state, [](const auto& in) { return StrongestTone(in, {kRateHz, 20, 500, 0}); });
}
BENCHMARK(FindTone)->Unit(benchmark::kMillisecond);

void FitTenHarmonics(benchmark::State& state) {
  Run(state, [](const auto& in) { return FitHarmonics(in, {kRateHz, 0}, 225, 2250); });
}
BENCHMARK(FitTenHarmonics)->Unit(benchmark::kMillisecond);

void Welch(benchmark::State& state) {
  Run(state, [](const auto& in) { return WelchSpectrum(in, {kRateHz, 8192}); });
}
BENCHMARK(Welch)->Unit(benchmark::kMillisecond);

void Demodulate(benchmark::State& state) {
  Run(state, [](const auto& in) { return DemodulateTone(in, {kRateHz, 225}); });
}
BENCHMARK(Demodulate)->Unit(benchmark::kMillisecond);

void Differentiate(benchmark::State& state) {
  Run(state, [](const auto& in) { return DescribeKinematics(in, kRateHz, 500, 0, in.size()); });
}
BENCHMARK(Differentiate)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace haptometer::dsp
