#include "sim/linear/scene_mode.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "sim/linear/linear_model.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kVolt = 5, kFingerM = 0.4, kFingerMPerS = -0.9;

// z = [x, u] of arbitrary states; the numbers that energies are of, relative to the finger
struct Instant {
  explicit Instant(const Scene& scene) : model(AssembleModel(scene)), z(model.states() + kInputs) {
    const Eigen::Index n = model.states();
    z.head(n) = Eigen::VectorXd::LinSpaced(n, 1.3, -0.7);
    z.tail(kInputs) << kVolt, kFingerM, kFingerMPerS;
    const bool moves = !scene.finger.tones.empty();
    travel = z(LinearModel::kMover) - z(LinearModel::kCase);
    speed = z(LinearModel::kMoverVelocity) - z(LinearModel::kCaseVelocity);
    adapter_m = z(LinearModel::kCase) - z(model.skin());
    adapter_rate = z(LinearModel::kCaseVelocity) - z(model.skin_velocity());
    strain = z(model.skin()) - (moves ? kFingerM : 0);
    strain_rate = z(model.skin_velocity()) - (moves ? kFingerMPerS : 0);
    const double ohm = scene.actuator.resistance_ohm + scene.drive.source_resistance_ohm;
    const double induced_v = scene.actuator.force_constant_n_per_a * speed;
    current = scene.actuator.inductance_h > 0 ? z(n - 1) : (kVolt + induced_v) / ohm;
  }

  // of x, or of [x, u] where the form is so large
  [[nodiscard]] double Of(const Eigen::MatrixXd& form) const {
    const Eigen::VectorXd part = z.head(form.rows());
    return form.size() == 0 ? 0 : part.dot(form * part);
  }
  [[nodiscard]] double CaseSpeed() const { return z(LinearModel::kCaseVelocity); }

  LinearModel model;
  Eigen::VectorXd z;
  double travel = 0, speed = 0, adapter_m = 0, adapter_rate = 0, strain = 0, strain_rate = 0;
  double current = 0;
};

// with and without an adapter, an inductance and a finger that moves; held, and behind a source
std::vector<Scene> SomeScenes() {
  std::vector<Scene> scenes;
  for (Scene scene : {tests::AdapterScene(), tests::DirectScene()}) {
    scene.actuator.force_constant_n_per_a = 0.7;
    scene.grip = {.stiffness_n_per_m = 300, .damping_n_s_per_m = 0.2};
    scene.drive.source_resistance_ohm = 3;
    for (const double inductance_h : {130e-6, 0.0}) {
      scene.actuator.inductance_h = inductance_h;
      scene.finger.tones.clear();
      scenes.push_back(scene);
      scene.finger.tones = {{.amplitude = 1e-5, .frequency_hz = 9}};
      scenes.push_back(scene);
    }
  }
  return scenes;
}

double Half(double factor, double value) { return factor * value * value / 2; }

TEST(SceneMode, StoresTheEnergyOfEachBodyAndSpring) {
  for (const Scene& scene : SomeScenes()) {
    const Instant at(scene);
    const Actuator& motor = scene.actuator;
    double stored_j = Half(motor.inductance_h, at.current) +
                      Half(motor.moving_mass_kg, at.z(LinearModel::kMoverVelocity)) +
                      Half(CaseSideMass(scene), at.CaseSpeed()) +
                      Half(motor.stiffness_n_per_m, at.travel) +
                      Half(scene.skin.stiffness_n_per_m, at.strain) +
                      Half(scene.grip.stiffness_n_per_m, at.z(LinearModel::kCase));
    if (scene.adapter) {
      stored_j += Half(scene.adapter->skin_side_mass_kg, at.z(at.model.skin_velocity())) +
                  Half(scene.adapter->stiffness_n_per_m, at.adapter_m);
    }
    EXPECT_REL(at.Of(SceneMode(scene).stored_j), stored_j, 1e-13, "rounding");
  }
}

TEST(SceneMode, DissipatesInEachElementWhatItsLawSays) {
  for (const Scene& scene : SomeScenes()) {
    const Instant at(scene);
    const Mode mode = SceneMode(scene);
    ASSERT_EQ(mode.dissipating.size(), kSceneElements.size());
    const auto power_w = [&](SceneElement element) {
      return at.Of(mode.dissipating[static_cast<std::size_t>(element)]);
    };
    EXPECT_REL(power_w(SceneElement::kCoil), 2 * Half(27, at.current), 1e-13, "rounding");
    EXPECT_REL(power_w(SceneElement::kSource), 2 * Half(3, at.current), 1e-13, "rounding");
    EXPECT_REL(power_w(SceneElement::kMover), 2 * Half(0.0322, at.speed), 1e-13, "rounding");
    EXPECT_REL(power_w(SceneElement::kGrip), 2 * Half(0.2, at.CaseSpeed()), 1e-13, "rounding");
    EXPECT_REL(power_w(SceneElement::kSkin), 2 * Half(scene.skin.damping_n_s_per_m, at.strain_rate),
               1e-13, "rounding");
    const double adapter_w = scene.adapter ? 2 * Half(0.01, at.adapter_rate) : 0;
    EXPECT_ABS(power_w(SceneElement::kAdapter), adapter_w, 1e-14, "rounding");
    EXPECT_EQ(power_w(SceneElement::kStop), 0);
  }
}

TEST(SceneMode, FeelsTheFingerThroughTheSkin) {
  for (const Scene& scene : SomeScenes()) {
    const Instant at(scene);
    const Mode mode = SceneMode(scene);
    if (scene.finger.tones.empty()) {
      EXPECT_EQ(mode.finger.size(), 0);
      EXPECT_EQ(mode.finger_force_row.size(), 0);
      continue;
    }
    const double Ks = scene.skin.stiffness_n_per_m, Bs = scene.skin.damping_n_s_per_m;
    EXPECT_REL(mode.finger_force_row.dot(at.z), Ks * at.strain + Bs * at.strain_rate, 1e-13,
               "rounding");
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(at.model.states(), 2);
    expected.row(at.model.skin_velocity()) << Ks, Bs;
    expected /= scene.adapter ? 4.35e-3 : 0.6e-3;
    EXPECT_ABS((mode.finger - expected).cwiseAbs().maxCoeff(), 0, 1e-9, "rounding of 3e6 1/s2");
  }
}

TEST(SceneMode, KnowsWhatMovesWithCaseAndSkin) {
  Scene scene = tests::AdapterScene();
  EXPECT_REL(CaseSideMass(scene), 0.6e-3 + 0.25e-3, 1e-15, "rounding");
  EXPECT_EQ(ContactMass(scene), 4.35e-3);
  scene.adapter.reset();
  EXPECT_EQ(CaseSideMass(scene), 0.6e-3);
  EXPECT_EQ(ContactMass(scene), 0.6e-3);
  scene.grip.holds = true;
  EXPECT_EQ(CaseSideMass(scene), HUGE_VAL);
  EXPECT_EQ(SceneMode(scene).stored_j.allFinite(), true) << "a case that is held has no energy";
}

// one more state, which is 1 and which nothing moves: all numbers are those of before
TEST(WithConstant, LeavesEveryNumberAsItIs) {
  for (const Scene& scene : SomeScenes()) {
    const Instant at(scene);
    const Eigen::Index n = at.model.states();
    Mode mode = SceneMode(scene);
    mode.guards = {{.row = Eigen::RowVectorXd::LinSpaced(n, 1, 2), .offset = 3}};
    const Mode grown = WithConstant(mode);
    Eigen::VectorXd z(n + 1 + kInputs);
    z << at.z.head(n), 1, at.z.tail(kInputs);
    const Eigen::VectorXd x = z.head(n + 1);
    const auto of = [&](const Eigen::MatrixXd& form) {
      return form.size() == 0 ? 0 : z.head(form.rows()).dot(form * z.head(form.rows()));
    };
    const Eigen::VectorXd before = at.z.head(n), rate = mode.a * before, grown_rate = grown.a * x;
    EXPECT_ABS((grown_rate.head(n) - rate).norm() / rate.norm(), 0, 1e-14, "order of the sums");
    EXPECT_EQ(grown_rate(n), 0);
    EXPECT_EQ(grown.Inputs().topRows(n), mode.Inputs());
    EXPECT_EQ(grown.Inputs().row(n).cwiseAbs().sum(), 0);
    EXPECT_EQ(grown.positions * x, before);
    EXPECT_REL(of(grown.stored_j), at.Of(mode.stored_j), 1e-14, "rounding");
    for (std::size_t k = 0; k < mode.dissipating.size(); ++k) {
      EXPECT_ABS(of(grown.dissipating[k]), at.Of(mode.dissipating[k]), 1e-13, "rounding");
    }
    EXPECT_ABS(grown.current_row.dot(x), mode.current_row.dot(before), 1e-14, "order of the sums");
    EXPECT_ABS(grown.guards[0].row.dot(x), mode.guards[0].row.dot(before), 1e-14, "the same");
    if (mode.finger_force_row.size() == 0) continue;
    EXPECT_REL(grown.finger_force_row.dot(z), mode.finger_force_row.dot(at.z), 1e-14, "rounding");
  }
}

}  // namespace
}  // namespace haptometer::sim
