// The oracle is the closed form: samples made of a, a', b and b'.
#include "dsp/spectrum/changing_sine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(ChangingSine, IsRecoveredFromItsSamples) {
  for (const std::size_t count : {40U, 41U, 333U}) {
    const double step_rad = 0.37;
    const auto n = static_cast<double>(count);
    std::vector<double> samples(count);
    double square_sum = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double from_middle = static_cast<double>(k) - 0.5 * (n - 1);
      const double u = from_middle / (0.5 * n);
      samples[k] = (3 + 0.5 * u) * std::cos(step_rad * from_middle) +
                   (-2 + 0.25 * u) * std::sin(step_rad * from_middle);
      square_sum += samples[k] * samples[k];
    }
    const ChangingSine fit = FitChangingSine(samples, step_rad);
    EXPECT_REL(fit.amplitude.real(), 3.0, 1e-12, "rounding of the sums");
    EXPECT_REL(fit.amplitude.imag(), 2.0, 1e-12, "rounding of the sums");
    EXPECT_REL(fit.slope.real(), 0.5, 1e-11, "rounding of the sums");
    EXPECT_REL(fit.slope.imag(), -0.25, 1e-11, "rounding of the sums");
    EXPECT_REL(fit.square_sum, square_sum, 1e-13, "rounding of the sum");
    EXPECT_LT(fit.residual_sum, 1e-11 * square_sum);
  }
}

// a cubic envelope is what the model does not have
TEST(ChangingSine, LeavesWhatIsNotLinear) {
  std::vector<double> samples(200);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double u = (static_cast<double>(k) - 99.5) / 100;
    samples[k] = u * u * std::cos(0.37 * (static_cast<double>(k) - 99.5));
  }
  const ChangingSine fit = FitChangingSine(samples, 0.37);
  // u^2 less its mean 1/3: 1/5 - 1/9 = 4/45 of a mean square 1/5
  EXPECT_REL(fit.residual_sum / fit.square_sum, 4.0 / 9, 0.03,
             "sums over 12 periods, no integrals");
}

}  // namespace
}  // namespace haptometer::dsp
