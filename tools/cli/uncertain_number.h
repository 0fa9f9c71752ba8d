#pragma once

#include <string>

namespace haptometer::cli {

/// `value` with its standard uncertainty in the last digits: "70.71(12)", "12350(670)",
/// "0.00123(45)". Two digits of uncertainty, rounded to even; six digits of the value where the
/// uncertainty is not above 0.
///
/// JCGM 100:2008, 7.2.2 (third form).
[[nodiscard]] std::string WithUncertainty(double value, double standard_uncertainty);

}  // namespace haptometer::cli
