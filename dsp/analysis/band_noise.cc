#include "dsp/analysis/band_noise.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "base/error.h"
#include "dsp/spectrum/fft.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// 24 bins on either side, the one next to the line excluded: 48 bins, 96 degrees of freedom
constexpr std::size_t kBinsOnASide = 24;
constexpr std::size_t kLeftOut = 1;

}  // namespace

double NoisePower::degrees_of_freedom() const {
  if (!(variance > 0)) return std::numeric_limits<double>::infinity();
  return 2 * mean_square * mean_square / variance;
}

double BandNoise::DensityNear(double frequency_hz, double lower_hz, double upper_hz) const {
  const auto center = static_cast<std::ptrdiff_t>(std::lround(frequency_hz / bin_hz));
  const auto least = static_cast<std::ptrdiff_t>(std::ceil(lower_hz / bin_hz));
  // within the band only
  const auto most = std::min(static_cast<std::ptrdiff_t>(std::floor(upper_hz / bin_hz)),
                             static_cast<std::ptrdiff_t>(bins.size()) - 1);
  double sum = 0;
  std::size_t count = 0;
  for (std::ptrdiff_t away = kLeftOut + 1;
       away <= static_cast<std::ptrdiff_t>(kBinsOnASide + kLeftOut); ++away) {
    for (const std::ptrdiff_t bin : {center - away, center + away}) {
      if (bin < least || bin > most) continue;
      sum += bins[static_cast<std::size_t>(bin)];
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) / bin_hz : 0;
}

// p[k] = 2 |X[k]|^2 / n^2 and variance = sum of p[k]^2 / 2 (Bendat and Piersol, section 8.2)
BandNoise MeasureNoise(std::span<const double> samples, double rate_hz, double upper_hz) {
  HAPTOMETER_CHECK(samples.size() >= 2 && rate_hz > 0, "{} samples at {} Hz", samples.size(),
                   rate_hz);
  const auto n = static_cast<double>(samples.size());
  BandNoise noise;
  noise.bin_hz = rate_hz / n;
  const double rms = Rms(samples);
  noise.power.mean_square = rms * rms;
  const auto spectrum = RealSpectrum(samples);
  const auto wanted = static_cast<std::size_t>(std::min(upper_hz / noise.bin_hz + 1, n / 2));
  noise.bins.resize(std::min(spectrum.size(), wanted + 1));
  for (std::size_t k = 1; k < noise.bins.size(); ++k) {
    noise.bins[k] = 2 * std::norm(spectrum[k]) / (n * n);
    noise.power.variance += 0.5 * noise.bins[k] * noise.bins[k];
  }
  return noise;
}

// weights are durations: mean = sum T m / sum T, variance = sum T^2 v / (sum T)^2
NoisePower Pooled(std::span<const WeightedPower> windows) {
  NoisePower pooled;
  double duration_s = 0;
  for (const WeightedPower& window : windows) {
    pooled.mean_square += window.duration_s * window.power.mean_square;
    pooled.variance += window.duration_s * window.duration_s * window.power.variance;
    duration_s += window.duration_s;
  }
  if (duration_s > 0) {
    pooled.mean_square /= duration_s;
    pooled.variance /= duration_s * duration_s;
  }
  return pooled;
}

}  // namespace haptometer::dsp
