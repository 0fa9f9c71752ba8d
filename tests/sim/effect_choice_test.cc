#include "sim/effect_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <random>

#include "sim/effective_scene.h"
#include "sim/steady_state.h"
#include "tests/repetitions.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kDurationS = 0.05;

EffectChoice Chosen(const Scene& scene) {
  auto choice = ChooseEffects(scene, "scene");
  EXPECT_TRUE(choice) << choice.error().Text();
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

// scenes over wide ranges; half of their limits lie within a factor of 2 of what is reached
class RandomScenes {
 public:
  explicit RandomScenes(std::uint64_t seed) : engine_(seed) {}

  Scene Next() {
    Scene scene = NextBodies();
    const SteadyState steady_state = SolveSteadyState(scene);
    scene.effects.travel_stops = NextStops(steady_state.mover_peak_m);
    scene.effects.contact_loss = ContactLoss{NearOrFar(steady_state.skin_force_peak_n)};
    // weight away from the skin is carried by no preload; half the least gap is sag at most
    const TravelStops& stops = *scene.effects.travel_stops;
    const double most = 0.5 * std::min(stops.gap_up_m, stops.gap_down_m) / MoverSag(scene);
    scene.effects.gravity_m_per_s2 *= std::min(1.0, most);
    for (const Effect effect :
         {Effect::kInductance, Effect::kGravity, Effect::kTravelStops, Effect::kContactLoss}) {
      scene.effects[effect] = Wish::kAuto;
    }
    scene.tolerance = Between(1e-9, 1e-2);
    scene.quantity = static_cast<AskedQuantity>(engine_() % kAskedQuantityNames.size());
    // what settles where stops limit it takes hundreds of periods: other tests
    EffectSet all;
    all.set();
    const bool steady =
        engine_() % 2 == 0 && SteadyMotionIsFree(WithEffects(scene, all), steady_state);
    scene.start = steady ? Start::kSteady : Start::kRest;
    return scene;
  }
  double Duration() { return Between(0.02, 0.08); }

 private:
  // evenly over the decades
  double Between(double low, double high) {
    return low * std::pow(high / low, std::ldexp(static_cast<double>(engine_() >> 11U), -53));
  }
  double NearOrFar(double value) {
    return value * (engine_() % 2 == 0 ? Between(0.5, 2) : Between(0.1, 100));
  }
  Scene NextBodies() {
    Scene scene = engine_() % 2 == 0 ? tests::AdapterScene() : tests::DirectScene();
    Actuator& actuator = scene.actuator;
    actuator.moving_mass_kg = Between(1e-4, 1e-2);
    actuator.case_mass_kg = Between(1e-4, 1e-2);
    actuator.stiffness_n_per_m = Between(500, 2e4);
    actuator.damping_n_s_per_m = Between(1e-2, 0.5);
    actuator.force_constant_n_per_a = Between(0.1, 10);
    actuator.resistance_ohm = Between(5, 100);
    actuator.inductance_h = Between(1e-6, 2e-3);
    scene.skin = {.stiffness_n_per_m = Between(100, 5000), .damping_n_s_per_m = Between(0.1, 5)};
    scene.drive = {.amplitude_v = Between(0.5, 10), .frequency_hz = Between(20, 600)};
    return scene;
  }
  TravelStops NextStops(double travel_m) {
    TravelStops stops{.gap_up_m = NearOrFar(travel_m), .gap_down_m = NearOrFar(travel_m)};
    if (engine_() % 2 == 0) {
      stops.stiffness_n_per_m = Between(1e4, 1e8);
      stops.damping_n_s_per_m = Between(1e-2, 10);
    } else {
      stops.restitution = Between(0.05, 0.95);
    }
    return stops;
  }

  std::mt19937_64 engine_;
};

// what is asked about, all of it at once
EffectSet Everything(const Scene& scene) {
  EffectSet on;
  for (std::size_t k = 0; k < on.size(); ++k) on[k] = scene.effects.wishes[k] != Wish::kOff;
  return on;
}

TEST(EffectChoice, OfRandomScenesStaysWithinTheToleranceAndKeepsLittle) {
  constexpr std::uint64_t kSeed = 20261122;
  RandomScenes random(kSeed);
  const int count = tests::Repetitions(tests::kIsSanitized ? 2 : 30);
  int active = 0, idle_effects = 0, idle_dropped = 0;
  for (int i = 0; i < count; ++i) {
    Scene scene = random.Next();
    const double duration_s = random.Duration() * (tests::kIsSanitized ? 0.1 : 1);
    scene.duration_s = duration_s;
    const EffectSet all = Everything(scene);
    const SceneRun everything = RunScene(WithEffects(scene, all), duration_s);
    const EffectChoice choice = Chosen(scene);
    ASSERT_FALSE(everything.stalled_at_s) << "seed " << kSeed << ", scene " << i;
    const SceneRun chosen = RunScene(WithEffects(scene, choice.on), duration_s);
    EXPECT_LE(Deviation(scene.quantity, chosen, everything), scene.tolerance)
        << "seed " << kSeed << ", scene " << i;
    active += everything.events.empty() ? 0 : 1;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (!all[k]) continue;
      EffectSet without = all;
      const SceneRun run = RunScene(WithEffects(scene, without.reset(k)), duration_s);
      if (run.stalled_at_s) continue;
      if (!(Deviation(scene.quantity, run, everything) < 0.01 * scene.tolerance)) continue;
      ++idle_effects;
      idle_dropped += choice.on[k] ? 0 : 1;
    }
  }
  std::cout << count << " scenes, seed " << kSeed << ", " << active << " with events; of "
            << idle_effects << " effects that change less than a hundredth of the tolerance "
            << idle_dropped << " are left out\n";
  EXPECT_GE(4 * active, count) << "at least a quarter with an effect active";
  EXPECT_GE(idle_dropped, 0.95 * idle_effects);
}

}  // namespace
}  // namespace haptometer::sim
