#include "fit/drop_test/ring_start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/fit/synthetic_drop.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using tests::MakeRecord;
using tests::SyntheticDrop;

TEST(RingStart, FindsImpactOffsetAndNoise) {
  SyntheticDrop drop;
  drop.noise_v = 2e-3;
  drop.quiet_s = 0.1;
  const auto start = FindRingStart(MakeRecord(drop));
  ASSERT_TRUE(start);
  EXPECT_ABS(start->impact_s, 0.37e-4, 2e-6, "phase from 1250 samples at 0.5 % noise");
  EXPECT_ABS(start->impact_voltage_v, std::sqrt(0.02 * 9.80665), 2e-3, "amplitude to 0.4 %");
  EXPECT_ABS(start->offset_v, 0.01, 2e-4, "mean of 1250 samples");
  EXPECT_REL(start->quiet_noise_v, 2e-3, 0.12, "490 samples, 3 sigma 10 %");
  EXPECT_REL(start->residual_rms_v, 2e-3, 0.1, "the pole pair fits");
  // the fit starts behind the blow by an eighth of a period, 0.56 ms
  const double first_s = -0.1 + static_cast<double>(start->first_sample) * drop.step_s;
  EXPECT_GT(first_s, 0.5e-3);
  EXPECT_LT(first_s, 1.0e-3);
  EXPECT_LT(-0.1 + static_cast<double>(start->quiet_samples) * drop.step_s, 0.0);
}

TEST(RingStart, ARecordThatBeginsWithTheBlowHasNoQuietStretch) {
  SyntheticDrop drop;
  drop.quiet_s = 0;
  drop.impact_s = -1e-6;
  const auto start = FindRingStart(MakeRecord(drop));
  ASSERT_TRUE(start);
  EXPECT_EQ(start->quiet_samples, 0U);
  EXPECT_EQ(start->quiet_noise_v, 0.0);
  EXPECT_ABS(start->impact_s, -1e-6, 3e-7, "offset taken from the median");
}

TEST(RingStart, PolarityIsThatOfTheFirstHalfPeriod) {
  for (const double polarity : {1.0, -1.0}) {
    SyntheticDrop drop;
    drop.polarity = polarity;
    const auto start = FindRingStart(MakeRecord(drop));
    ASSERT_TRUE(start);
    EXPECT_GT(polarity * start->impact_voltage_v, 0.4);
  }
}

TEST(RingStart, SilenceBeforeTheBlowStaysOutside) {
  // 1 ms of silence kept in a fit would cost 7 % of the damping
  SyntheticDrop drop;
  drop.quiet_s = 0.05;
  const auto record = MakeRecord(drop);
  const auto start = FindRingStart(record);
  ASSERT_TRUE(start);
  EXPECT_REL(start->poles.decay_per_s, 11.5, 1e-9, "noise-free");
}

TEST(RingStart, NoiseDoesNotMoveTheBlow) {
  // noise of a third of the amplitude: single samples before the blow pass half of the largest one
  for (unsigned seed = 1; seed <= 20; ++seed) {
    tests::SyntheticDrop drop;
    drop.noise_v = 0.33 * tests::ImpactSpeed(drop);
    drop.quiet_s = 0.03;
    drop.seed = seed;
    const auto start = FindRingStart(tests::MakeRecord(drop));
    ASSERT_TRUE(start) << start.error().Text();
    EXPECT_ABS(start->impact_s, drop.impact_s, 4e-4, "a tenth of a period");
  }
}

TEST(RingStart, TooShortARecordSaysWhatIsMissing) {
  SyntheticDrop drop;
  drop.quiet_s = 0;
  drop.length_s = 0.007;
  const auto start = FindRingStart(MakeRecord(drop));
  ASSERT_FALSE(start);
  EXPECT_EQ(start.error().cause, Cause::kCannotAnswer);
  EXPECT_EQ(start.error().where, "drop.csv");
  EXPECT_FALSE(start.error().remedy.empty());
  ImpulseRecord empty;
  EXPECT_FALSE(FindRingStart(empty));
}

TEST(RingStart, AReleaseBeginsAtAZeroWithTheSlopeOfItsForce) {
  // damped by 0.02, 0.2 and 0.4 of critical: 2 sqrt(Kv Mv) = 3.96 N s/m
  for (const double damping : {0.08, 0.8, 1.6}) {
    SCOPED_TRACE(damping);
    SyntheticDrop drop;
    drop.release_current_a = 0.05;
    drop.damping_n_s_per_m = damping;
    drop.step_s = 5e-5;
    drop.length_s = 0.03;
    const auto start = FindRingStart(MakeRecord(drop));
    ASSERT_TRUE(start) << start.error().Text();
    EXPECT_ABS(start->release_s, drop.impact_s, 1e-9, "noise-free");
    EXPECT_REL(start->release_slope_v_per_s, 0.05 / 1.4e-3, 1e-6, "Km^2 I0/Mv, noise-free");
  }
}

TEST(RingStart, BeyondCriticalDampingBothMotionsBeginAtTheirOnlyZero) {
  // 1.16 and 1.5 of critical: 2 sqrt(Kv Mv) = 3.96 N s/m
  for (const double damping : {4.6, 6.0}) {
    for (const double current_a : {0.0, 0.05}) {
      SCOPED_TRACE(damping);
      SCOPED_TRACE(current_a);
      SyntheticDrop drop;
      drop.release_current_a = current_a;
      drop.damping_n_s_per_m = damping;
      drop.step_s = 1e-5;
      drop.length_s = 0.02;
      const auto start = FindRingStart(MakeRecord(drop));
      ASSERT_TRUE(start) << start.error().Text();
      const double begin_s = current_a > 0 ? start->release_s : start->impact_s;
      EXPECT_ABS(begin_s, drop.impact_s, 1e-9, "noise-free");
    }
  }
}

TEST(RingStart, OfFewPeriodsBehindSilenceTheImpactIsFoundAtAnyOffset) {
  // 4.5 periods behind up to 3 silent ones: too few for the amplitude to be followed
  for (const double offset_v : {-3.0, 0.5, 3.0}) {
    for (const double quiet_s : {0.003, 0.006, 0.0132}) {
      SCOPED_TRACE(quiet_s);
      SCOPED_TRACE(offset_v);
      SyntheticDrop drop;
      drop.offset_v = offset_v;
      drop.quiet_s = quiet_s;
      drop.length_s = 0.02;
      const auto record = MakeRecord(drop);
      const auto start = FindRingStart(record);
      ASSERT_TRUE(start) << start.error().Text();
      EXPECT_ABS(start->impact_s, drop.impact_s, 1e-9, "noise-free");
      EXPECT_ABS(start->offset_v, offset_v, 1e-9, "noise-free");
      EXPECT_ABS(start->blow_s, 1e-4, 2.1e-4, "the next sample, to a sixteenth of a period");
    }
  }
}

// samples with something added, f(time)
template <typename Added>
ImpulseRecord With(ImpulseRecord record, const Added& added) {
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    record.voltage_v[n] += added(record.start_s + static_cast<double>(n) * record.step_s);
  }
  return record;
}

// A constant sine of h has the stronger spectrum where h T exceeds A/d: here 0.08 V.
TEST(RingStart, HumAndDriftLargerThanTheRingingDoNotHideIt) {
  SyntheticDrop drop;
  drop.noise_v = 2e-3;
  drop.quiet_s = 0.1;
  drop.length_s = 0.5;
  const ImpulseRecord clean = MakeRecord(drop);
  const auto expect = [](const ImpulseRecord& record) {
    const auto start = FindRingStart(record);
    ASSERT_TRUE(start) << start.error().Text();
    EXPECT_REL(start->poles.stiffness_per_s2, 2e6, 1e-3, "start values; 0.1 % of the frequency");
    EXPECT_REL(start->poles.decay_per_s, 11.5, 0.05, "start values");
    EXPECT_ABS(start->impact_s, 0.37e-4, 1e-4, "start values: a fortieth of a period");
    EXPECT_LT(start->quiet_noise_v, 6e-3) << "of 2 mV and what is left of the rest";
  };
  for (const double hum_v : {0.05, 0.1, 0.5}) {
    for (const double hum_hz : {50.0, 60.0}) {
      SCOPED_TRACE(hum_v);
      expect(With(clean, [&](double t) { return hum_v * std::sin(2 * M_PI * hum_hz * t + 1); }));
    }
  }
  for (const double drift_v_per_s : {0.3, 3.0, -20.0}) {
    SCOPED_TRACE(drift_v_per_s);
    expect(With(clean, [&](double t) { return drift_v_per_s * t; }));
    expect(With(clean, [&](double t) {
      return drift_v_per_s * t + 0.1 * std::sin(2 * M_PI * 50 * t + 1);
    }));
  }
}

TEST(RingStart, ARingingAtTheMainsOwnFrequencyIsNoHum) {
  // 50 Hz within a tenth of a line of the spectrum, from two decay times to a fifth of one
  for (const double decay_per_s : {4.0, 1.0, 0.4}) {
    SCOPED_TRACE(decay_per_s);
    SyntheticDrop drop;
    drop.stiffness_n_per_m = drop.moving_mass_kg * std::pow(2 * M_PI * 50.2, 2);
    drop.damping_n_s_per_m = 2 * drop.moving_mass_kg * decay_per_s;
    drop.noise_v = 2e-3;
    drop.quiet_s = 0.1;
    drop.length_s = 0.5;
    const auto start = FindRingStart(MakeRecord(drop));
    ASSERT_TRUE(start) << start.error().Text();
    EXPECT_REL(start->poles.stiffness_per_s2, std::pow(2 * M_PI * 50.2, 2), 1e-3, "noise");
    EXPECT_REL(start->quiet_noise_v, 2e-3, 0.12, "490 samples, 3 sigma 10 %");
  }
}

// The voltage behind a force of half a sine, `contact_s` long from time 0 on: its products with the
// complex oscillation, by the middle rule while it lasts.
ImpulseRecord AfterContact(double contact_s) {
  SyntheticDrop drop;
  drop.step_s = 5e-5;
  drop.quiet_s = 0.02;
  drop.noise_v = 2e-4;
  ImpulseRecord record = tests::MakeRecordWithHeight(drop);
  const double d = 11.5;
  const double w = std::sqrt(2e6 - d * d);
  const std::complex<double> rate(-d, w);
  // cos(w t) - d/w sin(w t) is the real part of (1 + j d/w) e^(j w t)
  const std::complex<double> blow = tests::SpeedVoltage(drop) * std::complex<double>(1, d / w);
  std::mt19937_64 engine(4);
  std::normal_distribution<double> noise(0, drop.noise_v);
  constexpr int kSteps = 1000;
  const auto pushed_until = [&](double until_s) {
    std::complex<double> pushed = 0;
    for (int k = 0; k < kSteps && until_s > 0; ++k) {
      const double u = until_s * (k + 0.5) / kSteps;
      pushed += std::sin(M_PI * u / contact_s) * std::exp(-rate * u) * until_s / double{kSteps};
    }
    return pushed;
  };
  const std::complex<double> whole = pushed_until(contact_s);
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    const double t = record.start_s + static_cast<double>(n) * record.step_s;
    const auto pushed = t < contact_s ? pushed_until(t) : whole;
    // the whole push is 2 T/pi
    const auto v = blow * std::exp(rate * t) * pushed / (2 * contact_s / M_PI);
    record.voltage_v[n] = 0.01 + v.real() + noise(engine);
  }
  return record;
}

TEST(RingStart, AContactsLengthLiesBetweenItsLimits) {
  // Lengths of 48 steps up to a third of a period are tried; a step is 31.5 us. The limits lie 30 %
  // and a step beyond those that the samples allow, which are within two steps of the length: noise
  // of 1e-3 of the first voltage, of 20 samples.
  const double step_s = 2 * M_PI / std::sqrt(2e6) / 3 / 47;
  for (const double contact_s : {0.7e-3, 1.0e-3, 1.3e-3}) {
    SCOPED_TRACE(contact_s);
    const ImpulseRecord record = AfterContact(contact_s);
    const auto start = FindRingStart(record);
    ASSERT_TRUE(start) << start.error().Text();
    EXPECT_LE(start->shortest_contact_s, 0.7 * contact_s);
    EXPECT_GE(start->shortest_contact_s, 0.7 * (contact_s - 3 * step_s));
    EXPECT_GE(start->longest_contact_s, 1.3 * contact_s);
    EXPECT_LE(start->longest_contact_s, 1.3 * (contact_s + 3 * step_s));
    EXPECT_FALSE(start->contact_may_be_longer);
    // no sample is fitted that the longest contact may reach
    const double first_s =
        record.start_s + static_cast<double>(start->first_sample) * record.step_s;
    EXPECT_GE(first_s, start->impact_s + start->longest_contact_s / 2);
    // the ring-down is one that begins at once in the contact's middle
    EXPECT_ABS(start->impact_s, contact_s / 2, 5e-6, "noise; d T to first order");
    const double angle = std::sqrt(2e6) * contact_s;
    EXPECT_REL(start->impact_voltage_v,
               std::sqrt(0.02 * 9.80665) * std::cos(angle / 2) / (1 - std::pow(angle / M_PI, 2)),
               3e-3, "noise; d T to first order");
  }
}

TEST(RingStart, AContactOfAThirdOfAPeriodMayBeLonger) {
  // 1.48 ms are a third of a period, where the search ends
  for (const double contact_s : {1.5e-3, 2e-3, 2.6e-3, 3e-3}) {
    SCOPED_TRACE(contact_s);
    const auto start = FindRingStart(AfterContact(contact_s));
    ASSERT_TRUE(start) << start.error().Text();
    EXPECT_TRUE(start->contact_may_be_longer);
  }
}

TEST(RingStart, OfASuddenImpactOnlyALongestContactIsReported) {
  SyntheticDrop drop;
  drop.step_s = 5e-5;
  drop.quiet_s = 0.02;
  drop.noise_v = 2e-4;
  const auto start = FindRingStart(tests::MakeRecordWithHeight(drop));
  ASSERT_TRUE(start);
  EXPECT_EQ(start->shortest_contact_s, 0);
  EXPECT_GT(start->longest_contact_s, 0);
  EXPECT_LT(start->longest_contact_s, 0.4e-3) << "samples are 0.05 ms apart";
  // without a height it is not looked for
  const auto without = FindRingStart(MakeRecord(drop));
  ASSERT_TRUE(without);
  EXPECT_EQ(without->longest_contact_s, 0);
}

// the number behind `before` in a refusal, and its decimals; -1: no such refusal
std::pair<double, std::size_t> NumberIn(const Result<RingStart>& start, const std::string& before) {
  if (start) return {-1, 0};
  const std::string text = start.error().Text();
  const auto at = text.find(before);
  if (at == std::string::npos) return {-1, 0};
  const std::string from = text.substr(at + before.size());
  const std::string number = from.substr(0, from.find_first_not_of("0123456789.-"));
  const auto point = number.find('.');
  return {std::stod(number), point == std::string::npos ? 0 : number.size() - point - 1};
}

// a number below a limit has one decimal, and more only where it would look like the limit
void ExpectBelow(const std::pair<double, std::size_t>& number, double limit) {
  if (number.first < 0) return;
  EXPECT_LT(number.first, limit);
  const bool looks_alike = std::round(10 * number.first) == std::round(10 * limit);
  EXPECT_EQ(number.second > 1, looks_alike) << number.first;
}

TEST(RingStart, WhatIsTooLittleIsReportedInDigitsThatDifferFromTheLimit) {
  int alike = 0;
  int refused = 0;
  for (int k = 0; k < 60; ++k) {
    SyntheticDrop drop;
    drop.quiet_s = 0;
    drop.impact_s = -1e-6;
    drop.step_s = 1e-4;
    drop.length_s = 6.5e-3 + 5e-5 * k;
    const auto start = FindRingStart(MakeRecord(drop));
    // a slow course takes most of so few periods; what it leaves is no ring-down
    if (start) {
      EXPECT_REL(std::sqrt(start->poles.stiffness_per_s2), std::sqrt(2e6), 0.2, "few periods");
    }
    const auto number = NumberIn(start, "holds only ");
    if (number.first < 0 || number.first > 10) continue;
    ++refused;
    alike += number.second > 1 ? 1 : 0;
    ExpectBelow(number, 2);
  }
  EXPECT_GT(refused, 5);
  EXPECT_GT(alike, 0);
}

TEST(RingStart, FiveSamplesAPeriodAreEnough) {
  const auto start_at = [](double samples) {
    SyntheticDrop drop;
    drop.step_s = 1 / (225.08 * samples);
    return FindRingStart(MakeRecord(drop));
  };
  // the spectrum's line is half of one of 1024 off: 0.3 %
  EXPECT_TRUE(start_at(5.05));
  const auto few = NumberIn(start_at(4.95), "has only ");
  EXPECT_ABS(few.first, 4.95, 0.065, "a decimal and half a line of the spectrum");
  ExpectBelow(few, 5);
  const auto fewer = NumberIn(start_at(4.97), "has only ");
  EXPECT_ABS(fewer.first, 4.97, 0.015, "half a line of the spectrum");
  EXPECT_EQ(fewer.second, 2U) << "5.0 would look like the limit";
}

// sum of squares of the ring-down behind the first sample over the mean square of what is left
double EnergyOf(const RingStart& start, const ImpulseRecord& record) {
  const double d = start.poles.decay_per_s;
  const double w = std::sqrt(start.poles.stiffness_per_s2 - d * d);
  double sum = 0;
  for (std::size_t n = start.first_sample; n < record.voltage_v.size(); ++n) {
    const double t = record.start_s + static_cast<double>(n) * record.step_s - start.impact_s;
    const double v =
        start.impact_voltage_v * std::exp(-d * t) * (std::cos(w * t) - d / w * std::sin(w * t));
    sum += v * v;
  }
  return sum / (start.residual_rms_v * start.residual_rms_v);
}

TEST(RingStart, AnEnergyOfFiftyTimesTheNoiseIsEnough) {
  double least = 1e9;
  double most_decibels = 0;
  // the energy of 0.443 V over the density of the noise is 50 at 0.46 V of it, 0.4 ms apart
  for (unsigned k = 0; k < 24; ++k) {
    SyntheticDrop drop;
    drop.step_s = 4e-4;
    drop.noise_v = 0.42 + 0.03 * (k % 3);
    drop.quiet_s = 0.03;
    drop.seed = k / 3 + 1;
    const auto record = MakeRecord(drop);
    const auto start = FindRingStart(record);
    if (start) least = std::min(least, EnergyOf(*start, record));
    const auto decibels = NumberIn(start, "has only ");
    if (decibels.first < 0) continue;
    most_decibels = std::max(most_decibels, decibels.first);
    ExpectBelow(decibels, 10 * std::log10(50.0));
  }
  EXPECT_GE(least, 50 * (1 - 1e-9));
  EXPECT_LT(least, 56) << "of so many records some lie close to the limit";
  // 10 lg 50 = 16.99
  EXPECT_LT(most_decibels, 16.99);
  EXPECT_GT(most_decibels, 16.4) << "of so many records some lie close to the limit";
}

}  // namespace
}  // namespace haptometer::fit
