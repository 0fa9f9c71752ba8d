#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <utility>
#include <vector>

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

FittedValue Determined(double value) {
  FittedValue fitted;
  fitted.value = value;
  fitted.determined = true;
  return fitted;
}

// a fit of usual numbers, made by hand
DropTestFit Usual() {
  DropTestFit fit;
  fit.natural_frequency = Determined(225);
  fit.quality_factor = Determined(60);
  fit.force_constant = Determined(1);
  fit.records.resize(1);
  fit.records[0].name = "drop.csv";
  fit.records[0].peak_v = 0.4;
  return fit;
}

TEST(Plausibility, OfAFitDoubtsBeginAtTheEndsOfTheRanges) {
  const auto expect = [](FindingKind kind, FittedValue DropTestFit::* member, double least,
                         double most) {
    for (const auto& [value, is_usual] : {std::pair(1.005 * least, true),
                                          {0.995 * least, false},
                                          {0.995 * most, true},
                                          {1.005 * most, false}}) {
      DropTestFit fit = Usual();
      (fit.*member).value = value;
      EXPECT_EQ(FindDoubts(fit, {}, {}).Has(kind), !is_usual) << value;
      (fit.*member).determined = false;
      EXPECT_FALSE(FindDoubts(fit, {}, {}).Has(kind)) << "nothing is known of it";
    }
  };
  EXPECT_THAT(FindDoubts(Usual(), {}, {}).list(), IsEmpty());
  expect(FindingKind::kUnusualFrequency, &DropTestFit::natural_frequency, 20, 2000);
  expect(FindingKind::kUnusualQuality, &DropTestFit::quality_factor, 0.05, 1000);
  expect(FindingKind::kUnusualForceConstant, &DropTestFit::force_constant, 1e-3, 100);
  for (const auto& [peak_v, is_usual] :
       {std::pair(1.005e-5, true), {0.995e-5, false}, {99.5, true}, {100.5, false}}) {
    DropTestFit fit = Usual();
    fit.records[0].peak_v = peak_v;
    EXPECT_EQ(tests::NumberOf(FindDoubts(fit, {}, {}), FindingKind::kUnusualVoltage, "peak_v"),
              is_usual ? 0 : peak_v);
  }
}

TEST(Plausibility, OfGivenNumbersDoubtsBeginAtTheEndsOfTheRanges) {
  const auto expect = [](FindingKind kind, std::optional<Quantity> ActuatorKnowns::* member,
                         double least, double most) {
    for (const auto& [value, is_usual] : {std::pair(1.005 * least, true),
                                          {0.995 * least, false},
                                          {0.995 * most, true},
                                          {1.005 * most, false}}) {
      ActuatorKnowns knowns;
      knowns.*member = Quantity{value, 0};
      EXPECT_EQ(FindDoubts(Usual(), {}, knowns).Has(kind), !is_usual) << value;
    }
  };
  expect(FindingKind::kUnusualMovingMass, &ActuatorKnowns::moving_mass_kg, 1e-5, 0.1);
  expect(FindingKind::kUnusualCaseMass, &ActuatorKnowns::case_mass_kg, 1e-5, 1);
  expect(FindingKind::kUnusualResistance, &ActuatorKnowns::resistance_ohm, 0.1, 1e4);
  for (const auto& [height_m, is_usual] :
       {std::pair(1.005e-4, true), {0.995e-4, false}, {0.995, true}, {1.005, false}}) {
    ImpulseRecord record;
    record.drop_height_m = Quantity{height_m, 0};
    EXPECT_EQ(FindDoubts(Usual(), {record}, {}).Has(FindingKind::kUnusualHeight), !is_usual);
  }
}

}  // namespace
}  // namespace haptometer::fit
