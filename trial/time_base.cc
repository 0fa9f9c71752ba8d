#include "trial/time_base.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/mapped.h"
#include "base/median.h"
#include "trial/time_lines.h"

namespace haptometer::trial {

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

constexpr std::size_t kWindowsBehind = 5;  // what a rise is measured against
constexpr std::size_t kWindowsAhead = 10;  // a rise must outlast these, or all up to the end
constexpr std::size_t kLeastWindowsAhead = 2;
constexpr std::size_t kWindowsForARate = 10;  // shorter segments take the common rate
// a rise exceeds this many standard deviations of the window minima
constexpr double kScatters = 3;

// The row at which a rise between two windows begins. Rows below the new line surely came before
// the loss; from there to the first row on the new line it is the one with the largest interval.
std::size_t PlaceOfRise(const TimedRows& rows, double period_ns, const LevelWindow& before,
                        const LevelWindow& after, double after_ns) {
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
double LeastOf(const std::vector<LevelWindow>& windows, std::size_t from, std::size_t count) {
  const auto first = windows.begin() + static_cast<std::ptrdiff_t>(from);
  return std::ranges::min_element(first, first + static_cast<std::ptrdiff_t>(count), {},
                                  &LevelWindow::level_ns)
      ->level_ns;
}

// rows at which the lower envelope rises and stays up: lines were lost before them
std::vector<std::size_t> Rises(const TimedRows& rows, const SourcePeriod& source) {
  const auto [period_ns, window_rows, block_ns, is_of_blocks] = source;
  const std::vector<LevelWindow> windows = WindowsOf(rows, period_ns, window_rows);
  // scatter of the minima: 1.4826 * median of the differences between neighbours
  std::vector<double> sizes;
  for (std::size_t k = 1; k < windows.size(); ++k) {
    sizes.push_back(std::abs(windows[k].level_ns - windows[k - 1].level_ns));
  }
  const double scatter_ns = kDeviationsPerMedian * UpperMedian(std::move(sizes));
  // a rise exceeds half a period, three times the scatter, and what blocks' ends may be off
  const double least_rise_ns =
      std::max({0.5 * period_ns, kScatters * scatter_ns, kRegular * block_ns});
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
bool StaysLate(const TimedRows& rows, double period_ns, std::size_t i, double excess_ns) {
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
std::vector<std::size_t> Pauses(const TimedRows& rows, double period_ns) {
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
std::vector<std::size_t> StartsIn(const TimedRows& rows, const std::vector<RowPiece>& pieces,
                                  const Find& find) {
  std::vector<std::size_t> starts;
  starts.reserve(pieces.size());
  for (const RowPiece& piece : pieces) {
    starts.push_back(piece.first);
    for (const std::size_t row : find(rows.Of(piece))) starts.push_back(piece.first + row);
  }
  return starts;
}

// the piece with the most rows that came in time
const RowPiece& Longest(const TimedRows& rows, const std::vector<RowPiece>& pieces,
                        const SourcePeriod& source) {
  return *std::ranges::max_element(pieces, {}, [&](const RowPiece& piece) {
    return RowsIn(WindowsOf(rows.Of(piece), source.ns, source.window_rows));
  });
}

// pieces of one line each, and what the longest of them shows of the source
struct Cut {
  std::vector<RowPiece> pieces;
  SourcePeriod source;
  std::size_t longest_rows = 0;
};

// The windows that a line is fitted to. Where lines were lost within a burst, the first rows of a
// piece may come from before the loss, below its line: its first window is left out, of pieces
// behind a known break too, where it costs little.
std::vector<LevelWindow> FittedWindows(const TimedRows& part, const RowPiece& piece,
                                       double period_ns, std::size_t window_rows) {
  auto windows = WindowsOf(part, period_ns, window_rows);
  if (piece.first > 0 && windows.size() > 2) windows.erase(windows.begin());
  return windows;
}

// The period of the lines below all pieces. That of n rows is known to a variance that falls with
// n^3, as a slope's does, which weights it.
double CommonSlope(const TimedRows& rows, const std::vector<RowPiece>& pieces,
                   const SourcePeriod& source) {
  double sum = 0;
  double weights = 0;
  for (const RowPiece& piece : pieces) {
    const TimedRows part = rows.Of(piece);
    const auto windows = FittedWindows(part, piece, source.ns, source.window_rows);
    if (windows.size() < 2) continue;
    const double weight = std::pow(AsDouble(RowsIn(windows)), 3);
    sum += weight * (LowerLine(part, source.ns, windows).period_ns - source.ns);
    weights += weight;
  }
  return weights > 0 ? source.ns + sum / weights : source.ns;
}

Cut CutAtLosses(const TimedRows& rows, const std::vector<std::size_t>& breaks, bool is_numbered) {
  SourcePeriod source = PeriodOf(rows);
  // known losses and pauses cut the recording with certainty
  const auto known = PiecesBetween(rows.size(), breaks);
  std::vector<RowPiece> pieces = PiecesBetween(
      rows.size(),
      StartsIn(rows, known, [&](const TimedRows& part) { return Pauses(part, source.ns); }));
  // twice, because many losses blur the period that they are looked for with
  const std::vector<RowPiece> sure = pieces;
  // a source that numbers its rows reports all losses: no search for rises
  for (int turn = 0; turn < (is_numbered ? 0 : 2); ++turn) {
    pieces = PiecesBetween(rows.size(), StartsIn(rows, sure, [&](const TimedRows& part) {
                             return Rises(part, source);
                           }));
    source.ns = CommonSlope(rows, pieces, source);
  }
  const RowPiece longest = Longest(rows, pieces, source);
  const auto windows = WindowsOf(rows.Of(longest), source.ns, source.window_rows);
  source.ns = CommonSlope(rows, pieces, source);
  return {std::move(pieces), source, RowsIn(windows)};
}

// one period for pieces too short to determine their own: the longest piece's, else the nominal one
std::optional<double> CommonPeriod(const Cut& cut, std::optional<double> nominal_rate_hz) {
  const SourcePeriod& source = cut.source;
  if (source.is_of_blocks || cut.longest_rows >= 2 * source.window_rows) return source.ns;
  if (nominal_rate_hz && *nominal_rate_hz > 0) return kNsPerSecond / *nominal_rate_hz;
  return std::nullopt;
}

// the line of one piece; with its own period only where it holds ten windows or more
TimeLine FitPiece(const TimedRows& part, const RowPiece& piece, const Cut& cut,
                  std::optional<double> common_period_ns) {
  const auto windows =
      FittedWindows(part, piece, common_period_ns.value_or(cut.source.ns), cut.source.window_rows);
  if (RowsIn(windows) < kWindowsForARate * cut.source.window_rows && common_period_ns) {
    // the period is given, so only the least delay is looked for
    return {LeastOf(windows, 0, windows.size()), *common_period_ns};
  }
  // without a common period the levels are the times themselves
  return LowerLine(part, common_period_ns.value_or(0), windows);
}

// scatter of the window minima about the line; by the median, so that a stall does not count
double Scatter(const TimedRows& part, const TimeLine& line, std::size_t window_rows) {
  // fewer than two windows give one minimum, hence a scatter of 0
  const std::size_t count = part.size() < 2 * window_rows ? part.size() : window_rows;
  auto levels = Mapped<double>(WindowsOf(part, line.period_ns, count), &LevelWindow::level_ns);
  // 1.4826 * MAD about the median
  const double middle = UpperMedian(levels);
  for (double& level : levels) level = std::abs(level - middle);
  return kDeviationsPerMedian * UpperMedian(std::move(levels));
}

}  // namespace

std::vector<double> PlacesOf(std::size_t rows, std::span<const MissingRows> missing) {
  std::vector<double> places(rows, 1);
  if (rows > 0) places[0] = 0;
  for (const MissingRows& at : missing) {
    if (at.row < rows) places[at.row] += static_cast<double>(at.count.value_or(0));
  }
  std::partial_sum(places.begin(), places.end(), places.begin());
  return places;
}

std::vector<Stretch> FitArrivalTimes(std::span<const std::int64_t> time_ns,
                                     std::optional<double> nominal_rate_hz,
                                     std::span<const MissingRows> missing, bool is_numbered) {
  if (time_ns.empty()) return {};
  const std::vector<double> times = SinceFirst(time_ns);
  const std::vector<double> places = PlacesOf(times.size(), missing);
  const TimedRows rows{times, places};
  std::vector<std::size_t> breaks;  // behind which a new line begins
  std::vector<std::size_t> missed;  // behind which the same one continues
  for (const MissingRows& at : missing) (at.count ? missed : breaks).push_back(at.row);
  const Cut cut = CutAtLosses(rows, breaks, is_numbered);
  const auto common_period_ns = CommonPeriod(cut, nominal_rate_hz);
  std::vector<Stretch> stretches;
  for (const RowPiece& piece : cut.pieces) {
    const TimedRows part = rows.Of(piece);
    const TimeLine line = FitPiece(part, piece, cut, common_period_ns);
    // within a long block the source may have paused, or lines may have been lost
    const double uncertainty_s =
        std::max(Scatter(part, line, cut.source.window_rows), cut.source.block_ns) / kNsPerSecond;
    // losses of known number divide segments, but both sides lie on one line
    std::vector<std::size_t> starts;
    for (const std::size_t row : missed) {
      if (row > piece.first && row < piece.end) starts.push_back(row - piece.first);
    }
    for (const RowPiece& run : PiecesBetween(piece.rows(), starts)) {
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

}  // namespace haptometer::trial
