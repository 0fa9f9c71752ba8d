#include "sim/scene/effects.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

TEST(StiffeningSpring, IsTheCubicAboutItsSag) {
  const StiffeningSpring spring{.cubic_n_per_m3 = 3e9, .sag_m = 5e-5};
  const double d = 3e-4, s = spring.sag_m;
  EXPECT_REL(spring.Force(d), 3e9 * (std::pow(d + s, 3) - std::pow(s, 3)), 1e-14, "the definition");
  EXPECT_REL(spring.Stiffness(d), 9e9 * (d + s) * (d + s), 1e-15, "its derivative");
  EXPECT_REL(spring.Stiffening(d), 18e9 * (d + s), 1e-15, "its second");
  EXPECT_REL(spring.Energy(d),
             3e9 * ((std::pow(d + s, 4) - std::pow(s, 4)) / 4 - std::pow(s, 3) * d), 1e-13,
             "the integral of the force");
}

TEST(StiffeningSpring, NearRestNoDigitsCancel) {
  const StiffeningSpring spring{.cubic_n_per_m3 = 3e9, .sag_m = 1e-3};
  for (const double d : {1e-12, -1e-12}) {
    EXPECT_REL(spring.Force(d), 9e9 * 1e-6 * d, 2e-9, "3 K3 s^2 d and d/s of it");
    EXPECT_REL(spring.Energy(d), 4.5e9 * 1e-6 * d * d, 2e-9, "half of that times d");
  }
}

TEST(StiffeningSpring, TheSagBalancesTheWeight) {
  const double weight_n = 1.4e-3 * 9.80665;
  for (const double Kv : {0.0, 1.0, 2800.0}) {
    for (const double K3 : {1e-6, 1e3, 3e9, 1e15}) {
      for (const double force_n : {weight_n, -weight_n, 1e-9}) {
        const double s = SagUnder(force_n, Kv, K3);
        EXPECT_REL(Kv * s + K3 * s * s * s, force_n, 1e-14, "the cubic itself");
      }
    }
  }
  EXPECT_EQ(SagUnder(weight_n, 2800, 0), weight_n / 2800);
}

}  // namespace
}  // namespace haptometer::sim
