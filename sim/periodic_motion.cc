#include "sim/periodic_motion.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <expected>
#include <string_view>
#include <utility>

namespace haptometer::sim {

namespace {

constexpr std::array<int, 3> kPeriods{1, 2, 4};
constexpr int kTransients = 3;
constexpr int kMostHalvings = 8;
// over the map's error: a step that need not be taken, a residual that is a fixed point's, and one
// that is a shorter period's
constexpr double kDone = 3;
constexpr double kFixed = 1e3;
constexpr double kSame = 1e4;

// The map, whose work a search counts; beyond its limit nothing is known of any point.
class CountedMap {
 public:
  CountedMap(const PeriodMap& map, std::int64_t most_steps, PeriodicSearch& search)
      : map_(map), most_steps_(most_steps), search_(search) {}

  bool IsSpent() const { return search_.steps > most_steps_; }
  std::expected<PeriodStep, std::string_view> After(const PeriodPoint& point, int periods,
                                                    bool with_means = false) {
    if (IsSpent()) return std::unexpected("the search needs too many steps");
    std::expected<PeriodStep, std::string_view> step = map_.After(point, periods, with_means);
    search_.periods_played += periods;
    if (step) search_.steps += step->steps;
    return step;
  }
  Eigen::VectorXd ScaleOf(const PeriodPoint& point) const { return map_.ScaleOf(point); }
  double error() const { return map_.error(); }

 private:
  const PeriodMap& map_;
  std::int64_t most_steps_;
  PeriodicSearch& search_;
};

// The fixed points of P^k near a point.
class Shooting {
 public:
  Shooting(CountedMap& map, int periods, const Eigen::VectorXd& scale)
      : map_(map), periods_(periods), scale_(scale) {}

  struct End {
    PeriodPoint point;
    Eigen::MatrixXd jacobian;
    double residual = 0;
  };

  // after Newton's steps; nothing if they lead nowhere. They end where they become small, not where
  // the residual does: what decays slowly moves little in a period.
  std::optional<End> From(PeriodPoint point, int newton_steps) {
    std::optional<Eigen::VectorXd> residual = Residual(point);
    if (!residual) return {};
    std::optional<Eigen::MatrixXd> jacobian = Jacobian(point);
    for (int i = 0; i < newton_steps && jacobian; ++i) {
      if (!TakeStep(*jacobian, point, *residual)) break;
      jacobian = Jacobian(point);
    }
    if (!jacobian || !(Size(*residual) <= kFixed * map_.error())) return {};
    return End{.point = point, .jacobian = *jacobian, .residual = Size(*residual)};
  }

  // dP^k/dx by central differences, in units of the scale
  std::optional<Eigen::MatrixXd> Jacobian(const PeriodPoint& point, double larger = 1) {
    const Eigen::Index n = point.x.size();
    const double step = larger * std::cbrt(map_.error());
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

 private:
  static double Size(const Eigen::VectorXd& scaled) { return scaled.cwiseAbs().maxCoeff(); }

  std::optional<PeriodPoint> After(const PeriodPoint& point, int periods) {
    std::expected<PeriodStep, std::string_view> step = map_.After(point, periods);
    if (!step) return {};
    return std::move(step->point);
  }

  // P^k(x) - x in units of the scale
  std::optional<Eigen::VectorXd> Residual(const PeriodPoint& point) {
    const std::optional<PeriodPoint> end = After(point, periods_);
    if (!end || end->mode != point.mode) return {};
    return (end->x - point.x).cwiseQuotient(scale_);
  }

  // As much of a step as makes the next one, by the same Jacobian, clearly smaller (Deuflhard's
  // natural test: residuals of slow and fast states do not compare); false: none does, or there is
  // no way left to go.
  bool TakeStep(const Eigen::MatrixXd& jacobian, PeriodPoint& point, Eigen::VectorXd& residual) {
    const Eigen::Index n = point.x.size();
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(Eigen::MatrixXd::Identity(n, n) - jacobian);
    const Eigen::VectorXd step = lu.solve(residual);
    if (!(Size(step) > kDone * map_.error())) return false;
    double part = 1;
    for (int i = 0; i < kMostHalvings; ++i, part /= 2) {
      PeriodPoint moved = point;
      moved.x += part * step.cwiseProduct(scale_);
      const std::optional<Eigen::VectorXd> left = Residual(moved);
      if (!left || !(Size(lu.solve(*left)) < (1 - part / 2) * Size(step))) continue;
      point = std::move(moved);
      residual = *left;
      return true;
    }
    return false;
  }

  CountedMap& map_;
  int periods_;
  const Eigen::VectorXd& scale_;
};

Eigen::VectorXcd LargestFirst(Eigen::VectorXcd values) {
  std::ranges::sort(values, [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
  return values;
}

double Largest(const Eigen::MatrixXd& jacobian) {
  return jacobian.eigenvalues().cwiseAbs().maxCoeff();
}

// Whether deviations die out, for certain: differences are wrong by about their step's square, and
// where that does not decide, by what another step makes of them.
bool IsStable(Shooting& shooting, const Shooting::End& end, double map_error) {
  const double largest = Largest(end.jacobian);
  if (largest < 1 - 10 * std::pow(map_error, 2.0 / 3)) return true;
  if (!(largest < 1)) return false;
  const std::optional<Eigen::MatrixXd> again = shooting.Jacobian(end.point, 3);
  return again && largest < 1 - 10 * std::abs(Largest(*again) - largest);
}

// A motion of k periods that has no shorter one.
std::optional<PeriodicMotion> Shoot(CountedMap& map, const PeriodPoint& from, int periods,
                                    int newton_steps) {
  const Eigen::VectorXd scale = map.ScaleOf(from);
  Shooting shooting(map, periods, scale);
  std::optional<Shooting::End> end = shooting.From(from, newton_steps);
  if (!end) return {};
  if (periods > 1) {
    const std::optional<double> apart = shooting.ReturnsWithin(end->point, periods / 2);
    if (apart && *apart <= kSame * map.error()) return {};
  }
  std::expected<PeriodStep, std::string_view> whole = map.After(end->point, periods, true);
  if (!whole) return {};
  const Eigen::VectorXd apart = (end->point.x - from.x).cwiseQuotient(scale);
  const bool stable = IsStable(shooting, *end, map.error());
  PeriodicMotion motion{.drive_periods = periods,
                        .point = std::move(end->point),
                        .multipliers = LargestFirst(end->jacobian.eigenvalues()),
                        .stable = stable,
                        .residual = end->residual,
                        .from_transient = apart.cwiseAbs().maxCoeff(),
                        .means = std::move(*whole->means)};
  return motion;
}

}  // namespace

PeriodicSearch FindPeriodicMotion(const PeriodMap& map, const PeriodPoint& start,
                                  const PeriodicSettings& settings) {
  PeriodicSearch search;
  CountedMap counted(map, settings.most_steps, search);
  PeriodPoint point = start;
  int transient = settings.transient_periods;
  for (int round = 0; round < kTransients; ++round, transient *= 2) {
    std::expected<PeriodStep, std::string_view> end = counted.After(point, transient);
    if (!end) {
      search.tried +=
          fmt::format("the motion stalls within {} periods: {}", transient, end.error());
      return search;
    }
    point = std::move(end->point);
    for (const int periods : kPeriods) {
      std::optional<PeriodicMotion> motion = Shoot(counted, point, periods, settings.newton_steps);
      if (motion && motion->stable) {
        search.found = std::move(motion);
        return search;
      }
      if (motion && !search.found) search.found = std::move(motion);
    }
    search.tried += fmt::format("{}{} periods of transient, then Newton for 1, 2 and 4",
                                round > 0 ? "; " : "", transient);
    if (counted.IsSpent()) {
      search.tried += fmt::format("; no more after {} steps", search.steps);
      break;
    }
  }
  return search;
}

}  // namespace haptometer::sim
