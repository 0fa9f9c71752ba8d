#include "sim/linear_model.h"

#include "base/check.h"

namespace haptometer::sim {

namespace {

void CheckActuator(const Actuator& actuator) {
  HAPTOMETER_CHECK(actuator.moving_mass_kg > 0 && actuator.case_mass_kg > 0, "masses {}, {} kg",
                   actuator.moving_mass_kg, actuator.case_mass_kg);
  HAPTOMETER_CHECK(actuator.resistance_ohm > 0 && actuator.inductance_h > 0, "{} ohm, {} H",
                   actuator.resistance_ohm, actuator.inductance_h);
}

// the coil and the moving mass, which all scenes share (rows 1-3 of matrix 2.5)
void FillMotor(const Actuator& actuator, Eigen::MatrixXd& a) {
  const double Mv = actuator.moving_mass_kg, Kv = actuator.stiffness_n_per_m;
  const double Bv = actuator.damping_n_s_per_m, Km = actuator.force_constant_n_per_a;
  const double R = actuator.resistance_ohm, L = actuator.inductance_h;
  a.row(0).head(5) << -R / L, 0, Km / L, 0, -Km / L;
  a(1, 2) = 1;
  a.row(2).head(5) << -Km / Mv, -Kv / Mv, -Bv / Mv, Kv / Mv, Bv / Mv;
  a(3, 4) = 1;
}

// what the motor does to the case of mass Mc1 (row 5 of matrix 2.5, without the adapter's part)
void FillReaction(const Actuator& actuator, double Mc1, Eigen::MatrixXd& a) {
  const double Kv = actuator.stiffness_n_per_m, Bv = actuator.damping_n_s_per_m;
  const double Km = actuator.force_constant_n_per_a;
  a.row(4).head(5) << Km / Mc1, Kv / Mc1, Bv / Mc1, -Kv / Mc1, -Bv / Mc1;
}

}  // namespace

LinearModel AssembleModel(const Actuator& actuator, const std::optional<Adapter>& adapter,
                          const Skin& skin) {
  CheckActuator(actuator);
  const Eigen::Index n = adapter ? 7 : 5;
  LinearModel model{.a = Eigen::MatrixXd::Zero(n, n), .b = Eigen::VectorXd::Zero(n)};
  model.b(0) = 1 / actuator.inductance_h;
  FillMotor(actuator, model.a);
  const double Ks = skin.stiffness_n_per_m, Bs = skin.damping_n_s_per_m;

  // the case itself on the skin
  if (!adapter) {
    const double Mc = actuator.case_mass_kg;
    FillReaction(actuator, Mc, model.a);
    model.a(4, 3) -= Ks / Mc;
    model.a(4, 4) -= Bs / Mc;
    return model;
  }

  // the adapter between case and skin
  const double Ma2 = adapter->skin_side_mass_kg;
  const double Ka = adapter->stiffness_n_per_m, Ba = adapter->damping_n_s_per_m;
  const double Mc1 = actuator.case_mass_kg + adapter->motor_side_mass_kg;
  HAPTOMETER_CHECK(Ma2 > 0 && Mc1 > 0, "skin side {} kg, case side {} kg", Ma2, Mc1);
  FillReaction(actuator, Mc1, model.a);
  model.a(4, 3) -= Ka / Mc1;
  model.a(4, 4) -= Ba / Mc1;
  model.a(4, 5) = Ka / Mc1;
  model.a(4, 6) = Ba / Mc1;
  model.a(5, 6) = 1;
  model.a.row(6).tail(4) << Ka / Ma2, Ba / Ma2, -(Ka + Ks) / Ma2, -(Ba + Bs) / Ma2;
  return model;
}

LinearModel AssembleModel(const Scene& scene) {
  return AssembleModel(scene.actuator, scene.adapter, scene.skin);
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
