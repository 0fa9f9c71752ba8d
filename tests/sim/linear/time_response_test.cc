#include "sim/linear/time_response.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>

#include "sim/linear/driven_step.h"
#include "sim/linear/steady_state.h"
#include "tests/residual.h"
#include "tests/sim/reference/linear_reference.h"
#include "tests/sim/thesis_scenes.h"
#include "tests/sim/uniform_motion.h"

namespace haptometer::sim {
namespace {

using tests::AdapterScene;

TimeResponse ResponseOf(const Scene& scene, Start start) {
  return {AssembleModel(scene), scene.drive, start};
}

// a scene's states in steps, from its state at start_s on
Eigen::MatrixXd Stepped(const Scene& scene, const Eigen::VectorXd& initial, double start_s,
                        double rate_hz, std::size_t count) {
  return UniformMotion(AssembleModel(scene), scene.drive, initial, start_s, rate_hz, count);
}

const Eigen::VectorXd kAtRest = Eigen::VectorXd::Zero(7);

// amplitude of each state in steady motion: what errors are measured against
Eigen::VectorXd Amplitudes(const Scene& scene) {
  return SolveSteadyState(scene).phasors.cwiseAbs();
}

double WorstError(const Scene& scene, const Eigen::VectorXd& actual,
                  const Eigen::VectorXd& expected) {
  return ((actual - expected).array() / Amplitudes(scene).array()).abs().maxCoeff();
}

Scene WithInductance(double inductance_h) {
  Scene scene = AdapterScene();
  scene.actuator.inductance_h = inductance_h;
  return scene;
}

Eigen::VectorXd Vector(const double (&values)[7]) {
  return Eigen::Map<const Eigen::VectorXd>(values, 7);
}

// the quintic c0 + c1 u + ... + c5 u^5, u = t / h, with its derivatives by time
MotionJet JetOf(const std::array<double, 6>& c, double u, double h_s) {
  MotionJet jet;
  for (std::size_t k = 0; k < c.size(); ++k) {
    const auto power = static_cast<double>(k);
    jet.x += c[k] * std::pow(u, power);
    if (k >= 1) jet.v += c[k] * power * std::pow(u, power - 1) / h_s;
    if (k >= 2) jet.a += c[k] * power * (power - 1) * std::pow(u, power - 2) / (h_s * h_s);
  }
  return jet;
}

HermiteQuintic QuinticOf(const std::array<double, 6>& c, double h_s) {
  return {JetOf(c, 0, h_s), JetOf(c, 1, h_s), h_s};
}

TEST(HermiteQuintic, OfAQuinticIsThatQuintic) {
  const std::array<double, 6> c{0.3, -1.1, 0.7, 1.9, -2.3, 0.9};
  for (const double h_s : {0.02, 1.0, 3.0}) {
    const HermiteQuintic quintic = QuinticOf(c, h_s);
    for (const double u : {0.0, 0.1, 0.5, 0.8, 1.0}) {
      EXPECT_ABS(quintic.At(u), JetOf(c, u, h_s).x, 1e-13, "sums of terms of some 20");
    }
  }
}

// x = u - 2^(k-1) u^k / k turns at u = 1/2, where it is 1/2 - 1/(2 k)
TEST(HermiteQuintic, HasItsExtremeWhereItsRateIsZero) {
  for (std::size_t k = 2; k <= 5; ++k) {
    const auto power = static_cast<double>(k);
    for (const double sign : {1.0, -1.0}) {
      std::array<double, 6> c{0.25, sign, 0, 0, 0, 0};
      c[k] = -sign * std::exp2(power - 1) / power;
      const ValueRange range = QuinticOf(c, 0.02).Range();
      const double turn = 0.25 + sign * (0.5 - 0.5 / power);
      const double end = 0.25 + sign * (1 - std::exp2(power - 1) / power);
      EXPECT_ABS(sign > 0 ? range.largest : range.least, turn, 1e-13, "rounding; flat there");
      EXPECT_ABS(sign > 0 ? range.least : range.largest,
                 sign > 0 ? std::min(0.25, end) : std::max(0.25, end), 1e-13, "an end");
    }
  }
  const ValueRange rising = QuinticOf({0, 1, 0, 1, 0, 1}, 0.02).Range();
  EXPECT_ABS(rising.least, 0, 1e-14, "an end");
  EXPECT_ABS(rising.largest, 3, 1e-13, "an end");
}

// h^6 max |x^(6)| / 46080, met in the middle of a step over a sine's peak
TEST(HermiteQuintic, IsWrongByItsStatedErrorInTheMiddle) {
  const double step = 2 * std::numbers::pi / 64;
  const auto jet = [](double t) { return MotionJet{std::cos(t), -std::sin(t), -std::cos(t)}; };
  const HermiteQuintic quintic(jet(-step / 2), jet(step / 2), step);
  EXPECT_REL(1 - quintic.At(0.5), std::pow(step, 6) / 46080, 0.01, "the cosine over the step");
}

TEST(TimeResponse, FromRestAgreesWithFiftyDigits) {
  const Scene scene = AdapterScene();
  const TimeResponse response = ResponseOf(scene, Start::kRest);
  EXPECT_ABS(WorstError(scene, response.StateAt(0.0123), Vector(tests::kAdapterState)), 0, 1e-13,
             "some 25 products, worst state");
  EXPECT_ABS(WorstError(scene, response.StateAt(0.1), Vector(tests::kAdapterLater)), 0, 5e-13,
             "some 25 products, worst state");
  const Eigen::VectorXd stepped = Stepped(scene, kAtRest, 0, 1e4, 1001).col(1000);
  EXPECT_ABS(WorstError(scene, stepped, Vector(tests::kAdapterLater)), 0, 1e-12,
             "a thousand products, worst state");
}

TEST(TimeResponse, WithAlmostNoInductanceLosesFewDigits) {
  const Scene ten = WithInductance(10e-6);
  const Scene one = WithInductance(1e-6);
  const TimeResponse response_ten = ResponseOf(ten, Start::kRest);
  const TimeResponse response_one = ResponseOf(one, Start::kRest);
  const char* stiff = "4 eps R/L t is the natural bound";
  EXPECT_ABS(WorstError(ten, response_ten.StateAt(0.0123), Vector(tests::kAdapterState10uH)), 0,
             5e-12, stiff);
  EXPECT_ABS(WorstError(one, response_one.StateAt(0.0123), Vector(tests::kAdapterState1uH)), 0,
             5e-11, stiff);
  EXPECT_ABS(WorstError(ten, Stepped(ten, kAtRest, 0, 1e4, 1001).col(1000),
                        Vector(tests::kAdapterLater10uH)),
             0, 5e-12, stiff);
  EXPECT_ABS(WorstError(one, Stepped(one, kAtRest, 0, 1e4, 1001).col(1000),
                        Vector(tests::kAdapterLater1uH)),
             0, 5e-11, stiff);
}

Scene SceneOf(const tests::HardReference& reference) {
  Scene scene = AdapterScene();
  scene.actuator.inductance_h = reference.inductance_h;
  scene.actuator.stiffness_n_per_m = reference.mover_stiffness_n_per_m;
  scene.actuator.damping_n_s_per_m = reference.mover_damping_n_s_per_m;
  scene.adapter->skin_side_mass_kg = reference.skin_side_mass_kg;
  scene.adapter->stiffness_n_per_m = reference.adapter_stiffness_n_per_m;
  scene.adapter->damping_n_s_per_m = reference.adapter_damping_n_s_per_m;
  scene.skin.stiffness_n_per_m = reference.skin_stiffness_n_per_m;
  return scene;
}

// the states and, last, the current; one column for each sample
Eigen::MatrixXd WithCurrent(const LinearModel& model, const SineDrive& drive,
                            const Eigen::MatrixXd& samples) {
  const Eigen::Index n = samples.rows();
  Eigen::MatrixXd all(7, samples.cols());
  all.topRows(n) = samples;
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    const double volt =
        drive.amplitude_v * DriveAt(drive.frequency_hz, static_cast<long double>(i) / 1e4L)[0];
    all(6, i) = model.current_row.dot(samples.col(i)) + model.current_per_volt * volt;
  }
  return all;
}

TEST(TimeResponse, OfHardCasesInSteps) {
  for (const tests::HardReference& reference : tests::kHardReferences) {
    SCOPED_TRACE(reference.name);
    const Scene scene = SceneOf(reference);
    const LinearModel model = AssembleModel(scene);
    EXPECT_EQ(model.states(), reference.inductance_h > 0 ? 7 : 6);
    const Eigen::MatrixXd samples = WithCurrent(
        model, scene.drive,
        UniformMotion(model, scene.drive, Eigen::VectorXd::Zero(model.states()), 0, 1e4, 1001));
    const Eigen::VectorXd peaks = samples.cwiseAbs().rowwise().maxCoeff();
    double worst = 0;
    for (Eigen::Index k = 0; k < 10; ++k) {
      const Eigen::VectorXd error = samples.col(100 * (k + 1)) - Vector(reference.states[k]);
      worst = std::max(worst, error.cwiseAbs().cwiseQuotient(peaks).maxCoeff());
    }
    // down to 1 uH less than the coil's own rate would allow: rounding of a step's 12 squarings,
    // 6e-12 of 1 uH on x86-64 and 1.4e-11 where products are fused (AArch64)
    const bool changed_coil = std::string_view(reference.name).ends_with(" uH");
    const double natural = 4 * 2.2e-16 * reference.fastest_rad_per_s * 0.1;
    double bar =
        changed_coil ? (reference.inductance_h < 50e-6 ? 2e-11 : 1e-12) : std::max(1e-12, natural);
    EXPECT_ABS(worst, 0, bar, "1e-12, 4 eps w t, and of coils as above");
  }
}

TEST(TimeResponse, WindowRmsIsTheIntegral) {
  const Scene scene = AdapterScene();
  const LinearModel model = AssembleModel(scene);
  const TimeResponse response = ResponseOf(scene, Start::kRest);
  const double rms_m = response.WindowRms(model.skin(), 0.1 - 10 / 225.0, 0.1);
  EXPECT_REL(rms_m, 0.1912e-3, 3e-4, "Lindsay 2013, Table 2.3 printed 0.1917; three digits");
  EXPECT_REL(rms_m, tests::kAdapterWindowRmsM, 2e-12, "fourteen doublings");
}

// far above the resonance an adapter keeps the skin a millionth to a billionth as large as the
// mover: it was off by 1e-10 at 3 kHz and 1e-7 at 30 kHz
TEST(TimeResponse, WindowRmsOfWhatAnAdapterKeepsQuietIsThatOfThePhasor) {
  Scene scene = AdapterScene();
  for (const double frequency_hz : {225.0, 3e3, 1e4, 3e4}) {
    scene.drive.frequency_hz = frequency_hz;
    const LinearModel model = AssembleModel(scene);
    const TimeResponse response = ResponseOf(scene, Start::kSteady);
    EXPECT_REL(response.WindowRms(model.skin(), 0.3, 0.3 + 10 / frequency_hz),
               SolveSteadyState(scene).skin_rms_m, 1e-12, "a hundred times 1e-14 seen");
  }
}

// mover and case all but one body: the skin moves by 1e-12 m, of what forces of 0.2 N leave over
TEST(TimeResponse, WindowRmsOfAStiffMoverIsTheIntegral) {
  Scene scene = AdapterScene();
  scene.actuator.stiffness_n_per_m = 1e11;
  const TimeResponse response = ResponseOf(scene, Start::kRest);
  EXPECT_REL(response.WindowRms(4, 0.1 - 10 / 225.0, 0.1), tests::kStiffMoverWindowRmsM, 1.2e-9,
             "4 eps w t, the bar of its states");
}

TEST(TimeResponse, WindowRmsOfTheSteadyStateIsTheEffectiveValue) {
  for (const Scene& scene : {AdapterScene(), tests::ConeScene(), tests::DirectScene()}) {
    const LinearModel model = AssembleModel(scene);
    const TimeResponse response = ResponseOf(scene, Start::kSteady);
    const double rms_m = response.WindowRms(model.skin(), 0.01, 0.01 + 10 / 225.0);
    EXPECT_REL(rms_m, SolveSteadyState(scene).skin_rms_m, 1e-12, "ten whole periods");
  }
}

TEST(TimeResponse, WindowsAddUp) {
  const TimeResponse response = ResponseOf(AdapterScene(), Start::kRest);
  const auto integral = [&](double begin_s, double end_s) {
    const double rms_m = response.WindowRms(4, begin_s, end_s);
    return rms_m * rms_m * (end_s - begin_s);
  };
  const double whole = integral(0, 0.08);
  for (const double cut_s : {1e-7, 1e-3, 0.0333, 0.0799}) {
    EXPECT_REL(integral(0, cut_s) + integral(cut_s, 0.08), whole, 2e-12, "rounding of doublings");
  }
}

TEST(TimeResponse, EndsInThePhasor) {
  for (const Scene& scene : {AdapterScene(), tests::ConeScene(), tests::DirectScene()}) {
    const TimeResponse rest = ResponseOf(scene, Start::kRest);
    const TimeResponse steady = ResponseOf(scene, Start::kSteady);
    // a whole number of periods later, all transients down by e^-41
    const SteadyState phasors = SolveSteadyState(scene);
    const Eigen::VectorXd expected = phasors.phasors.imag();
    for (const double t_s : {1.0, 2.0, 1000.0}) {
      EXPECT_ABS(WorstError(scene, rest.StateAt(t_s), expected), 0, 3e-13, "rounding");
      EXPECT_ABS(WorstError(scene, steady.StateAt(t_s), expected), 0, 3e-13, "rounding");
    }
  }
}

// powers of two up to 2^19 s
TEST(TimeResponse, ReachesAsFarAsTwoToTheTwentySeconds) {
  const Scene scene = AdapterScene();
  const TimeResponse response = ResponseOf(scene, Start::kRest);
  // a whole number of periods
  EXPECT_ABS(WorstError(scene, response.StateAt(1048575), SolveSteadyState(scene).phasors.imag()),
             0, 1e-12, "phase of 2^28 cycles in 64 bits, rounding");
  EXPECT_DEATH(static_cast<void>(response.StateAt(0x1p20)), "check failed");
  EXPECT_DEATH(static_cast<void>(response.StateAt(-1e-9)), "check failed");
}

TEST(TimeResponse, AnySplitOfTheIntervalGivesTheSame) {
  const Scene scene = AdapterScene();
  const TimeResponse response = ResponseOf(scene, Start::kRest);
  for (const double rate_hz : {1e2, 1e3, 2.2e4, 1e5}) {
    const auto steps = static_cast<std::size_t>(std::lround(0.05 * rate_hz));
    const Eigen::VectorXd stepped = Stepped(scene, kAtRest, 0, rate_hz, steps + 1).rightCols(1);
    const double t_s = static_cast<double>(steps) / rate_hz;
    EXPECT_ABS(WorstError(scene, stepped, response.StateAt(t_s)), 0, 2e-12, "rounding of steps");
  }
  // beginning in the middle is the same as having begun before
  const Eigen::MatrixXd whole = Stepped(scene, kAtRest, 0, 1e4, 200);
  const Eigen::MatrixXd late = Stepped(scene, response.StateAt(0.01), 0.01, 1e4, 100);
  EXPECT_ABS(WorstError(scene, late.col(99), whole.col(199)), 0, 1e-13, "rounding of steps");
}

TEST(TimeResponse, AtTimeZeroIsTheInitialState) {
  const Scene scene = AdapterScene();
  const Eigen::VectorXd initial = Eigen::VectorXd::LinSpaced(7, 1, 7);
  const TimeResponse response(AssembleModel(scene), scene.drive, initial);
  EXPECT_EQ(response.StateAt(0), initial);
  // after a time too short for anything but the first derivative
  const double t_s = 1e-12;
  const Eigen::VectorXd moved = response.StateAt(t_s) - initial;
  EXPECT_REL(moved(LinearModel::kMover) / t_s, initial(LinearModel::kMoverVelocity), 3e-4,
             "eps x / (v t)");
}

TEST(TimeResponse, IsLinearInTheVoltage) {
  Scene scene = AdapterScene();
  const Eigen::VectorXd once = ResponseOf(scene, Start::kRest).StateAt(0.02);
  scene.drive.amplitude_v *= 3;
  const Eigen::VectorXd thrice = ResponseOf(scene, Start::kRest).StateAt(0.02);
  EXPECT_ABS(WorstError(scene, thrice, 3 * once), 0, 2e-14, "the balance may differ by a factor");
}

// A body on a spring alone, driven by nothing: cos(w t) for ever.
LinearModel UndampedOscillator(double stiffness_over_mass) {
  LinearModel model{.a = Eigen::MatrixXd::Zero(5, 5),
                    .b = Eigen::VectorXd::Zero(5),
                    .current_row = Eigen::RowVectorXd::Zero(5)};
  model.a(3, 4) = 1;
  model.a(4, 3) = -stiffness_over_mass;
  return model;
}

TEST(TimeResponse, UndampedForAMillionCyclesHardlyDrifts) {
  const double omega = 2 * std::numbers::pi * 225;
  Eigen::VectorXd initial = Eigen::VectorXd::Zero(5);
  initial(3) = 1;
  const LinearModel model = UndampedOscillator(omega * omega);
  const SineDrive silence{.amplitude_v = 0, .frequency_hz = 225};
  const TimeResponse response(model, silence, initial);
  // amplitude from position and velocity: in one question, and in steps
  const auto amplitude = [&](const Eigen::VectorXd& x) { return std::hypot(x(3), x(4) / omega); };
  const double t_s = 1e6 / 225;
  EXPECT_REL(amplitude(response.StateAt(t_s)), 1, 5e-9,
             "22 squarings beyond one period's rounding");
  const Eigen::MatrixXd block = UniformMotion(model, silence, initial, 0, 1e4, 10001);
  EXPECT_REL(amplitude(block.col(10000)), 1, 5e-12, "225 cycles in 1e4 steps");
}

// Critical damping: two equal eigenvalues, no eigenvectors to lean on. x = (1 + p t) e^-pt.
TEST(TimeResponse, CriticallyDampedIsTheClosedForm) {
  for (const double detuning : {0.0, 1e-14, 1e-10, -1e-10}) {
    const double p = 1400;
    LinearModel model = UndampedOscillator(p * p * (1 + detuning));
    model.a(4, 4) = -2 * p;
    Eigen::VectorXd initial = Eigen::VectorXd::Zero(5);
    initial(3) = 1;
    const TimeResponse response(model, {.amplitude_v = 0, .frequency_hz = 225}, initial);
    for (const double t_s : {1e-5, 1e-3, 1e-2}) {
      const double expected = (1 + p * t_s) * std::exp(-p * t_s);
      EXPECT_REL(response.StateAt(t_s)(3), expected, 1e-12 + 50 * std::abs(detuning),
                 "closed form of the exact case");
    }
  }
}

// Resonant drive without damping: x grows as t; no phasor exists, the time response does.
TEST(TimeResponse, OfAnUndampedResonanceGrowsLinearly) {
  const double omega = 64;
  LinearModel model = UndampedOscillator(omega * omega);
  model.b(4) = 1;
  const TimeResponse response(
      model, {.amplitude_v = 1, .frequency_hz = omega / (2 * std::numbers::pi)}, Start::kRest);
  // x'' + w^2 x = sin w t  ->  x = (sin w t - w t cos w t) / (2 w^2)
  for (const double t_s : {0.01, 1.0, 20.0}) {
    const double phase = omega * t_s;
    const double expected = (std::sin(phase) - phase * std::cos(phase)) / (2 * omega * omega);
    EXPECT_ABS(response.StateAt(t_s)(3), expected, 1e-17 * (1 + phase * phase),
               "eps times the phase, times the growth");
  }
}

// No dampers, no drive, and a force constant so small that the coil takes nothing: the energy of
// the start stays, in all three bodies and springs together.
TEST(TimeResponse, WithoutDampersAndCurrentConservesEnergy) {
  Scene scene = AdapterScene();
  scene.actuator.damping_n_s_per_m = 0;
  scene.actuator.force_constant_n_per_a = 1e-9;
  scene.adapter->damping_n_s_per_m = 0;
  scene.skin.damping_n_s_per_m = 0;
  scene.drive.amplitude_v = 0;
  const auto energy_j = [&](const Eigen::VectorXd& x) {
    const double mc1 = scene.actuator.case_mass_kg + scene.adapter->motor_side_mass_kg;
    return (scene.actuator.moving_mass_kg * x(1) * x(1) + mc1 * x(3) * x(3) +
            scene.adapter->skin_side_mass_kg * x(5) * x(5) +
            scene.actuator.stiffness_n_per_m * std::pow(x(0) - x(2), 2) +
            scene.adapter->stiffness_n_per_m * std::pow(x(2) - x(4), 2) +
            scene.skin.stiffness_n_per_m * x(4) * x(4)) /
           2;
  };
  Eigen::VectorXd initial = Eigen::VectorXd::Zero(7);
  initial(0) = 1e-3;
  initial(5) = 0.2;
  const TimeResponse response(AssembleModel(scene), scene.drive, initial);
  for (const double t_s : {1e-4, 0.01, 1.0}) {
    EXPECT_REL(energy_j(response.StateAt(t_s)), energy_j(initial), 2e-11, "eps R/L t");
  }
}

}  // namespace
}  // namespace haptometer::sim
