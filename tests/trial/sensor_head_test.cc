// What averaging leaves of a tone.
#include "trial/sensor_head.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/residual.h"

namespace haptometer::trial {
namespace {

TEST(SensorHead, AveragingLeavesOfAToneWhatItsPhasorsSumTo) {
  // 16 averages at 0.33 ms: 0.15 at 225 Hz, 0.08 at 175 Hz; single readings 1
  EXPECT_ABS(AveragingGain(225, 0.33e-3, 16), 0.15, 5e-3, "the figure's digits");
  EXPECT_ABS(AveragingGain(175, 0.33e-3, 16), 0.08, 5e-3, "the figure's digits");
  EXPECT_EQ(AveragingGain(225, 0.33e-3, 1), 1);
  EXPECT_EQ(AveragingGain(1000, 1e-3, 16), 1) << "an alias of 0 Hz";
  EXPECT_ABS(AveragingGain(1000.0 / 16, 1e-3, 16), 0, 1e-15, "one whole period is averaged");
  // the mean of the samples of a phasor, summed
  double re = 0;
  double im = 0;
  for (int k = 0; k < 7; ++k) {
    re += std::cos(2 * std::numbers::pi * 90 * 1e-3 * k) / 7;
    im += std::sin(2 * std::numbers::pi * 90 * 1e-3 * k) / 7;
  }
  EXPECT_REL(AveragingGain(90, 1e-3, 7), std::hypot(re, im), 1e-14, "rounding");
}

}  // namespace
}  // namespace haptometer::trial
