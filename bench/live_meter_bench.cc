// What a live view costs the thread that reads the port: one reading at 10 kHz, in the band-pass of
// order 6, while nobody or somebody looks.
#include <benchmark/benchmark.h>

#include <atomic>
#include <thread>

#include "tools/acquire/live_view.h"

namespace haptometer::tools {
namespace {

trial::TrialHeader Stream() {
  trial::TrialHeader header;
  header.timing = trial::Timing::kArrival;
  header.channels = {{.name = "displacement",
                      .role = trial::ChannelRole::kDisplacement,
                      .unit = "m",
                      .encoding = trial::Encoding::kI32,
                      .scale = 1e-7}};
  return header;
}

// what is added: 1 um of 225 Hz-like triangle about 30 mm, every 100 us
class Readings {
 public:
  Readings() { reading_.samples.resize(1); }
  const acquire::Reading& Next() {
    reading_.time_ns += 100'000;
    count_ = (count_ + 1) % 44;
    reading_.samples[0].raw = trial::RawValue::Counts(300'000 + count_);
    return reading_;
  }

 private:
  acquire::Reading reading_;
  std::int32_t count_ = 0;
};

void BM_AddAReading(benchmark::State& state) {
  LiveMeter meter(Stream(), dsp::BandPass{});
  Readings readings;
  for (int n = 0; n < 20'000; ++n) meter.Add(readings.Next());  // the rate is known
  for (auto _ : state) meter.Add(readings.Next());
}
BENCHMARK(BM_AddAReading);

// somebody looks without a pause, which a view does twice a second
void BM_AddAReadingWhileSomebodyLooks(benchmark::State& state) {
  LiveMeter meter(Stream(), dsp::BandPass{});
  Readings readings;
  for (int n = 0; n < 20'000; ++n) meter.Add(readings.Next());
  std::atomic<bool> stop{false};
  std::thread looking([&] {
    while (!stop.load()) benchmark::DoNotOptimize(meter.Figures());
  });
  for (auto _ : state) meter.Add(readings.Next());
  stop.store(true);
  looking.join();
}
BENCHMARK(BM_AddAReadingWhileSomebodyLooks);

void BM_Figures(benchmark::State& state) {
  LiveMeter meter(Stream(), dsp::BandPass{});
  Readings readings;
  for (int n = 0; n < 40'000; ++n) meter.Add(readings.Next());
  for (auto _ : state) benchmark::DoNotOptimize(meter.Figures());
}
BENCHMARK(BM_Figures)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace haptometer::tools
