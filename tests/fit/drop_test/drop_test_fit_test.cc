#include "fit/drop_test/drop_test_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "fit/poles.h"
#include "tests/findings.h"
#include "tests/fit/fitted_drops.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::HasSubstr;
using tests::Fit;
using tests::kOpen;
using tests::MakeRecord;
using tests::MakeRecordWithHeight;
using tests::SyntheticDrop;
using tests::ThesisKnowns;

SyntheticDrop Loaded(double load_ohm) {
  SyntheticDrop drop;
  drop.load_ohm = load_ohm;
  drop.seed = 2;
  return drop;
}

void ExpectTruth(const DropTestFit& fit, const SyntheticDrop& drop, double tolerance = 1e-13) {
  ASSERT_TRUE(fit.stiffness.determined && fit.damping.determined && fit.force_constant.determined);
  EXPECT_REL(fit.stiffness.value, drop.stiffness_n_per_m, tolerance, "noise-free");
  EXPECT_REL(fit.damping.value, drop.damping_n_s_per_m, tolerance, "noise-free");
  EXPECT_REL(fit.force_constant.value, drop.force_constant_n_per_a, tolerance, "noise-free");
}

TEST(DropTestFit, RecoversANoiseFreePairWithoutAHeight) {
  const auto fit = Fit({MakeRecord({}), MakeRecord(Loaded(33))});
  ExpectTruth(fit, {});
  EXPECT_REL(fit.natural_frequency.value, std::sqrt(2e6) / (2 * std::numbers::pi), 1e-13,
             "noise-free");
  EXPECT_REL(fit.quality_factor.value, std::sqrt(2800 * 1.4e-3) / 0.0322, 1e-13, "noise-free");
  EXPECT_REL(fit.stiffness_over_mass.value, 2e6, 1e-13, "noise-free");
  EXPECT_REL(fit.damping_over_mass.value, 23.0, 1e-13, "noise-free");
  EXPECT_REL(fit.records[1].impact_speed_m_per_s, std::sqrt(0.02 * 9.80665), 1e-13, "noise-free");
  EXPECT_ABS(fit.records[1].impact_s, 0.37e-4, 1e-15, "noise-free");
  EXPECT_ABS(fit.records[1].offset_v, 0.01, 1e-15, "noise-free");
}

TEST(DropTestFit, RecoversEveryKindOfRecord) {
  // polarity, length before the blow, free case, no inductance, two loads without an open record
  SyntheticDrop drop;
  drop.polarity = -1;
  ExpectTruth(Fit({MakeRecordWithHeight(drop)}), drop);
  drop.quiet_s = 0.02;
  drop.impact_s = -1e-5;
  ExpectTruth(Fit({MakeRecordWithHeight(drop)}), drop);
  drop.rebound = 0.25;
  ExpectTruth(Fit({MakeRecordWithHeight(drop)}), drop);
  drop = Loaded(33);
  ExpectTruth(Fit({MakeRecordWithHeight(drop)}), drop);
  ExpectTruth(Fit({MakeRecord(Loaded(10)), MakeRecord(Loaded(100))}), {});
  drop = {};
  drop.condition = CaseCondition::kFree;
  auto drop_loaded = drop;
  drop_loaded.load_ohm = 27;
  ExpectTruth(Fit({MakeRecord(drop), MakeRecord(drop_loaded)}), drop);
}

TEST(DropTestFit, HeldAndFreeRecordsFitTogether) {
  auto free_drop = Loaded(50);
  free_drop.condition = CaseCondition::kFree;
  const auto fit = Fit({MakeRecord({}), MakeRecord(free_drop)});
  ExpectTruth(fit, {});
  EXPECT_EQ(fit.mass_symbol, "Mv");
  const auto no_masses = FitDropTest({MakeRecord({}), MakeRecord(free_drop)}, {});
  ASSERT_FALSE(no_masses);
  EXPECT_EQ(no_masses.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(no_masses.error().Text(), HasSubstr("both masses"));
}

TEST(DropTestFit, HardDampingIsNotSpecial) {
  // zeta = 0.5: hardly two periods ring above the noise of the arithmetic; zeta = 1: none does
  for (const double zeta :
       {0.0005, 0.002, 0.1, 0.5, 0.9, 0.999, 1 - 1e-9, 1.0, 1 + 1e-9, 1.001, 1.5, 3.0}) {
    SCOPED_TRACE(zeta);
    SyntheticDrop drop;
    drop.damping_n_s_per_m = zeta * 2 * std::sqrt(2800 * 1.4e-3);
    drop.step_s = zeta < 0.05 ? 1e-4 : 2e-5;
    drop.length_s = zeta < 0.05 ? 0.25 : 0.04;
    const auto fit = Fit({MakeRecordWithHeight(drop)});
    // at three times critical the fast decay has fallen to 1 % where the fit begins
    ExpectTruth(fit, drop, zeta > 2 ? 1e-11 : 1e-13);
  }
}

TEST(DropTestFit, AgreesWithTheTwoLoadFormula) {
  // the poles of the matrix pencil alone, without the circuit model: Km^2 = 2 M (dL - d0)(R + RL)
  SyntheticDrop open;
  SyntheticDrop loaded = Loaded(33);
  open.quiet_s = loaded.quiet_s = -0.001;
  open.offset_v = loaded.offset_v = 0;
  const auto poles_open = EstimatePoles(MakeRecord(open).voltage_v, open.step_s);
  const auto poles_loaded = EstimatePoles(MakeRecord(loaded).voltage_v, loaded.step_s);
  ASSERT_TRUE(poles_open && poles_loaded);
  const double km =
      std::sqrt(2 * 1.4e-3 * (poles_loaded->decay_per_s - poles_open->decay_per_s) * (27 + 33));
  const auto fit = Fit({MakeRecord({}), MakeRecord(Loaded(33))});
  EXPECT_REL(fit.force_constant.value, km, 1e-4, "inductance, 38 ppm at 27 ohm");
}

TEST(DropTestFit, AnOpenRecordWithoutAHeightLeavesKmOut) {
  SyntheticDrop drop;
  drop.noise_v = 2e-3;
  const auto fit = Fit({MakeRecord(drop)});
  EXPECT_TRUE(fit.stiffness.determined);
  EXPECT_TRUE(fit.damping.determined);
  EXPECT_FALSE(fit.force_constant.determined);
  EXPECT_EQ(fit.force_constant.value, 0.0);
  EXPECT_FALSE(fit.records[0].speed_determined);
  EXPECT_REL(tests::NumberOf(fit.findings, FindingKind::kKmTimesSpeedOnly, "product_v"), 0.4429,
             5e-3, "Km v0, and noise");
}

TEST(DropTestFit, WithoutMassesOnlyRatiosAreDetermined) {
  SyntheticDrop drop;
  drop.noise_v = 2e-3;
  auto fit = Fit({MakeRecord(drop)}, {});
  EXPECT_FALSE(fit.stiffness.determined);
  EXPECT_FALSE(fit.damping.determined);
  EXPECT_TRUE(fit.stiffness_over_mass.determined);
  EXPECT_TRUE(fit.damping_over_mass.determined);
  EXPECT_REL(fit.stiffness_over_mass.value, 2e6, 4e-5, "noise, 3 standard uncertainties");
  EXPECT_TRUE(fit.natural_frequency.determined);
  EXPECT_TRUE(fit.quality_factor.determined);
  EXPECT_TRUE(fit.findings.Has(FindingKind::kMassMissing));
  // the height gives Km all the same
  fit = Fit({MakeRecordWithHeight(drop)}, {});
  EXPECT_FALSE(fit.stiffness.determined);
  EXPECT_TRUE(fit.force_constant.determined);
  EXPECT_REL(fit.force_constant.value, 1.0, 2e-3, "noise, 3 standard uncertainties");
}

TEST(DropTestFit, OneLoadAloneDeterminesOnlyTheSumOfBothDampings) {
  auto drop = Loaded(33);
  drop.noise_v = 2e-3;
  const auto fit = Fit({MakeRecord(drop)});
  EXPECT_TRUE(fit.stiffness.determined);
  EXPECT_REL(fit.stiffness.value, 2800.0, 2e-4, "noise, and 64 ppm of the coil's share");
  EXPECT_FALSE(fit.damping.determined);
  EXPECT_FALSE(fit.force_constant.determined);
  EXPECT_FALSE(fit.quality_factor.determined);
  EXPECT_TRUE(fit.natural_frequency.determined);
  // 2 d = (Bv + Km^2/60)/Mv = 34.905 1/s
  EXPECT_REL(tests::NumberOf(fit.findings, FindingKind::kDampingsWithoutHeight, "sum_per_s"),
             34.905, 5e-3, "noise");
}

// The fit of drops whose blows have no length: what the samples around a blow leave open of it is
// not in the budget.
DropTestFit FitOfSuddenBlows(const std::vector<ImpulseRecord>& records,
                             const ActuatorKnowns& knowns = ThesisKnowns()) {
  auto prepared = Prepared(records).value();
  for (PreparedRecord& record : prepared) {
    record.start.shortest_contact_s = record.start.longest_contact_s = 0;
  }
  return FitDropTest(std::move(prepared), knowns).value();
}

TEST(DropTestFit, WithoutTheResistanceALoadStillGivesTheRest) {
  auto knowns = ThesisKnowns();
  knowns.resistance_ohm.reset();
  SyntheticDrop open;
  auto loaded = Loaded(33);
  open.noise_v = loaded.noise_v = 2e-3;
  const auto alone = Fit({MakeRecord(open), MakeRecord(loaded)}, knowns);
  EXPECT_TRUE(alone.damping.determined);
  EXPECT_FALSE(alone.force_constant.determined);
  // with a height too, even R follows
  ExpectTruth(
      FitOfSuddenBlows({MakeRecordWithHeight({}), MakeRecordWithHeight(Loaded(33))}, knowns), {});
}

TEST(DropTestFit, NearlyEqualLoadsDoNotInventAForceConstant) {
  auto first = Loaded(33);
  auto second = Loaded(33.5);
  first.noise_v = second.noise_v = 5e-3;
  second.seed = 3;
  const auto fit = Fit({MakeRecord(first), MakeRecord(second)});
  EXPECT_FALSE(fit.force_constant.determined);
  ASSERT_TRUE(fit.force_constant.at_most);
  EXPECT_GE(*fit.force_constant.at_most, 1.0);
}

TEST(DropTestFit, AnUnstatedReboundIsCarriedAsUncertainty) {
  auto record = MakeRecord({});
  record.drop_height_m = Quantity{0.01, 0};
  const auto fit = FitOfSuddenBlows({record});
  EXPECT_REL(fit.force_constant.value, 1.0, 1e-13, "no rebound happened");
  EXPECT_REL(fit.force_constant.combined_standard_uncertainty, 0.3 / std::sqrt(3.0), 1e-9,
             "uniform between 0 and 0.3 about 0");
  EXPECT_LT(fit.force_constant.standard_uncertainty, 1e-9);
  EXPECT_TRUE(fit.findings.Has(FindingKind::kReboundAssumed));
  // a second load needs no rebound
  auto loaded = MakeRecord(Loaded(33));
  loaded.drop_height_m = Quantity{0.01, 0};
  const auto pair = Fit({record, loaded});
  EXPECT_LT(pair.force_constant.combined_standard_uncertainty, 1e-6);
  EXPECT_TRUE(pair.findings.Has(FindingKind::kKmByLoads));
}

TEST(DropTestFit, TwoValuesOfKmThatContradictEachOtherAreADoubt) {
  const auto severity_at = [](double height_m) {
    auto record = MakeRecordWithHeight({});
    record.drop_height_m = Quantity{height_m, 0.05 * height_m};
    const auto fit = Fit({record, MakeRecord(Loaded(33))});
    const auto& list = fit.findings.list();
    const auto found = std::ranges::find(list, FindingKind::kKmByLoads, &Finding::kind);
    EXPECT_NE(found, list.end());
    return found->severity;
  };
  EXPECT_EQ(severity_at(0.0102), Severity::kNote);
  // ten times the height: Km by it is sqrt(10) times too small
  EXPECT_EQ(severity_at(0.1), Severity::kDoubt);
}

TEST(DropTestFit, InputsPropagateLikeTheClosedForms) {
  auto knowns = ThesisKnowns();
  knowns.moving_mass_kg = Quantity{1.4e-3, 0.05e-3 / std::sqrt(3.0)};
  auto record = MakeRecordWithHeight({});
  record.drop_height_m->standard_uncertainty = 1e-3;
  auto fit = FitOfSuddenBlows({record}, knowns);
  // Kv, Bv: u(M)/M = 2.06 %; Km: u(h)/(2h) = 5 %
  EXPECT_REL(fit.stiffness.combined_standard_uncertainty, 2800 * 0.0206197, 1e-5, "digits");
  EXPECT_REL(fit.damping.combined_standard_uncertainty, 0.0322 * 0.0206197, 1e-5, "digits");
  EXPECT_REL(fit.force_constant.combined_standard_uncertainty, 0.05, 1e-8, "noise-free");
  // a rounded mass moves no ratio
  EXPECT_LT(fit.stiffness_over_mass.combined_standard_uncertainty / 2e6, 1e-8);
  EXPECT_LT(fit.natural_frequency.combined_standard_uncertainty / 225, 1e-8);

  // two loads: Km by sqrt(M), by half of (R + RL), whose parts R and RL have 27/60 and 33/60
  knowns.resistance_ohm = Quantity{27, 0.54};
  auto loaded = MakeRecord(Loaded(33));
  loaded.load_ohm->standard_uncertainty = 0.33;
  fit = Fit({MakeRecord({}), loaded}, knowns);
  const double expected = std::hypot(0.0206197 / 2, 0.54 / 120, 0.33 / 120);
  EXPECT_REL(fit.force_constant.combined_standard_uncertainty, expected, 1e-4, "inductance");
  // the records' order does not matter
  fit = Fit({loaded, MakeRecord({})}, knowns);
  EXPECT_REL(fit.force_constant.combined_standard_uncertainty, expected, 1e-4, "inductance");
}

TEST(DropTestFit, TheRecordersScalesPropagateLikeTheClosedForms) {
  auto record = MakeRecordWithHeight({});
  record.voltage_scale = Quantity{1, 0.02};
  record.time_scale = Quantity{1, 1e-3};
  auto fit = FitOfSuddenBlows({record});
  // Kv = M (w s)^2, Bv = 2 M d s, Km = A / (g v0) for shown times s t and shown volts g v
  EXPECT_REL(fit.stiffness.combined_standard_uncertainty, 2800 * 2e-3, 1e-6, "differences of 1e-6");
  EXPECT_REL(fit.damping.combined_standard_uncertainty, 0.0322 * 1e-3, 1e-6, "differences of 1e-6");
  EXPECT_REL(fit.force_constant.combined_standard_uncertainty, 0.02, 1e-6, "differences of 1e-6");
  // a clock that runs 1 % fast, and shows it
  record.voltage_scale = Quantity{1.05, 0};
  record.time_scale = Quantity{1.01, 0};
  fit = FitOfSuddenBlows({record});
  EXPECT_REL(fit.stiffness.value, 2800 * 1.01 * 1.01, 1e-12, "noise-free");
  EXPECT_REL(fit.damping.value, 0.0322 * 1.01, 1e-12, "noise-free");
  EXPECT_REL(fit.force_constant.value, 1 / 1.05, 1e-12, "noise-free");
}

TEST(DropTestFit, CovarianceIsThatOfTheFitAndTheInputs) {
  auto knowns = ThesisKnowns();
  knowns.moving_mass_kg = Quantity{1.4e-3, 1.4e-5};
  SyntheticDrop drop;
  auto loaded = Loaded(33);
  drop.noise_v = loaded.noise_v = 2e-3;
  const auto fit = Fit({MakeRecord(drop), MakeRecord(loaded)}, knowns);
  const auto& c = fit.relative_covariance;
  EXPECT_REL(c[0][0],
             std::pow(fit.stiffness.combined_standard_uncertainty / fit.stiffness.value, 2), 1e-9,
             "the same sums");
  // Kv and Bv go by M, Km by its root
  EXPECT_REL(c[0][1], 1e-4, 1e-3, "their noise is hardly correlated");
  EXPECT_REL(c[0][2], 0.5e-4, 1e-3, "their noise is hardly correlated");
  EXPECT_EQ(c[0][1], c[1][0]);
}

TEST(DropTestFit, SensitivitiesAreThoseOfSolvingAgain) {
  SyntheticDrop drop;
  auto loaded = Loaded(33);
  drop.noise_v = loaded.noise_v = 2e-3;
  const std::vector records{MakeRecordWithHeight(drop), MakeRecordWithHeight(loaded)};
  const auto fit = Fit(records);
  auto knowns = ThesisKnowns();
  knowns.resistance_ohm->value *= 1 + 1e-4;
  const auto moved = Fit(records, knowns);
  const auto influence =
      std::ranges::find(fit.influences, "coil resistance", &InputInfluence::input);
  ASSERT_NE(influence, fit.influences.end());
  EXPECT_ABS(1e4 * std::log(moved.damping.value / fit.damping.value),
             influence->percent_per_percent[1], 5e-4,
             "second order of a step of 1e-4, reweighting");
  EXPECT_ABS(1e4 * std::log(moved.force_constant.value / fit.force_constant.value),
             influence->percent_per_percent[2], 5e-4,
             "second order of a step of 1e-4, reweighting");
}

TEST(DropTestFit, InfluencesAreInPercentPerPercent) {
  SyntheticDrop drop;
  drop.rebound = 0.25;
  const auto fit = Fit({MakeRecordWithHeight(drop)});
  // Km = A / ((1 + e) sqrt(2 g h)); Kv and Bv follow the mass
  const auto of = [&fit](std::string_view name) {
    const auto found = std::ranges::find(fit.influences, name, &InputInfluence::input);
    return found == fit.influences.end() ? std::array<double, 3>{} : found->percent_per_percent;
  };
  EXPECT_ABS(of("rebound")[2], -1.0, 1e-8, "differences of 1e-6");
  EXPECT_ABS(of("drop height")[2], -0.5, 1e-8, "differences of 1e-6");
  EXPECT_ABS(of("moving mass")[0], 1.0, 1e-6, "differences of 1e-6");
  EXPECT_ABS(of("moving mass")[1], 1.0, 1e-6, "differences of 1e-6");
  EXPECT_ABS(of("moving mass")[2], 0.0, 1e-6, "differences of 1e-6");
}

TEST(DropTestFit, StatisticalUncertaintyIsTheCramerRaoBound) {
  // u(d)/d = 2/sqrt(rho), u(w)/w = 2 zeta/sqrt(rho), rho = A^2/(4 d dt s^2), for a long record
  SyntheticDrop drop;
  drop.noise_v = 3e-3;
  drop.length_s = 0.6;
  const auto fit = Fit({MakeRecordWithHeight(drop)});
  const double amplitude = std::sqrt(0.02 * 9.80665) * std::exp(-11.5 * 5.6e-4);
  const double rho = amplitude * amplitude / (4 * 11.5 * drop.step_s * 9e-6);
  EXPECT_REL(fit.damping.standard_uncertainty / fit.damping.value, 2 / std::sqrt(rho), 0.05,
             "noise estimated from 3000 samples, 2 sigma 2.6 %");
  EXPECT_REL(fit.stiffness.standard_uncertainty / fit.stiffness.value, 4 * 0.00813 / std::sqrt(rho),
             0.05, "noise estimated from 3000 samples");
}

TEST(DropTestFit, IntervalsCoverTheTruth) {
  // 100 pairs, 8 bits: the 95 % interval holds each constant 90 to 99 times
  int kv = 0;
  int bv = 0;
  int km = 0;
  constexpr int kPairs = tests::kIsSanitized ? 5 : 100;
  for (unsigned k = 0; k < kPairs; ++k) {
    SyntheticDrop open;
    open.step_s = 4e-4;
    open.step_v = 0.004;
    open.noise_v = 0.5 * open.step_v;
    open.seed = 1000 + 2 * k;
    open.impact_s = 1e-6 * k;
    SyntheticDrop loaded = open;
    loaded.load_ohm = 33;
    loaded.step_v = 0.002;
    loaded.noise_v = 0.5 * loaded.step_v;
    loaded.seed = open.seed + 1;
    const auto fit = Fit({MakeRecord(open), MakeRecord(loaded)});
    const auto covers = [](const FittedValue& value, double truth) {
      return std::abs(value.value - truth) <= 1.96 * value.combined_standard_uncertainty ? 1 : 0;
    };
    kv += covers(fit.stiffness, 2800);
    bv += covers(fit.damping, 0.0322);
    km += covers(fit.force_constant, 1);
  }
  for (const int covered : {kv, bv, km}) {
    EXPECT_GE(covered, kPairs * 9 / 10 - (tests::kIsSanitized ? 2 : 0));
    EXPECT_LE(covered, kPairs - (tests::kIsSanitized ? 0 : 1));
  }
}

TEST(DropTestFit, AssumptionsAreSaid) {
  SyntheticDrop drop;
  auto record = MakeRecord(drop);
  record.condition.reset();
  record.load_ohm.reset();
  const auto fit = Fit({record});
  EXPECT_REL(tests::NumberOf(fit.findings, FindingKind::kHeldAssumed, "ratio"), 0.3, 1e-12,
             "0.6 g of 2 g");
  EXPECT_TRUE(fit.findings.Has(FindingKind::kOpenAssumed));
}

TEST(DropTestFit, UnfitRecordsAreNamed) {
  const auto error_of = [](const ImpulseRecord& record) {
    const auto fit = FitDropTest({record}, ThesisKnowns());
    EXPECT_FALSE(fit);
    if (fit) return std::string();
    EXPECT_EQ(fit.error().cause, Cause::kCannotAnswer);
    return fit.error().Text();
  };
  SyntheticDrop drop;
  drop.length_s = 0.004;
  EXPECT_THAT(error_of(MakeRecord(drop)), HasSubstr("drop.csv"));
  drop = {};
  drop.noise_v = 5;
  EXPECT_THAT(error_of(MakeRecord(drop)), HasSubstr("dB more energy than the noise"));
  drop = {};
  drop.step_s = 1e-3;
  EXPECT_THAT(error_of(MakeRecord(drop)), HasSubstr("samples per period"));
  auto constant = MakeRecord({});
  constant.voltage_v.assign(1000, 0.25);
  EXPECT_THAT(error_of(constant), HasSubstr("no ring-down"));
  EXPECT_FALSE(FitDropTest(std::vector<ImpulseRecord>{}, ThesisKnowns()));
}

TEST(DropTestFit, MissingSamplesAreLeftOut) {
  SyntheticDrop drop;
  auto record = MakeRecordWithHeight(drop);
  for (std::size_t n = 120; n < 160; ++n) record.voltage_v[n] = std::nan("");
  const auto fit = Fit({record});
  ExpectTruth(fit, drop);
  EXPECT_EQ(fit.records[0].samples + 40 + fit.records[0].first_sample, record.voltage_v.size());
}

TEST(DropTestFit, AHeightWithoutAQuietPartIsNotUsedAndNotAskedFor) {
  // a record that begins with the blow, as any does that begins whole periods behind it
  SyntheticDrop drop;
  drop.quiet_s = 0;
  const auto fit = Fit({MakeRecordWithHeight(drop)});
  EXPECT_TRUE(fit.stiffness.determined);
  EXPECT_FALSE(fit.force_constant.determined);
  EXPECT_TRUE(fit.findings.Has(FindingKind::kHeightWithoutImpact));
  EXPECT_TRUE(fit.findings.Has(FindingKind::kKmTimesUnusedSpeed));
  EXPECT_FALSE(fit.findings.Has(FindingKind::kKmTimesSpeedOnly));
  // beside a loaded record Km is that by the loads
  ExpectTruth(Fit({MakeRecordWithHeight(drop), MakeRecord(Loaded(33))}), {});
}

TEST(DropTestFit, AContactThatIsNotSeenIsReportedWithItsShare) {
  // half a sine of 0.5 ms leaves cos(x/2)/(1 - (x/pi)^2) of the amplitude, x = w T
  const auto fit = FitOfSuddenBlows({MakeRecordWithHeight({})});
  const double x = std::sqrt(2e6) * 0.5e-3;
  const double lost = 1 - std::cos(x / 2) / (1 - std::pow(x / std::numbers::pi, 2));
  EXPECT_REL(tests::NumberOf(fit.findings, FindingKind::kContactUnseen, "share"), lost, 0.02,
             "of second order in x");
}

TEST(DropTestFit, AMotionThatBeginsAnEighthOfAPeriodAwayIsRefused) {
  // silence up to `late` periods behind the impact, which continued backwards has begun before
  const auto refused = [](double late) {
    SyntheticDrop drop;
    drop.step_s = 2e-5;
    drop.release_current_a = 0.05;
    auto record = MakeRecord(drop);
    const double until_s = drop.impact_s + late / 225.08;
    for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
      const double t = record.start_s + static_cast<double>(n) * record.step_s;
      if (t < until_s) record.voltage_v[n] = drop.offset_v;
    }
    return Fit({record}).findings;
  };
  EXPECT_FALSE(refused(0.12).Refused());
  const auto findings = refused(0.132);
  EXPECT_TRUE(findings.Has(FindingKind::kMotionBeginsBefore));
  EXPECT_ABS(tests::NumberOf(findings, FindingKind::kMotionBeginsBefore, "apart_s"), 0.132 / 225.08,
             3e-5, "a sample and a half");
}

TEST(DropTestFit, ChiSquareIsTheResidualsPowerOverTheNoiseBefore) {
  SyntheticDrop drop;
  drop.noise_v = 3e-3;
  drop.quiet_s = 0.1;
  auto loaded = Loaded(33);
  loaded.noise_v = 2e-3;
  loaded.quiet_s = 0.05;
  const auto fit = Fit({MakeRecord(drop), MakeRecord(loaded)});
  double sum = 0;
  double samples = 0;
  for (const auto& record : fit.records) {
    const auto count = static_cast<double>(record.samples);
    sum += count * std::pow(record.residual_rms_v / record.quiet_noise_v, 2);
    samples += count;
  }
  EXPECT_REL(fit.chi_square_per_degree, sum / samples, 1e-12, "rounding");
  EXPECT_ABS(fit.chi_square_per_degree, 1.0, 0.2, "noise of 250 to 500 samples before the impact");
}

}  // namespace
}  // namespace haptometer::fit
