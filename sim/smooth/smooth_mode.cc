#include "sim/smooth/smooth_mode.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/elementary_functions.h"
#include "sim/linear/complex_equations.h"

namespace haptometer::sim {
namespace {

// of the growing oscillation that scales are taken from, over its angular frequency
constexpr double kGrowth = 0.1;

// x' form x
double Quadratic(const Eigen::MatrixXd& form, const Eigen::VectorXd& x) { return x.dot(form * x); }

// z = [x, u], the vector of forms that include the inputs
Eigen::VectorXd WithInputs(const Eigen::Ref<const Eigen::VectorXd>& x, const Eigen::Vector3d& u) {
  Eigen::VectorXd z(x.size() + kInputs);
  z << x, u;
  return z;
}

}  // namespace

double HighestFrequencyHz(const ExcitationPiece& piece) {
  double highest_hz = 0;
  for (const ExcitationTerm& term : piece.terms) {
    highest_hz = std::max(highest_hz, term.frequency_hz);
  }
  return highest_hz;
}

SmoothMode::SmoothMode(const SmoothSystem& system, std::size_t mode, const ExcitationPiece& piece,
                       bool with_energy)
    : system_(&system),
      mode_(mode),
      with_energy_(with_energy),
      inputs_(system.linear.modes[mode].Inputs()) {
  SetLinear();
  Begin(piece, piece.begin_s);
}

void SmoothMode::Begin(const ExcitationPiece& piece, long double origin_s) {
  piece_ = piece;
  origin_s_ = origin_s;
  const ExcitationShape shape = ShapeOf(piece);
  // u, u' and u'' from the signals w with w' = S w
  rows_[0] = shape.rows;
  rows_[1] = rows_[0] * shape.generator;
  rows_[2] = rows_[1] * shape.generator;
}

Eigen::Index SmoothMode::states() const { return n() + (system_->heating ? 1 : 0); }

Eigen::Index SmoothMode::integrals() const {
  if (!with_energy_) return 0;
  const PiecewiseLinearSystem& linear = system_->linear;
  // input, dissipating elements, squared rows, i^2
  return static_cast<Eigen::Index>(2 + linear.dissipating_elements.size() +
                                   linear.squared_rows.size());
}

Eigen::Vector3d SmoothMode::InputsThen(double t_s, std::size_t derivative) const {
  FillSignals(piece_, origin_s_ + static_cast<long double>(t_s), signals_);
  return rows_[derivative] * signals_;
}

// the highest tone's angular frequency in rad/s; that of 1 Hz for a piece without tones
double SmoothMode::Pace() const {
  const double highest_hz = HighestFrequencyHz(piece_);
  return 2 * std::numbers::pi * (highest_hz > 0 ? highest_hz : 1);
}

double SmoothMode::PaceOf(const ExcitationTerm& term) const {
  return term.frequency_hz > 0 ? 2 * std::numbers::pi * term.frequency_hz : Pace();
}

// bounds of what one term adds to u over the piece
Eigen::Vector3d SmoothMode::SourceOf(const ExcitationTerm& term) const {
  const Eigen::VectorXd largest = LargestSignals({piece_.begin_s, piece_.end_s, {term}});
  double amplitude = largest[0];
  // a tone's signals are sin and cos, so the amplitude is a factor; a ramp grows to the piece's end
  if (term.kind != ExcitationTerm::Kind::kPolynomial) {
    amplitude = std::abs(term.amplitude) * largest[0];
    if (largest.size() > 2) amplitude += std::abs(term.amplitude_per_s) * largest[2];
  }
  Eigen::Vector3d source = amplitude * Eigen::Vector3d::Unit(term.input);
  // the finger's rate is w times its amplitude
  if (term.input == kFinger) source[kFingerRate] = amplitude * PaceOf(term);
  return source;
}

Eigen::Vector3d SmoothMode::LargestInputs() const {
  Eigen::Vector3d largest = Eigen::Vector3d::Zero();
  for (const ExcitationTerm& term : piece_.terms) largest += SourceOf(term);
  return largest;
}

double SmoothMode::RisePerKelvin() const {
  return system_->heating ? system_->resistance_ohm * system_->heating->resistance_per_k : 0;
}

// i = (c x + k v) / (1 + k R0 alpha theta); k = 0 where the current is a state
SmoothMode::Coil SmoothMode::CoilAt(double volt, const Eigen::Ref<const Eigen::VectorXd>& y) const {
  const Mode& m = mode();
  Coil coil;
  if (system_->heating) coil.rise_ohm = RisePerKelvin() * y[n()];
  coil.held_back = HeldBack(coil.rise_ohm);
  coil.current_a = (m.current_row.dot(y.head(n())) + m.current_per_volt * volt) * coil.held_back;
  return coil;
}

double SmoothMode::Current(double t_s, const Eigen::VectorXd& y) const {
  return CoilAt(InputsThen(t_s)[kVoltage], y).current_a;
}

// A, B, P and R with the coil at R0 + linear_rise_ohm_
void SmoothMode::SetLinear() {
  const Mode& m = mode();
  const Eigen::Index size = n(), heat = system_->heating ? 1 : 0, spring = system_->spring ? 1 : 0;
  // voltage, and the finger where it reaches anything
  const Eigen::Index inputs = m.finger.size() > 0 ? kInputs : 1;
  linear_ = {.a = Eigen::MatrixXd::Zero(size + heat, size + heat),
             .inputs = Eigen::MatrixXd::Zero(size + heat, inputs),
             .feedback = Eigen::MatrixXd::Zero(size + heat, spring + 2 * heat),
             .readings = Eigen::MatrixXd::Zero(spring + 2 * heat, size + heat)};
  linear_.a.topLeftCorner(size, size) = m.a;
  linear_.inputs.topRows(size) = inputs_.leftCols(inputs);
  if (system_->spring) {
    const SpringTerms& terms = system_->spring_terms[mode_];
    linear_.feedback.col(0).head(size) = -terms.push;
    linear_.readings.row(0).head(size) = terms.deflection;
  }
  if (!system_->heating) return;
  const CoilHeating& heating = *system_->heating;
  // the voltage across the rise, as far as it is linear: rise i, i = held back (c x + k v)
  const double across = linear_rise_ohm_ * HeldBack(linear_rise_ohm_);
  linear_.a.topLeftCorner(size, size) -= across * m.b * m.current_row;
  linear_.inputs.col(kVoltage).head(size) -= across * m.current_per_volt * m.b;
  linear_.a(size, size) = -1 / (heating.thermal_resistance_k_per_w * heating.heat_capacity_j_per_k);
  linear_.feedback.col(spring).head(size) = -m.b;
  linear_.feedback(size, spring + 1) = 1;
  linear_.readings.row(spring).head(size) = m.current_row;
  linear_.readings(spring + 1, size) = 1;
}

int SmoothMode::Linearise(const ConstVector& y) {
  // a larger deviation from the linear part's resistance slows the fixed-point iteration down
  constexpr double kStep = 1.2;
  if (!system_->heating) return 0;
  const double R = system_->resistance_ohm;
  const double number = std::round(Log1p(RisePerKelvin() * y[n()] / R) / Log(kStep));
  // a rise that is no number, or below absolute zero
  const int next = std::abs(number) < 1000 ? static_cast<int>(number) : 0;
  if (next == linearisation_) return linearisation_;
  linearisation_ = next;
  linear_rise_ohm_ = R * (Pow(kStep, next) - 1);
  SetLinear();
  return linearisation_;
}

void SmoothMode::Inputs(double t_s, Vector u) const { u = InputsThen(t_s).head(u.size()); }

void SmoothMode::Feedback(const ConstVector& u, const ConstVector& readings, Vector g) const {
  Eigen::Index place = 0;
  if (system_->spring) {
    g[0] = system_->spring->Force(readings[0]);
    place = 1;
  }
  if (!system_->heating) return;
  // c x + k v, the current of a cold coil; theta
  const double cold_a = readings[place] + mode().current_per_volt * u[kVoltage];
  const double rise_ohm = RisePerKelvin() * readings[place + 1];
  const double current_a = HeldBack(rise_ohm) * cold_a;
  g[place] = rise_ohm * current_a - linear_rise_ohm_ * HeldBack(linear_rise_ohm_) * cold_a;
  g[place + 1] = (system_->resistance_ohm + rise_ohm) * current_a * current_a /
                 system_->heating->heat_capacity_j_per_k;
}

// A y + B u + P g
Eigen::VectorXd SmoothMode::Rate(double t_s, const Eigen::VectorXd& y) const {
  Eigen::VectorXd u(linear_.inputs.cols()), g(linear_.feedback.cols());
  Inputs(t_s, u);
  Feedback(u, linear_.readings * y, g);
  return linear_.a * y + linear_.inputs * u + linear_.feedback * g;
}

// d y' / dy
Eigen::MatrixXd SmoothMode::Jacobian(double t_s, const Eigen::VectorXd& y) const {
  const Mode& m = mode();
  const Eigen::Index size = n();
  const auto x = y.head(size);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(states(), states());
  // the linear part, then heating and spring
  jacobian.topLeftCorner(size, size) = m.a;
  if (system_->heating) {
    const CoilHeating& heating = *system_->heating;
    const Coil coil = CoilAt(InputsThen(t_s)[kVoltage], y);
    const double per_k = RisePerKelvin(), current = coil.current_a;
    const double resistance = system_->resistance_ohm + coil.rise_ohm;
    // di/dx, di/dtheta
    const Eigen::RowVectorXd by_state = coil.held_back * m.current_row;
    const double by_theta = -m.current_per_volt * per_k * current * coil.held_back;
    // the voltage is lower by (R(theta) - R0) i, whose derivatives by x and theta enter through b
    jacobian.topLeftCorner(size, size) -= coil.rise_ohm * m.b * by_state;
    jacobian.col(size).head(size) = -(per_k * current + coil.rise_ohm * by_theta) * m.b;
    jacobian.row(size).head(size) =
        2 * resistance * current / heating.heat_capacity_j_per_k * by_state;
    jacobian(size, size) = (per_k * current * current + 2 * resistance * current * by_theta -
                            1 / heating.thermal_resistance_k_per_w) /
                           heating.heat_capacity_j_per_k;
  }
  if (!system_->spring) return jacobian;
  const SpringTerms& terms = system_->spring_terms[mode_];
  jacobian.topLeftCorner(size, size) -=
      system_->spring->Stiffness(terms.deflection.dot(x)) * terms.push * terms.deflection;
  return jacobian;
}

void SmoothMode::IntegralRate(const ConstVector& inputs, const ConstVector& y, Vector rate) const {
  const Mode& m = mode();
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  u.head(inputs.size()) = inputs;
  const Coil coil = CoilAt(u[kVoltage], y);
  const Eigen::VectorXd z = WithInputs(y.head(n()), u);
  rate.setZero();  // a mode may know of no dissipation at all
  // v i, and the power of the finger's motion against the skin's force, W
  rate[0] = u[kVoltage] * coil.current_a;
  if (m.finger_force_row.size() > 0) rate[0] -= u[kFingerRate] * m.finger_force_row.dot(z);
  for (std::size_t k = 0; k < m.dissipating.size(); ++k) {
    const Eigen::MatrixXd& form = m.dissipating[k];
    if (form.size() == 0) continue;
    rate[static_cast<Eigen::Index>(k) + 1] = Quadratic(form, z.head(form.rows()));
  }
  if (system_->heating) {
    rate[static_cast<Eigen::Index>(system_->coil_element) + 1] =
        (system_->resistance_ohm + coil.rise_ohm) * coil.current_a * coil.current_a;
    // the forms contain the cold coil's current
    rate[static_cast<Eigen::Index>(system_->source_element) + 1] *= coil.held_back * coil.held_back;
  }
  auto place = 1 + static_cast<Eigen::Index>(system_->linear.dissipating_elements.size());
  for (const Eigen::RowVectorXd& row : system_->linear.squared_rows) {
    // squares of positions for RMS values, and i^2
    const double value = RowOfPositions(row).dot(y.head(n()));
    rate[place++] = value * value;
  }
  rate[place] = coil.current_a * coil.current_a;
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
    // without inductance the current follows the voltage at once, less the drop in R0 alpha theta
    Eigen::Vector3d u = InputsThen(t_s);
    const Coil coil = CoilAt(u[kVoltage], y);
    u[kVoltage] -= coil.rise_ohm * coil.current_a;
    value += that.feed.dot(u);
  }
  if (system_->spring) {
    const SpringTerms& terms = system_->spring_terms[mode_];
    value -= terms.guard_pulls[guard] * system_->spring->Force(terms.deflection.dot(x));
  }
  return value;
}

double SmoothMode::Value(const WatchedNumber& number, double t_s, const Eigen::VectorXd& y) const {
  const double value = number.row.dot(y.head(n())) + number.offset;
  return number.feed.size() > 0 ? value + number.feed.dot(InputsThen(t_s)) : value;
}

// the equations of motion differentiated: x'' = J x' + B u', x''' = J x'' + J' x' + B u''
GuardJet SmoothMode::Jet(std::size_t guard, double t_s, const Eigen::VectorXd& y) const {
  const Mode& m = mode();
  const Eigen::Index size = n();
  const Coil coil = CoilAt(InputsThen(t_s)[kVoltage], y);
  const Eigen::VectorXd rate = Rate(t_s, y);
  const Eigen::MatrixXd jacobian = Jacobian(t_s, y);
  // derivatives of the inputs; those of the voltage reduced by the rise of the resistance
  Eigen::Vector3d input_rate = InputsThen(t_s, 1), input_second = InputsThen(t_s, 2);
  input_rate[kVoltage] *= coil.held_back;
  input_second[kVoltage] *= coil.held_back;
  Eigen::VectorXd second = jacobian * rate;
  second.head(size) += inputs_ * input_rate;
  Eigen::VectorXd third = jacobian * second;
  third.head(size) += inputs_ * input_second;
  // the change of the Jacobian: twice each product of first derivatives, f'' d'^2
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
  Eigen::RowVectorXd feed = Eigen::RowVectorXd::Zero(kInputs);
  if (that.feed.size() > 0) feed = that.feed;
  return {Value(guard, t_s, y), that.row.dot(rate.head(size)) + feed.dot(input_rate),
          that.row.dot(second.head(size)) + feed.dot(input_second), that.row.dot(third.head(size))};
}

double SmoothMode::StoredEnergy(double t_s, const Eigen::VectorXd& y) const {
  const Eigen::MatrixXd& form = mode().stored_j;
  const auto x = y.head(n());
  const double linear_j =
      form.rows() == n() ? Quadratic(form, x) : Quadratic(form, WithInputs(x, InputsThen(t_s)));
  if (!system_->spring) return linear_j;
  return linear_j + system_->spring->Energy(system_->spring_terms[mode_].deflection.dot(x));
}

// largest magnitudes within a period, abs((s I - A)^-1 (B u + w x0)) at s = (0.1 + j) w
Eigen::VectorXd SmoothMode::ScaleFrom(const Eigen::VectorXd& y) const {
  const Mode& m = mode();
  const auto magnitudes = [&](double omega, const Eigen::VectorXd& source) -> Eigen::VectorXd {
    Eigen::MatrixXcd matrix = -m.a.cast<std::complex<double>>();
    matrix.diagonal().array() += std::complex<double>(kGrowth * omega, omega);
    return Magnitudes(ComplexEquations(matrix).Solve(source.cast<std::complex<double>>()));
  };
  Eigen::VectorXd scale(states());
  scale.head(n()) = magnitudes(Pace(), Pace() * y.head(n()));
  for (const ExcitationTerm& term : piece_.terms) {
    scale.head(n()) += magnitudes(PaceOf(term), inputs_ * SourceOf(term));
  }
  // rise within a radian of the drive without loss of heat, K
  if (system_->heating) {
    const double current = LargestCurrent(scale);
    scale[n()] = std::abs(y[n()]) + system_->resistance_ohm * current * current / Pace() /
                                        system_->heating->heat_capacity_j_per_k;
  }
  return scale;
}

// bound of the current, A: no cancellation between its terms
double SmoothMode::LargestCurrent(const Eigen::VectorXd& scale) const {
  return mode().current_row.cwiseAbs().dot(scale.head(n())) +
         mode().current_per_volt * LargestInputs()[kVoltage];
}

double SmoothMode::LastRise(const Eigen::VectorXd& scale) const {
  const double through_k_per_w = system_->heating->thermal_resistance_k_per_w;
  if (std::isinf(through_k_per_w)) return 0;
  // stationary rise R0 i^2 Rth, K
  const double current = LargestCurrent(scale);
  return system_->resistance_ohm * current * current * through_k_per_w;
}

Eigen::VectorXd SmoothMode::IntegralScale(const Eigen::VectorXd& scale) const {
  if (!with_energy_) return {};
  const Mode& m = mode();
  const Eigen::Vector3d largest = LargestInputs();
  const Eigen::VectorXd z = WithInputs(scale.head(n()), largest);
  const double current = LargestCurrent(scale);
  // power, W, and stored energy, J, without cancellation: all terms by magnitude
  double power_w = largest[kVoltage] * current;
  if (m.finger_force_row.size() > 0) {
    power_w += largest[kFingerRate] * m.finger_force_row.cwiseAbs().dot(z);
  }
  for (const Eigen::MatrixXd& form : m.dissipating) {
    if (form.size() > 0) power_w += Quadratic(form.cwiseAbs(), z.head(form.rows()));
  }
  double stored_j = Quadratic(m.stored_j.cwiseAbs(), z.head(m.stored_j.rows()));
  if (system_->spring) {
    const Eigen::RowVectorXd& deflection = system_->spring_terms[mode_].deflection;
    stored_j += system_->spring->Energy(deflection.cwiseAbs().dot(scale.head(n())));
  }
  // the same scale for all energies: power over a radian of the drive, and what is stored
  Eigen::VectorXd integral_scale =
      Eigen::VectorXd::Constant(integrals(), power_w / Pace() + stored_j);
  auto place = 1 + static_cast<Eigen::Index>(system_->linear.dissipating_elements.size());
  for (const Eigen::RowVectorXd& row : system_->linear.squared_rows) {
    const double value = RowOfPositions(row).cwiseAbs().dot(scale.head(n()));
    integral_scale[place++] = value * value / Pace();
  }
  integral_scale[place] = current * current / Pace();
  return integral_scale;
}

}  // namespace haptometer::sim
