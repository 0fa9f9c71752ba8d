#include "fit/calibration/outliers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "dsp/statistics/distributions.h"

namespace haptometer::fit {
namespace {

using Places = std::vector<std::size_t>;

// largest number of outliers
std::size_t MostOf(std::size_t points) { return std::min<std::size_t>(3, points / 2 - 1); }

std::vector<LinePoint> PointsAt(std::span<const LinePoint> points, const Places& places) {
  std::vector<LinePoint> found;
  found.reserve(places.size());
  for (const std::size_t i : places) found.push_back(points[i]);
  return found;
}

double VarianceOf(const LinePoint& point, double slope) {
  return point.y_uncertainty * point.y_uncertainty +
         slope * slope * point.x_uncertainty * point.x_uncertainty;
}

double DistanceOf(const LinePoint& point, const StraightLine& line) {
  return point.y - line.intercept - line.slope * point.x;
}

double ShareOf(const LinePoint& point, const StraightLine& line) {
  const double distance = DistanceOf(point, line);
  return distance * distance / VarianceOf(point, line.slope);
}

// the `count` points that are nearest to a line, in their order
Places NearestTo(std::span<const LinePoint> points, const StraightLine& line, std::size_t count) {
  Places places(points.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  std::ranges::sort(places, {}, [&](std::size_t i) { return ShareOf(points[i], line); });
  places.resize(count);
  std::ranges::sort(places);
  return places;
}

// lines through two points each; of many points through 12 of them, most of which are no outliers
std::vector<StraightLine> LinesThroughTwo(std::span<const LinePoint> points) {
  constexpr std::size_t kFewPoints = 40, kOfMany = 12;
  const std::size_t step = points.size() <= kFewPoints ? 1 : points.size() / kOfMany;
  std::vector<StraightLine> lines;
  for (std::size_t i = 0; i < points.size(); i += step) {
    for (std::size_t j = i + step; j < points.size(); j += step) {
      const double slope = (points[j].y - points[i].y) / (points[j].x - points[i].x);
      if (!std::isfinite(slope) || slope == 0) continue;
      lines.push_back({.slope = slope, .intercept = points[i].y - slope * points[i].x});
    }
  }
  return lines;
}

// the `count` points of least weighted squares about their line; empty where none was found
Places LeastTrimmed(std::span<const LinePoint> points, std::size_t count) {
  Places best;
  double least = std::numeric_limits<double>::infinity();
  std::set<Places> seen;
  for (StraightLine line : LinesThroughTwo(points)) {
    // until the line keeps the points that it is of
    for (Places places = NearestTo(points, line, count); seen.insert(places).second;
         places = NearestTo(points, line, count)) {
      auto fit = FitStraightLine(PointsAt(points, places), Scatter::kFromResiduals);
      if (!fit) break;
      line = *std::move(fit);
      double squares = 0;
      for (const std::size_t i : places) squares += ShareOf(points[i], line);
      if (squares >= least) continue;
      least = squares;
      best = places;
    }
  }
  return best;
}

// whether the scatter of the others gives the uncertainty; else it is as stated
bool IsScaled(const StraightLine& others, Scatter scatter) {
  return scatter == Scatter::kFromResiduals || others.is_beyond_stated;
}

// |t| of a point's distance from the line of the others
double DistanceInT(const LinePoint& point, const StraightLine& others, Scatter scatter) {
  const double own = (IsScaled(others, scatter) ? others.birge_ratio : 1) *
                     std::sqrt(VarianceOf(point, others.slope));
  const double uncertainty = std::hypot(own, others.UncertaintyAt(point.x));
  const double distance = std::abs(DistanceOf(point, others));
  // of exact points: any distance
  return uncertainty > 0 ? distance / uncertainty : distance > 0 ? HUGE_VAL : 0;
}

// whether noise takes any of `count` points so far with a probability below `level`
bool IsFar(double t, const StraightLine& others, std::size_t count, Scatter scatter, double level) {
  constexpr double kManyDegrees = 1e6;
  if (!std::isfinite(t)) return true;
  const double freedom = IsScaled(others, scatter) ? others.degrees_of_freedom : kManyDegrees;
  return static_cast<double>(count) * dsp::StudentTwoSidedP(t, freedom) < level;
}

// whether a distance matters, where the others lie on a line but for rounding
bool IsLarge(const LinePoint& point, const StraightLine& others,
             const std::vector<LinePoint>& kept) {
  constexpr double kLeastShare = 1e-3;
  const auto [least, most] = std::ranges::minmax(kept, {}, &LinePoint::y);
  return std::abs(DistanceOf(point, others)) > kLeastShare * (most.y - least.y);
}

Outliers OutliersOf(std::span<const LinePoint> points, const Places& left, StraightLine others,
                    std::vector<LinePoint> kept) {
  Outliers found;
  for (const std::size_t i : left) found.points.push_back({i, DistanceOf(points[i], others)});
  double squares = 0;
  for (const double residual : others.residuals) squares += residual * residual;
  found.scatter = std::sqrt(squares / static_cast<double>(kept.size()));
  found.others = std::move(others);
  found.kept = std::move(kept);
  return found;
}

}  // namespace

std::optional<Outliers> FindOutliers(std::span<const LinePoint> points, Scatter scatter) {
  constexpr std::size_t kLeastPoints = 4;
  if (points.size() < kLeastPoints) return std::nullopt;
  const std::size_t most = MostOf(points.size());
  Places inside = LeastTrimmed(points, points.size() - most);
  if (inside.empty()) return std::nullopt;
  Places left;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!std::ranges::binary_search(inside, i)) left.push_back(i);
  }
  const double level = kOutlierByChance / static_cast<double>(most);
  while (!left.empty()) {
    std::vector<LinePoint> kept = PointsAt(points, inside);
    auto others = FitStraightLine(kept, scatter);
    if (!others) return std::nullopt;
    const auto nearest = std::ranges::min_element(
        left, {}, [&](std::size_t i) { return DistanceInT(points[i], *others, scatter); });
    const LinePoint& point = points[*nearest];
    const double t = DistanceInT(point, *others, scatter);
    if (IsLarge(point, *others, kept) && IsFar(t, *others, inside.size() + 1, scatter, level)) {
      return OutliersOf(points, left, *std::move(others), std::move(kept));
    }
    // it is one of the others
    inside.insert(std::ranges::upper_bound(inside, *nearest), *nearest);
    left.erase(nearest);
  }
  return std::nullopt;
}

}  // namespace haptometer::fit
