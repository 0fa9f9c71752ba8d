#include "fit/identifiability.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

// three columns over four rows; the third is the sum of the first two, in another unit
Jacobian Deficient() {
  Jacobian jacobian{.rows = 4, .columns = 3, .values = {}, .residuals = {0, 0, 0, 0}};
  const double first[]{1, 2, 0, 1};
  const double second[]{0, 1, 3, -1};
  for (std::size_t n = 0; n < 4; ++n) {
    jacobian.values.insert(jacobian.values.end(),
                           {100 * first[n], 1e6 * second[n], 10 * (first[n] + second[n])});
  }
  return jacobian;
}

TEST(Identifiability, FindsTheInvisibleDirection) {
  const auto seen = FindIdentifiability(Deficient(), {true, true, true}, {true, true, true});
  ASSERT_EQ(seen.nullity, 1U);
  // J n = 0 for n = (0.1, 1e-5, -1)
  const double length = std::sqrt(1.01 + 1e-10);
  EXPECT_REL(Blur(seen, {0, 0, 1}), 1 / length, 1e-13, "rounding");
  EXPECT_REL(Blur(seen, {1, 0, 0}), 0.1 / length, 1e-13, "rounding");
  EXPECT_REL(Blur(seen, {0, 1, 0}), 1e-5 / length, 1e-13, "rounding");
  EXPECT_ABS(Blur(seen, {1, 0, 0.1}), 0.0, 1e-15, "a determined combination");
}

TEST(Identifiability, HoldingAColumnRestoresTheRank) {
  const auto jacobian = Deficient();
  const auto seen = FindIdentifiability(jacobian, {true, true, false}, {true, true, true});
  EXPECT_EQ(seen.nullity, 0U);
  EXPECT_TRUE(seen.null_directions.empty());
  // J'J of the first two columns is [6e4 1e8; 1e8 11e12]
  const double determinant = 6 * 11 - 1;
  EXPECT_REL(Variance(seen, {1, 0, 0}), 11e-4 / determinant, 1e-13, "2 x 2 inverse");
  EXPECT_REL(Variance(seen, {0, 1, 0}), 6e-12 / determinant, 1e-13, "2 x 2 inverse");
  EXPECT_REL(Variance(seen, {100, 1e6, 0}), (11 + 6 - 2) / determinant, 1e-13, "2 x 2 inverse");
  EXPECT_EQ(Variance(seen, {0, 0, 1}), 0.0);
}

TEST(Identifiability, AnEmptyColumnIsInvisible) {
  Jacobian jacobian{.rows = 3, .columns = 2, .values = {1, 0, 2, 0, 3, 0}, .residuals = {0, 0, 0}};
  const auto seen = FindIdentifiability(jacobian, {true, true}, {true, true});
  EXPECT_EQ(seen.nullity, 1U);
  EXPECT_ABS(Blur(seen, {0, 1}), 1.0, 1e-15, "unit length");
  EXPECT_ABS(Blur(seen, {1, 0}), 0.0, 1e-15, "seen");
}

TEST(Identifiability, AVanishingColumnDoesNotHideOtherDirections) {
  // the fourth column is that of a damping that has gone to zero
  const auto three = Deficient();
  Jacobian jacobian{.rows = 4, .columns = 4, .values = {}, .residuals = {0, 0, 0, 0}};
  for (std::size_t n = 0; n < 4; ++n) {
    const double* row = three.values.data() + 3 * n;
    jacobian.values.insert(jacobian.values.end(), {row[0], row[1], row[2], 1e-20});
  }
  const auto seen =
      FindIdentifiability(jacobian, {true, true, true, true}, {true, true, true, true});
  EXPECT_EQ(seen.nullity, 2U);
  EXPECT_ABS(Blur(seen, {0, 0, 0, 1}), 1.0, 1e-12, "unit length");
  EXPECT_REL(Blur(seen, {0, 0, 1, 0}), 1 / std::sqrt(1.01 + 1e-10), 1e-12, "as without it");
}

TEST(Identifiability, AVanishingLogarithmLeavesItsNeighbourSeen) {
  // the first column alone is a logarithm, and unseen; the second has the same direction
  Jacobian jacobian{.rows = 2, .columns = 2, .values = {1e-9, 1, 1e-9, 1}, .residuals = {0, 0}};
  const auto seen = FindIdentifiability(jacobian, {true, true}, {true, false});
  EXPECT_EQ(seen.nullity, 1U);
  EXPECT_REL(Variance(seen, {0, 1}), 0.5, 1e-13, "1 / (1 + 1)");
}

TEST(Identifiability, ADirectionLostInTheNoiseIsUnseen) {
  // two nearly equal columns of length 10: their difference is 1e-3 long, known to 1/1e-3 only
  Jacobian jacobian{.rows = 2, .columns = 2, .values = {10, 10, 0, 1e-3}, .residuals = {0, 0}};
  EXPECT_EQ(FindIdentifiability(jacobian, {true, true}, {true, true}).nullity, 1U);
  // where no logarithm is concerned, any length will do
  EXPECT_EQ(FindIdentifiability(jacobian, {true, true}, {false, false}).nullity, 0U);
  // with a ten-thousandth of the noise, it is seen
  for (double& value : jacobian.values) value *= 1e4;
  EXPECT_EQ(FindIdentifiability(jacobian, {true, true}, {true, true}).nullity, 0U);
}

TEST(Identifiability, DeterminedCombinationsKeepTheirVariance) {
  // sum of the first and third parameter's contribution is seen, whichever one is held
  const auto jacobian = Deficient();
  const std::vector<double> combination{1, 0, 0.1};
  const auto all = FindIdentifiability(jacobian, {true, true, true}, {true, true, true});
  const auto held = FindIdentifiability(jacobian, {true, true, false}, {true, true, true});
  EXPECT_REL(Variance(all, combination), Variance(held, combination), 1e-12, "pseudo-inverse");
}

TEST(Identifiability, ResponseSolvesTheLinearProblem) {
  const auto jacobian = Deficient();
  const auto seen = FindIdentifiability(jacobian, {true, true, false}, {true, true, true});
  // residuals that moving the first parameter by 0.02 and the second by -3e-6 would undo
  std::vector<double> change(4);
  for (std::size_t n = 0; n < 4; ++n) {
    change[n] = -0.02 * jacobian.values[3 * n] + 3e-6 * jacobian.values[3 * n + 1];
  }
  const auto response = Response(seen, jacobian, change);
  EXPECT_REL(response[0], 0.02, 1e-13, "rounding");
  EXPECT_REL(response[1], -3e-6, 1e-13, "rounding");
  EXPECT_EQ(response[2], 0.0);
}

TEST(Identifiability, CorrelationsAreThoseOfTheInverse) {
  // J'J of the first two columns is [6e4 1e8; 1e8 11e12]: correlation -1/sqrt(66)
  const auto seen = FindIdentifiability(Deficient(), {true, true, false}, {true, true, true});
  const auto correlations = Correlations(seen);
  ASSERT_EQ(correlations.size(), 9U);
  for (const std::size_t k : {0U, 4U}) EXPECT_REL(correlations[k], 1.0, 1e-14, "of itself");
  for (const std::size_t k : {1U, 3U}) {
    EXPECT_REL(correlations[k], -1 / std::sqrt(66.0), 1e-13, "2 x 2 inverse");
  }
  // the third column is held
  for (const std::size_t k : {2U, 5U, 6U, 7U, 8U}) EXPECT_EQ(correlations[k], 0.0) << k;
}

TEST(Identifiability, CovarianceOfTwoSumsIsBilinear) {
  const auto seen = FindIdentifiability(Deficient(), {true, true, false}, {true, true, true});
  // inverse of [6e4 1e8; 1e8 11e12]
  EXPECT_REL(Covariance(seen, {1, 0, 0}, {0, 1, 0}), -1e-8 / 65, 1e-13, "2 x 2 inverse");
  EXPECT_REL(Covariance(seen, {2, 0, 0}, {1, 1e4, 0}), 2 * (11e-4 - 1e-4) / 65, 1e-13,
             "2 x 2 inverse");
}

TEST(Identifiability, ALogarithmIsSeenToAFactorE) {
  // alone: one standard deviation is the reciprocal of the column's length
  const auto nullity = [](double length) {
    const Jacobian jacobian{.rows = 1, .columns = 1, .values = {length}, .residuals = {0}};
    return FindIdentifiability(jacobian, {true}, {true}).nullity;
  };
  EXPECT_EQ(nullity(1.005), 0U);
  EXPECT_EQ(nullity(0.995), 1U);
  // together: the columns (10, 0) and (10, s) differ by s in length, and one standard deviation
  // along (1, -1)/sqrt(2) moves either by 1/s
  const auto together = [](double s) {
    const Jacobian jacobian{.rows = 2, .columns = 2, .values = {10, 10, 0, s}, .residuals = {0, 0}};
    return FindIdentifiability(jacobian, {true, true}, {true, true}).nullity;
  };
  EXPECT_EQ(together(1.01), 0U) << "0.0025 of it is s^2/(4 100)";
  EXPECT_EQ(together(0.99), 1U) << "0.0025 of it is s^2/(4 100)";
}

TEST(Identifiability, ASingularValueCountsFromABillionthOfTheLargestOn) {
  // unit columns at the angle e have the singular values sqrt(2) and e/sqrt(2)
  const auto nullity = [](double angle) {
    const Jacobian jacobian{
        .rows = 2, .columns = 2, .values = {1, 1, 0, angle}, .residuals = {0, 0}};
    return FindIdentifiability(jacobian, {true, true}, {false, false}).nullity;
  };
  EXPECT_EQ(nullity(2.01e-9), 0U);
  EXPECT_EQ(nullity(1.99e-9), 1U);
}

}  // namespace
}  // namespace haptometer::fit
