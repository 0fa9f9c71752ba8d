#include "fit/residual_density.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

constexpr double kStepS = 1e-4;
constexpr double kResonanceHz = 225;

// x[n] = share x[n-1] + white noise
std::vector<double> Noise(double share, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<double> noise(20'000);
  double last = 0;
  for (double& x : noise) x = last = share * last + normal(engine);
  return noise;
}

TEST(ResidualDensity, OfWhiteNoiseIsOne) {
  int coloured = 0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const auto density = DensityAt(Noise(0, seed), kStepS, kResonanceHz);
    EXPECT_ABS(density.ratio, 1.0, 4 / std::sqrt(450.0), "450 lines, four deviations");
    coloured += density.is_coloured ? 1 : 0;
  }
  EXPECT_LE(coloured, 3) << "1 % of white records";
}

TEST(ResidualDensity, OfFilteredNoiseIsThatOfTheFilter) {
  // at frequencies far below the corner (1-a^2)/(1-a)^2 = (1+a)/(1-a) of the white density
  const auto density = DensityAt(Noise(0.5, 1), kStepS, kResonanceHz);
  EXPECT_TRUE(density.is_coloured);
  EXPECT_REL(density.ratio, 3.0, 0.2, "450 lines, four deviations");
}

TEST(ResidualDensity, NeedsLinesAndABandBelowHalfTheRate) {
  const auto noise = Noise(0.5, 1);
  EXPECT_EQ(DensityAt(noise, kStepS, 4000).ratio, 1);
  EXPECT_EQ(DensityAt({noise.begin(), noise.begin() + 300}, kStepS, kResonanceHz).ratio, 1)
      << "6.75 lines in the band";
  EXPECT_EQ(DensityAt(std::vector<double>(1000, 0.0), kStepS, kResonanceHz).ratio, 1);
}

}  // namespace
}  // namespace haptometer::fit
