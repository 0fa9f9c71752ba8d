#include "fit/uncertainty.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

TEST(FromLogarithm, TypesAAndBAddInSquares) {
  const FittedValue value = FromLogarithm(std::log(2800), 0.03 * 0.03, 0.04 * 0.04, "N/m");
  EXPECT_REL(value.value, 2800.0, 1e-14, "exp of a logarithm");
  EXPECT_REL(value.standard_uncertainty, 2800 * 0.03, 1e-14, "rounding");
  EXPECT_REL(value.combined_standard_uncertainty, 2800 * 0.05, 1e-14, "3-4-5");
  EXPECT_REL(value.lower, 2800 * (1 - 1.96 * 0.05), 1e-14, "rounding");
  EXPECT_REL(value.upper, 2800 * (1 + 1.96 * 0.05), 1e-14, "rounding");
  EXPECT_TRUE(value.determined);
}

TEST(FromLogarithm, IsDeterminedBelowAQuarterOfScatterWhateverIsGiven) {
  const auto of = [](double scatter, double given) {
    return FromLogarithm(0, scatter * scatter, given * given, "").determined;
  };
  EXPECT_TRUE(of(0.2499, 0.5));
  EXPECT_FALSE(of(0.2501, 0));
  EXPECT_FALSE(of(0.01, std::numeric_limits<double>::infinity()));
}

// 99 % quantiles of chi-squared, 6.634897 with one degree of freedom and 11.344867 with three
TEST(Scatters, BeyondWhatOneOfAHundredSetsReaches) {
  EXPECT_FALSE(Scatters(std::sqrt(6.6348), 1));
  EXPECT_TRUE(Scatters(std::sqrt(6.6350), 1));
  EXPECT_FALSE(Scatters(std::sqrt(11.3448 / 3), 3));
  EXPECT_TRUE(Scatters(std::sqrt(11.3449 / 3), 3));
}

TEST(ScatterCoverage, IsStudentsFactorOfTheEffectiveDegreesOfFreedom) {
  EXPECT_EQ(ScatterCoverage(2, 0, 1), kCoverage95) << "no scatter";
  EXPECT_EQ(ScatterCoverage(0, 0, 1), kCoverage95) << "no variance";
  // Student's factors of 95 % as GUM, table G.2, prints them
  EXPECT_ABS(ScatterCoverage(2, 2, 1), 12.71, 0.005, "printed to two decimals");
  EXPECT_ABS(ScatterCoverage(2, 2, 3), 3.18, 0.005, "printed to two decimals");
  EXPECT_ABS(ScatterCoverage(2, 1, 2), 2.31, 0.005, "2 x (2/1)^2 = 8 degrees of freedom");
  EXPECT_ABS(ScatterCoverage(3, 2, 8), 2.10, 0.005, "8 x (3/2)^2 = 18 degrees of freedom");
}

// Means of n values with a known deviation of 1 and an unknown one: the share of intervals with
// the Birge ratio and this factor that hold the truth.
double ShareHeld(int n, double unknown) {
  constexpr int kSets = 5000;
  std::mt19937_64 engine(7);
  std::normal_distribution<double> value(0, std::hypot(1.0, unknown));
  int held = 0;
  for (int set = 0; set < kSets; ++set) {
    double sum = 0;
    double squares = 0;
    for (int k = 0; k < n; ++k) {
      const double x = value(engine);
      sum += x;
      squares += x * x;
    }
    const double birge_square = (squares - sum * sum / n) / (n - 1);
    const double scatter = std::max(0.0, birge_square - 1) / n;
    const double variance = 1.0 / n + scatter;
    held += std::abs(sum / n) < ScatterCoverage(variance, scatter, n - 1) * std::sqrt(variance);
  }
  return held / double{kSets};
}

TEST(ScatterCoverage, HoldsTheMeanOfAFewValuesThatScatter) {
  // a deviation of the share of 0.0031; 1.96 alone holds 70 % of pairs and 81 % of threes
  for (const int n : {2, 3, 5}) {
    EXPECT_ABS(ShareHeld(n, 1000), 0.95, 0.0125, "four deviations");
    EXPECT_GT(ShareHeld(n, 0), 0.937) << "never narrower than what is known";
  }
}

}  // namespace
}  // namespace haptometer::fit
