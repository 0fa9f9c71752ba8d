#include "sim/hermite.h"

#include <algorithm>
#include <cmath>

namespace haptometer::sim {

HermiteQuintic::HermiteQuintic(const MotionJet& begin, const MotionJet& end, double h_s) {
  const double v0 = begin.v * h_s, v1 = end.v * h_s;
  const double a0 = begin.a * h_s * h_s, a1 = end.a * h_s * h_s, d = end.x - begin.x;
  c_ = {begin.x,
        v0,
        a0 / 2,
        10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
        -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
        6 * d - 3 * (v0 + v1) + 0.5 * (a1 - a0)};
}

double HermiteQuintic::At(double u) const {
  return c_[0] + u * (c_[1] + u * (c_[2] + u * (c_[3] + u * (c_[4] + u * c_[5]))));
}

double HermiteQuintic::Slope(double u) const {
  return c_[1] + u * (2 * c_[2] + u * (3 * c_[3] + u * (4 * c_[4] + u * 5 * c_[5])));
}

double HermiteQuintic::Peak() const {
  constexpr int kHalvings = 40;  // the peak is flat: 2^-26 would do
  const double ends = std::max(std::abs(At(0)), std::abs(At(1)));
  const bool rises = Slope(0) > 0;
  if ((Slope(1) > 0) == rises) return ends;
  double low = 0, high = 1;
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = 0.5 * (low + high);
    ((Slope(middle) > 0) == rises ? low : high) = middle;
  }
  return std::max(ends, std::abs(At(low)));
}

}  // namespace haptometer::sim
