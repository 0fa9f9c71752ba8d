#include "sim/energy_ledger.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "sim/matrix_exponential.h"
#include "sim/scene_mode.h"

namespace haptometer::sim {

namespace {

// S(h) as its Taylor series, |G| h <= 1/4: terms h^(k+1) / (k+1)! M_k with M_0 = Q and
// M_(k+1) = G' M_k + M_k G fall faster than 2^-k/k!; what no longer counts is left out
Eigen::MatrixXd ShortIntegral(const Eigen::MatrixXd& g, const Eigen::MatrixXd& q, double h_s) {
  constexpr int kTerms = 16;
  Eigen::MatrixXd term = h_s * q;
  Eigen::MatrixXd sum = term;
  for (int k = 1; k <= kTerms; ++k) {
    const Eigen::MatrixXd half = term * g;
    term = h_s / (k + 1) * (half + half.transpose());
    sum += term;
    if (term.cwiseAbs().maxCoeff() < 1e-20 * sum.cwiseAbs().maxCoeff()) break;
  }
  return sum;
}

// The integrals of several forms over one step, which share its exponentials.
std::vector<Eigen::MatrixXd> Integrals(const Eigen::MatrixXd& generator,
                                       std::vector<Eigen::MatrixXd> forms, double h_s) {
  const BalancedMatrix balanced = Balance(generator);
  const double norm = balanced.matrix.cwiseAbs().colwise().sum().maxCoeff() * h_s;
  const int doublings = norm > 0.25 ? std::ilogb(norm) + 3 : 0;
  const double short_s = std::ldexp(h_s, -doublings);
  const auto scale = balanced.scale.asDiagonal();
  for (Eigen::MatrixXd& form : forms) {
    if (form.size() > 0) form = ShortIntegral(balanced.matrix, scale * form * scale, short_s);
  }
  for (int k = 0; k < doublings; ++k) {
    const Eigen::MatrixXd e = MatrixExponential(std::ldexp(short_s, k) * balanced.matrix);
    for (Eigen::MatrixXd& form : forms) {
      if (form.size() > 0) form += (e.transpose() * form * e).eval();
    }
  }
  const auto back = balanced.scale.cwiseInverse().asDiagonal();
  for (Eigen::MatrixXd& form : forms) {
    if (form.size() > 0) form = (back * form * back).eval();
  }
  return forms;
}

// what comes in from outside, v i and the finger's part, of [x, u]; made symmetric
Eigen::MatrixXd InputForm(const Mode& mode) {
  const Eigen::Index n = mode.a.rows(), m = n + kInputs;
  Eigen::RowVectorXd current = Eigen::RowVectorXd::Zero(m);
  current.head(n) = mode.current_row;
  current(n + kVoltage) = mode.current_per_volt;
  Eigen::MatrixXd half = Eigen::RowVectorXd::Unit(m, n + kVoltage).transpose() * current / 2;
  if (mode.finger_force_row.size() > 0) {
    half -= Eigen::RowVectorXd::Unit(m, n + kFingerRate).transpose() * mode.finger_force_row / 2;
  }
  return half + half.transpose();
}

}  // namespace

double EnergyLedger::Imbalance() const {
  const double out_j = std::accumulate(dissipated_j.begin(), dissipated_j.end(), impact_j);
  const double error_j = input_j + initial_j - stored_j - out_j;
  const double reference_j = std::max({initial_j, std::abs(input_j), std::abs(out_j)});
  return reference_j > 0 ? std::abs(error_j) / reference_j : 0;
}

StepEnergy EnergyOver(const Mode& mode, const std::vector<Eigen::RowVectorXd>& squared_rows,
                      const Eigen::MatrixXd& generator, const Eigen::MatrixXd& input_rows,
                      double h_s) {
  const Eigen::Index n = mode.a.rows(), m = input_rows.cols();
  // [x, u] = from z
  Eigen::MatrixXd from = Eigen::MatrixXd::Zero(n + kInputs, n + m);
  from.topLeftCorner(n, n).setIdentity();
  from.bottomRightCorner(kInputs, m) = input_rows;
  const auto in_z = [&](const Eigen::MatrixXd& form) {
    return FormIn(form, from.topRows(form.rows()));
  };

  std::vector<Eigen::MatrixXd> forms{in_z(InputForm(mode))};
  forms.reserve(1 + mode.dissipating.size() + squared_rows.size());
  for (const Eigen::MatrixXd& power : mode.dissipating) forms.push_back(in_z(power));
  for (const Eigen::RowVectorXd& positions_row : squared_rows) {
    const Eigen::RowVectorXd row =
        mode.positions.size() > 0 ? (positions_row * mode.positions).eval() : positions_row;
    forms.push_back(in_z(row.transpose() * row));
  }
  forms = Integrals(generator, std::move(forms), h_s);
  StepEnergy energy{.input_j = forms.front()};
  const auto squares = forms.begin() + 1 + static_cast<std::ptrdiff_t>(mode.dissipating.size());
  energy.dissipated_j.assign(forms.begin() + 1, squares);
  energy.squares.assign(squares, forms.end());
  return energy;
}

}  // namespace haptometer::sim
