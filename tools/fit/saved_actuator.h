#pragma once

#include <string>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/impedance/impedance_fit.h"
#include "sim/scene/actuator.h"

namespace haptometer::tools {

/// The fitted actuator: what was given, Kv, Bv and Km with combined standard uncertainties, and
/// their correlations with each other and with what was given. A constant that is not determined
/// is left out. Errors (Cause::kUsage): one of Mv, Mc, R, L, without which no scene runs, is not
/// known.
[[nodiscard]] Result<sim::StatedActuator> FittedActuator(const fit::DropTestFit& fit,
                                                         const fit::ActuatorKnowns& knowns);

/// The same of a sweep. R and L are those that were stated, else the sweep's own.
[[nodiscard]] Result<sim::StatedActuator> FittedActuator(const fit::ImpedanceFit& fit,
                                                         const fit::ActuatorKnowns& knowns);

/// Writes it as a file for scenes, `simulate` and --actuator (sim/scene/actuator.h). Errors: those
/// of `actuator`; as cli::OutputFile.
[[nodiscard]] Result<void> SaveActuator(const std::string& path, bool overwrite,
                                        const Result<sim::StatedActuator>& actuator);

}  // namespace haptometer::tools
