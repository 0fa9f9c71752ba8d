#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

/// Steps of the time bases in trial/time_base.h: pieces of a recording and their lines, which
/// arrival times and polled times share, and the period and the lower line of arrival times. All
/// times are nanoseconds since the first row, as doubles: exact below 2^53 ns = 104 days.
namespace haptometer::trial {

inline constexpr double kNsPerSecond = 1e9;
/// Share of the time that rows took at the source, below which they catch up after a stall.
inline constexpr double kCatchingUp = 0.75;
/// A longer silence that no later rows make up for is a gap, wherever it is.
inline constexpr double kSurelyAPauseNs = 0.25 * kNsPerSecond;

/// Share of the silence between blocks by which their ends may be off one line.
inline constexpr double kRegular = 0.25;

using Times = std::span<const double>;

/// Rows [first, end) of a recording.
struct RowPiece {
  std::size_t first = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t rows() const { return end - first; }
};

/// The time of row j of a piece: start_ns + j * period_ns.
struct TimeLine {
  double start_ns = 0;
  double period_ns = 0;
};

/// Rows with their places on the source's grid: the row's number and the losses known before it.
struct TimedRows {
  Times times;
  Times places;

  [[nodiscard]] std::size_t size() const { return times.size(); }
  [[nodiscard]] TimedRows Of(const RowPiece& piece) const {
    return {times.subspan(piece.first, piece.rows()), places.subspan(piece.first, piece.rows())};
  }
  /// How late row j is against a line of this period; the zero is arbitrary.
  [[nodiscard]] double Level(std::size_t j, double period_ns) const {
    return times[j] - (places[j] - places[0]) * period_ns;
  }
};

/// Rows [first, end), and the least of their levels.
struct LevelWindow {
  std::size_t first = 0;
  std::size_t end = 0;
  double level_ns = 0;
};

/// A source's period, and the rows of a window that its minima are formed over.
struct SourcePeriod {
  double ns = 0;
  std::size_t window_rows = 0;
  /// Silence between blocks of rows, ns, where it is as long as a pause of the source and may be
  /// none: its rows may have been collected on their way. 0 for other sources.
  double block_ns = 0;
  bool is_of_blocks = false;  ///< the rows were collected, and their blocks' ends show the period
};

[[nodiscard]] constexpr double AsDouble(std::size_t n) { return static_cast<double>(n); }

/// Rows per second; infinite where all rows have one time.
[[nodiscard]] constexpr double RateOf(double period_ns) {
  return period_ns > 0 ? kNsPerSecond / period_ns : std::numeric_limits<double>::infinity();
}

/// Times in ns after the first row.
[[nodiscard]] std::vector<double> SinceFirst(std::span<const std::int64_t> time_ns);

/// values[k] - values[k - 1], one less than the values.
[[nodiscard]] std::vector<double> Differences(std::span<const double> values);

/// The pieces of `rows` rows that begin at 0 and at `starts`, in any order and number.
[[nodiscard]] std::vector<RowPiece> PiecesBetween(std::size_t rows,
                                                  std::vector<std::size_t> starts);

/// The period of rows that neither bursts nor stalls nor a few gaps disturb: from how many rows
/// came in each window of time, then by medians of the minima over windows of rows.
///
/// Silences that make up half of the time divide the rows into blocks. Rows of a block that come at
/// once (within 1/8 of the time) were collected on their way: the last of them is the one in time,
/// and the period is the time from one block's end to the next, divided by the rows. Rows that
/// take longer are those of a source that pauses for more than 0.25 s, and show its period between
/// its silences; but if each block holds what its cycle brings at one rate, they may have been
/// collected too. Cost: O(rows), or with blocks O(rows log rows).
[[nodiscard]] SourcePeriod PeriodOf(const TimedRows& rows);

/// The windows of `count` rows, the last one with the remaining rows, without those whose rows came
/// much faster than the source sends: after a stall they only show that they are late. All where no
/// other is left.
[[nodiscard]] std::vector<LevelWindow> WindowsOf(const TimedRows& rows, double period_ns,
                                                 std::size_t count);

/// The rows of all windows.
[[nodiscard]] std::size_t RowsIn(const std::vector<LevelWindow>& windows);

/// The line below all points with the least sum of distances: the edge of the lower convex hull
/// over the mean place, of the rows in these windows. Computed on the levels (of any period near
/// the true one), whose small numbers keep the digits. It begins at the first row's place. Needs a
/// row.
[[nodiscard]] TimeLine LowerLine(const TimedRows& rows, double period_ns,
                                 const std::vector<LevelWindow>& windows);

}  // namespace haptometer::trial
