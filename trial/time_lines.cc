#include "trial/time_lines.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/mapped.h"
#include "base/median.h"

namespace haptometer::trial {
namespace {

// minima of the delays are formed over 0.1 s, or over 16 rows of a slow source
constexpr double kWindowNs = 0.1 * kNsPerSecond;
constexpr std::size_t kLeastWindowRows = 16;
constexpr std::size_t kLeastCounts = 3;    // windows that show a rate
constexpr double kSigmaOfMedian = 1.2533;  // sqrt(pi / 2), against that of the mean
// blocks of rows: windows hold few of them, which have three rows or more
constexpr double kShortestBlockNs = 0.25 * kWindowNs;
constexpr double kLeastBlockRows = 3;
constexpr double kAtOnce = 0.125;     // share of the time in which no source sends all its rows
constexpr double kOneInstant = 1e-3;  // the same of one or two cycles, which a pause may divide

// median of the intervals between neighbouring rows, ns
double MedianInterval(const TimedRows& rows) { return UpperMedian(Differences(rows.times)); }

// A period from how many rows came in each window of time, to some percent. A stall leaves windows
// empty, and all that waited comes in the one behind them: only windows between two others with
// rows count. Nothing where there are too few.
std::optional<double> PeriodByCounts(const TimedRows& rows) {
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

// the value at which half of the weight is passed; the values are sorted. 0 without any weight
double WeightedMedian(std::vector<std::pair<double, double>> values_and_weights) {
  std::ranges::sort(values_and_weights);
  double weight = 0;
  for (const auto& at : values_and_weights) weight += at.second;
  double passed = 0;
  for (const auto& [value, at] : values_and_weights) {
    passed += at;
    if (passed >= 0.5 * weight && weight > 0) return value;
  }
  return 0;
}

// The interval between neighbouring rows below which half of the time lies, ns; 0 where that is
// shorter than between blocks. O(rows) there.
double UsualSilence(const TimedRows& rows) {
  std::vector<std::pair<double, double>> silences;
  double silent_ns = 0;
  double total_ns = 0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const double interval_ns = rows.times[k] - rows.times[k - 1];
    // times that run backwards, of a damaged file, have none
    total_ns += std::max(interval_ns, 0.0);
    if (interval_ns < kShortestBlockNs) continue;
    silences.emplace_back(interval_ns, interval_ns);
    silent_ns += interval_ns;
  }
  if (silent_ns <= 0.5 * total_ns) return 0;
  silences.emplace_back(0, total_ns - silent_ns);
  return WeightedMedian(std::move(silences));
}

// rows between silences
struct Blocks {
  double period_ns = 0;     // from one block's end to the next by the rows, the median by time
  bool is_at_once = false;  // next to no time passes within the blocks
  bool is_regular = false;  // each holds what its cycle brings at that period
};

// Blocks of rows between silences of half the usual one or more. Nothing of rows that come one by
// one, or in bursts of which windows hold many.
std::optional<Blocks> BlocksOf(const TimedRows& rows, double silence_ns) {
  if (silence_ns <= 0) return std::nullopt;
  std::vector<std::size_t> starts;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows.times[i] - rows.times[i - 1] >= 0.5 * silence_ns) starts.push_back(i);
  }
  // cycles, from one block's last row, which is the least late, to the next one's
  std::vector<std::pair<double, double>> periods;
  std::vector<double> counts;
  double within_ns = 0;
  double total_ns = 0;
  for (const RowPiece& piece : PiecesBetween(rows.size(), starts)) {
    if (piece.first == 0) continue;
    const double cycle_ns = rows.times[piece.end - 1] - rows.times[piece.first - 1];
    if (!(cycle_ns > 0)) continue;
    counts.push_back(rows.places[piece.end - 1] - rows.places[piece.first - 1]);
    periods.emplace_back(cycle_ns / counts.back(), cycle_ns);
    within_ns += rows.times[piece.end - 1] - rows.times[piece.first];
    total_ns += cycle_ns;
  }
  if (counts.empty() || UpperMedian(counts) < kLeastBlockRows) return std::nullopt;
  const double period_ns = WeightedMedian(periods);
  std::vector<double> late_ns;
  late_ns.reserve(counts.size());
  for (std::size_t k = 0; k < counts.size(); ++k) {
    late_ns.push_back(std::abs(periods[k].second - counts[k] * period_ns));
  }
  return Blocks{
      .period_ns = period_ns,
      .is_at_once = within_ns < (counts.size() < kLeastCounts ? kOneInstant : kAtOnce) * total_ns,
      .is_regular = UpperMedian(std::move(late_ns)) < kRegular * silence_ns};
}

// The period of a source that pauses: that of the second halves of what lies between silences of
// more than 0.25 s, the median by time. Whatever waited during a stall of the host came in the
// first halves. Nothing where all rows came at one time.
std::optional<double> PeriodBetweenSilences(const TimedRows& rows) {
  std::vector<std::size_t> starts;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows.times[i] - rows.times[i - 1] > kSurelyAPauseNs) starts.push_back(i);
  }
  // period and length of each second half
  std::vector<std::pair<double, double>> halves;
  for (const RowPiece& piece : PiecesBetween(rows.size(), starts)) {
    const Times times = rows.Of(piece).times;
    const auto middle = std::ranges::lower_bound(times, 0.5 * (times.front() + times.back()));
    // times that run backwards, of a damaged file, have none
    if (middle == times.end() || !(times.back() > *middle)) continue;
    const double half_ns = times.back() - *middle;
    const auto first = piece.first + static_cast<std::size_t>(middle - times.begin());
    halves.emplace_back(half_ns / (rows.places[piece.end - 1] - rows.places[first]), half_ns);
  }
  if (halves.empty()) return std::nullopt;
  return WeightedMedian(std::move(halves));
}

// rows in a window: enough to last 0.1 s at the source, so that each spans several bursts
std::size_t WindowRows(const TimedRows& rows, double period_ns) {
  std::size_t count = kLeastWindowRows;
  while (rows.size() / count >= 8 && AsDouble(count) * period_ns < kWindowNs) count *= 2;
  return count;
}

// each level becomes the least of itself and the next count - 1
std::vector<LevelWindow> RunningLeast(const std::vector<LevelWindow>& windows, std::size_t count) {
  std::vector<LevelWindow> least;
  least.reserve(windows.size());
  for (std::size_t k = 0; k + count <= windows.size(); ++k) {
    least.push_back(windows[k]);
    for (std::size_t i = 1; i < count; ++i) {
      least.back().level_ns = std::min(least.back().level_ns, windows[k + i].level_ns);
    }
  }
  return least;
}

// what the levels rise by a place of the grid, from each window to the one `lag` further
std::vector<double> Slopes(const TimedRows& rows, const std::vector<LevelWindow>& windows,
                           std::size_t lag) {
  std::vector<double> slopes;
  slopes.reserve(windows.size());
  for (std::size_t k = lag; k < windows.size(); ++k) {
    const LevelWindow& from = windows[k - lag];
    slopes.push_back((windows[k].level_ns - from.level_ns) /
                     (rows.places[windows[k].first] - rows.places[from.first]));
  }
  return slopes;
}

// What the minima rise by from place to place. Slopes over `lag` windows are the least noisy, but
// where lines are lost more often than that, each of them holds a loss; then most of those between
// neighbours do not.
double RisePerPlace(const TimedRows& rows, const std::vector<LevelWindow>& windows, std::size_t lag,
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

// time per place over whole windows, by the median, ns; `period_ns` where they are too few
double PeriodByWindows(const TimedRows& rows, double period_ns, std::size_t window_rows) {
  std::vector<double> periods;
  for (const LevelWindow& window : WindowsOf(rows, period_ns, window_rows)) {
    const std::size_t end = window.first + window_rows;
    if (end >= rows.size()) continue;
    periods.push_back((rows.times[end] - rows.times[window.first]) /
                      (rows.places[end] - rows.places[window.first]));
  }
  // a pause in one of few windows would otherwise be treated as the source's period
  if (periods.size() < kLeastCounts && period_ns > 0) return period_ns;
  return UpperMedian(std::move(periods));
}

// A period that neither bursts nor stalls nor a few gaps disturb, from one that is nearly right.
// The lag of up to ten windows keeps the noise of the minima small; a loss spoils only the
// differences across it. Then on the minima over three windows, which are much less noisy once the
// slope is nearly right; three times, because bursts that keep step with the windows leave 1 % of a
// slope at first.
double RobustPeriod(const TimedRows& rows, double period_ns, std::size_t window_rows) {
  // correction by the slope of the minima over one window, then over three
  for (const std::size_t count : {1U, 3U, 3U, 3U}) {
    const auto windows = RunningLeast(WindowsOf(rows, period_ns, window_rows), count);
    const std::size_t lag = std::clamp<std::size_t>(windows.size() / 5, 1, 10);
    period_ns += RisePerPlace(rows, windows, lag, period_ns, window_rows);
  }
  return period_ns;
}

}  // namespace

std::vector<double> SinceFirst(std::span<const std::int64_t> time_ns) {
  return Mapped<double>(time_ns, [&](const std::int64_t t) {
    return static_cast<double>(t) - static_cast<double>(time_ns.front());
  });
}

std::vector<double> Differences(std::span<const double> values) {
  std::vector<double> differences;
  differences.reserve(values.size());
  for (std::size_t k = 1; k < values.size(); ++k) differences.push_back(values[k] - values[k - 1]);
  return differences;
}

std::vector<RowPiece> PiecesBetween(std::size_t rows, std::vector<std::size_t> starts) {
  std::ranges::sort(starts);
  std::vector<RowPiece> pieces{{0, rows}};
  for (const std::size_t row : starts) {
    if (row <= pieces.back().first || row >= rows) continue;
    pieces.back().end = row;
    pieces.push_back({row, rows});
  }
  return pieces;
}

std::vector<LevelWindow> WindowsOf(const TimedRows& rows, double period_ns, std::size_t count) {
  std::vector<LevelWindow> all;
  std::vector<LevelWindow> in_time;
  const std::size_t windows = std::max<std::size_t>(1, rows.size() / count);
  all.reserve(windows);
  in_time.reserve(windows);
  for (std::size_t k = 0; k < windows; ++k) {
    const std::size_t first = k * count;
    const std::size_t end = k + 1 == windows ? rows.size() : first + count;
    // delays are never negative, so the least level is the best estimate of the undelayed time
    LevelWindow window{first, end, rows.Level(first, period_ns)};
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

std::size_t RowsIn(const std::vector<LevelWindow>& windows) {
  std::size_t rows = 0;
  for (const LevelWindow& window : windows) rows += window.end - window.first;
  return rows;
}

SourcePeriod PeriodOf(const TimedRows& rows) {
  const double silence_ns = UsualSilence(rows);
  const bool is_pause = silence_ns > kSurelyAPauseNs;
  const std::optional<Blocks> blocks = BlocksOf(rows, silence_ns);
  // rows that were collected: the blocks' ends show the period
  if (blocks && blocks->is_at_once) {
    const std::size_t window_rows = WindowRows(rows, blocks->period_ns);
    return {RobustPeriod(rows, blocks->period_ns, window_rows), window_rows,
            is_pause ? silence_ns : 0, true};
  }
  // a source that pauses: its period between its silences, unless its rows were collected
  if (const auto between_ns = is_pause ? PeriodBetweenSilences(rows) : std::nullopt) {
    const bool may_be_collected =
        blocks && blocks->is_regular && *between_ns < kCatchingUp * blocks->period_ns;
    return {*between_ns, WindowRows(rows, *between_ns), may_be_collected ? silence_ns : 0};
  }
  // rough period by counts per window, then a robust one by medians
  const std::optional<double> counted_ns = PeriodByCounts(rows);
  const double first_ns = counted_ns ? *counted_ns : MedianInterval(rows);
  const std::size_t window_rows = WindowRows(rows, first_ns);
  if (rows.size() <= window_rows) return {MedianInterval(rows), window_rows};
  const double rough_ns = PeriodByWindows(rows, first_ns, window_rows);
  return {RobustPeriod(rows, rough_ns, window_rows), window_rows};
}

TimeLine LowerLine(const TimedRows& rows, double period_ns,
                   const std::vector<LevelWindow>& windows) {
  std::vector<std::pair<double, double>> hull;
  double sum_x = 0;
  for (const LevelWindow& window : windows) {
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

}  // namespace haptometer::trial
