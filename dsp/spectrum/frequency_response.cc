#include "dsp/spectrum/frequency_response.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "dsp/spectrum/envelope.h"

namespace haptometer::dsp {
namespace {

constexpr double kLeastDrive = 1e-10;  // of the greatest density

// A phase over a block: mean + slope tau + bend (tau^2 - mean_square), tau from -1 to 1 and
// mean_square the mean of its squares: three terms that are orthogonal over the samples.
struct BlockPhase {
  double mean = 0;
  double slope = 0;
  double bend = 0;
  double mean_square = 0;

  [[nodiscard]] double At(double tau) const {
    return mean + slope * tau + bend * (tau * tau - mean_square);
  }
};

// least squares, of the phase that goes on from sample to sample
BlockPhase FitPhase(std::span<const std::complex<double>> block, double half) {
  const auto size = static_cast<double>(block.size());
  BlockPhase fit;
  fit.mean_square = (size + 1) / (3 * (size - 1));
  double slope_square = 0;
  double bend_square = 0;
  double phase = std::arg(block[0]);
  for (std::size_t k = 0; k < block.size(); ++k) {
    if (k > 0) phase += std::arg(block[k] * std::conj(block[k - 1]));
    const double tau = static_cast<double>(k) / half - 1;
    const double square = tau * tau - fit.mean_square;
    fit.mean += phase;
    fit.slope += phase * tau;
    fit.bend += phase * square;
    slope_square += tau * tau;
    bend_square += square * square;
  }
  fit.mean /= size;
  fit.slope /= slope_square;
  // two samples have no bend
  fit.bend = block.size() > 2 ? fit.bend / bend_square : 0;
  return fit;
}

// Amplitude and mean frequency of a block of the analytic signal: what turns with its phase, so
// that noise beside it, whose phase does not, averages out.
SweptPoint PointOf(std::span<const std::complex<double>> block, double rate_hz) {
  const double half = 0.5 * static_cast<double>(block.size() - 1);
  const BlockPhase phase = FitPhase(block, half);
  std::complex<double> sum;
  for (std::size_t k = 0; k < block.size(); ++k) {
    sum += block[k] * std::polar(1.0, -phase.At(static_cast<double>(k) / half - 1));
  }
  SweptPoint point;
  point.amplitude = std::abs(sum) / static_cast<double>(block.size());
  point.frequency_hz = phase.slope / half * rate_hz / (2 * std::numbers::pi);
  return point;
}

}  // namespace

Result<std::vector<ResponsePoint>> MeasureResponse(std::span<const double> drive,
                                                   std::span<const double> displacement,
                                                   const WelchOptions& options, double lower_hz,
                                                   double upper_hz) {
  auto cross = WelchCrossSpectrum(drive, displacement, options);
  if (!cross) return std::unexpected(std::move(cross.error()));
  if (cross->grid.segments < 2) {
    return Usage("sweep", "holds one segment, which has no coherence",
                 "choose shorter segments, or record longer");
  }
  const std::vector<double> coherence = Coherence(*cross);
  const double least = kLeastDrive * std::ranges::max(cross->from_density);
  std::vector<ResponsePoint> points;
  points.reserve(cross->cross.size());
  for (std::size_t k = 0; k < cross->cross.size(); ++k) {
    const double frequency_hz = static_cast<double>(k) * cross->grid.resolution_hz;
    if (frequency_hz < lower_hz || frequency_hz > upper_hz) continue;
    if (!(cross->from_density[k] > least) || !(coherence[k] > 0)) continue;
    const double c = std::min(1.0, coherence[k]);
    points.push_back({frequency_hz, cross->cross[k] / cross->from_density[k], c,
                      std::sqrt((1 - c) / (c * cross->grid.degrees_of_freedom))});
  }
  return points;
}

std::vector<SweptPoint> SweptAmplitude(std::span<const double> displacement, double rate_hz,
                                       double lower_hz, double upper_hz, double periods) {
  HAPTOMETER_CHECK(rate_hz > 0 && lower_hz > 0 && periods > 0, "rate_hz = {}, lower_hz = {}",
                   rate_hz, lower_hz);
  const double samples = std::round(periods * rate_hz / lower_hz);
  if (!(samples >= 2 && 3 * samples <= static_cast<double>(displacement.size()))) return {};
  const auto size = static_cast<std::size_t>(samples);
  const std::vector<std::complex<double>> analytic = AnalyticSignal(displacement);
  std::vector<SweptPoint> points;
  points.reserve(analytic.size() / size);
  // the first and the last block hold what the transform's ends disturb
  for (std::size_t begin = size; begin + 2 * size <= analytic.size(); begin += size) {
    SweptPoint point = PointOf(std::span(analytic).subspan(begin, size), rate_hz);
    point.time_s = (static_cast<double>(begin) + 0.5 * (samples - 1)) / rate_hz;
    if (point.frequency_hz >= lower_hz && point.frequency_hz <= upper_hz) points.push_back(point);
  }
  return points;
}

}  // namespace haptometer::dsp
