#include "dsp/spectrum/window.h"

#include <array>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

using Cosines = std::array<double, 5>;  // of w[n] = sum over k of c_k cos(2 pi k n / size)

Cosines CosinesOf(WindowShape shape) {
  switch (shape) {
    case WindowShape::kRectangular:
      return {1, 0, 0, 0, 0};
    case WindowShape::kHann:
      return {0.5, -0.5, 0, 0, 0};
    case WindowShape::kHamming:
      return {0.54, -0.46, 0, 0, 0};
    case WindowShape::kBlackmanHarris:
      return {0.35875, -0.48829, 0.14128, -0.01168, 0};
    case WindowShape::kFlatTop:
      return {1, -1.942604, 1.340318, -0.440811, 0.043097};
  }
  HAPTOMETER_CHECK(false, "shape = {}", static_cast<int>(shape));
  return {};
}

}  // namespace

std::vector<double> WindowValues(WindowShape shape, std::size_t size) {
  HAPTOMETER_CHECK(size >= 1, "size = {}", size);
  const Cosines c = CosinesOf(shape);
  std::vector<double> values(size);
  for (std::size_t n = 0; n < size; ++n) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(n) / static_cast<double>(size);
    double sum = 0;
    for (std::size_t k = c.size(); k-- > 0;) sum += c[k] * std::cos(static_cast<double>(k) * angle);
    values[n] = sum;
  }
  return values;
}

double NoiseBandwidthBins(const std::vector<double>& window) {
  const double rms = Rms(window);
  const double mean = Mean(window);
  return rms * rms / (mean * mean);
}

}  // namespace haptometer::dsp
