#pragma once

// Ways to the mean of squares, in any type of number: what dsp/statistics/moments.h does not offer.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// One running sum.
template <typename Number>
Number NaiveMeanSquare(std::span<const Number> values) {
  Number sum = 0;
  for (const Number value : values) sum += value * value;
  return sum / static_cast<Number>(values.size());
}

/// Eight running sums in blocks of 128 values, the blocks added in pairs, as moments.cc does.
template <typename Number>
Number PairwiseMeanSquare(std::span<const Number> values) {
  constexpr std::size_t kBlock = 128;
  constexpr std::size_t kLanes = 8;
  std::vector<Number> sums((values.size() + kBlock - 1) / kBlock);
  for (std::size_t block = 0; block < sums.size(); ++block) {
    const std::span<const Number> part =
        values.subspan(block * kBlock).first(std::min(kBlock, values.size() - block * kBlock));
    std::array<Number, kLanes> lanes{};
    std::size_t k = 0;
    for (; k + kLanes <= part.size(); k += kLanes) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        lanes[lane] += part[k + lane] * part[k + lane];
      }
    }
    for (; k < part.size(); ++k) lanes[k % kLanes] += part[k] * part[k];
    for (const Number lane : lanes) sums[block] += lane;
  }
  for (std::size_t left = sums.size(); left > 1; left = (left + 1) / 2) {
    for (std::size_t k = 0; k < left / 2; ++k) sums[k] = sums[2 * k] + sums[2 * k + 1];
    if (left % 2 == 1) sums[left / 2] = sums[left - 1];
  }
  return sums.front() / static_cast<Number>(values.size());
}

/// A running sum and a second one of what its roundings lost (A. Neumaier, Zeitschrift fuer
/// angewandte Mathematik und Mechanik 54, 1974).
template <typename Number>
Number CompensatedMeanSquare(std::span<const Number> values) {
  Number sum = 0;
  Number lost = 0;
  for (const Number value : values) {
    const Number term = value * value;
    const Number next = sum + term;
    lost += sum >= term ? (sum - next) + term : (term - next) + sum;
    sum = next;
  }
  return (sum + lost) / static_cast<Number>(values.size());
}

}  // namespace haptometer::dsp
