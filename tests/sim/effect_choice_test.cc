#include "sim/effect_choice.h"

#include <gtest/gtest.h>

#include <string>

#include "sim/effective_scene.h"
#include "sim/linear/steady_state.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kDurationS = 0.05;

EffectChoice Chosen(const Scene& scene) {
  auto choice = ChooseEffects(scene);
  EXPECT_TRUE(choice) << "refused by kind " << static_cast<int>(choice.error().kind);
  return choice ? *choice : EffectChoice{};
}

Scene Asking(double gap_m, double preload_n) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  scene.duration_s = kDurationS;
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
  const EffectChoice choice = Chosen(scene);
  EXPECT_EQ(choice.on, EffectSet(1));  // the inductance alone
  EXPECT_EQ(VerdictOf(choice, Effect::kTravelStops).ground, Ground::kNeverReached);
  EXPECT_EQ(VerdictOf(choice, Effect::kContactLoss).ground, Ground::kNeverReached);
  EXPECT_EQ(VerdictOf(choice, Effect::kGravity).ground, Ground::kSuperposed);
  EXPECT_EQ(VerdictOf(choice, Effect::kTremor).ground, Ground::kNotNamed);
  EXPECT_EQ(choice.runs, 1U);
  // as if nobody had asked
  EXPECT_EQ(choice.run.skin_m, RunScene(WithEffects(scene, EffectSet(1)), kDurationS).skin_m);
}

// runs are compared output by output, so all choices of a scene are looked at equally often
TEST(EffectChoice, AllChoicesHaveTheSameOutputs) {
  Scene scene = Asking(5e-3, 10);
  scene.drive.frequency_hz = 20;
  scene.finger.tones = {{.amplitude = 1e-6, .frequency_hz = 2000}};
  const EffectiveScene with = WithEffects(scene, EffectSet{}.set(PlaceOf(Effect::kTremor)));
  const EffectiveScene without = WithEffects(scene, {});
  EXPECT_NE(OutputRateHz(with.scene), OutputRateHz(without.scene));
  EXPECT_EQ(with.RateHz(), without.RateHz());
  EXPECT_EQ(RunScene(with, 0.05).skin_m.size(), RunScene(without, 0.05).skin_m.size());
}

TEST(EffectChoice, KeepsWhatChangesTheAnswer) {
  const EffectChoice choice = Chosen(Asking(0.3e-3, 0.01));
  EXPECT_TRUE(VerdictOf(choice, Effect::kTravelStops).on);
  EXPECT_TRUE(VerdictOf(choice, Effect::kContactLoss).on);
  EXPECT_TRUE(VerdictOf(choice, Effect::kGravity).on) << "more than the preload";
  EXPECT_GT(VerdictOf(choice, Effect::kTravelStops).change, 1e-3);
  EXPECT_EQ(choice.change, 0);
}

TEST(EffectChoice, TheToleranceDecides) {
  Scene scene = Asking(0.3e-3, 10);
  const double change = VerdictOf(Chosen(scene), Effect::kGravity).change;  // moves the stops
  EXPECT_GT(change, 1e-10);
  scene.tolerance = 0.9 * change;
  EXPECT_TRUE(VerdictOf(Chosen(scene), Effect::kGravity).on);
  scene.tolerance = 1.1 * change;
  const EffectChoice loose = Chosen(scene);
  EXPECT_FALSE(VerdictOf(loose, Effect::kGravity).on);
  EXPECT_EQ(VerdictOf(loose, Effect::kGravity).ground, Ground::kCompared);
  EXPECT_LE(loose.change, scene.tolerance);
  EXPECT_GT(loose.change, 0);
}

TEST(EffectChoice, OfStopsThatAreNamedGravityIsCompared) {
  Scene scene = Asking(0.3e-3, 10);
  scene.effects[Effect::kTravelStops] = Wish::kOn;
  scene.tolerance = 1;
  const EffectChoice choice = Chosen(scene);
  EXPECT_TRUE(VerdictOf(choice, Effect::kTravelStops).on);
  EXPECT_EQ(VerdictOf(choice, Effect::kTravelStops).ground, Ground::kNamed);
  EXPECT_EQ(VerdictOf(choice, Effect::kGravity).ground, Ground::kCompared);
}

// whether the inductance matters depends on what is asked
TEST(EffectChoice, TheInductanceMattersForTheWaveformFirst) {
  Scene scene = tests::AdapterScene();
  scene.duration_s = kDurationS;
  scene.start = Start::kSteady;
  scene.effects[Effect::kInductance] = Wish::kAuto;
  scene.tolerance = 1e-3;
  const EffectChoice rms = Chosen(scene);
  EXPECT_FALSE(VerdictOf(rms, Effect::kInductance).on);
  EXPECT_REL(VerdictOf(rms, Effect::kInductance).change, 6.6e-5, 0.02, "two printed digits");
  scene.quantity = AskedQuantity::kSkinWaveform;
  const EffectChoice waveform = Chosen(scene);
  EXPECT_TRUE(VerdictOf(waveform, Effect::kInductance).on);
  EXPECT_REL(VerdictOf(waveform, Effect::kInductance).change, 5.2e-3, 0.05,
             "a lag of 5.2 mrad, two digits");
}

// without a duration the motion that the scene settles to decides
TEST(EffectChoice, OfASceneThatSettlesComparesPeriodicMotions) {
  Scene scene = Asking(5e-3, 10);
  scene.duration_s.reset();
  const EffectChoice free = Chosen(scene);
  EXPECT_EQ(free.on, EffectSet(1));
  EXPECT_FALSE(free.periodic);
  EXPECT_REL(free.run.skin_rms_m, SolveSteadyState(scene).skin_rms_m, 1e-12, "whole periods");

  scene = Asking(0.4e-3, 10);
  scene.duration_s.reset();
  scene.effects[Effect::kGravity] = Wish::kOff;
  const EffectChoice limited = Chosen(scene);
  ASSERT_TRUE(limited.periodic);
  EXPECT_TRUE(VerdictOf(limited, Effect::kTravelStops).on);
  EXPECT_FALSE(VerdictOf(limited, Effect::kContactLoss).on);
  EXPECT_EQ(limited.run.mover_peak_m, 0.4e-3);
  // the end of a long run
  scene.duration_s = 2;
  EXPECT_REL(Chosen(scene).run.skin_rms_m, limited.run.skin_rms_m, 1e-9, "2 s of transient");
}

TEST(EffectChoice, WhatIsTooFastToLookForEventsIsNamed) {
  // a current that settles in 3e-12 s
  Scene scene = Asking(0.02e-3, 10);
  scene.actuator.inductance_h = 1e-9;
  scene.actuator.resistance_ohm = 300;
  for (const bool settles : {false, true}) {
    if (settles) scene.duration_s.reset();
    const auto choice = ChooseEffects(scene);
    ASSERT_FALSE(choice);
    EXPECT_EQ(choice.error().kind, FindingKind::kBodiesTooFast);
    EXPECT_EQ(choice.error().severity, Severity::kRefusal);
    // in the run, or within a transient
    ASSERT_EQ(choice.error().numbers.size(), 1U);
    EXPECT_EQ(choice.error().numbers[0].name, settles ? "periods" : "at_s");
  }
}

}  // namespace
}  // namespace haptometer::sim
