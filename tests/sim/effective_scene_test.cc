#include "sim/effective_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "sim/linear/excitation.h"
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

}  // namespace
}  // namespace haptometer::sim
