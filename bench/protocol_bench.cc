// Bytes to readings: lines per second through framing and parsing. A 921600 baud wire brings 10
// 240.
#include <benchmark/benchmark.h>

#include <array>
#include <string>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/line_framer.h"
#include "acquire/protocol/stream_line.h"

namespace haptometer::acquire {
namespace {

constexpr int kLines = 1000;

// feeds `bytes` in pieces of the benchmark's argument and hands each line to `parse`
template <typename Parse>
void RunLines(benchmark::State& state, Delimiter delimiter, std::size_t longest,
              const std::string& bytes, Parse parse) {
  LineFramer framer(delimiter, longest);
  const auto piece = static_cast<std::size_t>(state.range(0));
  for (auto _ : state) {
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
      framer.Feed(std::string_view(bytes).substr(at, piece));
      for (Frame frame = framer.Next(); frame.framing == Framing::kValid; frame = framer.Next()) {
        auto reading = parse(frame.text);
        benchmark::DoNotOptimize(reading);
      }
    }
  }
  state.counters["lines/s"] = benchmark::Counter(static_cast<double>(state.iterations()) * kLines,
                                                 benchmark::Counter::kIsRate);
}

void StreamLines(benchmark::State& state) {
  const StreamFormat format;
  std::string bytes;
  for (int i = 0; i < kLines; ++i) bytes += FormatStreamLine(format, {i * 37 - 500, 4, {}});
  RunLines(state, format.delimiter, 4 * LineBytes(format), bytes,
           [&](std::string_view line) { return ParseStreamLine(format, line); });
}
BENCHMARK(StreamLines)->Arg(9)->Arg(64)->Arg(4095);

void DlRs1aReplies(benchmark::State& state) {
  std::string bytes;
  for (int i = 0; i < kLines; ++i) {
    bytes += dl::FormatM0Reply(dl_rs1a::Spelling(), std::array{Value{i * 3 - 500, 3, {}}});
  }
  RunLines(state, Delimiter::kCrLf, dl_rs1a::kLongestLine, bytes,
           [](std::string_view line) { return dl::ParseReply(dl_rs1a::Spelling(), line); });
}
BENCHMARK(DlRs1aReplies)->Arg(12)->Arg(64);

}  // namespace
}  // namespace haptometer::acquire
