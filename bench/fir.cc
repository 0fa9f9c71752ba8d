#include "bench/fir.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

#include "base/error.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/fft.h"

namespace haptometer::dsp {
namespace {

constexpr double kMostTaps = 0x1p26;

double Beta(double attenuation_db) {
  if (attenuation_db > 50) return 0.1102 * (attenuation_db - 8.7);
  return 0.5842 * std::pow(attenuation_db - 21, 0.4) + 0.07886 * (attenuation_db - 21);
}

Result<void> Check(const FirBandPass& band, double rate_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) {
    return Usage("sample rate", fmt::format("is {} Hz", rate_hz), "give a positive rate");
  }
  const double half = band.transition_hz / 2;
  if (!(band.transition_hz > 0) || !(band.lower_hz > half) || !(band.upper_hz > band.lower_hz) ||
      !(band.upper_hz + half < rate_hz / 2)) {
    return Usage("band",
                 fmt::format("{}-{} Hz with transitions of {} Hz does not fit between 0 and {} Hz",
                             band.lower_hz, band.upper_hz, band.transition_hz, rate_hz / 2),
                 "take narrower transitions or other corners");
  }
  if (!(band.attenuation_db >= 21) || !(band.attenuation_db <= 200)) {
    return Usage("attenuation", fmt::format("{} dB is not possible", band.attenuation_db),
                 "choose 21 to 200 dB");
  }
  return {};
}

}  // namespace

Result<std::vector<double>> DesignFirBandPass(const FirBandPass& band, double rate_hz) {
  if (auto checked = Check(band, rate_hz); !checked) return std::unexpected(checked.error());
  const double pi = std::numbers::pi;
  const double wanted =
      (band.attenuation_db - 7.95) / (2.285 * 2 * pi * band.transition_hz / rate_hz);
  if (wanted > kMostTaps) {
    return Usage("transition", fmt::format("{} Hz needs {:.3g} taps", band.transition_hz, wanted),
                 "take a wider one");
  }
  const double beta = Beta(band.attenuation_db);
  const auto reach = static_cast<std::size_t>(std::ceil(wanted / 2));
  std::vector<double> taps(2 * reach + 1);
  taps[reach] = 2 * (band.upper_hz - band.lower_hz) / rate_hz;
  for (std::size_t k = 1; k <= reach; ++k) {
    const auto n = static_cast<double>(k);
    const double share = n / static_cast<double>(reach);
    const double window =
        std::cyl_bessel_i(0.0, beta * std::sqrt(1 - share * share)) / std::cyl_bessel_i(0.0, beta);
    // sin a - sin b = 2 cos((a + b)/2) sin((a - b)/2)
    const double sinc = 2 * std::cos(pi * (band.upper_hz + band.lower_hz) / rate_hz * n) *
                        std::sin(pi * (band.upper_hz - band.lower_hz) / rate_hz * n) / (pi * n);
    taps[reach - k] = taps[reach + k] = sinc * window;
  }
  return taps;
}

namespace {

// signal[first ..], 0 beyond its ends
void Copy(std::span<const double> signal, std::ptrdiff_t first, std::span<double> out) {
  const std::ptrdiff_t size = std::ssize(signal);
  for (std::ptrdiff_t k = 0; k < std::ssize(out); ++k) {
    const std::ptrdiff_t at = first + k;
    out[static_cast<std::size_t>(k)] =
        at >= 0 && at < size ? signal[static_cast<std::size_t>(at)] : 0;
  }
}

}  // namespace

std::vector<double> FilterByOverlapSave(std::span<const double> taps,
                                        std::span<const double> signal) {
  HAPTOMETER_CHECK(taps.size() % 2 == 1, "{} taps", taps.size());
  RealFft fft(std::bit_ceil(4 * taps.size()));
  std::vector<double> samples(fft.size());
  std::vector<std::complex<double>> response(fft.bins());
  Copy(taps, 0, samples);
  fft.Forward(samples, response);
  std::vector<std::complex<double>> bins(fft.bins());

  // of each block the first taps.size() - 1 outputs are wrapped round
  const std::size_t wrapped = taps.size() - 1;
  const std::size_t useful = fft.size() - wrapped;
  const auto before = static_cast<std::ptrdiff_t>(wrapped / 2);
  std::vector<double> out(signal.size());
  for (std::size_t begin = 0; begin < signal.size(); begin += useful) {
    Copy(signal, static_cast<std::ptrdiff_t>(begin) - before, samples);
    fft.Forward(samples, bins);
    for (std::size_t k = 0; k < response.size(); ++k) bins[k] *= response[k];
    fft.Inverse(bins, samples);
    const std::size_t count = std::min(useful, signal.size() - begin);
    std::copy_n(&samples[wrapped], count, &out[begin]);
  }
  return out;
}

std::vector<double> FilterByFft(const FilterDesign& design, std::span<const double> signal) {
  if (signal.empty()) return {};
  const std::size_t padding = RingingSamples(design, 1e-12);
  RealFft fft(std::bit_ceil(signal.size() + 2 * padding));
  const std::size_t reach = std::min(padding, signal.size() - 1);
  std::vector<double> samples(fft.size());
  // continued oddly after the end, and before the begin, which a circle has at its other end
  std::ranges::fill(samples, 2 * signal.back() - signal[signal.size() - 1 - reach]);
  std::ranges::copy(signal, samples.begin());
  std::fill_n(samples.rbegin(), padding, 2 * signal.front() - signal[reach]);
  for (std::size_t k = 1; k <= reach; ++k) {
    samples[signal.size() - 1 + k] = 2 * signal.back() - signal[signal.size() - 1 - k];
    samples[samples.size() - k] = 2 * signal.front() - signal[k];
  }
  std::vector<std::complex<double>> bins(fft.bins());
  fft.Forward(samples, bins);
  const double step_hz = design.rate_hz / static_cast<double>(samples.size());
  for (std::size_t k = 0; k < bins.size(); ++k) {
    bins[k] *= std::norm(Response(design, static_cast<double>(k) * step_hz));
  }
  fft.Inverse(bins, samples);
  return {samples.begin(), samples.begin() + std::ssize(signal)};
}

}  // namespace haptometer::dsp
