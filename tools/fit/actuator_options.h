#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/impulse_record.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// What the command line of fit-lra, fit-impedance and plan-drop-test says of an actuator.
struct ActuatorWords {
  fit::ActuatorKnowns knowns;
  std::string file;  ///< NAME|FILE of --actuator; beaten by `knowns`; empty: none
  bool held = false;
  bool is_free = false;
  std::vector<std::string> required;  ///< constants without which the status is 3
};

/// Declares --moving-mass, --resistance, --inductance and --actuator.
void DeclareCoilAndMass(cli::Options& options, ActuatorWords& words);

/// Declares --held, --free, --case-mass and --require.
void DeclareCase(cli::Options& options, ActuatorWords& words);

/// Refuses values that are out of range, held and free together, and a required constant that is
/// none of Kv, Bv, Km. Errors: Cause::kUsage.
[[nodiscard]] Result<void> Check(const ActuatorWords& words);

/// What the file of --actuator says; nothing without one. Errors: sim::FindActuator.
[[nodiscard]] Result<fit::ActuatorKnowns> KnownsOfFile(const ActuatorWords& words);

/// Options, else what the file of --actuator says. Errors: sim::FindActuator.
[[nodiscard]] Result<fit::ActuatorKnowns> KnownsOf(const ActuatorWords& words);

}  // namespace haptometer::tools
