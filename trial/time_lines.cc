#include "trial/time_lines.h"

#include <algorithm>
#include <limits>

namespace haptometer::trial {

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

std::vector<double> Differences(const std::vector<double>& values, std::size_t lag) {
  std::vector<double> differences;
  for (std::size_t k = lag; k < values.size(); ++k) {
    differences.push_back(values[k] - values[k - lag]);
  }
  return differences;
}

// pieces between rows that begin a new one, whatever their order and number
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

double RateOf(double period_ns) {
  return period_ns > 0 ? kNsPerSecond / period_ns : std::numeric_limits<double>::infinity();
}

std::vector<double> SinceFirst(std::span<const std::int64_t> time_ns) {
  std::vector<double> times;
  times.reserve(time_ns.size());
  for (const std::int64_t t : time_ns) {
    times.push_back(static_cast<double>(t) - static_cast<double>(time_ns.front()));
  }
  return times;
}

}  // namespace haptometer::trial
