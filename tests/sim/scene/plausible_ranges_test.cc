#include "sim/scene/plausible_ranges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <variant>
#include <vector>

#include "tests/findings.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> DoubtedIn(const Scene& scene) {
  Findings findings;
  DoubtUnusual(scene, findings);
  std::vector<std::string> keys;
  for (const Finding& found : findings.list()) {
    EXPECT_EQ(found.kind, FindingKind::kUnusualNumber);
    EXPECT_EQ(found.severity, Severity::kDoubt);
    keys.push_back(std::get<std::string>(found.numbers.front().value));
  }
  return keys;
}

TEST(UsualNumbers, OfTheThesisAreAllUsual) {
  EXPECT_THAT(DoubtedIn(tests::AdapterScene()), IsEmpty());
  EXPECT_THAT(DoubtedIn(tests::ConeScene()), IsEmpty());
  EXPECT_THAT(DoubtedIn(tests::DirectScene()), IsEmpty());
}

TEST(UsualNumbers, ThoseInAnotherUnitAreDoubtedByTheirKey) {
  const auto with = [](const std::function<void(Scene&)>& change) {
    Scene scene = tests::AdapterScene();
    change(scene);
    return DoubtedIn(scene);
  };
  EXPECT_THAT(with([](Scene& of) { of.adapter->skin_side_mass_kg = 4.35; }),
              ElementsAre("adapter.skin_side_mass_kg"));
  EXPECT_THAT(with([](Scene& of) { of.adapter->motor_side_mass_kg = 0.25; }),
              ElementsAre("adapter.motor_side_mass_kg"));
  EXPECT_THAT(with([](Scene& of) { of.actuator.moving_mass_kg = 1.4; }),
              ElementsAre("actuator.moving_mass_kg"));
  EXPECT_THAT(with([](Scene& of) { of.actuator.stiffness_n_per_m = 2.8e6; }),
              ElementsAre("the actuator's resonance in Hz"));
  EXPECT_THAT(with([](Scene& of) { of.drive.frequency_hz = 225e3; }),
              ElementsAre("the drive's frequency in Hz"));
  EXPECT_THAT(with([](Scene& of) { of.drive.amplitude_v = 5000; }),
              ElementsAre("the drive's voltage in V"));
  EXPECT_THAT(with([](Scene& of) { of.skin.stiffness_n_per_m = 600e3; }),
              ElementsAre("skin.stiffness_n_per_m"));
}

// a massless side, no skin, no drive
TEST(UsualNumbers, NothingIsNoMistake) {
  Scene scene = tests::AdapterScene();
  scene.adapter->motor_side_mass_kg = 0;
  scene.skin = {};
  scene.drive.amplitude_v = 0;
  EXPECT_THAT(DoubtedIn(scene), IsEmpty());
}

TEST(UsualNumbers, AKeyIsDoubtedOnce) {
  Scene scene = tests::AdapterScene();
  scene.adapter->skin_side_mass_kg = 4.35;
  Findings findings;
  DoubtUnusual(scene, findings);
  DoubtUnusual(scene, findings);
  EXPECT_EQ(findings.list().size(), 1U);
}

struct RangeCase {
  const char* key;
  void (*set)(Scene& scene, double value);
  double least, most;
};

// a resonance by its spring, with 1 g on it
void SetResonanceHz(Scene& scene, double hertz) {
  scene.actuator.moving_mass_kg = 1e-3;
  scene.actuator.stiffness_n_per_m = 1e-3 * std::pow(2 * std::numbers::pi * hertz, 2);
}

const RangeCase kRangeCases[] = {
    {"actuator.case_mass_kg", [](Scene& of, double x) { of.actuator.case_mass_kg = x; }, 1e-5, 1},
    {"actuator.force_constant_n_per_a",
     [](Scene& of, double x) { of.actuator.force_constant_n_per_a = x; }, 1e-3, 100},
    {"actuator.resistance_ohm", [](Scene& of, double x) { of.actuator.resistance_ohm = x; }, 0.1,
     1e4},
    {"the actuator's resonance in Hz", SetResonanceHz, 20, 2000},
    {"adapter.motor_side_mass_kg", [](Scene& of, double x) { of.adapter->motor_side_mass_kg = x; },
     1e-5, 0.1},
    {"adapter.skin_side_mass_kg", [](Scene& of, double x) { of.adapter->skin_side_mass_kg = x; },
     1e-5, 0.1},
    {"skin.stiffness_n_per_m", [](Scene& of, double x) { of.skin.stiffness_n_per_m = x; }, 30, 3e4},
    {"skin.damping_n_s_per_m", [](Scene& of, double x) { of.skin.damping_n_s_per_m = x; }, 0.02,
     50},
    {"the drive's frequency in Hz", [](Scene& of, double x) { of.drive.frequency_hz = x; }, 10,
     5000}};

// within a thousandth of either end, with the ends in the finding
TEST(UsualNumbers, EndWhereTheirRangesEnd) {
  for (const RangeCase& range : kRangeCases) {
    const auto doubted = [&](double value) {
      Scene scene = tests::AdapterScene();
      range.set(scene, value);
      return DoubtedIn(scene);
    };
    EXPECT_THAT(doubted(range.least * 1.001), IsEmpty()) << range.key;
    EXPECT_THAT(doubted(range.most * 0.999), IsEmpty()) << range.key;
    EXPECT_THAT(doubted(range.least * 0.999), ElementsAre(range.key));
    EXPECT_THAT(doubted(range.most * 1.001), ElementsAre(range.key));
    Scene scene = tests::AdapterScene();
    range.set(scene, range.most * 2);
    Findings findings;
    DoubtUnusual(scene, findings);
    const FindingKind kind = FindingKind::kUnusualNumber;
    EXPECT_DOUBLE_EQ(tests::NumberOf(findings, kind, "value"), range.most * 2) << range.key;
    EXPECT_EQ(tests::NumberOf(findings, kind, "least"), range.least) << range.key;
    EXPECT_EQ(tests::NumberOf(findings, kind, "most"), range.most) << range.key;
  }
}

// the mass has another doubt instead of that of its resonance
TEST(UsualNumbers, AMassOutsideOfItsRangeIsDoubtedAlone) {
  for (const double mass_kg : {0.999e-5, 0.1001}) {
    Scene scene = tests::AdapterScene();
    scene.actuator.moving_mass_kg = mass_kg;
    EXPECT_THAT(DoubtedIn(scene), ElementsAre("actuator.moving_mass_kg")) << mass_kg;
  }
  Scene scene = tests::AdapterScene();
  scene.actuator.moving_mass_kg = 0.0999;  // at 26 Hz
  EXPECT_THAT(DoubtedIn(scene), IsEmpty());
}

// an offset counts
TEST(UsualNumbers, EndAtFiftyVolts) {
  Scene scene = tests::AdapterScene();
  scene.drive.amplitude_v = 40;
  scene.drive.offset_v = -9.99;
  EXPECT_THAT(DoubtedIn(scene), IsEmpty());
  scene.drive.offset_v = -10.01;
  EXPECT_THAT(DoubtedIn(scene), ElementsAre("the drive's voltage in V"));
}

}  // namespace
}  // namespace haptometer::sim
