#include "dsp/spectrum/spectrogram.h"

#include <complex>
#include <utility>

#include "dsp/spectrum/segment_transform.h"

namespace haptometer::dsp {

Result<Spectrogram> MakeSpectrogram(std::span<const double> signal, const WelchOptions& options) {
  // the averaged spectrum refuses what cannot be asked
  const auto mean = WelchSpectrum(signal, options);
  if (!mean) return std::unexpected(mean.error());
  SegmentTransform transform(options);
  Spectrogram result;
  result.resolution_hz = mean->grid.resolution_hz;
  result.noise_bandwidth_hz = mean->grid.noise_bandwidth_hz;
  result.start_s = 0.5 * static_cast<double>(transform.size() - 1) / options.rate_hz;
  result.step_s = static_cast<double>(transform.step()) / options.rate_hz;
  result.density.reserve(mean->grid.segments);
  for (std::size_t m = 0; m < mean->grid.segments; ++m) {
    const std::span<const std::complex<double>> bins = transform.Of(signal, m);
    std::vector<double> density(bins.size());
    for (std::size_t k = 0; k < bins.size(); ++k) {
      density[k] = std::norm(bins[k]) * transform.DensityScale(k);
    }
    result.density.push_back(std::move(density));
  }
  return result;
}

}  // namespace haptometer::dsp
