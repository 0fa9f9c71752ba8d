#include "dsp/statistics/change_points.h"

#include <algorithm>
#include <limits>

namespace haptometer::dsp {
namespace {

constexpr std::size_t kMostAtOnce = 2048;

// borders of the cheapest partition of values [first, end), first and end included
std::vector<std::size_t> Partition(std::size_t first, std::size_t end, double penalty,
                                   const SegmentCost& cost_of) {
  const std::size_t n = end - first;
  std::vector<double> cost(n + 1, 0.0);
  std::vector<std::size_t> from(n + 1, 0);
  cost[0] = -penalty;
  std::vector<std::size_t> candidates{0};
  std::vector<double> with;
  for (std::size_t k = 1; k <= n; ++k) {
    cost[k] = std::numeric_limits<double>::infinity();
    with.resize(candidates.size());
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      with[j] = cost[candidates[j]] + cost_of(first + candidates[j], first + k);
      if (with[j] + penalty >= cost[k]) continue;
      cost[k] = with[j] + penalty;
      from[k] = candidates[j];
    }
    // a candidate that lost by more than a penalty never wins again
    std::size_t kept = 0;
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      if (with[j] <= cost[k] + penalty) candidates[kept++] = candidates[j];
    }
    candidates.resize(kept);
    candidates.push_back(k);
  }
  std::vector<std::size_t> borders{end};
  for (std::size_t k = n; k > 0; k = from[k]) borders.push_back(first + from[k]);
  std::ranges::reverse(borders);
  return borders;
}

}  // namespace

std::vector<std::size_t> CheapestPartition(std::size_t count, double penalty,
                                           const SegmentCost& cost_of) {
  // in pieces, whose borders stay only where they pay
  std::vector<std::size_t> borders{0};
  for (std::size_t first = 0; first < count; first += kMostAtOnce) {
    const auto piece = Partition(first, std::min(count, first + kMostAtOnce), penalty, cost_of);
    borders.insert(borders.end(), piece.begin() + 1, piece.end());
  }
  for (std::size_t piece = kMostAtOnce; piece < count; piece += kMostAtOnce) {
    const auto at = std::ranges::lower_bound(borders, piece);
    if (at == borders.end() || *at != piece) continue;
    const std::size_t before = *(at - 1);
    const std::size_t after = *(at + 1);
    const double apart = cost_of(before, piece) + cost_of(piece, after) + penalty;
    if (cost_of(before, after) <= apart) borders.erase(at);
  }
  return borders;
}

}  // namespace haptometer::dsp
