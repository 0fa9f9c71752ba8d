// What an emulated device costs: lines or answers a second of processor time, without any wire.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <string>

#include "acquire/emulator/dl_unit.h"
#include "acquire/emulator/stream_head.h"

namespace haptometer::acquire::emulator {
namespace {

double Sine(double t_s) { return 2e-4 * std::sin(2 * std::numbers::pi * 225 * t_s); }

// one millisecond of a 10 kHz head at a time, as the server asks for it
void StreamLines(benchmark::State& state) {
  StreamHead head({.head = {.head = trial::Stream10kHz(), .displacement = Sine}});
  std::string out;
  MonotonicNs now = 0;
  while (state.KeepRunning()) {
    out.clear();
    now += 1'000'000;
    head.Advance(now, out);
    benchmark::DoNotOptimize(out.data());
  }
  state.SetItemsProcessed(10 * state.iterations());
}
BENCHMARK(StreamLines);

// one M0 exchange of an IL-030 with 16 averages, byte by byte
void PolledAnswers(benchmark::State& state) {
  DlRs1aUnit unit({.baud = 38400, .head = {.head = trial::Il030(), .displacement = Sine}});
  std::string out;
  MonotonicNs now = 0;
  while (state.KeepRunning()) {
    out.clear();
    unit.Receive("M0\r\n", now);
    while (!out.ends_with('\n')) {
      now = *unit.NextDue();
      unit.Advance(now, out);
    }
    benchmark::DoNotOptimize(out.data());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(PolledAnswers);

}  // namespace
}  // namespace haptometer::acquire::emulator
