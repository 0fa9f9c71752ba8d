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
  const auto fit = FitRing(samples, {20, 1.9e6}, {.drifts = true, .hum_hz = {50}});
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

TEST(RingFit, EachLineOfHumHasItsCosineAndItsSine) {
  // 0.004 and 0.003 at 150 Hz, -0.002 and 0.001 at 250 Hz beside the 50 Hz; t on the record's axis
  auto record = Record();
  const auto angle = [&](std::size_t n, double hertz) {
    return 2 * std::numbers::pi * hertz * (record.start_s + static_cast<double>(n) * record.step_s);
  };
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    record.voltage_v[n] += 4e-3 * std::cos(angle(n, 150)) + 3e-3 * std::sin(angle(n, 150)) -
                           2e-3 * std::cos(angle(n, 250)) + 1e-3 * std::sin(angle(n, 250));
  }
  // condensed and not
  for (const std::size_t end : {2400U, 900U}) {
    for (const bool drifts : {true, false}) {
      auto without_line = record;
      for (std::size_t n = 0; n < 2400 && !drifts; ++n) {
        without_line.voltage_v[n] -= 0.03 * (static_cast<double>(n) / 2399 - 0.5);
      }
      const auto samples = BlocksOf(without_line, 0, end, 1);
      const auto fit = FitRing(samples, {20, 1.9e6}, {.drifts = drifts, .hum_hz = {50, 150, 250}});
      ASSERT_EQ(fit.hum.size(), 3U);
      EXPECT_EQ(fit.hum[1].frequency_hz, 150);
      EXPECT_ABS(fit.hum[1].cosine_v, 4e-3, 1e-12, "noise-free");
      EXPECT_ABS(fit.hum[1].sine_v, 3e-3, 1e-12, "noise-free");
      EXPECT_EQ(fit.hum[2].frequency_hz, 250);
      EXPECT_ABS(fit.hum[2].cosine_v, -2e-3, 1e-12, "noise-free");
      EXPECT_ABS(fit.hum[2].sine_v, 1e-3, 1e-12, "noise-free");
      EXPECT_ABS(fit.HumAmplitude(), std::sqrt(1e-4 + 25e-6 + 5e-6), 1e-12, "noise-free");
      EXPECT_ABS(fit.hum[2].At(1e-3), 1e-3, 1e-12, "a quarter of a period: the sine");
    }
  }
}

TEST(RingFit, BlocksKeepThePoles) {
  auto record = Record();
  record.voltage_v[77] = std::nan("");
  const auto samples = BlocksOf(record, 5, 2400, 4);
  EXPECT_EQ(samples.values_v.size(), 597U) << "598 whole blocks, one with a hole";
  EXPECT_DOUBLE_EQ(samples.times_s[0], -2e-3 + 6.5e-4);
  // a mean of 4 scales the line and the hum too, which stay a line and a hum
  const auto fit = FitRing(samples, {20, 1.9e6}, {.drifts = true, .hum_hz = {50}});
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

// both begin at rest where the release is, `later` samples of 10 us before what is seen
void ExpectALinearMotionOf(std::size_t later) {
  FrictionRing ring = Released(0.02);
  ring.poles.decay_per_s = 25;
  const double damped = std::sqrt(kAngular * kAngular - 625);
  const double since_s = 1e-5 * static_cast<double>(later);
  const auto from_begin_s = Times(1e-5, 6000);
  const auto whole = MotionWithFriction({.poles = ring.poles,
                                         .even_v = 1,
                                         .odd_v_per_s = 25,
                                         .friction = 0.02,
                                         .signal = RecordedSignal::kDisplacement},
                                        from_begin_s);
  // the same motion from there on: position and speed give even and odd
  const double fall = std::exp(-25 * since_s);
  const double even = fall * std::cos(damped * since_s);
  const double odd = fall * std::sin(damped * since_s) / damped;
  ring.even_v = 0.98 * (even + 25 * odd) + 0.02;
  ring.odd_v_per_s = -kAngular * kAngular * 0.98 * odd + 25 * ring.even_v;
  const auto times_s = Times(1e-5, 5000);
  const auto more = LinearLessFriction(ring, -since_s, true, times_s);
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    const double t = times_s[n] + since_s;
    const double linear =
        std::exp(-25 * t) * (std::cos(damped * t) + 25 / damped * std::sin(damped * t));
    EXPECT_ABS(whole[n + later] + more[n], linear, 1e-9, "the begin is found by bisection")
        << later << ' ' << n;
  }
}

TEST(DryFriction, WhatIsAddedMakesALinearMotionOfIt) {
  // half a period is 241.7 samples: the first swing's begin, middle and end
  for (const std::size_t later : {1U, 40U, 121U, 239U, 241U}) ExpectALinearMotionOf(later);
}

TEST(RingFit, FrictionIsFittedBesideOffsetLineAndHum) {
  // friction of 0.1 % of the spring's force at the first swing, which does not end the motion
  const double w = std::sqrt(2e6);
  for (const auto signal : {RecordedSignal::kVoltage, RecordedSignal::kDisplacement}) {
    const double per_motion = signal == RecordedSignal::kVoltage ? w : 1;
    const FrictionRing ring{.poles = {.decay_per_s = 11, .stiffness_per_s2 = 2e6},
                            .even_v = 0.4,
                            .odd_v_per_s = 60,
                            .friction = 0.001 * 0.4 / per_motion,
                            .signal = signal};
    RingSamples samples{
        .step_s = 1e-4, .signal = signal, .times_s = Times(1e-4, 1200), .values_v = {}};
    samples.values_v = MotionWithFriction(ring, samples.times_s);
    for (std::size_t n = 0; n < samples.times_s.size(); ++n) {
      const double t = samples.times_s[n];
      samples.values_v[n] += 0.02 + 0.03 * (static_cast<double>(n) / 1199 - 0.5) +
                             0.01 * std::cos(2 * std::numbers::pi * 50 * t) -
                             0.02 * std::sin(2 * std::numbers::pi * 50 * t);
    }
    const auto fit =
        FitRing(samples, {11.5, 1.99e6}, {.drifts = true, .hum_hz = {50}, .has_friction = true});
    ASSERT_TRUE(fit.converged);
    constexpr const char* kReason = "slopes by differences of 1e-6";
    EXPECT_REL(fit.friction, ring.friction, 1e-5, kReason);
    EXPECT_REL(fit.poles.decay_per_s, 11.0, 1e-5, kReason);
    EXPECT_REL(fit.poles.stiffness_per_s2, 2e6, 1e-8, kReason);
    EXPECT_REL(fit.even_v, 0.4, 1e-6, kReason);
    EXPECT_REL(fit.odd_v_per_s, 60.0, 1e-5, kReason);
    EXPECT_REL(fit.offset_v, 0.02, 1e-5, kReason);
    EXPECT_REL(fit.drift_v, 0.03, 1e-5, kReason);
    ASSERT_EQ(fit.hum.size(), 1U);
    EXPECT_REL(fit.hum[0].cosine_v, 0.01, 1e-5, kReason);
    EXPECT_REL(fit.hum[0].sine_v, -0.02, 1e-5, kReason);
  }
}

// 0.5 % to 4 % of the spring's force at the first swing, which ends the motion after 44 to 11 half
// swings, within the record
TEST(RingFit, FrictionThatEndsTheMotionIsFound) {
  const double w = std::sqrt(2e6);
  for (const auto signal : {RecordedSignal::kVoltage, RecordedSignal::kDisplacement}) {
    for (const double share : {0.005, 0.01, 0.02, 0.04}) {
      const FrictionRing ring{
          .poles = {.decay_per_s = 11, .stiffness_per_s2 = 2e6},
          .even_v = 0.4,
          .odd_v_per_s = 60,
          .friction = share * 0.4 / (signal == RecordedSignal::kVoltage ? w : 1),
          .signal = signal};
      RingSamples samples{
          .step_s = 1e-4, .signal = signal, .times_s = Times(1e-4, 1200), .values_v = {}};
      samples.values_v = MotionWithFriction(ring, samples.times_s);
      for (double& value : samples.values_v) value += 0.02;
      const auto fit = FitRing(samples, {15, 1.99e6}, {.has_friction = true});
      EXPECT_TRUE(fit.converged);
      constexpr const char* kReason = "slopes by differences of 1e-6, kinks at the turns";
      EXPECT_REL(fit.friction, ring.friction, 1e-4, kReason);
      EXPECT_REL(fit.poles.decay_per_s, 11.0, 1e-3, kReason);
      EXPECT_REL(fit.poles.stiffness_per_s2, 2e6, 1e-7, kReason);
    }
  }
}

TEST(RingFit, DeviationsAreTheCramerRaoBounds) {
  // variance of d and of w of A e^(-d t) cos(w t + p) over a length T in white noise s:
  // (2 s^2 dt/A^2) I0/(I0 I2 - I1^2), I_k the integrals of t^k e^(-2 d t)
  const auto samples = BlocksOf(Record(), 0, 2400, 1);
  const auto fit = FitRing(samples, {20, 1.9e6}, {.drifts = true, .hum_hz = {50}});
  const double x = 2 * 11 * 0.24;
  const double left = std::exp(-x);
  const double i0 = (1 - left) / 22;
  const double i1 = (1 - left * (1 + x)) / std::pow(22, 2);
  const double i2 = (2 - left * (2 + 2 * x + x * x)) / std::pow(22, 3);
  const double amplitude = std::hypot(0.4, 60 / std::sqrt(2e6 - 121));
  const double noise_v = 3e-3;
  const double rate = std::sqrt(2 * 1e-4 * i0 / (i0 * i2 - i1 * i1)) * noise_v / amplitude;
  EXPECT_REL(fit.Deviation(0, noise_v * noise_v), rate / 11, 0.01, "ln d; sums for averages");
  EXPECT_REL(fit.Deviation(1, noise_v * noise_v), 2 * rate / std::sqrt(2e6), 0.01,
             "ln q = 2 ln w; sums for averages");
}

TEST(RingFit, TheEnvelopeOfAnAperiodicMotionIsItsFirstValueThatDecays) {
  RingFit fit;
  fit.poles = {.decay_per_s = 2000, .stiffness_per_s2 = 2e6};
  fit.even_v = -0.3;
  fit.odd_v_per_s = 100;
  EXPECT_REL(fit.Envelope(1e-3), 0.3 * std::exp(-2), 1e-14, "closed form");
}

TEST(DryFriction, WhatIsAddedToASpeedMakesALinearMotionOfIt) {
  // an impact at -0.4 ms: u = 0 and u' = 1 there, in either direction
  const PolePair poles{.decay_per_s = 25, .stiffness_per_s2 = kAngular * kAngular};
  const double damped = std::sqrt(kAngular * kAngular - 625);
  constexpr double kFriction = 2e-5;  // 2.6 % of the first swing of 1/1300
  for (const double sign : {1.0, -1.0}) {
    const FrictionRing whole{.poles = poles,
                             .even_v = sign,
                             .odd_v_per_s = -25 * sign,
                             .friction = kFriction,
                             .signal = RecordedSignal::kVoltage};
    const auto seen = MotionWithFriction(whole, Times(1e-5, 6000));
    // the same motion as of 40 samples later, about -f sign
    const double fall = std::exp(-25 * 4e-4);
    const double even = fall * std::cos(damped * 4e-4);
    const double odd = fall * std::sin(damped * 4e-4) / damped;
    const double u = sign * (kFriction * (even + 25 * odd) + odd - kFriction);
    const double v = sign * (even - 25 * odd - kAngular * kAngular * kFriction * odd);
    EXPECT_ABS(seen[40], v, 1e-12, "rounding");
    FrictionRing later = whole;
    later.even_v = v;
    later.odd_v_per_s = -kAngular * kAngular * u - 25 * v;
    const auto times_s = Times(1e-5, 5000);
    const auto more = LinearLessFriction(later, -4e-4, false, times_s);
    for (std::size_t n = 0; n < times_s.size(); ++n) {
      const double t = times_s[n] + 4e-4;
      const double linear =
          sign * std::exp(-25 * t) * (std::cos(damped * t) - 25 / damped * std::sin(damped * t));
      EXPECT_ABS(seen[n + 40] + more[n], linear, 1e-9, "the begin is found by bisection");
    }
  }
}

TEST(RingFit, HasAColumnForEachParameterAndARowForEachSample) {
  // of 600 samples, and of 2400, which are condensed for the descent
  for (const std::size_t count : {600U, 2400U}) {
    const auto samples = BlocksOf(Record(), 0, count, 1);
    const auto columns = [&](const RingBackground& background) {
      const RingFit fit = FitRing(samples, {11.5, 1.99e6}, background);
      EXPECT_EQ(fit.jacobian.rows, count);
      EXPECT_EQ(fit.jacobian.values.size(), count * fit.jacobian.columns);
      EXPECT_EQ(fit.jacobian.residuals.size(), count);
      return fit.jacobian.columns;
    };
    EXPECT_EQ(columns({}), 5U) << "two of the poles, even, odd and offset";
    EXPECT_EQ(columns({.drifts = true}), 6U);
    EXPECT_EQ(columns({.hum_hz = {50}}), 7U);
    EXPECT_EQ(columns({.drifts = true, .hum_hz = {50}}), 8U);
    EXPECT_EQ(columns({.has_friction = true}), 6U);
  }
}

TEST(RingFit, AnInstantThatTimesCountFromChangesNothing) {
  // a short motion and a long one, which is condensed for the descent; a second apart
  for (const std::size_t count : {200U, 2400U}) {
    auto record = Record();
    const auto now = FitRing(BlocksOf(record, 0, count, 1), {11.5, 1.99e6}, {.drifts = true});
    record.start_s += 1;
    const auto later = FitRing(BlocksOf(record, 0, count, 1), {11.5, 1.99e6}, {.drifts = true});
    ASSERT_TRUE(now.converged && later.converged);
    EXPECT_REL(later.poles.decay_per_s, now.poles.decay_per_s, 1e-7, "the solver's end");
    EXPECT_REL(later.poles.stiffness_per_s2, now.poles.stiffness_per_s2, 1e-9, "the solver's end");
    EXPECT_REL(later.even_v, now.even_v, 1e-7, "the solver's end");
    EXPECT_REL(later.odd_v_per_s, now.odd_v_per_s, 1e-7, "the solver's end");
    EXPECT_REL(later.drift_v, now.drift_v, 1e-6, "the solver's end");
  }
}

}  // namespace
}  // namespace haptometer::fit
