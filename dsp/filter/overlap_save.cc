#include "dsp/filter/overlap_save.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>

#include "base/error.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/fft.h"

namespace haptometer::dsp {
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
