// Rows a second into and out of a trial.bin of one i32 channel with arrival times (13 bytes a row),
// in memory, and the time base behind them.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.h"
#include "trial/time_base.h"
#include "trial/trial_reader.h"
#include "trial/trial_writer.h"

namespace haptometer::trial {
namespace {

class StringSink final : public ByteSink {
 public:
  explicit StringSink(std::string* bytes) : bytes_(bytes) {}
  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    bytes_->append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return bytes.size();
  }
  Result<void> Sync() override { return {}; }

 private:
  std::string* bytes_;
};

constexpr std::int64_t kPeriodNs = 100'000;

std::string Written(std::int64_t rows) {
  TrialHeader header;
  header.timing = Timing::kArrival;
  ChannelFormat channel;
  channel.role = ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.encoding = Encoding::kI32;
  channel.scale = 1e-7;
  header.channels.push_back(channel);
  std::string bytes;
  SystemClock clock;
  auto writer =
      TrialWriter::CreateIn(std::make_unique<StringSink>(&bytes), "bench", header, {}, clock);
  for (std::int64_t i = 0; i < rows; ++i) {
    const Sample sample{RawValue::Counts(static_cast<std::int32_t>(i)), SampleStatus::kOk};
    if (!writer->Append({.time_ns = i * kPeriodNs, .samples = {&sample, 1}})) break;
  }
  if (!writer->Finish()) bytes.clear();
  return bytes;
}

void CountRows(benchmark::State& state) {
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.SetBytesProcessed(state.iterations() * state.range(0) * 13);
}

void Write(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(Written(state.range(0)));
  CountRows(state);
}
BENCHMARK(Write)->Arg(100'000);

void Stream(benchmark::State& state) {
  const std::string bytes = Written(state.range(0));
  for (auto _ : state) {
    auto reader = TrialReader::OpenFrom(MakeMemorySource(bytes), "bench");
    double sum = 0;
    for (;;) {
      const auto chunk = reader->Next();
      if (!chunk || *chunk == nullptr) break;
      for (std::size_t row = 0; row < (*chunk)->rows(); ++row) sum += (*chunk)->ValueAt(row, 0);
    }
    benchmark::DoNotOptimize(sum);
  }
  CountRows(state);
}
BENCHMARK(Stream)->Arg(100'000);

void WholeRecord(benchmark::State& state) {
  const std::string bytes = Written(state.range(0));
  for (auto _ : state) {
    auto recording = ReadRecordFrom(MakeMemorySource(bytes), "bench");
    benchmark::DoNotOptimize(recording);
  }
  CountRows(state);
}
BENCHMARK(WholeRecord)->Arg(100'000);

void ArrivalTimes(benchmark::State& state) {
  std::vector<std::int64_t> times;
  times.reserve(static_cast<std::size_t>(state.range(0)));
  // bursts of 160 lines, as a USB converter hands them out
  for (std::int64_t i = 0; i < state.range(0); ++i)
    times.push_back((i / 160 + 1) * 160 * kPeriodNs);
  for (auto _ : state) benchmark::DoNotOptimize(FitArrivalTimes(times, std::nullopt));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(ArrivalTimes)->Arg(100'000);

}  // namespace
}  // namespace haptometer::trial
