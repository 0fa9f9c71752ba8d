#include "dsp/spectrum/electrical.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRateHz = 50e3;
constexpr double kToneHz = 225;
// 5 V on 27 ohm and 3 mH
constexpr double kResistance_ohm = 27;
constexpr double kReactance_ohm = 2 * kPi * kToneHz * 3e-3;

struct Wires {
  std::vector<double> voltage_v;
  std::vector<double> current_a;
};

Wires CoilFor(std::size_t count) {
  const std::complex<double> z(kResistance_ohm, kReactance_ohm);
  return {Samples(kRateHz, count, 0, {{5, kToneHz, 0.3}}),
          Samples(kRateHz, count, 0, {{5 / std::abs(z), kToneHz, 0.3 - std::arg(z)}})};
}

TEST(Electrical, OfACoilIsTheClosedFormAtAnyLength) {
  const std::complex<double> z(kResistance_ohm, kReactance_ohm);
  const double current = 5 / std::abs(z);
  for (const std::size_t count : {2000U, 2111U}) {  // 9 periods, 9.4995 periods
    const Wires wires = CoilFor(count);
    const auto state = DescribeElectrical(wires.voltage_v, wires.current_a, kRateHz, kToneHz);
    ASSERT_TRUE(state);
    constexpr const char* kReason = "rounding";
    EXPECT_REL(state->voltage_rms_v.value, 5 / std::numbers::sqrt2, 1e-13, kReason);
    EXPECT_REL(state->current_rms_a.value, current / std::numbers::sqrt2, 1e-13, kReason);
    EXPECT_REL(state->real_power_w.value, 0.5 * current * current * 27, 1e-13, kReason);
    EXPECT_REL(state->apparent_power_va.value, 2.5 * current, 1e-13, kReason);
    EXPECT_REL(state->phase_rad.value, -std::arg(z), 1e-12, "the current lags");
    EXPECT_REL(state->resistance_ohm.value, kResistance_ohm, 1e-13, kReason);
    EXPECT_REL(state->reactance_ohm.value, kReactance_ohm, 1e-12, kReason);
  }
}

TEST(Electrical, OffsetsAndMultiplesCarryPowerToo) {
  Wires wires = CoilFor(2000);
  const std::vector<double> third = Samples(kRateHz, 2000, 0.5, {{1, 3 * kToneHz, 1}});
  for (std::size_t k = 0; k < third.size(); ++k) {
    wires.voltage_v[k] += third[k];
    wires.current_a[k] += 0.01 * third[k];
  }
  const auto state = DescribeElectrical(wires.voltage_v, wires.current_a, kRateHz, kToneHz);
  ASSERT_TRUE(state);
  EXPECT_REL(state->voltage_rms_v.value, std::sqrt(12.5 + 0.25 + 0.5), 1e-12, "whole periods");
  const double impedance = std::hypot(kResistance_ohm, kReactance_ohm);
  const double tone_w = 0.5 * 25 * kResistance_ohm / (impedance * impedance);
  EXPECT_REL(state->real_power_w.value, tone_w + 0.01 * (0.25 + 0.5), 1e-12, "whole periods");
}

TEST(Electrical, IntervalsHoldTheTruth) {
  constexpr int kRepetitions = 2000;
  const double impedance = std::hypot(kResistance_ohm, kReactance_ohm);
  const double power_w = 0.5 * 25 * kResistance_ohm / (impedance * impedance);
  Noise noise(17);
  const Wires clean = CoilFor(500);
  int power = 0;
  int phase = 0;
  int resistance = 0;
  int reactance = 0;
  int current = 0;
  const auto holds = [](const Estimate& estimate, double truth) {
    return std::abs(estimate.value - truth) <= 1.965 * estimate.uncertainty ? 1 : 0;  // t, 497
  };
  for (int r = 0; r < kRepetitions; ++r) {
    Wires wires = clean;
    for (double& v : wires.voltage_v) v += 0.02 * noise();
    for (double& i : wires.current_a) i += 0.001 * noise();
    const auto state = DescribeElectrical(wires.voltage_v, wires.current_a, kRateHz, kToneHz);
    ASSERT_TRUE(state);
    power += holds(state->real_power_w, power_w);
    phase += holds(state->phase_rad, -std::atan2(kReactance_ohm, kResistance_ohm));
    resistance += holds(state->resistance_ohm, kResistance_ohm);
    reactance += holds(state->reactance_ohm, kReactance_ohm);
    current += holds(state->current_rms_a, 5 / impedance / std::numbers::sqrt2);
  }
  EXPECT_NEAR(power, 1900, 40) << "95 % +- 2 % of 2000";
  EXPECT_NEAR(phase, 1900, 40);
  EXPECT_NEAR(resistance, 1900, 40);
  EXPECT_NEAR(reactance, 1900, 40);
  EXPECT_NEAR(current, 1900, 40);
}

TEST(Electrical, IsNotMadeUp) {
  const Wires wires = CoilFor(2000);
  const std::vector<double> nothing(2000, 0.0);
  EXPECT_FALSE(DescribeElectrical(wires.voltage_v, nothing, kRateHz, kToneHz)) << "no current";
  Noise noise(3);
  std::vector<double> noisy(2000);
  for (double& i : noisy) i = noise();
  EXPECT_FALSE(DescribeElectrical(wires.voltage_v, noisy, kRateHz, kToneHz));
  EXPECT_FALSE(DescribeElectrical(std::span(wires.voltage_v).first(200),
                                  std::span(wires.current_a).first(200), kRateHz, kToneHz))
      << "0.9 of a period";
}

// 9 whole periods, in which tone, offset and third multiple share nothing: the fit leaves the
// multiple, of 1 V and 0.01 A, and each uncertainty has a closed form
TEST(Electrical, UncertaintiesAreThoseOfWhatTheFitLeaves) {
  constexpr double kSamples = 2000;
  const double current = 5 / std::hypot(kResistance_ohm, kReactance_ohm);
  Wires wires = CoilFor(2000);
  const std::vector<double> third = Samples(kRateHz, 2000, 0, {{1, 3 * kToneHz, 1}});
  for (std::size_t k = 0; k < third.size(); ++k) {
    wires.voltage_v[k] += third[k] + 0.5;
    wires.current_a[k] += 0.01 * third[k];
  }
  const auto state = DescribeElectrical(wires.voltage_v, wires.current_a, kRateHz, kToneHz);
  ASSERT_TRUE(state);
  constexpr const char* kReason = "rounding of sums over whole periods";
  // of a mean square S + s^2 on n samples: 4 S s^2 / n + 2 s^4 / n, over 2 RMS
  const auto of_rms = [](double power, double noise) {
    return std::sqrt((4 * power * noise + 2 * noise * noise) / kSamples) /
           (2 * std::sqrt(power + noise));
  };
  const double u_v = of_rms(12.5 + 0.25, 0.5);
  const double u_i = of_rms(0.5 * current * current, 0.5e-4);
  EXPECT_REL(state->voltage_rms_v.uncertainty, u_v, 1e-10, kReason);
  EXPECT_REL(state->current_rms_a.uncertainty, u_i, 1e-10, kReason);
  const double v = std::sqrt(12.5 + 0.25 + 0.5);
  const double i = std::sqrt(0.5 * current * current + 0.5e-4);
  EXPECT_REL(state->apparent_power_va.uncertainty, std::hypot(v * u_i, i * u_v), 1e-10, kReason);
  EXPECT_REL(state->real_power_w.uncertainty,
             std::hypot(v * std::sqrt(0.5e-4), i * std::sqrt(0.5)) / std::sqrt(kSamples), 1e-10,
             kReason);
  // of an amplitude and, over it, of a phase: sqrt(2 s^2 / n), s^2 with n - 3 degrees of freedom
  const double relative = std::hypot(1.0 / 5, 0.01 / current) / std::sqrt(kSamples - 3);
  EXPECT_REL(state->phase_rad.uncertainty, relative, 1e-10, kReason);
  const double impedance = 5 / current;
  EXPECT_REL(state->resistance_ohm.uncertainty, impedance * relative, 1e-10, kReason);
  EXPECT_REL(state->reactance_ohm.uncertainty, impedance * relative, 1e-10, kReason);
}

// u = s sqrt(2 / n): of a multiple of amplitude b, b / sqrt(n - 3)
TEST(Electrical, NeedsAnAmplitudeOfThreeUncertainties) {
  const Wires wires = CoilFor(2000);
  for (const double uncertainties : {2.98, 3.02}) {
    const double least = uncertainties / std::sqrt(2000.0 - 3);
    const std::vector<double> current =
        Samples(kRateHz, 2000, 0, {{least, kToneHz, 0.1}, {1, 3 * kToneHz, 1}});
    EXPECT_EQ(DescribeElectrical(wires.voltage_v, current, kRateHz, kToneHz).has_value(),
              uncertainties > 3);
    EXPECT_EQ(DescribeElectrical(current, wires.voltage_v, kRateHz, kToneHz).has_value(),
              uncertainties > 3);
  }
}

// 222.2 samples a period
TEST(Electrical, NeedsOnePeriod) {
  for (const std::size_t count : {222U, 223U}) {
    const Wires wires = CoilFor(count);
    EXPECT_EQ(DescribeElectrical(wires.voltage_v, wires.current_a, kRateHz, kToneHz).has_value(),
              count == 223);
  }
}

// phases that are a turn apart are none
TEST(Electrical, TheAngleIsThatOfEveryPhaseOfTheTone) {
  const std::complex<double> z(kResistance_ohm, kReactance_ohm);
  for (int eighth = 0; eighth < 8; ++eighth) {
    const double phase = 0.25 * kPi * eighth + 0.1;
    const auto voltage = Samples(kRateHz, 2000, 0, {{5, kToneHz, phase}});
    const auto current = Samples(kRateHz, 2000, 0, {{0.1, kToneHz, phase - std::arg(z)}});
    const auto state = DescribeElectrical(voltage, current, kRateHz, kToneHz);
    ASSERT_TRUE(state);
    EXPECT_REL(state->phase_rad.value, -std::arg(z), 1e-11, "rounding of phases of 57 rad");
  }
}

TEST(Electrical, OnePeriodIsEnough) {
  const std::vector<double> tone = Samples(kRateHz, 200, 0, {{5, 250, 0.3}});
  EXPECT_TRUE(DescribeElectrical(tone, tone, kRateHz, 250));
  EXPECT_FALSE(
      DescribeElectrical(std::span(tone).first(199), std::span(tone).first(199), kRateHz, 250));
}

}  // namespace
}  // namespace haptometer::dsp
