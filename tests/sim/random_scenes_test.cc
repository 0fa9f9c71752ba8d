#include "tests/sim/random_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <map>
#include <string>

#include "sim/effect_choice.h"
#include "sim/scene/scene_file.h"
#include "tests/repetitions.h"

namespace haptometer::sim {
namespace {

// what is named and what is asked about, all of it at once
EffectSet Everything(const Scene& scene) {
  EffectSet on;
  for (std::size_t k = 0; k < on.size(); ++k) on[k] = scene.effects.wishes[k] != Wish::kOff;
  return on;
}

// how the scenes came out
struct Tally {
  int refused_by_reader = 0, refused = 0, answered = 0, active = 0, smooth = 0;
  int idle = 0, idle_dropped = 0;
  std::map<int, int> reasons{};  // by the refusal's kind
};

void CheckScene(const Scene& scene, const std::string& text, const std::string& name,
                Tally& tally) {
  const auto choice = ChooseEffects(scene);
  if (!choice) {
    ++tally.refused;
    ++tally.reasons[static_cast<int>(choice.error().kind)];
    return;
  }
  ++tally.answered;
  const EffectSet all = Everything(scene);
  const PlayedScene everything = PlayWith(scene, all);
  const PlayedScene chosen = PlayWith(scene, choice->on);
  ASSERT_TRUE(everything.answered && chosen.answered) << name << "\n" << text;
  // every number and the waveform, up to what both runs state
  const double stated = choice->run.error_estimate + everything.run.error_estimate;
  for (const SceneRun* run : {&chosen.run, &choice->run}) {
    const double apart = std::max(LargestDeviation(*run, everything.run),
                                  Deviation(AskedQuantity::kSkinWaveform, *run, everything.run));
    EXPECT_LE(apart, stated) << name << ", " << all << " as " << choice->on << "\n" << text;
  }
  tally.active += everything.run.events.empty() ? 0 : 1;
  tally.smooth += everything.run.solver_tolerance > 0 ? 1 : 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (scene.effects.wishes[k] != Wish::kAuto) continue;
    EffectSet without = all;
    const PlayedScene played = PlayWith(scene, without.reset(k));
    if (!played.answered) continue;
    const double change = Deviation(scene.quantity, played.run, everything.run);
    if (!(change < 0.01 * scene.tolerance)) continue;
    ++tally.idle;
    tally.idle_dropped += choice->on[k] ? 0 : 1;
    if (choice->on[k] && std::getenv("HAPTOMETER_SHOW_RESIDUALS") != nullptr) {
      std::cout << name << " keeps " << kEffectNames[k] << ", " << change << " of "
                << scene.tolerance << "\n";
    }
  }
}

TEST(RandomScenes, AutoStaysWithinTheTolerance) {
  constexpr std::uint64_t kSeed = 20261122;
  tests::RandomScenes random(kSeed);
  const int count = tests::Repetitions(tests::kIsSanitized ? 3 : 30);
  Tally tally;
  for (int i = 0; i < count;) {
    const std::string text = random.Next();
    const auto scene = ReadSceneText(text, "scene.toml");
    if (!scene) {
      ++tally.refused_by_reader;
      EXPECT_EQ(scene.error().cause, Cause::kUsage) << scene.error().Text() << "\n" << text;
      continue;
    }
    CheckScene(*scene, text, "seed " + std::to_string(kSeed) + ", scene " + std::to_string(i++),
               tally);
  }
  std::cout << count << " scenes, seed " << kSeed << " (and " << tally.refused_by_reader
            << " refused by the reader): " << tally.answered << " answered, " << tally.smooth
            << " by the solver, " << tally.active << " with events; of " << tally.idle
            << " effects that change less than a hundredth of the tolerance " << tally.idle_dropped
            << " are left out\n";
  for (const auto& [reason, times] : tally.reasons) {
    std::cout << "  " << times << " refused: " << reason << "\n";
  }
  EXPECT_GE(4 * tally.active, tally.answered) << "at least a quarter with an effect active";
  EXPECT_GE(10 * tally.answered, 8 * count) << "most are answered";
  EXPECT_GE(2 * tally.idle_dropped, tally.idle) << "proofs and bounds find most of them";
}

}  // namespace
}  // namespace haptometer::sim
