#pragma once

namespace haptometer::dsp {

/// x with P(chi-squared <= x) = `probability` (0 to 1, exclusive) for `degrees_of_freedom` > 0, any
/// real number. Boost.Math; relative error below 1e-13.
[[nodiscard]] double ChiSquaredQuantile(double probability, double degrees_of_freedom);

}  // namespace haptometer::dsp
