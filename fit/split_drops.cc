#include "fit/split_drops.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "dsp/statistics/repeated_measures.h"
#include "fit/poles.h"
#include "fit/ring_amplitude.h"

namespace haptometer::fit {
namespace {

constexpr double kRisen = 0.3;  // of the largest amplitude
constexpr double kFallen = 0.1;
constexpr double kLeastPeriods = 6;
constexpr std::size_t kLeastSamples = 64;

// the period of the strongest oscillation, in samples
std::optional<double> PeriodOf(const std::vector<double>& values, double middle_v, double step_s) {
  std::vector<double> about_middle = values;
  for (double& value : about_middle) value -= middle_v;
  const auto frequency_hz = StrongestFrequency(about_middle, step_s);
  if (!frequency_hz) return std::nullopt;
  return 1 / (*frequency_hz * step_s);
}

// where each drop's piece begins: half way from where the ringing had gone to the rise
std::vector<std::size_t> Begins(const std::vector<double>& amplitudes, std::size_t period) {
  const double largest = *std::ranges::max_element(amplitudes);
  std::vector<std::size_t> begins{0};
  bool rings = false;
  std::size_t fallen = 0;  // samples that the amplitude has been small for
  for (std::size_t n = 0; n < amplitudes.size(); ++n) {
    fallen = amplitudes[n] < kFallen * largest ? fallen + 1 : 0;
    if (rings && fallen > period) {
      rings = false;
      begins.push_back(n);
    } else if (!rings && amplitudes[n] > kRisen * largest) {
      if (begins.size() > 1) begins.back() = (begins.back() + n) / 2;
      rings = true;
    }
  }
  // the last ringing is followed by none
  if (!rings && begins.size() > 1) begins.pop_back();
  return begins;
}

ImpulseRecord Piece(const ImpulseRecord& record, std::size_t begin, std::size_t end,
                    std::size_t number) {
  ImpulseRecord piece = record;
  const auto first = record.voltage_v.begin();
  piece.voltage_v.assign(first + static_cast<std::ptrdiff_t>(begin),
                         first + static_cast<std::ptrdiff_t>(end));
  piece.start_s = record.start_s + static_cast<double>(begin) * record.step_s;
  piece.name = fmt::format("{}, drop {}", record.name, number);
  if (number > 1) piece.drop_height_m.reset();
  return piece;
}

}  // namespace

std::vector<ImpulseRecord> SplitDrops(const ImpulseRecord& record) {
  const auto measured =
      std::ranges::count_if(record.voltage_v, [](double v) { return std::isfinite(v); });
  if (static_cast<std::size_t>(measured) < kLeastSamples) return {record};
  const std::vector<double> values = Filled(record.voltage_v);
  const double middle_v = dsp::Median(values);
  const auto period = PeriodOf(values, middle_v, record.step_s);
  if (!period || kLeastPeriods * *period > static_cast<double>(values.size())) return {record};
  const auto amplitudes = FollowingAmplitude(values, middle_v, *period);
  std::vector<std::size_t> begins = Begins(amplitudes, static_cast<std::size_t>(*period));
  if (begins.size() < 2) return {record};
  begins.push_back(values.size());
  std::vector<ImpulseRecord> pieces;
  for (std::size_t k = 0; k + 1 < begins.size(); ++k) {
    if (static_cast<double>(begins[k + 1] - begins[k]) < kLeastPeriods * *period) return {record};
    pieces.push_back(Piece(record, begins[k], begins[k + 1], k + 1));
  }
  return pieces;
}

}  // namespace haptometer::fit
