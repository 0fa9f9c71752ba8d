#pragma once

#include <string>

#include "base/result.h"
#include "fit/drop_test_fit.h"
#include "fit/impulse_record.h"

namespace haptometer::tools {

/// The fitted actuator as a file for scenes, `simulate` and --actuator (sim/actuator.h): what was
/// given, Kv, Bv and Km with combined standard uncertainties, and their correlations with each
/// other and with what was given.
///
/// Errors (Cause::kUsage): one of the four given numbers, without which no scene runs, is missing.
/// A constant that is not determined is left out.
[[nodiscard]] Result<std::string> ActuatorText(const fit::DropTestFit& fit,
                                               const fit::ActuatorKnowns& knowns);

}  // namespace haptometer::tools
