#include "sim/piecewise/energy_ledger.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "base/error.h"
#include "sim/linear/driven_step.h"
#include "sim/linear/scene_mode.h"
#include "sim/piecewise/piecewise_motion.h"

namespace haptometer::sim {
namespace {

// S(h) as its Taylor series, |G| h <= 1/4: terms h^(k+1) / (k+1)! M_k with M_0 = Q and
// M_(k+1) = G' M_k + M_k G fall faster than 2^-k/k!; the sum ends where they are negligible
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
  // halvings until |G| h <= 1/4, for the series
  const double norm = balanced.matrix.cwiseAbs().colwise().sum().maxCoeff() * h_s;
  const int doublings = norm > 0.25 ? std::ilogb(norm) + 3 : 0;
  const double short_s = std::ldexp(h_s, -doublings);
  const auto scale = balanced.scale.asDiagonal();
  for (Eigen::MatrixXd& form : forms) {
    if (form.size() > 0) form = ShortIntegral(balanced.matrix, scale * form * scale, short_s);
  }
  // S(2h) = S(h) + exp(G' h) S(h) exp(G h), sums of terms of one sign only
  for (int k = 0; k < doublings; ++k) {
    const Eigen::MatrixXd e = MatrixExponential(std::ldexp(short_s, k) * balanced.matrix);
    for (Eigen::MatrixXd& form : forms) {
      if (form.size() > 0) form += (e.transpose() * form * e).eval();
    }
  }
  // back to the caller's units: D^-1 S D^-1
  const auto back = balanced.scale.cwiseInverse().asDiagonal();
  for (Eigen::MatrixXd& form : forms) {
    if (form.size() > 0) form = (back * form * back).eval();
  }
  return forms;
}

// input power v i and the finger's part as a form of [x, u], made symmetric
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
  // input + initial = stored + dissipated + impacts
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

  // one list, because all forms share the exponentials: input, elements, squared rows
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

// What a piecewise motion accumulates: energies, and the ranges of the numbers watched.

namespace {

// x' form x of a form (n, n), without a temporary vector
double Quadratic(const Eigen::MatrixXd& form, const Eigen::VectorXd& x) {
  const Eigen::Index n = x.size();
  HAPTOMETER_CHECK(form.rows() == n && form.cols() == n, "{} rows for {}", form.rows(), n);
  double sum = 0;
  for (Eigen::Index column = 0; column < n; ++column) {
    sum += x[column] * Eigen::VectorXd::Map(form.data() + column * n, n).dot(x);
  }
  return sum;
}

}  // namespace

void PiecewiseMotion::TakeStock(const Point& from, int level, const Point& to) {
  if (with_energy_) CountEnergy(from, level);
  if (!flow_.ranges.empty()) Watch(from, level, to);
  // before the first event the error is carried in long steps (CarryErrorFar)
  if (flow_.error && flow_.error_by_steps) CarryError(from, level, to);
}

void PiecewiseMotion::CountEnergy(const Point& from, int level) {
  // each energy of the step is a quadratic form of z = [x, w] at its begin, J
  const StepEnergy& energy = Stepper().Energy(level);
  Eigen::VectorXd& z = energy_z_;
  z.resize(from.x.size() + from.drive.size());
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

void PiecewiseMotion::ForgetRanges() {
  flow_.ranges.assign(system_.modes[mode_].watched.size(), {});
  for (std::size_t k = 0; k < flow_.ranges.size(); ++k) {
    flow_.ranges[k].Include(Stepper().Watched()[k].Value(now_.x, now_.drive));
  }
}

// A step that cannot exceed the ranges so far needs the values at its ends only.
void PiecewiseMotion::Watch(const Point& from, int level, const Point& to) {
  constexpr int kHalvings = 24;  // the bound is then 2^-48 of the first
  const double h_s = std::ldexp(1 / rate_hz_, -level);
  std::vector<GuardBound>& watched = Stepper().Watched();
  for (std::size_t k = 0; k < watched.size(); ++k) {
    ValueRange& range = flow_.ranges[k];
    const double begin = watched[k].Value(from.x, from.drive);
    const double end = watched[k].Value(to.x, to.drive);
    range.Include(begin);
    range.Include(end);
    // a function lies within max abs(f'') h^2 / 8 of its chord
    const double bulge = watched[k].SecondBound(from.x, largest_signals_) * h_s * h_s / 8;
    const bool inside = std::max(begin, end) + bulge <= range.largest &&
                        std::min(begin, end) - bulge >= range.least;
    if (inside) continue;
    LookForExtremes(watched[k], from, level, to, level + kHalvings, range);
  }
}

// includes the extremes within a step: proves that there is none, finds the only one, or halves
void PiecewiseMotion::LookForExtremes(GuardBound& number, const Point& from, int level,
                                      const Point& to, int deepest, ValueRange& range) {
  const double h_s = std::ldexp(1 / rate_hz_, -level);
  const GuardJet begin = number.Jet(from.x, from.drive), end = number.Jet(to.x, to.drive);
  range.Include(begin[0]);
  range.Include(end[0]);
  const bool bounded = level >= Stepper().WatchLevel();
  if (bounded) {
    // bounds of the derivatives hold over the step: does it contain anything new?
    const auto [bound, m3, m4] = number.Bounds(from.x, largest_signals_);
    // |g''| is also at most what lies between its values at both ends and m4 h^2/8 (at rest, where
    // the bound by magnitudes is far too large)
    const double ends = std::max(std::abs(begin[2]), std::abs(end[2]));
    const double m2 = std::min(bound, ends + m4 * h_s * h_s / 8);
    // and 1e-15 of the range is the state's rounding
    const double bulge = m2 * h_s * h_s / 8 - 1e-15 * std::max(range.largest, -range.least);
    const bool inside = std::max(begin[0], end[0]) + bulge <= range.largest &&
                        std::min(begin[0], end[0]) - bulge >= range.least;
    if (inside || std::min(std::abs(begin[1]), std::abs(end[1])) > m2 * h_s) return;
    // the slope may change its sign more than once: halves
    if (std::abs(begin[2]) <= m3 * h_s) {
      if (level >= std::min(deepest, kFinestLevel)) return;
      Point middle;
      Step(from, level + 1, middle);
      LookForExtremes(number, from, level + 1, middle, deepest, range);
      LookForExtremes(number, middle, level + 1, to, deepest, range);
      return;
    }
  }
  // g'' has one sign (or the step is too long to bound): one extreme where g' changes its sign
  if ((begin[1] > 0) != (end[1] > 0)) range.Include(ValueAtExtreme(number, from, level));
}

// the value where the slope changes its sign, which it does once
double PiecewiseMotion::ValueAtExtreme(const GuardBound& number, const Point& from, int level) {
  constexpr int kHalvings = 28;  // an extreme is flat
  Point point = from, next;
  const bool rises = number.Jet(from.x, from.drive)[1] > 0;
  for (int finer = level + 1; finer <= std::min(level + kHalvings, kFinestLevel); ++finer) {
    Step(point, finer, next);
    if ((number.Jet(next.x, next.drive)[1] > 0) == rises) std::swap(point, next);
  }
  return number.Value(point.x, point.drive);
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
