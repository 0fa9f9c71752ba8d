#include "sim/linear_model.h"

#include "base/check.h"

namespace haptometer::sim {

namespace {

void CheckActuator(const Actuator& actuator) {
  HAPTOMETER_CHECK(actuator.moving_mass_kg > 0 && actuator.case_mass_kg > 0, "masses {}, {} kg",
                   actuator.moving_mass_kg, actuator.case_mass_kg);
  HAPTOMETER_CHECK(actuator.resistance_ohm > 0 && actuator.inductance_h >= 0, "{} ohm, {} H",
                   actuator.resistance_ohm, actuator.inductance_h);
}

// the moving mass and its spring, which all scenes share, and what they do to the case of mass Mc1
// (rows 2, 3 and 5 of matrix 2.5, without the coil's and the adapter's part)
void FillMotor(const Actuator& actuator, double Mc1, Eigen::MatrixXd& a) {
  const double Mv = actuator.moving_mass_kg, Kv = actuator.stiffness_n_per_m;
  const double Bv = actuator.damping_n_s_per_m;
  a(0, 1) = 1;
  a.row(1).head(4) << -Kv / Mv, -Bv / Mv, Kv / Mv, Bv / Mv;
  a(2, 3) = 1;
  a.row(3).head(4) << Kv / Mc1, Bv / Mc1, -Kv / Mc1, -Bv / Mc1;
}

// the coil (row 1 of matrix 2.5) and its forces
void FillCoil(const Actuator& actuator, double Mc1, LinearModel& model) {
  const double Mv = actuator.moving_mass_kg, Km = actuator.force_constant_n_per_a;
  const double R = actuator.resistance_ohm, L = actuator.inductance_h;
  const Eigen::Index n = model.states();
  Eigen::VectorXd force_per_ampere = Eigen::VectorXd::Zero(n);
  force_per_ampere(LinearModel::kMoverVelocity) = -Km / Mv;
  force_per_ampere(LinearModel::kCaseVelocity) = Km / Mc1;
  if (L > 0) {
    const Eigen::Index i = n - 1;
    model.a.row(i).head(4) << 0, Km / L, 0, -Km / L;
    model.a(i, i) = -R / L;
    model.a.col(i) += force_per_ampere;
    model.b(i) = 1 / L;
    model.current_row(i) = 1;
    return;
  }
  model.current_row.head(4) << 0, Km / R, 0, -Km / R;
  model.current_per_volt = 1 / R;
  model.a += force_per_ampere * model.current_row;
  model.b = force_per_ampere / R;
}

}  // namespace

LinearModel AssembleModel(const Actuator& actuator, const std::optional<Adapter>& adapter,
                          const Skin& skin) {
  return AssembleModel(actuator, adapter, skin, Grip{});
}

LinearModel AssembleModel(const Actuator& actuator, const std::optional<Adapter>& adapter,
                          const Skin& skin, const Grip& grip) {
  CheckActuator(actuator);
  const Eigen::Index n = (adapter ? 6 : 4) + (actuator.inductance_h > 0 ? 1 : 0);
  LinearModel model{.a = Eigen::MatrixXd::Zero(n, n),
                    .b = Eigen::VectorXd::Zero(n),
                    .current_row = Eigen::RowVectorXd::Zero(n)};
  const double Mc1 = actuator.case_mass_kg + (adapter ? adapter->motor_side_mass_kg : 0);
  const double Ks = skin.stiffness_n_per_m, Bs = skin.damping_n_s_per_m;
  FillMotor(actuator, Mc1, model.a);
  model.a(3, 2) -= grip.stiffness_n_per_m / Mc1;
  model.a(3, 3) -= grip.damping_n_s_per_m / Mc1;

  if (!adapter) {
    // the case itself on the skin
    model.a(3, 2) -= Ks / Mc1;
    model.a(3, 3) -= Bs / Mc1;
  } else {
    // the adapter between case and skin
    const double Ma2 = adapter->skin_side_mass_kg;
    const double Ka = adapter->stiffness_n_per_m, Ba = adapter->damping_n_s_per_m;
    HAPTOMETER_CHECK(Ma2 > 0 && Mc1 > 0, "skin side {} kg, case side {} kg", Ma2, Mc1);
    model.a(3, 2) -= Ka / Mc1;
    model.a(3, 3) -= Ba / Mc1;
    model.a(3, 4) = Ka / Mc1;
    model.a(3, 5) = Ba / Mc1;
    model.a(4, 5) = 1;
    model.a.row(5).segment(2, 4) << Ka / Ma2, Ba / Ma2, -(Ka + Ks) / Ma2, -(Ba + Bs) / Ma2;
  }
  FillCoil(actuator, Mc1, model);
  return model;
}

LinearModel AssembleModel(const Scene& scene) {
  Actuator actuator = scene.actuator;
  actuator.resistance_ohm += scene.drive.source_resistance_ohm;
  return AssembleModel(actuator, scene.adapter, scene.skin, scene.grip);
}

Eigen::Index StateOf(const LinearModel& model, SensorTarget target) {
  switch (target) {
    case SensorTarget::kSkin:
      return model.skin();
    case SensorTarget::kCase:
      return LinearModel::kCase;
    case SensorTarget::kMover:
      return LinearModel::kMover;
  }
  return model.skin();
}

}  // namespace haptometer::sim
