#include "dsp/readings/regular_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/median.h"
#include "dsp/readings/row_block.h"

namespace haptometer::dsp {
namespace {

constexpr double kFarthestPeriods = 0.45;  // beyond this a time may belong to the next place
constexpr double kFollowed = 1.0 / 16;     // of each reading's distance, by the grid's start
// bound, as a part of a tone's amplitude, at which no further points are added
constexpr double kNegligibleError = 1e-6;
// numbers of nodes that are tried, from the cheapest
constexpr std::array<std::size_t, 4> kPoints{4, 8, 12, 16};
constexpr std::size_t kMostPoints = kPoints.back();

// places of the rows on a grid, and the grid
struct Places {
  std::vector<std::int64_t> place{};   // of each row, growing
  std::vector<std::size_t> reading{};  // of each row: the one that it is of, or the nearest in time
  double start_s = 0;
  double period_s = 0;
  // of the times about a grid that follows them: standard deviation and largest
  double followed_jitter_s = 0;
  double followed_largest_s = 0;

  [[nodiscard]] double TimeOf(std::int64_t n) const {
    return start_s + static_cast<double>(n) * period_s;
  }
};

// a robust period: dropped readings change a median little
double MedianInterval(std::span<const double> times_s) {
  std::vector<double> intervals;
  intervals.reserve(times_s.size());
  for (std::size_t j = 1; j < times_s.size(); ++j) intervals.push_back(times_s[j] - times_s[j - 1]);
  return UpperMedian(std::move(intervals));
}

// the least-squares line of the times over their places
void FitLine(std::span<const double> times_s, Places& places) {
  const auto n = static_cast<double>(times_s.size());
  // about the means, with times relative to the first, so that large times cost no digits
  double mean_place = 0;
  double mean_s = 0;  // of what the times are past the first
  for (std::size_t j = 0; j < times_s.size(); ++j) {
    mean_place += static_cast<double>(places.place[j]) / n;
    mean_s += (times_s[j] - times_s[0]) / n;
  }
  double xt = 0;
  double xx = 0;
  for (std::size_t j = 0; j < times_s.size(); ++j) {
    const double x = static_cast<double>(places.place[j]) - mean_place;
    xt += x * (times_s[j] - times_s[0] - mean_s);
    xx += x * x;
  }
  places.period_s = xt / xx;
  places.start_s = times_s[0] + mean_s - mean_place * places.period_s;
}

// the places where no reading was dropped
Places CountedPlaces(std::span<const double> times_s) {
  Places places{.place = std::vector<std::int64_t>(times_s.size()),
                .reading = std::vector<std::size_t>(times_s.size())};
  std::iota(places.place.begin(), places.place.end(), 0);
  std::iota(places.reading.begin(), places.reading.end(), 0UZ);
  FitLine(times_s, places);
  places.followed_largest_s = std::numeric_limits<double>::infinity();
  return places;
}

// Places on a grid that follows the readings: each takes the one nearest to its time, behind that
// of the reading before. Behind a long gap the grid begins again. Where most times repeat there is
// no period to follow.
Places FollowedPlaces(std::span<const double> times_s) {
  const double period_s = MedianInterval(times_s);
  if (!(period_s > 0)) return CountedPlaces(times_s);
  Places places{.reading = std::vector<std::size_t>(times_s.size())};
  std::iota(places.reading.begin(), places.reading.end(), 0UZ);
  places.place.reserve(times_s.size());
  places.place.push_back(0);
  double start_s = times_s[0];
  double square_sum = 0;
  for (std::size_t j = 1; j < times_s.size(); ++j) {
    const double last_s = start_s + static_cast<double>(places.place.back()) * period_s;
    const double periods = std::clamp((times_s[j] - last_s) / period_s, 1.0, 1e15);
    places.place.push_back(places.place.back() + std::llround(periods));
    const double at_s = start_s + static_cast<double>(places.place.back()) * period_s;
    const double off_s = times_s[j] - at_s;
    const bool begins_again = periods * kFollowed > 1;
    start_s += (begins_again ? 1 : kFollowed) * off_s;
    // what a clock went away within a gap is no jitter
    if (begins_again) continue;
    square_sum += off_s * off_s;
    places.followed_largest_s = std::max(places.followed_largest_s, std::abs(off_s));
  }
  places.followed_jitter_s = std::sqrt(square_sum / static_cast<double>(times_s.size() - 1));
  FitLine(times_s, places);
  return places;
}

// The places of an even grid of the line's period from the first time on, of a clock that drifts
// away from any: rows are taken where a reading lies within a period, whichever it is.
Places DriftingPlaces(std::span<const double> times_s, const Places& followed) {
  Places places{.start_s = times_s[0],
                .period_s = followed.period_s,
                .followed_jitter_s = followed.followed_jitter_s,
                .followed_largest_s = followed.followed_largest_s};
  const auto place_of = [&](double time_s) {
    return static_cast<std::int64_t>(std::llround((time_s - places.start_s) / places.period_s));
  };
  const std::int64_t last = place_of(times_s.back());
  std::size_t j = 0;
  for (std::int64_t n = 0; n <= last; ++n) {
    const double at_s = places.TimeOf(n);
    while (j + 1 < times_s.size() && std::abs(times_s[j + 1] - at_s) <= std::abs(times_s[j] - at_s))
      ++j;
    if (std::abs(times_s[j] - at_s) <= places.period_s) {
      places.place.push_back(n);
      places.reading.push_back(j);
    } else if (j + 1 < times_s.size()) {
      // on to the places before the gap's end
      n = std::max(n, place_of(times_s[j + 1]) - 2);
    }
  }
  return places;
}

// standard deviation and largest distance of the times from the line, and places without a reading
RegularGrid Described(std::span<const double> times_s, const Places& places) {
  RegularGrid grid;
  double square_sum = 0;
  for (std::size_t j = 0; j < times_s.size(); ++j) {
    const double jitter_s = times_s[j] - places.TimeOf(places.place[j]);
    square_sum += jitter_s * jitter_s;
    grid.largest_jitter_s = std::max(grid.largest_jitter_s, std::abs(jitter_s));
  }
  const auto n = static_cast<double>(times_s.size());
  grid.jitter_s = std::sqrt(square_sum / (n - 2));
  grid.rate_hz = 1 / places.period_s;
  grid.readings = times_s.size();
  grid.dropped = static_cast<std::size_t>(places.place.back()) + 1 - times_s.size();
  return grid;
}

// readings that are measured
struct Readings {
  std::vector<double> times_s;
  std::vector<double> values;
  std::vector<std::size_t> rank;  // of each reading: how many measured ones precede it
};

Readings MeasuredOf(const trial::Channel& channel, std::span<const double> times_s) {
  Readings readings;
  readings.times_s.reserve(times_s.size());
  readings.values.reserve(times_s.size());
  for (std::size_t j = 0; j < times_s.size(); ++j) {
    readings.rank.push_back(readings.times_s.size());
    if (!IsMeasured(channel.values[j], channel.statuses[j])) continue;
    readings.times_s.push_back(times_s[j]);
    readings.values.push_back(channel.values[j]);
  }
  return readings;
}

// first of the `points` readings nearest to reading `j`, moved inwards at the ends
std::size_t FirstOf(std::size_t j, std::size_t points, std::size_t size) {
  return std::min(j - std::min(j, points / 2), size - points);
}

// Cauchy's remainder for a tone of amplitude 1: w^m / m! product of |t - t_k|
double Remainder(std::span<const double> nodes_s, double at_s, double omega) {
  double product = 1;
  double factor = 0;
  for (const double node_s : nodes_s) product *= omega * std::abs(at_s - node_s) / ++factor;
  return product;
}

// Neville's scheme: the polynomial through all nodes at `at_s`
double Neville(std::span<const double> nodes_s, std::span<const double> values, double at_s) {
  std::array<double, kMostPoints> p;
  std::ranges::copy(values, p.begin());
  for (std::size_t step = 1; step < nodes_s.size(); ++step) {
    for (std::size_t k = 0; k + step < nodes_s.size(); ++k) {
      p[k] += (at_s - nodes_s[k]) * (p[k + 1] - p[k]) / (nodes_s[k + step] - nodes_s[k]);
    }
  }
  return p[0];
}

// interpolates one channel of jittered readings at the rows' places
class Interpolator {
 public:
  Interpolator(const trial::Channel& channel, std::span<const double> times_s, const Places& places,
               double omega)
      : channel_(channel),
        places_(places),
        omega_(omega),
        readings_(MeasuredOf(channel, times_s)) {}

  [[nodiscard]] std::size_t readings() const { return readings_.times_s.size(); }

  // bounds of the error at all measured rows
  [[nodiscard]] std::vector<double> Bounds(std::size_t points) const {
    std::vector<double> bounds;
    bounds.reserve(readings());
    ForEachMeasured([&](std::size_t row, std::size_t j) {
      const double at_s = places_.TimeOf(places_.place[row]);
      bounds.push_back(Remainder(Nodes(j, points), at_s, omega_));
    });
    return bounds;
  }

  // values at the places of the rows; NaN where there is none or its bound is too large
  [[nodiscard]] std::vector<double> Values(std::size_t points, RegularGrid& grid) const {
    std::vector<double> values(places_.place.size(), std::numeric_limits<double>::quiet_NaN());
    ForEachMeasured([&](std::size_t row, std::size_t j) {
      const double at_s = places_.TimeOf(places_.place[row]);
      const std::span<const double> nodes_s = Nodes(j, points);
      const double bound = Remainder(nodes_s, at_s, omega_);
      if (bound > kLargestInterpolationError) {
        ++grid.left_out;
        return;
      }
      grid.error_bound = std::max(grid.error_bound, bound);
      const std::size_t first = FirstOf(j, points, readings());
      values[row] = Neville(nodes_s, std::span(readings_.values).subspan(first, points), at_s);
    });
    return values;
  }

 private:
  [[nodiscard]] std::span<const double> Nodes(std::size_t j, std::size_t points) const {
    return std::span(readings_.times_s).subspan(FirstOf(j, points, readings()), points);
  }

  template <typename Visit>
  void ForEachMeasured(const Visit& visit) const {
    for (std::size_t row = 0; row < places_.place.size(); ++row) {
      const std::size_t j = places_.reading[row];
      if (IsMeasured(channel_.values[j], channel_.statuses[j])) visit(row, readings_.rank[j]);
    }
  }

  const trial::Channel& channel_;
  const Places& places_;
  double omega_;
  Readings readings_;
};

// the bound that nine of ten rows keep
double UsualBound(std::vector<double> bounds) {
  const auto most = bounds.begin() + static_cast<std::ptrdiff_t>(bounds.size() * 9 / 10);
  std::ranges::nth_element(bounds, most);
  return *most;
}

// the least number of points with a negligible bound, or that with the least bound
std::size_t PointsFor(const Interpolator& interpolator) {
  std::size_t best = kPoints.front();
  double best_bound = std::numeric_limits<double>::infinity();
  for (const std::size_t points : kPoints) {
    if (points > interpolator.readings()) break;
    const double bound = UsualBound(interpolator.Bounds(points));
    if (bound < best_bound) {
      best = points;
      best_bound = bound;
    }
    if (bound < kNegligibleError) break;
  }
  return best;
}

// statuses of the rows' readings, and their values on the grid
trial::Channel OnPlaces(const trial::Channel& channel, const Places& places,
                        std::vector<double> values) {
  trial::Channel placed = channel;
  placed.values = std::move(values);
  placed.statuses.clear();
  for (const std::size_t j : places.reading) placed.statuses.push_back(channel.statuses[j]);
  return placed;
}

// one row per place with a reading; a stretch ends where places are without one
void LayOut(const Places& places, RegularGrid& grid) {
  trial::Record& record = grid.record;
  record.rows = places.place.size();
  for (std::size_t row = 0; row < record.rows; ++row) {
    if (row == 0 || places.place[row] != places.place[row - 1] + 1) {
      record.stretches.push_back({row, 0, places.TimeOf(places.place[row]), grid.rate_hz, 0});
    }
    ++record.stretches.back().rows;
  }
}

RegularGrid Refused(FindingKind kind, std::vector<FindingNumber> numbers) {
  RegularGrid none;
  none.refusal = {.severity = Severity::kRefusal, .kind = kind, .numbers = std::move(numbers)};
  return none;
}

}  // namespace

RegularGrid OnRegularGrid(const trial::Record& record, double upper_hz) {
  HAPTOMETER_CHECK(record.times_are_known && record.raw_times_s.size() == record.rows,
                   "{} times of {} rows", record.raw_times_s.size(), record.rows);
  if (record.rows < kPoints.front()) {
    return Refused(FindingKind::kFewUnevenTimes, {{"rows", record.rows}});
  }
  const std::span<const double> times_s = record.raw_times_s;
  Places places = FollowedPlaces(times_s);
  RegularGrid grid = Described(times_s, places);
  // without dropped readings, where that leaves less jitter
  Places counted = CountedPlaces(times_s);
  RegularGrid without_drops = Described(times_s, counted);
  if (without_drops.jitter_s < grid.jitter_s) {
    places = std::move(counted);
    grid = std::move(without_drops);
  }
  // a clock that drifts: from any even grid its times go away, from one that follows them they do
  // not
  const double farthest_s = kFarthestPeriods * places.period_s;
  if (grid.largest_jitter_s > farthest_s && places.followed_largest_s <= farthest_s) {
    places = DriftingPlaces(times_s, places);
    grid.drift_s = grid.largest_jitter_s;
    grid.jitter_s = places.followed_jitter_s;
    grid.largest_jitter_s = places.followed_largest_s;
  }
  // times too far from any grid cannot be assigned to places
  if (!(places.period_s > 0 && grid.largest_jitter_s <= farthest_s)) {
    return Refused(FindingKind::kTimesTooUneven, {{"jitter_s", grid.jitter_s},
                                                  {"grid_s", 1 / grid.rate_hz},
                                                  {"largest_jitter_s", grid.largest_jitter_s}});
  }

  grid.record.metadata = record.metadata;
  LayOut(places, grid);
  grid.record.channels.reserve(record.channels.size());
  // each channel has its own unmeasured rows, so its own nodes and number of points
  for (const trial::Channel& channel : record.channels) {
    const Interpolator interpolator(channel, times_s, places, 2 * std::numbers::pi * upper_hz);
    std::vector<double> values(grid.record.rows, std::numeric_limits<double>::quiet_NaN());
    if (interpolator.readings() >= kPoints.front()) {
      grid.points = PointsFor(interpolator);
      const std::size_t left_out_before = grid.left_out;
      values = interpolator.Values(grid.points, grid);
      // more than half of the rows beyond the bound: the readings do not determine the motion
      if (2 * (grid.left_out - left_out_before) > interpolator.readings()) {
        return Refused(FindingKind::kReadingsTooFarApart,
                       {{"upper_hz", upper_hz}, {"readings_per_s", grid.rate_hz}});
      }
    }
    grid.record.channels.push_back(OnPlaces(channel, places, std::move(values)));
  }
  return grid;
}

Result<RegularGrid> OnRegularGrid(const trial::RowSource& source, double upper_hz) {
  HAPTOMETER_LET(const auto record, trial::ReadAllRows(source));
  return OnRegularGrid(record, upper_hz);
}

}  // namespace haptometer::dsp
