#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "trial/time_base.h"
#include "trial/time_lines.h"

namespace haptometer::trial {
namespace {

constexpr double kWindowNs = 0.1 * kNsPerSecond;
constexpr std::size_t kLeastWindowRows = 16;
constexpr std::size_t kWindowsBehind = 5;  // what a rise is measured against
constexpr std::size_t kWindowsAhead = 10;  // a rise must outlast these, or all up to the end
constexpr std::size_t kLeastWindowsAhead = 2;
constexpr std::size_t kWindowsForARate = 10;  // shorter stretches take the common rate
constexpr double kSurelyAPauseNs = 0.25 * kNsPerSecond;
constexpr double kScatters = 3;
constexpr double kSigmaPerMad = 1.4826;    // of a normal distribution
constexpr double kSigmaOfMedian = 1.2533;  // sqrt(pi / 2), against that of the mean

// durations of the whole windows of `rows` rows
std::vector<double> WindowDurations(Times times, std::size_t rows) {
  std::vector<double> durations;
  for (std::size_t end = rows; end < times.size(); end += rows) {
    durations.push_back(times[end] - times[end - rows]);
  }
  return durations;
}

// rows in a window: enough to last 0.1 s, in most windows, so that each sees several bursts
std::size_t WindowRows(Times times) {
  std::size_t rows = kLeastWindowRows;
  while (times.size() / rows >= 8 && Median(WindowDurations(times, rows)) < kWindowNs) rows *= 2;
  return rows;
}

// least of t_j - j * period in each window; the last one takes the remaining rows
std::vector<double> Levels(Times times, double period_ns, std::size_t window_rows) {
  std::vector<double> levels(std::max<std::size_t>(1, times.size() / window_rows),
                             std::numeric_limits<double>::infinity());
  for (std::size_t j = 0; j < times.size(); ++j) {
    double& level = levels[std::min(j / window_rows, levels.size() - 1)];
    level = std::min(level, times[j] - AsDouble(j) * period_ns);
  }
  return levels;
}

// each value becomes the least of itself and the next count - 1
std::vector<double> RunningLeast(const std::vector<double>& values, std::size_t count) {
  std::vector<double> least;
  for (std::size_t k = 0; k + count <= values.size(); ++k) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(k);
    least.push_back(*std::min_element(first, first + static_cast<std::ptrdiff_t>(count)));
  }
  return least;
}

// What the minima rise by from window to window. Differences over `lag` windows are the least
// noisy, but where lines are lost more often than that, each of them holds a loss; then most of
// those between neighbours do not.
double RisePerWindow(const std::vector<double>& levels, std::size_t lag, double period_ns) {
  const double over_lag = Median(Differences(levels, lag)) / AsDouble(lag);
  std::vector<double> steps = Differences(levels, 1);
  if (steps.empty()) return over_lag;
  const double step = Median(steps);
  for (double& deviation : steps) deviation = std::abs(deviation - step);
  const double uncertainty =
      kSigmaOfMedian * kSigmaPerMad * Median(steps) / std::sqrt(AsDouble(steps.size()));
  const bool holds_losses =
      (over_lag - step) * AsDouble(lag) > 0.5 * period_ns && over_lag - step > 5 * uncertainty;
  return holds_losses ? step : over_lag;
}

// A period that neither bursts nor a few gaps disturb: medians over windows. The lag of up to ten
// windows keeps the noise of the minima small; a loss spoils only the differences across it. Then
// once more on the minima over three windows, which are much less noisy once the slope is nearly
// right.
double RobustPeriod(Times times, std::size_t window_rows) {
  const auto durations = WindowDurations(times, window_rows);
  if (durations.empty()) {
    return Median(Differences(std::vector<double>(times.begin(), times.end()), 1));
  }
  double period_ns = Median(durations) / AsDouble(window_rows);
  for (const std::size_t count : {1U, 3U}) {
    const auto levels = RunningLeast(Levels(times, period_ns, window_rows), count);
    const std::size_t lag = std::clamp<std::size_t>(levels.size() / 5, 1, 10);
    period_ns += RisePerWindow(levels, lag, period_ns) / AsDouble(window_rows);
  }
  return period_ns;
}

// the line below all points with the least sum of distances: the edge of the lower convex hull over
// the mean row. Computed on t_j - j * period (of any period near the true one), whose small numbers
// keep the digits.
Line LowerLine(Times times, double period_ns) {
  std::vector<std::pair<double, double>> hull;
  for (std::size_t j = 0; j < times.size(); ++j) {
    const double x = AsDouble(j);
    const double y = times[j] - x * period_ns;
    while (hull.size() >= 2) {
      const auto [x1, y1] = hull[hull.size() - 2];
      const auto [x2, y2] = hull.back();
      if ((y2 - y1) * (x - x1) < (y - y1) * (x2 - x1)) break;
      hull.pop_back();
    }
    hull.emplace_back(x, y);
  }
  const double mean_x = 0.5 * AsDouble(times.size() - 1);
  const auto right = std::ranges::find_if(hull, [&](const auto& p) { return p.first >= mean_x; });
  if (right == hull.begin()) return {right->second, period_ns};
  const auto [x1, y1] = *std::prev(right);
  const auto [x2, y2] = *right;
  const double slope = (y2 - y1) / (x2 - x1);
  return {y1 - slope * x1, period_ns + slope};
}

// The row at which a rise after window k - 1 begins. Rows below the new line surely came before the
// loss; from there to the first row on the new line it is the one with the largest interval.
std::size_t PlaceOfRise(Times times, double period_ns, std::size_t window_rows, std::size_t k,
                        double after_ns) {
  auto level = [&](std::size_t j) { return times[j] - AsDouble(j) * period_ns; };
  const double slack_ns = 0.5 * period_ns;
  std::size_t last_old = (k - 1) * window_rows;
  for (std::size_t j = last_old; j < k * window_rows; ++j) {
    if (level(j) < after_ns - slack_ns) last_old = j;
  }
  std::size_t best = last_old + 1;
  for (std::size_t j = best; j < times.size(); ++j) {
    if (times[j] - times[j - 1] > times[best] - times[best - 1]) best = j;
    if (level(j) < after_ns + slack_ns) break;
  }
  return best;
}

double LeastOf(const std::vector<double>& levels, std::size_t from, std::size_t count) {
  const auto first = levels.begin() + static_cast<std::ptrdiff_t>(from);
  return *std::min_element(first, first + static_cast<std::ptrdiff_t>(count));
}

// rows at which the lower envelope rises and stays up: lines were lost before them
std::vector<std::size_t> Rises(Times times, double period_ns, std::size_t window_rows) {
  const std::vector<double> levels = Levels(times, period_ns, window_rows);
  std::vector<double> sizes = Differences(levels, 1);
  for (double& size : sizes) size = std::abs(size);
  const double scatter_ns = kSigmaPerMad * Median(std::move(sizes));
  const double least_rise_ns = std::max(0.5 * period_ns, kScatters * scatter_ns);
  auto ahead_ns = [&](std::size_t k) {
    return LeastOf(levels, k, std::min(kWindowsAhead, levels.size() - k));
  };
  std::vector<std::size_t> rises;
  std::size_t begin = 0;
  for (std::size_t k = 1; k + kLeastWindowsAhead <= levels.size(); ++k) {
    const std::size_t behind = std::min(kWindowsBehind, k - begin);
    if (ahead_ns(k) - LeastOf(levels, k - behind, behind) <= least_rise_ns) continue;
    // a loss within a window may raise it in part and the next one in full: one rise
    while (k + 1 + kLeastWindowsAhead <= levels.size() &&
           ahead_ns(k + 1) - ahead_ns(k) > least_rise_ns) {
      ++k;
    }
    // near the place, a slope that is not quite right does not matter
    const std::size_t near = std::min<std::size_t>(3, levels.size() - k);
    rises.push_back(PlaceOfRise(times, period_ns, window_rows, k, LeastOf(levels, k, near)));
    begin = k;
  }
  return rises;
}

// rows after a pause that is too long for a stall and is not made up for
std::vector<std::size_t> Pauses(Times times, double period_ns) {
  std::vector<std::size_t> pauses;
  const double least_ns = std::max(kSurelyAPauseNs, 8 * period_ns);
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double pause_ns = times[i] - times[i - 1];
    if (pause_ns <= least_ns) continue;
    double after_ns = pause_ns;
    for (std::size_t j = i; j < times.size() && AsDouble(j - i) * period_ns < 2 * pause_ns; ++j) {
      after_ns = std::min(after_ns, times[j] - times[i - 1] - AsDouble(j - i + 1) * period_ns);
    }
    if (after_ns > 0.5 * pause_ns) pauses.push_back(i);
  }
  return pauses;
}

// what `find` finds in each piece, as rows of the recording, beside the pieces' own beginnings
template <typename Find>
std::vector<std::size_t> StartsIn(Times times, const std::vector<Piece>& pieces, const Find& find) {
  std::vector<std::size_t> starts;
  for (const Piece& piece : pieces) {
    starts.push_back(piece.first);
    for (const std::size_t row : find(times.subspan(piece.first, piece.rows()))) {
      starts.push_back(piece.first + row);
    }
  }
  return starts;
}

const Piece& Longest(const std::vector<Piece>& pieces) {
  return *std::ranges::max_element(pieces, {}, &Piece::rows);
}

Line LowerLineOf(Times times, const Piece& piece, double period_ns) {
  return LowerLine(times.subspan(piece.first, piece.rows()), period_ns);
}

// the stretches' rows, and the period that the longest of them shows
struct Cut {
  std::vector<Piece> pieces;
  double period_ns = 0;
};

Cut CutAtLosses(Times times, std::span<const std::size_t> breaks, std::size_t window_rows) {
  double period_ns = RobustPeriod(times, window_rows);
  const auto known =
      PiecesBetween(times.size(), std::vector<std::size_t>(breaks.begin(), breaks.end()));
  const auto sure = PiecesBetween(
      times.size(), StartsIn(times, known, [&](Times t) { return Pauses(t, period_ns); }));
  // twice, because many losses blur the period that they are looked for with
  std::vector<Piece> pieces;
  for (int turn = 0; turn < 2; ++turn) {
    pieces = PiecesBetween(times.size(), StartsIn(times, sure, [&](Times t) {
                             return Rises(t, period_ns, window_rows);
                           }));
    const Piece& longest = Longest(pieces);
    period_ns = RobustPeriod(times.subspan(longest.first, longest.rows()), window_rows);
  }
  period_ns = LowerLineOf(times, Longest(pieces), period_ns).period_ns;
  return {std::move(pieces), period_ns};
}

// one period for pieces too short to tell their own: the longest piece's, else the nominal one
std::optional<double> CommonPeriod(const Cut& cut, std::size_t window_rows,
                                   std::optional<double> nominal_rate_hz) {
  if (Longest(cut.pieces).rows() >= 2 * window_rows) return cut.period_ns;
  if (nominal_rate_hz && *nominal_rate_hz > 0) return kNsPerSecond / *nominal_rate_hz;
  return std::nullopt;
}

Line FitPiece(Times part, std::size_t window_rows, std::optional<double> common_period_ns) {
  if (part.size() < kWindowsForARate * window_rows && common_period_ns) {
    // the period is given, so only the least delay is looked for
    return {Levels(part, *common_period_ns, part.size()).front(), *common_period_ns};
  }
  return LowerLine(part, common_period_ns.value_or(0));
}

// scatter of the window minima about the line; by the median, so that a stall does not count
double Scatter(Times part, const Line& line, std::size_t window_rows) {
  auto levels = Levels(part, line.period_ns, part.size() < 2 * window_rows ? 1 : window_rows);
  const double middle = Median(levels);
  for (double& level : levels) level = std::abs(level - middle);
  return kSigmaPerMad * Median(std::move(levels));
}

}  // namespace

std::vector<Stretch> FitArrivalTimes(std::span<const std::int64_t> time_ns,
                                     std::optional<double> nominal_rate_hz,
                                     std::span<const std::size_t> breaks) {
  if (time_ns.empty()) return {};
  const std::vector<double> times = SinceFirst(time_ns);
  const std::size_t window_rows = WindowRows(times);
  const Cut cut = CutAtLosses(times, breaks, window_rows);
  const auto common_period_ns = CommonPeriod(cut, window_rows, nominal_rate_hz);
  std::vector<Stretch> stretches;
  for (const Piece& piece : cut.pieces) {
    const Times part = Times(times).subspan(piece.first, piece.rows());
    const Line line = FitPiece(part, window_rows, common_period_ns);
    const double start_ns = static_cast<double>(time_ns.front()) + line.start_ns;
    stretches.push_back({.first_row = piece.first,
                         .rows = piece.rows(),
                         .start_s = start_ns / kNsPerSecond,
                         .rate_hz = RateOf(line.period_ns),
                         .time_uncertainty_s = Scatter(part, line, window_rows) / kNsPerSecond});
  }
  return stretches;
}

}  // namespace haptometer::trial
