#include "sim/linear/motor_source.h"

#include <gtest/gtest.h>

#include <complex>
#include <numbers>
#include <random>

#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/tuning/tuning_problem.h"
#include "tests/residual.h"
#include "tests/sim/reference/linear_reference.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

TEST(MotorSource, GivesTheThesisSceneItsFiftyDigits) {
  const Scene scene = tests::AdapterScene();
  const MotorSource source = SourceOf(scene.actuator, scene.drive);
  const AdapterMotion motion = MotionOf(source, *scene.adapter, scene.skin);
  EXPECT_REL(std::abs(motion.skin_m) / std::numbers::sqrt2, tests::kAdapterSkinRmsM, 1e-14,
             "rounding of some forty operations");
  EXPECT_REL(std::abs(motion.case_m) / std::numbers::sqrt2, tests::kAdapterCaseRmsM, 1e-14,
             "rounding of some forty operations");
  EXPECT_REL(ElectricalPower(source, motion.case_m), tests::kAdapterPowerW, 1e-14,
             "rounding of some forty operations");
  EXPECT_GT(source.stiffness_n_per_m.imag(), 0);
  EXPECT_LT(source.rounding_allowance, 1e-10);
}

TEST(MotorSource, MovesAsTheSevenStatesDo) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0, 1);
  const AdapterBounds bounds = ThesisBounds();
  Scene scene = tests::AdapterScene();
  for (int trial = 0; trial < 300; ++trial) {
    scene.drive.frequency_hz = 30 + 600 * part(random);
    scene.adapter = Adapter{.motor_side_mass_kg = bounds.motor_side_mass_kg.At(part(random)),
                            .skin_side_mass_kg = bounds.skin_side_mass_kg.At(part(random)),
                            .stiffness_n_per_m = bounds.stiffness_n_per_m.At(part(random)),
                            .damping_n_s_per_m = bounds.damping_n_s_per_m.At(part(random))};
    scene.skin = SkinUnderArea(AreaAt(bounds.contact_area_m2, part(random)), SkinRange::kTable);
    const SteadyState steady = SolveSteadyState(scene);
    const MotorSource source = SourceOf(scene.actuator, scene.drive);
    const AdapterMotion motion = MotionOf(source, *scene.adapter, scene.skin);
    EXPECT_REL(std::abs(motion.skin_m) / std::numbers::sqrt2, steady.skin_rms_m, 1e-12,
               "rounding, near resonances");
    EXPECT_REL(std::abs(motion.case_m) / std::numbers::sqrt2, steady.case_rms_m, 1e-11,
               "rounding, near antiresonances");
    EXPECT_REL(ElectricalPower(source, motion.case_m), steady.power_w, 1e-12, "rounding");
  }
}

using Complex = std::complex<double>;

// a case that a grip holds does not move: Xa = 0
TEST(MotorSource, OfACaseThatIsHeldIsTheMoverAlone) {
  Scene scene = tests::ConeScene();
  scene.grip.holds = true;
  for (const double frequency_hz : {50.0, 225.0, 900.0}) {
    scene.drive.frequency_hz = frequency_hz;
    const MotorSource source = SourceOf(scene.actuator, scene.drive);
    const SteadyState steady = SolveSteadyState(scene);
    EXPECT_REL(source.blocked_power_w, steady.power_w, 1e-13, "rounding");
    EXPECT_REL(ElectricalPower(source, 0), steady.power_w, 1e-13, "rounding");
    EXPECT_REL(std::abs(source.free_travel_m), steady.mover_peak_m, 1e-13, "rounding");
    EXPECT_REL(MoverTravel(source, 0), steady.mover_peak_m, 1e-13, "rounding");
  }
}

// k1 = Kv + j w Bv + Km^2 j w / (R + j w L)
TEST(MotorSource, StatesWhatItsRoundingMayDo) {
  const Actuator actuator = tests::AdapterScene().actuator;
  const double R = actuator.resistance_ohm, L = actuator.inductance_h;
  for (const double frequency_hz : {50.0, 225.0, 900.0}) {
    const MotorSource source = SourceOf(actuator, {.amplitude_v = 5, .frequency_hz = frequency_hz});
    const double w = 2 * std::numbers::pi * frequency_hz;
    const double Km = actuator.force_constant_n_per_a;
    const double damping =
        w * actuator.damping_n_s_per_m + Km * Km * w * R / (R * R + w * w * L * L);
    const double elastic =
        actuator.stiffness_n_per_m + Km * Km * w * w * L / (R * R + w * w * L * L);
    EXPECT_REL(source.coupling_damping_n_per_m, damping, 1e-13, "rounding");
    const Complex k1(elastic, damping), d1 = k1 - actuator.moving_mass_kg * w * w;
    const Complex kc = k1 - k1 * k1 / d1;
    const double larger = 1 + std::abs(k1 / d1);
    EXPECT_REL(source.rounding_allowance,
               64 * 0x1p-52 * larger * larger * (1 + std::abs(kc) / kc.imag()), 1e-10,
               "kc as a difference");
  }
}

Complex SkinPhasor(const Scene& scene) {
  return SolveSteadyState(scene).phasors(AssembleModel(scene).skin());
}

TEST(Impedance, OfTheSkinIsForceOverVelocity) {
  const Skin skin{.stiffness_n_per_m = 600, .damping_n_s_per_m = 0.75};
  const Complex z = SkinImpedance(skin, 225);
  EXPECT_REL(z.real(), 0.75, 1e-15, "Bs");
  EXPECT_REL(z.imag(), -600 / (2 * std::numbers::pi * 225), 1e-15, "Ks / w");
}

// Thevenin's theorem: one force behind one impedance moves every skin as the seven states do.
TEST(Impedance, OfTheDriverHoldsForEverySkin) {
  for (Scene scene : {tests::AdapterScene(), tests::ConeScene()}) {
    for (const double frequency_hz : {50.0, 175.0, 225.0, 500.0}) {
      scene.drive.frequency_hz = frequency_hz;
      const Complex driver = DriverImpedance(scene, frequency_hz);
      const auto force = [&](const Skin& skin) {
        scene.skin = skin;
        return SkinPhasor(scene) * (SkinImpedance(skin, frequency_hz) + driver);
      };
      const Complex soft = force({.stiffness_n_per_m = 600, .damping_n_s_per_m = 0.75});
      const Complex stiff = force({.stiffness_n_per_m = 1e5, .damping_n_s_per_m = 50});
      EXPECT_ABS(std::abs(soft - stiff) / std::abs(soft), 0, 1e-11, "both are rounded");
    }
  }
}

// NumPy's eigenvalues of the same matrix, to the digits printed there
TEST(Poles, OfTheAdapterScene) {
  const auto poles = Poles(AssembleModel(tests::AdapterScene()));
  ASSERT_EQ(poles.size(), 7U);
  const auto hertz = [&](std::size_t i) { return std::abs(poles[i]) / (2 * std::numbers::pi); };
  EXPECT_REL(hertz(0), 47.602812983678525, 1e-9, "NumPy does not balance as we do");
  EXPECT_REL(hertz(2), 225.15167079840842, 1e-9, "NumPy");
  EXPECT_REL(hertz(4), 613.7186476910264, 1e-9, "NumPy");
  EXPECT_REL(poles[2].real(), -41.5933066703883, 1e-9, "NumPy");
  EXPECT_REL(poles[6].real(), -207622.25139749915, 1e-9, "the coil's");
}

TEST(Sensitivity, ChangesOneNumberOnly) {
  const Scene scene = tests::AdapterScene();
  const Scene heavier = Scaled(scene, SceneNumber::kMa2, 1.5);
  EXPECT_REL(heavier.adapter->skin_side_mass_kg, 1.5 * 4.35e-3, 1e-15, "as asked");
  EXPECT_EQ(heavier.adapter->stiffness_n_per_m, scene.adapter->stiffness_n_per_m);
  EXPECT_EQ(heavier.skin.damping_n_s_per_m, scene.skin.damping_n_s_per_m);
  EXPECT_EQ(Symbol(SceneNumber::kMa2), "Ma2");
  for (const SceneNumber number : kSceneNumbers) EXPECT_EQ(RelativeSkinRms(scene, number, 1), 1);
}

// an independent solution of the same seven equations (NumPy), to its four decimals
TEST(Sensitivity, AtHalfAsMuchMore) {
  const Scene scene = tests::AdapterScene();
  constexpr double kExpected[] = {-0.0001, -0.5898, -0.4292, -0.0037, -0.0186, -0.2165};
  for (std::size_t i = 0; i < kSceneNumbers.size(); ++i) {
    EXPECT_ABS(RelativeSkinRms(scene, kSceneNumbers[i], 1.5) - 1, kExpected[i], 5.1e-5,
               "half of the last decimal");
  }
}

}  // namespace
}  // namespace haptometer::sim
