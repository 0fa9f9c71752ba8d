#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "base/toml.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/impedance/impedance_fit.h"
#include "sim/scene/actuator.h"
#include "tools/cli/options.h"
#include "tools/document/present.h"

namespace haptometer::tools {

/// A number that an option, a TOML file and the header of a recording may state, with its range.
struct Statement {
  std::string_view key;     ///< in files: "moving_mass_kg"
  std::string_view option;  ///< "--moving-mass"; empty: none
  Dimension dimension;
  cli::Bounds bounds;
  std::string_view help;  ///< of the option

  /// Declares the option.
  cli::Option& Declare(cli::Options& options, std::optional<Quantity>* value) const;
  /// What the table states under the key; what is out of range is refused.
  [[nodiscard]] std::optional<Quantity> Read(TomlTable& table) const;
};

/// A number of an actuator that a fit takes and a scene cannot do without.
struct KnownNumber : Statement {
  std::string_view input;  ///< its name among the inputs of a fit
  std::size_t place;       ///< in sim::kActuatorSymbols
  std::optional<Quantity> fit::ActuatorKnowns::* known;
  Quantity sim::StatedActuator::* stated;
};

/// Moving mass, case mass, resistance, inductance.
[[nodiscard]] std::span<const KnownNumber> KnownNumbers();

/// What the command line of fit-lra, fit-impedance and plan-drop-test says of an actuator.
struct ActuatorWords {
  fit::ActuatorKnowns knowns;
  std::string file;  ///< NAME|FILE of --actuator; beaten by `knowns`; empty: none
  bool held = false;
  bool is_free = false;
  std::vector<std::string> required;  ///< constants without which the status is 3
};

/// Declares --moving-mass, --resistance, --inductance and --actuator; `has_case`: also --held,
/// --free, --case-mass and --require.
void DeclareActuator(cli::Options& options, ActuatorWords& words, bool has_case);

/// Refuses a required constant that is none of Kv, Bv, Km. Errors: Cause::kUsage.
[[nodiscard]] Result<void> Check(const ActuatorWords& words);

/// What the file of --actuator says; nothing without one. Errors: sim::FindActuator.
[[nodiscard]] Result<fit::ActuatorKnowns> KnownsOfFile(const ActuatorWords& words);

/// Options, else what the file of --actuator says. Errors: sim::FindActuator.
[[nodiscard]] Result<fit::ActuatorKnowns> KnownsOf(const ActuatorWords& words);

/// What fit-lra and fit-impedance write beside the answer.
struct FitFiles {
  document::Outputs outputs;
  std::string save;        ///< a file for scenes and --actuator; empty: none
  bool overwrite = false;  ///< of `save`
};

/// Declares --all, --plot (`figures`: what it draws), --report, --save and --overwrite.
void DeclareFiles(cli::Options& options, FitFiles& files, std::string_view figures);

/// Whether `save` can be written; to be asked before long work. Errors: Cause::kUsage.
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

/// `actuator`, or the error that stands in its place where a refusal is among the findings of
/// `answer`: constants that are not to be used are not saved.
[[nodiscard]] Result<sim::StatedActuator> UnlessRefused(const document::Document& answer,
                                                        const FitFiles& files,
                                                        Result<sim::StatedActuator> actuator);

/// Writes it to `files.save`, where that is not empty, as a file for scenes, `simulate` and
/// --actuator (sim/scene/actuator.h), behind a comment with the provenance; `argv` is the verb's.
/// Returns the exit status, after an error is reported: those of `actuator`; as cli::OutputFile.
[[nodiscard]] int SaveActuator(const FitFiles& files, const Result<sim::StatedActuator>& actuator,
                               std::string_view verb, int argc, const char* const* argv);

}  // namespace haptometer::tools
