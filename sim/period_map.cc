#include "sim/period_map.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/error.h"
#include "sim/linear/excitation.h"
#include "sim/linear/linear_model.h"
#include "sim/smooth/smooth_mode.h"

namespace haptometer::sim {
namespace {

// relative error of an exact motion over a period
constexpr double kExactError = 1e-13;
constexpr int kOutputsPerPeriod = 64;
// scale of a coordinate that nothing moves, so that no quotient is 0 / 0
constexpr double kUnmoved = 1e-9;

// a last state that is always 1
bool HasConstant(const Mode& mode) {
  const Eigen::Index last = mode.a.rows() - 1;
  return mode.positions.size() > 0 && mode.a.row(last).isZero(0) && mode.b(last) == 0;
}

// every position, and the mover's travel in its case
std::vector<Eigen::RowVectorXd> RowsToSquare(const Mode& mode) {
  const Eigen::Index n = mode.positions.size() > 0 ? mode.positions.rows() : mode.a.rows();
  std::vector<Eigen::RowVectorXd> rows;
  rows.reserve(static_cast<std::size_t>(n) + 1);
  for (Eigen::Index k = 0; k < n; ++k) rows.emplace_back(Eigen::RowVectorXd::Unit(n, k));
  rows.emplace_back(rows[LinearModel::kMover] - rows[LinearModel::kCase]);
  return rows;
}

}  // namespace

PeriodMap::PeriodMap(PiecewiseLinearSystem system, const SineDrive& drive)
    : system_{.linear = std::move(system)}, drive_(drive), error_(kExactError) {
  system_.linear.squared_rows = RowsToSquare(system_.linear.modes[0]);
}

PeriodMap::PeriodMap(SmoothSystem system, const SineDrive& drive, const SmoothSettings& settings)
    : system_(std::move(system)), drive_(drive), settings_(settings), error_(settings.tolerance) {
  system_.linear.squared_rows = RowsToSquare(system_.linear.modes[0]);
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
  const SmoothMode mode(system_, point.mode, Excitation(drive_).Piece(0), false);
  Eigen::VectorXd scale = mode.ScaleFrom(y).cwiseMax(y.cwiseAbs());
  // the coil's stationary rise, as its time constant may be a million periods
  if (system_.heating) scale(n) = std::max(scale(n), mode.LastRise(scale));
  // coordinates that nothing moves
  scale = (scale.array() > 0).select(scale, kUnmoved);
  return PointOf(point.mode, scale.head(n), system_.heating ? scale(n) : 0).x;
}

template <typename Motion>
std::expected<PeriodStep, FindingKind> PeriodMap::Play(Motion& motion, int periods, int outputs,
                                                       bool with_means, const Visit& visit) const {
  const auto here = [&] {
    double theta_k = 0;
    if constexpr (requires { motion.temperature_rise_k(); }) theta_k = motion.temperature_rise_k();
    return PointOf(motion.mode(), motion.x(), theta_k);
  };
  // peaks at the outputs only, not between them
  Eigen::VectorXd largest = motion.Positions().cwiseAbs();
  for (int i = 1; i <= periods * outputs; ++i) {
    motion.Next();
    if (motion.stalled_at_s()) return std::unexpected(*motion.stall_reason());
    if (visit && i % outputs == 0) visit(here());
    if (with_means) largest = largest.cwiseMax(motion.Positions().cwiseAbs());
  }
  PeriodStep step{.point = here(), .steps = motion.steps()};
  if (!with_means) return step;
  const double duration_s = periods / drive_.frequency_hz;
  const std::vector<double> squares = motion.SquareIntegrals();
  const auto n = static_cast<Eigen::Index>(squares.size()) - 1;
  const EnergyLedger ledger = motion.Ledger();
  // integrals over the time played become means
  step.means =
      PeriodMeans{.mean_squares = Eigen::Map<const Eigen::VectorXd>(squares.data(), n) / duration_s,
                  .travel_mean_square = squares.back() / duration_s,
                  .power_w = ledger.input_j / duration_s,
                  .coil_w = ledger.dissipated_j[system_.coil_element] / duration_s,
                  .largest = largest,
                  .events = motion.events().size()};
  return step;
}

std::expected<PeriodStep, FindingKind> PeriodMap::After(const PeriodPoint& point, int periods,
                                                        bool with_means, const Visit& visit) const {
  // means need the peaks within a period, the map alone the ends of periods
  const int outputs = with_means ? kOutputsPerPeriod : 1;
  const double rate_hz = outputs * drive_.frequency_hz;
  if (!settings_) {
    if (with_means) {
      PiecewiseMotion motion(system_.linear, drive_, StartOf(point), rate_hz, true);
      return Play(motion, periods, outputs, true, visit);
    }
    if (exact_ == nullptr) {
      exact_ = std::make_unique<PiecewiseMotion>(system_.linear, drive_, StartOf(point), rate_hz);
    } else {
      exact_->Restart(StartOf(point));
    }
    return Play(*exact_, periods, outputs, false, visit);
  }
  const double theta_k = system_.heating ? point.x(point.x.size() - 1) : 0;
  if (with_means) {
    SmoothSettings settings = *settings_;
    settings.with_energy = true;
    SmoothMotion motion(system_, drive_, StartOf(point), rate_hz, settings, theta_k);
    return Play(motion, periods, outputs, true, visit);
  }
  if (smooth_ == nullptr) {
    smooth_ = std::make_unique<SmoothMotion>(system_, drive_, StartOf(point), rate_hz, *settings_,
                                             theta_k);
  } else {
    smooth_->Restart(StartOf(point), theta_k);
  }
  return Play(*smooth_, periods, outputs, false, visit);
}

}  // namespace haptometer::sim
