#include "fit/ring_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

// v = 0.4 E(t) + 60 O(t) + 0.02 with a line, and 50 Hz; t from -2 ms
ImpulseRecord Record() {
  ImpulseRecord record;
  record.start_s = -2e-3;
  record.step_s = 1e-4;
  const double w = std::sqrt(2e6 - 121);
  for (int n = 0; n < 2400; ++n) {
    const double t = n * record.step_s;
    const double ringing = std::exp(-11 * t) * (0.4 * std::cos(w * t) + 60 * std::sin(w * t) / w);
    const double line = 0.03 * (t / (2399 * record.step_s) - 0.5);
    const double hum = 0.01 * std::sin(2 * std::numbers::pi * 50 * t);
    record.voltage_v.push_back(ringing + 0.02 + line + hum);
  }
  return record;
}

TEST(RingFit, FindsEveryPartOfACleanRecord) {
  const auto samples = BlocksOf(Record(), 0, 2400, 1);
  const auto fit = FitRing(samples, {20, 1.9e6}, {.drifts = true, .hum_hz = 50});
  ASSERT_TRUE(fit.converged);
  EXPECT_REL(fit.poles.decay_per_s, 11.0, 1e-11, "noise-free");
  EXPECT_REL(fit.poles.stiffness_per_s2, 2e6, 1e-12, "noise-free");
  EXPECT_REL(fit.even_v, 0.4, 1e-11, "noise-free");
  EXPECT_REL(fit.odd_v_per_s, 60.0, 1e-11, "noise-free");
  EXPECT_REL(fit.offset_v, 0.02, 1e-11, "noise-free");
  EXPECT_REL(fit.drift_v, 0.03, 1e-11, "noise-free");
  EXPECT_REL(fit.HumAmplitude(), 0.01, 1e-11, "noise-free");
  const double amplitude = std::hypot(0.4, 60 / std::sqrt(2e6 - 121));
  EXPECT_REL(fit.Envelope(0.1), amplitude * std::exp(-1.1), 1e-11, "closed form");
}

TEST(RingFit, BlocksKeepThePoles) {
  auto record = Record();
  record.voltage_v[77] = std::nan("");
  const auto samples = BlocksOf(record, 5, 2400, 4);
  EXPECT_EQ(samples.values_v.size(), 597U) << "598 whole blocks, one with a hole";
  EXPECT_DOUBLE_EQ(samples.times_s[0], -2e-3 + 6.5e-4);
  // a mean of 4 scales the line and the hum too, which stay a line and a hum
  const auto fit = FitRing(samples, {20, 1.9e6}, {.drifts = true, .hum_hz = 50});
  EXPECT_REL(fit.poles.decay_per_s, 11.0, 1e-10, "noise-free");
  EXPECT_REL(fit.poles.stiffness_per_s2, 2e6, 1e-11, "noise-free");
}

}  // namespace
}  // namespace haptometer::fit
