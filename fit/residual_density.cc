#include "fit/residual_density.h"

#include <cmath>
#include <complex>
#include <span>

#include "dsp/spectrum/fft.h"

namespace haptometer::fit {
namespace {

constexpr std::size_t kLeastLines = 8;
constexpr double kOneInAHundred = 2.33;  // deviations of a Gaussian

double MeanPower(std::span<const std::complex<double>> lines) {
  double sum = 0;
  for (const auto& line : lines) sum += std::norm(line);
  return sum / static_cast<double>(lines.size());
}

}  // namespace

ResidualDensity DensityAt(const std::vector<double>& residuals, double step_s,
                          double resonance_hz) {
  if (residuals.size() < 2 * kLeastLines) return {};
  const auto lines = dsp::RealSpectrum(residuals);
  const double lines_per_hz = static_cast<double>(residuals.size()) * step_s;
  const auto first = static_cast<std::size_t>(std::ceil(0.5 * resonance_hz * lines_per_hz));
  const auto end = static_cast<std::size_t>(1.5 * resonance_hz * lines_per_hz) + 1;
  if (first < 1 || end > lines.size() || end < first + kLeastLines) return {};
  const std::span all(lines);
  // the offset takes the line at 0
  const double whole = MeanPower(all.subspan(1));
  if (!(whole > 0)) return {};
  ResidualDensity density;
  density.ratio = MeanPower(all.subspan(first, end - first)) / whole;
  const double deviation = 1 / std::sqrt(static_cast<double>(end - first));
  density.is_coloured = density.ratio > 1 + kOneInAHundred * deviation;
  return density;
}

}  // namespace haptometer::fit
