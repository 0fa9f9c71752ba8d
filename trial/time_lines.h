#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// What the fits of arrival times and of polled times share. All times are nanoseconds since the
/// first row, as doubles: exact below 2^53 ns = 104 days.
namespace haptometer::trial {

inline constexpr double kNsPerSecond = 1e9;

using Times = std::span<const double>;

/// Rows [first, end) of a recording
struct Piece {
  std::size_t first = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t rows() const { return end - first; }
};

/// Time of row j of a piece: start_ns + j * period_ns
struct Line {
  double start_ns = 0;
  double period_ns = 0;
};

[[nodiscard]] inline double AsDouble(std::size_t n) { return static_cast<double>(n); }

/// The upper one of two middle values; 0 of none.
[[nodiscard]] double Median(std::vector<double> values);

/// values[k] - values[k - lag].
[[nodiscard]] std::vector<double> Differences(const std::vector<double>& values, std::size_t lag);

/// The pieces of `rows` rows that begin at 0 and at `starts`, in any order.
[[nodiscard]] std::vector<Piece> PiecesBetween(std::size_t rows, std::vector<std::size_t> starts);

/// Rows a second; infinite where all came at one moment.
[[nodiscard]] double RateOf(double period_ns);

[[nodiscard]] std::vector<double> SinceFirst(std::span<const std::int64_t> time_ns);

}  // namespace haptometer::trial
