#include "fit/drop_test/consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/ring_fit.h"
#include "fit/residuals.h"
#include "tests/findings.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using tests::MakeRecord;
using tests::SyntheticDrop;

DropTestFit Fit(const std::vector<ImpulseRecord>& records) {
  const auto fit = FitDropTest(records, tests::ThesisKnowns());
  EXPECT_TRUE(fit) << fit.error().Text();
  return fit.value_or(DropTestFit{});
}

// `count` drops with 1 % of noise; `vary` changes each by its number
std::vector<ImpulseRecord> Drops(unsigned count, unsigned seed,
                                 const std::function<void(SyntheticDrop&, unsigned)>& vary) {
  std::vector<ImpulseRecord> records;
  for (unsigned k = 0; k < count; ++k) {
    SyntheticDrop drop;
    drop.step_s = 4e-4;
    drop.noise_v = 0.01 * tests::SpeedVoltage(drop);
    drop.seed = 100 * seed + k + 1;
    vary(drop, k);
    records.push_back(MakeRecord(drop));
  }
  return records;
}

TEST(Consistency, DropsOfOneActuatorAgree) {
  constexpr unsigned kSets = tests::kIsSanitized ? 4 : 50;
  int scattered = 0;
  int doubted = 0;
  for (unsigned k = 0; k < kSets; ++k) {
    const DropTestFit fit = Fit(Drops(4, k, [](SyntheticDrop&, unsigned) {}));
    scattered += fit.frequency_birge_ratio > 1 || fit.decay_birge_ratio > 1 ? 1 : 0;
    doubted += tests::DoubtsOf(fit.findings).empty() ? 0 : 1;
  }
  // two tests a set at 1 %: 1 expected, more than 5 in 1 of 2000 runs
  EXPECT_LE(scattered, 5);
  EXPECT_LE(doubted - scattered, 1) << "400 differences at 4 deviations: 0.03 expected";
}

TEST(Consistency, ScatterBeyondTheNoiseWidensWhatItConcerns) {
  // resonances 0.2 % apart, ten times what the noise makes of them; decays alike
  const auto records = Drops(4, 1, [](SyntheticDrop& drop, unsigned k) {
    drop.stiffness_n_per_m *= 1 + 0.002 * (k % 2 == 0 ? 1 : -1);
  });
  const DropTestFit fit = Fit(records);
  EXPECT_GT(fit.frequency_birge_ratio, 10);
  EXPECT_EQ(fit.decay_birge_ratio, 1);
  EXPECT_TRUE(fit.findings.Has(FindingKind::kFrequenciesScatter));
  // the mean of four values +-0.2 % off, as if drawn from such: 0.23 % / sqrt(4)
  EXPECT_REL(fit.stiffness.standard_uncertainty / 2800, 0.002 / std::sqrt(3.0), 0.2,
             "of drops that are weighted alike");
  // Student's factor of three degrees of freedom is 3.182, within 1/10^2 of which the noise lies
  EXPECT_REL(std::log(fit.stiffness.upper / fit.stiffness.value) * 2800 /
                 fit.stiffness.standard_uncertainty,
             3.182446, 0.02, "an interval of the logarithm; and the Birge ratio above 10");
}

// a drop beside what it would be by its own poles
ComparedDrop Beside(const PreparedRecord& prepared) {
  return {.prepared = &prepared, .load_ohm = tests::kOpen, .expected = prepared.part.poles};
}

// v = Km x' of x'' + 2 d x' + w^2 x (1 + cubic x^2) + friction sign(x') = 0, by Runge and Kutta
ImpulseRecord Nonlinear(double cubic_per_m2, double friction_m_per_s2) {
  ImpulseRecord record = MakeRecord({});
  constexpr double kW2 = 2e6;
  constexpr double kTwiceDecay = 23;
  const auto slope = [&](double x, double v) {
    return -kTwiceDecay * v - kW2 * x * (1 + cubic_per_m2 * x * x) -
           friction_m_per_s2 * (v > 0 ? 1 : -1);
  };
  double x = 0;
  double v = std::sqrt(0.02 * 9.80665);
  std::mt19937_64 engine(3);
  std::normal_distribution<double> noise(0, 1e-3);
  constexpr int kSteps = 20;
  const double h = record.step_s / kSteps;
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    const double t = record.start_s + static_cast<double>(n) * record.step_s;
    record.voltage_v[n] = noise(engine) + (t < 0 ? 0 : v);
    for (int k = 0; t >= 0 && k < kSteps; ++k) {
      const double a1 = slope(x, v);
      const double a2 = slope(x + h / 2 * v, v + h / 2 * a1);
      const double a3 = slope(x + h / 2 * v + h * h / 4 * a1, v + h / 2 * a2);
      const double a4 = slope(x + h * v + h * h / 2 * a2, v + h * a3);
      x += h * v + h * h / 6 * (a1 + a2 + a3);
      v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
  }
  return record;
}

TEST(Consistency, ASpringThatStiffensAndFrictionAreNamed) {
  EXPECT_THAT(tests::DoubtsOf(Fit({Nonlinear(0, 0)}).findings), IsEmpty());
  // travel is 0.31 mm: 1 % more stiffness there
  EXPECT_TRUE(Fit({Nonlinear(1e5, 0)}).findings.Has(FindingKind::kSpringStiffens));
  EXPECT_TRUE(Fit({Nonlinear(-1e5, 0)}).findings.Has(FindingKind::kSpringSoftens));
}

TEST(Consistency, FrictionIsFittedAlongAndItsIntervalsHold) {
  // 1 m/s^2 is 0.16 % of the spring's force at the first peak: part of the model, so no doubt
  for (const double friction_m_per_s2 : {0.4, 1.0, 6.0}) {
    const auto fit = Fit({Nonlinear(0, friction_m_per_s2)});
    ASSERT_FALSE(fit.records.empty());
    EXPECT_TRUE(fit.records[0].found.Has(FindingKind::kDryFriction));
    EXPECT_THAT(tests::DoubtsOf(fit.findings), IsEmpty());
    EXPECT_LE(fit.damping.lower, 0.0322) << friction_m_per_s2;
    EXPECT_GE(fit.damping.upper, 0.0322) << friction_m_per_s2;
    EXPECT_LE(fit.stiffness.lower, 2800) << friction_m_per_s2;
    EXPECT_GE(fit.stiffness.upper, 2800) << friction_m_per_s2;
    // not by an interval that holds everything: friction taken as damping is 5 to 75 % off
    EXPECT_LT(fit.damping.upper - fit.damping.lower, 0.1 * 0.0322) << friction_m_per_s2;
  }
}

// variance of d and of w of A e^(-d t) cos(w t + p) over a length T in white noise s:
// (2 s^2 dt/A^2) I0/(I0 I2 - I1^2), I_k the integrals of t^k e^(-2 d t)
double RateDeviation(double amplitude, double decay, double length_s, double step_s, double noise) {
  const double x = 2 * decay * length_s;
  const double left = std::exp(-x);
  const double i0 = (1 - left) / (2 * decay);
  const double i1 = (1 - left * (1 + x)) / std::pow(2 * decay, 2);
  const double i2 = (2 - left * (2 + 2 * x + x * x)) / std::pow(2 * decay, 3);
  return std::sqrt(2 * step_s * i0 / (i0 * i2 - i1 * i1)) * noise / amplitude;
}

TEST(Consistency, FrictionWidensByWhatIsLeftOpenOfIt) {
  // 6 m/s^2 over the spring's 2e6 x at the first swing of v0/w: a share f of 0.0096
  const auto prepared = PrepareRecord(Nonlinear(0, 6));
  ASSERT_TRUE(prepared) << prepared.error().Text();
  const double speed = std::sqrt(0.02 * 9.80665);
  const double w = std::sqrt(2e6);
  const double share = 6 / (w * speed);
  EXPECT_REL(tests::NumberOf(prepared->part.found, FindingKind::kDryFriction, "share"), share, 0.03,
             "an eighth of a period later the swing is 1 % less");
  const Consistency found = CheckConsistency({Beside(*prepared)});
  // its part in the first swing's decay, of which a fiftieth is left open, and 1e-4 in the
  // frequency; against the linear motion's own uncertainties, which are 1 % of that
  const double taken = 2 * share / M_PI / (11.5 / w);
  const double rate = RateDeviation(speed, 11.5, 0.25, prepared->record.step_s, 1e-3);
  EXPECT_REL(found.decay_widening, 0.02 * taken / (rate / 11.5), 0.06,
             "noise of 1240 samples, and an eighth of a period");
  EXPECT_REL(found.frequency_widening, 1e-4 * taken / (rate / w), 0.06,
             "noise of 1240 samples, and an eighth of a period");
}

TEST(Consistency, ADropThatItsOwnFitExplainsMuchBetterIsOfAnother) {
  SyntheticDrop drop;
  drop.noise_v = 3e-3;
  const auto prepared = PrepareRecord(MakeRecord(drop));
  ASSERT_TRUE(prepared);
  // both noises are estimated from some 1240 samples, blocks of one
  const auto samples = static_cast<double>(prepared->part.end_sample - prepared->part.first_sample);
  const double limit = 1.1 + 4 / std::sqrt(2 * samples);
  const auto ratio_at = [&](double noise_v) {
    Consistency found = CheckConsistency({Beside(*prepared)});
    DoubtStatements({Beside(*prepared)}, {noise_v}, found);
    return tests::NumberOf(found.findings, FindingKind::kRecordOfAnother, "ratio");
  };
  double alike = 3e-3;
  double apart = 6e-3;
  EXPECT_EQ(ratio_at(alike), 0);
  EXPECT_REL(ratio_at(apart), 2.0, 0.1, "the noise of 1240 samples");
  double least = 0;
  for (int halving = 0; halving < 12; ++halving) {
    const double middle = (alike + apart) / 2;
    const double ratio = ratio_at(middle);
    (ratio > 0 ? apart : alike) = middle;
    if (ratio > 0) least = ratio;
  }
  EXPECT_REL(least, limit, 2e-3, "halved 12 times");
}

TEST(Consistency, BelowAMillionthOfTheRingingNoNoiseIsAnothers) {
  const auto prepared = PrepareRecord(MakeRecord({}));
  ASSERT_TRUE(prepared);
  const double ringing_v =
      std::sqrt(0.02 * 9.80665) *
      std::exp(-11.5 * static_cast<double>(prepared->start.first_sample) * 2e-4 + 11.5 * 0.01);
  const auto is_of_another = [&](double noise_v) {
    Consistency found = CheckConsistency({Beside(*prepared)});
    DoubtStatements({Beside(*prepared)}, {noise_v}, found);
    return found.findings.Has(FindingKind::kRecordOfAnother);
  };
  EXPECT_FALSE(is_of_another(0.995e-6 * ringing_v));
  EXPECT_TRUE(is_of_another(1.005e-6 * ringing_v));
}

// the fit of a drop's samples from one on, and the variance that its residuals have at the
// resonance
struct PartFit {
  RingFit fit;
  double variance = 0;

  [[nodiscard]] double logarithm() const { return 0.5 * std::log(fit.poles.stiffness_per_s2); }
  [[nodiscard]] double deviation() const { return 0.5 * fit.Deviation(1, variance); }
};

PartFit FitFrom(const PreparedRecord& prepared, std::size_t first, const PolePair& start) {
  const auto samples = BlocksOf(prepared.record, first, prepared.part.end_sample, 1);
  PartFit part{FitRing(samples, start, prepared.part.background)};
  const auto density = DensityAt(part.fit.jacobian.residuals, samples.step_s,
                                 std::sqrt(start.stiffness_per_s2) / (2 * std::numbers::pi));
  part.variance = part.fit.Squares() / (static_cast<double>(samples.values_v.size()) - 5) *
                  (density.is_coloured ? density.ratio : 1);
  return part;
}

TEST(Consistency, AChangeOfTheFrequencyWidensByItsShare) {
  for (const double cubic_per_m2 : {2e4, -2e4}) {
    const auto prepared = PrepareRecord(Nonlinear(cubic_per_m2, 0));
    ASSERT_TRUE(prepared) << prepared.error().Text();
    const Consistency found = CheckConsistency({Beside(*prepared)});
    // the whole, and what begins a decay time later
    const std::size_t first = prepared->part.first_sample;
    const PartFit whole = FitFrom(*prepared, first, prepared->part.poles);
    const double decay_samples = 1 / (whole.fit.poles.decay_per_s * prepared->record.step_s);
    const PartFit later =
        FitFrom(*prepared, first + static_cast<std::size_t>(decay_samples), whole.fit.poles);
    const double share = later.logarithm() - whole.logarithm();
    EXPECT_EQ(share < 0, cubic_per_m2 > 0);
    EXPECT_REL(found.frequency_widening, std::hypot(1.0, share / whole.deviation()), 1e-4,
               "the solver's end");
    const double noise_ratio = std::min(std::sqrt(later.variance / whole.variance), 1.0);
    EXPECT_LT(noise_ratio, 0.9) << "what does not fit is in the whole's noise";
    const double deviations =
        std::abs(share) /
        std::sqrt(std::pow(later.deviation(), 2) - std::pow(noise_ratio * whole.deviation(), 2));
    const auto kind = share < 0 ? FindingKind::kSpringStiffens : FindingKind::kSpringSoftens;
    EXPECT_REL(tests::NumberOf(found.findings, kind, "share"), share, 1e-4, "the solver's end");
    EXPECT_EQ(tests::NumberOf<std::int64_t>(found.findings, kind, "deviations"),
              std::lround(deviations));
  }
}

TEST(Consistency, TwoDropsScatterByTheirDifferenceInItsOwnUncertainty) {
  // 0.25 % apart in frequency, with noises of 2 and 6 mV
  SyntheticDrop low;
  low.noise_v = 2e-3;
  SyntheticDrop high;
  high.stiffness_n_per_m *= 1.005;
  high.noise_v = 6e-3;
  high.seed = 2;
  const auto first = PrepareRecord(MakeRecord(low));
  const auto second = PrepareRecord(MakeRecord(high));
  ASSERT_TRUE(first && second);
  const double w = std::sqrt(2e6);
  const auto deviation = [&](const SyntheticDrop& drop) {
    return RateDeviation(tests::SpeedVoltage(drop), 11.5, 0.25, drop.step_s, drop.noise_v) / w;
  };
  const double ratio = std::log(1.005) / 2 / std::hypot(deviation(low), deviation(high));
  ASSERT_GT(ratio, 10);
  const PolePair expected{11.5, 2e6};
  std::vector<ComparedDrop> drops{{.prepared = &*first, .load_ohm = 33, .expected = expected},
                                  {.prepared = &*second, .load_ohm = 33, .expected = expected}};
  const Consistency found = CheckConsistency(drops);
  EXPECT_REL(found.frequency.birge_ratio, ratio, 0.06, "noise of 1240 samples, and its scatter");
  EXPECT_EQ(found.frequency.degrees, 1);
  EXPECT_EQ(found.decay.birge_ratio, 1);
  // of ln Kv: d^2 = u1^2 + u2^2 + 2 t^2; with Student's 12.7 in place of 1.96
  const double noise = 4 * (std::pow(deviation(low), 2) + std::pow(deviation(high), 2));
  const double square = std::pow(std::log(1.005), 2);
  EXPECT_REL(found.frequency.deviation, std::sqrt((square - noise) / 2), 0.02,
             "noise: 0.01 of the difference each");
  EXPECT_REL(found.frequency.student_deviation,
             std::sqrt((square * std::pow(12.7062 / 1.96, 2) - noise) / 2), 0.02, "the same");
  EXPECT_REL(tests::NumberOf(found.findings, FindingKind::kFrequenciesScatter, "birge_ratio"),
             found.frequency.birge_ratio, 1e-12, "the same");
  EXPECT_REL(tests::NumberOf(found.findings, FindingKind::kFrequenciesScatter, "scatter"),
             found.frequency.deviation, 1e-12, "the same");
  // the start of the fit of all
  EXPECT_REL(found.drops[1].stiffness, std::log(1.005), 0.01, "noise");
  // with another load only the frequencies are compared; where the added masses show the mover's,
  // these neither
  auto apart = drops;
  apart[1].load_ohm = 34;
  EXPECT_GT(CheckConsistency(apart).frequency.birge_ratio, 10);
  EXPECT_EQ(CheckConsistency(apart).decay.deviation, 0);
  EXPECT_EQ(CheckConsistency(apart).decay.student_deviation, 0);
  apart[1].added_mass_kg = 0.1e-3;
  EXPECT_EQ(CheckConsistency(apart).frequency.birge_ratio, 1);
  EXPECT_EQ(CheckConsistency(apart).frequency.student_deviation, 0);
}

TEST(Consistency, TheDecaysScatterIsThatOfTheDampingsShare) {
  // 2 % apart in the decay, of which the coil has three quarters: 8 % of Bv
  std::vector<PreparedRecord> prepared;
  for (const double factor : {1.0, 1.02}) {
    SyntheticDrop drop;
    drop.damping_n_s_per_m *= factor;
    prepared.push_back(*PrepareRecord(MakeRecord(drop)));
  }
  std::vector<ComparedDrop> drops{Beside(prepared[0]), Beside(prepared[1])};
  for (ComparedDrop& drop : drops) {
    drop.expected = {11.5, 2e6};
    drop.damping_share = 0.25;
  }
  const Consistency found = CheckConsistency(drops);
  EXPECT_REL(found.decay.deviation, 4 * std::log(1.02) / std::sqrt(2.0), 1e-3, "no noise");
  EXPECT_REL(found.drops[1].damping - found.drops[0].damping, 4 * std::log(1.02), 1e-3, "no noise");
}

TEST(Consistency, TheNoiseOfSomeDropsDoesNotHideTheScatterOfOthers) {
  // of two open drops and two loaded ones of ten times the noise, either pair is apart in the decay
  for (const bool open_scatter : {true, false}) {
    std::vector<PreparedRecord> prepared;
    for (unsigned k = 0; k < 4; ++k) {
      SyntheticDrop drop;
      drop.seed = k + 1;
      drop.noise_v = k < 2 ? 1e-3 : 1e-2;
      if (k == (open_scatter ? 1 : 3)) drop.damping_n_s_per_m *= open_scatter ? 1.02 : 1.18;
      prepared.push_back(*PrepareRecord(MakeRecord(drop)));
    }
    std::vector<ComparedDrop> drops;
    for (const auto& one : prepared) drops.push_back(Beside(one));
    for (ComparedDrop& drop : drops) drop.expected = {11.5, 2e6};
    for (const std::size_t k : {2UZ, 3UZ}) drops[k].load_ohm = 33;
    const DropScatter found = CheckConsistency(drops).decay;
    // d^2 = u1^2 + u2^2 + 2 t^2 of the open pair alone; 2 degrees of freedom of both
    EXPECT_EQ(found.degrees, open_scatter ? 1 : 2);
    if (open_scatter) {
      EXPECT_REL(found.deviation, std::log(1.02) / std::sqrt(2.0), 0.2, "noise of 0.2 %");
    } else {
      EXPECT_GT(found.deviation, 0.01);
    }
  }
}

// the records that are refused
std::vector<std::string> Refused(const Findings& findings) {
  std::vector<std::string> refused;
  for (const Finding& finding : findings.list()) {
    if (finding.severity == Severity::kRefusal) refused.push_back(finding.subject);
  }
  return refused;
}

// four drops, of which the strong one has other constants than the mean of all
std::vector<ImpulseRecord> StrongOneApart(double stiffness, double damping) {
  // of mean 1 with the strong one's 1 + x: the others' scatter as much
  constexpr std::array kShares{1.0, -1.2, 0.6, -0.4};
  return Drops(4, 7, [&](SyntheticDrop& drop, unsigned k) {
    drop.stiffness_n_per_m *= 1 + stiffness * kShares[k];
    drop.damping_n_s_per_m *= 1 + damping * kShares[k];
    if (k > 0) drop.height_m /= 64;  // an eighth of the voltage, in the same noise
    drop.noise_v = 2e-3;
  });
}

TEST(Consistency, AStrongDropsOwnScatterIsInTheIntervals) {
  // 1 % in the stiffness and 2 % in the damping, beside noises of 0.003 % and 0.1 % of the strong
  // one: weighted by the noise alone, the mean is the strong one's, as surely as its noise is low
  const DropTestFit fit = Fit(StrongOneApart(0.01, 0.02));
  EXPECT_THAT(Refused(fit.findings), IsEmpty());
  EXPECT_TRUE(fit.findings.Has(FindingKind::kFrequenciesScatter));
  for (const auto& [value, truth, scatter] :
       {std::tuple(fit.stiffness, 2800.0, 0.01), {fit.damping, 0.0322, 0.02}}) {
    EXPECT_LT(value.lower, truth);
    EXPECT_GT(value.upper, truth);
    // sqrt(sum of the squared shares/3), over sqrt(4)
    const double deviation = scatter * std::sqrt((1 + 1.44 + 0.36 + 0.16) / 3) / 2;
    EXPECT_REL(value.standard_uncertainty / truth, deviation, 0.35,
               "the weak drops' noise is 0.4 of the dampings' scatter");
    EXPECT_LT((value.upper - value.lower) / truth, 2 * 4 * deviation) << "t(3) = 3.18";
  }
}

TEST(Consistency, TwoPercentBetweenTheDampingsIsNoOtherActuator) {
  const auto records = Drops(3, 2, [](SyntheticDrop& drop, unsigned k) {
    drop.damping_n_s_per_m *= 1 + 0.02 * (static_cast<double>(k) - 1);
    drop.noise_v /= 10;
  });
  const DropTestFit fit = Fit(records);
  EXPECT_THAT(Refused(fit.findings), IsEmpty());
  EXPECT_TRUE(fit.findings.Has(FindingKind::kDecaysScatter));
  EXPECT_REL(fit.damping.standard_uncertainty / 0.0322, 0.02 / std::sqrt(3.0), 0.05,
             "three values 2 % apart");
}

// of three drops, the first with these factors of its frequency and decay
Findings FindingsOfFirst(double frequency, double decay) {
  std::vector<PreparedRecord> prepared;
  for (unsigned k = 0; k < 3; ++k) {
    SyntheticDrop drop;
    drop.noise_v = 1e-3;
    drop.seed = k + 1;
    if (k == 0) drop.stiffness_n_per_m *= frequency * frequency;
    if (k == 0) drop.damping_n_s_per_m *= decay;
    ImpulseRecord record = MakeRecord(drop);
    record.name = std::to_string(k);
    prepared.push_back(*PrepareRecord(record));
  }
  std::vector<ComparedDrop> drops;
  for (const auto& one : prepared) {
    drops.push_back(Beside(one));
    drops.back().expected = {11.5, 2e6};
  }
  return CheckConsistency(drops).findings;
}

std::vector<std::string> Foreign(double frequency, double decay) {
  return Refused(FindingsOfFirst(frequency, decay));
}

TEST(Consistency, ADropIsOfAnotherActuatorBeyondItsLimits) {
  // 2 % in the frequency, 20 % in the decay, which noise makes uncertain by 1e-5 and 1e-3
  EXPECT_THAT(Foreign(1.0198, 1), IsEmpty());
  EXPECT_THAT(Foreign(1 / 1.0198, 1), IsEmpty());
  EXPECT_THAT(Foreign(1.0202, 1), ElementsAre("0"));
  EXPECT_THAT(Foreign(1 / 1.0202, 1), ElementsAre("0"));
  EXPECT_THAT(Foreign(1, 1.19), IsEmpty());
  EXPECT_THAT(Foreign(1, 1 / 1.19), IsEmpty());
  EXPECT_THAT(Foreign(1, 1.21), ElementsAre("0"));
  EXPECT_THAT(Foreign(1, 1 / 1.21), ElementsAre("0"));
  EXPECT_REL(tests::NumberOf(FindingsOfFirst(0.96, 1), FindingKind::kFrequencyOfAnother, "share"),
             -0.04, 1e-3, "noise");
  EXPECT_REL(tests::NumberOf(FindingsOfFirst(1, 1.5), FindingKind::kDecayOfAnother, "share"), 0.5,
             0.03, "noise of 0.3 %");
}

TEST(Consistency, AnotherActuatorsDropIsRefusedAndTheOthersConstantsHold) {
  // one of 5 % more stiffness, and one of 50 % more damping, the strongest of all
  for (const auto& [stiffness, damping] : {std::pair(1.05, 1.0), {1.0, 1.5}, {1.7, 0.3}}) {
    auto records = Drops(4, 3, [&](SyntheticDrop& drop, unsigned k) {
      if (k == 0) drop.height_m *= 16;
      if (k == 0) drop.stiffness_n_per_m *= stiffness;
      if (k == 0) drop.damping_n_s_per_m *= damping;
    });
    for (std::size_t k = 0; k < records.size(); ++k) records[k].name = std::to_string(k);
    const DropTestFit fit = Fit(records);
    EXPECT_THAT(Refused(fit.findings), ::testing::AllOf(Not(IsEmpty()), Each("0")))
        << stiffness << " " << damping;
    EXPECT_REL(fit.stiffness.value, 2800, 3e-4, "four deviations of the others' noise");
    EXPECT_REL(fit.damping.value, 0.0322, 0.01, "four deviations of the others' noise");
  }
}

TEST(Consistency, OfTwoActuatorsEitherMayBeTheOther) {
  // a pair of an open and a loaded drop, too
  for (const double load_ohm : {tests::kOpen, 33.0}) {
    auto records = Drops(2, 4, [&](SyntheticDrop& drop, unsigned k) {
      if (k == 0) return;
      drop.stiffness_n_per_m *= 1.05;
      drop.load_ohm = load_ohm;
    });
    const DropTestFit fit = Fit(records);
    EXPECT_EQ(
        std::ranges::count(fit.findings.list(), FindingKind::kFrequencyOfAnother, &Finding::kind),
        2);
    EXPECT_GT(fit.stiffness.upper, 2800 * 1.05) << "the interval holds both";
    EXPECT_LT(fit.stiffness.lower, 2800);
  }
}

}  // namespace
}  // namespace haptometer::fit
