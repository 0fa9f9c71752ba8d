#include "sim/scene/plausible_ranges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
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

}  // namespace
}  // namespace haptometer::sim
