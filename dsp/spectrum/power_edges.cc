#include "dsp/spectrum/power_edges.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>

namespace haptometer::dsp {

namespace {

std::size_t WidthOf(const PowerCells& cells) {
  return static_cast<std::size_t>(std::max(1.0, std::round(cells.window_s / cells.cell_s)));
}

// Means over `width` values that follow each other. Each window ends one block of `width` values
// and begins the next; both parts are summed, as a running sum leaves a rest where all values are
// 0.
std::vector<double> MovingMeans(std::span<const double> values, std::size_t width) {
  std::vector<double> to_end(values.size());
  std::vector<double> from_begin(values.size());
  for (std::size_t k = values.size(); k-- > 0;) {
    const bool is_last = (k + 1) % width == 0 || k + 1 == values.size();
    to_end[k] = values[k] + (is_last ? 0 : to_end[k + 1]);
  }
  for (std::size_t k = 0; k < values.size(); ++k) {
    from_begin[k] = values[k] + (k % width == 0 ? 0 : from_begin[k - 1]);
  }
  std::vector<double> means(values.size() - width + 1);
  for (std::size_t k = 0; k < means.size(); ++k) {
    const double next = k % width == 0 ? 0 : from_begin[k + width - 1];
    means[k] = (to_end[k] + next) / static_cast<double>(width);
  }
  return means;
}

}  // namespace

std::vector<PowerEdge> PowerEdges(std::span<const double> mean_square, const PowerCells& cells) {
  const std::size_t width = WidthOf(cells);
  if (mean_square.size() < 2 * width) return {};
  // mean k lies about the middle of its cells
  const std::vector<double> means = MovingMeans(mean_square, width);
  std::vector<double> sorted = means;
  const auto top = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 19 / 20);
  std::ranges::nth_element(sorted, top);
  const double half = 0.5 * *top;
  std::vector<PowerEdge> edges;
  for (std::size_t k = 1; k < means.size(); ++k) {
    if ((means[k] > half) == (means[k - 1] > half)) continue;
    const double middle = static_cast<double>(k) + 0.5 * static_cast<double>(width);
    edges.push_back({cells.start_s + middle * cells.cell_s, means[k] > half,
                     0.5 * cells.window_s / std::numbers::sqrt3});
  }
  return edges;
}

namespace {

// where `smooth` crosses `level` nearest to `place`, at most `width` away
std::optional<double> CrossingNear(std::span<const double> smooth, double level, double place,
                                   std::size_t width) {
  const auto middle = static_cast<std::size_t>(std::lround(place));
  std::optional<double> nearest;
  for (std::size_t n = middle - width; n < middle + width; ++n) {
    if ((smooth[n] > level) == (smooth[n + 1] > level)) continue;
    const double at = static_cast<double>(n) + (level - smooth[n]) / (smooth[n + 1] - smooth[n]);
    if (!nearest || std::abs(at - place) < std::abs(*nearest - place)) nearest = at;
  }
  return nearest;
}

// time to the nearest other edge
double Apart(std::span<const PowerEdge> edges, std::size_t k) {
  double apart_s = std::numeric_limits<double>::infinity();
  if (k > 0) apart_s = edges[k].time_s - edges[k - 1].time_s;
  if (k + 1 < edges.size()) apart_s = std::min(apart_s, edges[k + 1].time_s - edges[k].time_s);
  return apart_s;
}

}  // namespace

std::vector<PowerEdge> RefinedEdges(std::span<const double> mean_square, const PowerCells& cells,
                                    double unknown_s, std::vector<PowerEdge> edges) {
  const std::size_t width = WidthOf(cells);
  if (mean_square.size() < 2 * width) return edges;
  const std::vector<double> smooth = MovingMeans(MovingMeans(mean_square, width), width);
  const std::size_t beside = width + width / 2;
  const std::vector<PowerEdge> coarse = edges;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (Apart(coarse, k) < 2.5 * cells.window_s) continue;
    // smooth[n] is of 2 width - 1 cells from n on
    const double first = static_cast<double>(width) - 0.5;
    const double place = (coarse[k].time_s - cells.start_s) / cells.cell_s - first;
    const auto room = static_cast<double>(beside + 1);
    if (place < room || place + room > static_cast<double>(smooth.size())) continue;
    const auto middle = static_cast<std::size_t>(std::lround(place));
    const double before = smooth[middle - beside];
    const double after = smooth[std::min(middle + beside, smooth.size() - 1)];
    const auto at = CrossingNear(smooth, 0.5 * (before + after), place, width);
    if (!at) continue;
    edges[k].time_s += (*at - place) * cells.cell_s;
    const double q = std::max(0.0, std::min(before, after)) / std::abs(after - before);
    edges[k].uncertainty_s =
        std::hypot(unknown_s, std::sqrt(cells.window_s / cells.bandwidth_hz * q * (1 + q)));
  }
  return edges;
}

}  // namespace haptometer::dsp
