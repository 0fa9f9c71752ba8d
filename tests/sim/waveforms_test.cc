#include "sim/waveforms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/scene_run.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

TEST(Waveforms, OfASteadySineAreItsPhasors) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kSteady;
  const LinearModel model = AssembleModel(scene);
  const SteadyState steady = SolveSteadyState(scene);
  const EffectiveScene effective{.scene = scene, .piecewise = {}};
  const Waveforms waves = PlayWaveforms(effective, BeginningOf(effective), 0.05, 7919);
  ASSERT_EQ(waves.rows(), 396) << "0.05 s hold 395.95 steps";
  EXPECT_EQ(waves.finger_m.size(), 0);
  const double w = 2 * std::numbers::pi * 225;
  for (Eigen::Index row = 0; row < waves.rows(); row += 5) {
    const std::complex<double> turn = std::polar(1.0, w * static_cast<double>(row) / 7919);
    const auto at = [&](std::complex<double> phasor) { return (phasor * turn).imag(); };
    const auto expect = [&](double value, std::complex<double> phasor) {
      EXPECT_ABS(value, at(phasor), 1e-11 * std::abs(phasor), "rounding of 400 steps");
    };
    const Eigen::VectorXcd& x = steady.phasors;
    expect(waves.voltage_v(row), 5);
    expect(waves.current_a(row), steady.current_a);
    expect(waves.mover_m(row), x(LinearModel::kMover));
    expect(waves.mover_m_per_s(row), x(LinearModel::kMoverVelocity));
    expect(waves.case_m(row), x(LinearModel::kCase));
    expect(waves.case_m_per_s(row), x(LinearModel::kCaseVelocity));
    expect(waves.skin_m(row), x(model.skin()));
    expect(waves.skin_m_per_s(row), x(model.skin_velocity()));
    expect(waves.force_n(row), std::complex<double>(600, w * 0.75) * x(model.skin()));
  }
  EXPECT_EQ(waves.events.cwiseAbs().maxCoeff(), 0);
}

// stops that are never reached leave no bit: rows that come one by one and many at once are the
// same
TEST(Waveforms, OfEffectsThatAreOutOfReachAreThoseWithout) {
  for (const double inductance_h : {130e-6, 0.0}) {
    Scene scene = tests::AdapterScene();
    scene.actuator.inductance_h = inductance_h;
    const EffectiveScene plain{.scene = scene, .piecewise = {}};
    const EffectiveScene watched{
        .scene = scene, .piecewise = {.stops = TravelStops{.gap_up_m = 1, .gap_down_m = 1}}};
    const Waveforms expected = PlayWaveforms(plain, {.start = PiecewiseStartOf(scene)}, 0.3, 1e4);
    const Waveforms waves = PlayWaveforms(watched, {.start = PiecewiseStartOf(scene)}, 0.3, 1e4);
    EXPECT_EQ(waves.voltage_v, expected.voltage_v);
    EXPECT_EQ(waves.current_a, expected.current_a);
    EXPECT_EQ(waves.mover_m, expected.mover_m);
    EXPECT_EQ(waves.case_m_per_s, expected.case_m_per_s);
    EXPECT_EQ(waves.skin_m, expected.skin_m);
    EXPECT_EQ(waves.force_n, expected.force_n);
    EXPECT_EQ(waves.events, expected.events);
    EXPECT_GT(expected.current_a.cwiseAbs().minCoeff(), 0) << "a current in every row";
  }
}

// a spring that hardens by nothing to speak of: the solver's waveforms are the exact ones
TEST(Waveforms, OfSmoothEffectsAreTheSolvers) {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  scene.tolerance = 1e-7;
  scene.finger.tones = {{.amplitude = 1e-4, .frequency_hz = 8.3}};
  const EffectiveScene exact{.scene = scene, .piecewise = {}};
  EffectiveScene solved = exact;
  solved.smooth.spring = StiffeningSpring{.cubic_n_per_m3 = 1e-3};
  const Waveforms expected = PlayWaveforms(exact, BeginningOf(exact), 0.02, 5000);
  const Waveforms waves = PlayWaveforms(solved, BeginningOf(solved), 0.02, 5000);
  ASSERT_EQ(waves.rows(), expected.rows());
  const auto expect = [](const Eigen::VectorXd& wave, const Eigen::VectorXd& truth) {
    EXPECT_ABS((wave - truth).cwiseAbs().maxCoeff(), 0, 1e-6 * truth.cwiseAbs().maxCoeff(),
               "ten times the tolerance");
  };
  expect(waves.voltage_v, expected.voltage_v);
  expect(waves.current_a, expected.current_a);
  expect(waves.mover_m, expected.mover_m);
  expect(waves.skin_m_per_s, expected.skin_m_per_s);
  expect(waves.finger_m, expected.finger_m);
  expect(waves.force_n, expected.force_n);
}

// under contact that breaks: no force in flight, none below zero, every event in some row
TEST(Waveforms, OfAContactThatBreaks) {
  Scene scene = tests::DirectScene();
  scene.start = Start::kRest;
  const EffectiveScene effective{.scene = scene, .piecewise = {.contact_loss = ContactLoss{0.07}}};
  EXPECT_EQ(RestingForceN(effective), 0.07);
  const SceneRun run = RunScene(effective, 0.1);
  const Waveforms waves = PlayWaveforms(effective, BeginningOf(effective), 0.1, 48000);
  double events = 0;
  for (const EventCount& event : run.events) events += static_cast<double>(event.count);
  EXPECT_GT(events, 20);
  EXPECT_EQ(waves.events.sum(), events);
  EXPECT_GE(waves.force_n.minCoeff(), -1e-12) << "rounding of a force of 0.3 N";
  EXPECT_GT((waves.force_n.array() == 0).count(), 100) << "in flight";
  // a flight ends with a row that has the landing in it, and the force goes on from there
  for (Eigen::Index row = 1; row < waves.rows(); ++row) {
    const bool left = waves.force_n(row) == 0 && waves.force_n(row - 1) > 0;
    const bool landed = waves.force_n(row) > 0 && waves.force_n(row - 1) == 0;
    if (left || landed) {
      EXPECT_GE(waves.events(row), 1);
    }
  }
}

TEST(Waveforms, DoNotDependOnTheirRate) {
  Scene scene = tests::AdapterScene();
  scene.drive = {.amplitude_v = 4, .kind = DriveKind::kPulse, .start_s = 1e-3, .hold_s = 7e-3};
  scene.finger.tones = {{.amplitude = 20e-6, .frequency_hz = 9}};
  const EffectiveScene effective{
      .scene = scene,
      .piecewise = {.stops =
                        TravelStops{.gap_up_m = 5e-5, .gap_down_m = 5e-5, .restitution = 0.5}}};
  const Waveforms fine = PlayWaveforms(effective, BeginningOf(effective), 0.05, 32000);
  const Waveforms coarse = PlayWaveforms(effective, BeginningOf(effective), 0.05, 2000);
  ASSERT_EQ(coarse.rows(), 101);
  EXPECT_GT(coarse.events.sum(), 2);
  EXPECT_EQ(coarse.events.sum(), fine.events.sum());
  for (Eigen::Index row = 0; row < coarse.rows(); ++row) {
    EXPECT_ABS(coarse.skin_m(row), fine.skin_m(16 * row), 1e-11 * fine.skin_m.cwiseAbs().maxCoeff(),
               "events to 1e-13 s, impacts at 1 m/s");
    EXPECT_ABS(coarse.finger_m(row), fine.finger_m(16 * row), 1e-18, "the same sine");
  }
  EXPECT_EQ(fine.voltage_v(16), 0);
  EXPECT_EQ(coarse.voltage_v(10), 4);
}

// what presses at rest: preload, and weight where there is gravity
TEST(Waveforms, KnowWhatPressesAtRest) {
  Scene scene = tests::AdapterScene();
  EXPECT_EQ(RestingForceN({.scene = scene, .piecewise = {}}), 0);
  scene.effects.contact_loss = ContactLoss{0.2};
  EXPECT_EQ(RestingForceN({.scene = scene, .piecewise = {}}), 0.2) << "stated, contact kept";
  scene.effects[Effect::kGravity] = Wish::kOn;
  // Mv + Mc + Ma1 + Ma2 = 6.6 g
  EXPECT_REL(RestingForceN({.scene = scene, .piecewise = {}}), 0.2 + 6.6e-3 * 9.80665, 1e-12,
             "rounding");
}

// effects that may act count as those that do; a held case carries all
TEST(Waveforms, KnowWhatMayPressAtRest) {
  Scene scene = tests::AdapterScene();
  scene.mover_preload_n = 0.3;
  scene.effects[Effect::kGravity] = Wish::kAuto;
  EXPECT_REL(RestingForceN({.scene = scene, .piecewise = {}}), 0.3 + 6.6e-3 * 9.80665, 1e-12,
             "rounding");
  const EffectiveScene breaking{.scene = scene, .piecewise = {.contact_loss = ContactLoss{0.07}}};
  EXPECT_EQ(RestingForceN(breaking), 0.07) << "all of it is in an effective preload";
  scene.adapter.reset();
  scene.grip.holds = true;
  EXPECT_EQ(RestingForceN({.scene = scene, .piecewise = {}}), 0);
}

// between rows too: three a period and a little more see other places of it each time
TEST(Waveforms, KnowTheLeastForceBetweenTheirRows) {
  Scene scene = tests::ConeScene();
  scene.start = Start::kSteady;
  scene.effects.contact_loss = ContactLoss{0.2};
  const EffectiveScene effective{.scene = scene, .piecewise = {}};
  const double least_n = 0.2 + SolveSteadyState(scene).skin_force_least_n;
  const Waveforms waves =
      PlayWaveforms(effective, BeginningOf(effective), 0.1, 64 * 225.0 * 0.99, true);
  ASSERT_TRUE(waves.force_least_n);
  EXPECT_REL(*waves.force_least_n, least_n, 1e-9, "a peak between 63 outputs, to 1e-10");
  EXPECT_FALSE(PlayWaveforms(effective, BeginningOf(effective), 0.01, 1000).force_least_n);
}

// rows 0 to floor(duration rate)
TEST(Waveforms, HaveTheRowsOfTheirDuration) {
  const EffectiveScene effective{.scene = tests::ConeScene(), .piecewise = {}};
  const auto rows = [&](double duration_s) {
    return PlayWaveforms(effective, BeginningOf(effective), duration_s, 1000).rows();
  };
  for (int count = 1; count <= 60; ++count) {
    EXPECT_EQ(rows(count / 1000.0), count + 1);
    EXPECT_EQ(rows((count + 0.999) / 1000.0), count + 1);
  }
}

}  // namespace
}  // namespace haptometer::sim
