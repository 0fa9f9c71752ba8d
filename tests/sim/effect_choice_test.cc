#include "sim/effect_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim/effect_bound.h"
#include "sim/effective_scene.h"
#include "sim/linear/steady_state.h"
#include "sim/steady_run.h"
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
  EXPECT_EQ(VerdictOf(choice, Effect::kGravity).ground, Ground::kKept);
  EXPECT_FALSE(VerdictOf(choice, Effect::kGravity).change) << "nothing is compared";
  EXPECT_EQ(choice.change, 0);
  EXPECT_EQ(choice.runs, 1U);
}

// a spring, a coil and a finger that disturb the linear motion a little
Scene Disturbed() {
  Scene scene = tests::AdapterScene();
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 1e4};
  scene.effects.coil_heating =
      CoilHeating{.heat_capacity_j_per_k = 50, .thermal_resistance_k_per_w = 2e-3};
  scene.finger.tones = {{.amplitude = 1e-9, .frequency_hz = 9}};
  for (const Effect effect : {Effect::kStiffening, Effect::kCoilHeating, Effect::kTremor}) {
    scene.effects[effect] = Wish::kAuto;
  }
  scene.tolerance = 1e-11;
  return scene;
}

TEST(EffectChoice, TheToleranceDecides) {
  Scene scene = Disturbed();
  scene.duration_s = kDurationS;
  scene.tolerance = 1e-9;
  const EffectChoice exact = Chosen(scene);
  EXPECT_EQ(VerdictOf(exact, Effect::kStiffening).ground, Ground::kKept);
  EXPECT_EQ(exact.runs, 2U) << "the linear motion, and what is kept";
  EXPECT_GT(exact.run.solver_tolerance, 0);
  scene.tolerance = 1e-2;
  const EffectChoice loose = Chosen(scene);
  for (const Effect effect : kDisturbances) {
    EXPECT_EQ(VerdictOf(loose, effect).ground, Ground::kBounded) << kEffectNames[PlaceOf(effect)];
    EXPECT_GT(VerdictOf(loose, effect).change, 0);
  }
  EXPECT_EQ(loose.runs, 1U);
  EXPECT_EQ(loose.run.solver_tolerance, 0) << "no solver";
  EXPECT_EQ(loose.run.skin_m, RunScene(WithEffects(scene, EffectSet(1)), kDurationS).skin_m);
  // what was left out is in the stated error
  EXPECT_LE(loose.change, scene.tolerance / 2);
  EXPECT_GE(loose.run.error_estimate, loose.change);
  EXPECT_LE(LargestDeviation(loose.run, exact.run), loose.run.error_estimate);
}

// each bound holds for every number of a run and for its waveform, and is not far from the truth at
// the resonance
TEST(EffectBound, HoldsForEachDisturbance) {
  for (const bool settles : {false, true}) {
    for (const double frequency_hz : {225.0, 60.0, 500.0}) {
      Scene scene = Disturbed();
      scene.drive.frequency_hz = frequency_hz;
      if (!settles) scene.duration_s = kDurationS;
      for (const Effect effect : kDisturbances) {
        const EffectSet on = EffectSet(1).set(PlaceOf(effect));
        const PlayedScene base = PlayWith(scene, WithoutDisturbances(on));
        const PlayedScene with = PlayWith(scene, on);
        ASSERT_TRUE(base.answered && with.answered);
        const double bound = BoundEffects(scene, on, base.run)[PlaceOf(effect)];
        const double change = std::max(LargestDeviation(base.run, with.run),
                                       Deviation(AskedQuantity::kSkinWaveform, base.run, with.run));
        EXPECT_LE(change, bound) << kEffectNames[PlaceOf(effect)] << " at " << frequency_hz;
        // as effect_bound.h says; several resonances of a Q of 20 and more
        const double worst = frequency_hz == 225 ? 300 : 1e4;
        EXPECT_LE(bound, worst * change) << kEffectNames[PlaceOf(effect)] << " at " << frequency_hz;
      }
    }
  }
}

// one that is left out acts back on those that stay
TEST(EffectBound, HoldsBesideTheOthers) {
  Scene scene = Disturbed();
  scene.effects.stiffening->cubic_n_per_m3 = 1e7;
  scene.duration_s = kDurationS;
  const EffectSet all = EffectSet(1)
                            .set(PlaceOf(Effect::kStiffening))
                            .set(PlaceOf(Effect::kCoilHeating))
                            .set(PlaceOf(Effect::kTremor));
  const PlayedScene base = PlayWith(scene, WithoutDisturbances(all));
  const EffectBounds bounds = BoundEffects(scene, all, base.run);
  const PlayedScene with = PlayWith(scene, all);
  for (const Effect effect : kDisturbances) {
    EffectSet on = all;
    const PlayedScene without = PlayWith(scene, on.reset(PlaceOf(effect)));
    EXPECT_LE(LargestDeviation(without.run, with.run), bounds[PlaceOf(effect)]);
    EXPECT_TRUE(std::isfinite(bounds[PlaceOf(effect)])) << kEffectNames[PlaceOf(effect)];
  }
}

// no bound where the disturbed motion may reach a stop or leave the skin, or does not contract
TEST(EffectBound, IsInfiniteWhereTheMotionMayChangeItsKind) {
  Scene scene = Disturbed();
  scene.duration_s = kDurationS;
  const EffectSet on = EffectSet(1).set(PlaceOf(Effect::kStiffening));
  const SceneRun base = PlayWith(scene, EffectSet(1)).run;
  const auto bound = [&](EffectSet with) {
    return BoundEffects(scene, with, base)[PlaceOf(Effect::kStiffening)];
  };
  ASSERT_TRUE(std::isfinite(bound(on)));
  // a gap 1e-6 beyond the linear travel, and one twice as far
  const double travel_m = base.mover_peak_of_run_m;
  const EffectSet stops = EffectSet(on).set(PlaceOf(Effect::kTravelStops));
  scene.effects.travel_stops = TravelStops{travel_m * (1 + 1e-6), travel_m * (1 + 1e-6)};
  EXPECT_TRUE(std::isinf(bound(stops)));
  scene.effects.travel_stops = TravelStops{2 * travel_m, 2 * travel_m};
  EXPECT_TRUE(std::isfinite(bound(stops)));
  const EffectSet contact = EffectSet(on).set(PlaceOf(Effect::kContactLoss));
  scene.effects.contact_loss = ContactLoss{-base.skin_force_least_n * (1 + 1e-6)};
  EXPECT_TRUE(std::isinf(bound(contact)));
  scene.effects.contact_loss = ContactLoss{-base.skin_force_least_n * 2};
  EXPECT_TRUE(std::isfinite(bound(contact)));
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 1e10};
  EXPECT_TRUE(std::isinf(bound(on)));
}

// a travel far below the sag of 4.9 um: the spring is stiffer all the time
TEST(EffectBound, HoldsWhereGravityStretchesTheSpring) {
  Scene scene = Disturbed();
  scene.effects.stiffening->cubic_n_per_m3 = 1e9;
  scene.drive.amplitude_v = 0.001;
  scene.duration_s = kDurationS;
  const EffectSet on =
      EffectSet(1).set(PlaceOf(Effect::kStiffening)).set(PlaceOf(Effect::kGravity));
  const PlayedScene base = PlayWith(scene, WithoutDisturbances(on));
  const PlayedScene with = PlayWith(scene, on);
  const double bound = BoundEffects(scene, on, base.run)[PlaceOf(Effect::kStiffening)];
  const double change = Deviation(AskedQuantity::kSkinWaveform, base.run, with.run);
  EXPECT_LE(change, bound);
  EXPECT_LE(bound, 300 * change) << "as effect_bound.h says";
}

TEST(EffectBound, OfACaseThatIsHeld) {
  Scene scene = Disturbed();
  scene.adapter.reset();
  scene.grip.holds = true;
  scene.drive.amplitude_v = 0.5;
  scene.duration_s = kDurationS;
  const EffectSet on = EffectSet(1).set(PlaceOf(Effect::kStiffening));
  const PlayedScene base = PlayWith(scene, EffectSet(1));
  const double bound = BoundEffects(scene, on, base.run)[PlaceOf(Effect::kStiffening)];
  const PlayedScene with = PlayWith(scene, on);
  EXPECT_LE(std::abs(with.run.mover_peak_m / base.run.mover_peak_m - 1), bound);
  EXPECT_TRUE(std::isfinite(bound));
}

// in its steady motion an effect has acted for ever, however short the run is
TEST(EffectBound, HoldsForAShortRunOfTheSteadyMotion) {
  Scene scene = Disturbed();
  scene.adapter.reset();
  scene.grip.holds = true;
  scene.actuator.stiffness_n_per_m = 2800;
  scene.actuator.damping_n_s_per_m = 1e-3;
  scene.actuator.force_constant_n_per_a = 0.1;
  scene.effects.stiffening->cubic_n_per_m3 = 1e9;
  scene.drive.amplitude_v = 5e-3;
  scene.drive.frequency_hz = 225.157;
  scene.start = Start::kSteady;
  scene.duration_s = 0.1;
  const EffectSet on = EffectSet(1).set(PlaceOf(Effect::kStiffening));
  const PlayedScene base = PlayWith(scene, EffectSet(1));
  const PlayedScene with = PlayWith(scene, on);
  ASSERT_TRUE(base.answered && with.answered);
  const double bound = BoundEffects(scene, on, base.run)[PlaceOf(Effect::kStiffening)];
  EXPECT_LE(Deviation(AskedQuantity::kMoverPeak, base.run, with.run), bound);
}

// the cubics of a chirp are in the error of both kinds of run
TEST(EffectChoice, AChirpsCubicsAreInTheStatedError) {
  Scene scene = Disturbed();
  scene.drive = {.amplitude_v = 1,
                 .frequency_hz = 100,
                 .kind = DriveKind::kChirp,
                 .end_frequency_hz = 400,
                 .duration_s = 0.1005,
                 .hold_tolerance = 1e-4};
  scene.start = Start::kRest;
  scene.duration_s = 0.1;
  scene.tolerance = 1e-6;
  scene.effects[Effect::kStiffening] = Wish::kOn;
  const EffectChoice choice = Chosen(scene);
  EXPECT_GT(choice.run.solver_tolerance, 0);
  EXPECT_GE(choice.run.error_estimate, DriveError(scene));
  EXPECT_GT(DriveError(scene), 1e-5) << "a whole number of cubics, of 1e-4 at most";
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

// bounds of the three, least first
std::vector<double> BoundsOf(const Scene& scene) {
  EffectSet on = EffectSet(1);
  for (const Effect effect : kDisturbances) on.set(PlaceOf(effect));
  const PlayedScene base = PlayWith(scene, WithoutDisturbances(on));
  const EffectBounds bounds = BoundEffects(scene, on, base.run);
  std::vector<double> sorted;
  for (const Effect effect : kDisturbances) sorted.push_back(bounds[PlaceOf(effect)]);
  std::ranges::sort(sorted);
  return sorted;
}

// the least ones first, as long as they are half of the tolerance together
TEST(EffectChoice, LeavesOutAsManyAsHalfOfTheToleranceAllows) {
  Scene scene = Disturbed();
  scene.duration_s = 0.02;
  const std::vector<double> bounds = BoundsOf(scene);
  double sum = 0;
  for (std::size_t count = 1; count <= 3; ++count) {
    sum += bounds[count - 1];
    ASSERT_LT(sum, 0.2) << "a tolerance is below 1";
    for (const bool is_enough : {true, false}) {
      scene.tolerance = 2 * sum * (is_enough ? 1.001 : 0.999);
      const EffectChoice choice = Chosen(scene);
      const std::size_t left_out = is_enough ? count : count - 1;
      EXPECT_EQ(choice.on.count(), 4 - left_out) << "the inductance stays";
      const double left = is_enough ? sum : sum - bounds[count - 1];
      EXPECT_ABS(choice.change, left, 1e-12 * sum, "rounding of a sum") << count;
      EXPECT_GE(choice.run.error_estimate, choice.change);
      EXPECT_LE(choice.run.error_estimate, scene.tolerance);
    }
  }
}

// by 0.077 N on the bare case the motion repeats itself every fourth period: ten of them are no
// whole number of its own, but 12 are, and 8 where the run is shorter
TEST(EffectChoice, ARunEndsWithWholePeriodsOfItsOwn) {
  Scene scene = tests::DirectScene();
  scene.start = Start::kSteady;
  scene.effects.contact_loss = ContactLoss{0.077};
  const EffectSet on = EffectSet(1).set(PlaceOf(Effect::kContactLoss));
  const auto played = [&](double periods) {
    scene.duration_s = periods / 225;
    return PlayWith(scene, on);
  };
  const PlayedScene longer = played(12.5), shorter = played(11.5), short_one = played(9.9);
  ASSERT_TRUE(longer.answered && longer.end && shorter.answered && shorter.end);
  EXPECT_EQ(longer.end->drive_periods, 4);
  EXPECT_EQ(shorter.end->drive_periods, 4);
  EXPECT_REL(longer.run.end_s - longer.run.begin_s, 12.0 / 225, 1e-12, "whole outputs");
  EXPECT_REL(shorter.run.end_s - shorter.run.begin_s, 8.0 / 225, 1e-12, "whole outputs");
  EXPECT_REL(longer.run.skin_rms_m, shorter.run.skin_rms_m, 1e-8, "the same whole periods");
  EXPECT_GT(std::abs(longer.end->ten_periods_rms_m / longer.run.skin_rms_m - 1), 1e-4)
      << "two and a half of its periods are another number";
  EXPECT_FALSE(longer.end->window_uncertainty);
  EXPECT_TRUE(short_one.answered);
  EXPECT_FALSE(short_one.end) << "shorter than ten periods";
}

std::optional<double> NumberIn(const Finding& finding, std::string_view name) {
  const auto found = std::ranges::find(finding.numbers, name, &FindingNumber::name);
  if (found == finding.numbers.end()) return std::nullopt;
  return std::get<double>(found->value);
}

// below the solver's rounding: what is reached, what was asked, and twice the first as advice
TEST(EffectChoice, RefusesWhatItCannotPlayAsExactly) {
  Scene scene = Disturbed();
  scene.duration_s = 0.01;
  scene.effects[Effect::kStiffening] = Wish::kOn;
  scene.tolerance = 1e-13;
  const auto choice = ChooseEffects(scene);
  ASSERT_FALSE(choice);
  EXPECT_EQ(choice.error().kind, FindingKind::kErrorTooLarge);
  EXPECT_EQ(choice.error().severity, Severity::kRefusal);
  const double error = NumberIn(choice.error(), "relative_error").value_or(0);
  EXPECT_GT(error, 1e-12) << "the least that the solver states";
  EXPECT_LT(error, 1e-10);
  EXPECT_EQ(NumberIn(choice.error(), "tolerance"), 1e-13);
  EXPECT_EQ(NumberIn(choice.error(), "least_tolerance"), 2 * error);
  scene.tolerance = 2 * error;
  EXPECT_TRUE(ChooseEffects(scene)) << "the advice";
}

// a run that begins in its steady motion has the error of both
TEST(PlayedScene, OfASteadyStartHasTheErrorOfItsStart) {
  Scene scene = tests::AdapterScene();
  scene.effects.travel_stops =
      TravelStops{.gap_up_m = 0.3e-3, .gap_down_m = 0.3e-3, .restitution = 0.5};
  scene.start = Start::kSteady;
  scene.duration_s = 11.0 / 225;
  const EffectSet on = EffectSet(1).set(PlaceOf(Effect::kTravelStops));
  const PlayedScene played = PlayWith(scene, on);
  ASSERT_TRUE(played.answered);
  const EffectiveScene effective = WithEffects(scene, on);
  const SteadyRun steady = PlaySteady(effective);
  ASSERT_TRUE(steady.run);
  const SceneRun run = RunScene(effective, *scene.duration_s, steady.start);
  EXPECT_REL(played.run.error_estimate, run.error_estimate + steady.run->error_estimate, 1e-14,
             "rounding");
  ASSERT_TRUE(played.end);
  EXPECT_EQ(played.end->drive_periods, 1);
  EXPECT_EQ(played.end->ten_periods_rms_m, played.run.skin_rms_m);
}

// a motion that does not repeat itself: by what its RMS varies over the windows before
TEST(PlayedScene, OfAChaoticMotionIsUncertainByItsWindows) {
  Scene scene = tests::DirectScene();
  scene.start = Start::kRest;
  scene.effects.contact_loss = ContactLoss{0.07};
  scene.duration_s = 60.0 / 225;
  const EffectSet on = EffectSet(1).set(PlaceOf(Effect::kContactLoss));
  const PlayedScene played = PlayWith(scene, on);
  ASSERT_TRUE(played.answered && played.end);
  EXPECT_FALSE(played.end->drive_periods);
  EXPECT_EQ(played.end->window_uncertainty, WindowUncertainty(played.run, 10));
  EXPECT_GT(played.end->window_uncertainty.value_or(0), 1e-4) << "it stays in two bands";
  EXPECT_EQ(played.end->ten_periods_rms_m, played.run.skin_rms_m);
}

TEST(PlayedScene, OfAPreloadThatDoesNotPressIsRefused) {
  Scene scene = tests::DirectScene();
  scene.duration_s = 0.01;
  scene.effects.contact_loss = ContactLoss{0.0};
  const EffectSet on = EffectSet(1).set(PlaceOf(Effect::kContactLoss));
  const PlayedScene played = PlayWith(scene, on);
  EXPECT_FALSE(played.answered);
  ASSERT_TRUE(played.refusal);
  EXPECT_EQ(played.refusal->kind, FindingKind::kNothingHolds);
}

}  // namespace
}  // namespace haptometer::sim
