#include "sim/steady_tones.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sim/linear_model.h"
#include "sim/scene_run.h"
#include "sim/steady_state.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

Scene WithTones(Scene scene, std::vector<Tone> tones) {
  scene.drive = {.kind = DriveKind::kTones, .tones = std::move(tones)};
  return scene;
}

TEST(SteadyTones, OfOneAreTheSineAtAnyPhase) {
  const Scene sine = tests::AdapterScene();
  const SteadyState expected = SolveSteadyState(sine);
  for (const double phase_rad : {0.0, 1.0, -2.5}) {
    const SteadyTones tones = SolveSteadyTones(WithTones(sine, {{5, 225, phase_rad}}));
    EXPECT_REL(tones.skin_rms_m, expected.skin_rms_m, 1e-13, "rounding of one factor 5");
    EXPECT_REL(tones.case_rms_m, expected.case_rms_m, 1e-13, "the same");
    EXPECT_REL(tones.current_rms_a, expected.current_rms_a, 1e-13, "the same");
    EXPECT_REL(tones.power_w, expected.power_w, 1e-13, "the same");
    EXPECT_REL(tones.mover_peak_m, expected.mover_peak_m, 1e-10, "quintics, 64 in a period");
    EXPECT_REL(tones.skin_force_peak_n, expected.skin_force_peak_n, 1e-10, "the same");
    EXPECT_REL(tones.period_s, 1 / 225.0, 1e-15, "rounding");
    const std::complex<double> turn = std::polar(1.0, phase_rad);
    EXPECT_LT((tones.start - (expected.phasors * turn).imag()).norm(), 1e-13);
  }
  // sin w/o phase beside it: Bs |Vs|^2 / 2
  const double speed = 2 * std::numbers::pi * 225 * expected.skin_rms_m;
  EXPECT_REL(SolveSteadyTones(WithTones(sine, {{5, 225, 0}})).skin_power_w,
             sine.skin.damping_n_s_per_m * speed * speed, 1e-13, "rounding");
}

// another solver: exact steps and integrals over the common period, from the steady start
TEST(SteadyTones, AreWhatIsPlayed) {
  for (Scene scene : {tests::AdapterScene(), tests::DirectScene()}) {
    scene = WithTones(scene, {{3, 225, 0.4}, {2, 175, -1}, {1, 62.5, 2}, {0.5, 225, -0.8}});
    const SteadyTones tones = SolveSteadyTones(scene);
    EXPECT_REL(tones.period_s, 1 / 12.5, 1e-15, "the greatest common divisor");
    scene.start = Start::kSteady;
    scene.duration_s = tones.period_s;
    const SceneRun run = RunScene({.scene = scene, .piecewise = {}}, tones.period_s);
    EXPECT_REL(tones.skin_rms_m, run.skin_rms_m, 1e-11, "rounding of some 3000 steps");
    EXPECT_REL(tones.case_rms_m, run.case_rms_m, 1e-11, "the same");
    EXPECT_REL(tones.current_rms_a, run.current_rms_a, 1e-11, "the same");
    EXPECT_REL(tones.power_w, run.power_w, 1e-11, "the same");
    EXPECT_REL(tones.mover_peak_m, run.mover_peak_of_run_m, 1e-9, "quintics of either");
    EXPECT_REL(tones.skin_power_w, run.ledger.dissipated_j[3] / tones.period_s, 1e-10,
               "the ledger's skin");
  }
}

TEST(SteadyTones, OfOneFrequencyAddUpFirst) {
  const Scene scene =
      WithTones(tests::AdapterScene(), {{2, 225, 0}, {2, 225, std::numbers::pi}, {1, 100, 0}});
  const SteadyTones alone = SolveSteadyTones(WithTones(tests::AdapterScene(), {{1, 100, 0}}));
  EXPECT_REL(SolveSteadyTones(scene).skin_rms_m, alone.skin_rms_m, 1e-12, "2 - 2 by rounding");
}

TEST(SteadyTones, WithoutACommonPeriodHaveTheSumAsBound) {
  const std::vector<Tone> both{{3, 225, 0}, {2, 225 * std::numbers::sqrt2, 0}};
  const Scene scene = WithTones(tests::AdapterScene(), both);
  const SteadyTones tones = SolveSteadyTones(scene);
  EXPECT_EQ(tones.period_s, 0);
  double sum_m = 0;
  for (const Tone& tone : both) {
    sum_m += SolveSteadyTones(WithTones(scene, {tone})).mover_peak_m;
  }
  EXPECT_REL(tones.mover_peak_m, sum_m, 1e-9, "quintics of the parts");
  // and it is nearly met within a second
  Scene played = scene;
  played.start = Start::kSteady;
  played.duration_s = 1;
  const double peak_m = RunScene({.scene = played, .piecewise = {}}, 1).mover_peak_of_run_m;
  EXPECT_LE(peak_m, sum_m * (1 + 1e-9));
  EXPECT_GT(peak_m, 0.99 * sum_m);
}

TEST(SteadyTones, SayWhereAResonanceIsUndamped) {
  Scene scene = tests::DirectScene();
  scene.actuator.damping_n_s_per_m = 0;
  scene.actuator.force_constant_n_per_a = 1e-9;
  scene.skin = {.stiffness_n_per_m = 0, .damping_n_s_per_m = 0};
  // mover against case
  const double reduced_kg =
      1 / (1 / scene.actuator.moving_mass_kg + 1 / scene.actuator.case_mass_kg);
  const double resonance_hz =
      std::sqrt(scene.actuator.stiffness_n_per_m / reduced_kg) / (2 * std::numbers::pi);
  EXPECT_GE(SolveSteadyTones(WithTones(scene, {{1, 10, 0}, {1, resonance_hz, 0}})).error_estimate,
            1);
}

}  // namespace
}  // namespace haptometer::sim
