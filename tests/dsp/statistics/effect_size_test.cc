#include "dsp/statistics/effect_size.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(HedgesCorrection, IsExact) {
  // Gamma(7/2) = 15 sqrt(pi) / 8, Gamma(3) = 2
  EXPECT_REL(HedgesCorrection(7), 15 * std::sqrt(std::numbers::pi) / 16 / std::sqrt(3.5), 1e-15,
             "closed form: 0.888203");
  EXPECT_REL(HedgesCorrection(400), 1 - 3.0 / (4 * 400 - 1), 1e-6, "Hedges' approximation");
}

}  // namespace
}  // namespace haptometer::dsp
