// Records spoiled in known ways: each is named, and the constants stay where the clean ones are.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>

#include "fit/drop_test/drop_test_fit.h"
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

}  // namespace
}  // namespace haptometer::fit
