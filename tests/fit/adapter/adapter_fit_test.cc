#include "fit/adapter/adapter_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "fit/drop_test/ring_fit.h"
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
  double step_s = kStep;
  unsigned seed = 1;
};

double Decay(const Tap& tap) { return tap.damping / (2 * kMass); }
double Angular(const Tap& tap) { return std::sqrt(kStiffness / kMass - std::pow(Decay(tap), 2)); }

// the impulse response, written down here
ImpulseRecord Record(const Tap& tap) {
  ImpulseRecord record;
  record.name = "tap.bin";
  record.unit = "m";
  record.signal = RecordedSignal::kDisplacement;
  record.step_s = tap.step_s;
  record.start_s = -0.02;
  std::mt19937_64 engine(tap.seed);
  std::normal_distribution<double> noise;
  const int rows = static_cast<int>((tap.length_s + 0.02) / tap.step_s);
  for (int n = 0; n < rows; ++n) {
    const double t = record.start_s + n * tap.step_s;
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
  // Student's factor of two degrees of freedom is 4.303, a little less beside the taps' own noise
  const double factor =
      (fit->damping.upper - fit->damping.value) / fit->damping.combined_standard_uncertainty;
  EXPECT_LE(factor, 4.3031);
  EXPECT_GT(factor, 3.5);
  EXPECT_TRUE(fit->findings.Has(FindingKind::kTapsScatter));
}

// 0.1 % to 2 % of the spring's force at the first swing, of which 2 % end the motion
TEST(AdapterFit, DryFrictionOfADisplacementIsFittedAlong) {
  for (const double share : {0.001, 0.01, 0.02}) {
    ImpulseRecord record = Record({.length_s = 0.5});
    constexpr double kSwingM = 2e-4;
    const FrictionRing ring{
        .poles = {.decay_per_s = 0.1 / (2 * kMass), .stiffness_per_s2 = kStiffness / kMass},
        .even_v = 0,
        .odd_v_per_s = kSwingM * std::sqrt(kStiffness / kMass),
        .friction = share * kSwingM,
        .signal = RecordedSignal::kDisplacement};
    std::mt19937_64 engine(3);
    std::normal_distribution<double> noise(0, 1e-8);
    std::vector<double> times_s(record.voltage_v.size() - 50);
    for (std::size_t n = 0; n < times_s.size(); ++n) times_s[n] = static_cast<double>(n) * kStep;
    const std::vector<double> motion = MotionWithFriction(ring, times_s);
    for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
      record.voltage_v[n] = noise(engine) + (n < 50 ? 0 : motion[n - 50]);
    }
    const auto fit = FitAdapter({record}, {kMass, 0});
    ASSERT_TRUE(fit) << share;
    EXPECT_ABS(fit->stiffness.value, kStiffness, 4 * fit->stiffness.standard_uncertainty,
               "four deviations");
    EXPECT_REL(fit->stiffness.value, kStiffness, 1e-5, "noise of 1e-8 m in a swing of 2e-4 m");
  }
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

// a tap whose decay rate grows by 2 decay_bend t, and its angular frequency by 2 phase_bend t
ImpulseRecord Bent(const Tap& tap, double decay_bend, double phase_bend) {
  ImpulseRecord record = Record(tap);
  std::mt19937_64 engine(9);
  std::normal_distribution<double> noise(0, tap.noise_m);
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    const double t = record.start_s + static_cast<double>(n) * kStep;
    const double swing = std::exp(-Decay(tap) * t - decay_bend * t * t) *
                         std::sin(Angular(tap) * t + phase_bend * t * t);
    record.voltage_v[n] =
        1e-3 + noise(engine) + (t > 0 ? tap.speed_m_per_s / Angular(tap) * swing : 0);
  }
  return record;
}

std::optional<double> ShareOf(const ImpulseRecord& record, FindingKind kind) {
  const auto fit = FitAdapter({record}, {kMass, 0});
  EXPECT_TRUE(fit) << fit.error().Text();
  if (!fit || !fit->findings.Has(kind)) return std::nullopt;
  return tests::NumberOf(fit->findings, kind, "share");
}

// the share of the least change that is reported, of records that bend from not at all to `most`
double LeastShare(const std::function<ImpulseRecord(double)>& record_at, double most,
                  FindingKind kind) {
  EXPECT_FALSE(ShareOf(record_at(0), kind));
  double silent = 0;
  double named = most;
  double share = 0;
  for (int halving = 0; halving < 12; ++halving) {
    const double middle = (silent + named) / 2;
    const auto found = ShareOf(record_at(middle), kind);
    (found ? named : silent) = middle;
    if (found) share = *found;
  }
  return share;
}

// By Cramer and Rao, the noise of these three tests leaves the difference of both fits uncertain to
// a fifth or a sixth of the change: it is beyond 4 deviations, and too faint for another impact.
// The damping falls: one that grows while the amplitude falls is dry friction's.
TEST(AdapterFit, AChangeOfTheDampingIsReportedFromTwoPercentOn) {
  const double share = LeastShare([](double bend) { return Bent({.noise_m = 5e-7}, -bend, 0); },
                                  0.3, FindingKind::kDampingChangesLater);
  EXPECT_LE(share, -0.02);
  EXPECT_GT(share, -0.02 * 1.005) << "the share goes with the bend, which is halved 12 times";
}

TEST(AdapterFit, AChangeOfTheStiffnessIsReportedFromATenThousandthOn) {
  const double share = LeastShare([](double bend) { return Bent({.noise_m = 1.5e-6}, 0, bend); }, 1,
                                  FindingKind::kStiffnessChangesLater);
  EXPECT_GE(share, 1e-4);
  EXPECT_LT(share, 1e-4 * 1.005) << "the share goes with the bend, which is halved 12 times";
}

TEST(AdapterFit, TheLaterPartBeginsHalfADecayTimeLaterOrAtAThird) {
  const auto skipped_s = [](double damping, double bend) {
    const auto fit = FitAdapter({Bent({.noise_m = 5e-7, .damping = damping}, bend, 0)}, {kMass, 0});
    EXPECT_TRUE(fit);
    return tests::NumberOf(fit->findings, FindingKind::kDampingChangesLater, "skipped_s");
  };
  // d = 10.87 1/s: half of its reciprocal is 46 ms of 1 s
  EXPECT_REL(skipped_s(10 * kDamping, -3.5), kMass / (10 * kDamping), 0.1,
             "the bend moves d by 5 %");
  // d = 1.087 1/s: half of its reciprocal is 0.46 s, of 1 s less an eighth of a period
  EXPECT_ABS(skipped_s(kDamping, -0.07), (1 - 1 / (8 * 212.5)) / 3, 2 * kStep, "two samples");
}

TEST(AdapterFit, AStrongTapDoesNotSpeakForOthersThatDiffer) {
  // 5 % apart, uncertain to 0.2 % and 1.6 %: weighted by these alone, the mean is the strong one's
  const Tap strong{.noise_m = 3e-7, .damping = 0.95 * kDamping, .seed = 31};
  const Tap weak{.noise_m = 24e-7, .damping = 1.05 * kDamping, .seed = 32};
  const auto fit = FitAdapter({Record(strong), Record(weak)}, {kMass, 0});
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->findings.Has(FindingKind::kTapsScatter));
  EXPECT_REL(fit->damping.value, kDamping, 0.015, "the weak tap's uncertainty");
  EXPECT_REL(fit->damping.standard_uncertainty, 0.05 * kDamping, 0.25, "half the distance");
  EXPECT_LT(fit->damping.lower, 0.95 * kDamping);
  EXPECT_GT(fit->damping.upper, 1.05 * kDamping);
}

TEST(AdapterFit, TapsAreAveragedByTheReciprocalsOfTheirVariances) {
  // a quiet tap and a noisy one, alike and 1 % apart in damping
  for (const double factor : {1.0, 1.01}) {
    const Tap quiet{.noise_m = 3e-7, .seed = 21};
    const Tap noisy{.noise_m = 9e-7, .damping = factor * kDamping, .seed = 22};
    const AdapterFit first = Fit(quiet);
    const AdapterFit second = Fit(noisy);
    const auto both = FitAdapter({Record(quiet), Record(noisy)}, {kMass, 0});
    ASSERT_TRUE(both);
    const auto expect = [&](const FittedValue AdapterFit::* member, double birge_ratio) {
      const FittedValue& one = first.*member;
      const FittedValue& other = second.*member;
      const double u = one.standard_uncertainty / one.value;
      const double v = other.standard_uncertainty / other.value;
      const double apart = std::log(other.value / one.value);
      const FittedValue& mean = (*both).*member;
      // what the noise does not explain is a variance of both
      const double between = std::max(apart * apart - u * u - v * v, 0.0) / 2;
      const double first_variance = u * u + between;
      const double second_variance = v * v + between;
      const double share = first_variance / (first_variance + second_variance);
      EXPECT_REL(std::log(mean.value / one.value), apart * share, 1e-6,
                 "rounding of logarithms near 0");
      // chi^2 of two values about their mean
      const double ratio = std::abs(apart) / std::hypot(u, v);
      EXPECT_REL(birge_ratio, ratio, 1e-6, "the same");
      EXPECT_REL(mean.standard_uncertainty / mean.value, std::sqrt(second_variance * share), 1e-9,
                 "closed form");
    };
    expect(&AdapterFit::stiffness, both->stiffness_birge_ratio);
    expect(&AdapterFit::damping, both->damping_birge_ratio);
  }
}

TEST(AdapterFit, WhatFollowsFromKaAndBaHasTheirUncertainties) {
  const AdapterFit fit = Fit({.noise_m = 1e-6}, {kMass, 0.02 * kMass});
  const auto share = [](const FittedValue& value) {
    return value.combined_standard_uncertainty / value.value;
  };
  const double of_stiffness = fit.stiffness.standard_uncertainty / fit.stiffness.value;
  const double of_damping = fit.damping.standard_uncertainty / fit.damping.value;
  EXPECT_REL(share(fit.stiffness), std::hypot(of_stiffness, 0.02), 1e-9, "Ka = M q");
  EXPECT_REL(share(fit.damping), std::hypot(of_damping, 0.02), 1e-9, "Ba = 2 M d");
  EXPECT_REL(share(fit.stiffness_over_mass), of_stiffness, 1e-9, "q alone");
  EXPECT_REL(share(fit.damping_over_mass), of_damping, 1e-9, "2 d alone");
  EXPECT_REL(share(fit.natural_frequency), of_stiffness / 2, 1e-9, "the root of q");
  EXPECT_REL(share(fit.quality_factor), std::hypot(of_stiffness / 2, of_damping), 1e-9,
             "the root of q over 2 d");
}

TEST(AdapterFit, TheLimitOfADecayThatIsNotSeenIsTheIntervalsUpperEnd) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const AdapterFit fit = Fit({.length_s = 0.04, .noise_m = 2e-6, .seed = seed}, {kMass, 1e-4});
    if (fit.damping.determined) continue;
    EXPECT_REL(*fit.damping.at_most,
               fit.damping.value + 1.96 * fit.damping.combined_standard_uncertainty, 1e-9,
               "a normal distribution's 95 %");
  }
}

// the kinds of doubt about a tap of this amplitude where the fit begins, quality factor and mass
std::vector<FindingKind> DoubtsAbout(double amplitude_m, double quality, double mass_kg) {
  Tap tap;
  tap.damping = std::sqrt(kStiffness * kMass) / quality;
  const double lost = std::exp(-Decay(tap) / (8 * 212.5));
  tap.speed_m_per_s = amplitude_m * Angular(tap) / lost;
  return tests::DoubtsOf(Fit(tap, {mass_kg, 0}).findings);
}

TEST(AdapterFit, WhatIsUnlikeAnAdapterIsDoubtedAtTheEndsOfItsRange) {
  const auto only = [](FindingKind kind) { return std::vector{kind}; };
  for (const double quality : {1980.0, 100.0}) {
    EXPECT_THAT(DoubtsAbout(1e-4, quality, 4.6e-3), IsEmpty()) << quality;
  }
  EXPECT_EQ(DoubtsAbout(1e-4, 2020, 4.6e-3), only(FindingKind::kUnusualQuality));
  EXPECT_THAT(DoubtsAbout(0.0199, 600, 4.6e-3), IsEmpty());
  EXPECT_EQ(DoubtsAbout(0.0201, 600, 4.6e-3), only(FindingKind::kUnusualAmplitude));
  EXPECT_THAT(DoubtsAbout(1.01e-8, 600, 4.6e-3), IsEmpty());
  EXPECT_EQ(DoubtsAbout(0.99e-8, 600, 4.6e-3), only(FindingKind::kUnusualAmplitude));
  EXPECT_THAT(DoubtsAbout(1e-4, 600, 0.0999), IsEmpty());
  EXPECT_EQ(DoubtsAbout(1e-4, 600, 0.1001), only(FindingKind::kUnusualAdapterMass));
}

TEST(AdapterFit, ATapInAnotherUnitIsDoubtedWithItsUnit) {
  auto record = Record({.noise_m = 1e-6});
  record.unit = "V";
  const auto fit = FitAdapter({record}, {kMass, 0});
  ASSERT_TRUE(fit);
  EXPECT_EQ(tests::NumberOf<std::string>(fit->findings, FindingKind::kNoDisplacement, "unit"), "V");
  EXPECT_FALSE(fit->findings.Has(FindingKind::kUnusualAmplitude));
}

TEST(AdapterFit, ATapIsReportedWithItsOwnTimesAndSizes) {
  const Tap tap{.noise_m = 1e-6};
  const AdapterFit fit = Fit(tap);
  ASSERT_EQ(fit.taps.size(), 1U);
  const FittedTap& tap_fit = fit.taps[0];
  const double eighth_s = 1 / (8 * 212.495);
  EXPECT_ABS(tap_fit.first_s, eighth_s, 2 * kStep,
             "the impact and an eighth of a period, in samples");
  EXPECT_ABS(tap_fit.end_s, 1.0, 2 * kStep, "the record's end");
  EXPECT_EQ(tap_fit.samples,
            static_cast<std::size_t>(std::lround((tap_fit.end_s - tap_fit.first_s) / kStep)));
  EXPECT_REL(tap_fit.natural_frequency_hz, 212.49471935474193, 1e-4, "noise");
  EXPECT_REL(tap_fit.decay_per_s, Decay(tap), 0.05, "noise");
  EXPECT_REL(tap_fit.amplitude,
             tap.speed_m_per_s / Angular(tap) * std::exp(-Decay(tap) * tap_fit.first_s), 0.01,
             "noise");
  EXPECT_REL(tap_fit.residual_rms, 1e-6, 0.06, "four deviations of 2500 samples");
}

// Ka goes with the square of the rate, Ba with the rate
TEST(AdapterFit, AnUncertainTimeScaleWidensBothConstants) {
  auto record = Record({});
  const AdapterFit exact = FitAdapter({record}, {kMass, 0}).value();
  record.time_scale = Quantity{1, 0.01};
  const AdapterFit fit = FitAdapter({record}, {kMass, 0}).value();
  const auto added = [](const FittedValue& wide, const FittedValue& narrow) {
    return std::sqrt(std::pow(wide.standard_uncertainty, 2) -
                     std::pow(narrow.standard_uncertainty, 2)) /
           wide.value;
  };
  EXPECT_REL(added(fit.stiffness, exact.stiffness), 0.02, 1e-3, "of a logarithm, to first order");
  EXPECT_REL(added(fit.damping, exact.damping), 0.01, 1e-3, "of a logarithm, to first order");
}

TEST(AdapterFit, UncertaintiesOfFewPeriodsAreThoseOfEachParameter) {
  // the offset and a part of a period take up more of one parameter than of the other
  const Tap tap{.length_s = 0.02, .noise_m = 1e-7, .damping = std::sqrt(kStiffness * kMass) / 6};
  const auto record = Record(tap);
  const AdapterFit fit = Fit(tap);
  ASSERT_EQ(fit.taps.size(), 1U);
  const auto sample = [&](double time_s) {
    return static_cast<std::size_t>(std::lround((time_s - record.start_s) / kStep));
  };
  const auto samples = BlocksOf(record, sample(fit.taps[0].first_s), sample(fit.taps[0].end_s), 1);
  const RingFit ring = FitRing(samples, {Decay(tap), kStiffness / kMass}, {});
  // of two pole parameters, two amplitudes and the offset
  const double variance = fit.taps[0].density.ratio * ring.Squares() /
                          (static_cast<double>(samples.values_v.size()) - 5);
  const double of_decay = ring.Deviation(0, variance);
  const double of_stiffness = ring.Deviation(1, variance);
  EXPECT_REL(fit.damping.standard_uncertainty / fit.damping.value, of_decay, 1e-6,
             "the solver's end");
  EXPECT_REL(fit.stiffness.standard_uncertainty / fit.stiffness.value, of_stiffness, 1e-6,
             "the solver's end");
  // ln d and ln q in units of d and of w, where both are alike of many periods
  const double per_rate =
      of_decay * Decay(tap) / (of_stiffness * std::sqrt(kStiffness / kMass) / 2);
  EXPECT_GT(std::abs(per_rate - 1), 0.01) << "else both could be exchanged";
}

TEST(AdapterFit, WithoutARecordThereIsNoFit) {
  const auto fit = FitAdapter({}, {kMass, 0});
  ASSERT_FALSE(fit);
  EXPECT_THAT(fit.error().Text(), HasSubstr("no record of a tap is given"));
}

TEST(AdapterFit, MoreThanTwentyThousandSamplesAreAveragedTo32APeriod) {
  struct Row {
    double step_s;
    double length_s;
    double damping;
    std::size_t block;  // samples
  };
  // 117.65 samples a period of 4.7060 ms: 3 in a block, up to 20000 none; and periods of 11.8
  for (const Row& row : {Row{4e-5, 0.82, kDamping, 3}, Row{4e-5, 0.79, kDamping, 1},
                         Row{4e-4, 8.2, kDamping / 5, 1}}) {
    const Tap tap{
        .length_s = row.length_s, .noise_m = 1e-7, .damping = row.damping, .step_s = row.step_s};
    const AdapterFit fit = Fit(tap);
    ASSERT_EQ(fit.taps.size(), 1U);
    const auto samples = std::lround((fit.taps[0].end_s - fit.taps[0].first_s) / row.step_s);
    EXPECT_EQ(samples > 20000, row.length_s > 0.8);
    EXPECT_EQ(fit.taps[0].samples, static_cast<std::size_t>(samples) / row.block);
    EXPECT_REL(fit.taps[0].residual_rms, 1e-7 / std::sqrt(row.block), 0.03,
               "three deviations of 7000 blocks");
    EXPECT_ABS(fit.damping.value, row.damping, 4 * fit.damping.standard_uncertainty,
               "four deviations");
    EXPECT_ABS(fit.stiffness.value, kStiffness, 4 * fit.stiffness.standard_uncertainty,
               "four deviations");
  }
}

}  // namespace
}  // namespace haptometer::fit
