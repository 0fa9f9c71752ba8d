#pragma once

#include <string>
#include <string_view>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/impedance/impedance_fit.h"
#include "sim/scene/actuator.h"
#include "tools/cli/options.h"
#include "tools/document/present.h"

namespace haptometer::tools {

/// What fit-lra and fit-impedance write beside the answer.
struct FitFiles {
  document::Outputs outputs;
  std::string save;        ///< a file for scenes and --actuator; empty: none
  bool overwrite = false;  ///< of `save`
};

/// Declares --all, --plot (`figures`: what it draws), --report, --save and --overwrite.
void DeclareFiles(cli::Options& options, FitFiles& files, std::string_view figures);

/// Whether they can be written; to be asked before long work. Errors: Cause::kUsage.
[[nodiscard]] Result<void> CheckFiles(const FitFiles& files);

/// The fitted actuator: what was given, Kv, Bv and Km with combined standard uncertainties, and
/// their correlations with each other and with what was given. A constant that is not determined
/// is left out. Errors (Cause::kUsage): one of Mv, Mc, R, L, without which no scene runs, is not
/// known.
[[nodiscard]] Result<sim::StatedActuator> FittedActuator(const fit::DropTestFit& fit,
                                                         const fit::ActuatorKnowns& knowns);

/// The same of a sweep. R and L are those that were stated, else the sweep's own.
[[nodiscard]] Result<sim::StatedActuator> FittedActuator(const fit::ImpedanceFit& fit,
                                                         const fit::ActuatorKnowns& knowns);

/// Writes it to `files.save`, where that is not empty, as a file for scenes, `simulate` and
/// --actuator (sim/scene/actuator.h), behind a comment with the provenance; `argv` is the verb's.
/// Errors: those of `actuator`; as cli::OutputFile.
[[nodiscard]] Result<void> SaveActuator(const FitFiles& files,
                                        const Result<sim::StatedActuator>& actuator,
                                        std::string_view verb, int argc, const char* const* argv);

}  // namespace haptometer::tools
