// The functions of base/ that give the same bytes everywhere, beside those of the C library: 4096
// arguments of the usual range each, by turns in one run; `ratio` is the least time of ours over
// the least time of theirs.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"

namespace haptometer {
namespace {

using Seconds = std::chrono::duration<double>;

std::vector<double> Arguments(double lower, double upper) {
  std::mt19937_64 random(20130613);
  std::uniform_real_distribution<double> uniform(lower, upper);
  std::vector<double> values(4096);
  for (double& value : values) value = uniform(random);
  return values;
}

// seconds of a function of neighbours (x, y) over all arguments
template <typename Function>
double Time(const Function& function, const std::vector<double>& arguments) {
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t k = 1; k < arguments.size(); ++k) {
    benchmark::DoNotOptimize(function(arguments[k], arguments[k - 1]));
  }
  return Seconds(std::chrono::steady_clock::now() - begin).count();
}

template <typename Ours, typename Theirs>
void Compare(benchmark::State& state, const Ours& ours, const Theirs& theirs, double lower,
             double upper) {
  const std::vector<double> arguments = Arguments(lower, upper);
  double ours_s = 1, theirs_s = 1;
  for (auto _ : state) {
    const double once_s = Time(ours, arguments);
    ours_s = std::min(ours_s, once_s);
    theirs_s = std::min(theirs_s, Time(theirs, arguments));
    state.SetIterationTime(once_s);
  }
  const auto calls = static_cast<double>(arguments.size() - 1);
  state.counters["ns"] = 1e9 * ours_s / calls;
  state.counters["theirs_ns"] = 1e9 * theirs_s / calls;
  state.counters["ratio"] = ours_s / theirs_s;
}

// NAME(x) of both over [lower, upper]
#define HAPTOMETER_COMPARE(NAME, THEIRS, LOWER, UPPER)                  \
  void NAME##Bench(benchmark::State& state) {                           \
    Compare(                                                            \
        state, [](double x, double) { return NAME(x); },                \
        [](double x, double) { return std::THEIRS(x); }, LOWER, UPPER); \
  }                                                                     \
  BENCHMARK(NAME##Bench)->Name(#NAME)->UseManualTime();

HAPTOMETER_COMPARE(Exp, exp, -20, 20)
HAPTOMETER_COMPARE(Expm1, expm1, -2, 2)
HAPTOMETER_COMPARE(Log, log, 0, 100)
HAPTOMETER_COMPARE(Log1p, log1p, -0.9, 2)
HAPTOMETER_COMPARE(Log10, log10, 0, 100)
HAPTOMETER_COMPARE(Sinh, sinh, -5, 5)
HAPTOMETER_COMPARE(Asinh, asinh, -5, 5)
HAPTOMETER_COMPARE(Cbrt, cbrt, 0, 10)
HAPTOMETER_COMPARE(Erfc, erfc, -6, 28)
HAPTOMETER_COMPARE(Sin, sin, -4, 4)
HAPTOMETER_COMPARE(Cos, cos, -4, 4)
HAPTOMETER_COMPARE(Tan, tan, -4, 4)

#undef HAPTOMETER_COMPARE

void PowBench(benchmark::State& state) {
  Compare(
      state, [](double x, double y) { return Pow(x, y); },
      [](double x, double y) { return std::pow(x, y); }, 0, 10);
}
BENCHMARK(PowBench)->Name("Pow")->UseManualTime();

void HypotBench(benchmark::State& state) {
  Compare(
      state, [](double x, double y) { return Hypot(x, y); },
      [](double x, double y) { return std::hypot(x, y); }, -2, 2);
}
BENCHMARK(HypotBench)->Name("Hypot")->UseManualTime();

void Atan2Bench(benchmark::State& state) {
  Compare(
      state, [](double x, double y) { return Atan2(y, x); },
      [](double x, double y) { return std::atan2(y, x); }, -2, 2);
}
BENCHMARK(Atan2Bench)->Name("Atan2")->UseManualTime();

void SinCosBench(benchmark::State& state) {
  Compare(
      state,
      [](double x, double) {
        const SineAndCosine parts = SinCos(x);
        return parts.sine + parts.cosine;
      },
      [](double x, double) { return std::sin(x) + std::cos(x); }, -4, 4);
}
BENCHMARK(SinCosBench)->Name("SinCos")->UseManualTime();

// angles that are reduced by many bits
void LargeAngles(benchmark::State& state) {
  Compare(
      state, [](double x, double) { return Sin(x); }, [](double x, double) { return std::sin(x); },
      1e9, 1e15);
}
BENCHMARK(LargeAngles)->Name("Sin of 1e9 to 1e15")->UseManualTime();

void PolarBench(benchmark::State& state) {
  Compare(
      state, [](double x, double y) { return Polar(std::abs(y), x); },
      [](double x, double y) { return std::polar(std::abs(y), x); }, -4, 4);
}
BENCHMARK(PolarBench)->Name("Polar")->UseManualTime();

void SqrtBench(benchmark::State& state) {
  Compare(
      state, [](double x, double y) { return Sqrt(std::complex<double>(x, y)); },
      [](double x, double y) { return std::sqrt(std::complex<double>(x, y)); }, -2, 2);
}
BENCHMARK(SqrtBench)->Name("Sqrt of a complex number")->UseManualTime();

}  // namespace
}  // namespace haptometer
