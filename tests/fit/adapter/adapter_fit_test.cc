#include "fit/adapter/adapter_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "tests/findings.h"
#include "tests/fit/pulls.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Lindsay 2013, Table 2.4 and section 3.1: 8200 N/m, 0.01 N s/m under the built base of 4.6 g
constexpr double kStiffness = 8200;
constexpr double kDamping = 0.01;
constexpr double kMass = 4.6e-3;
constexpr double kStep = 4e-4;

struct Tap {
  double length_s = 1;
  double speed_m_per_s = 0.05;
  double noise_m = 0;
  double resolution_m = 0;
  double drift_m = 0;
  double hum_m = 0;
  double damping = kDamping;
  unsigned seed = 1;
};

double Decay(const Tap& tap) { return tap.damping / (2 * kMass); }
double Angular(const Tap& tap) { return std::sqrt(kStiffness / kMass - std::pow(Decay(tap), 2)); }

// the impulse response, written down here
ImpulseRecord Record(const Tap& tap) {
  ImpulseRecord record;
  record.name = "tap.bin";
  record.unit = "m";
  record.step_s = kStep;
  record.start_s = -0.02;
  std::mt19937_64 engine(tap.seed);
  std::normal_distribution<double> noise;
  const int rows = static_cast<int>((tap.length_s + 0.02) / kStep);
  for (int n = 0; n < rows; ++n) {
    const double t = record.start_s + n * kStep;
    double x = 1e-3;
    if (t > 0) {
      x +=
          tap.speed_m_per_s / Angular(tap) * std::exp(-Decay(tap) * t) * std::sin(Angular(tap) * t);
    }
    x += tap.drift_m * t / tap.length_s + tap.hum_m * std::sin(2 * std::numbers::pi * 50 * t + 1);
    if (tap.noise_m > 0) x += tap.noise_m * noise(engine);
    if (tap.resolution_m > 0) x = std::round(x / tap.resolution_m) * tap.resolution_m;
    record.voltage_v.push_back(x);
  }
  return record;
}

// Cramer-Rao: variance of d and of w of A e^(-d t) cos(w t + p) over a length T in white noise,
// (2 s^2 dt/A^2) I0/(I0 I2 - I1^2), I_k the integrals of t^k e^(-2 d t)
double RateVariance(const Tap& tap) {
  const double lost_s = 2 * std::numbers::pi / Angular(tap) / 8;  // where the fit begins
  const double decay = Decay(tap);
  const double amplitude = tap.speed_m_per_s / Angular(tap) * std::exp(-decay * lost_s);
  const double x = 2 * decay * (tap.length_s - lost_s);
  const double left = std::exp(-x);
  const double i0 = (1 - left) / (2 * decay);
  const double i1 = (1 - left * (1 + x)) / std::pow(2 * decay, 2);
  const double i2 = (2 - left * (2 + 2 * x + x * x)) / std::pow(2 * decay, 3);
  const double noise = std::hypot(tap.noise_m, tap.resolution_m / std::sqrt(12.0));
  return 2 * noise * noise * kStep / (amplitude * amplitude) * i0 / (i0 * i2 - i1 * i1);
}

AdapterFit Fit(const Tap& tap, const Quantity& mass = {kMass, 0}) {
  const auto fit = FitAdapter({Record(tap)}, mass);
  EXPECT_TRUE(fit) << fit.error().Text();
  return fit ? *fit : AdapterFit{};
}

TEST(AdapterFit, ACleanTapGivesTheConstantsToRounding) {
  const AdapterFit fit = Fit({});
  // readings of about 3e-5 m on an offset of 1e-3 m carry 2e-19 m of rounding each
  EXPECT_REL(fit.stiffness.value, kStiffness, 1e-13, "rounding of the record");
  EXPECT_REL(fit.damping.value, kDamping, 1e-13, "rounding of the record");
  EXPECT_REL(fit.natural_frequency.value, 212.49471935474193, 1e-13, "worked number");
  EXPECT_REL(fit.quality_factor.value, std::sqrt(kStiffness * kMass) / kDamping, 1e-13,
             "closed form");
  EXPECT_REL(fit.stiffness_over_mass.value, kStiffness / kMass, 1e-13, "closed form");
  EXPECT_REL(fit.damping_over_mass.value, kDamping / kMass, 1e-13, "closed form");
  EXPECT_THAT(tests::DoubtsOf(fit.findings), IsEmpty());
  EXPECT_THAT(tests::KindsOf(fit.findings, Severity::kRefusal), IsEmpty());
}

TEST(AdapterFit, TheMassIsTypeB) {
  const AdapterFit fit = Fit({.noise_m = 1e-6}, {kMass, 0.046e-3});
  const double share = fit.stiffness.combined_standard_uncertainty / fit.stiffness.value;
  EXPECT_REL(share, 0.01, 1e-3, "1 % of mass is 1 % of Ka; statistics adds some ppm");
  EXPECT_LT(fit.stiffness.standard_uncertainty, 1e-4 * fit.stiffness.value);
  EXPECT_EQ(fit.natural_frequency.combined_standard_uncertainty,
            fit.natural_frequency.standard_uncertainty);
}

struct Case {
  std::string name;
  Tap tap;
};

class AdapterTaps : public ::testing::TestWithParam<Case> {};

TEST_P(AdapterTaps, ErrorsAreAtTheBoundAndAsStated) {
  const int repetitions = tests::Repetitions(tests::kIsSanitized ? 6 : 60);
  tests::Pulls stiffness;
  tests::Pulls damping;
  for (int k = 0; k < repetitions; ++k) {
    Tap tap = GetParam().tap;
    tap.seed = static_cast<unsigned>(k) + 1;
    const AdapterFit fit = Fit(tap);
    ASSERT_TRUE(fit.stiffness.determined && fit.damping.determined);
    stiffness.Add(fit.stiffness.value, kStiffness, fit.stiffness.standard_uncertainty);
    damping.Add(fit.damping.value, kDamping, fit.damping.standard_uncertainty);
  }
  const double rate = std::sqrt(RateVariance(GetParam().tap));
  ExpectEfficient(stiffness, 2 * rate / Angular(GetParam().tap) * kStiffness, "Ka");
  ExpectEfficient(damping, rate / Decay(GetParam().tap) * kDamping, "Ba");
}

INSTANTIATE_TEST_SUITE_P(
    Noise, AdapterTaps,
    ::testing::Values(Case{"OneMicrometre", {.noise_m = 1e-6}},
                      Case{"LaserSteps", {.noise_m = 0.5e-6, .resolution_m = 1e-6}},
                      Case{"HalfADecayTime", {.length_s = 0.5, .noise_m = 0.5e-6}}),
    [](const auto& tried) { return tried.param.name; });

TEST(AdapterFit, NoiseThatIsDenserAtTheResonanceWidensTheResult) {
  // e[n] = 0.6 e[n-1] + white has 0.64/(1 - 1.2 cos(2 pi f dt) + 0.36) = 2.0 of its mean at 212 Hz:
  // taken as white, the pulls would scatter by 1.4
  const int repetitions = tests::Repetitions(tests::kIsSanitized ? 6 : 60);
  tests::Pulls stiffness;
  tests::Pulls damping;
  for (int k = 0; k < repetitions; ++k) {
    ImpulseRecord record = Record({});
    std::mt19937_64 engine(static_cast<unsigned>(k) + 1000);
    std::normal_distribution<double> white(0, 1e-6);
    double noise = 0;
    for (double& value : record.voltage_v) value += noise = 0.6 * noise + white(engine);
    const auto fit = FitAdapter({record}, {kMass, 0});
    ASSERT_TRUE(fit);
    stiffness.Add(fit->stiffness.value, kStiffness, fit->stiffness.standard_uncertainty);
    damping.Add(fit->damping.value, kDamping, fit->damping.standard_uncertainty);
  }
  const double slack = 2.5 / std::sqrt(2.0 * repetitions);
  EXPECT_LE(stiffness.deviation(), 1.1 + slack);
  EXPECT_LE(damping.deviation(), 1.1 + slack);
  EXPECT_GE(stiffness.deviation(), 0.9 - slack);
  EXPECT_GE(damping.deviation(), 0.9 - slack);
  std::printf("pulls %.3f, %.3f\n", stiffness.deviation(), damping.deviation());
}

TEST(AdapterFit, DriftAndHumAreNamedAndFittedAlong) {
  const AdapterFit fit = Fit({.noise_m = 2e-7, .drift_m = 2e-5, .hum_m = 2e-6});
  const Findings& found = fit.taps.at(0).found;
  EXPECT_GT(tests::NumberOf(found, FindingKind::kDrift, "amplitude_m"), 0) << "not volts";
  EXPECT_EQ(tests::NumberOf(found, FindingKind::kHum, "frequency_hz"), 50);
  EXPECT_ABS(fit.damping.value, kDamping, 3 * fit.damping.standard_uncertainty, "3 deviations");
  EXPECT_ABS(fit.stiffness.value, kStiffness, 3 * fit.stiffness.standard_uncertainty,
             "3 deviations");
}

TEST(AdapterFit, ADecayThatIsNotSeenIsALimit) {
  // 40 ms hold 4 % of the decay
  constexpr unsigned kSeeds = 40;
  int refused = 0;
  int covered = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const AdapterFit fit = Fit({.length_s = 0.04, .noise_m = 2e-6, .seed = seed});
    EXPECT_TRUE(fit.stiffness.determined);
    if (fit.damping.determined) continue;
    ++refused;
    EXPECT_LT(*fit.damping.at_most, 5 * kDamping);
    covered += *fit.damping.at_most > kDamping ? 1 : 0;
    EXPECT_EQ(tests::KindsOf(fit.findings, Severity::kRefusal), std::vector{FindingKind::kBaBelow});
  }
  EXPECT_GE(refused, 36) << "its standard uncertainty is about 60 %";
  EXPECT_GE(covered, refused - 6) << "a 95 % limit misses 2 of 40, more than 6 in 1 % of seeds";
}

TEST(AdapterFit, TapsThatDisagreeWidenTheResult) {
  const auto softer = [](double factor) {
    Tap tap{.noise_m = 2e-7, .seed = 3};
    tap.damping = kDamping * factor;
    return Record(tap);
  };
  const auto fit = FitAdapter({softer(0.95), softer(1.0), softer(1.05)}, {kMass, 0});
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->damping_birge_ratio, 3);
  EXPECT_ABS(fit->damping.value, kDamping, 2 * fit->damping.standard_uncertainty, "2 deviations");
  // three values of 0.95, 1, 1.05 have a mean with 0.05/sqrt(3); weights differ by some percent
  EXPECT_REL(fit->damping.standard_uncertainty, kDamping * 0.05 / std::sqrt(3.0), 0.1,
             "unequal weights");
}

// x'' = -2 d x' - q x (1 + (x/a)^2), by Runge and Kutta's fourth order
ImpulseRecord StiffeningRecord(double noise_m) {
  ImpulseRecord record = Record({});
  std::mt19937_64 engine(5);
  std::normal_distribution<double> noise(0, noise_m);
  const double q = kStiffness / kMass;
  const double d = kDamping / kMass / 2;
  const double scale = 1e-3;  // 0.05 m/s swing to 37 um: 0.05 % of the frequency
  const auto acceleration = [&](double x, double v) {
    return -2 * d * v - q * x * (1 + x * x / (scale * scale));
  };
  double x = 0;
  double v = 0.05;
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    record.voltage_v[n] = 1e-3 + x + noise(engine);
    if (record.start_s + static_cast<double>(n) * kStep < 0) {
      record.voltage_v[n] = 1e-3 + noise(engine);
      continue;
    }
    constexpr int kSteps = 4;
    const double h = kStep / kSteps;
    for (int k = 0; k < kSteps; ++k) {
      const double a1 = acceleration(x, v);
      const double a2 = acceleration(x + h / 2 * v, v + h / 2 * a1);
      const double a3 = acceleration(x + h / 2 * (v + h / 2 * a1), v + h / 2 * a2);
      const double a4 = acceleration(x + h * (v + h / 2 * a2), v + h * a3);
      x += h * (v + h / 6 * (a1 + a2 + a3));
      v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
  }
  return record;
}

TEST(AdapterFit, ASpringThatStiffensIsDoubted) {
  const auto fit = FitAdapter({StiffeningRecord(5e-8)}, {kMass, 0});
  ASSERT_TRUE(fit);
  const auto doubts = tests::DoubtsOf(fit->findings);
  EXPECT_THAT(doubts, ::testing::AnyOf(Contains(FindingKind::kStiffnessChangesLater),
                                       Contains(FindingKind::kManyImpacts)));
}

// noise that scatters the later part's damping by several percent is no change of it
TEST(AdapterFit, NoiseIsNoChangeOfTheDamping) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const AdapterFit fit = Fit({.noise_m = 3e-6, .seed = seed});
    EXPECT_FALSE(fit.findings.Has(FindingKind::kDampingChangesLater)) << seed;
  }
}

TEST(AdapterFit, WrongUnitsAreDoubted) {
  EXPECT_EQ(tests::NumberOf(Fit({.noise_m = 1e-6}, {4.6, 0}).findings,
                            FindingKind::kUnusualAdapterMass, "mass_kg"),
            4.6);
  auto record = Record({.noise_m = 1e-6});
  for (double& value : record.voltage_v) value *= 1e3;
  const auto in_mm = FitAdapter({record}, {kMass, 0});
  ASSERT_TRUE(in_mm);
  EXPECT_TRUE(in_mm->findings.Has(FindingKind::kUnusualAmplitude));
  record.step_s *= 1e3;
  const auto in_ms = FitAdapter({record}, {kMass, 0});
  ASSERT_TRUE(in_ms);
  EXPECT_TRUE(in_ms->findings.Has(FindingKind::kUnusualFrequency));
}

TEST(AdapterFit, WhatHoldsNoRingDownIsLeftOut) {
  ImpulseRecord flat = Record({});
  for (double& value : flat.voltage_v) value = 1e-3;
  const auto alone = FitAdapter({flat}, {kMass, 0});
  ASSERT_FALSE(alone);
  EXPECT_THAT(alone.error().Text(), ::testing::Not(HasSubstr("voltage")));
  const auto beside = FitAdapter({flat, Record({.noise_m = 1e-6})}, {kMass, 0});
  ASSERT_TRUE(beside);
  EXPECT_EQ(beside->left_out.size(), 1U);
  EXPECT_EQ(beside->taps.size(), 1U);
  ImpulseRecord two = Record({});
  two.voltage_v.resize(2);
  EXPECT_FALSE(FitAdapter({two}, {kMass, 0}));
  ImpulseRecord holes = Record({});
  for (double& value : holes.voltage_v) value = std::nan("");
  EXPECT_FALSE(FitAdapter({holes}, {kMass, 0}));
}

}  // namespace
}  // namespace haptometer::fit
