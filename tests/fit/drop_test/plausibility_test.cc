#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fit/drop_test/drop_test_fit.h"
#include "tests/findings.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::IsEmpty;

Findings FindingsOf(const ImpulseRecord& record, const ActuatorKnowns& knowns) {
  const auto fit = FitDropTest({record}, knowns);
  EXPECT_TRUE(fit) << fit.error().Text();
  return fit ? FindDoubts(*fit, {record}, knowns) : Findings{};
}

TEST(Plausibility, TheThesisActuatorIsNotDoubted) {
  const auto record = tests::MakeRecordWithHeight({});
  EXPECT_THAT(FindingsOf(record, tests::ThesisKnowns()).list(), IsEmpty());
}

TEST(Plausibility, MillisecondsAsSecondsAreNamed) {
  auto record = tests::MakeRecord({});
  record.step_s *= 1e3;
  record.start_s *= 1e3;
  EXPECT_TRUE(FindingsOf(record, tests::ThesisKnowns()).Has(FindingKind::kUnusualFrequency));
}

TEST(Plausibility, MillivoltsAsVoltsAreNamed) {
  auto record = tests::MakeRecordWithHeight({});
  for (double& v : record.voltage_v) v *= 1e3;
  const auto doubts = FindingsOf(record, tests::ThesisKnowns());
  EXPECT_TRUE(doubts.Has(FindingKind::kUnusualVoltage));
  EXPECT_REL(tests::NumberOf(doubts, FindingKind::kUnusualForceConstant, "force_constant_n_per_a"),
             1000.0, 5e-4, "noise-free");
}

TEST(Plausibility, GramsAsKilogramsAndMillimetresAsMetresAreNamed) {
  auto record = tests::MakeRecordWithHeight({});
  record.drop_height_m = Quantity{10, 0};
  const ActuatorKnowns knowns{Quantity{1.4, 0}, Quantity{0.6e-3, 0}, Quantity{27, 0}, {}};
  const auto doubts = FindingsOf(record, knowns);
  EXPECT_EQ(tests::NumberOf(doubts, FindingKind::kUnusualMovingMass, "moving_mass_kg"), 1.4);
  EXPECT_EQ(tests::NumberOf(doubts, FindingKind::kUnusualHeight, "drop_height_m"), 10);
  EXPECT_FALSE(doubts.Has(FindingKind::kUnusualCaseMass));
}

}  // namespace
}  // namespace haptometer::fit
