#include "sim/smooth_mode.h"

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>

#include "sim/driven_step.h"

namespace haptometer::sim {

namespace {

// of the growing oscillation that scales are taken from, over its angular frequency
constexpr double kGrowth = 0.1;

double Quadratic(const Eigen::MatrixXd& form, const Eigen::VectorXd& x) { return x.dot(form * x); }

// [x, u] with the voltage; the finger rests
Eigen::VectorXd WithVoltage(const Eigen::Ref<const Eigen::VectorXd>& x, double volt) {
  Eigen::VectorXd z = Eigen::VectorXd::Zero(x.size() + kInputs);
  z.head(x.size()) = x;
  z(x.size() + kVoltage) = volt;
  return z;
}

}  // namespace

SmoothMode::SmoothMode(const SmoothSystem& system, std::size_t mode, const SineDrive& drive,
                       bool with_energy)
    : system_(&system), mode_(mode), drive_(drive), with_energy_(with_energy) {}

Eigen::Index SmoothMode::states() const { return n() + (system_->heating ? 1 : 0); }

Eigen::Index SmoothMode::integrals() const {
  if (!with_energy_) return 0;
  const PiecewiseLinearSystem& linear = system_->linear;
  return static_cast<Eigen::Index>(1 + linear.dissipating_elements.size() +
                                   linear.squared_rows.size());
}

// sin and cos of the drive's phase
Eigen::Vector2d SmoothMode::DriveThen(double t_s) const {
  return DriveAt(drive_.frequency_hz, origin_s_ + static_cast<long double>(t_s));
}

// rad/s
double SmoothMode::Pace() const {
  return 2 * std::numbers::pi * (drive_.frequency_hz > 0 ? drive_.frequency_hz : 1);
}

double SmoothMode::RisePerKelvin() const {
  return system_->heating ? system_->resistance_ohm * system_->heating->resistance_per_k : 0;
}

SmoothMode::Coil SmoothMode::CoilAt(double volt, const Eigen::Ref<const Eigen::VectorXd>& y) const {
  const Mode& m = mode();
  Coil coil;
  if (system_->heating) coil.rise_ohm = RisePerKelvin() * y[n()];
  coil.held_back = 1 / (1 + m.current_per_volt * coil.rise_ohm);
  coil.current_a = (m.current_row.dot(y.head(n())) + m.current_per_volt * volt) * coil.held_back;
  return coil;
}

double SmoothMode::Current(double t_s, const Eigen::VectorXd& y) const {
  return CoilAt(drive_.amplitude_v * DriveThen(t_s)[0], y).current_a;
}

void SmoothMode::Rate(double t_s, const ConstVector& y, Vector rate) const {
  const Mode& m = mode();
  const auto x = y.head(n());
  double volt = drive_.amplitude_v * DriveThen(t_s)[0];
  if (system_->heating) {
    const CoilHeating& heating = *system_->heating;
    const Coil coil = CoilAt(volt, y);
    rate[n()] = ((system_->resistance_ohm + coil.rise_ohm) * coil.current_a * coil.current_a -
                 y[n()] / heating.thermal_resistance_k_per_w) /
                heating.heat_capacity_j_per_k;
    volt -= coil.rise_ohm * coil.current_a;
  }
  rate.head(n()).noalias() = m.a * x;
  rate.head(n()) += volt * m.b;
  if (!system_->spring) return;
  const SpringTerms& terms = system_->spring_terms[mode_];
  rate.head(n()) -= system_->spring->Force(terms.deflection.dot(x)) * terms.push;
}

void SmoothMode::Jacobian(double t_s, const ConstVector& y, Matrix jacobian) const {
  const Mode& m = mode();
  const Eigen::Index size = n();
  const auto x = y.head(size);
  jacobian.topLeftCorner(size, size) = m.a;
  if (system_->heating) {
    const CoilHeating& heating = *system_->heating;
    const Coil coil = CoilAt(drive_.amplitude_v * DriveThen(t_s)[0], y);
    const double per_k = RisePerKelvin(), current = coil.current_a;
    const double resistance = system_->resistance_ohm + coil.rise_ohm;
    // di/dx, di/dtheta
    const Eigen::RowVectorXd by_state = coil.held_back * m.current_row;
    const double by_theta = -m.current_per_volt * per_k * current * coil.held_back;
    jacobian.topLeftCorner(size, size) -= coil.rise_ohm * m.b * by_state;
    jacobian.col(size).head(size) = -(per_k * current + coil.rise_ohm * by_theta) * m.b;
    jacobian.row(size).head(size) =
        2 * resistance * current / heating.heat_capacity_j_per_k * by_state;
    jacobian(size, size) = (per_k * current * current + 2 * resistance * current * by_theta -
                            1 / heating.thermal_resistance_k_per_w) /
                           heating.heat_capacity_j_per_k;
  }
  if (!system_->spring) return;
  const SpringTerms& terms = system_->spring_terms[mode_];
  jacobian.topLeftCorner(size, size) -=
      system_->spring->Stiffness(terms.deflection.dot(x)) * terms.push * terms.deflection;
}

void SmoothMode::IntegralRate(double t_s, const ConstVector& y, Vector rate) const {
  const Mode& m = mode();
  const double volt = drive_.amplitude_v * DriveThen(t_s)[0];
  const Coil coil = CoilAt(volt, y);
  const Eigen::VectorXd z = WithVoltage(y.head(n()), volt);
  rate.setZero();  // a mode may know of no dissipation at all
  rate[0] = volt * coil.current_a;
  for (std::size_t k = 0; k < m.dissipating.size(); ++k) {
    const Eigen::MatrixXd& form = m.dissipating[k];
    if (form.size() == 0) continue;
    rate[static_cast<Eigen::Index>(k) + 1] = Quadratic(form, z.head(form.rows()));
  }
  if (system_->heating) {
    rate[static_cast<Eigen::Index>(system_->coil_element) + 1] =
        (system_->resistance_ohm + coil.rise_ohm) * coil.current_a * coil.current_a;
  }
  auto place = 1 + static_cast<Eigen::Index>(system_->linear.dissipating_elements.size());
  for (const Eigen::RowVectorXd& row : system_->linear.squared_rows) {
    const double value = RowOfPositions(row).dot(y.head(n()));
    rate[place++] = value * value;
  }
}

// a row over the positions as one over the mode's coordinates
Eigen::RowVectorXd SmoothMode::RowOfPositions(const Eigen::RowVectorXd& row) const {
  return mode().positions.size() > 0 ? (row * mode().positions).eval() : row;
}

double SmoothMode::Value(std::size_t guard, double t_s, const Eigen::VectorXd& y) const {
  const Guard& that = mode().guards[guard];
  const auto x = y.head(n());
  double value = that.row.dot(x) + that.offset;
  if (that.feed.size() > 0) {
    // the coil's current feels the voltage at once, less what the rise takes
    const double volt = drive_.amplitude_v * DriveThen(t_s)[0];
    const Coil coil = CoilAt(volt, y);
    value += that.feed(kVoltage) * (volt - coil.rise_ohm * coil.current_a);
  }
  if (system_->spring) {
    const SpringTerms& terms = system_->spring_terms[mode_];
    value -= terms.guard_pulls[guard] * system_->spring->Force(terms.deflection.dot(x));
  }
  return value;
}

// x and its derivatives by differentiating the equations of motion
GuardJet SmoothMode::Jet(std::size_t guard, double t_s, const Eigen::VectorXd& y) const {
  const Mode& m = mode();
  const Eigen::Index size = n();
  const double omega = 2 * std::numbers::pi * drive_.frequency_hz;
  const Eigen::Vector2d turn = drive_.amplitude_v * DriveThen(t_s);
  const Coil coil = CoilAt(turn[0], y);
  Eigen::VectorXd rate(states());
  Rate(t_s, ConstVector(y.data(), y.size()), Vector(rate.data(), rate.size()));
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(states(), states());
  Jacobian(t_s, ConstVector(y.data(), y.size()),
           Matrix(jacobian.data(), jacobian.rows(), jacobian.cols()));
  // the voltage's derivatives as the coil feels them
  const double volt_rate = omega * turn[1] * coil.held_back;
  const double volt_second = -omega * omega * turn[0] * coil.held_back;
  Eigen::VectorXd second = jacobian * rate;
  second.head(size) += volt_rate * m.b;
  Eigen::VectorXd third = jacobian * second;
  third.head(size) += volt_second * m.b;
  // what the Jacobian's own change adds: twice each product of first derivatives, f'' d'^2
  if (system_->heating) {
    const double current_rate = m.current_row.dot(rate.head(size));
    third.head(size) -= 2 * RisePerKelvin() * rate[size] * current_rate * m.b;
  }
  if (system_->spring) {
    const SpringTerms& terms = system_->spring_terms[mode_];
    const double speed = terms.deflection.dot(rate.head(size));
    third.head(size) -= system_->spring->Stiffening(terms.deflection.dot(y.head(size))) * speed *
                        speed * terms.push;
  }
  const Guard& that = m.guards[guard];
  const double feed = that.feed.size() > 0 ? that.feed(kVoltage) : 0;
  return {Value(guard, t_s, y), that.row.dot(rate.head(size)) + feed * volt_rate,
          that.row.dot(second.head(size)) + feed * volt_second, that.row.dot(third.head(size))};
}

double SmoothMode::StoredEnergy(const Eigen::VectorXd& y) const {
  const Eigen::VectorXd x = y.head(n());
  const double linear_j = Quadratic(mode().stored_j, x);
  if (!system_->spring) return linear_j;
  return linear_j + system_->spring->Energy(system_->spring_terms[mode_].deflection.dot(x));
}

Eigen::VectorXd SmoothMode::ScaleFrom(const Eigen::VectorXd& y) const {
  const Mode& m = mode();
  const double omega = Pace();
  Eigen::MatrixXcd matrix = -m.a.cast<std::complex<double>>();
  matrix.diagonal().array() += std::complex<double>(kGrowth * omega, omega);
  const Eigen::VectorXd source = drive_.amplitude_v * m.b + omega * y.head(n());
  Eigen::VectorXd scale(states());
  scale.head(n()) = matrix.partialPivLu().solve(source.cast<std::complex<double>>()).cwiseAbs();
  if (system_->heating) {
    const double current =
        m.current_row.cwiseAbs().dot(scale.head(n())) + m.current_per_volt * drive_.amplitude_v;
    scale[n()] = y[n()] + system_->resistance_ohm * current * current / omega /
                              system_->heating->heat_capacity_j_per_k;
  }
  return scale;
}

double SmoothMode::LastRise(const Eigen::VectorXd& scale) const {
  const double through_k_per_w = system_->heating->thermal_resistance_k_per_w;
  if (std::isinf(through_k_per_w)) return 0;
  const double current = mode().current_row.cwiseAbs().dot(scale.head(n())) +
                         mode().current_per_volt * drive_.amplitude_v;
  return system_->resistance_ohm * current * current * through_k_per_w;
}

Eigen::VectorXd SmoothMode::IntegralScale(const Eigen::VectorXd& scale) const {
  if (!with_energy_) return {};
  const Mode& m = mode();
  const Eigen::VectorXd z = WithVoltage(scale.head(n()), drive_.amplitude_v);
  const double current =
      m.current_row.cwiseAbs().dot(scale.head(n())) + m.current_per_volt * drive_.amplitude_v;
  double power_w = drive_.amplitude_v * current;
  for (const Eigen::MatrixXd& form : m.dissipating) {
    if (form.size() > 0) power_w += Quadratic(form.cwiseAbs(), z.head(form.rows()));
  }
  Eigen::VectorXd integral_scale =
      Eigen::VectorXd::Constant(integrals(), power_w / Pace() + std::abs(StoredEnergy(scale)));
  auto place = 1 + static_cast<Eigen::Index>(system_->linear.dissipating_elements.size());
  for (const Eigen::RowVectorXd& row : system_->linear.squared_rows) {
    const double value = RowOfPositions(row).cwiseAbs().dot(scale.head(n()));
    integral_scale[place++] = value * value / Pace();
  }
  return integral_scale;
}

}  // namespace haptometer::sim
