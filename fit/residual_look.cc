#include "fit/residual_look.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace haptometer::fit {

ResidualLook LookAtResiduals(const std::vector<double>& residuals, std::size_t points) {
  ResidualLook look;
  std::vector<double> magnitudes;
  magnitudes.reserve(residuals.size());
  double product = 0;
  double square = 0;
  std::size_t farthest = 0;
  for (std::size_t n = 0; n < residuals.size(); ++n) {
    magnitudes.push_back(std::abs(residuals[n]));
    square += residuals[n] * residuals[n];
    if (magnitudes[n] > magnitudes[farthest]) farthest = n;
    const bool has_next = (n + 1) % points != 0;
    if (has_next) product += residuals[n] * residuals[n + 1];
  }
  if (!(square > 0)) return look;
  look.serial_correlation = product / square * std::sqrt(static_cast<double>(residuals.size()));
  look.farthest = farthest % points;
  const double largest = magnitudes[farthest];
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  constexpr double kGaussian = 1.4826;  // a standard deviation over the median magnitude
  look.farthest_spread = *middle > 0 ? largest / (kGaussian * *middle) : 0;
  return look;
}

std::vector<std::string> DoubtResiduals(const ResidualLook& look, double noise, double farthest_hz,
                                        const std::string& cause) {
  constexpr double kRounding = 1e-9;
  constexpr double kSurely = 3.5;
  constexpr double kFar = 8;
  std::vector<std::string> doubts;
  if (noise < kRounding) return doubts;
  if (look.serial_correlation > kSurely) {
    doubts.push_back(fmt::format(
        "the residuals follow each other: {}; the intervals are too narrow then", cause));
  }
  if (look.farthest_spread > kFar) {
    doubts.push_back(
        fmt::format("the point at {:.5g} Hz lies {:.0f} times the others' spread off the model: is "
                    "it a slip? all constants lean towards it",
                    farthest_hz, look.farthest_spread));
  }
  return doubts;
}

}  // namespace haptometer::fit
