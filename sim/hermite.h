#pragma once

#include <array>

namespace haptometer::sim {

/// A position with its first two derivatives by time.
struct MotionJet {
  double x = 0;
  double v = 0;
  double a = 0;
};

/// The quintic through two jets h apart: its six conditions are met, its error is
/// h^6 max|x''''''| / 46080, for 64 points in a period 2e-11 of the amplitude.
class HermiteQuintic {
 public:
  HermiteQuintic(const MotionJet& begin, const MotionJet& end, double h_s);
  /// At begin + u h, 0 <= u <= 1.
  [[nodiscard]] double At(double u) const;
  /// Its largest absolute value where its rate has one zero at most.
  [[nodiscard]] double Peak() const;

 private:
  [[nodiscard]] double Slope(double u) const;
  std::array<double, 6> c_;  // of u^k
};

}  // namespace haptometer::sim
