#include "fit/poles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "sim/ring_down.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

std::vector<double> Decay(const PolePair& poles, double step_s, std::size_t count,
                          double noise = 0) {
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  std::vector<double> values(count);
  for (std::size_t n = 0; n < count; ++n) {
    const auto pair = sim::DampedFundamentals(poles.decay_per_s, poles.stiffness_per_s2,
                                              static_cast<double>(n) * step_s);
    values[n] = 0.4 * pair.even - 5.0 * pair.odd + noise * normal(engine);
  }
  return values;
}

TEST(StrongestFrequency, IsTheLineNearestToTheTone) {
  const PolePair poles{11.5, 2e6};
  const auto frequency_hz = StrongestFrequency(Decay(poles, 1e-4, 2500), 1e-4);
  ASSERT_TRUE(frequency_hz);
  EXPECT_ABS(*frequency_hz, 225.07, 0.5 * 1e4 / 8192, "half a line of the padded spectrum");
}

TEST(StrongestFrequency, NeedsSixteenSamplesThatDiffer) {
  EXPECT_FALSE(StrongestFrequency(std::vector<double>(15, 1.0), 1e-3));
  EXPECT_FALSE(StrongestFrequency(std::vector<double>(100, 0.0), 1e-3));
}

TEST(EstimatePoles, IsExactWithoutNoise) {
  // block means of a sum of exponentials are such a sum themselves, so nothing is lost by them
  for (const double step_s : {5e-4, 1e-4, 2e-6}) {
    const auto poles =
        EstimatePoles(Decay({11.5, 2e6}, step_s, static_cast<std::size_t>(0.25 / step_s)), step_s);
    ASSERT_TRUE(poles);
    EXPECT_REL(poles->decay_per_s, 11.5, 2e-13, "SVD of 240 samples, zeta 0.008");
    EXPECT_REL(poles->stiffness_per_s2, 2e6, 1e-14, "SVD of 240 samples");
  }
}

TEST(EstimatePoles, KeepsADoublePole) {
  const double w = 1414.0;
  for (const double zeta : {0.5, 0.99, 1.0, 1.01, 2.0}) {
    SCOPED_TRACE(zeta);
    const auto poles = EstimatePoles(Decay({zeta * w, w * w}, 5e-5, 400), 5e-5);
    ASSERT_TRUE(poles);
    EXPECT_REL(poles->decay_per_s, zeta * w, 1e-10, "trace and determinant stay well conditioned");
    EXPECT_REL(poles->stiffness_per_s2, w * w, 1e-10,
               "trace and determinant stay well conditioned");
  }
}

TEST(EstimatePoles, StaysNearTheBoundInNoise) {
  // noise 1 % of the amplitude, 2500 samples in 0.25 s: the bound is 0.14 % for the decay
  const auto poles = EstimatePoles(Decay({11.5, 2e6}, 1e-4, 2500, 4e-3), 1e-4);
  ASSERT_TRUE(poles);
  EXPECT_REL(poles->decay_per_s, 11.5, 0.005, "3.5 standard deviations of the bound");
  EXPECT_REL(std::sqrt(poles->stiffness_per_s2), std::sqrt(2e6), 4e-5, "4 of 11 ppm");
}

TEST(EstimatePoles, FallsBackOnTheSpectrumInHeavyNoise) {
  // twice as much noise as signal: the line is still there
  const auto poles = EstimatePoles(Decay({11.5, 2e6}, 1e-4, 2500, 0.8), 1e-4);
  ASSERT_TRUE(poles);
  EXPECT_GT(poles->decay_per_s, 0);
  EXPECT_REL(std::sqrt(poles->stiffness_per_s2) / (2 * std::numbers::pi), 225.07, 0.05,
             "the fit reaches 30 %");
}

}  // namespace
}  // namespace haptometer::fit
