#include "dsp/filter/fir.h"

#include <fmt/core.h>

#include <cmath>
#include <cstddef>
#include <numbers>

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

}  // namespace haptometer::dsp
