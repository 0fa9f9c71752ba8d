#include "fit/drop_test/drop_test_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using tests::MakeRecord;
using tests::MakeRecordWithHeight;
using tests::SyntheticDrop;
using tests::ThesisKnowns;
using Kind = DropTestInput::Kind;

const double kAngular = std::sqrt(2e6);  // rad/s, of the records below

// a prepared record of a few samples, made by hand
PreparedRecord ByHand() {
  PreparedRecord prepared;
  prepared.record.name = "drop.csv";
  prepared.record.step_s = 1e-4;
  prepared.record.voltage_v = {0, 0, 0.4, 0.3, 0.2, 0.1, 0, -0.1, -0.2, -0.1};
  prepared.record.load_ohm = Quantity{33, 0};
  prepared.start.poles = {11.5, 2e6};
  prepared.start.impact_voltage_v = 0.4;
  prepared.start.residual_rms_v = 1e-3;
  prepared.part.first_sample = 2;
  prepared.part.end_sample = 10;
  prepared.part.poles = prepared.start.poles;
  return prepared;
}

DropTestModel ModelOf(std::vector<PreparedRecord> records,
                      const ActuatorKnowns& knowns = ThesisKnowns()) {
  auto model = MakeDropTestModel(std::move(records), knowns);
  EXPECT_TRUE(model) << model.error().Text();
  return model ? *std::move(model) : DropTestModel{};
}

std::vector<DropTestInput> OfKind(const DropTestModel& model, Kind kind) {
  std::vector<DropTestInput> found;
  std::ranges::copy_if(model.inputs, std::back_inserter(found),
                       [kind](const DropTestInput& input) { return input.kind == kind; });
  return found;
}

// what a force of half a sine leaves of the ringing that a sudden impact gives: |sum of f(u) e^(j w
// u)| over the sum of f(u), by the middle rule
double LeftByHalfSine(double angle) {
  constexpr int kSteps = 20'000;
  std::complex<double> ringing = 0;
  double push = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double share = (k + 0.5) / kSteps;
    const double force = std::sin(std::numbers::pi * share);
    ringing += std::polar(force, angle * share);
    push += force;
  }
  return std::abs(ringing) / push;
}

std::optional<Quantity> ContactOf(double shortest_s, double longest_s, double friction_share = 0) {
  PreparedRecord prepared = ByHand();
  prepared.record.drop_height_m = Quantity{0.01, 0};
  prepared.start.shortest_contact_s = shortest_s;
  prepared.start.longest_contact_s = longest_s;
  prepared.part.friction_share = friction_share;
  const auto contacts = OfKind(ModelOf({prepared}), Kind::kContact);
  if (contacts.empty()) return std::nullopt;
  EXPECT_EQ(contacts.size(), 1U);
  return contacts[0].quantity;
}

TEST(ContactShare, OfASeenContactIsTheMiddleOfBothLengths) {
  const double least = LeftByHalfSine(kAngular * 0.9e-3);
  const double most = LeftByHalfSine(kAngular * 0.5e-3);
  const auto contact = ContactOf(0.5e-3, 0.9e-3);
  ASSERT_TRUE(contact);
  EXPECT_REL(contact->value, (least + most) / 2, 1e-8, "middle rule");
  // 95 % between the two are two standard uncertainties on either side
  EXPECT_REL(contact->standard_uncertainty, (most - least) / 4, 1e-6, "middle rule");
}

TEST(ContactShare, OfOneThatNoSampleShowsIsAnUncertaintyAlone) {
  const auto contact = ContactOf(0, 0.3e-3);
  ASSERT_TRUE(contact);
  EXPECT_EQ(contact->value, 1);
  EXPECT_REL(contact->standard_uncertainty, (1 - LeftByHalfSine(kAngular * 0.3e-3)) / 2, 1e-5,
             "middle rule");
  EXPECT_FALSE(ContactOf(0, 0)) << "not looked for";
}

TEST(ContactShare, DryFrictionBrakesUntilItsMiddle) {
  // the speed falls by w^2 f in a unit of time, f the friction as a share of the first swing's
  // travel v/w: by f w T/2 of itself in half the contact, half of which is removed
  const auto without = ContactOf(0.5e-3, 0.9e-3);
  const auto with = ContactOf(0.5e-3, 0.9e-3, 0.02);
  const double braked = 0.02 * kAngular * 0.9e-3 / 2 / 2;
  EXPECT_REL(without->value - with->value, braked, 1e-12, "rounding");
  EXPECT_REL(with->standard_uncertainty, std::hypot(without->standard_uncertainty, braked / 2),
             1e-12, "all of it is uncertain");
}

TEST(ContactShare, EndsAtLengthsThatAreNotLookedFor) {
  const auto left = [](double angle) {
    const double length_s = angle / kAngular;
    return ContactOf(length_s, length_s)->value;
  };
  EXPECT_REL(left(2.79), LeftByHalfSine(2.79), 1e-8, "middle rule");
  EXPECT_REL(left(3.5), LeftByHalfSine(2.8), 1e-8, "0.9 of a half period");
}

TEST(DropTestInputs, AnUnstatedReboundIsUniformBetweenNoneAndThreeTenths) {
  PreparedRecord prepared = ByHand();
  prepared.record.drop_height_m = Quantity{0.01, 0};
  auto rebounds = OfKind(ModelOf({prepared}), Kind::kRebound);
  ASSERT_EQ(rebounds.size(), 1U);
  EXPECT_EQ(rebounds[0].name, "rebound (not stated)");
  EXPECT_EQ(rebounds[0].quantity.value, 0);
  EXPECT_REL(rebounds[0].quantity.standard_uncertainty, 0.3 / std::sqrt(3.0), 1e-15, "RMS about 0");
  prepared.record.rebound = Quantity{0.2, 0.05};
  rebounds = OfKind(ModelOf({prepared}), Kind::kRebound);
  EXPECT_EQ(rebounds.at(0).name, "rebound");
  EXPECT_EQ(rebounds.at(0).quantity, (Quantity{0.2, 0.05}));
}

TEST(DropTestInputs, EqualNumbersOfSeveralRecordsAreOne) {
  auto other = ByHand();
  other.record.load_ohm = Quantity{33, 1};
  const auto loads = OfKind(ModelOf({ByHand(), other, ByHand()}), Kind::kLoad);
  ASSERT_EQ(loads.size(), 2U);
  EXPECT_EQ(loads[0].records, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(loads[1].records, (std::vector<std::size_t>{1}));
}

TEST(ApplyInputs, GiveEachRecordItsSpeedScalesAndMasses) {
  auto dropped = ByHand();
  dropped.record.drop_height_m = Quantity{0.02, 0};
  dropped.record.rebound = Quantity{0.25, 0};
  dropped.record.voltage_scale = Quantity{1.1, 0};
  dropped.record.time_scale = Quantity{1.02, 0};
  dropped.start.shortest_contact_s = dropped.start.longest_contact_s = 0.5e-3;
  auto released = ByHand();
  released.record.release_current_a = Quantity{0.05, 0};
  released.record.voltage_scale = Quantity{1.1, 0};
  released.record.added_mass_kg = Quantity{0.3e-3, 0};
  auto free = ByHand();
  free.record.condition = CaseCondition::kFree;
  const auto model = ModelOf({dropped, released, free});
  for (const bool use_heights : {true, false}) {
    RingDownProblem problem = MakeProblem(model);
    RingDownPoint point;
    ApplyInputs(model.inputs, model, use_heights, &problem, &point);
    const auto& records = problem.records();
    // v0 = (1 + e) sqrt(2 g h), what the contact leaves, and what the recorder shows
    const double speed =
        1.25 * std::sqrt(2 * 9.80665 * 0.02) * LeftByHalfSine(kAngular * 0.5e-3) * 1.1;
    EXPECT_ABS(records[0].speed_m_per_s, use_heights ? speed : 0, 1e-8, "middle rule");
    EXPECT_EQ(records[0].time_scale, 1.02);
    EXPECT_EQ(records[0].load_ohm, 33);
    EXPECT_REL(records[1].release_current_a, 0.05 * 1.1, 1e-15, "rounding");
    EXPECT_EQ(records[1].added_mass_kg, 0.3e-3);
    EXPECT_EQ(records[1].speed_m_per_s, 0);
    EXPECT_EQ(records[1].time_scale, 1);
    // Mc/(Mv + Mc) of a free case among held ones
    EXPECT_EQ(records[1].mass_ratio, 1);
    EXPECT_REL(records[2].mass_ratio, 0.3, 1e-15, "0.6 g of 2 g");
    EXPECT_REL(std::exp(point.shared[Index(Shared::kMass)]), 1.4e-3, 1e-14, "the mover's");
    EXPECT_REL(std::exp(point.shared[Index(Shared::kResistance)]), 27.0, 1e-14, "given");
    EXPECT_EQ(problem.inductance_h(), 130e-6);
  }
  // where all cases are free, M is the reduced mass
  const auto all_free = ModelOf({free, free});
  RingDownProblem problem = MakeProblem(all_free);
  RingDownPoint point;
  ApplyInputs(all_free.inputs, all_free, false, &problem, &point);
  EXPECT_REL(std::exp(point.shared[Index(Shared::kMass)]), 1.4e-3 * 0.3, 1e-14, "Mv Mc/(Mv + Mc)");
  EXPECT_EQ(problem.records()[0].mass_ratio, 1);
}

TEST(MakeProblem, HasTheMeasuredSamplesOfEachPartWithItsBackground) {
  auto humming = ByHand();
  humming.part.background = {.drifts = false, .hum_hz = {50}};
  humming.record.voltage_v[4] = std::nan("");
  auto drifting = ByHand();
  drifting.part.background = {.drifts = true};
  drifting.record.start_s = -0.5;
  drifting.start.impact_voltage_v = -0.4;
  drifting.start.residual_rms_v = 0;
  drifting.part.linear_less_friction_v = {1, 2, 3, 4, 5, 6, 7, 8};
  const RingDownProblem problem = MakeProblem(ModelOf({humming, drifting}));
  const RingDownSamples& first = problem.records().at(0);
  const RingDownSamples& second = problem.records().at(1);
  EXPECT_EQ(first.hum_hz, std::vector<double>{50});
  EXPECT_TRUE(second.hum_hz.empty());
  EXPECT_FALSE(first.drifts);
  EXPECT_TRUE(second.drifts);
  EXPECT_EQ(first.voltages_v, (std::vector<double>{0.4, 0.3, 0.1, 0, -0.1, -0.2, -0.1}));
  ASSERT_EQ(first.times_s.size(), 7U);
  EXPECT_DOUBLE_EQ(first.times_s[1], 3e-4);
  EXPECT_DOUBLE_EQ(first.times_s[2], 5e-4) << "one sample is missing";
  // the friction's share is added from the part's first sample on
  ASSERT_EQ(second.voltages_v.size(), 8U);
  EXPECT_DOUBLE_EQ(second.voltages_v[0], 1.4);
  EXPECT_DOUBLE_EQ(second.voltages_v[7], 7.9);
  EXPECT_DOUBLE_EQ(second.times_s[0], -0.5 + 2e-4);
  EXPECT_EQ(first.polarity, 1);
  EXPECT_EQ(second.polarity, -1);
  EXPECT_EQ(first.noise_v, 1e-3);
  EXPECT_DOUBLE_EQ(second.noise_v, 0.4e-12) << "a record without noise keeps finite weights";
  EXPECT_EQ(first.step_s, 1e-4);
}

TEST(MakeProblem, OfAReleaseThePolarityIsThatOfItsSlope) {
  auto released = ByHand();
  released.record.release_current_a = Quantity{0.05, 0};
  released.start.release_slope_v_per_s = -3;
  const RingDownProblem problem = MakeProblem(ModelOf({released}));
  EXPECT_EQ(problem.records().at(0).polarity, -1);
  EXPECT_EQ(problem.records().at(0).signal, RingingSignal::kReleaseVoltage);
}

// the start values of noise-free records, whose own poles are exact
RingDownPoint Start(const std::vector<ImpulseRecord>& records, bool use_heights,
                    const ActuatorKnowns& knowns = ThesisKnowns()) {
  const auto model = MakeDropTestModel(records, knowns);
  EXPECT_TRUE(model) << model.error().Text();
  RingDownProblem problem = MakeProblem(*model);
  return StartPoint(*model, use_heights, &problem);
}

void ExpectTruth(const RingDownPoint& start) {
  constexpr const char* kReason = "the inductance turns the poles by less than 1e-4";
  EXPECT_REL(std::exp(start.shared[Index(Shared::kStiffness)]), 2800.0, 1e-3, kReason);
  EXPECT_REL(std::exp(start.shared[Index(Shared::kDamping)]), 0.0322, 2e-3, kReason);
  EXPECT_REL(start.shared[Index(Shared::kForceConstantSquared)], 1.0, 2e-3, kReason);
  EXPECT_REL(std::exp(start.shared[Index(Shared::kMass)]), 1.4e-3, 2e-3, kReason);
}

SyntheticDrop Loaded(double load_ohm) {
  SyntheticDrop drop;
  drop.load_ohm = load_ohm;
  return drop;
}

TEST(StartPoint, TwoLoadsGiveTheConstants) {
  const auto start =
      Start({MakeRecord({}), MakeRecord(Loaded(33)), MakeRecord(Loaded(100))}, false);
  ExpectTruth(start);
  for (const auto& own : start.own) {
    // the load's divider is removed: Km v0 of all three
    EXPECT_REL(std::exp(own[Index(Own::kAmplitude)]), std::sqrt(0.02 * 9.80665), 1e-3,
               "the inductance's phase");
    EXPECT_ABS(own[Index(Own::kImpact)], 0.37e-4, 1e-5, "the inductance's delay of 5 us");
    EXPECT_ABS(own[Index(Own::kOffset)], 0.01, 1e-4, "noise-free");
  }
}

TEST(StartPoint, AHeightGivesTheForceConstantOfOneRecord) {
  ExpectTruth(Start({MakeRecordWithHeight(Loaded(33))}, true));
}

TEST(StartPoint, AReleasedCurrentGivesTheForceConstant) {
  SyntheticDrop drop;
  drop.release_current_a = 0.05;
  drop.offset_v = 1e-3;
  const auto start = Start({MakeRecord(drop)}, false);
  ExpectTruth(start);
  EXPECT_ABS(start.own.at(0)[Index(Own::kImpact)], 0.37e-4, 1e-6, "its zero");
}

TEST(StartPoint, AnUnknownMassFollowsFromAnAddedOneOrFromHeightsAndLoads) {
  auto knowns = ThesisKnowns();
  knowns.moving_mass_kg.reset();
  knowns.case_mass_kg.reset();
  SyntheticDrop heavy;
  heavy.added_mass_kg = 0.5e-3;
  ExpectTruth(Start({MakeRecord({}), MakeRecord(Loaded(33)), MakeRecord(heavy)}, false, knowns));
  ExpectTruth(Start({MakeRecordWithHeight({}), MakeRecordWithHeight(Loaded(33))}, true, knowns));
}

TEST(UnknownColumns, AreThoseThatNothingGives) {
  auto dropped = ByHand();
  dropped.record.drop_height_m = Quantity{0.02, 0};
  dropped.part.background = {.drifts = true};
  auto humming = ByHand();
  humming.part.background = {.drifts = false, .hum_hz = {60}};
  auto knowns = ThesisKnowns();
  knowns.resistance_ohm.reset();
  const auto model = ModelOf({dropped, humming}, knowns);
  RingDownProblem problem = MakeProblem(model);
  RingDownPoint point;
  ApplyInputs(model.inputs, model, true, &problem, &point);
  const auto unknown = UnknownColumns(model, problem);
  EXPECT_FALSE(unknown[Index(Shared::kMass)]);
  EXPECT_TRUE(unknown[Index(Shared::kResistance)]);
  EXPECT_TRUE(unknown[Index(Shared::kForceConstantSquared)]);
  const auto own = [&](std::size_t record) {
    return std::vector<bool>(
        unknown.begin() + static_cast<std::ptrdiff_t>(Column(record, Own::kAmplitude)),
        unknown.begin() + static_cast<std::ptrdiff_t>(Column(record, Own::kHumSine)) + 1);
  };
  // amplitude, impact, offset, drift, hum's cosine and sine
  EXPECT_EQ(own(0), (std::vector<bool>{false, true, true, true, false, false}));
  EXPECT_EQ(own(1), (std::vector<bool>{true, true, true, false, true, true}));
}

TEST(MakeDropTestModel, StatementsThatDoNotGoTogetherAreRefused) {
  const auto error = [](const std::function<void(ImpulseRecord&)>& state) {
    auto prepared = ByHand();
    state(prepared.record);
    const auto model = MakeDropTestModel(std::vector{prepared}, ThesisKnowns());
    return model ? "" : model.error().what;
  };
  const Quantity height{0.01, 0};
  const Quantity current{0.05, 0};
  const Quantity added{1e-4, 0};
  EXPECT_EQ(error([&](auto& record) { record.drop_height_m = height; }), "");
  EXPECT_EQ(error([&](auto& record) { record.release_current_a = current; }), "");
  EXPECT_EQ(error([&](auto& record) { record.added_mass_kg = added; }), "");
  EXPECT_EQ(error([](auto& record) { record.signal = RecordedSignal::kDisplacement; }), "");
  EXPECT_EQ(error([](auto& record) { record.condition = CaseCondition::kFree; }), "");
  EXPECT_EQ(error([&](auto& record) {
              record.drop_height_m = height;
              record.release_current_a = current;
            }),
            "states a drop height and a released current");
  EXPECT_EQ(error([&](auto& record) {
              record.signal = RecordedSignal::kDisplacement;
              record.release_current_a = current;
            }),
            "is a displacement after a released current");
  EXPECT_EQ(error([&](auto& record) {
              record.condition = CaseCondition::kFree;
              record.added_mass_kg = added;
            }),
            "has an added mass and a free case");
}

TEST(MakeDropTestModel, TheMassIsKnownByWhatTheCasesNeed) {
  auto held = ByHand();
  held.record.condition = CaseCondition::kHeld;
  auto free = ByHand();
  free.record.condition = CaseCondition::kFree;
  const auto both = ThesisKnowns();
  auto mover = both;
  mover.case_mass_kg.reset();
  auto case_alone = both;
  case_alone.moving_mass_kg.reset();
  EXPECT_TRUE(ModelOf({held}, mover).knows_mass);
  EXPECT_TRUE(ModelOf({held}, both).knows_mass);
  EXPECT_FALSE(ModelOf({held}, case_alone).knows_mass);
  EXPECT_TRUE(ModelOf({free}, both).knows_mass);
  EXPECT_FALSE(ModelOf({free}, mover).knows_mass);
  EXPECT_FALSE(ModelOf({free, free}, case_alone).knows_mass);
  EXPECT_TRUE(ModelOf({free, free}, both).all_free);
  EXPECT_FALSE(ModelOf({held, free}, both).all_free);
  EXPECT_TRUE(ModelOf({held, free}, both).knows_mass);
  // their ratio needs both masses
  for (const auto& knowns : {mover, case_alone, ActuatorKnowns{}}) {
    EXPECT_FALSE(MakeDropTestModel(std::vector{held, free}, knowns));
    EXPECT_TRUE(MakeDropTestModel(std::vector{held, held}, knowns));
    EXPECT_TRUE(MakeDropTestModel(std::vector{free, free}, knowns));
  }
  // the case's mass counts only where a case is free
  EXPECT_TRUE(OfKind(ModelOf({held}, both), Kind::kCaseMass).empty());
  EXPECT_EQ(OfKind(ModelOf({held, free}, both), Kind::kCaseMass).size(), 1U);
}

TEST(MakeDropTestModel, AHeightOfADisplacementIsNoInput) {
  auto prepared = ByHand();
  prepared.record.drop_height_m = Quantity{0.01, 0};
  EXPECT_TRUE(ModelOf({prepared}).knows_heights);
  EXPECT_EQ(OfKind(ModelOf({prepared}), Kind::kHeight).size(), 1U);
  prepared.record.signal = RecordedSignal::kDisplacement;
  EXPECT_FALSE(ModelOf({prepared}).knows_heights);
  EXPECT_TRUE(OfKind(ModelOf({prepared}), Kind::kHeight).empty());
  EXPECT_TRUE(OfKind(ModelOf({prepared}), Kind::kRebound).empty());
}

TEST(MakeDropTestModel, ResistanceAndInductanceCountUnderALoad) {
  auto open = ByHand();
  open.record.load_ohm = Quantity{tests::kOpen, 0};
  auto knowns = ThesisKnowns();
  EXPECT_TRUE(OfKind(ModelOf({open}, knowns), Kind::kResistance).empty());
  EXPECT_EQ(OfKind(ModelOf({open, ByHand()}, knowns), Kind::kResistance).size(), 1U);
  EXPECT_EQ(OfKind(ModelOf({open, ByHand()}, knowns), Kind::kInductance).size(), 1U);
  knowns.resistance_ohm.reset();
  EXPECT_TRUE(ModelOf({open}, knowns).knows_resistance);
  EXPECT_FALSE(ModelOf({open, ByHand()}, knowns).knows_resistance);
}

TEST(StartPoint, AnUnknownMassFollowsFromTwoAddedOnes) {
  auto knowns = ThesisKnowns();
  knowns.moving_mass_kg.reset();
  knowns.case_mass_kg.reset();
  std::vector<ImpulseRecord> records;
  for (const double added_kg : {0.7e-3, 0.2e-3, 0.4e-3}) {
    for (const double load_ohm : {tests::kOpen, 33.0}) {
      SyntheticDrop drop = Loaded(load_ohm);
      drop.added_mass_kg = added_kg;
      records.push_back(MakeRecord(drop));
    }
  }
  ExpectTruth(Start(records, false, knowns));
}

}  // namespace
}  // namespace haptometer::fit
