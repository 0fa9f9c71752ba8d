// What accuracy costs: prints docs/filter_cost.csv (fixtures/generate/filter_cost.py runs and draws
// it). A hand-held record: 30 mm, 0.5 mm of tremor at 8.3 Hz, 1 um at 100 Hz, 10 kHz. The error of
// the answer is how far the band RMS over 100 s is from that of the 1 um; the error of the
// arithmetic how far the samples are, in RMS, from the same filter in 113 bits. Sums of squares are
// compared with one in 113 bits.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <numbers>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/fir.h"
#include "bench/mean_square.h"
#include "bench/plain_cascade.h"
#include "dsp/filter/cascade.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"
#include "tests/dsp/filter/exact_filter.h"
#include "tests/dsp/signals.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;
constexpr std::size_t kEdge = 50'000;  // every filter of the ladder has settled to 1e-30 by then
constexpr std::size_t kMiddle = 1'000'000;
constexpr std::size_t kSums = 10'000'000;

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

// samples of a filter's output as they would be without rounding
struct ExactSamples {
  std::size_t step = 1;  // from kEdge on, every `step`-th
  std::vector<Quad> values;
};

constexpr std::size_t kExact = 20'000;  // the record's first 2 kEdge + kExact samples tell them

std::vector<Quad> Beginning(const std::vector<double>& in) {
  return {in.begin(), in.begin() + 2 * kEdge + kExact};
}

ExactSamples Middle(const std::vector<Quad>& filtered) {
  return {1, {filtered.begin() + kEdge, filtered.begin() + kEdge + kExact}};
}

ExactSamples ExactOnePass(const FilterDesign& design, const std::vector<double>& in) {
  return Middle(QuadFiltered(design, Beginning(in), static_cast<Quad>(in.front())));
}

ExactSamples ExactTwoPasses(const FilterDesign& design, const std::vector<double>& in) {
  std::vector<Quad> turned = QuadFiltered(design, Beginning(in), static_cast<Quad>(in.front()));
  std::ranges::reverse(turned);
  const Quad start = turned.front();
  std::vector<Quad> filtered = QuadFiltered(design, std::move(turned), start);
  std::ranges::reverse(filtered);
  return Middle(filtered);
}

ExactSamples ExactConvolution(const std::vector<double>& taps, const std::vector<double>& in) {
  ExactSamples exact{kExact / 100, {}};
  const std::size_t reach = (taps.size() - 1) / 2;
  for (std::size_t at = kEdge; at < kEdge + kExact; at += exact.step) {
    Quad sum = 0;
    for (std::size_t k = 0; k < taps.size(); ++k) {
      sum += static_cast<Quad>(taps[k]) * static_cast<Quad>(in[at + reach - k]);
    }
    exact.values.push_back(sum);
  }
  return exact;
}

template <typename Number>
double ArithmeticError(const std::vector<Number>& out, const ExactSamples& exact) {
  Quad error = 0;
  Quad power = 0;
  for (std::size_t k = 0; k < exact.values.size(); ++k) {
    const Quad off = static_cast<Quad>(out[kEdge + k * exact.step]) - exact.values[k];
    error += off * off;
    power += exact.values[k] * exact.values[k];
  }
  return std::sqrt(static_cast<double>(error / power));
}

void Print(const std::string& method, const std::string& setting, double nanoseconds,
           const std::string& answer_error, double arithmetic_error) {
  std::cout << method << ',' << setting << ',' << nanoseconds << ',' << answer_error << ','
            << arithmetic_error << '\n';
}

std::string Digits(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

// `filter` returns its output, in doubles or floats
template <typename Filter>
void Measure(const std::string& method, const std::string& setting, const ExactSamples& exact,
             const Filter& filter) {
  decltype(filter()) out;
  const double nanoseconds = NanosecondsPerSample(kMiddle + 2 * kEdge, [&] { out = filter(); });
  const std::vector<double> middle(out.begin() + kEdge, out.begin() + kEdge + kMiddle);
  Print(method, setting, nanoseconds,
        Digits(std::abs(Rms(middle) * std::numbers::sqrt2 / 1e-6 - 1)),
        ArithmeticError(out, exact));
}

template <int kOrder>
void Filters(const std::vector<double>& in, const std::vector<float>& in_float) {
  const std::string setting = std::to_string(kOrder);
  const FilterDesign once = DesignBandPass({kOrder, 20, 500, Corners::kEach}, kRateHz).value();
  const ExactSamples one_pass = ExactOnePass(once, in);
  Measure("one pass", setting, one_pass, [&] {
    std::vector<double> out(in.size());
    Cascade cascade(once);
    cascade.StartFrom(in.front());
    cascade.Process(in, out);
    return out;
  });
  const std::span<const float> floats = in_float;
  Measure("one pass in float", setting, one_pass,
          [&] { return OnePass<DeltaForm<float, kOrder>>(once, floats); });

  const FilterDesign whole = DesignBandPass({kOrder, 20, 500}, kRateHz).value();
  const ExactSamples two_passes = ExactTwoPasses(whole, in);
  const std::span<const double> doubles = in;
  Measure("zero phase", setting, two_passes, [&] { return FilterZeroPhase(whole, in); });
  Measure("zero phase in float", setting, two_passes,
          [&] { return TwoPasses<DeltaForm<float, kOrder>>(whole, floats); });
  Measure("zero phase in direct form", setting, two_passes,
          [&] { return TwoPasses<DirectForm<double, kOrder>>(whole, doubles); });
  Measure("zero phase in direct form in float", setting, two_passes,
          [&] { return TwoPasses<DirectForm<float, kOrder>>(whole, floats); });
  Measure("FFT", setting, two_passes, [&] { return FilterByFft(whole, in); });
}

void Firs(const std::vector<double>& in) {
  for (const double transition_hz : {20.0, 10.0, 5.0}) {
    for (const double attenuation_db : {60.0, 80.0, 100.0, 140.0}) {
      const auto taps =
          DesignFirBandPass({20, 500, transition_hz, attenuation_db}, kRateHz).value();
      Measure("FIR " + std::to_string(static_cast<int>(transition_hz)) + " Hz",
              std::to_string(static_cast<int>(attenuation_db)) + " dB", ExactConvolution(taps, in),
              [&] { return FilterByOverlapSave(taps, in); });
    }
  }
}

template <typename Number>
using MeanSquare = Number (*)(std::span<const Number>);

// of the RMS, as it would be with the mean square's error alone
template <typename Number>
void Sum(const std::string& method, const std::vector<Number>& all, std::size_t count,
         Quad exact_mean_square, MeanSquare<Number> mean_square) {
  const std::span<const Number> values = std::span(all).first(count);
  Number found = 0;
  const double nanoseconds = NanosecondsPerSample(count, [&] { found = mean_square(values); });
  const Quad off = static_cast<Quad>(found) / exact_mean_square - 1;
  Print(method, std::to_string(count), nanoseconds, "", std::abs(static_cast<double>(off)) / 2);
}

// 1 um at 97.3 Hz and noise, as a filter leaves them
std::vector<double> Band() {
  std::vector<double> values = Samples(kRateHz, kSums, 0, {{1e-6, 97.3}});
  Noise noise(1);
  for (double& value : values) value += 1e-7 * noise();
  return values;
}

void Sums() {
  const std::vector<double> doubles = Band();
  const std::vector<float> floats(doubles.begin(), doubles.end());
  for (std::size_t count = 10'000; count <= kSums; count *= 10) {
    Quad exact = 0;
    for (const double value : std::span(doubles).first(count)) {
      exact += static_cast<Quad>(value) * static_cast<Quad>(value);
    }
    exact /= static_cast<Quad>(count);
    Sum<float>("naive sum in float", floats, count, exact, NaiveMeanSquare);
    Sum<float>("pairwise sum in float", floats, count, exact, PairwiseMeanSquare);
    Sum<float>("compensated sum in float", floats, count, exact, CompensatedMeanSquare);
    Sum<double>("naive sum", doubles, count, exact, NaiveMeanSquare);
    Sum<double>("pairwise sum", doubles, count, exact, PairwiseMeanSquare);
    Sum<double>("compensated sum", doubles, count, exact, CompensatedMeanSquare);
  }
}

void Ladder() {
  const std::vector<double> in =
      HandHeld(kRateHz, static_cast<double>(kMiddle + 2 * kEdge) / kRateHz);
  const std::vector<float> in_float(in.begin(), in.end());
  [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) {
    (Filters<kIndex + 1>(in, in_float), ...);
  }(std::make_integer_sequence<int, kHighestOrder>());
  Firs(in);
  Sums();
}

}  // namespace
}  // namespace haptometer::dsp

int main() {
  std::cout.precision(4);
  haptometer::dsp::Ladder();
}
