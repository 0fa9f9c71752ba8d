#include "dsp/analysis/window/measured_window.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/analysis/hum.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// `rows` samples from `begin` on that are not excluded
SampleRanges KeptOf(std::size_t begin, std::size_t rows, const SampleRanges& excluded) {
  SampleRanges kept;
  const std::size_t end = begin + rows;
  for (const auto& [from, to] : excluded) {
    if (std::min(from, end) > begin) kept.emplace_back(begin, std::min(from, end));
    begin = std::max(begin, to);
  }
  if (end > begin) kept.emplace_back(begin, end);
  return kept;
}

}  // namespace

std::size_t WholePeriods(const MeasuredWindow& window, const std::optional<SineFit>& tone) {
  const std::size_t rows = window.chosen.end - window.chosen.begin;
  if (!tone) return rows;
  const double seconds = static_cast<double>(rows) / window.rate_hz();
  const double periods = std::floor(seconds * tone->frequency_hz);
  if (periods < 1) return rows;
  const double whole = std::round(periods / tone->frequency_hz * window.rate_hz());
  return std::min(rows, static_cast<std::size_t>(whole));
}

void DescribePart(MeasuredWindow& window) {
  UsedPart& part = window.numbers.part;
  part = window.chosen.part;
  part.first_row = window.signal().first_row() + window.chosen.begin;
  part.rows = window.rows;
  const double begin_s = TimeOfSample(window.signal(), window.chosen.begin);
  part.window = {begin_s, begin_s + window.duration_s()};
  for (const auto& [from, to] : window.chosen.excluded) {
    if (from >= window.chosen.begin + window.rows) continue;
    const std::size_t last = std::min(to, window.chosen.begin + window.rows);
    window.numbers.excluded.push_back(
        {TimeOfSample(window.signal(), from), TimeOfSample(window.signal(), last)});
  }
  window.numbers.hum = window.chosen.hum;
}

Result<double> MeanSquareKept(const MeasuredWindow& window, const SampleRanges& excluded,
                              std::size_t inset) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& [from, to] : KeptOf(window.chosen.begin, window.rows, excluded)) {
    if (to - from <= 2 * inset) continue;
    HAPTOMETER_LET(const double square_sum, window.signal().SquareSum(from + inset, to - inset));
    sum += square_sum;
    count += to - from - 2 * inset;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

Result<std::vector<double>> WithoutHum(const MeasuredWindow& window, std::size_t begin,
                                       std::size_t end, double* hum_square) {
  HAPTOMETER_LET(auto samples, ReadMiddle(window.signal(), begin, end));
  const std::size_t first = begin + (end - begin - samples.size()) / 2;
  const double with_hum = Rms(samples);
  SubtractLines(window.chosen.hum, window.rate_hz(), static_cast<double>(first), samples);
  if (!window.chosen.hum.empty()) *hum_square = std::pow(with_hum, 2) - std::pow(Rms(samples), 2);
  return samples;
}

Result<ThinnedSamples> SamplesOf(MeasuredWindow& window) {
  const ChosenPart& chosen = window.chosen;
  const auto kept = KeptOf(chosen.begin, chosen.end - chosen.begin, chosen.excluded);
  const auto [begin, end] =
      *std::ranges::max_element(kept, {}, [](const auto& one) { return one.second - one.first; });
  HAPTOMETER_LET(auto samples, WithoutHum(window, begin, end, &window.hum_square));
  return Thinned(std::move(samples), window.rate_hz(), window.signal().design(), window.band());
}

}  // namespace haptometer::dsp
