#include "fit/uncertain_pole.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace haptometer::fit {

std::vector<PolePlace> EllipseOf(const UncertainPole& pole, std::size_t points) {
  HAPTOMETER_CHECK(pole.determined && points >= 3, "{} points of a pole", points);
  const double radius = std::sqrt(-2 * std::log(0.05));
  // Cholesky's factor of the covariance; rounding may leave it a hair indefinite
  const auto& [along, across] = pole.covariance;
  const double first = std::sqrt(along[0]);
  const double mixed = first > 0 ? across[0] / first : 0;
  const double second = std::sqrt(std::max(across[1] - mixed * mixed, 0.0));
  std::vector<PolePlace> ellipse;
  ellipse.reserve(points + 1);
  for (std::size_t k = 0; k <= points; ++k) {
    const double turn = static_cast<double>(k % points) / static_cast<double>(points);
    const double x = radius * std::cos(2 * std::numbers::pi * turn);
    const double y = radius * std::sin(2 * std::numbers::pi * turn);
    ellipse.push_back({pole.frequency_hz + first * x, pole.decay_per_s + mixed * x + second * y});
  }
  return ellipse;
}

}  // namespace haptometer::fit
