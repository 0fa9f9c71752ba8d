#include "sim/period_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "base/check.h"
#include "sim/linear_model.h"
#include "sim/smooth_mode.h"

namespace haptometer::sim {

namespace {

constexpr double kExactError = 1e-13;
constexpr int kOutputsPerPeriod = 64;
constexpr double kUnmoved = 1e-9;

// a last state that is always 1
bool HasConstant(const Mode& mode) {
  const Eigen::Index last = mode.a.rows() - 1;
  return mode.positions.size() > 0 && mode.a.row(last).isZero(0) && mode.b(last) == 0;
}

Eigen::MatrixXd PositionsOf(const Mode& mode) {
  if (mode.positions.size() > 0) return mode.positions;
  return Eigen::MatrixXd::Identity(mode.a.rows(), mode.a.rows());
}

// what turns a position's square into a power of the size that the ledger's have
Eigen::VectorXd PowersPerSquare(const PiecewiseLinearSystem& system, const SineDrive& drive) {
  const double omega = 2 * std::numbers::pi * drive.frequency_hz;
  const Eigen::VectorXd energies = system.modes[0].stored_j.diagonal();
  return (energies.array() > 0).select(omega * energies, 1);
}

// The squares of all positions, and of the travel, as dissipating elements of the ledger, which
// integrates them as exactly as it does energies.
void AddSquares(PiecewiseLinearSystem& system, const Eigen::VectorXd& factors) {
  constexpr std::string_view kName = "square";
  for (Mode& mode : system.modes) {
    mode.dissipating.resize(system.dissipating_elements.size());
    const Eigen::MatrixXd rows = PositionsOf(mode);
    mode.dissipating.reserve(mode.dissipating.size() + static_cast<std::size_t>(rows.rows()) + 1);
    for (Eigen::Index k = 0; k < rows.rows(); ++k) {
      mode.dissipating.emplace_back(factors(k) * rows.row(k).transpose() * rows.row(k));
    }
    const Eigen::RowVectorXd travel = rows.row(LinearModel::kMover) - rows.row(LinearModel::kCase);
    mode.dissipating.emplace_back(factors(LinearModel::kMover) * travel.transpose() * travel);
  }
  system.dissipating_elements.insert(system.dissipating_elements.end(),
                                     static_cast<std::size_t>(factors.size()) + 1, kName);
}

}  // namespace

PeriodMap::PeriodMap(PiecewiseLinearSystem system, const SineDrive& drive)
    : system_{.linear = std::move(system)}, drive_(drive), error_(kExactError) {
  squares_from_ = system_.linear.dissipating_elements.size();
  powers_per_square_ = PowersPerSquare(system_.linear, drive);
  AddSquares(system_.linear, powers_per_square_);
}

PeriodMap::PeriodMap(SmoothSystem system, const SineDrive& drive, const SmoothSettings& settings)
    : PeriodMap(std::move(system.linear), drive) {
  system.linear = std::move(system_.linear);
  system_ = std::move(system);
  settings_ = settings;
  settings_->with_error = false;
  error_ = settings.tolerance;
}

PeriodPoint PeriodMap::PointOf(std::size_t mode, const Eigen::VectorXd& x,
                               double temperature_rise_k) const {
  const Mode& that = system_.linear.modes[mode];
  HAPTOMETER_CHECK(x.size() == that.a.rows(), "{} states", x.size());
  const Eigen::Index n = x.size() - (HasConstant(that) ? 1 : 0);
  PeriodPoint point{.mode = mode, .x = x.head(n)};
  if (!system_.heating) return point;
  point.x.conservativeResize(n + 1);
  point.x(n) = temperature_rise_k;
  return point;
}

// the mode's own coordinates, with a state that is 1
PiecewiseStart PeriodMap::StartOf(const PeriodPoint& point) const {
  const Mode& mode = system_.linear.modes[point.mode];
  PiecewiseStart start{.mode = point.mode, .x = Eigen::VectorXd::Ones(mode.a.rows())};
  const Eigen::Index n = mode.a.rows() - (HasConstant(mode) ? 1 : 0);
  start.x.head(n) = point.x.head(n);
  return start;
}

Eigen::VectorXd PeriodMap::ScaleOf(const PeriodPoint& point) const {
  Eigen::VectorXd y = StartOf(point).x;
  const Eigen::Index n = y.size();
  if (system_.heating) {
    y.conservativeResize(n + 1);
    y(n) = point.x(point.x.size() - 1);
  }
  const SmoothMode mode(system_, point.mode, drive_, false);
  Eigen::VectorXd scale = mode.ScaleFrom(y).cwiseMax(y.cwiseAbs());
  // what the coil comes to in the end, not within a period
  if (system_.heating) scale(n) = std::max(scale(n), mode.LastRise(scale));
  // what nothing moves
  scale = (scale.array() > 0).select(scale, kUnmoved);
  return PointOf(point.mode, scale.head(n), system_.heating ? scale(n) : 0).x;
}

template <typename Motion>
std::optional<PeriodStep> PeriodMap::Play(Motion& motion, int periods, int outputs,
                                          bool with_means) const {
  Eigen::VectorXd largest = motion.Positions().cwiseAbs();
  for (int i = 0; i < periods * outputs; ++i) {
    motion.Next();
    if (motion.stalled_at_s()) return {};
    if (with_means) largest = largest.cwiseMax(motion.Positions().cwiseAbs());
  }
  double theta_k = 0;
  if constexpr (requires { motion.temperature_rise_k(); }) theta_k = motion.temperature_rise_k();
  PeriodStep step{.point = PointOf(motion.mode(), motion.x(), theta_k)};
  if (!with_means) return step;
  const EnergyLedger ledger = motion.Ledger();
  const double duration_s = periods / drive_.frequency_hz;
  const Eigen::Index n = powers_per_square_.size();
  step.means = PeriodMeans{.mean_squares = Eigen::VectorXd(n),
                           .power_w = ledger.input_j / duration_s,
                           .largest = largest,
                           .events = motion.events().size()};
  const double* const squares_j = ledger.dissipated_j.data() + squares_from_;
  for (Eigen::Index k = 0; k < n; ++k) {
    step.means->mean_squares(k) = squares_j[k] / (powers_per_square_(k) * duration_s);
  }
  step.means->travel_mean_square =
      squares_j[n] / (powers_per_square_(LinearModel::kMover) * duration_s);
  return step;
}

std::optional<PeriodStep> PeriodMap::After(const PeriodPoint& point, int periods,
                                           bool with_means) const {
  const int outputs = with_means ? kOutputsPerPeriod : 1;
  const double rate_hz = outputs * drive_.frequency_hz;
  if (!settings_) {
    PiecewiseMotion motion(system_.linear, drive_, StartOf(point), rate_hz, with_means);
    return Play(motion, periods, outputs, with_means);
  }
  SmoothSettings settings = *settings_;
  settings.with_energy = with_means;
  const double theta_k = system_.heating ? point.x(point.x.size() - 1) : 0;
  SmoothMotion motion(system_, drive_, StartOf(point), rate_hz, settings, theta_k);
  return Play(motion, periods, outputs, with_means);
}

}  // namespace haptometer::sim
