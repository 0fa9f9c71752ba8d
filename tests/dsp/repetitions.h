#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/repetitions.h"

namespace haptometer::dsp {

using tests::Repetitions;

/// Prints how many of `repetitions` 95 % intervals held the truth, and expects 93 % or more, of few
/// repetitions three standard deviations less. `most_percent`: 97 of an interval for a population
/// value, 100 of one that contains a bound.
inline void ExpectCoverage(const char* name, int held, int repetitions, double most_percent = 97) {
  const double percent = 100.0 * held / repetitions;
  std::printf("[coverage] %s: %.2f %%\n", name, percent);
  // 1000 repetitions know 95 % to 0.7
  const bool long_run = repetitions >= 1000;
  const double least_percent = most_percent < 100 ? 93 : 95;
  const double by_chance = std::min(82.0, 95 - 300 * std::sqrt(0.95 * 0.05 / repetitions));
  EXPECT_GE(percent, long_run ? least_percent : by_chance) << name;
  EXPECT_LE(percent, long_run ? most_percent : 100) << name;
}

}  // namespace haptometer::dsp
