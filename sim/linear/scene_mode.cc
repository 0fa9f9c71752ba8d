#include "sim/linear/scene_mode.h"

#include <limits>

#include "sim/linear/linear_model.h"

namespace haptometer::sim {
namespace {

using Row = Eigen::RowVectorXd;

Row Unit(Eigen::Index n, Eigen::Index place) { return Row::Unit(n, place); }

// factor (row x)^2
Eigen::MatrixXd Square(double factor, const Row& row) { return factor * row.transpose() * row; }

// whether forms are of [x, u] rather than of x
Eigen::Index InputsOf(const Scene& scene) { return scene.finger.tones.empty() ? 0 : kInputs; }

// a state relative to the finger under the skin
Row FromFinger(const Scene& scene, const LinearModel& model, Eigen::Index place,
               Eigen::Index input) {
  const Eigen::Index n = model.states();
  Row row = Unit(n + InputsOf(scene), place);
  if (InputsOf(scene) > 0) row(n + input) = -1;
  return row;
}

void AddStored(const Scene& scene, const LinearModel& model, Mode& mode) {
  const Eigen::Index n = model.states(), m = n + InputsOf(scene);
  const Row mover = Unit(m, LinearModel::kMover), motor = Unit(m, LinearModel::kCase);
  const Row skin = Unit(m, model.skin());
  const Actuator& motor_data = scene.actuator;
  Row current = Row::Zero(m);
  current.head(n) = model.current_row;
  // energies of L i^2 / 2, m v^2 / 2 and K d^2 / 2; without inductance the coil stores nothing
  mode.stored_j =
      Square(motor_data.inductance_h / 2, current) +
      Square(motor_data.moving_mass_kg / 2, Unit(m, LinearModel::kMoverVelocity)) +
      // a case that is held has none
      Square(scene.grip.holds ? 0 : CaseSideMass(scene) / 2, Unit(m, LinearModel::kCaseVelocity)) +
      Square(motor_data.stiffness_n_per_m / 2, mover - motor) +
      Square(scene.skin.stiffness_n_per_m / 2, FromFinger(scene, model, model.skin(), kFinger)) +
      Square(scene.grip.stiffness_n_per_m / 2, motor);
  if (!scene.adapter) return;
  mode.stored_j += Square(scene.adapter->skin_side_mass_kg / 2, Unit(m, model.skin_velocity())) +
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
  Row current = model.current_row;
  // without inductance the current follows the voltage at once
  if (model.current_per_volt != 0) {
    current.conservativeResize(n + kInputs);
    current.tail(kInputs) = model.current_per_volt * Row::Unit(kInputs, kVoltage);
  }
  // powers R i^2 and B v^2, W
  place(SceneElement::kCoil) = Square(scene.actuator.resistance_ohm, current);
  place(SceneElement::kMover) =
      Square(scene.actuator.damping_n_s_per_m, Unit(n, LinearModel::kMoverVelocity) - motor);
  place(SceneElement::kSkin) = Square(scene.skin.damping_n_s_per_m,
                                      FromFinger(scene, model, model.skin_velocity(), kFingerRate));
  if (scene.drive.source_resistance_ohm > 0) {
    place(SceneElement::kSource) = Square(scene.drive.source_resistance_ohm, current);
  }
  if (scene.grip.damping_n_s_per_m > 0) {
    place(SceneElement::kGrip) = Square(scene.grip.damping_n_s_per_m, motor);
  }
  if (!scene.adapter) return;
  place(SceneElement::kAdapter) = Square(scene.adapter->damping_n_s_per_m, motor - skin);
}

// the acceleration by the finger's motion, and the skin's force on it
void AddFinger(const Scene& scene, const LinearModel& model, Mode& mode) {
  if (InputsOf(scene) == 0) return;
  const double Ks = scene.skin.stiffness_n_per_m, Bs = scene.skin.damping_n_s_per_m;
  mode.finger = Eigen::MatrixXd::Zero(model.states(), 2);
  mode.finger.row(model.skin_velocity()) << Ks / ContactMass(scene), Bs / ContactMass(scene);
  mode.finger_force_row = Ks * FromFinger(scene, model, model.skin(), kFinger) +
                          Bs * FromFinger(scene, model, model.skin_velocity(), kFingerRate);
}

// `from`, and the inputs where they were
Eigen::MatrixXd WithInputs(const Eigen::MatrixXd& from, Eigen::Index size) {
  const Eigen::Index inputs = size - from.rows();
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(size, from.cols() + inputs);
  whole.topLeftCorner(from.rows(), from.cols()) = from;
  whole.bottomRightCorner(inputs, inputs).setIdentity();
  return whole;
}

}  // namespace

double CaseSideMass(const Scene& scene) {
  if (scene.grip.holds) return std::numeric_limits<double>::infinity();
  return scene.actuator.case_mass_kg + (scene.adapter ? scene.adapter->motor_side_mass_kg : 0);
}

double ContactMass(const Scene& scene) {
  return scene.adapter ? scene.adapter->skin_side_mass_kg : CaseSideMass(scene);
}

Mode SceneMode(const Scene& scene) {
  const LinearModel model = AssembleModel(scene);
  Mode mode{.name = "linear",
            .a = model.a,
            .b = model.b,
            .positions = {},
            .stored_j = {},
            .current_row = model.current_row,
            .current_per_volt = model.current_per_volt,
            .a_rest = model.a_rest,
            .b_rest = model.b_rest};
  AddStored(scene, model, mode);
  AddDissipating(scene, model, mode);
  AddFinger(scene, model, mode);
  return mode;
}

Mode WithConstant(const Mode& mode) {
  const Eigen::Index n = mode.a.rows();
  // nothing acts on the constant state: zeros
  const Eigen::MatrixXd without = Eigen::MatrixXd::Identity(n, n + 1);
  Mode grown = mode;
  grown.a = without.transpose() * mode.a * without;
  grown.b = without.transpose() * mode.b;
  if (mode.a_rest.size() > 0) {
    grown.a_rest = without.transpose() * mode.a_rest * without;
    grown.b_rest = without.transpose() * mode.b_rest;
  }
  if (mode.finger.size() > 0) grown.finger = without.transpose() * mode.finger;
  grown.finger_force_row = RowIn(mode.finger_force_row, without);
  grown.stored_j = FormIn(mode.stored_j, without);
  grown.current_row = mode.current_row * without;
  for (Eigen::MatrixXd& power : grown.dissipating) power = FormIn(power, without);
  for (Guard& guard : grown.guards) guard.row = (guard.row * without).eval();
  grown.positions = mode.positions.size() > 0 ? (mode.positions * without).eval() : without;
  return grown;
}

Eigen::MatrixXd FormIn(const Eigen::MatrixXd& form, const Eigen::MatrixXd& from) {
  if (form.size() == 0) return form;
  const Eigen::MatrixXd whole = WithInputs(from, form.rows());
  return whole.transpose() * form * whole;
}

Eigen::RowVectorXd RowIn(const Eigen::RowVectorXd& row, const Eigen::MatrixXd& from) {
  if (row.size() == 0) return row;
  return row * WithInputs(from, row.size());
}

}  // namespace haptometer::sim
