// What a SmoothMotion shows of where it stands.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/error.h"
#include "sim/smooth_motion.h"

namespace haptometer::sim {

Eigen::VectorXd SmoothMotion::Positions() const {
  const Mode& mode = system_.linear.modes[mode_];
  if (mode.positions.size() == 0) return x_;
  return mode.positions * x_;
}

// the integrals up to the output
std::vector<double> SmoothMotion::IntegralsHere() const {
  HAPTOMETER_CHECK(settings_.with_energy, "no energies were kept");
  // after a stall the output lies behind the solver's last step
  const OdeSolver& solver = runs_[mode_]->solver;
  const double tau_s = std::clamp(TauOfOutput(), solver.begin_s(), solver.end_s());
  const Eigen::VectorXd since = solver.IntegralsAt(tau_s);
  std::vector<double> integrals;
  integrals.reserve(flow_.integrals.size());
  for (std::size_t k = 0; k < flow_.integrals.size(); ++k) {
    integrals.push_back(static_cast<double>(flow_.integrals[k]) +
                        since[static_cast<Eigen::Index>(k)]);
  }
  return integrals;
}

EnergyLedger SmoothMotion::Ledger() const {
  const std::vector<double> integrals = IntegralsHere();
  const auto squares =
      integrals.end() - 1 - static_cast<std::ptrdiff_t>(system_.linear.squared_rows.size());
  return {.initial_j = initial_j_,
          .stored_j = runs_[mode_]->problem.StoredEnergy(TauOfOutput(), x_),
          .input_j = integrals.front(),
          .impact_j = static_cast<double>(flow_.impact_j),
          .dissipated_j{integrals.begin() + 1, squares}};
}

std::vector<double> SmoothMotion::SquareIntegrals() const {
  const std::vector<double> integrals = IntegralsHere();
  const auto end = integrals.end() - 1;
  return {end - static_cast<std::ptrdiff_t>(system_.linear.squared_rows.size()), end};
}

// the state with the coil's rise
Eigen::VectorXd SmoothMotion::Whole() const {
  Eigen::VectorXd y = x_;
  if (!system_.heating) return y;
  y.conservativeResize(y.size() + 1);
  y(y.size() - 1) = temperature_rise_k_;
  return y;
}

Eigen::VectorXd SmoothMotion::Rates() const {
  const Eigen::VectorXd y = Whole();
  Eigen::VectorXd rate(y.size());
  runs_[mode_]->problem.Rate(TauOfOutput(), OdeProblem::ConstVector(y.data(), y.size()),
                             OdeProblem::Vector(rate.data(), rate.size()));
  const Mode& mode = system_.linear.modes[mode_];
  if (mode.positions.size() == 0) return rate.head(x_.size());
  return mode.positions * rate.head(x_.size());
}

Eigen::VectorXd SmoothMotion::Inputs() const {
  Eigen::VectorXd signals;
  FillSignals(piece_, std::max(0.0L, TimeOf(index_)), signals);
  return ShapeOf(piece_).rows * signals;
}

double SmoothMotion::CurrentA() const {
  return runs_[mode_]->problem.Current(TauOfOutput(), Whole());
}

}  // namespace haptometer::sim
