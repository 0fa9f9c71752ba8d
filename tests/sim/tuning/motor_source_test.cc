#include "sim/tuning/motor_source.h"

#include <gtest/gtest.h>

#include <complex>
#include <numbers>
#include <random>

#include "sim/steady_state.h"
#include "sim/tuning/adapter_bounds.h"
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

}  // namespace
}  // namespace haptometer::sim
