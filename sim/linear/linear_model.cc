#include "sim/linear/linear_model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/circular_functions.h"
#include "base/error.h"
#include "sim/linear/driven_step.h"

namespace haptometer::sim {
namespace {

void CheckActuator(const Actuator& actuator) {
  HAPTOMETER_CHECK(actuator.moving_mass_kg > 0 && actuator.case_mass_kg > 0, "masses {}, {} kg",
                   actuator.moving_mass_kg, actuator.case_mass_kg);
  HAPTOMETER_CHECK(actuator.resistance_ohm > 0 && actuator.inductance_h >= 0, "{} ohm, {} H",
                   actuator.resistance_ohm, actuator.inductance_h);
}

// a, b and current_row of LinearModel, in arithmetic of either length
template <typename Scalar>
struct Rows {
  explicit Rows(Eigen::Index states)
      : a(Matrix::Zero(states, states)),
        b(Vector::Zero(states)),
        current(RowVector::Zero(states)) {}
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using RowVector = Eigen::Matrix<Scalar, 1, Eigen::Dynamic>;
  Matrix a;
  Vector b;
  RowVector current;
};

struct Bodies {
  const Actuator& actuator;
  const std::optional<Adapter>& adapter;
  const Skin& skin;
  const Grip& grip;
  // position and speed of two bodies or three, and the current where it is a state
  [[nodiscard]] Eigen::Index states() const {
    return (adapter ? 6 : 4) + (actuator.inductance_h > 0 ? 1 : 0);
  }
};

template <typename Scalar>
Scalar As(double value) {
  return static_cast<Scalar>(value);
}

// Mc1 = Mc + Ma1, kg; infinite for a case that is held
template <typename Scalar>
Scalar CaseSide(const Bodies& bodies) {
  if (bodies.grip.holds) return std::numeric_limits<Scalar>::infinity();
  return As<Scalar>(bodies.actuator.case_mass_kg) +
         As<Scalar>(bodies.adapter ? bodies.adapter->motor_side_mass_kg : 0);
}

// the moving mass and its spring, which all scenes share, and what they do to the case of mass Mc1
// (rows 2, 3 and 5 of matrix 2.5, without the coil's and the adapter's part)
template <typename Scalar>
void FillMotor(const Actuator& actuator, Scalar Mc1, Rows<Scalar>& rows) {
  const auto Mv = As<Scalar>(actuator.moving_mass_kg), Kv = As<Scalar>(actuator.stiffness_n_per_m);
  const auto Bv = As<Scalar>(actuator.damping_n_s_per_m);
  rows.a(0, 1) = 1;
  // Mv vv' = -Kv (xv - xa) - Bv (vv - va), and the reaction on the case
  rows.a.row(1).head(4) << -Kv / Mv, -Bv / Mv, Kv / Mv, Bv / Mv;
  rows.a(2, 3) = 1;
  rows.a.row(3).head(4) << Kv / Mc1, Bv / Mc1, -Kv / Mc1, -Bv / Mc1;
}

// 1/s, of a case that is held: it decays sooner than movers do, and does not depend on the spring,
// whose place sim/smooth/smooth_system.cc reads off two stiffnesses
constexpr double kHeldPace = 2000;

// what holds the case: the grip, and the skin itself or the adapter between
template <typename Scalar>
void FillMounting(const Bodies& bodies, Scalar Mc1, Rows<Scalar>& rows) {
  const auto Ks = As<Scalar>(bodies.skin.stiffness_n_per_m),
             Bs = As<Scalar>(bodies.skin.damping_n_s_per_m);
  if (bodies.grip.holds) {
    // the case stays at 0 for any value here, which keeps the matrix regular
    rows.a(2, 2) = rows.a(3, 3) = As<Scalar>(-kHeldPace);
    return;
  }
  // a grip acts between the case and the ground
  rows.a(3, 2) -= As<Scalar>(bodies.grip.stiffness_n_per_m) / Mc1;
  rows.a(3, 3) -= As<Scalar>(bodies.grip.damping_n_s_per_m) / Mc1;
  // without an adapter the case itself is on the skin
  if (!bodies.adapter) {
    rows.a(3, 2) -= Ks / Mc1;
    rows.a(3, 3) -= Bs / Mc1;
    return;
  }
  const auto Ma2 = As<Scalar>(bodies.adapter->skin_side_mass_kg);
  const auto Ka = As<Scalar>(bodies.adapter->stiffness_n_per_m),
             Ba = As<Scalar>(bodies.adapter->damping_n_s_per_m);
  // Ka and Ba between case and skin contact; Ks and Bs between contact and ground
  rows.a(3, 2) -= Ka / Mc1;
  rows.a(3, 3) -= Ba / Mc1;
  rows.a(3, 4) = Ka / Mc1;
  rows.a(3, 5) = Ba / Mc1;
  rows.a(4, 5) = 1;
  rows.a.row(5).segment(2, 4) << Ka / Ma2, Ba / Ma2, -(Ka + Ks) / Ma2, -(Ba + Bs) / Ma2;
}

// the coil (row 1 of matrix 2.5) and its forces
template <typename Scalar>
void FillCoil(const Actuator& actuator, Scalar Mc1, Rows<Scalar>& rows) {
  const auto Mv = As<Scalar>(actuator.moving_mass_kg),
             Km = As<Scalar>(actuator.force_constant_n_per_a);
  const auto R = As<Scalar>(actuator.resistance_ohm), L = As<Scalar>(actuator.inductance_h);
  const Eigen::Index n = rows.a.rows();
  typename Rows<Scalar>::Vector force_per_ampere = Rows<Scalar>::Vector::Zero(n);
  // -Km i on the mover, +Km i on the case; matrix 2.5 has the reaction, equation 2.3 lacks it
  force_per_ampere(LinearModel::kMoverVelocity) = -Km / Mv;
  force_per_ampere(LinearModel::kCaseVelocity) = Km / Mc1;
  if (L > 0) {
    const Eigen::Index i = n - 1;
    // L i' = v - R i - Km (va - vv)
    rows.a.row(i).head(4) << 0, Km / L, 0, -Km / L;
    rows.a(i, i) = -R / L;
    rows.a.col(i) += force_per_ampere;
    rows.b(i) = 1 / L;
    rows.current(i) = 1;
    return;
  }
  // without L the current follows at once: i = (v + Km (vv - va)) / R
  rows.current.head(4) << 0, Km / R, 0, -Km / R;
  rows.a += force_per_ampere * rows.current;
  rows.b = force_per_ampere / R;
}

template <typename Scalar>
Rows<Scalar> RowsOf(const Bodies& bodies) {
  Rows<Scalar> rows(bodies.states());
  const auto Mc1 = CaseSide<Scalar>(bodies);
  FillMotor(bodies.actuator, Mc1, rows);
  FillMounting(bodies, Mc1, rows);
  FillCoil(bodies.actuator, Mc1, rows);
  return rows;
}

// rows of [x, v] whose squares sum to the power in W: sqrt(R) i, sqrt(B) times a damper's speed
Eigen::MatrixXd PowerRows(const Bodies& bodies, const LinearModel& model) {
  const Eigen::Index n = model.states();
  const auto unit = [&](Eigen::Index place) { return Eigen::RowVectorXd::Unit(n + 1, place); };
  const Eigen::RowVectorXd motor = unit(LinearModel::kCaseVelocity);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(5, n + 1);
  rows.row(0) << model.current_row, model.current_per_volt;
  rows.row(0) *= std::sqrt(bodies.actuator.resistance_ohm);
  rows.row(1) =
      std::sqrt(bodies.actuator.damping_n_s_per_m) * (unit(LinearModel::kMoverVelocity) - motor);
  rows.row(2) = std::sqrt(bodies.grip.damping_n_s_per_m) * motor;
  rows.row(3) = std::sqrt(bodies.skin.damping_n_s_per_m) * unit(model.skin_velocity());
  if (bodies.adapter) {
    rows.row(4) =
        std::sqrt(bodies.adapter->damping_n_s_per_m) * (motor - unit(model.skin_velocity()));
  }
  return rows;
}

// whether the spring is so stiff that mover and case move as one: w^2 = Kv (1/Mv + 1/Mc1)
bool AllButOneBody(const Bodies& bodies) {
  const double inverse_mass = 1 / bodies.actuator.moving_mass_kg + 1 / CaseSide<double>(bodies);
  const double square = bodies.actuator.stiffness_n_per_m * inverse_mass;
  return square > LinearModel::kStiffMoverRadPerS * LinearModel::kStiffMoverRadPerS;
}

// rounding errors of A and b: the same sums in long double less the double ones
void AddRest(const Bodies& bodies, LinearModel& model) {
  const auto rows = RowsOf<long double>(bodies);
  model.a_rest = (rows.a - model.a.cast<long double>()).cast<double>();
  model.b_rest = (rows.b - model.b.cast<long double>()).cast<double>();
}

}  // namespace

LinearModel AssembleModel(const Actuator& actuator, const std::optional<Adapter>& adapter,
                          const Skin& skin) {
  return AssembleModel(actuator, adapter, skin, Grip{});
}

LinearModel AssembleModel(const Actuator& actuator, const std::optional<Adapter>& adapter,
                          const Skin& skin, const Grip& grip) {
  CheckActuator(actuator);
  const Bodies bodies{.actuator = actuator, .adapter = adapter, .skin = skin, .grip = grip};
  HAPTOMETER_CHECK(!(adapter && grip.holds), "an adapter on a case that is held");
  HAPTOMETER_CHECK(!adapter || (adapter->skin_side_mass_kg > 0 && CaseSide<double>(bodies) > 0),
                   "skin side {} kg, case side {} kg", adapter->skin_side_mass_kg,
                   CaseSide<double>(bodies));
  auto rows = RowsOf<double>(bodies);
  LinearModel model{
      .a = std::move(rows.a), .b = std::move(rows.b), .current_row = std::move(rows.current)};
  if (actuator.inductance_h == 0) model.current_per_volt = 1 / actuator.resistance_ohm;
  model.power_rows = PowerRows(bodies, model);
  if (AllButOneBody(bodies)) AddRest(bodies, model);
  return model;
}

namespace {

// the source's resistance is in series with the coil's
Actuator WithSource(const Scene& scene) {
  Actuator actuator = scene.actuator;
  actuator.resistance_ohm += scene.drive.source_resistance_ohm;
  return actuator;
}

}  // namespace

LinearModel AssembleModel(const Scene& scene) {
  return AssembleModel(WithSource(scene), scene.adapter, scene.skin, scene.grip);
}

LongModel AssembleLongModel(const Scene& scene) {
  const Actuator actuator = WithSource(scene);
  auto rows = RowsOf<long double>(
      {.actuator = actuator, .adapter = scene.adapter, .skin = scene.skin, .grip = scene.grip});
  return {.a = std::move(rows.a), .b = std::move(rows.b)};
}

Eigen::VectorXd StatedStart(const InitialState& stated, const LinearModel& model) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.states());
  if (!stated.Any()) return x;
  x.head(4) << stated.mover_m, stated.mover_m_per_s, stated.case_m, stated.case_m_per_s;
  if (model.skin() != LinearModel::kCase) {
    x(model.skin()) = stated.skin_m;
    x(model.skin_velocity()) = stated.skin_m_per_s;
  }
  // without inductance the current is no state
  if (model.current_per_volt == 0) x(model.states() - 1) = stated.current_a;
  return x;
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

std::vector<std::complex<double>> Poles(const LinearModel& model) {
  // balanced first, as units differ by orders of magnitude
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(Balance(model.a).matrix, false);
  const Eigen::VectorXcd& values = solver.eigenvalues();
  std::vector<std::complex<double>> poles(values.begin(), values.end());
  std::ranges::sort(poles, {}, [](const auto& pole) { return std::pair(Abs(pole), pole.imag()); });
  return poles;
}

}  // namespace haptometer::sim
