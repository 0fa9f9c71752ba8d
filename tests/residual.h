#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <iostream>

namespace haptometer::tests {

/// Whether HAPTOMETER_SHOW_RESIDUALS is set: every comparison then prints its true residual beside
/// its tolerance, so that a bound ten times too loose is seen.
inline bool ShowResiduals() {
  static const bool show = std::getenv("HAPTOMETER_SHOW_RESIDUALS") != nullptr;
  return show;
}

/// |actual - expected| <= tolerance * scale; a NaN fails.
inline ::testing::AssertionResult Within(const char* kind, const char* actual_text,
                                         const char* expected_text, double actual, double expected,
                                         double tolerance, double scale, const char* reason) {
  const double residual = std::abs(actual - expected) / scale;
  if (ShowResiduals()) {
    std::cout << "[residual] " << actual_text << ": " << residual << " of " << tolerance << ' '
              << kind << " (" << reason << ")\n";
  }
  if (residual <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << actual_text << " = " << std::setprecision(17) << actual << ", expected "
         << expected_text << " = " << expected << "; " << kind << " residual " << residual << " > "
         << tolerance << " (" << reason << ")";
}

}  // namespace haptometer::tests

/// Relative and absolute comparison. `reason` says where the tolerance comes from; it is required.
#define EXPECT_REL(actual, expected, tolerance, reason)                                         \
  EXPECT_TRUE(::haptometer::tests::Within("relative", #actual, #expected, (actual), (expected), \
                                          (tolerance), std::abs(expected), reason))
#define EXPECT_ABS(actual, expected, tolerance, reason)                                         \
  EXPECT_TRUE(::haptometer::tests::Within("absolute", #actual, #expected, (actual), (expected), \
                                          (tolerance), 1.0, reason))
