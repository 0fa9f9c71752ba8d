// Records other than a voltage after a blow: released currents, added masses, a laser's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fit/drop_test/drop_test_fit.h"
#include "tests/findings.h"
#include "tests/fit/fitted_drops.h"
#include "tests/fit/pulls.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::HasSubstr;
using tests::Fit;
using tests::MakeRecord;
using tests::Pulls;
using tests::SyntheticDrop;
using tests::ThesisKnowns;

ActuatorKnowns WithoutMasses() {
  auto knowns = ThesisKnowns();
  knowns.moving_mass_kg.reset();
  knowns.case_mass_kg.reset();
  return knowns;
}

SyntheticDrop Released(double current_a) {
  SyntheticDrop drop;
  drop.release_current_a = current_a;
  return drop;
}

SyntheticDrop Weighted(double added_kg) {
  SyntheticDrop drop;
  drop.added_mass_kg = added_kg;
  return drop;
}

SyntheticDrop SeenByLaser() {
  SyntheticDrop drop;
  drop.condition = CaseCondition::kFree;
  drop.displacement_share = 0.7;
  drop.step_s = 1e-4;
  drop.offset_v = 0.03;  // metres
  return drop;
}

TEST(ReleasedCurrent, OneOpenRecordTellsAllThree) {
  // 50 mA bend the spring by 18 um and ring with 25 mV: Km by the amplitude, without height or load
  for (const double polarity : {1.0, -1.0}) {
    auto drop = Released(0.05);
    drop.polarity = polarity;
    drop.offset_v = 1e-3;
    const auto fit = Fit({MakeRecord(drop)});
    ASSERT_TRUE(fit.force_constant.determined);
    EXPECT_REL(fit.stiffness.value, 2800.0, 1e-12, "noise-free");
    EXPECT_REL(fit.damping.value, 0.0322, 1e-12, "noise-free");
    EXPECT_REL(fit.force_constant.value, 1.0, 1e-12, "noise-free");
    EXPECT_ABS(fit.records[0].impact_s, 0.37e-4, 1e-14, "noise-free");
    EXPECT_FALSE(fit.records[0].speed_determined);
  }
}

TEST(ReleasedCurrent, WithALoadItsShareOfTheDampingIsKnown) {
  auto drop = Released(0.05);
  drop.load_ohm = 33;
  drop.offset_v = 1e-3;
  const auto fit = Fit({MakeRecord(drop)});
  EXPECT_REL(fit.damping.value, 0.0322, 1e-11, "noise-free");
  EXPECT_REL(fit.force_constant.value, 1.0, 1e-11, "noise-free");
}

TEST(ReleasedCurrent, ItsUncertaintyIsHalvedInKm) {
  // Km^2 = amplitude M/I0
  auto record = MakeRecord(Released(0.05));
  record.release_current_a = Quantity{0.05, 0.05 * 0.02};
  const auto fit = Fit({record});
  const auto& km = fit.force_constant;
  EXPECT_REL(km.combined_standard_uncertainty / km.value, 0.01, 1e-6, "first order");
  record.voltage_scale = Quantity{1, 0.03};
  EXPECT_REL(Fit({record}).force_constant.combined_standard_uncertainty, std::hypot(0.01, 0.015),
             1e-6, "first order");
}

TEST(ReleasedCurrent, ErrorsAreAsStated) {
  Pulls pulls;
  for (int k = 0; k < tests::Repetitions(60); ++k) {
    auto drop = Released(0.05);
    drop.noise_v = 5e-4;  // 2 % of the first amplitude
    drop.offset_v = 1e-3;
    drop.seed = static_cast<unsigned>(k) + 1;
    const auto fit = Fit({MakeRecord(drop)});
    const auto& km = fit.force_constant;
    ASSERT_TRUE(km.determined);
    pulls.Add(km.value, 1, km.standard_uncertainty);
  }
  const double slack = 2.5 / std::sqrt(2.0 * pulls.count());
  EXPECT_ABS(pulls.mean(), 0.0, 0.15 + std::sqrt(2.0) * slack, "of so many pulls");
  EXPECT_ABS(pulls.deviation(), 1.0, 0.1 + slack, "of so many pulls");
}

TEST(AddedMass, TellsTheMover) {
  // M = dM/((f0/f1)^2 - 1)
  const auto fit = Fit({MakeRecord({}), MakeRecord(Weighted(0.5e-3))}, WithoutMasses());
  ASSERT_TRUE(fit.moving_mass.determined);
  EXPECT_REL(fit.moving_mass.value, 1.4e-3, 1e-11, "noise-free");
  EXPECT_REL(fit.stiffness.value, 2800.0, 1e-11, "noise-free");
  EXPECT_REL(fit.damping.value, 0.0322, 1e-11, "noise-free");
  EXPECT_FALSE(fit.force_constant.determined);
  // its uncertainty is the mover's, all else being frequencies
  auto weighed = MakeRecord(Weighted(0.5e-3));
  weighed.added_mass_kg = Quantity{0.5e-3, 0.5e-5};
  const auto mass = Fit({MakeRecord({}), weighed}, WithoutMasses()).moving_mass;
  EXPECT_REL(mass.combined_standard_uncertainty / mass.value, 0.01, 1e-6, "in proportion");
}

TEST(AddedMass, WithALoadAllFourAreTold) {
  SyntheticDrop loaded;
  loaded.load_ohm = 33;
  const auto fit =
      Fit({MakeRecord({}), MakeRecord(Weighted(0.5e-3)), MakeRecord(loaded)}, WithoutMasses());
  EXPECT_REL(fit.force_constant.value, 1.0, 1e-10, "noise-free");
  EXPECT_REL(fit.moving_mass.value, 1.4e-3, 1e-11, "noise-free");
}

TEST(AddedMass, NeedsAHeldCase) {
  auto drop = Weighted(0.5e-3);
  drop.condition = CaseCondition::kFree;
  const auto fit = FitDropTest({MakeRecord(drop)}, ThesisKnowns());
  ASSERT_FALSE(fit);
  EXPECT_THAT(fit.error().Text(), HasSubstr("hold the case"));
}

TEST(LaserRecord, TellsSpringAndDampingOfACaseInTheAir) {
  const auto fit = Fit({MakeRecord(SeenByLaser())});
  EXPECT_REL(fit.stiffness.value, 2800.0, 1e-11, "noise-free, 30 mm of distance");
  EXPECT_REL(fit.damping.value, 0.0322, 1e-10, "noise-free, 30 mm of distance");
  EXPECT_FALSE(fit.force_constant.determined);
  EXPECT_FALSE(fit.records[0].speed_determined);
  EXPECT_TRUE(fit.findings.Has(FindingKind::kKmOfDisplacement));
}

TEST(LaserRecord, StandsBesideVoltages) {
  auto open = SyntheticDrop{.condition = CaseCondition::kFree, .step_s = 1e-4};
  auto loaded = open;
  loaded.load_ohm = 33;
  const auto fit = Fit({MakeRecord(SeenByLaser()), MakeRecord(open), MakeRecord(loaded)});
  EXPECT_REL(fit.stiffness.value, 2800.0, 1e-11, "noise-free");
  EXPECT_REL(fit.force_constant.value, 1.0, 1e-10, "noise-free");
}

TEST(LaserRecord, OfALoadedCoilIsExactWithItsInductance) {
  // both records seen by the laser: the load's damping alone tells Km
  auto loaded = SeenByLaser();
  loaded.load_ohm = 27;
  const auto fit = Fit({MakeRecord(SeenByLaser()), MakeRecord(loaded)});
  EXPECT_REL(fit.force_constant.value, 1.0, 1e-9, "noise-free, 30 mm of distance");
}

}  // namespace
}  // namespace haptometer::fit
