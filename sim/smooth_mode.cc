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

}  // namespace

SmoothMode::SmoothMode(const SmoothSystem& system, std::size_t mode, const SineDrive& drive,
                       bool with_energy)
    : system_(&system), mode_(mode), drive_(drive), with_energy_(with_energy) {}

Eigen::Index SmoothMode::states() const { return n() + (system_->heating ? 1 : 0); }

Eigen::Index SmoothMode::integrals() const {
  return with_energy_ ? static_cast<Eigen::Index>(system_->linear.dissipating_elements.size()) + 1
                      : 0;
}

// sin and cos of the drive's phase
Eigen::Vector2d SmoothMode::DriveThen(double t_s) const {
  return DriveAt(drive_.frequency_hz, origin_s_ + static_cast<long double>(t_s));
}

// rad/s
double SmoothMode::Pace() const {
  return 2 * std::numbers::pi * (drive_.frequency_hz > 0 ? drive_.frequency_hz : 1);
}

// R(theta) - R0
double SmoothMode::ResistanceRise(double theta_k) const {
  return system_->resistance_ohm * system_->heating->resistance_per_k * theta_k;
}

void SmoothMode::Rate(double t_s, const ConstVector& y, Vector rate) const {
  const Mode& m = mode();
  const auto x = y.head(n());
  double volt = drive_.amplitude_v * DriveThen(t_s)[0];
  if (system_->heating) {
    const CoilHeating& heating = *system_->heating;
    const double current = m.current_row.dot(x), theta = y[n()];
    const double rise = ResistanceRise(theta);
    rate[n()] = ((system_->resistance_ohm + rise) * current * current -
                 theta / heating.thermal_resistance_k_per_w) /
                heating.heat_capacity_j_per_k;
    volt -= rise * current;
  }
  rate.head(n()).noalias() = m.a * x;
  rate.head(n()) += volt * m.b;
  if (!system_->spring) return;
  const SpringTerms& terms = system_->spring_terms[mode_];
  rate.head(n()) -= system_->spring->Force(terms.deflection.dot(x)) * terms.push;
}

void SmoothMode::Jacobian(double /*t_s*/, const ConstVector& y, Matrix jacobian) const {
  const Mode& m = mode();
  const Eigen::Index size = n();
  const auto x = y.head(size);
  jacobian.topLeftCorner(size, size) = m.a;
  if (system_->heating) {
    const CoilHeating& heating = *system_->heating;
    const double current = m.current_row.dot(x), rise = ResistanceRise(y[size]);
    const double per_k = ResistanceRise(1);
    const double capacity = heating.heat_capacity_j_per_k;
    jacobian.topLeftCorner(size, size) -= rise * m.b * m.current_row;
    jacobian.col(size).head(size) = -per_k * current * m.b;
    jacobian.row(size).head(size) =
        2 * (system_->resistance_ohm + rise) * current / capacity * m.current_row;
    jacobian(size, size) =
        (per_k * current * current - 1 / heating.thermal_resistance_k_per_w) / capacity;
  }
  if (!system_->spring) return;
  const SpringTerms& terms = system_->spring_terms[mode_];
  jacobian.topLeftCorner(size, size) -=
      system_->spring->Stiffness(terms.deflection.dot(x)) * terms.push * terms.deflection;
}

void SmoothMode::IntegralRate(double t_s, const ConstVector& y, Vector rate) const {
  const Mode& m = mode();
  const Eigen::VectorXd x = y.head(n());
  rate[0] = drive_.amplitude_v * DriveThen(t_s)[0] * m.current_row.dot(x);
  for (std::size_t k = 0; k < m.dissipating.size(); ++k) {
    const bool rests = m.dissipating[k].size() == 0;
    rate[static_cast<Eigen::Index>(k) + 1] = rests ? 0 : Quadratic(m.dissipating[k], x);
  }
  if (!system_->heating) return;
  rate[static_cast<Eigen::Index>(system_->coil_element) + 1] *=
      1 + system_->heating->resistance_per_k * y[n()];
}

double SmoothMode::Value(std::size_t guard, const Eigen::VectorXd& y) const {
  const Guard& that = mode().guards[guard];
  const auto x = y.head(n());
  double value = that.row.dot(x) + that.offset;
  if (system_->spring) {
    const SpringTerms& terms = system_->spring_terms[mode_];
    value -= terms.guard_pulls[guard] * system_->spring->Force(terms.deflection.dot(x));
  }
  return value;
}

// x', x'', x''' by differentiating the equations of motion
GuardJet SmoothMode::Jet(std::size_t guard, double t_s, const Eigen::VectorXd& y) const {
  const Mode& m = mode();
  const Eigen::Index size = n();
  const double omega = 2 * std::numbers::pi * drive_.frequency_hz;
  const Eigen::Vector2d turn = drive_.amplitude_v * DriveThen(t_s);
  const Eigen::VectorXd x = y.head(size);
  Eigen::VectorXd rate(states());
  Rate(t_s, ConstVector(y.data(), y.size()), Vector(rate.data(), rate.size()));
  Eigen::MatrixXd jacobian(states(), states());
  if (system_->heating) jacobian.setZero();
  Jacobian(t_s, ConstVector(y.data(), y.size()),
           Matrix(jacobian.data(), jacobian.rows(), jacobian.cols()));
  Eigen::VectorXd second = jacobian * rate;
  second.head(size) += omega * turn[1] * m.b;
  Eigen::VectorXd third = jacobian * second;
  third.head(size) -= omega * omega * turn[0] * m.b;
  // what the Jacobian's own change adds: twice each product of first derivatives, f'' d'^2
  if (system_->heating) {
    const double current_rate = m.current_row.dot(rate.head(size));
    third.head(size) -= 2 * ResistanceRise(rate[size]) * current_rate * m.b;
  }
  if (system_->spring) {
    const SpringTerms& terms = system_->spring_terms[mode_];
    const double speed = terms.deflection.dot(rate.head(size));
    third.head(size) -=
        system_->spring->Stiffening(terms.deflection.dot(x)) * speed * speed * terms.push;
  }
  const Eigen::RowVectorXd& row = m.guards[guard].row;
  return {Value(guard, y), row.dot(rate.head(size)), row.dot(second.head(size)),
          row.dot(third.head(size))};
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
    const double current = m.current_row.cwiseAbs().dot(scale.head(n()));
    scale[n()] = y[n()] + system_->resistance_ohm * current * current / omega /
                              system_->heating->heat_capacity_j_per_k;
  }
  return scale;
}

double SmoothMode::LastRise(const Eigen::VectorXd& scale) const {
  const double through_k_per_w = system_->heating->thermal_resistance_k_per_w;
  if (std::isinf(through_k_per_w)) return 0;
  const double current = mode().current_row.cwiseAbs().dot(scale.head(n()));
  return system_->resistance_ohm * current * current * through_k_per_w;
}

double SmoothMode::EnergyScale(const Eigen::VectorXd& scale) const {
  const Mode& m = mode();
  const Eigen::VectorXd x = scale.head(n());
  double power_w = drive_.amplitude_v * m.current_row.cwiseAbs().dot(x);
  for (const Eigen::MatrixXd& form : m.dissipating) {
    if (form.size() > 0) power_w += Quadratic(form.cwiseAbs(), x);
  }
  return power_w / Pace() + std::abs(StoredEnergy(scale));
}

}  // namespace haptometer::sim
