#pragma once

#include <string>

namespace haptometer::cli {

/// `value` with its standard uncertainty in the last digits: "70.71(12)", "12350(670)",
/// "0.00123(45)". Two digits of uncertainty, rounded to even; six digits of the value where the
/// uncertainty is not above 0.
///
/// JCGM 100:2008, 7.2.2 (third form).
[[nodiscard]] std::string WithUncertainty(double value, double standard_uncertainty);

/// `value` to the place that WithUncertainty shows it to, its zeros kept: "12.30", "12350"; an end
/// of an interval beside its middle. Never "-0.00". Six digits where the uncertainty is not above
/// 0.
[[nodiscard]] std::string ToThePlaceOf(double standard_uncertainty, double value);

/// Decimals that show an interval to two digits of its width, `least` at least: 4 of [0.1234,
/// 0.1312]. `least` where the width is 0 or not finite. At most 12.
[[nodiscard]] int DecimalsOf(double lower, double upper, int least);

/// Significant digits of the larger end that do so: 4 of [225.1, 227.3], `least` at least. At most
/// 12.
[[nodiscard]] int DigitsOf(double lower, double upper, int least);

}  // namespace haptometer::cli
