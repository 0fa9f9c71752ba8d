#include "trial/import/printed_grid.h"

#include <algorithm>
#include <cmath>

namespace haptometer::trial {
namespace {

struct Run {
  std::size_t first = 0;
  std::size_t rows = 0;
};

double AsDouble(std::size_t n) { return static_cast<double>(n); }

// the median over differences of eight rows: rounding matters an eighth as much as in single
// intervals
double MedianPeriod(std::span<const double> times_s) {
  const std::size_t lag = std::min<std::size_t>(8, times_s.size() - 1);
  // of a long record a part says as much
  constexpr std::size_t kEnough = 1U << 16U;
  const std::size_t step = 1 + times_s.size() / kEnough;
  std::vector<double> spans;
  spans.reserve(times_s.size() / step + 1);
  for (std::size_t i = lag; i < times_s.size(); i += step) {
    spans.push_back(times_s[i] - times_s[i - lag]);
  }
  const auto middle = spans.begin() + static_cast<std::ptrdiff_t>(spans.size() / 2);
  std::ranges::nth_element(spans, middle);
  return *middle / AsDouble(lag);
}

// runs of rows without an interval that is half a period too long; rounding may add to it, but
// never so much that a missing row would pass
std::vector<Run> Runs(std::span<const double> times_s, std::span<const double> resolutions_s) {
  const double period_s = MedianPeriod(times_s);
  std::vector<Run> runs{{0, 1}};
  for (std::size_t i = 1; i < times_s.size(); ++i) {
    const double rounding_s = resolutions_s[i] + resolutions_s[i - 1];
    const double longest_s = 1.5 * period_s + std::min(rounding_s, 0.4 * period_s);
    if (times_s[i] - times_s[i - 1] > longest_s) runs.push_back({i, 0});
    ++runs.back().rows;
  }
  return runs;
}

// whether first + j * period gives every time of `run` back within its digits
bool Fits(const Run& run, double period_s, std::span<const double> times_s,
          std::span<const double> resolutions_s) {
  const std::size_t last = run.first + run.rows - 1;
  const double ends_s = std::max(resolutions_s[run.first], resolutions_s[last]);
  for (std::size_t j = 0; j < run.rows; ++j) {
    const double grid_s = times_s[run.first] + AsDouble(j) * period_s;
    const double bound_s = ends_s + resolutions_s[run.first + j] + 1e-6 * period_s;
    if (std::abs(times_s[run.first + j] - grid_s) > bound_s) return false;
  }
  return true;
}

// The straight line through times whose digits are coarser than the period: least squares, each
// time weighted by its digits, because most printers keep a number of digits, so that times near 0
// are the finest. Nothing where it does not give every time back within its digits.
std::optional<Stretch> LineThroughCoarse(std::span<const double> times_s,
                                         std::span<const double> resolutions_s) {
  // fewer repeated times prove no grid
  constexpr std::size_t kFewest = 16;
  if (times_s.size() < kFewest) return std::nullopt;
  double sum = 0;
  double sum_x = 0;
  double sum_t = 0;
  const auto weight = [&](std::size_t i) {
    const double relative = resolutions_s.back() / std::max(resolutions_s[i], 1e-300);
    return std::clamp(relative * relative, 1e-12, 1e12);
  };
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    sum += weight(i);
    sum_x += weight(i) * AsDouble(i);
    sum_t += weight(i) * times_s[i];
  }
  double sum_xx = 0;
  double sum_xt = 0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const double x = AsDouble(i) - sum_x / sum;
    sum_xx += weight(i) * x * x;
    sum_xt += weight(i) * x * (times_s[i] - sum_t / sum);
  }
  const double period_s = sum_xt / sum_xx;
  const double start_s = sum_t / sum - period_s * (sum_x / sum);
  if (!(period_s > 0) || !std::isfinite(1 / period_s)) return std::nullopt;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    // twice, as some printers cut digits off where others round
    const double bound_s = 2 * resolutions_s[i] + 1e-6 * period_s;
    if (!(std::abs(times_s[i] - start_s - AsDouble(i) * period_s) <= bound_s)) return std::nullopt;
  }
  return Stretch{.rows = times_s.size(), .start_s = start_s, .rate_hz = 1 / period_s};
}

}  // namespace

std::optional<std::vector<Stretch>> PrintedGrid(std::span<const double> times_s,
                                                std::span<const double> resolutions_s) {
  if (std::ranges::adjacent_find(times_s) != times_s.end()) {
    const auto line = LineThroughCoarse(times_s, resolutions_s);
    if (!line) return std::nullopt;
    return std::vector<Stretch>{*line};
  }
  const std::vector<Run> runs = Runs(times_s, resolutions_s);
  auto own_period_s = [&](const Run& run) {
    return (times_s[run.first + run.rows - 1] - times_s[run.first]) / AsDouble(run.rows - 1);
  };
  const Run& longest = *std::ranges::max_element(runs, {}, &Run::rows);
  if (longest.rows < 2) return std::nullopt;
  const double common_period_s = own_period_s(longest);
  std::vector<Stretch> stretches;
  for (const Run& run : runs) {
    double period_s = common_period_s;
    if (!Fits(run, period_s, times_s, resolutions_s)) {
      period_s = own_period_s(run);
      if (!Fits(run, period_s, times_s, resolutions_s)) return std::nullopt;
    }
    if (!std::isfinite(1 / period_s)) return std::nullopt;
    stretches.push_back({.first_row = run.first,
                         .rows = run.rows,
                         .start_s = times_s[run.first],
                         .rate_hz = 1 / period_s,
                         .time_uncertainty_s = 0});
  }
  return stretches;
}

}  // namespace haptometer::trial
