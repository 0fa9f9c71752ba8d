#include "trial/time_base.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/mapped.h"
#include "base/median.h"

/// What the fits of arrival times and of polled times share. All times are nanoseconds since the
/// first row, as doubles: exact below 2^53 ns = 104 days.
namespace haptometer::trial {
namespace {

constexpr double kNsPerSecond = 1e9;

using Times = std::span<const double>;

// Rows [first, end) of a recording
struct Piece {
  std::size_t first = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t rows() const { return end - first; }
};

// Time of row j of a piece: start_ns + j * period_ns
struct Line {
  double start_ns = 0;
  double period_ns = 0;
};

double AsDouble(std::size_t n) { return static_cast<double>(n); }

// values[k] - values[k - lag]
std::vector<double> Differences(const std::vector<double>& values, std::size_t lag) {
  std::vector<double> differences;
  for (std::size_t k = lag; k < values.size(); ++k) {
    differences.push_back(values[k] - values[k - lag]);
  }
  return differences;
}

// the pieces of `rows` rows that begin at 0 and at `starts`, in any order and number
std::vector<Piece> PiecesBetween(std::size_t rows, std::vector<std::size_t> starts) {
  std::ranges::sort(starts);
  std::vector<Piece> pieces{{0, rows}};
  for (const std::size_t row : starts) {
    if (row <= pieces.back().first || row >= rows) continue;
    pieces.back().end = row;
    pieces.push_back({row, rows});
  }
  return pieces;
}

// rows per second; infinite where all rows have one time
double RateOf(double period_ns) {
  return period_ns > 0 ? kNsPerSecond / period_ns : std::numeric_limits<double>::infinity();
}

// times in ns after the first row
std::vector<double> SinceFirst(std::span<const std::int64_t> time_ns) {
  return Mapped<double>(time_ns, [&](const std::int64_t t) {
    return static_cast<double>(t) - static_cast<double>(time_ns.front());
  });
}

}  // namespace

void UniformGrid::Append(std::int64_t first_index, std::size_t rows) {
  // a jump of the index means lost rows: a new segment begins at first_index / rate
  if (stretches_.empty() || first_index != next_index_) {
    stretches_.push_back({.first_row = rows_,
                          .rows = 0,
                          .start_s = static_cast<double>(first_index) / rate_hz_,
                          .rate_hz = rate_hz_,
                          .time_uncertainty_s = 0});
  }
  stretches_.back().rows += rows;
  rows_ += rows;
  next_index_ = first_index + static_cast<std::int64_t>(rows);
}

namespace {

// minima of the delays are formed over 0.1 s, or over 16 rows of a slow source
constexpr double kWindowNs = 0.1 * kNsPerSecond;
constexpr std::size_t kLeastWindowRows = 16;
constexpr std::size_t kLeastCounts = 3;    // windows that show a rate
constexpr std::size_t kWindowsBehind = 5;  // what a rise is measured against
constexpr std::size_t kWindowsAhead = 10;  // a rise must outlast these, or all up to the end
constexpr std::size_t kLeastWindowsAhead = 2;
constexpr std::size_t kWindowsForARate = 10;  // shorter segments take the common rate
// a longer silence that no later rows make up for is a gap, wherever it is
constexpr double kSurelyAPauseNs = 0.25 * kNsPerSecond;
constexpr double kCatchingUp = 0.75;  // of the time that the rows took at the source
// a rise exceeds this many standard deviations of the window minima
constexpr double kScatters = 3;
constexpr double kSigmaOfMedian = 1.2533;  // sqrt(pi / 2), against that of the mean

// Rows with their places on the source's grid: the row's number and the losses known before it.
struct Rows {
  Times times;
  Times places;

  [[nodiscard]] std::size_t size() const { return times.size(); }
  [[nodiscard]] Rows Of(const Piece& piece) const {
    return {times.subspan(piece.first, piece.rows()), places.subspan(piece.first, piece.rows())};
  }
  // how late row j is against a line of this period; the zero is arbitrary
  [[nodiscard]] double Level(std::size_t j, double period_ns) const {
    return times[j] - (places[j] - places[0]) * period_ns;
  }
};

// rows [first, end), and the least of their levels
struct Window {
  std::size_t first = 0;
  std::size_t end = 0;
  double level_ns = 0;
};

// median of the intervals between neighbouring rows, ns
double MedianInterval(const Rows& rows) {
  return UpperMedian(Differences(std::vector<double>(rows.times.begin(), rows.times.end()), 1));
}

// A period from how many rows came in each window of time, to some percent. A stall leaves windows
// empty, and all that waited comes in the one behind them: only windows between two others with
// rows count. Nothing where there are too few.
std::optional<double> PeriodByCounts(const Rows& rows) {
  // a damaged file may hold any times
  const auto [first, last] = std::ranges::minmax(rows.times);
  const double span_ns = last - first;
  if (span_ns <= 0) return std::nullopt;
  // a window lasts 0.1 s, or 16 mean intervals of a slow source
  const double mean_ns = span_ns / AsDouble(rows.size());
  const double window_ns = std::max(kWindowNs, AsDouble(kLeastWindowRows) * mean_ns);
  std::vector<double> counts(static_cast<std::size_t>(span_ns / window_ns) + 1);
  for (const double time_ns : rows.times) {
    ++counts[static_cast<std::size_t>((time_ns - first) / window_ns)];
  }
  // counts of windows whose neighbours hold rows too: no stall, no rows that catch up
  std::vector<double> usual;
  for (std::size_t k = 1; k + 1 < counts.size(); ++k) {
    if (counts[k - 1] > 0 && counts[k] > 0 && counts[k + 1] > 0) usual.push_back(counts[k]);
  }
  if (usual.size() < kLeastCounts) return std::nullopt;
  // period = window length / median count
  return window_ns / UpperMedian(std::move(usual));
}

// The period of a source that was silent for more than half of the time: that of the second halves
// of what lies between silences of more than 0.25 s, the median by time. Whatever waited during a
// stall of the host came in the first halves. Nothing of other sources.
std::optional<double> PeriodBetweenSilences(const Rows& rows) {
  std::vector<std::size_t> starts;
  double silent_ns = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double interval_ns = rows.times[i] - rows.times[i - 1];
    if (interval_ns <= kSurelyAPauseNs) continue;
    starts.push_back(i);
    silent_ns += interval_ns;
  }
  if (silent_ns <= 0.5 * (rows.times.back() - rows.times.front())) return std::nullopt;
  // period and length of each second half
  std::vector<std::pair<double, double>> halves;
  double length_ns = 0;
  for (const Piece& piece : PiecesBetween(rows.size(), starts)) {
    const Times times = rows.Of(piece).times;
    const auto middle = std::ranges::lower_bound(times, 0.5 * (times.front() + times.back()));
    // times that run backwards, of a damaged file, have none
    if (middle == times.end() || !(times.back() > *middle)) continue;
    const double half_ns = times.back() - *middle;
    const auto first = piece.first + static_cast<std::size_t>(middle - times.begin());
    halves.emplace_back(half_ns / (rows.places[piece.end - 1] - rows.places[first]), half_ns);
    length_ns += half_ns;
  }
  std::ranges::sort(halves);
  double passed_ns = 0;
  for (const auto& [period_ns, half_ns] : halves) {
    passed_ns += half_ns;
    if (passed_ns >= 0.5 * length_ns) return period_ns;
  }
  return std::nullopt;
}

// rows in a window: enough to last 0.1 s at the source, so that each spans several bursts
std::size_t WindowRows(const Rows& rows, double period_ns) {
  std::size_t count = kLeastWindowRows;
  while (rows.size() / count >= 8 && AsDouble(count) * period_ns < kWindowNs) count *= 2;
  return count;
}

// The windows of `count` rows, the last one with the remaining rows, without those whose rows came
// much faster than the source sends: after a stall they only show that they are late. All where no
// other is left.
std::vector<Window> WindowsOf(const Rows& rows, double period_ns, std::size_t count) {
  std::vector<Window> all;
  std::vector<Window> in_time;
  const std::size_t windows = std::max<std::size_t>(1, rows.size() / count);
  for (std::size_t k = 0; k < windows; ++k) {
    const std::size_t first = k * count;
    const std::size_t end = k + 1 == windows ? rows.size() : first + count;
    // delays are never negative, so the least level is the best estimate of the undelayed time
    Window window{first, end, rows.Level(first, period_ns)};
    for (std::size_t j = first; j < end; ++j) {
      window.level_ns = std::min(window.level_ns, rows.Level(j, period_ns));
    }
    // rows that took less than 0.75 of their time at the source catch up after a stall
    const double took_ns = rows.times[end - 1] - rows.times[first];
    const double sent_ns = (rows.places[end - 1] - rows.places[first]) * period_ns;
    all.push_back(window);
    if (took_ns >= kCatchingUp * sent_ns) in_time.push_back(window);
  }
  return in_time.empty() ? all : in_time;
}

std::size_t RowsIn(const std::vector<Window>& windows) {
  std::size_t rows = 0;
  for (const Window& window : windows) rows += window.end - window.first;
  return rows;
}

// each level becomes the least of itself and the next count - 1
std::vector<Window> RunningLeast(const std::vector<Window>& windows, std::size_t count) {
  std::vector<Window> least;
  for (std::size_t k = 0; k + count <= windows.size(); ++k) {
    least.push_back(windows[k]);
    for (std::size_t i = 1; i < count; ++i) {
      least.back().level_ns = std::min(least.back().level_ns, windows[k + i].level_ns);
    }
  }
  return least;
}

// what the levels rise by a place of the grid, from each window to the one `lag` further
std::vector<double> Slopes(const Rows& rows, const std::vector<Window>& windows, std::size_t lag) {
  std::vector<double> slopes;
  for (std::size_t k = lag; k < windows.size(); ++k) {
    const Window& from = windows[k - lag];
    slopes.push_back((windows[k].level_ns - from.level_ns) /
                     (rows.places[windows[k].first] - rows.places[from.first]));
  }
  return slopes;
}

// What the minima rise by from place to place. Slopes over `lag` windows are the least noisy, but
// where lines are lost more often than that, each of them holds a loss; then most of those between
// neighbours do not.
double RisePerPlace(const Rows& rows, const std::vector<Window>& windows, std::size_t lag,
                    double period_ns, std::size_t window_rows) {
  // first estimate: the median slope over `lag` windows; second: between neighbouring windows
  const double over_lag = UpperMedian(Slopes(rows, windows, lag));
  std::vector<double> steps = Slopes(rows, windows, 1);
  if (steps.empty()) return over_lag;
  const double step = UpperMedian(steps);
  // standard uncertainty of the median step: 1.2533 * 1.4826 * MAD / sqrt(n)
  for (double& deviation : steps) deviation = std::abs(deviation - step);
  const double uncertainty = kSigmaOfMedian * kDeviationsPerMedian * UpperMedian(steps) /
                             std::sqrt(AsDouble(steps.size()));
  // losses explain a difference above half a period over the lag and above 5 uncertainties
  const bool holds_losses = (over_lag - step) * AsDouble(lag * window_rows) > 0.5 * period_ns &&
                            over_lag - step > 5 * uncertainty;
  return holds_losses ? step : over_lag;
}

// A period that neither bursts nor stalls nor a few gaps disturb: medians over windows. The lag of
// up to ten windows keeps the noise of the minima small; a loss spoils only the differences across
// it. Then on the minima over three windows, which are much less noisy once the slope is nearly
// right; three times, because bursts that keep step with the windows leave 1 % of a slope at first.
double RobustPeriod(const Rows& rows, double period_ns, std::size_t window_rows) {
  if (rows.size() <= window_rows) return MedianInterval(rows);
  // first estimate: time per place over whole windows, by the median
  std::vector<double> periods;
  for (const Window& window : WindowsOf(rows, period_ns, window_rows)) {
    const std::size_t end = window.first + window_rows;
    if (end >= rows.size()) continue;
    periods.push_back((rows.times[end] - rows.times[window.first]) /
                      (rows.places[end] - rows.places[window.first]));
  }
  // a pause in one of few windows would otherwise be treated as the source's period
  if (periods.size() >= kLeastCounts || period_ns <= 0) period_ns = UpperMedian(std::move(periods));
  // correction by the slope of the minima over one window, then over three
  for (const std::size_t count : {1U, 3U, 3U, 3U}) {
    const auto windows = RunningLeast(WindowsOf(rows, period_ns, window_rows), count);
    const std::size_t lag = std::clamp<std::size_t>(windows.size() / 5, 1, 10);
    period_ns += RisePerPlace(rows, windows, lag, period_ns, window_rows);
  }
  return period_ns;
}

// the line below all points with the least sum of distances: the edge of the lower convex hull over
// the mean place, of the rows in these windows. Computed on the levels (of any period near the true
// one), whose small numbers keep the digits. It begins at the first row's place.
Line LowerLine(const Rows& rows, double period_ns, const std::vector<Window>& windows) {
  std::vector<std::pair<double, double>> hull;
  double sum_x = 0;
  for (const Window& window : windows) {
    for (std::size_t j = window.first; j < window.end; ++j) {
      const double x = rows.places[j] - rows.places[0];
      const double y = rows.Level(j, period_ns);
      sum_x += x;
      // the last corner is no corner if it lies on or above the line to the new point
      while (hull.size() >= 2) {
        const auto [x1, y1] = hull[hull.size() - 2];
        const auto [x2, y2] = hull.back();
        if ((y2 - y1) * (x - x1) < (y - y1) * (x2 - x1)) break;
        hull.pop_back();
      }
      hull.emplace_back(x, y);
    }
  }
  // the sum of the distances is least on the hull's edge over the mean place (Moon et al. 1999)
  const double mean_x = sum_x / AsDouble(RowsIn(windows));
  const auto right = std::ranges::find_if(hull, [&](const auto& p) { return p.first >= mean_x; });
  // a single place has no edge: the given period is retained
  if (right == hull.begin()) return {right->second, period_ns};
  const auto [x1, y1] = *std::prev(right);
  const auto [x2, y2] = *right;
  // the edge's slope corrects the period; the line is extended to the first place
  const double slope = (y2 - y1) / (x2 - x1);
  return {y1 - slope * x1, period_ns + slope};
}

// The row at which a rise between two windows begins. Rows below the new line surely came before
// the loss; from there to the first row on the new line it is the one with the largest interval.
std::size_t PlaceOfRise(const Rows& rows, double period_ns, const Window& before,
                        const Window& after, double after_ns) {
  // a row is on a line if its level is within half a period of it
  const double slack_ns = 0.5 * period_ns;
  std::size_t last_old = before.first;
  for (std::size_t j = before.first; j < after.first; ++j) {
    if (rows.Level(j, period_ns) < after_ns - slack_ns) last_old = j;
  }
  std::size_t best = last_old + 1;
  for (std::size_t j = best; j < rows.size(); ++j) {
    if (rows.times[j] - rows.times[j - 1] > rows.times[best] - rows.times[best - 1]) best = j;
    if (rows.Level(j, period_ns) < after_ns + slack_ns) break;
  }
  return best;
}

// least level of the windows [from, from + count), ns
double LeastOf(const std::vector<Window>& windows, std::size_t from, std::size_t count) {
  const auto first = windows.begin() + static_cast<std::ptrdiff_t>(from);
  return std::ranges::min_element(first, first + static_cast<std::ptrdiff_t>(count), {},
                                  &Window::level_ns)
      ->level_ns;
}

// rows at which the lower envelope rises and stays up: lines were lost before them
std::vector<std::size_t> Rises(const Rows& rows, double period_ns, std::size_t window_rows) {
  const std::vector<Window> windows = WindowsOf(rows, period_ns, window_rows);
  // scatter of the minima: 1.4826 * median of the differences between neighbours
  std::vector<double> sizes;
  for (std::size_t k = 1; k < windows.size(); ++k) {
    sizes.push_back(std::abs(windows[k].level_ns - windows[k - 1].level_ns));
  }
  const double scatter_ns = kDeviationsPerMedian * UpperMedian(std::move(sizes));
  // a rise exceeds half a period and three times the scatter
  const double least_rise_ns = std::max(0.5 * period_ns, kScatters * scatter_ns);
  // the level behind window k: it stays up only if all of the next ten windows do
  auto ahead_ns = [&](std::size_t k) {
    return LeastOf(windows, k, std::min(kWindowsAhead, windows.size() - k));
  };
  std::vector<std::size_t> rises;
  std::size_t begin = 0;
  for (std::size_t k = 1; k + kLeastWindowsAhead <= windows.size(); ++k) {
    // the level before window k: at most five windows back, none of them before the last rise
    const std::size_t behind = std::min(kWindowsBehind, k - begin);
    if (ahead_ns(k) - LeastOf(windows, k - behind, behind) <= least_rise_ns) continue;
    // a loss within a window may raise it in part and the next one in full: one rise
    while (k + 1 + kLeastWindowsAhead <= windows.size() &&
           ahead_ns(k + 1) - ahead_ns(k) > least_rise_ns) {
      ++k;
    }
    // near the place, a slope that is not quite right does not matter
    const std::size_t near = std::min<std::size_t>(3, windows.size() - k);
    rises.push_back(
        PlaceOfRise(rows, period_ns, windows[k - 1], windows[k], LeastOf(windows, k, near)));
    begin = k;
  }
  return rises;
}

// Whether nothing makes up for the silence before row i, which lasted `excess_ns` longer than the
// rows known to be missing explain. What is still coming in faster than the source sends when the
// rows end may make up for it.
bool StaysLate(const Rows& rows, double period_ns, std::size_t i, double excess_ns) {
  // least lateness, against the row before the silence, of the rows of the next 2 * excess_ns
  double after_ns = excess_ns;
  std::size_t j = i;
  for (; j < rows.size() && AsDouble(j - i) * period_ns < 2 * excess_ns; ++j) {
    after_ns = std::min(after_ns, rows.Level(j, period_ns) - rows.Level(i - 1, period_ns));
  }
  // half of the delay is made up for: a stall of the host, no loss
  if (after_ns <= 0.5 * excess_ns) return false;
  // the rows end early: the last ones may still be catching up
  const double took_ns = rows.times[j - 1] - rows.times[i];
  const double sent_ns = (rows.places[j - 1] - rows.places[i]) * period_ns;
  return j < rows.size() || took_ns >= kCatchingUp * sent_ns;
}

// rows after a pause that is too long for a stall and is not made up for
std::vector<std::size_t> Pauses(const Rows& rows, double period_ns) {
  std::vector<std::size_t> pauses;
  // a pause exceeds 0.25 s and eight periods
  const double least_ns = std::max(kSurelyAPauseNs, 8 * period_ns);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double excess_ns = rows.Level(i, period_ns) - rows.Level(i - 1, period_ns);
    if (excess_ns > least_ns && StaysLate(rows, period_ns, i, excess_ns)) pauses.push_back(i);
  }
  return pauses;
}

// what `find` finds in each piece, as rows of the recording, beside the pieces' own beginnings
template <typename Find>
std::vector<std::size_t> StartsIn(const Rows& rows, const std::vector<Piece>& pieces,
                                  const Find& find) {
  std::vector<std::size_t> starts;
  starts.reserve(pieces.size());
  for (const Piece& piece : pieces) {
    starts.push_back(piece.first);
    for (const std::size_t row : find(rows.Of(piece))) starts.push_back(piece.first + row);
  }
  return starts;
}

// the piece with the most rows that came in time
const Piece& Longest(const Rows& rows, const std::vector<Piece>& pieces, double period_ns,
                     std::size_t window_rows) {
  return *std::ranges::max_element(pieces, {}, [&](const Piece& piece) {
    return RowsIn(WindowsOf(rows.Of(piece), period_ns, window_rows));
  });
}

// pieces of one line each, and the period that the longest of them shows
struct Cut {
  std::vector<Piece> pieces;
  double period_ns = 0;
  std::size_t longest_rows = 0;
  std::size_t window_rows = 0;
};

// The windows that a line is fitted to. Where lines were lost within a burst, the first rows of a
// piece may come from before the loss, below its line: its first window is left out, of pieces
// behind a known break too, where it costs little.
std::vector<Window> FittedWindows(const Rows& part, const Piece& piece, double period_ns,
                                  std::size_t window_rows) {
  auto windows = WindowsOf(part, period_ns, window_rows);
  if (piece.first > 0 && windows.size() > 2) windows.erase(windows.begin());
  return windows;
}

// The period of the lines below all pieces. That of n rows is known to a variance that falls with
// n^3, as a slope's does, which weights it.
double CommonSlope(const Rows& rows, const std::vector<Piece>& pieces, double period_ns,
                   std::size_t window_rows) {
  double sum = 0;
  double weights = 0;
  for (const Piece& piece : pieces) {
    if (piece.rows() < 2 * window_rows) continue;
    const Rows part = rows.Of(piece);
    const auto windows = FittedWindows(part, piece, period_ns, window_rows);
    const double weight = std::pow(AsDouble(RowsIn(windows)), 3);
    sum += weight * (LowerLine(part, period_ns, windows).period_ns - period_ns);
    weights += weight;
  }
  return weights > 0 ? period_ns + sum / weights : period_ns;
}

Cut CutAtLosses(const Rows& rows, const std::vector<std::size_t>& breaks, bool is_numbered) {
  // rough period by counts per window, then a robust one by medians
  const std::optional<double> between_ns = PeriodBetweenSilences(rows);
  const double first_ns =
      between_ns ? *between_ns : PeriodByCounts(rows).value_or(MedianInterval(rows));
  const std::size_t window_rows = WindowRows(rows, first_ns);
  double period_ns = between_ns ? first_ns : RobustPeriod(rows, first_ns, window_rows);
  // known losses and pauses cut the recording with certainty
  const auto known = PiecesBetween(rows.size(), breaks);
  std::vector<Piece> pieces = PiecesBetween(
      rows.size(),
      StartsIn(rows, known, [&](const Rows& part) { return Pauses(part, period_ns); }));
  // twice, because many losses blur the period that they are looked for with
  const std::vector<Piece> sure = pieces;
  // a source that numbers its rows reports all losses: no search for rises
  for (int turn = 0; turn < (is_numbered ? 0 : 2); ++turn) {
    pieces = PiecesBetween(rows.size(), StartsIn(rows, sure, [&](const Rows& part) {
                             return Rises(part, period_ns, window_rows);
                           }));
    period_ns = CommonSlope(rows, pieces, period_ns, window_rows);
  }
  const Piece longest = Longest(rows, pieces, period_ns, window_rows);
  const auto windows = WindowsOf(rows.Of(longest), period_ns, window_rows);
  period_ns = CommonSlope(rows, pieces, period_ns, window_rows);
  return {std::move(pieces), period_ns, RowsIn(windows), window_rows};
}

// one period for pieces too short to determine their own: the longest piece's, else the nominal one
std::optional<double> CommonPeriod(const Cut& cut, std::optional<double> nominal_rate_hz) {
  if (cut.longest_rows >= 2 * cut.window_rows) return cut.period_ns;
  if (nominal_rate_hz && *nominal_rate_hz > 0) return kNsPerSecond / *nominal_rate_hz;
  return std::nullopt;
}

// the line of one piece; with its own period only where it holds ten windows or more
Line FitPiece(const Rows& part, const Piece& piece, const Cut& cut,
              std::optional<double> common_period_ns) {
  const auto windows =
      FittedWindows(part, piece, common_period_ns.value_or(cut.period_ns), cut.window_rows);
  if (RowsIn(windows) < kWindowsForARate * cut.window_rows && common_period_ns) {
    // the period is given, so only the least delay is looked for
    return {LeastOf(windows, 0, windows.size()), *common_period_ns};
  }
  // without a common period the levels are the times themselves
  return LowerLine(part, common_period_ns.value_or(0), windows);
}

// scatter of the window minima about the line; by the median, so that a stall does not count
double Scatter(const Rows& part, const Line& line, std::size_t window_rows) {
  // fewer than two windows give one minimum, hence a scatter of 0
  const std::size_t count = part.size() < 2 * window_rows ? part.size() : window_rows;
  auto levels = Mapped<double>(WindowsOf(part, line.period_ns, count), &Window::level_ns);
  // 1.4826 * MAD about the median
  const double middle = UpperMedian(levels);
  for (double& level : levels) level = std::abs(level - middle);
  return kDeviationsPerMedian * UpperMedian(std::move(levels));
}

// each row's place: its number, and what is known to be missing before it
std::vector<double> PlacesOf(std::size_t rows, std::span<const MissingRows> missing) {
  std::vector<double> places(rows, 1);
  if (rows > 0) places[0] = 0;
  for (const MissingRows& at : missing) {
    if (at.row < rows) places[at.row] += static_cast<double>(at.count.value_or(0));
  }
  std::partial_sum(places.begin(), places.end(), places.begin());
  return places;
}

}  // namespace

std::vector<Stretch> FitArrivalTimes(std::span<const std::int64_t> time_ns,
                                     std::optional<double> nominal_rate_hz,
                                     std::span<const MissingRows> missing, bool is_numbered) {
  if (time_ns.empty()) return {};
  const std::vector<double> times = SinceFirst(time_ns);
  const std::vector<double> places = PlacesOf(times.size(), missing);
  const Rows rows{times, places};
  std::vector<std::size_t> breaks;  // behind which a new line begins
  std::vector<std::size_t> missed;  // behind which the same one continues
  for (const MissingRows& at : missing) (at.count ? missed : breaks).push_back(at.row);
  const Cut cut = CutAtLosses(rows, breaks, is_numbered);
  const auto common_period_ns = CommonPeriod(cut, nominal_rate_hz);
  std::vector<Stretch> stretches;
  for (const Piece& piece : cut.pieces) {
    const Rows part = rows.Of(piece);
    const Line line = FitPiece(part, piece, cut, common_period_ns);
    const double uncertainty_s = Scatter(part, line, cut.window_rows) / kNsPerSecond;
    // losses of known number divide segments, but both sides lie on one line
    std::vector<std::size_t> starts;
    for (const std::size_t row : missed) {
      if (row > piece.first && row < piece.end) starts.push_back(row - piece.first);
    }
    for (const Piece& run : PiecesBetween(piece.rows(), starts)) {
      // time since the recording's start = first row + line + places lost before this segment
      const double start_ns = static_cast<double>(time_ns.front()) + line.start_ns +
                              (part.places[run.first] - part.places[0]) * line.period_ns;
      stretches.push_back({.first_row = piece.first + run.first,
                           .rows = run.rows(),
                           .start_s = start_ns / kNsPerSecond,
                           .rate_hz = RateOf(line.period_ns),
                           .time_uncertainty_s = uncertainty_s});
    }
  }
  return stretches;
}

namespace {

// the least-squares line of a piece; its own slope where it has rows enough
// rows centred on their mean: period = sum(x t) / sum(x^2)
Line MeanLine(Times part, std::optional<double> common_period_ns) {
  const double mean_x = 0.5 * AsDouble(part.size() - 1);
  double mean_t = 0;
  for (const double t : part) mean_t += t / AsDouble(part.size());
  double xt = 0;
  double xx = 0;
  for (std::size_t j = 0; j < part.size(); ++j) {
    const double x = AsDouble(j) - mean_x;
    xt += x * (part[j] - mean_t);
    xx += x * x;
  }
  // two rows do not determine a period against the uncertainty of their times
  const bool is_short = part.size() < 3;
  const double own_ns = xx > 0 ? xt / xx : 0;
  const double period_ns = is_short ? common_period_ns.value_or(own_ns) : own_ns;
  return {mean_t - mean_x * period_ns, period_ns};
}

// scatter of polled times about `line`, and of the reading within request and reply
double PolledUncertaintyNs(Times part, Times waits, const Line& line) {
  double squares = 0;
  for (std::size_t j = 0; j < part.size(); ++j) {
    const double residual = part[j] - line.start_ns - AsDouble(j) * line.period_ns;
    // the reading is anywhere within its wait: variance wait^2 / 12 (uniform distribution)
    squares += residual * residual + waits[j] * waits[j] / 12;
  }
  return std::sqrt(squares / AsDouble(part.size()));
}

}  // namespace

std::vector<Stretch> FitPolledTimes(std::span<const std::int64_t> request_ns,
                                    std::span<const std::int64_t> reply_ns,
                                    std::optional<double> nominal_rate_hz,
                                    std::span<const std::size_t> breaks) {
  HAPTOMETER_CHECK(request_ns.size() == reply_ns.size(), "{} requests, {} replies",
                   request_ns.size(), reply_ns.size());
  if (request_ns.empty()) return {};
  // time of a polled reading: the middle of request and reply
  std::vector<double> middles = SinceFirst(request_ns);
  std::vector<double> waits;
  for (std::size_t j = 0; j < middles.size(); ++j) {
    waits.push_back(static_cast<double>(reply_ns[j]) - static_cast<double>(request_ns[j]));
    middles[j] += 0.5 * waits[j];
  }
  // a pause between two polls begins a segment, as a break does
  const std::vector<double> intervals = Differences(middles, 1);
  const double median_ns = UpperMedian(intervals);
  std::vector<std::size_t> starts(breaks.begin(), breaks.end());
  for (std::size_t j = 0; j < intervals.size(); ++j) {
    if (intervals[j] > 8 * median_ns) starts.push_back(j + 1);
  }
  // period for short segments: the median interval, else the nominal one
  std::optional<double> common_period_ns;
  if (nominal_rate_hz && *nominal_rate_hz > 0) common_period_ns = kNsPerSecond / *nominal_rate_hz;
  if (median_ns > 0) common_period_ns = median_ns;
  std::vector<Stretch> stretches;
  for (const Piece& piece : PiecesBetween(middles.size(), std::move(starts))) {
    const Times part = Times(middles).subspan(piece.first, piece.rows());
    const Line line = MeanLine(part, common_period_ns);
    const double start_ns = static_cast<double>(request_ns.front()) + line.start_ns;
    const Times part_waits = Times(waits).subspan(piece.first, piece.rows());
    stretches.push_back(
        {.first_row = piece.first,
         .rows = piece.rows(),
         .start_s = start_ns / kNsPerSecond,
         .rate_hz = RateOf(line.period_ns),
         .time_uncertainty_s = PolledUncertaintyNs(part, part_waits, line) / kNsPerSecond});
  }
  return stretches;
}

}  // namespace haptometer::trial
