#include "sim/effect_choice.h"

#include <gtest/gtest.h>

#include "sim/steady_state.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kDurationS = 0.05;

Scene Asking(double gap_m, double preload_n) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  scene.effects.travel_stops =
      TravelStops{.gap_up_m = gap_m, .gap_down_m = gap_m, .restitution = 0.5};
  scene.effects.contact_loss = ContactLoss{preload_n};
  for (const Effect effect : {Effect::kGravity, Effect::kTravelStops, Effect::kContactLoss}) {
    scene.effects[effect] = Wish::kAuto;
  }
  return scene;
}

const EffectVerdict& VerdictOf(const EffectChoice& choice, Effect effect) {
  return choice.verdicts[PlaceOf(effect)];
}

TEST(EffectChoice, LeavesOutWhatIsNeverReachedInOneRun) {
  const Scene scene = Asking(5e-3, 10);
  const EffectChoice choice = ChooseEffects(scene, kDurationS);
  EXPECT_EQ(choice.on, EffectSet(1));  // the inductance alone
  EXPECT_EQ(VerdictOf(choice, Effect::kTravelStops).ground, Ground::kNeverReached);
  EXPECT_EQ(VerdictOf(choice, Effect::kContactLoss).ground, Ground::kNeverReached);
  EXPECT_EQ(VerdictOf(choice, Effect::kGravity).ground, Ground::kSuperposed);
  EXPECT_EQ(VerdictOf(choice, Effect::kTremor).ground, Ground::kNotNamed);
  EXPECT_EQ(choice.runs, 1U);
  // as if nobody had asked
  EXPECT_EQ(choice.run.skin_m, RunScene(WithEffects(scene, EffectSet(1)), kDurationS).skin_m);
}

TEST(EffectChoice, KeepsWhatChangesTheAnswer) {
  const EffectChoice choice = ChooseEffects(Asking(0.3e-3, 0.01), kDurationS);
  EXPECT_TRUE(VerdictOf(choice, Effect::kTravelStops).on);
  EXPECT_TRUE(VerdictOf(choice, Effect::kContactLoss).on);
  EXPECT_TRUE(VerdictOf(choice, Effect::kGravity).on) << "more than the preload";
  EXPECT_GT(VerdictOf(choice, Effect::kTravelStops).change, 1e-3);
  EXPECT_EQ(choice.change, 0);
}

TEST(EffectChoice, TheToleranceDecides) {
  Scene scene = Asking(0.3e-3, 10);
  const double change =
      VerdictOf(ChooseEffects(scene, kDurationS), Effect::kGravity).change;  // moves the stops
  EXPECT_GT(change, 1e-10);
  scene.tolerance = 0.9 * change;
  EXPECT_TRUE(VerdictOf(ChooseEffects(scene, kDurationS), Effect::kGravity).on);
  scene.tolerance = 1.1 * change;
  const EffectChoice loose = ChooseEffects(scene, kDurationS);
  EXPECT_FALSE(VerdictOf(loose, Effect::kGravity).on);
  EXPECT_EQ(VerdictOf(loose, Effect::kGravity).ground, Ground::kCompared);
  EXPECT_LE(loose.change, scene.tolerance);
  EXPECT_GT(loose.change, 0);
}

TEST(EffectChoice, OfStopsThatAreNamedGravityIsCompared) {
  Scene scene = Asking(0.3e-3, 10);
  scene.effects[Effect::kTravelStops] = Wish::kOn;
  scene.tolerance = 1;
  const EffectChoice choice = ChooseEffects(scene, kDurationS);
  EXPECT_TRUE(VerdictOf(choice, Effect::kTravelStops).on);
  EXPECT_EQ(VerdictOf(choice, Effect::kTravelStops).ground, Ground::kNamed);
  EXPECT_EQ(VerdictOf(choice, Effect::kGravity).ground, Ground::kCompared);
}

// whether the inductance matters depends on what is asked
TEST(EffectChoice, TheInductanceMattersForTheWaveformFirst) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kSteady;
  scene.effects[Effect::kInductance] = Wish::kAuto;
  scene.tolerance = 1e-3;
  const EffectChoice rms = ChooseEffects(scene, kDurationS);
  EXPECT_FALSE(VerdictOf(rms, Effect::kInductance).on);
  EXPECT_REL(VerdictOf(rms, Effect::kInductance).change, 6.6e-5, 0.02, "two printed digits");
  scene.quantity = AskedQuantity::kSkinWaveform;
  const EffectChoice waveform = ChooseEffects(scene, kDurationS);
  EXPECT_TRUE(VerdictOf(waveform, Effect::kInductance).on);
  EXPECT_REL(VerdictOf(waveform, Effect::kInductance).change, 5.2e-3, 0.05,
             "a lag of 5.2 mrad, two digits");
}

}  // namespace
}  // namespace haptometer::sim
