#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tools/compare/compare.h"

// u(simulated) and the scores at a resonance, where no quantity is linear in the inputs.

namespace haptometer::tools {
namespace {

// a mover on its spring, f0 = 225.08 Hz, of a quality factor of 60: sqrt(Kv Mv) / (Bv + Km^2 / R)
constexpr const char* kResonance =
    "[actuator]\nmoving_mass_kg = 1.4e-3\ncase_mass_kg = 0.6e-3\nstiffness_n_per_m = 2800\n"
    "damping_n_s_per_m = 0.0315\nforce_constant_n_per_a = 0.2\nresistance_ohm = 27\n"
    "inductance_h = 130e-6\n[skin]\nstiffness_n_per_m = 1e9\ndamping_n_s_per_m = 0.75\n"
    "[drive]\nkind = \"sine\"\namplitude_v = 0.5\nfrequency_hz = 225.08\n"
    "[sensor]\nkind = \"ideal\"\ntarget = \"mover\"\n";

ComparedScene ResonanceWith(const std::string& path, const std::string& input) {
  auto inputs = ReadInputs({input});
  auto scene = ComparedScene::Read(path, inputs.value());
  EXPECT_TRUE(scene.has_value()) << scene.error().Text();
  return *std::move(scene);
}

class CompareResonance : public tests::TemporaryFiles {};

// u(simulated) against the root mean square change of draws
TEST_F(CompareResonance, HoldsTheSpreadOfANarrowAndAWideInput) {
  constexpr int kDraws = 4000;
  const std::string path = File("resonance.toml", kResonance);
  for (const char* word : {"drive.frequency_hz=225.08+-0.3", "drive.frequency_hz=225.08+-3",
                           "drive.frequency_hz=225.08+-30", "drive.frequency_hz=215:235",
                           "drive.frequency_hz=223+-2", "actuator.stiffness_n_per_m=2800+-100"}) {
    const ComparedScene scene = ResonanceWith(path, word);
    MeasuredNumbers measured{.upper_hz = 500};
    measured.numbers[0] = {50e-6, 0.1e-6};
    const Propagation propagation = Propagate(scene, measured).value();
    const double u_m = std::sqrt(propagation.spread(0, 0));
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(-std::numbers::sqrt3, std::numbers::sqrt3);
    double squares = 0, fourths = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const double z = scene.inputs()[0].is_range ? uniform(random) : normal(random);
      const auto at = SimulatedOf(scene.At(Eigen::VectorXd::Constant(1, z)).value(), path, false);
      const double square = std::pow((*at)[0].value - propagation.at[0].value, 2);
      squares += square / kDraws, fourths += square * square / kDraws;
    }
    const double drawn_m = std::sqrt(squares);
    std::printf("%-40s %.3g um; by a tangent %.3g um, by draws %.3g um\n", word, u_m * 1e6,
                std::abs(propagation.changes(0, 0)) * 1e6, drawn_m * 1e6);
    // four standard deviations of the draws' mean square, and 2 % for steps of a fifth of u
    const double share = 2 * std::sqrt((fourths - squares * squares) / kDraws) / squares;
    EXPECT_REL(u_m, drawn_m, share + 0.02, "draws and the step of the rule") << word;
  }
}

// what an input within its uncertainty explains is no difference
TEST_F(CompareResonance, AFrequencyWithinItsUncertaintyIsNoDifference) {
  const std::string path = File("resonance.toml", kResonance);
  const ComparedScene scene = ResonanceWith(path, "drive.frequency_hz=225.08+-3");
  MeasuredNumbers measured{.upper_hz = 500};
  for (const double z : {-2., -1., 1., 2.}) {
    const auto truth = SimulatedOf(scene.At(Eigen::VectorXd::Constant(1, z)).value(), path, false);
    measured.numbers[0] = {(*truth)[0].value, 0.1e-6};
    const auto propagation = Propagate(scene, measured);
    const auto result = Compare(measured.numbers, scene, propagation.value());
    EXPECT_LT(std::abs(result.quantities[0].NormalizedError()), 1) << z;
    EXPECT_FALSE(result.DiffersTogether()) << z;
  }
  // none makes it larger than at the resonance
  measured.numbers[0]->value = 3 * Propagate(scene, measured)->at[0].value;
  const auto propagation = Propagate(scene, measured);
  EXPECT_TRUE(Compare(measured.numbers, scene, propagation.value()).Differs());
}

// an actuator's damping of 0.03 +- 0.02 is below 0 in a part of its distribution
TEST_F(CompareResonance, LeavesOutValuesThatTheSceneDoesNotTake) {
  const std::string path = File("resonance.toml", kResonance);
  const ComparedScene scene = ResonanceWith(path, "actuator.damping_n_s_per_m=0.0315+-0.02");
  MeasuredNumbers measured{.upper_hz = 500};
  measured.numbers[0] = {50e-6, 0.1e-6};
  const Propagation propagation = Propagate(scene, measured).value();
  EXPECT_TRUE(std::isfinite(propagation.spread(0, 0)));
  EXPECT_GT(propagation.spread(0, 0), std::pow(propagation.changes(0, 0), 2) / 4);
}

}  // namespace
}  // namespace haptometer::tools
