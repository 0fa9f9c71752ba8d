#include "sim/scene_mode.h"

#include "sim/linear_model.h"

namespace haptometer::sim {

namespace {

using Row = Eigen::RowVectorXd;

Row Unit(Eigen::Index n, Eigen::Index place) { return Row::Unit(n, place); }

// factor (row x)^2
Eigen::MatrixXd Square(double factor, const Row& row) { return factor * row.transpose() * row; }

void AddStored(const Scene& scene, const LinearModel& model, Mode& mode) {
  const Eigen::Index n = model.states();
  const Row mover = Unit(n, LinearModel::kMover), motor = Unit(n, LinearModel::kCase);
  const Row skin = Unit(n, model.skin());
  const Actuator& motor_data = scene.actuator;
  mode.stored_j = Square(motor_data.inductance_h / 2, Unit(n, LinearModel::kCurrent)) +
                  Square(motor_data.moving_mass_kg / 2, Unit(n, LinearModel::kMoverVelocity)) +
                  Square(CaseSideMass(scene) / 2, Unit(n, LinearModel::kCaseVelocity)) +
                  Square(motor_data.stiffness_n_per_m / 2, mover - motor) +
                  Square(scene.skin.stiffness_n_per_m / 2, skin);
  if (!scene.adapter) return;
  mode.stored_j += Square(scene.adapter->skin_side_mass_kg / 2, Unit(n, model.skin_velocity())) +
                   Square(scene.adapter->stiffness_n_per_m / 2, motor - skin);
}

void AddDissipating(const Scene& scene, const LinearModel& model, Mode& mode) {
  const Eigen::Index n = model.states();
  const Row motor = Unit(n, LinearModel::kCaseVelocity);
  const Row skin = Unit(n, model.skin_velocity());
  const auto place = [&](SceneElement element) -> Eigen::MatrixXd& {
    return mode.dissipating[static_cast<std::size_t>(element)];
  };
  mode.dissipating.resize(kSceneElements.size());
  place(SceneElement::kCoil) =
      Square(scene.actuator.resistance_ohm, Unit(n, LinearModel::kCurrent));
  place(SceneElement::kMover) =
      Square(scene.actuator.damping_n_s_per_m, Unit(n, LinearModel::kMoverVelocity) - motor);
  place(SceneElement::kSkin) = Square(scene.skin.damping_n_s_per_m, skin);
  if (!scene.adapter) return;
  place(SceneElement::kAdapter) = Square(scene.adapter->damping_n_s_per_m, motor - skin);
}

// with a row and a column of zeros
Eigen::MatrixXd Grown(const Eigen::MatrixXd& matrix) {
  Eigen::MatrixXd grown = Eigen::MatrixXd::Zero(matrix.rows() + 1, matrix.cols() + 1);
  grown.topLeftCorner(matrix.rows(), matrix.cols()) = matrix;
  return grown;
}

}  // namespace

double CaseSideMass(const Scene& scene) {
  return scene.actuator.case_mass_kg + (scene.adapter ? scene.adapter->motor_side_mass_kg : 0);
}

Mode SceneMode(const Scene& scene) {
  const LinearModel model = AssembleModel(scene);
  Mode mode{.name = "linear",
            .a = model.a,
            .b = model.b,
            .positions = {},
            .stored_j = {},
            .current_row = Unit(model.states(), LinearModel::kCurrent)};
  AddStored(scene, model, mode);
  AddDissipating(scene, model, mode);
  return mode;
}

Mode WithConstant(const Mode& mode) {
  const Eigen::Index n = mode.a.rows();
  Mode grown = mode;
  grown.a = Grown(mode.a);
  grown.b.conservativeResize(n + 1);
  grown.b(n) = 0;
  grown.stored_j = Grown(mode.stored_j);
  grown.current_row.conservativeResize(n + 1);
  grown.current_row(n) = 0;
  for (Eigen::MatrixXd& power : grown.dissipating) {
    if (power.size() > 0) power = Grown(power);
  }
  for (Guard& guard : grown.guards) {
    guard.row.conservativeResize(n + 1);
    guard.row(n) = 0;
  }
  grown.positions = mode.positions.size() > 0 ? mode.positions : Eigen::MatrixXd::Identity(n, n);
  grown.positions.conservativeResize(Eigen::NoChange, n + 1);
  grown.positions.col(n).setZero();
  return grown;
}

}  // namespace haptometer::sim
