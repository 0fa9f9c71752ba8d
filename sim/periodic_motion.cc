#include "sim/periodic_motion.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace haptometer::sim {

namespace {

constexpr std::array<int, 3> kPeriods{1, 2, 4};
constexpr int kTransients = 3;
constexpr int kMostHalvings = 8;
// residuals over the map's error: good enough to end Newton's steps, to be a fixed point at all,
// and to be a point of a shorter period
constexpr double kDone = 3;
constexpr double kFixed = 1e3;
constexpr double kSame = 1e4;

// The fixed points of P^k near a point.
class Shooting {
 public:
  Shooting(const PeriodMap& map, int periods, const Eigen::VectorXd& scale, std::int64_t& played)
      : map_(map), periods_(periods), scale_(scale), played_(played) {}

  // after Newton's steps; nothing if they lead nowhere
  std::optional<PeriodPoint> From(PeriodPoint point, int newton_steps) {
    std::optional<Eigen::VectorXd> residual = Residual(point);
    for (int i = 0; i < newton_steps && residual && Size(*residual) > kDone * map_.error(); ++i) {
      const std::optional<Eigen::MatrixXd> jacobian = Jacobian(point);
      if (!jacobian || !TakeStep(*jacobian, point, residual)) break;
    }
    if (!residual || !(Size(*residual) <= kFixed * map_.error())) return {};
    residual_ = Size(*residual);
    return point;
  }

  // dP^k/dx by central differences, in units of the scale
  std::optional<Eigen::MatrixXd> Jacobian(const PeriodPoint& point) {
    const Eigen::Index n = point.x.size();
    const double step = std::cbrt(map_.error());
    Eigen::MatrixXd jacobian(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      std::array<Eigen::VectorXd, 2> ends;
      for (const std::size_t side : {0U, 1U}) {
        PeriodPoint moved = point;
        moved.x(k) += (side == 0 ? -step : step) * scale_(k);
        const std::optional<PeriodPoint> end = After(moved, periods_);
        if (!end || end->mode != point.mode) return {};
        ends[side] = end->x;
      }
      jacobian.col(k) = (ends[1] - ends[0]).cwiseQuotient(scale_) / (2 * step);
    }
    return jacobian;
  }

  // how far a point is from where it returns to after other periods
  std::optional<double> ReturnsWithin(const PeriodPoint& point, int periods) {
    const std::optional<PeriodPoint> end = After(point, periods);
    if (!end || end->mode != point.mode) return {};
    return Size((end->x - point.x).cwiseQuotient(scale_));
  }
  [[nodiscard]] double residual() const { return residual_; }

 private:
  static double Size(const Eigen::VectorXd& scaled) { return scaled.cwiseAbs().maxCoeff(); }

  std::optional<PeriodPoint> After(const PeriodPoint& point, int periods) {
    played_ += periods;
    std::optional<PeriodStep> step = map_.After(point, periods);
    if (!step) return {};
    return std::move(step->point);
  }

  // P^k(x) - x in units of the scale
  std::optional<Eigen::VectorXd> Residual(const PeriodPoint& point) {
    const std::optional<PeriodPoint> end = After(point, periods_);
    if (!end || end->mode != point.mode) return {};
    return (end->x - point.x).cwiseQuotient(scale_);
  }

  // a step that brings the point nearer to its image; false: there is none
  bool TakeStep(const Eigen::MatrixXd& jacobian, PeriodPoint& point,
                std::optional<Eigen::VectorXd>& residual) {
    const Eigen::Index n = point.x.size();
    const Eigen::VectorXd step =
        (Eigen::MatrixXd::Identity(n, n) - jacobian).partialPivLu().solve(*residual);
    if (!step.allFinite()) return false;
    double part = 1;
    for (int i = 0; i < kMostHalvings; ++i, part /= 2) {
      PeriodPoint moved = point;
      moved.x += part * step.cwiseProduct(scale_);
      const std::optional<Eigen::VectorXd> left = Residual(moved);
      if (!left || !(Size(*left) < Size(*residual))) continue;
      point = std::move(moved);
      residual = left;
      return true;
    }
    return false;
  }

  const PeriodMap& map_;
  int periods_;
  const Eigen::VectorXd& scale_;
  std::int64_t& played_;
  double residual_ = 0;
};

Eigen::VectorXcd LargestFirst(Eigen::VectorXcd values) {
  std::ranges::sort(values, [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
  return values;
}

// A motion of k periods that has no shorter one.
std::optional<PeriodicMotion> Shoot(const PeriodMap& map, const PeriodPoint& from, int periods,
                                    int newton_steps, std::int64_t& played) {
  const Eigen::VectorXd scale = map.ScaleOf(from);
  Shooting shooting(map, periods, scale, played);
  const std::optional<PeriodPoint> point = shooting.From(from, newton_steps);
  if (!point) return {};
  if (periods > 1) {
    const std::optional<double> apart = shooting.ReturnsWithin(*point, periods / 2);
    if (apart && *apart <= kSame * map.error()) return {};
  }
  const std::optional<Eigen::MatrixXd> jacobian = shooting.Jacobian(*point);
  played += periods;
  std::optional<PeriodStep> whole = map.After(*point, periods, true);
  if (!jacobian || !whole) return {};
  PeriodicMotion motion{
      .drive_periods = periods,
      .point = *point,
      .multipliers = LargestFirst(jacobian->eigenvalues()),
      .residual = shooting.residual(),
      .from_transient = (point->x - from.x).cwiseQuotient(scale).cwiseAbs().maxCoeff(),
      .means = std::move(*whole->means)};
  // central differences are wrong by about the step's square
  const double margin = 10 * std::pow(map.error(), 2.0 / 3);
  motion.stable = std::abs(motion.multipliers(0)) < 1 - margin;
  return motion;
}

}  // namespace

PeriodicSearch FindPeriodicMotion(const PeriodMap& map, const PeriodPoint& start,
                                  const PeriodicSettings& settings) {
  PeriodicSearch search;
  PeriodPoint point = start;
  int transient = settings.transient_periods;
  for (int round = 0; round < kTransients; ++round, transient *= 2) {
    std::optional<PeriodStep> end = map.After(point, transient);
    search.periods_played += transient;
    if (!end) {
      search.tried += fmt::format("the motion stalls within {} periods", transient);
      return search;
    }
    point = std::move(end->point);
    for (const int periods : kPeriods) {
      std::optional<PeriodicMotion> motion =
          Shoot(map, point, periods, settings.newton_steps, search.periods_played);
      if (motion && motion->stable) {
        search.found = std::move(motion);
        return search;
      }
      if (motion && !search.found) search.found = std::move(motion);
    }
    search.tried += fmt::format("{}{} periods of transient, then Newton for 1, 2 and 4",
                                round > 0 ? "; " : "", transient);
  }
  return search;
}

}  // namespace haptometer::sim
