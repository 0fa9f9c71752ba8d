#include "dsp/spectrum/changing_sine.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptometer::dsp {
namespace {

// x and y of  p x + q y = r,  q x + s y = t
std::array<double, 2> Solved(double p, double q, double s, double r, double t) {
  const double determinant = p * s - q * q;
  return {(s * r - q * t) / determinant, (p * t - q * r) / determinant};
}

}  // namespace

ChangingSine FitChangingSine(std::span<const double> samples, double step_rad) {
  const auto n = static_cast<double>(samples.size());
  const double middle = 0.5 * (n - 1);
  const double advance_cos = std::cos(step_rad);
  const double advance_sin = std::sin(step_rad);
  double cos = std::cos(step_rad * middle);
  double sin = -std::sin(step_rad * middle);
  // sums: of squares and products, then of what the samples share with each
  double square = 0;
  double cos2 = 0;
  double u2 = 0;
  double u2cos2 = 0;
  double cross = 0;
  std::array<double, 4> right{};
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double u = (static_cast<double>(k) - middle) / (0.5 * n);
    const double x = samples[k];
    square += x * x;
    cos2 += cos * cos;
    u2 += u * u;
    u2cos2 += u * u * cos * cos;
    cross += u * cos * sin;
    right[0] += x * cos;
    right[1] += x * u * sin;
    right[2] += x * sin;
    right[3] += x * u * cos;
    const double turned = cos * advance_cos - sin * advance_sin;
    sin = cos * advance_sin + sin * advance_cos;
    cos = turned;
  }
  const auto even = Solved(cos2, cross, u2 - u2cos2, right[0], right[1]);
  const auto odd = Solved(n - cos2, cross, u2cos2, right[2], right[3]);
  const double explained =
      even[0] * right[0] + even[1] * right[1] + odd[0] * right[2] + odd[1] * right[3];
  return {.amplitude = {even[0], -odd[0]},
          .slope = {odd[1], -even[1]},
          .square_sum = square,
          .residual_sum = std::max(0.0, square - explained)};
}

}  // namespace haptometer::dsp
