// What accuracy costs: prints docs/filter_cost.csv (fixtures/generate/filter_cost.py runs and draws
// it). A hand-held record: 30 mm, 0.5 mm of tremor at 8.3 Hz, 1 um at 100 Hz, 10 kHz. `error` is
// how far the band RMS over 100 s is from that of the 1 um; sums are compared with the closed form.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "dsp/filter/cascade.h"
#include "dsp/filter/fir.h"
#include "dsp/filter/overlap_save.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;
constexpr std::size_t kEdge = 50'000;
constexpr std::size_t kMiddle = 1'000'000;

std::vector<double> HandHeld() {
  std::vector<double> values(kMiddle + 2 * kEdge);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(k) / kRateHz;
    values[k] = 30e-3 + 0.5e-3 * std::sin(8.3 * turn) + 1e-6 * std::sin(100 * turn);
  }
  return values;
}

// the best time of five, per sample of `count`
template <typename Work>
double NanosecondsPerSample(std::size_t count, const Work& work) {
  double best = 1e9;
  for (int k = 0; k < 5; ++k) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
    best = std::min(best, taken.count());
  }
  return best / static_cast<double>(count);
}

void Print(const std::string& method, const std::string& setting, double nanoseconds,
           double error) {
  std::cout << method << ',' << setting << ',' << nanoseconds << ',' << error << '\n';
}

void Filter(const std::string& method, const std::string& setting,
            const std::function<std::vector<double>()>& filter) {
  std::vector<double> out;
  const double nanoseconds = NanosecondsPerSample(kMiddle + 2 * kEdge, [&] { out = filter(); });
  const double rms = Rms(std::span(out).subspan(kEdge, kMiddle));
  Print(method, setting, nanoseconds, std::abs(rms * std::numbers::sqrt2 / 1e-6 - 1));
}

void Filters() {
  const std::vector<double> in = HandHeld();
  for (int order = 1; order <= kHighestOrder; ++order) {
    const std::string setting = std::to_string(order);
    const FilterDesign once = DesignBandPass({order, 20, 500, Corners::kEach}, kRateHz).value();
    Filter("one pass", setting, [&] {
      std::vector<double> out(in.size());
      Cascade cascade(once);
      cascade.StartFrom(in.front());
      cascade.Process(in, out);
      return out;
    });
    const FilterDesign whole = DesignBandPass({order, 20, 500}, kRateHz).value();
    Filter("zero phase", setting, [&] { return FilterZeroPhase(whole, in); });
    Filter("FFT", setting, [&] { return FilterByFft(whole, in); });
  }
  for (const double transition_hz : {20.0, 10.0, 5.0}) {
    for (const double attenuation_db : {60.0, 80.0, 100.0, 140.0}) {
      const auto taps =
          DesignFirBandPass({20, 500, transition_hz, attenuation_db}, kRateHz).value();
      Filter("FIR " + std::to_string(static_cast<int>(transition_hz)) + " Hz",
             std::to_string(static_cast<int>(attenuation_db)) + " dB",
             [&] { return FilterByOverlapSave(taps, in); });
    }
  }
}

template <typename Number>
double NaiveRms(std::span<const double> values) {
  Number sum = 0;
  for (const double value : values) sum += static_cast<Number>(value) * static_cast<Number>(value);
  return std::sqrt(static_cast<double>(sum) / static_cast<double>(values.size()));
}

void Sums() {
  // whole periods: the mean square is 1/2
  std::vector<double> values(10 * kMiddle);
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] = std::sin(2 * std::numbers::pi * static_cast<double>(k % 100) / 100);
  }
  const auto sum = [&](const std::string& setting, double (*rms)(std::span<const double>)) {
    double found = 0;
    const double nanoseconds = NanosecondsPerSample(values.size(), [&] { found = rms(values); });
    Print("RMS", setting, nanoseconds, std::abs(found * std::numbers::sqrt2 - 1));
  };
  sum("naive float", NaiveRms<float>);
  sum("naive double", NaiveRms<double>);
  sum("pairwise", Rms);
}

}  // namespace
}  // namespace haptometer::dsp

int main() {
  std::cout.precision(4);
  haptometer::dsp::Filters();
  haptometer::dsp::Sums();
}
