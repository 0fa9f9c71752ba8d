// The energies that a piecewise motion keeps.
#include "base/check.h"
#include "sim/piecewise_motion.h"

namespace haptometer::sim {

namespace {

// x' form x, without a vector between: the allocator's lock would cost threads a tenth of their
// time
double Quadratic(const Eigen::MatrixXd& form, const Eigen::VectorXd& x) {
  double sum = 0;
  for (Eigen::Index column = 0; column < x.size(); ++column) {
    sum += x[column] * form.col(column).dot(x);
  }
  return sum;
}

}  // namespace

void PiecewiseMotion::CountEnergy(const Point& from, int level) {
  const StepEnergy& energy = Stepper().Energy(level);
  Eigen::VectorXd z(from.x.size() + from.drive.size());
  z << from.x, from.drive;
  flow_.input_j += static_cast<long double>(Quadratic(energy.input_j, z));
  for (std::size_t k = 0; k < energy.dissipated_j.size(); ++k) {
    if (energy.dissipated_j[k].size() == 0) continue;
    flow_.dissipated_j[k] += static_cast<long double>(Quadratic(energy.dissipated_j[k], z));
  }
  for (std::size_t k = 0; k < energy.squares.size(); ++k) {
    flow_.squares[k] += static_cast<long double>(Quadratic(energy.squares[k], z));
  }
}

double PiecewiseMotion::StoredNow() const {
  const Eigen::MatrixXd& form = system_.modes[mode_].stored_j;
  if (form.rows() == now_.x.size()) return Quadratic(form, now_.x);
  Eigen::VectorXd with_inputs(form.rows());
  with_inputs << now_.x, Inputs();
  return Quadratic(form, with_inputs);
}

EnergyLedger PiecewiseMotion::Ledger() const {
  HAPTOMETER_CHECK(with_energy_, "no energies were kept");
  EnergyLedger ledger{.initial_j = initial_j_,
                      .stored_j = StoredNow(),
                      .input_j = static_cast<double>(flow_.input_j),
                      .impact_j = static_cast<double>(flow_.impact_j)};
  ledger.dissipated_j.assign(flow_.dissipated_j.begin(), flow_.dissipated_j.end());
  return ledger;
}

std::vector<double> PiecewiseMotion::SquareIntegrals() const {
  HAPTOMETER_CHECK(with_energy_, "no energies were kept");
  return {flow_.squares.begin(), flow_.squares.end()};
}

}  // namespace haptometer::sim
