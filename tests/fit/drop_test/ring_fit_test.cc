#include "fit/drop_test/ring_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

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

constexpr double kAngular = 1300;  // undamped, rad/s

// without damping, displaced by 1 and let go
FrictionRing Released(double friction) {
  return {.poles = {.decay_per_s = 0, .stiffness_per_s2 = kAngular * kAngular},
          .even_v = 1,
          .odd_v_per_s = 0,
          .friction = friction,
          .signal = RecordedSignal::kDisplacement};
}

std::vector<double> Times(double step_s, std::size_t count) {
  std::vector<double> times_s(count);
  for (std::size_t n = 0; n < count; ++n) times_s[n] = static_cast<double>(n) * step_s;
  return times_s;
}

TEST(DryFriction, PeaksFallByFourTimesTheFrictionAPeriod) {
  // Coulomb's own result: each half swing loses 2 f, whatever the amplitude
  constexpr double kFriction = 0.03;
  const auto turns_s = Times(std::numbers::pi / kAngular, 16);
  const auto turns = MotionWithFriction(Released(kFriction), turns_s);
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const double expected = (k % 2 == 0 ? 1 : -1) * (1 - 2 * kFriction * static_cast<double>(k));
    EXPECT_ABS(turns[k], expected, 1e-12, "rounding of some ten half swings");
  }
}

TEST(DryFriction, TheMotionEndsAtTheFirstTurnWithinTheFriction) {
  // 1, -0.6, 0.2: there the spring's force is below the friction's
  const auto motion = MotionWithFriction(Released(0.2001), Times(1e-5, 3000));
  EXPECT_ABS(motion.back(), 1 - 4 * 0.2001, 1e-12, "rounding");
  const auto end = static_cast<std::size_t>(2 * std::numbers::pi / kAngular / 1e-5) + 1;
  for (std::size_t n = end; n < motion.size(); ++n) EXPECT_EQ(motion[n], motion.back());
  FrictionRing speed = Released(0.2001);
  speed.signal = RecordedSignal::kVoltage;
  speed.even_v = 0;
  speed.odd_v_per_s = -kAngular * kAngular;
  EXPECT_EQ(MotionWithFriction(speed, Times(1e-5, 3000)).back(), 0)
      << "a voltage goes as the speed";
}

TEST(DryFriction, WithoutFrictionItIsTheLinearRingDown) {
  FrictionRing ring = Released(0);
  ring.poles.decay_per_s = 40;
  ring.odd_v_per_s = -500;
  const double damped = std::sqrt(kAngular * kAngular - 1600);
  const auto times_s = Times(1e-4, 800);
  for (const auto signal : {RecordedSignal::kDisplacement, RecordedSignal::kVoltage}) {
    ring.signal = signal;
    const auto motion = MotionWithFriction(ring, times_s);
    for (std::size_t n = 0; n < motion.size(); ++n) {
      const double t = times_s[n];
      EXPECT_ABS(motion[n],
                 std::exp(-40 * t) * (std::cos(damped * t) - 500 / damped * std::sin(damped * t)),
                 1e-12, "rounding of some thirty half swings");
    }
  }
}

TEST(DryFriction, EnergyIsLostToFrictionAndDampingAlone) {
  // q u^2/2 + v^2/2 falls by the integral of 2 d v^2 + q f |v|: the trapezium rule, 1e-6 s apart
  FrictionRing ring = Released(0.01);
  ring.poles.decay_per_s = 15;
  ring.odd_v_per_s = 700;
  const auto times_s = Times(1e-6, 40'000);
  const auto u = MotionWithFriction(ring, times_s);
  const double q = ring.poles.stiffness_per_s2;
  double lost = 0;
  const auto speed = [&](std::size_t n) { return (u[n + 1] - u[n - 1]) / 2e-6; };
  const auto energy = [&](std::size_t n) { return (q * u[n] * u[n] + speed(n) * speed(n)) / 2; };
  for (std::size_t n = 1; n + 1 < u.size(); ++n) {
    const double v = speed(n);
    const bool is_end = n == 1 || n + 2 == u.size();
    lost += (is_end ? 0.5e-6 : 1e-6) * (30 * v * v + q * 0.01 * std::abs(v));
  }
  EXPECT_REL(energy(1) - energy(u.size() - 2), lost, 1e-5, "differences 1e-6 s apart: (w h)^2");
}

TEST(DryFriction, WhatIsAddedMakesALinearMotionOfIt) {
  // both begin at rest at -0.4 ms where the release is
  FrictionRing ring = Released(0.02);
  ring.poles.decay_per_s = 25;
  const double damped = std::sqrt(kAngular * kAngular - 625);
  const double begin_s = -4e-4;
  const auto from_begin_s = Times(1e-5, 6000);
  const auto whole = MotionWithFriction({.poles = ring.poles,
                                         .even_v = 1,
                                         .odd_v_per_s = 25,
                                         .friction = 0.02,
                                         .signal = RecordedSignal::kDisplacement},
                                        from_begin_s);
  // the same motion as of 40 samples later: position and speed there give even and odd
  const double fall = std::exp(-25 * 4e-4);
  const double even = fall * std::cos(damped * 4e-4);
  const double odd = fall * std::sin(damped * 4e-4) / damped;
  ring.even_v = 0.98 * (even + 25 * odd) + 0.02;
  ring.odd_v_per_s = -kAngular * kAngular * 0.98 * odd + 25 * ring.even_v;
  const auto times_s = Times(1e-5, 5000);
  const auto more = LinearLessFriction(ring, begin_s, true, times_s);
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    const double t = times_s[n] - begin_s;
    const double linear =
        std::exp(-25 * t) * (std::cos(damped * t) + 25 / damped * std::sin(damped * t));
    EXPECT_ABS(whole[n + 40] + more[n], linear, 1e-9, "the begin is found by bisection");
  }
}

}  // namespace
}  // namespace haptometer::fit
