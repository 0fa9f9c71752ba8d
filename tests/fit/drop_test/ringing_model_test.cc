#include "fit/drop_test/ringing_model.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim/ring_down.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using Jet = ceres::Jet<double, 3>;

struct Circuit {
  double decay_per_s = 0;
  double stiffness_per_s2 = 0;
};

constexpr double kStepS = 1e-4;

// light, near critical on either side, critical, heavy
const std::vector<Circuit> kCircuits{
    {11.5, 2e6}, {1414, 2e6}, {1415, 2e6}, {1000, 1e6}, {4000, 2e6}};

TEST(RingingMoments, AreTheFundamentalSolutions) {
  for (const Circuit& circuit : kCircuits) {
    SCOPED_TRACE(circuit.decay_per_s);
    RingingMoments moments(circuit.decay_per_s, circuit.stiffness_per_s2, 2e4, kStepS);
    for (int n = -30; n < 1000; ++n) {
      if (n % 97 == 13) continue;             // a hole
      if (n > 500 && n < 700) continue;       // a long one
      const double off = n > 800 ? 3e-5 : 0;  // another grid
      const double t = n * kStepS + 1.7e-5 + off;
      const auto moment = moments.At(t);
      const auto pair = sim::DampedFundamentals(circuit.decay_per_s, circuit.stiffness_per_s2, t);
      const double envelope =
          std::abs(pair.even) + std::sqrt(circuit.stiffness_per_s2) * std::abs(pair.odd);
      EXPECT_ABS(moment.even / envelope, pair.even / envelope, 3e-13, "140 rad of phase, rounded");
      EXPECT_ABS(moment.odd * std::sqrt(circuit.stiffness_per_s2) / envelope,
                 pair.odd * std::sqrt(circuit.stiffness_per_s2) / envelope, 3e-13,
                 "140 rad of phase, rounded");
      EXPECT_EQ(moment.electrical, t >= 0 && 2e4 * t < 700 ? std::exp(-2e4 * t) : 0);
    }
  }
}

TEST(RingingMoments, SlopesAreThoseOfAutomaticDerivatives) {
  for (const Circuit& circuit : kCircuits) {
    SCOPED_TRACE(circuit.decay_per_s);
    RingingMoments moments(circuit.decay_per_s, circuit.stiffness_per_s2, 0, 0);
    for (const double t : {-3e-4, 1e-7, 1e-5, 4e-4, 0.99e-3, 1.3e-3, 0.02}) {
      const auto slopes = moments.SlopesAt(moments.At(t));
      const auto pair = sim::DampedFundamentals(Jet(circuit.decay_per_s, 0),
                                                Jet(circuit.stiffness_per_s2, 1), Jet(t, 2));
      const auto expect = [](double found, double expected, double scale) {
        EXPECT_ABS(found / scale, expected / scale, 1e-13, "terms that cancel, rounded");
      };
      const double t2 = t * t;
      const double grown = std::exp(std::abs(circuit.decay_per_s * t));
      expect(slopes.even_by_decay, pair.even.v[0], std::abs(t) * grown);
      expect(slopes.even_by_stiffness, pair.even.v[1], t2 * grown);
      expect(slopes.even_by_time, pair.even.v[2],
             (circuit.decay_per_s + std::sqrt(circuit.stiffness_per_s2)) * grown);
      expect(slopes.odd_by_decay, pair.odd.v[0], t2 * grown);
      expect(slopes.odd_by_stiffness, pair.odd.v[1], std::abs(t) * t2 * grown);
      expect(slopes.odd_by_time, pair.odd.v[2], grown);
    }
  }
}

}  // namespace
}  // namespace haptometer::fit
