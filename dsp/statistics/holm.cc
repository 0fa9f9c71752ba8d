#include "dsp/statistics/holm.h"

#include <algorithm>
#include <numeric>

namespace haptometer::dsp {

std::vector<double> HolmAdjusted(std::span<const double> p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // equal p values come out alike in either order
  std::ranges::sort(order, {}, [&](std::size_t i) { return p[i]; });
  std::vector<double> adjusted(p.size());
  double largest = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double scaled = static_cast<double>(p.size() - k) * p[order[k]];
    largest = std::max(largest, std::min(1.0, scaled));
    adjusted[order[k]] = largest;
  }
  return adjusted;
}

std::vector<std::optional<double>> HolmOverTested(std::span<const std::optional<double>> p) {
  std::vector<double> tested;
  tested.reserve(p.size());
  for (const std::optional<double>& one : p) {
    if (one) tested.push_back(*one);
  }
  const std::vector<double> of_tested = HolmAdjusted(tested);
  std::vector<std::optional<double>> adjusted(p.size());
  auto next = of_tested.begin();
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p[i]) adjusted[i] = *next++;
  }
  return adjusted;
}

}  // namespace haptometer::dsp
