#include "sim/linear/steady_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/scene_run.h"
#include "tests/residual.h"
#include "tests/sim/reference/linear_reference.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

using tests::AdapterScene;
using tests::ConeScene;
using tests::DirectScene;

constexpr const char* kFiftyDigits = "mpmath from the equations of motion; rounding only";

TEST(SteadyStateBars, AreMet) {
  EXPECT_REL(SolveSteadyState(AdapterScene()).skin_rms_m, 0.2001762058e-3, 1e-9,
             "the bar, ten digits");
  EXPECT_REL(SolveSteadyState(ConeScene()).skin_rms_m, 0.0461001664e-3, 1e-9,
             "the bar, nine digits");
  EXPECT_REL(SolveSteadyState(DirectScene()).skin_rms_m, 0.04499108754e-3, 1e-9,
             "the bar, ten digits");
}

TEST(SteadyState, OfTheAdapterSceneAgreesWithFiftyDigits) {
  const SteadyState steady = SolveSteadyState(AdapterScene());
  EXPECT_REL(steady.skin_rms_m, tests::kAdapterSkinRmsM, 2e-15, kFiftyDigits);
  EXPECT_REL(steady.mover_peak_m, tests::kAdapterMoverPeakM, 2e-15, kFiftyDigits);
  EXPECT_REL(steady.case_rms_m, tests::kAdapterCaseRmsM, 2e-15, kFiftyDigits);
  EXPECT_REL(steady.current_rms_a, tests::kAdapterCurrentRmsA, 2e-15, kFiftyDigits);
  EXPECT_REL(steady.power_w, tests::kAdapterPowerW, 2e-15, kFiftyDigits);
  EXPECT_REL(steady.phase_rad, tests::kAdapterPhaseRad, 2e-13, "a small angle of two large parts");
  EXPECT_REL(steady.skin_force_peak_n, tests::kAdapterSkinForcePeakN, 2e-15, kFiftyDigits);
}

TEST(SteadyState, OfTheConeAndDirectScenesAgreesWithFiftyDigits) {
  const SteadyState cone = SolveSteadyState(ConeScene());
  EXPECT_REL(cone.skin_rms_m, tests::kConeSkinRmsM, 2e-15, kFiftyDigits);
  EXPECT_REL(cone.mover_peak_m, tests::kConeMoverPeakM, 2e-15, kFiftyDigits);
  EXPECT_REL(cone.power_w, tests::kConePowerW, 2e-15, kFiftyDigits);
  EXPECT_REL(cone.phase_rad, tests::kConePhaseRad, 2e-13, "a small angle of two large parts");
  EXPECT_EQ(cone.skin_rms_m, cone.case_rms_m);
  const SteadyState direct = SolveSteadyState(DirectScene());
  EXPECT_REL(direct.skin_rms_m, tests::kDirectSkinRmsM, 2e-15, kFiftyDigits);
  EXPECT_REL(direct.mover_peak_m, tests::kDirectMoverPeakM, 2e-15, kFiftyDigits);
  EXPECT_REL(direct.current_rms_a, tests::kDirectCurrentRmsA, 2e-15, kFiftyDigits);
  EXPECT_REL(direct.skin_force_peak_n, tests::kDirectSkinForcePeakN, 2e-15, kFiftyDigits);
}

// mover and case all but one body: what the coil's pair of forces leaves over is 1e-9 of them
TEST(SteadyState, OfAStiffMoverAgreesWithFiftyDigits) {
  Scene scene = AdapterScene();
  scene.actuator.stiffness_n_per_m = 1e11;
  const SteadyState steady = SolveSteadyState(scene);
  const char* balance = "eps of 64 bits times Kv/Ks";
  EXPECT_REL(steady.skin_rms_m, tests::kStiffMoverSkinRmsM, 1e-11, balance);
  EXPECT_REL(steady.case_rms_m, tests::kStiffMoverCaseRmsM, 1e-11, balance);
  EXPECT_REL(steady.power_w, tests::kStiffMoverPowerW, 2e-15, kFiftyDigits);
  EXPECT_LE(std::abs(steady.skin_rms_m / tests::kStiffMoverSkinRmsM - 1), steady.error_estimate);
  EXPECT_LT(steady.error_estimate, 1e-8)
      << "eps Kv/Ks: rounding of the phasors as if it did not cancel";
}

TEST(SteadyState, BoundsItsOwnError) {
  for (const double frequency_hz : {10.0, 47.6, 225.15, 613.7, 1e4, 1e6}) {
    Scene scene = AdapterScene();
    scene.drive.frequency_hz = frequency_hz;
    const SteadyState steady = SolveSteadyState(scene);
    EXPECT_GT(steady.error_estimate, 1e-16) << frequency_hz;
    EXPECT_LT(steady.error_estimate, 1e-11) << frequency_hz;
  }
  const SteadyState steady = SolveSteadyState(AdapterScene());
  EXPECT_LE(std::abs(steady.skin_rms_m / tests::kAdapterSkinRmsM - 1), steady.error_estimate);
}

Scene SceneOf(const tests::SharpReference& sharp) {
  Scene scene;
  scene.actuator = {.moving_mass_kg = sharp.moving_mass_kg,
                    .case_mass_kg = sharp.case_mass_kg,
                    .stiffness_n_per_m = sharp.mover_stiffness_n_per_m,
                    .damping_n_s_per_m = sharp.mover_damping_n_s_per_m,
                    .force_constant_n_per_a = sharp.force_constant_n_per_a,
                    .resistance_ohm = sharp.resistance_ohm,
                    .inductance_h = sharp.inductance_h};
  if (sharp.skin_side_mass_kg > 0) {
    scene.adapter = Adapter{.motor_side_mass_kg = sharp.motor_side_mass_kg,
                            .skin_side_mass_kg = sharp.skin_side_mass_kg,
                            .stiffness_n_per_m = sharp.adapter_stiffness_n_per_m,
                            .damping_n_s_per_m = sharp.adapter_damping_n_s_per_m};
  }
  scene.skin = {.stiffness_n_per_m = sharp.skin_stiffness_n_per_m,
                .damping_n_s_per_m = sharp.skin_damping_n_s_per_m};
  scene.grip.stiffness_n_per_m = sharp.grip_stiffness_n_per_m;
  scene.drive = {.amplitude_v = sharp.amplitude_v, .frequency_hz = sharp.frequency_hz};
  return scene;
}

double LargestDeviation(const SteadyState& steady, const tests::SharpReference& sharp) {
  double largest = 0;
  for (const auto& [value, reference] : {std::pair(steady.skin_rms_m, sharp.skin_rms_m),
                                         {steady.mover_peak_m, sharp.mover_peak_m},
                                         {steady.case_rms_m, sharp.case_rms_m},
                                         {steady.current_rms_a, sharp.current_rms_a},
                                         {steady.power_w, sharp.power_w},
                                         {steady.skin_force_peak_n, sharp.skin_force_peak_n}}) {
    if (reference != 0) largest = std::max(largest, std::abs(value / reference - 1));
  }
  return largest;
}

// the rounding of 2 pi f is seen 1e2 to 1e4 times beside these resonances
TEST(SteadyState, BoundsItsErrorBesideSharpResonances) {
  for (const tests::SharpReference& sharp : tests::kSharpReferences) {
    const SteadyState steady = SolveSteadyState(SceneOf(sharp));
    const double deviation = LargestDeviation(steady, sharp);
    EXPECT_LE(deviation, steady.error_estimate) << sharp.frequency_hz;
    if (sharp.frequency_hz < 1) {
      EXPECT_GE(steady.error_estimate, 1) << "the inertia of bodies that float is lost in doubles";
      continue;
    }
    EXPECT_LT(deviation, 1e-15) << sharp.frequency_hz << ": " << kFiftyDigits;
    EXPECT_LT(steady.error_estimate, 2e-13) << sharp.frequency_hz;
  }
}

// mean electrical power against what the resistance and the three dampers turn into heat
TEST(SteadyState, TakesThePowerThatItDissipates) {
  for (Scene scene : {AdapterScene(), ConeScene(), DirectScene()}) {
    for (const double frequency_hz : {20.0, 100.0, 225.0, 700.0}) {
      scene.drive.frequency_hz = frequency_hz;
      const LinearModel model = AssembleModel(scene);
      const SteadyState steady = SolveSteadyState(scene);
      const auto& x = steady.phasors;
      const auto half_square = [](std::complex<double> z) { return std::norm(z) / 2; };
      const auto case_velocity = x(LinearModel::kCaseVelocity);
      const auto skin_velocity = x(model.skin_velocity());
      double heat_w = scene.actuator.resistance_ohm * half_square(steady.current_a);
      heat_w += scene.actuator.damping_n_s_per_m *
                half_square(x(LinearModel::kMoverVelocity) - case_velocity);
      heat_w += scene.skin.damping_n_s_per_m * half_square(skin_velocity);
      if (scene.adapter) {
        heat_w += scene.adapter->damping_n_s_per_m * half_square(case_velocity - skin_velocity);
      }
      EXPECT_REL(heat_w, steady.power_w, 3e-15, "conservation of energy, rounding only");
    }
  }
}

// what holds the case and what the source has inside dissipate as well
TEST(SteadyState, TakesThePowerOfGripAndSource) {
  for (Scene scene : {AdapterScene(), DirectScene()}) {
    for (const double inductance_h : {130e-6, 0.0}) {
      scene.actuator.inductance_h = inductance_h;
      const double alone_w = SolveSteadyState(scene).power_w;
      Scene held = scene;
      held.grip = {.stiffness_n_per_m = 300, .damping_n_s_per_m = 0.8};
      held.drive.source_resistance_ohm = 3;
      const SteadyState steady = SolveSteadyState(held);
      // Re(V conj(I)) / 2
      EXPECT_REL(steady.power_w, held.drive.amplitude_v * steady.current_a.real() / 2, 1e-13,
                 "a current nearly in phase; rounding");
      EXPECT_GT(std::abs(steady.power_w / alone_w - 1), 1e-3);
    }
  }
}

TEST(SkinRmsUncertainty, OfACurrentDrivenActuatorIsThatOfKmOverR) {
  // through 1 Mohm the current is V / R whatever moves, so the RMS goes as Km / R
  Scene scene = AdapterScene();
  scene.actuator.resistance_ohm = 1e6;
  scene.actuator_covariance[4][4] = 0.02 * 0.02;
  scene.actuator_covariance[5][5] = 0.03 * 0.03;
  EXPECT_REL(SkinRmsUncertainty(scene), std::hypot(0.02, 0.03), 1e-4, "back EMF, 1e-6 of R");
  // what moves both alike cancels
  scene.actuator_covariance[5][5] = 0.02 * 0.02;
  scene.actuator_covariance[4][5] = scene.actuator_covariance[5][4] = 0.02 * 0.02;
  EXPECT_ABS(SkinRmsUncertainty(scene), 0.0, 1e-6, "back EMF, 1e-6 of R, and its root of rounding");
}

TEST(SkinRmsUncertainty, IsTheChangeThatAMovedConstantMakes) {
  constexpr double kStep = 3e-4;  // three times that of the library
  for (std::size_t place = 0; place < kActuatorSymbols.size(); ++place) {
    SCOPED_TRACE(kActuatorSymbols[place]);
    Scene scene = AdapterScene();
    // a case and a coil that are not hidden by the adapter's motor side and by the resistance
    scene.actuator.case_mass_kg = 10e-3;
    scene.actuator.inductance_h = 3e-3;
    scene.actuator_covariance[place][place] = 1e-6;
    const auto moved = [&](double factor) {
      Scene other = scene;
      other.actuator = Scaled(scene.actuator, place, factor);
      return SolveSteadyState(other).skin_rms_m;
    };
    const double change =
        1e-3 * std::abs(std::log(moved(std::exp(kStep)) / moved(std::exp(-kStep)))) / (2 * kStep);
    EXPECT_GT(change, 1e-5) << "ten times the tolerance below";
    EXPECT_ABS(SkinRmsUncertainty(scene), change, 1e-6,
               "third order of the step by the resonance's width");
  }
  EXPECT_EQ(SkinRmsUncertainty(AdapterScene()), 0) << "all is stated as exact";
}

TEST(SteadyState, IsLinearInTheVoltage) {
  Scene scene = AdapterScene();
  const SteadyState one = SolveSteadyState(scene);
  scene.drive.amplitude_v *= 4;
  const SteadyState four = SolveSteadyState(scene);
  // a power of two is exact in binary
  EXPECT_EQ(four.skin_rms_m, 4 * one.skin_rms_m);
  EXPECT_EQ(four.power_w, 16 * one.power_w);
  EXPECT_EQ(four.phase_rad, one.phase_rad);
  // the phase counts from the voltage, whichever sign that begins with
  scene.drive.amplitude_v *= -1;
  const SteadyState turned = SolveSteadyState(scene);
  EXPECT_EQ(turned.phase_rad, one.phase_rad);
  EXPECT_EQ(turned.current_a, -four.current_a);
  scene.drive.amplitude_v = 0;
  const SteadyState silent = SolveSteadyState(scene);
  EXPECT_EQ(silent.skin_rms_m, 0);
  EXPECT_EQ(silent.error_estimate, 0);
}

// Masses, springs and dampers times s, force constant and voltage times sqrt(s): the coil's
// equation and so the current grow by sqrt(s), all forces by s, and the motion stays.
TEST(SteadyState, ScalesWithTheUnitOfForce) {
  const Scene scene = AdapterScene();
  Scene scaled = scene;
  const double s = 4;
  scaled.actuator.moving_mass_kg *= s;
  scaled.actuator.case_mass_kg *= s;
  scaled.actuator.stiffness_n_per_m *= s;
  scaled.actuator.damping_n_s_per_m *= s;
  scaled.actuator.force_constant_n_per_a *= std::sqrt(s);
  scaled.adapter->motor_side_mass_kg *= s;
  scaled.adapter->skin_side_mass_kg *= s;
  scaled.adapter->stiffness_n_per_m *= s;
  scaled.adapter->damping_n_s_per_m *= s;
  scaled.skin.stiffness_n_per_m *= s;
  scaled.skin.damping_n_s_per_m *= s;
  scaled.drive.amplitude_v *= std::sqrt(s);
  const SteadyState one = SolveSteadyState(scene);
  const SteadyState other = SolveSteadyState(scaled);
  EXPECT_REL(other.skin_rms_m, one.skin_rms_m, 1e-15, "the same motion");
  EXPECT_REL(other.power_w, s * one.power_w, 1e-15, "s times the power");
}

// Without dampers and skin, the mover against the free case is a two-body oscillator in closed
// form, |Xrel| = F / |Kv - mu w^2| with mu = Mv Mc / (Mv + Mc); a resistance of 1e8 ohm makes the
// current 1 A, whatever the back EMF.
TEST(SteadyState, OfTwoFreeBodiesIsTheClosedForm) {
  Scene scene = ConeScene();
  scene.actuator.damping_n_s_per_m = 0;
  scene.actuator.resistance_ohm = 1e8;
  scene.actuator.inductance_h = 1e-9;
  scene.skin = {0, 0};
  scene.drive = {.amplitude_v = 1e8, .frequency_hz = 200};
  const double omega = 2 * std::numbers::pi * 200;
  const double reduced_kg = 1.4e-3 * 0.6e-3 / (1.4e-3 + 0.6e-3);
  const double expected_m = 1 / std::abs(2800 - reduced_kg * omega * omega);
  EXPECT_REL(SolveSteadyState(scene).mover_peak_m, expected_m, 1e-15, "back EMF of 1e-16");
}

// At an undamped resonance the amplitude has no bound, and the answer must not look like one.
TEST(SteadyState, AtAnUndampedResonanceSaysThatThereIsNone) {
  // the skin's side swings alone against a case that the drive does not reach
  LinearModel model;
  const double stiffness_n_per_m = 1024, mass_kg = 0.25;
  model.a = Eigen::MatrixXd::Zero(5, 5);
  model.b = Eigen::VectorXd::Zero(5);
  model.current_row = Eigen::RowVectorXd::Zero(5);
  model.power_rows = Eigen::MatrixXd::Zero(1, 6);
  model.a(0, 0) = -1;
  model.a(1, 1) = -1;
  model.a(4, 4) = -1;
  model.a(2, 3) = 1;
  model.a(3, 2) = -stiffness_n_per_m / mass_kg;
  model.b(3) = 1;
  const SineDrive drive{.amplitude_v = 1, .frequency_hz = 64 / (2 * std::numbers::pi)};
  EXPECT_GE(SolveSteadyState(model, drive, Skin{}).error_estimate, 1);
  // a thousandth beside it there is an answer again
  const SineDrive beside{.amplitude_v = 1, .frequency_hz = 64.064 / (2 * std::numbers::pi)};
  const SteadyState steady = SolveSteadyState(model, beside, Skin{});
  EXPECT_LT(steady.error_estimate, 1e-11);
  EXPECT_REL(steady.skin_rms_m, 1 / (64.064 * 64.064 - 64.0 * 64) / std::numbers::sqrt2, 5e-13,
             "closed form, a thousandfold cancellation");
}

// x'' + w0^2 x = sin w t, w = (1 + d) w0: X = -1 / (w0^2 (2 d + d^2)), a difference whose rounding
// is eps / d
TEST(SteadyState, BoundsItsErrorBesideAnUndampedResonance) {
  LinearModel model;
  model.a = -Eigen::MatrixXd::Identity(5, 5);
  model.a(2, 2) = model.a(3, 3) = 0;
  model.a(2, 3) = 1;
  model.a(3, 2) = -64.0 * 64;
  model.b = Eigen::VectorXd::Unit(5, 3);
  model.current_row = Eigen::RowVectorXd::Zero(5);
  model.power_rows = Eigen::MatrixXd::Zero(1, 6);
  constexpr double kEps = 0x1p-52;
  for (const double detuning : {1e-3, 1e-6, 1e-9}) {
    const SineDrive drive{.amplitude_v = 1,
                          .frequency_hz = 64 * (1 + detuning) / (2 * std::numbers::pi)};
    const SteadyState steady = SolveSteadyState(model, drive, Skin{});
    const double expected_m = 1 / (64 * 64 * detuning * (2 + detuning)) / std::numbers::sqrt2;
    EXPECT_REL(steady.skin_rms_m, expected_m, steady.error_estimate, "as stated");
    EXPECT_GT(steady.error_estimate, kEps / detuning);
    EXPECT_LT(steady.error_estimate, 30 * kEps / detuning);
  }
}

// x' = -x + sin t: X = (1 - j) / 2 without rounding. The equation may be off by eps (|M| |X| + |b|)
// = 2 eps, which |M^-1| makes 2 eps of X; eps for the terms of a sum, and 8 eps of the sum itself.
TEST(SteadyState, BoundsTheRoundingOfAnEquationThatHasNone) {
  LinearModel model;
  model.a = -Eigen::MatrixXd::Identity(5, 5);
  model.b = Eigen::VectorXd::Unit(5, LinearModel::kCase);
  model.current_row = Eigen::RowVectorXd::Unit(5, LinearModel::kCase);
  model.power_rows = Eigen::MatrixXd::Zero(1, 6);
  const SineDrive drive{.amplitude_v = 1, .frequency_hz = 1 / (2 * std::numbers::pi)};
  constexpr double kEps = 0x1p-52;
  const SteadyState steady = SolveSteadyState(model, drive, Skin{});
  EXPECT_ABS(steady.skin_rms_m, 0.5, 1e-16, "sqrt(1/2) / sqrt(2)");
  EXPECT_REL(steady.error_estimate, 11 * kEps, 1e-3, "nothing but the bound");
  // twice the error of what is squared
  model.power_rows(0, LinearModel::kCase) = 1;
  EXPECT_REL(SolveSteadyState(model, drive, Skin{}).error_estimate, 22 * kEps, 1e-3,
             "nothing but the bound");
}

// Under x' = -x + b sin t each X = b (1 - j) / 2 is off by 2 eps |X|, and a sum by what its terms
// are and by eps (sum of their magnitudes + 8 |sum|).
TEST(SteadyState, BoundsTheRoundingOfDifferences) {
  LinearModel model;
  model.a = -Eigen::MatrixXd::Identity(5, 5);
  model.b = Eigen::VectorXd::Unit(5, LinearModel::kCase);
  model.b(LinearModel::kMover) = 1.25;
  model.current_row = Eigen::RowVectorXd::Zero(5);
  model.power_rows = Eigen::MatrixXd::Zero(1, 6);
  const SineDrive drive{.amplitude_v = 1, .frequency_hz = 1 / (2 * std::numbers::pi)};
  constexpr double kEps = 0x1p-52;
  // mover 1.25, case 1 and travel 0.25 of one phasor: 3 (1.25 + 1) / 0.25 + 8
  EXPECT_REL(SolveSteadyState(model, drive, Skin{}).error_estimate, 35 * kEps, 1e-3,
             "nothing but the bound");
  // a current of that phasor less 0.375 A that the voltage gives without one: 0.125 - 0.5 j
  model.b(LinearModel::kMover) = 0;
  model.current_row(LinearModel::kCase) = 1;
  model.current_per_volt = -0.375;
  const double part = std::sqrt(0.5), sum = std::hypot(0.125, 0.5);
  EXPECT_REL(SolveSteadyState(model, drive, Skin{}).error_estimate,
             ((2 * part + part + 0.375) / sum + 8) * kEps, 1e-3, "nothing but the bound");
}

TEST(IsHeldInPlace, BySkinGripOrAHeldCase) {
  Scene scene = ConeScene();
  EXPECT_TRUE(IsHeldInPlace(scene));
  scene.skin.stiffness_n_per_m = 0;
  EXPECT_FALSE(IsHeldInPlace(scene));
  scene.grip.damping_n_s_per_m = 1;
  EXPECT_FALSE(IsHeldInPlace(scene)) << "dampers hold nothing in its place";
  scene.grip.stiffness_n_per_m = 1e-3;
  EXPECT_TRUE(IsHeldInPlace(scene));
  scene.grip = {.holds = true};
  EXPECT_TRUE(IsHeldInPlace(scene));
}

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
  // the least force is at one place of the period, at each of its 64 outputs and between them
  for (int k = 0; k < 160; ++k) {
    const SteadyTones tones = SolveSteadyTones(WithTones(sine, {{5, 225, 0.04 * k}}));
    EXPECT_REL(tones.skin_force_least_n, -expected.skin_force_peak_n, 1e-10, "quintics") << k;
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
    EXPECT_REL(tones.skin_force_least_n, run.skin_force_least_n, 1e-9, "quintics of either");
    Scene turned = scene;
    for (Tone& tone : turned.drive.tones) tone.amplitude *= -1;
    const double most_n = -SolveSteadyTones(turned).skin_force_least_n;
    EXPECT_REL(std::max(most_n, -tones.skin_force_least_n), tones.skin_force_peak_n, 1e-13,
               "rounding");
    EXPECT_GT(std::abs(most_n + tones.skin_force_least_n), 1e-3 * most_n) << "not symmetric";
    EXPECT_REL(tones.skin_power_w, run.ledger.dissipated_j[3] / tones.period_s, 1e-10,
               "the ledger's skin");
  }
}

TEST(SteadyTones, OfOneFrequencyAddUpFirst) {
  const Scene scene =
      WithTones(tests::AdapterScene(), {{2, 225, 0}, {2, 225, std::numbers::pi}, {1, 100, 0}});
  const SteadyTones alone = SolveSteadyTones(WithTones(tests::AdapterScene(), {{1, 100, 0}}));
  EXPECT_REL(SolveSteadyTones(scene).skin_rms_m, alone.skin_rms_m, 1e-12, "2 - 2 by rounding");
  // a sum of exactly 0 is no part of the motion
  const SteadyTones none =
      SolveSteadyTones(WithTones(tests::AdapterScene(), {{2, 225, 0}, {-2, 225, 0}, {1, 100, 0}}));
  EXPECT_EQ(none.skin_rms_m, alone.skin_rms_m);
  EXPECT_EQ(none.power_w, alone.power_w);
}

TEST(SteadyTones, WithoutACommonPeriodHaveTheSumAsBound) {
  const std::vector<Tone> both{{3, 225, 0}, {2, 225 * std::numbers::sqrt2, 0}};
  const Scene scene = WithTones(tests::AdapterScene(), both);
  const SteadyTones tones = SolveSteadyTones(scene);
  EXPECT_EQ(tones.period_s, 0);
  double sum_m = 0, sum_n = 0;
  for (const Tone& tone : both) {
    const SteadyTones part = SolveSteadyTones(WithTones(scene, {tone}));
    sum_m += part.mover_peak_m;
    sum_n += part.skin_force_peak_n;
  }
  EXPECT_REL(tones.mover_peak_m, sum_m, 1e-9, "quintics of the parts");
  EXPECT_REL(tones.skin_force_peak_n, sum_n, 1e-9, "quintics of the parts");
  EXPECT_REL(tones.skin_force_least_n, -sum_n, 1e-9, "quintics of the parts");
  // about a constant travel of Km V / (R Kv), on either side
  for (const double offset_v : {2.0, -2.0}) {
    Scene pushed = scene;
    pushed.drive.offset_v = offset_v;
    EXPECT_REL(SolveSteadyTones(pushed).mover_peak_m, sum_m + 2.0 / 27 / 2800, 1e-9, "quintics");
  }
  // and it is nearly met within a second
  Scene played = scene;
  played.start = Start::kSteady;
  played.duration_s = 1;
  const double peak_m = RunScene({.scene = played, .piecewise = {}}, 1).mover_peak_of_run_m;
  EXPECT_LE(peak_m, sum_m * (1 + 1e-9));
  EXPECT_GT(peak_m, 0.99 * sum_m);
}

// for a body that nothing holds under an offset only the period is given, without any peak
double CommonPeriodOf(const std::vector<double>& frequencies_hz) {
  std::vector<Tone> tones;
  for (const double frequency_hz : frequencies_hz) tones.push_back({1, frequency_hz, 0});
  Scene scene = WithTones(DirectScene(), tones);
  scene.skin.stiffness_n_per_m = 0;
  scene.drive.offset_v = 1;
  const SteadyTones found = SolveSteadyTones(scene);
  EXPECT_GE(found.error_estimate, 1);
  return found.period_s;
}

TEST(SteadyTones, HaveACommonPeriodUpToTwoToTheTwentyOutputs) {
  // 64 outputs in the shortest period: 1 048 512 and 1 048 640 in 100 s
  EXPECT_REL(CommonPeriodOf({163.83, 0.01}), 100, 1e-15, "rounding");
  EXPECT_EQ(CommonPeriodOf({163.85, 0.01}), 0);
  EXPECT_REL(CommonPeriodOf({60, 90, 105}), 1 / 15.0, 1e-15, "rounding");
  EXPECT_REL(CommonPeriodOf({0.000003, 0.000002}), 1e6, 1e-15, "one microhertz");
  EXPECT_REL(CommonPeriodOf({0.000001}), 1e6, 1e-15, "one microhertz");
  EXPECT_EQ(CommonPeriodOf({225.0000005}), 0) << "half a microhertz";
  EXPECT_REL(CommonPeriodOf({1e9}), 1e-9, 1e-15, "1e15 microhertz");
  EXPECT_EQ(CommonPeriodOf({1.01e9}), 0);
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
