// Text of an oscilloscope to a record: 10 000 rows are to take below 10 ms, a layout that needs no
// more than its header, and one whose times repeat and are put on a grid.
#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <string>

#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

std::string Table(std::int64_t rows, std::string_view head, int digits) {
  std::string text(head);
  for (std::int64_t row = 0; row < rows; ++row) {
    const auto k = static_cast<double>(row);
    text += fmt::format("{:.{}e},{:.4f}\n", k * 1e-6, digits, (k - 5e3) * 1e-4);
  }
  return text;
}

void Read(benchmark::State& state, const std::string& text) {
  for (auto _ : state) {
    auto record = ParseCsv(text, "bench");
    if (!record) state.SkipWithError(record.error().Text().c_str());
    benchmark::DoNotOptimize(record);
  }
  state.counters["rows/s"] = benchmark::Counter(
      static_cast<double>(state.iterations() * state.range(0)), benchmark::Counter::kIsRate);
}

void ScopeCsv(benchmark::State& state) {
  Read(state, Table(state.range(0), "Source,CH1\nSecond,Volt\n", 8));
}
BENCHMARK(ScopeCsv)->Arg(10'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);

void ScopeCsvOfFiveDigits(benchmark::State& state) {
  Read(state, Table(state.range(0), "Time(s),CH1(V)\n", 4));
}
BENCHMARK(ScopeCsvOfFiveDigits)->Arg(10'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace haptometer::trial
