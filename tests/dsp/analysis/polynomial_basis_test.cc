#include "dsp/analysis/polynomial_basis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace haptometer::dsp {
namespace {

std::vector<double> StepAt(std::size_t size, std::size_t at) {
  std::vector<double> step(size, 0);
  for (std::size_t k = at; k < size; ++k) step[k] = 1;
  return step;
}

double SquareSum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

// degrees far above 2 sqrt(samples), where the recurrence of three terms has lost all digits
TEST(PolynomialBasis, TakesOutWhatItHoldsAndNothingTwice) {
  constexpr std::size_t kSize = 300;
  const PolynomialBasis basis(kSize, 80);
  std::vector<double> chebyshev(kSize);
  for (std::size_t k = 0; k < kSize; ++k) {
    const double x = (2 * static_cast<double>(k) + 1) / kSize - 1;
    chebyshev[k] = std::cos(80 * std::acos(x));
  }
  const double before = SquareSum(chebyshev);
  basis.TakeOut(chebyshev);
  EXPECT_LT(SquareSum(chebyshev), 1e-24 * before);

  std::vector<double> once = StepAt(kSize, 117);
  basis.TakeOut(once);
  std::vector<double> twice = once;
  basis.TakeOut(twice);
  for (std::size_t k = 0; k < kSize; ++k) EXPECT_NEAR(twice[k], once[k], 1e-13);
}

TEST(PolynomialBasis, KnowsWhatItLeavesOfAStep) {
  const PolynomialBasis basis(200, 30);
  for (const std::size_t at : {std::size_t{0}, std::size_t{3}, std::size_t{90}, std::size_t{199}}) {
    std::vector<double> step = StepAt(200, at);
    basis.TakeOut(step);
    EXPECT_NEAR(basis.step_norms()[at], SquareSum(step), 1e-11) << at;
  }
}

}  // namespace
}  // namespace haptometer::dsp
