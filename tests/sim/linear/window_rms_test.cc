#include "sim/linear/window_rms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/linear/steady_state.h"
#include "tests/residual.h"
#include "tests/sim/reference/window_reference.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

using tests::kWindowRunS;

Scene SceneOf(const tests::WindowReference& reference) {
  Scene scene;
  scene.actuator = {.moving_mass_kg = reference.Mv,
                    .case_mass_kg = reference.Mc,
                    .stiffness_n_per_m = reference.Kv,
                    .damping_n_s_per_m = reference.Bv,
                    .force_constant_n_per_a = reference.Km,
                    .resistance_ohm = reference.R,
                    .inductance_h = reference.L};
  scene.adapter = Adapter{.motor_side_mass_kg = reference.Ma1,
                          .skin_side_mass_kg = reference.Ma2,
                          .stiffness_n_per_m = reference.Ka,
                          .damping_n_s_per_m = reference.Ba};
  scene.skin = {.stiffness_n_per_m = reference.Ks, .damping_n_s_per_m = reference.Bs};
  scene.drive.amplitude_v = reference.A;
  scene.drive.frequency_hz = reference.f;
  scene.drive.offset_v = reference.V0;
  scene.grip = {.stiffness_n_per_m = reference.Kg, .damping_n_s_per_m = reference.Bg};
  scene.initial = {.mover_m = reference.xv, .skin_m_per_s = reference.vs, .current_a = reference.i};
  scene.duration_s = kWindowRunS;
  return scene;
}

WindowRms LastTenPeriods(const Scene& scene) {
  const auto end_s = static_cast<long double>(*scene.duration_s);
  return WindowRmsOf(LinearMotionOf(scene), AssembleModel(scene).skin(),
                     end_s - 10 / static_cast<long double>(scene.drive.frequency_hz), end_s);
}

// forty scenes over decades; the double was off by up to 3e-10 and said 6e-15
TEST(WindowRms, IsThatOfSixtyDigitsWithinItsStatedError) {
  double worst = 0;
  for (const tests::WindowReference& reference : tests::kWindowReferences) {
    const WindowRms window = LastTenPeriods(SceneOf(reference));
    const double error = std::abs(window.rms / reference.rms_m - 1);
    EXPECT_LE(error, window.error_estimate) << reference.rms_m;
    EXPECT_LT(window.error_estimate, 1e-10) << "the accuracy that simulate promises";
    worst = std::max(worst, error);
  }
  EXPECT_ABS(worst, 0, 1e-12, "the long double's rounding where the skin is kept quietest");
}

// an offset moves where the mover rests, not what the skin does once that has died away
TEST(WindowRms, OfTheSteadyMotionIsTheEffectiveValueUnderAnyOffset) {
  Scene scene = tests::AdapterScene();
  scene.duration_s = 1;
  scene.start = Start::kSteady;
  const double rms_m = SolveSteadyState(scene).skin_rms_m;
  EXPECT_REL(LastTenPeriods(scene).rms, rms_m, 1e-13, "the phasor's rounding");
  scene.drive.offset_v = 3;
  EXPECT_REL(LastTenPeriods(scene).rms, rms_m, 1e-13, "the phasor's rounding");
  // from rest after 100 s: all transients are down by e^-100
  scene.start = Start::kRest;
  scene.duration_s = 100;
  EXPECT_REL(LastTenPeriods(scene).rms, rms_m, 1e-13, "the phasor's rounding");
}

// the window of a run of twelve days is as exact: it counts back from the end
TEST(WindowRms, OfTheLongestRunIsTheEffectiveValue) {
  Scene scene = tests::AdapterScene();
  scene.duration_s = kLongestRunS;
  const WindowRms window = LastTenPeriods(scene);
  const double rms_m = SolveSteadyState(scene).skin_rms_m;
  EXPECT_REL(window.rms, rms_m, 2.5e-12, "a begin of 20 digits, 1e6 s over 44 ms");
  EXPECT_LE(std::abs(window.rms / rms_m - 1), window.error_estimate);
  EXPECT_LT(window.error_estimate, 1e-11);
}

// without a spring to ground an offset still has a place where mover and current rest
TEST(WindowRms, OfAFreeCaseUnderAnOffsetIsThatOfItsStart) {
  Scene scene = tests::DirectScene();
  scene.drive.source_resistance_ohm = 3;
  scene.skin = {.stiffness_n_per_m = 0, .damping_n_s_per_m = 0.5};
  scene.drive.amplitude_v = 0;
  scene.drive.offset_v = 2;
  scene.duration_s = 0.045;
  // it begins where the offset holds it, and stays there
  scene.initial.current_a = scene.drive.offset_v / (scene.actuator.resistance_ohm + 3);
  scene.initial.mover_m = -scene.actuator.force_constant_n_per_a * scene.initial.current_a /
                          scene.actuator.stiffness_n_per_m;
  EXPECT_ABS(LastTenPeriods(scene).rms, 0, 1e-18, "rounding of a deflection of 26 um");
}

// without a motion nothing is left but the result's rounding and that of the window's begin
TEST(WindowRms, OfRestIsAsWrongAsItsTimes) {
  Scene scene = tests::DirectScene();
  scene.drive.amplitude_v = 0;
  scene.start = Start::kRest;
  const LinearMotion motion = LinearMotionOf(scene);
  for (const long double begin_s : {0.0L, 1000.0L}) {
    const long double end_s = begin_s + 0.125L;
    const WindowRms window = WindowRmsOf(motion, LinearModel::kCase, begin_s, end_s);
    EXPECT_EQ(window.rms, 0);
    EXPECT_REL(window.error_estimate,
               2e-15 + static_cast<double>(0x1p-63L * end_s / (end_s - begin_s)), 1e-12,
               "the bound itself");
  }
}

}  // namespace
}  // namespace haptometer::sim
