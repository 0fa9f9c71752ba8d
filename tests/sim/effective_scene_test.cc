#include "sim/effective_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/linear/excitation.h"
#include "sim/linear/steady_state.h"
#include "sim/scene_run.h"
#include "sim/waveforms.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kHighestOwnHz = 613.7;  // of the adapter's scene: facts of the thesis's model

Scene With(Drive drive) {
  Scene scene = tests::AdapterScene();
  scene.drive = std::move(drive);
  return scene;
}

Drive Samples(double rate_hz, std::vector<double> voltages_v) {
  return {.kind = DriveKind::kSamples,
          .samples = std::make_shared<VoltageSamples>(VoltageSamples{rate_hz, voltages_v})};
}

TEST(OutputRate, FollowsTheHighestFrequency) {
  EXPECT_EQ(OutputRateHz(tests::AdapterScene()), 64 * 225);
  // a slow sine may set the scene ringing
  Scene slow = tests::AdapterScene();
  slow.drive.frequency_hz = 10;
  EXPECT_EQ(OutputRateHz(slow), 640) << "not in its steady state";
  slow.duration_s = 1;
  EXPECT_EQ(OutputRateHz(slow), 640 * std::ceil(16 * kHighestOwnHz / 640));
  const Drive tones{.kind = DriveKind::kTones, .tones = {{1, 40, 0}, {1, 2000, 0}}};
  EXPECT_EQ(OutputRateHz(With(tones)), 64 * 2000);
  const Drive pulse{.amplitude_v = 1, .kind = DriveKind::kPulse, .hold_s = 1e-3};
  EXPECT_REL(OutputRateHz(With(pulse)), 64 * kHighestOwnHz, 1e-3, "four printed digits, damped");
  const double fast_hz = OutputRateHz(With(Samples(48000, {0, 1})));
  EXPECT_EQ(fast_hz, 48000) << "39 kHz would do for the scene";
  const double slow_hz = OutputRateHz(With(Samples(1000, {0, 1})));
  EXPECT_EQ(slow_hz, 1000 * std::ceil(OutputRateHz(With(pulse)) / 1000));
}

// the peak of a run from rest under a slow sine, where 64 looks in its period would miss the
// ringing
TEST(OutputRate, ShowsThePeakOfWhatRings) {
  Scene scene = tests::AdapterScene();
  scene.drive.frequency_hz = 3;
  scene.start = Start::kRest;
  scene.duration_s = 0.2;
  const EffectiveScene effective{.scene = scene, .piecewise = {}};
  const Waveforms fine = PlayWaveforms(effective, BeginningOf(effective), 0.2, 1e6);
  EXPECT_REL(RunScene(effective, 0.2).mover_peak_of_run_m,
             (fine.mover_m - fine.case_m).cwiseAbs().maxCoeff(), 1e-5, "1e6 looks a second");
}

TEST(OutputRate, CountsTheStepsOfARun) {
  EXPECT_EQ(StepsOfRun(tests::AdapterScene(), 2), 2 * 64 * 225);
  const Drive chirp{.amplitude_v = 1,
                    .frequency_hz = 50,
                    .kind = DriveKind::kChirp,
                    .start_s = 1,
                    .end_frequency_hz = 60,
                    .duration_s = 4,
                    .hold_tolerance = 1e-6};
  const double cubics = CubicsOf(chirp);
  EXPECT_EQ(static_cast<double>(Excitation(chirp, {}).size()), cubics + 2) << "rest on both sides";
  EXPECT_EQ(std::fmod(cubics, 4000), 0) << "as many in each millisecond";
  const double rate_hz = OutputRateHz(With(chirp));
  EXPECT_EQ(std::fmod(rate_hz, cubics / 4), 0) << "each begins at an output";
  EXPECT_EQ(StepsOfRun(With(chirp), 3), 3 * rate_hz);
}

// the slowest motion is excited by a pulse, and after RingDownS a thousandth of it is left
TEST(OutputRate, ARingDownEndsAtAThousandth) {
  for (Scene scene : {tests::AdapterScene(), tests::DirectScene()}) {
    scene.drive = {.amplitude_v = 5, .kind = DriveKind::kPulse, .hold_s = 2e-3};
    scene.start = Start::kRest;
    const double ring_down_s = RingDownS(scene).value();
    const EffectiveScene effective{.scene = scene, .piecewise = {}};
    const auto peak_m = [&](double begin_s, double length_s) {
      const double rate_hz = OutputRateHz(scene);
      const Waveforms waves =
          PlayWaveforms(effective, BeginningOf(effective), begin_s + length_s, rate_hz);
      const auto rows = static_cast<Eigen::Index>(length_s * rate_hz);
      return waves.skin_m.tail(rows).cwiseAbs().maxCoeff();
    };
    const double ratio = peak_m(2e-3 + ring_down_s, 0.05) / peak_m(2e-3, 0.05);
    EXPECT_LT(ratio, 1.01e-3);
    EXPECT_GT(ratio, 1e-5);
  }
}

TEST(OutputRate, NothingRingsDownWithoutDamping) {
  Scene scene = tests::DirectScene();
  scene.actuator.damping_n_s_per_m = 0;
  scene.actuator.force_constant_n_per_a = 1e-9;
  scene.skin.damping_n_s_per_m = 0;
  EXPECT_FALSE(RingDownS(scene).has_value());
}

// a mover by itself, in a case that is held: sqrt(Kv / Mv) and Bv / (2 Mv) are its poles
Scene HeldMover(double own_hz, double decay_per_s) {
  Scene scene = tests::ConeScene();
  scene.grip.holds = true;
  Actuator& actuator = scene.actuator;
  actuator.force_constant_n_per_a = 0;
  actuator.inductance_h = 0;
  actuator.stiffness_n_per_m = actuator.moving_mass_kg * std::pow(2 * std::numbers::pi * own_hz, 2);
  actuator.damping_n_s_per_m = 2 * actuator.moving_mass_kg * decay_per_s;
  return scene;
}

TEST(OutputRate, FollowsOwnFrequenciesUpTo100KHz) {
  for (const auto& [own_hz, counted_hz] : {std::pair{0.995e5, 0.995e5}, std::pair{1.005e5, 1e5}}) {
    Scene scene = HeldMover(own_hz, 0);
    scene.drive = {.amplitude_v = 1, .kind = DriveKind::kPulse, .hold_s = 1e-3};
    EXPECT_REL(OutputRateHz(scene), 64 * counted_hz, 1e-10, "rounding of the poles");
  }
}

TEST(OutputRate, IsAThousandHertzWhereNothingHasAFrequency) {
  Scene scene = HeldMover(100, 5000);  // it does not ring
  scene.drive = {.amplitude_v = 1, .kind = DriveKind::kPulse, .hold_s = 1e-3};
  EXPECT_EQ(OutputRateHz(scene), 1000);
  scene.finger.tones = {{.amplitude = 1e-6, .frequency_hz = 15}};
  EXPECT_EQ(OutputRateHz(scene), 1000) << "64 looks in 1/15 s are fewer";
  scene.finger.tones[0].frequency_hz = 16;
  EXPECT_EQ(OutputRateHz(scene), 1024);
}

// 64 x 19.8 Hz by the samples' 422.4 Hz is a rounding more than 3
TEST(OutputRate, IsNoMoreOfTheSamplesRateThanRoundingAsksFor) {
  Scene scene = HeldMover(100, 5000);  // it does not ring
  scene.finger.tones = {{.amplitude = 1e-6, .frequency_hz = 19.8}};
  scene.drive = Samples(422.4, {0, 1});
  EXPECT_GT(64 * 19.8 / 422.4, 3) << "by rounding";
  EXPECT_EQ(OutputRateHz(scene), 3 * 422.4);
  scene.finger.tones[0].frequency_hz = 19.8 * (1 + 1e-9);
  EXPECT_EQ(OutputRateHz(scene), 4 * 422.4);
}

TEST(OutputRate, HasAMostOfSteps) {
  Scene scene = tests::AdapterScene();
  EXPECT_EQ(MostSteps(scene), 1e8);
  for (const DriveKind kind : {DriveKind::kPulse, DriveKind::kTones, DriveKind::kChirp}) {
    scene.drive.kind = kind;
    EXPECT_EQ(MostSteps(scene), 1e7) << "all outputs are kept";
  }
}

// ln 1000 over the slowest decay, down to 1e-13 of the fastest pole, here the held case's
TEST(OutputRate, ARingDownIsThatOfTheSlowestPole) {
  EXPECT_REL(RingDownS(HeldMover(225, 11.5)).value(), std::log(1000) / 11.5, 1e-10,
             "rounding of the poles");
  const double fastest_per_s = 2 * std::numbers::pi * 1000;
  EXPECT_TRUE(RingDownS(HeldMover(1000, 1.05e-13 * fastest_per_s)).has_value());
  EXPECT_FALSE(RingDownS(HeldMover(1000, 0.95e-13 * fastest_per_s)).has_value());
}

// what pulls may just not exceed what presses
TEST(SteadyMotion, IsFreeWhileContactHolds) {
  const Scene scene = tests::ConeScene();
  const SteadyState steady = SolveSteadyState(scene);
  EffectiveScene effective{.scene = scene, .piecewise = {}};
  EXPECT_TRUE(SteadyMotionIsFree(effective, steady));
  effective.piecewise.contact_loss = ContactLoss{-steady.skin_force_least_n * (1 + 1e-9)};
  EXPECT_TRUE(SteadyMotionIsFree(effective, steady));
  effective.piecewise.contact_loss = ContactLoss{-steady.skin_force_least_n * (1 - 1e-9)};
  EXPECT_FALSE(SteadyMotionIsFree(effective, steady));
}

// an error of a tenth takes a tenth of each gap and of the preload
TEST(SteadyMotion, IsFreeByMoreThanItsError) {
  const Scene scene = tests::ConeScene();
  SteadyTones steady;
  steady.mover_peak_m = 5e-4;
  steady.mean_travel_m = 1e-4;  // from -3e-4 to 5e-4
  steady.skin_force_least_n = -0.2;
  steady.error_estimate = 0.1;
  EffectiveScene effective{.scene = scene, .piecewise = {}};
  const auto is_free = [&](double gap_up_m, double gap_down_m, double preload_n) {
    effective.piecewise.stops = TravelStops{.gap_up_m = gap_up_m, .gap_down_m = gap_down_m};
    effective.piecewise.contact_loss = ContactLoss{preload_n};
    return SteadyMotionIsFree(effective, steady);
  };
  constexpr double kMore = 1.0001 / 0.9, kLess = 0.9999 / 0.9;
  EXPECT_TRUE(is_free(5e-4 * kMore, 3e-4 * kMore, 0.2 * kMore));
  EXPECT_FALSE(is_free(5e-4 * kLess, 3e-4 * kMore, 0.2 * kMore));
  EXPECT_FALSE(is_free(5e-4 * kMore, 3e-4 * kLess, 0.2 * kMore));
  EXPECT_FALSE(is_free(5e-4 * kMore, 3e-4 * kMore, 0.2 * kLess));
  effective.smooth.spring = StiffeningSpring{.cubic_n_per_m3 = 1};
  EXPECT_FALSE(is_free(1, 1, 1)) << "a spring bends it";
}

// a steady motion under the drive alone is not that of a finger that moves
TEST(SteadyMotion, OfADriveIsNotThatOfATremor) {
  Scene scene = tests::ConeScene();
  scene.finger.tones = {{.amplitude = 1e-9, .frequency_hz = 9}};
  const EffectiveScene effective{.scene = scene, .piecewise = {}};
  EXPECT_FALSE(SteadyMotionIsFree(effective, SolveSteadyState(scene)));
  EXPECT_TRUE(SteadyMotionIsFree(effective, Superpose(scene)));
}

TEST(Rest, NeedsAPreloadAndASkinThatCarriesIt) {
  EffectiveScene effective{.scene = tests::ConeScene(), .piecewise = {}};
  EXPECT_TRUE(CanRest(effective));
  effective.piecewise.contact_loss = ContactLoss{1e-9};
  EXPECT_TRUE(CanRest(effective));
  for (const Skin& skin : {Skin{600, 0}, Skin{0, 0.75}}) {
    effective.scene.skin = skin;
    EXPECT_TRUE(CanRest(effective)) << skin.stiffness_n_per_m;
  }
  effective.scene.skin = {};
  EXPECT_FALSE(CanRest(effective));
  effective.scene.skin = {600, 0.75};
  for (const double preload_n : {0.0, -0.1}) {
    effective.piecewise.contact_loss = ContactLoss{preload_n};
    EXPECT_FALSE(CanRest(effective)) << preload_n;
  }
}

// g (Mv + Mc + Ma1 + Ma2), with the mover's preload; a held case carries both
TEST(Rest, PressesByWeightAndPreload) {
  Scene scene = tests::AdapterScene();
  scene.effects.gravity_m_per_s2 = -4;
  scene.mover_preload_n = 0.5;
  EXPECT_REL(Weight(scene), -4 * 6.6e-3, 1e-14, "rounding");
  EXPECT_REL(PressOnSkin(scene, true), 0.5 - 4 * 6.6e-3, 1e-14, "rounding");
  EXPECT_EQ(PressOnSkin(scene, false), 0.5);
  scene.adapter.reset();
  EXPECT_REL(Weight(scene), -4 * 2e-3, 1e-14, "rounding");
  scene.grip.holds = true;
  EXPECT_EQ(Weight(scene), 0);
  EXPECT_EQ(PressOnSkin(scene, true), 0);
}

}  // namespace
}  // namespace haptometer::sim
