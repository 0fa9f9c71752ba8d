#include "dsp/spectrum/slow_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/error.h"
#include "dsp/spectrum/welch.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kBatches = 8;
constexpr std::size_t kLeastSamples = 2 * kBatches;
// three periods of the lowest frequency of tremor
constexpr double kLeastDuration_s = 1;
constexpr double kSegment_s = 4;
constexpr std::size_t kUnit = 16;
constexpr double kRatePerTremor = 4;

struct Line {
  double slope = 0;  // per sample
  double uncertainty = 0;
};

// least-squares line through the means of kBatches equal parts
Line LineThroughBatches(std::span<const double> signal) {
  const std::size_t size = signal.size() / kBatches;
  constexpr double kMiddle = 0.5 * (kBatches - 1);
  // sum of (b - middle)^2 over the batches
  constexpr double kSquares = kBatches * (kBatches * kBatches - 1) / 12.0;
  std::array<double, kBatches> means{};
  for (std::size_t b = 0; b < kBatches; ++b) means[b] = Mean(signal.subspan(b * size, size));
  const double mean = Mean(means);
  double products = 0;
  for (std::size_t b = 0; b < kBatches; ++b) {
    products += (static_cast<double>(b) - kMiddle) * (means[b] - mean);
  }
  const double per_batch = products / kSquares;
  // residual of the means with kBatches - 2 degrees of freedom
  double squares = 0;
  for (std::size_t b = 0; b < kBatches; ++b) {
    const double rest = means[b] - mean - per_batch * (static_cast<double>(b) - kMiddle);
    squares += rest * rest;
  }
  const auto samples = static_cast<double>(size);
  return {per_batch / samples, std::sqrt(squares / (kBatches - 2) / kSquares) / samples};
}

// signal less its mean and the line, so that drift does not leak into the tremor's bins
std::vector<double> WithoutLine(std::span<const double> signal, double slope) {
  const double mean = Mean(signal);
  const double middle = 0.5 * static_cast<double>(signal.size() - 1);
  std::vector<double> rest(signal.size());
  for (std::size_t k = 0; k < rest.size(); ++k) {
    rest[k] = signal[k] - mean - slope * (static_cast<double>(k) - middle);
  }
  return rest;
}

// RMS, its uncertainty and the centre of the power between 3 and 13 Hz
void DescribeBand(const PowerSpectrum& spectrum, double duration_s, SlowMotion& motion) {
  const double rms = RmsWithin(spectrum, kTremorLower_hz, kTremorUpper_hz);
  // power, squared power and first moment in frequency over the bins of the tremor
  double sum = 0;
  double square_sum = 0;
  double moment = 0;
  for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
    const double frequency_hz = static_cast<double>(k) * spectrum.grid.resolution_hz;
    if (frequency_hz < kTremorLower_hz || frequency_hz > kTremorUpper_hz) continue;
    sum += spectrum.density[k];
    square_sum += spectrum.density[k] * spectrum.density[k];
    moment += spectrum.density[k] * frequency_hz;
  }
  motion.tremor_rms = rms;
  if (!(sum > 0)) return;
  motion.tremor_frequency_hz = moment / sum;
  // a random signal with this width has 2 width duration degrees of freedom: (sum S)^2 / sum S^2
  const double width_hz = sum * sum / square_sum * spectrum.grid.resolution_hz;
  // u(rms) / rms = 1 / sqrt(2 degrees of freedom)
  motion.tremor_rms_uncertainty = rms / std::sqrt(4 * width_hz * duration_s);
}

}  // namespace

std::optional<SlowMotion> DescribeSlowMotion(std::span<const double> signal, double rate_hz) {
  HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz);
  const bool finite = std::ranges::all_of(signal, [](double x) { return std::isfinite(x); });
  if (signal.size() < kLeastSamples || !finite) return std::nullopt;
  const Line line = LineThroughBatches(signal);
  SlowMotion motion;
  motion.drift_per_s = line.slope * rate_hz;
  motion.drift_uncertainty_per_s = line.uncertainty * rate_hz;

  const double duration_s = static_cast<double>(signal.size()) / rate_hz;
  // tremor is not determined from a short or slow record; the drift is
  if (duration_s < kLeastDuration_s || rate_hz < kRatePerTremor * kTremorUpper_hz) return motion;
  const std::vector<double> rest = WithoutLine(signal, line.slope);
  // a multiple of 16: sizes of small primes transform several times as fast
  const auto longest = kUnit * static_cast<std::size_t>(std::round(kSegment_s * rate_hz / kUnit));
  const auto spectrum = WelchSpectrum(rest, {rate_hz, std::min(rest.size(), longest)});
  if (!spectrum) return motion;
  DescribeBand(*spectrum, duration_s, motion);
  return motion;
}

}  // namespace haptometer::dsp
