#pragma once

#include <algorithm>
#include <iterator>
#include <ranges>
#include <utility>
#include <vector>

#include "base/error.h"

namespace haptometer {

/// Standard deviation of a normal distribution over the median of |x - mean|: 1 / 0.674490.
inline constexpr double kDeviationsPerMedian = 1.4826022185056018;

/// The middle one of the values, or the upper one of the middle two: one that occurs among them, as
/// a reading does. 0 of none. Cost: O(n).
template <std::ranges::random_access_range Values>
  requires(!std::ranges::view<Values>)
[[nodiscard]] std::ranges::range_value_t<Values> UpperMedian(Values values) {
  if (std::ranges::empty(values)) return {};
  const auto middle = std::ranges::begin(values) + std::ranges::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The middle value, or the mean of the middle two. At least 1 value. Cost: O(n).
[[nodiscard]] inline double Median(std::vector<double> values) {
  HAPTOMETER_CHECK(!values.empty(), "no values");
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  if (values.size() % 2 == 1) return *middle;
  // without overflow of their sum
  const double below = *std::ranges::max_element(values.begin(), middle);
  return below + (*middle - below) / 2;
}

}  // namespace haptometer
