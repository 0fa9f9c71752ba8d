// Records spoiled in known ways: each is named, and the constants stay where the clean ones are.
#include "fit/drop_test/disturbances.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/prepared_record.h"
#include "fit/drop_test/ring_fit.h"
#include "fit/drop_test/ring_start.h"
#include "tests/findings.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/residual.h"
#include "tests/sim/ring_ratios.h"

namespace haptometer::fit {
namespace {

using ::testing::IsEmpty;
using tests::MakeRecord;
using tests::SyntheticDrop;

using Spoil = std::function<void(const SyntheticDrop&, ImpulseRecord&)>;

// adds f(t) volts, as a share of the first amplitude, from the impact on
Spoil Add(const std::function<double(double)>& share) {
  return [share](const SyntheticDrop& drop, ImpulseRecord& record) {
    for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
      const double t = record.start_s + static_cast<double>(n) * record.step_s - drop.impact_s;
      record.voltage_v[n] += tests::SpeedVoltage(drop) * share(t);
    }
  };
}

// a further blow of a share of the first one's speed
Spoil SecondImpact(double share, double at_s) {
  SyntheticDrop second;
  const sim::RingDown<double> circuit({.stiffness_n_per_m = second.stiffness_n_per_m,
                                       .damping_n_s_per_m = second.damping_n_s_per_m,
                                       .force_constant_squared_n2_per_a2 = 1,
                                       .mass_kg = second.moving_mass_kg,
                                       .coil_resistance_ohm = 27,
                                       .inductance_h = 0,
                                       .load_ohm = tests::kOpen});
  return Add([=](double t) { return t > at_s ? share * VoltageRatio(circuit, t - at_s) : 0.0; });
}

Spoil Clip(double share) {
  return [share](const SyntheticDrop& drop, ImpulseRecord& record) {
    const double limit_v = share * tests::SpeedVoltage(drop);
    for (double& v : record.voltage_v) {
      v = drop.offset_v + std::clamp(v - drop.offset_v, -limit_v, limit_v);
    }
  };
}

struct Case {
  std::optional<FindingKind> named;  // absent: nothing may be named
  Spoil spoil;
};

struct Bias {
  double stiffness = 0;  // mean error over the mean stated standard uncertainty
  double damping = 0;
};

// mean errors over seeded records of noise `noise` of the amplitude
Bias MeanBias(const Case& spoiled, double noise, int repetitions) {
  Bias bias;
  for (int seed = 1; seed <= repetitions; ++seed) {
    SyntheticDrop drop;
    drop.seed = static_cast<unsigned>(seed);
    drop.noise_v = noise * tests::SpeedVoltage(drop);
    auto record = MakeRecord(drop);
    spoiled.spoil(drop, record);
    const auto fit = FitDropTest({record}, tests::ThesisKnowns());
    EXPECT_TRUE(fit) << fit.error().Text();
    if (!fit) return bias;
    if (spoiled.named) {
      EXPECT_TRUE(fit->records[0].found.Has(*spoiled.named));
    } else {
      EXPECT_THAT(fit->records[0].found.list(), IsEmpty());
    }
    bias.stiffness +=
        (fit->stiffness.value - 2800) / fit->stiffness.standard_uncertainty / repetitions;
    bias.damping += (fit->damping.value - 0.0322) / fit->damping.standard_uncertainty / repetitions;
  }
  return bias;
}

class SpoiledRecord : public ::testing::TestWithParam<double> {
 protected:
  void Expect(std::optional<FindingKind> named, const Spoil& spoil) const {
    const Bias bias = MeanBias({named, spoil}, GetParam(), 6);
    // the mean of 6 errors has a deviation of 0.41 of one
    EXPECT_ABS(bias.stiffness, 0.0, 1.0, "one stated standard uncertainty");
    EXPECT_ABS(bias.damping, 0.0, 1.0, "one stated standard uncertainty");
  }
};

TEST_P(SpoiledRecord, ACleanOneIsLeftAlone) {
  Expect({}, [](const SyntheticDrop&, ImpulseRecord&) {});
}

TEST_P(SpoiledRecord, ALaterImpactIsCutOff) {
  for (const double at_s : {0.02, 0.1507}) {
    SCOPED_TRACE(at_s);
    Expect(FindingKind::kLaterImpact, SecondImpact(0.1, at_s));
  }
}

TEST_P(SpoiledRecord, ClippedPeaksAreLeftOut) { Expect(FindingKind::kClipped, Clip(0.8)); }

TEST_P(SpoiledRecord, HumIsFittedAlong) {
  for (const double hum_hz : {50.0, 60.0}) {
    SCOPED_TRACE(hum_hz);
    Expect(FindingKind::kHum, Add([hum_hz](double t) {
             return 0.1 * std::sin(2 * std::numbers::pi * hum_hz * t + 0.7);
           }));
  }
}

TEST_P(SpoiledRecord, DriftIsFittedAlong) {
  Expect(FindingKind::kDrift, Add([](double t) { return 0.01 * t / 0.25; }));
}

// a coupling capacitor's exponential, a line and nothing, beside noise of 1 % of the ringing
TEST(FindDisturbances, ASlowRestIsDoubtedWhereNoLineExplainsIt) {
  const auto doubts = [](const std::function<double(double)>& slow, unsigned seed) {
    SyntheticDrop drop;
    drop.noise_v = 0.01 * tests::SpeedVoltage(drop);
    drop.seed = seed;
    ImpulseRecord record = MakeRecord(drop);
    Add(slow)(drop, record);
    const auto start = FindRingStart(record);
    EXPECT_TRUE(start);
    return FindDisturbances(record, *start).found.Has(FindingKind::kSlowRest);
  };
  int false_alarms = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    EXPECT_TRUE(doubts([](double t) { return 0.1 * std::exp(-t / 0.05); }, seed)) << seed;
    false_alarms += doubts([](double t) { return 0.1 * t; }, seed) ? 1 : 0;
    false_alarms += doubts([](double) { return 0.0; }, seed) ? 1 : 0;
  }
  EXPECT_EQ(false_alarms, 0);
}

// hum of 50 Hz and `further`, on a ring-down at 150 Hz with a quality factor of 40
Disturbances AtAHarmonic(const std::function<double(double)>& further) {
  SyntheticDrop drop;
  const double own_rad_per_s = 2 * std::numbers::pi * 150.7;
  drop.stiffness_n_per_m = drop.moving_mass_kg * own_rad_per_s * own_rad_per_s;
  drop.damping_n_s_per_m = drop.moving_mass_kg * own_rad_per_s / 40;
  drop.noise_v = 1e-3 * tests::SpeedVoltage(drop);
  auto record = MakeRecord(drop);
  Add([&](double t) { return 0.05 * std::sin(100 * std::numbers::pi * t) + further(t); })(drop,
                                                                                          record);
  const auto start = FindRingStart(record);
  EXPECT_TRUE(start);
  return FindDisturbances(record, *start);
}

TEST(FindDisturbances, HarmonicsOfTheHumAreTakenBesideIt) {
  const auto hum = AtAHarmonic([](double t) {
    const double angle = 100 * std::numbers::pi * t;
    return 0.02 * std::sin(2 * angle + 1) + 0.01 * std::sin(5 * angle + 2);
  });
  EXPECT_THAT(hum.background.hum_hz, ::testing::ElementsAre(50, 100, 250)) << "the largest first";
  EXPECT_TRUE(hum.no_ring_down.empty()) << hum.no_ring_down;
}

TEST(FindDisturbances, AHarmonicAtTheResonanceIsTakenOnlyWhereItLasts) {
  const auto hum =
      AtAHarmonic([](double t) { return 0.02 * std::sin(300 * std::numbers::pi * t + 1); });
  EXPECT_THAT(hum.background.hum_hz, ::testing::ElementsAre(50, 150));
  // what a stiffening spring leaves, at the same frequency, falls with the amplitude's cube
  const auto spring = AtAHarmonic([](double t) {
    const double decay_per_s = std::numbers::pi * 150.7 / 40;
    const double phase = 0.05 * (1 - std::exp(-2 * decay_per_s * t));
    return t < 0 ? 0 : -phase * std::exp(-decay_per_s * t) * std::sin(301.4 * std::numbers::pi * t);
  });
  EXPECT_THAT(spring.background.hum_hz, ::testing::ElementsAre(50));
}

TEST(FindDisturbances, KeepsTheFirstPartWhereAHeightIsStated) {
  // 30 ms before the blow and 220 ms behind it: more is known behind, the height holds before
  for (const bool has_height : {false, true}) {
    SyntheticDrop drop;
    drop.noise_v = 1e-3;
    auto record = has_height ? tests::MakeRecordWithHeight(drop) : MakeRecord(drop);
    SecondImpact(0.8, 0.03)(drop, record);
    const auto fit = FitDropTest({record}, tests::ThesisKnowns());
    ASSERT_TRUE(fit) << fit.error().Text();
    EXPECT_EQ(
        tests::NumberOf<std::string>(fit->records[0].found, FindingKind::kLaterImpact, "kept"),
        has_height ? "before" : "behind");
    EXPECT_EQ(fit->force_constant.determined, has_height);
  }
}

TEST(FindDisturbances, ATailBelowTheConvertersStepIsLeftOut) {
  SyntheticDrop drop;
  drop.step_v = 0.02;
  drop.length_s = 0.6;
  const auto fit = FitDropTest({MakeRecord(drop)}, tests::ThesisKnowns());
  ASSERT_TRUE(fit) << fit.error().Text();
  EXPECT_TRUE(fit->records[0].found.Has(FindingKind::kQuantisedTail));
  // 0.443 V fall to 0.02 V in ln(22)/11.5 s
  EXPECT_ABS(static_cast<double>(fit->records[0].samples) * drop.step_s, 0.269, 0.01,
             "closed form");
}

TEST(FindDisturbances, ATailThatRoundingStopsIsNoFriction) {
  // 8 bits, and a twentieth of a step of noise: below half a step the converter shows rest, as dry
  // friction leaves behind; it took 0.2 to 0.5 % from Km by the loads
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SyntheticDrop drop;
    drop.seed = seed;
    drop.step_s = 1e-4;
    drop.damping_n_s_per_m = 0.07;
    drop.length_s = 0.7;
    drop.height_m = 0.008 + 0.0002 * seed;
    drop.step_v = 2.2 * tests::SpeedVoltage(drop) / 256;
    drop.noise_v = 0.05 * drop.step_v;
    const auto fit = FitDropTest({MakeRecord(drop)}, tests::ThesisKnowns());
    ASSERT_TRUE(fit) << fit.error().Text();
    EXPECT_FALSE(fit->records[0].found.Has(FindingKind::kDryFriction)) << seed;
    EXPECT_ABS(fit->damping.value, drop.damping_n_s_per_m, 4 * fit->damping.standard_uncertainty,
               "4 of its deviations");
  }
}

INSTANTIATE_TEST_SUITE_P(AtNoise, SpoiledRecord, ::testing::Values(0.002, 0.01));

double NumberOf(const ImpulseRecord& record, FindingKind kind, const char* name) {
  const auto prepared = PrepareRecord(record);
  EXPECT_TRUE(prepared) << prepared.error().Text();
  return prepared ? tests::NumberOf(prepared->part.found, kind, name) : 0;
}

TEST(FindDisturbances, ALaterImpactIsReportedWithItsTimeAndItsSizes) {
  for (const double since_s : {0.1, 0.101, 0.102}) {
    SCOPED_TRACE(since_s);
    SyntheticDrop drop;
    drop.noise_v = 1e-3;
    auto record = MakeRecord(drop);
    SecondImpact(0.1, since_s)(drop, record);
    const double at_s = NumberOf(record, FindingKind::kLaterImpact, "at_s");
    EXPECT_ABS(at_s, since_s + drop.impact_s, 4e-4, "two samples");
    const double speed_v = tests::SpeedVoltage(drop);
    EXPECT_REL(NumberOf(record, FindingKind::kLaterImpact, "amplitude_v"), 0.1 * speed_v, 0.1,
               "the sample that the impact is counted from");
    EXPECT_REL(NumberOf(record, FindingKind::kLaterImpact, "ringing_v"),
               speed_v * std::exp(-11.5 * since_s), 0.2,
               "of a fit that leans to the second, a third of the first at that time");
  }
}

// the Cramer-Rao bound of a decay rate, up to a factor: sqrt(I0/(I0 I2 - I1^2))/A
double DecayBound(double amplitude, double decay_per_s, double length_s) {
  const double x = 2 * decay_per_s * length_s;
  const double left = std::exp(-x);
  const double i0 = (1 - left) / (2 * decay_per_s);
  const double i1 = (1 - left * (1 + x)) / std::pow(2 * decay_per_s, 2);
  const double i2 = (2 - left * (2 + 2 * x + x * x)) / std::pow(2 * decay_per_s, 3);
  return std::sqrt(i0 / (i0 * i2 - i1 * i1)) / amplitude;
}

TEST(FindDisturbances, OfBothSidesOfAnImpactTheOneIsKeptThatTellsMoreOfTheDecay) {
  // a ring-down of 0.25 s from an eighth of a period on; a sixteenth before the impact and a
  // quarter behind it are excluded
  const double period_s = 2 * M_PI / std::sqrt(2e6);
  const auto before = [&](double since_s) {
    return DecayBound(1, 11.5, since_s - period_s * (1. / 16 + 1. / 8));
  };
  const auto after = [&](double since_s) {
    return DecayBound(std::exp(-11.5 * since_s), 11.5, 0.25 - since_s - period_s / 4);
  };
  double even_s = 0.02;
  while (before(even_s) > after(even_s)) even_s += 1e-4;
  for (const double factor : {0.93, 1.07}) {
    SyntheticDrop drop;
    drop.noise_v = 1e-3;
    auto record = MakeRecord(drop);
    SecondImpact(0.05, factor * even_s)(drop, record);
    const auto prepared = PrepareRecord(record);
    ASSERT_TRUE(prepared) << prepared.error().Text();
    EXPECT_EQ(tests::NumberOf<std::string>(prepared->part.found, FindingKind::kLaterImpact, "kept"),
              factor < 1 ? "behind" : "before")
        << even_s;
  }
}

TEST(FindDisturbances, HumAndDriftAreReportedWithTheirAmplitudes) {
  SyntheticDrop drop;
  drop.noise_v = 1e-3;
  auto record = MakeRecord(drop);
  Add([](double t) { return 0.1 * std::sin(2 * std::numbers::pi * 60 * t + 0.7); })(drop, record);
  EXPECT_EQ(NumberOf(record, FindingKind::kHum, "frequency_hz"), 60);
  EXPECT_REL(NumberOf(record, FindingKind::kHum, "amplitude_v"), 0.1 * tests::SpeedVoltage(drop),
             0.02, "noise; the ringing's fit takes little of it");
  record = MakeRecord(drop);
  Add([](double t) { return 0.05 * t / 0.25; })(drop, record);
  // from end to end of the part, which lacks an eighth of a period
  EXPECT_REL(NumberOf(record, FindingKind::kDrift, "amplitude_v"),
             0.05 * tests::SpeedVoltage(drop) * (1 - 0.6e-3 / 0.25), 0.02, "noise");
}

TEST(FindDisturbances, ABackgroundBelowATwoThousandthOfTheRingingIsLetPass) {
  const auto has = [](FindingKind kind, double share) {
    SyntheticDrop drop;
    drop.noise_v = 1e-6;
    auto record = MakeRecord(drop);
    // of the ringing where the part begins, an eighth of a period behind the impact
    const double ringing = std::exp(-11.5 * 0.6e-3);
    const auto shape = [&](double t) {
      if (kind == FindingKind::kDrift) return share * ringing * (t - 0.6e-3) / (0.25 - 0.6e-3);
      return share * ringing * std::cos(2 * std::numbers::pi * 50 * t);
    };
    Add(shape)(drop, record);
    const auto prepared = PrepareRecord(record);
    EXPECT_TRUE(prepared) << prepared.error().Text();
    return prepared && prepared->part.found.Has(kind);
  };
  for (const FindingKind kind : {FindingKind::kDrift, FindingKind::kHum}) {
    EXPECT_FALSE(has(kind, 0.98 * 5e-4));
    EXPECT_TRUE(has(kind, 1.02 * 5e-4));
  }
}

TEST(FindDisturbances, AQuantisedTailIsReportedWithItsStepAndItsBegin) {
  SyntheticDrop drop;
  drop.step_v = 0.02;
  drop.length_s = 0.6;
  const auto record = MakeRecord(drop);
  EXPECT_REL(NumberOf(record, FindingKind::kQuantisedTail, "step_v"), 0.02, 1e-9, "rounding");
  // where 0.443 V have fallen to a step
  EXPECT_ABS(NumberOf(record, FindingKind::kQuantisedTail, "from_s"),
             std::log(tests::SpeedVoltage(drop) / 0.02) / 11.5, 5e-3, "a period");
  // the same in codes
  auto codes = record;
  codes.unit = "";
  for (double& v : codes.voltage_v) v = std::round(v / 0.02);
  EXPECT_EQ(NumberOf(codes, FindingKind::kQuantisedTail, "step"), 1);
  EXPECT_ABS(NumberOf(codes, FindingKind::kQuantisedTail, "from_s"),
             NumberOf(record, FindingKind::kQuantisedTail, "from_s"), 1e-9, "rounding");
}

TEST(FindDisturbances, NumbersHaveTheUnitOfTheRecord) {
  SyntheticDrop drop;
  drop.noise_v = 1e-3;
  auto record = MakeRecord(drop);
  Add([](double t) { return 0.05 * t / 0.25; })(drop, record);
  record.unit = "m";
  EXPECT_GT(NumberOf(record, FindingKind::kDrift, "amplitude_m"), 0);
  record.unit = "mm";
  EXPECT_GT(NumberOf(record, FindingKind::kDrift, "amplitude"), 0);
}

// a drop whose mover rubs: friction of a share of the spring's force at the first swing
ImpulseRecord Rubbing(SyntheticDrop drop, double share) {
  auto record = MakeRecord(drop);
  const double speed_v = tests::SpeedVoltage(drop);
  const double decay_per_s = drop.damping_n_s_per_m / (2 * drop.moving_mass_kg);
  const double stiffness_per_s2 = drop.stiffness_n_per_m / drop.moving_mass_kg;
  // at the impact u = 0
  FrictionRing ring{.poles = {.decay_per_s = decay_per_s, .stiffness_per_s2 = stiffness_per_s2},
                    .even_v = speed_v,
                    .odd_v_per_s = -decay_per_s * speed_v,
                    .friction = 0,
                    .signal = RecordedSignal::kVoltage};
  std::size_t first = 0;
  std::vector<double> since_s;
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    const double t = record.start_s + static_cast<double>(n) * record.step_s - drop.impact_s;
    if (t <= 0) first = n + 1;
    if (t > 0) since_s.push_back(t);
  }
  const auto without = MotionWithFriction(ring, since_s);
  ring.friction = share * speed_v / std::sqrt(stiffness_per_s2);
  const auto with = MotionWithFriction(ring, since_s);
  for (std::size_t n = 0; n < with.size(); ++n) {
    record.voltage_v[first + n] += with[n] - without[n];
  }
  return record;
}

// decrease of the squares by friction over the mean square that is left
double GainOfFriction(const ImpulseRecord& record, const RingStart& start) {
  const auto samples = BlocksOf(record, start.first_sample, record.voltage_v.size(), 1);
  const RingFit without = FitRing(samples, start.poles, {});
  const RingFit with = FitRing(samples, start.poles, {.has_friction = true});
  const auto degrees = static_cast<double>(with.jacobian.rows - with.jacobian.columns);
  return (without.Squares() - with.Squares()) / with.Squares() * degrees;
}

TEST(FindDisturbances, FrictionIsTakenFromAGainOfTwelveOn) {
  SyntheticDrop drop;
  drop.step_s = 4e-4;  // 11 samples a period: blocks of one
  drop.noise_v = 1e-3 * tests::SpeedVoltage(drop);
  double silent_share = 0;
  double taken_share = 4e-5;
  double silent = 0;
  double taken = 0;
  for (int halving = 0; halving < 12; ++halving) {
    const double share = (silent_share + taken_share) / 2;
    const auto record = Rubbing(drop, share);
    const auto start = FindRingStart(record);
    ASSERT_TRUE(start);
    const bool has = FindDisturbances(record, *start).found.Has(FindingKind::kDryFriction);
    (has ? taken_share : silent_share) = share;
    (has ? taken : silent) = GainOfFriction(record, *start);
  }
  EXPECT_REL(taken, 12.0, 5e-3, "first order of the friction; halved 12 times");
  EXPECT_REL(silent, 12.0, 5e-3, "first order of the friction; halved 12 times");
}

TEST(FindDisturbances, FrictionOfMoreThanATwentySecondOfTheSpringsForceIsNoRingDown) {
  SyntheticDrop drop;
  drop.noise_v = 1e-4 * tests::SpeedVoltage(drop);
  double ringing_share = 0.03;
  double stopped_share = 0.06;
  double reported = 0;
  std::string reason;
  for (int halving = 0; halving < 10; ++halving) {
    const double share = (ringing_share + stopped_share) / 2;
    const auto record = Rubbing(drop, share);
    const auto start = FindRingStart(record);
    ASSERT_TRUE(start);
    const auto part = FindDisturbances(record, *start);
    (part.no_ring_down.empty() ? ringing_share : stopped_share) = share;
    if (!part.no_ring_down.empty()) reason = part.no_ring_down;
    if (part.no_ring_down.empty()) reported = part.friction_share;
  }
  EXPECT_EQ(reason, "is stopped by dry friction within its first swings");
  EXPECT_REL(reported, 0.045, 2e-3, "halved 10 times");
  EXPECT_LT(reported, 0.045);
}

TEST(FindDisturbances, FrictionIsSoughtBelowThreeTenthsOfCriticalDamping) {
  double sought = 0.2;
  double left = 0.35;
  double fitted = 0;
  for (int halving = 0; halving < 12; ++halving) {
    const double ratio = (sought + left) / 2;
    SyntheticDrop drop;
    drop.damping_n_s_per_m = 2 * ratio * std::sqrt(drop.stiffness_n_per_m * drop.moving_mass_kg);
    drop.step_s = 4e-5;  // 111 samples a period
    drop.length_s = 0.02;
    drop.noise_v = 1e-4 * tests::SpeedVoltage(drop);
    const auto record = Rubbing(drop, 0.01);
    const auto start = FindRingStart(record);
    ASSERT_TRUE(start) << start.error().Text();
    const bool has = FindDisturbances(record, *start).found.Has(FindingKind::kDryFriction);
    (has ? sought : left) = ratio;
    // by a fit without friction, which takes some of it for damping
    const auto samples = BlocksOf(record, start->first_sample, record.voltage_v.size(), 1);
    const PolePair poles = FitRing(samples, start->poles, {}).poles;
    fitted = poles.decay_per_s / std::sqrt(poles.stiffness_per_s2);
  }
  EXPECT_REL(fitted, 0.3, 1e-3, "halved 12 times");
}

TEST(FindDisturbances, AnImpactInTheLastPeriodIsNotLookedFor) {
  // 22.2 samples a period: trials begin 12 samples apart, the last two of these distances excluded
  const auto has_impact = [](std::size_t samples_before_end) {
    SyntheticDrop drop;
    drop.noise_v = 1e-3 * tests::SpeedVoltage(drop);
    auto record = MakeRecord(drop);
    const auto start = FindRingStart(record);
    EXPECT_TRUE(start);
    // a trial lies 6 and 30 samples before the end
    const std::size_t count = (record.voltage_v.size() - start->first_sample) / 12 * 12 - 6;
    record.voltage_v.resize(start->first_sample + count);
    const std::size_t first = record.voltage_v.size() - samples_before_end;
    // half a sample before it
    const double at_s =
        record.start_s + (static_cast<double>(first) - 0.5) * record.step_s - drop.impact_s;
    SecondImpact(6e-3, at_s)(drop, record);
    return FindDisturbances(record, *start).found.Has(FindingKind::kLaterImpact);
  };
  EXPECT_FALSE(has_impact(6));
  EXPECT_TRUE(has_impact(30));
}

TEST(FindDisturbances, AnImpactBelowATwoHundredthOfTheRingingIsLetPass) {
  const auto has_impact = [](double share) {
    SyntheticDrop drop;
    drop.noise_v = 1e-5 * tests::SpeedVoltage(drop);
    auto record = MakeRecord(drop);
    const auto start = FindRingStart(record);
    EXPECT_TRUE(start);
    // half a sample before one of the trials, which begin 12 samples apart; the part begins an
    // eighth of a period behind the first impact
    const double at_s =
        record.start_s +
        (static_cast<double>(start->first_sample + 45 * 12UZ) - 0.5) * record.step_s -
        drop.impact_s;
    const double since_s =
        record.start_s + static_cast<double>(start->first_sample) * record.step_s - drop.impact_s;
    SecondImpact(share * std::exp(-11.5 * since_s), at_s)(drop, record);
    return FindDisturbances(record, *start).found.Has(FindingKind::kLaterImpact);
  };
  EXPECT_FALSE(has_impact(0.993 * 5e-3));
  EXPECT_TRUE(has_impact(1.007 * 5e-3));
}

// what is known of a short drop at 40 Hz with a share of 120 Hz
struct ShortDrop {
  double periods = 0;     // of the part
  double share_left = 0;  // RMS of the residual over the first amplitude
  double times_noise = 0;
  bool is_refused = false;
};

ShortDrop ShortOf(double periods, double harmonic, double noise) {
  SyntheticDrop drop = tests::HeavilyDampedDrop(periods, 100);
  drop.quiet_s = 100 * drop.step_s;
  drop.noise_v = noise * tests::SpeedVoltage(drop);
  auto record = MakeRecord(drop);
  Add([harmonic](double t) {
    return t < 0 ? 0 : harmonic * std::sin(2 * std::numbers::pi * 120 * t);
  })(drop, record);
  const auto start = FindRingStart(record);
  EXPECT_TRUE(start);
  if (!start) return {};
  const auto part = FindDisturbances(record, *start);
  const auto samples = BlocksOf(record, part.first_sample, part.end_sample, 1);
  const RingFit fit = FitRing(samples, part.poles, part.background);
  const double left_v = std::sqrt(fit.Squares() / static_cast<double>(samples.values_v.size()));
  const std::string& reason = part.no_ring_down;
  EXPECT_TRUE(reason.empty() || reason.starts_with("holds only")) << reason;
  return {.periods = (samples.times_s.back() - samples.times_s.front()) *
                     std::sqrt(fit.poles.stiffness_per_s2) / (2 * std::numbers::pi),
          .share_left = left_v / fit.Envelope(0),
          .times_noise = left_v / start->quiet_noise_v,
          .is_refused = !reason.empty()};
}

// the last drops on either side of an edge, of 12 halvings
std::pair<ShortDrop, ShortDrop> EdgeOf(const std::function<ShortDrop(double)>& drop_at,
                                       double refused, double accepted) {
  std::pair<ShortDrop, ShortDrop> edge;
  for (int halving = 0; halving < 12; ++halving) {
    const double middle = (refused + accepted) / 2;
    const ShortDrop drop = drop_at(middle);
    (drop.is_refused ? refused : accepted) = middle;
    (drop.is_refused ? edge.first : edge.second) = drop;
  }
  return edge;
}

TEST(FindDisturbances, LessThanTwoPeriodsMayLeaveAHundredthOfTheAmplitude) {
  const auto [refused, accepted] =
      EdgeOf([](double harmonic) { return ShortOf(2.05, harmonic, 1e-5); }, 0.03, 0.005);
  EXPECT_GE(refused.share_left, 0.01);
  EXPECT_LT(accepted.share_left, 0.01);
  EXPECT_REL(refused.share_left, accepted.share_left, 3e-3, "halved 12 times");
}

TEST(FindDisturbances, LessThanTwoPeriodsMayLeaveTenTimesTheNoiseBefore) {
  const auto [refused, accepted] =
      EdgeOf([](double noise) { return ShortOf(2.05, 0.03, noise); }, 1e-3, 5e-3);
  EXPECT_GE(refused.times_noise, 10);
  EXPECT_LT(accepted.times_noise, 10);
  EXPECT_REL(refused.times_noise, accepted.times_noise, 3e-3, "halved 12 times");
}

TEST(FindDisturbances, TwoPeriodsMayLeaveMore) {
  const auto [refused, accepted] =
      EdgeOf([](double periods) { return ShortOf(periods, 0.03, 1e-5); }, 2.05, 2.3);
  EXPECT_LT(refused.periods, 2);
  EXPECT_GE(accepted.periods, 2);
  EXPECT_LT(accepted.periods - refused.periods, 0.011) << "100 samples a period";
}

}  // namespace
}  // namespace haptometer::fit
