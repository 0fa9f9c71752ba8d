#include "dsp/statistics/reliability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(VariationOfLogs, IsThatOfALognormalValue) {
  // variance / mean^2 = exp(s^2) - 1
  EXPECT_REL(VariationOfLogs(1), std::sqrt(std::exp(1.0) - 1), 1e-15, "rounding");
  EXPECT_REL(VariationOfLogs(1e-9), 1e-9, 1e-15, "s itself where it is small");
}

TEST(AssessRepeats, IsThatOfShroutAndFleiss) {
  // P. E. Shrout and J. L. Fleiss, Psychological Bulletin 86(2), 1979, table 2: ICC(1,1) = .17,
  // MS between 11.24, MS within 6.26
  const std::vector<std::vector<double>> cells{{9, 2, 5, 8}, {6, 1, 3, 2},  {8, 4, 6, 8},
                                               {7, 1, 2, 6}, {10, 5, 6, 9}, {6, 2, 4, 7}};
  const auto reliability = AssessRepeats(cells);
  EXPECT_ABS(reliability->icc, 0.166, 5e-4, "printed digits");
  EXPECT_ABS(reliability->within_sd * reliability->within_sd, 6.26, 0.01, "printed digits");
  EXPECT_LT(reliability->interval.lower, 0);
  EXPECT_GT(reliability->interval.upper, 0.6);
  EXPECT_FALSE(AssessRepeats(std::vector<std::vector<double>>{{1, 2}, {1, 2, 3}}));
  EXPECT_FALSE(AssessRepeats(std::vector<std::vector<double>>{{1, 1}, {2, 2}}));
}

}  // namespace
}  // namespace haptometer::dsp
