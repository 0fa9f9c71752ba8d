#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "sim/linear/driven_step.h"
#include "sim/ring_down.h"
#include "sim/scene/effects.h"
#include "tests/hard_cases/hard_case.h"

namespace haptometer::hard_cases {
namespace {

// Bars: DampedFundamentals states 4e-16 + 2e-16 |r t|.

TEST(HardCasesSim, CriticalDamping) {
  const double s = 1000;
  const double t = 1e-3;
  const double r = std::sqrt(s * s - s * s);
  Check({"sim", "critical damping", "r = 0: sinh(r t)/r is 0/0", "e^(-s t) sinh(r t)/r", 4e-16},
        {std::exp(-1.0L) * static_cast<long double>(t), sim::DampedFundamentals(s, s * s, t).odd,
         std::exp(-s * t) * std::sinh(r * t) / r});
}

TEST(HardCasesSim, StrongDampingForALongTime) {
  const double s = 1e6;
  const double q = 1e6;
  const double t = 1;
  const double r = std::sqrt(s * s - q);
  // slow root q/(s + r), the fast one is e^-2e6
  const long double root = std::sqrt(1e12L - 1e6L);
  Check({"sim", "damping 1000 times critical, after 1 s", "cosh overflows, e^(-s t) underflows",
         "e^(-s t) cosh(r t)", 4e-16},
        {0.5L * std::exp(-1e6L / (1e6L + root)), sim::DampedFundamentals(s, q, t).even,
         std::exp(-s * t) * std::cosh(r * t)});
}

TEST(HardCasesSim, SlowRootOfStrongDamping) {
  const double s = 1e8;
  const double q = 1e4;
  const double t = 1e4;
  const long double root = std::sqrt(1e16L - 1e4L);
  const double r = std::sqrt(s * s - q);
  Check({"sim", "slow root, damping 1e6 times critical", "s - r cancels",
         "quadratic formula, e^(-(s - r) t)/2", 4e-16},
        {0.5L * std::exp(-1e8L / (1e8L + root)), sim::DampedFundamentals(s, q, t).even,
         0.5 * std::exp(-(s - r) * t)});
}

TEST(HardCasesSim, UndampedOscillationByForwardEuler) {
  const double w = 1024;
  const int steps = 1000;
  const double t = 1.0 / 1024;
  double x = 1;
  double v = 0;
  for (int i = 0; i < steps; ++i) {
    const double before = x;
    x += v * t / steps;
    v -= w * w * before * t / steps;
  }
  Check({"sim", "undamped oscillation, one radian", "a step method adds energy",
         "forward Euler, 1000 steps", 6e-16},
        {std::cos(1.0L), sim::DampedFundamentals(0.0, w * w, t).even, x});
}

TEST(HardCasesSim, StiffeningForceOfATinyTravelBesideASag) {
  const sim::StiffeningSpring spring{.cubic_n_per_m3 = 3e9, .sag_m = 3e-4};
  const double d = 1e-12;
  const long double k3 = 3e9L, s = static_cast<long double>(spring.sag_m),
                    x = static_cast<long double>(d);
  Check({"sim", "stiffening force, 1 pm beside 0.3 mm at rest", "(d + s)^3 - s^3 cancels",
         "K3 ((d + s)^3 - s^3)", 1e-15},
        {k3 * x * (x * x + 3 * s * (x + s)), spring.Force(d),
         3e9 * (std::pow(d + spring.sag_m, 3) - std::pow(spring.sag_m, 3))});
}

TEST(HardCasesSim, StiffeningEnergyOfATinyTravelBesideASag) {
  const sim::StiffeningSpring spring{.cubic_n_per_m3 = 3e9, .sag_m = 3e-4};
  const double d = 1e-10;
  const double s = spring.sag_m;
  const long double k3 = 3e9L, sl = static_cast<long double>(s), x = static_cast<long double>(d);
  Check({"sim", "stiffening energy, 0.1 nm beside 0.3 mm at rest", "fourth powers cancel",
         "K3/4 ((d + s)^4 - s^4) - K3 s^3 d", 1e-15},
        {k3 * x * x * ((x + 2 * sl) * (x + 2 * sl) / 4 + sl * sl / 2), spring.Energy(d),
         3e9 / 4 * (std::pow(d + s, 4) - std::pow(s, 4)) - 3e9 * s * s * s * d});
}

// Cardano's formula of s^3 + p s = q
double Cardano(double p, double q) {
  const double root = std::sqrt(q * q / 4 + p * p * p / 27);
  return std::cbrt(q / 2 + root) + std::cbrt(q / 2 - root);
}

// s of Kv s + K3 s^3 = F by Newton's method in long double, which converges from above
long double SagByNewton(long double force, long double kv, long double k3, long double start) {
  long double s = start;
  for (int k = 0; k < 200; ++k) s -= (kv * s + k3 * s * s * s - force) / (kv + 3 * k3 * s * s);
  return s;
}

TEST(HardCasesSim, SagOfAnAlmostLinearSpring) {
  Check({"sim", "static deflection under 13.7 mN with a cubic of 1e-3 N/m^3",
         "two cube roots cancel", "Cardano's formula", 1e-15},
        {SagByNewton(0.0137L, 2800, 1e-3L, 0.0137L / 2800), sim::SagUnder(0.0137, 2800, 1e-3),
         Cardano(2800 / 1e-3, 0.0137 / 1e-3)});
}

TEST(HardCasesSim, SagOfASpringWithoutALinearPart) {
  Check({"sim", "static deflection of a purely cubic spring", "the linear stiffness is 0", "F / Kv",
         4e-16},
        {1e-3L, sim::SagUnder(1, 0, 1e9), 1 / 0.0});
}

// exp(A) by its Taylor series of 60 terms
Eigen::MatrixXd Taylor(const Eigen::MatrixXd& a) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Identity(a.rows(), a.cols());
  Eigen::MatrixXd term = sum;
  for (int k = 1; k < 60; ++k) {
    term = (term * a / k).eval();
    sum += term;
  }
  return sum;
}

// the bar is eps |A|: what squaring leaves
TEST(HardCasesSim, ExponentialOfAStiffMatrix) {
  Eigen::MatrixXd a(2, 2);
  a << -1e6, 1e6, 0, -1;
  Check({"sim", "exp(A), rates of 1e6 and 1", "terms of 1e6^k cancel", "Taylor series of 60 terms",
         2.3e-10},
        {std::exp(-1.0L) * 1e6L / (1e6L - 1), sim::MatrixExponential(a)(0, 1), Taylor(a)(0, 1)});
}

TEST(HardCasesSim, ExponentialOfManyTurns) {
  Eigen::MatrixXd a(2, 2);
  a << 0, 100, -100, 0;
  Check({"sim", "exp(A), a turn of 100 radians", "terms of 100^k cancel",
         "Taylor series of 60 terms", 1e-13},
        {std::cos(100.0L), sim::MatrixExponential(a)(0, 0), Taylor(a)(0, 0)});
}

}  // namespace
}  // namespace haptometer::hard_cases
