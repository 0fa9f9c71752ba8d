#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/finding.h"
#include "base/quantity.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/drop_test/prepared_record.h"
#include "tools/document/document.h"
#include "tools/document/provenance.h"
#include "tools/fit/actuator.h"
#include "trial/import/import_options.h"

namespace haptometer::tools {

/// What the command line of fit-lra says; every statement here overrides the files' headers
/// and a drops file, which overrides the headers too.
struct FitLraOptions {
  std::vector<std::string> files;              ///< with the load of their header; or one drops file
  std::vector<std::vector<std::string>> open;  ///< groups of files, open circuit
  std::vector<std::vector<std::string>> loads;  ///< groups: a resistance, then files
  ActuatorWords actuator;
  bool is_robust = false;  ///< Huber's loss in place of squares
  std::optional<Quantity> drop_height_m;
  std::optional<Quantity> rebound;
  std::optional<Quantity> release_current_a;
  std::optional<Quantity> voltage_scale;
  std::optional<Quantity> time_scale;
  std::string window;           ///< "A:B": the part of each record that is fitted, in s; empty: all
  trial::ImportOptions import;  ///< how to read tables of other programs
};

/// What is found while statements of several places are laid over each other.
enum class StatementFinding : std::uint8_t { kReplaced };

/// The drops that can be fitted, what is known of the actuator, and what was left out.
struct FitLraInput {
  std::vector<fit::ImpulseRecord> records;
  std::vector<fit::PreparedRecord> prepared;  ///< one of each, for the fit
  fit::ActuatorKnowns knowns;
  trial::Findings reading;                    ///< what is lost and what was assumed, by files
  Findings<StatementFinding> replaced;        ///< statements that replaced others
  fit::Findings findings;                     ///< of headers, and of what was done with drops
  std::vector<document::DataSource> sources;  ///< of the recordings, each once
  std::vector<Error> left_out;                ///< files that cannot be fitted; the others still are
  std::vector<fit::LeftOutDrop> left_out_drops;  ///< those of them that could be read
};

/// Refuses options whose value is out of range, and held and free together. Errors: Cause::kUsage.
[[nodiscard]] Result<void> CheckFitLraOptions(const FitLraOptions& options);

/// Reads the files and lays options over headers.
///
/// Errors: Cause::kUsage for impossible options (no file, held and free, a value out of range, a
/// group without files); Cause::kCannotAnswer for an actuator that cannot be read and for files
/// whose headers contradict each other. Files that cannot be used are in `left_out`.
[[nodiscard]] Result<FitLraInput> GatherFitLraInput(const FitLraOptions& options);

/// One drop as a drops file states it; what is absent is left to the recording's header.
struct StatedDrop {
  std::string path;  ///< of the recording, from where the program runs
  std::optional<Quantity> load_ohm{};
  std::optional<fit::CaseCondition> condition{};
  std::optional<Quantity> drop_height_m{};
  std::optional<Quantity> rebound{};
  std::optional<Quantity> release_current_a{};
  std::optional<Quantity> added_mass_kg{};
  std::optional<Quantity> voltage_scale{};
  std::optional<Quantity> time_scale{};
};

/// The drops of one actuator.
struct DropsFile {
  std::string path;
  fit::ActuatorKnowns knowns;
  std::vector<StatedDrop> drops;  ///< at least one, in the file's order
};

/// Whether a file given to fit-lra is a drops file and no recording: its name ends in .toml.
[[nodiscard]] bool IsDropsFile(std::string_view path);

/// Reads a drops file (docs/reference/fit-lra.md):
///
///     moving_mass_kg = "1.420(10)g"      # also case_mass_kg, resistance_ohm, inductance_h
///
///     [[drop]]
///     file = "open1.csv"                 # or files = ["open1.csv", "open2.csv"], beside this file
///     load_ohm = "open"                  # also case, drop_height_m, rebound,
///                                        # release_current_a, added_mass_kg, voltage_scale,
///                                        # time_scale: the keys of an impulse file's header
///
/// Errors: the file's (base/input_file.h); Cause::kCannotAnswer for broken TOML; Cause::kUsage for
/// an unknown key, which is named with the nearest known one, a drop without a file or with both
/// keys, no drop, a value out of its range.
[[nodiscard]] Result<DropsFile> ReadDropsFile(const std::string& path);

/// The same out of text; `path` is the file's name for errors and for what lies beside it.
[[nodiscard]] Result<DropsFile> ReadDropsText(std::string_view text, const std::string& path);

/// Everything that fit-lra answers.
struct FitLraAnswer {
  FitLraInput input;
  std::optional<fit::DropTestFit> fit{};  ///< absent: no record could be fitted
  fit::Findings doubts{};                 ///< what is unlike an actuator
  std::vector<std::string> required{};    ///< "Km": constants without which there is no answer
};

/// What the findings of statements say.
[[nodiscard]] document::Sentence SentenceOf(StatementFinding kind);

/// The answer as a document (docs/reference/fit-lra.md): the constants, the budget of their
/// uncertainties, records, given numbers, and what was found; where nothing could be fitted, the
/// same keys without values. Its figures, where they are asked for, are those of FitLraFigures.
[[nodiscard]] document::Document FitLraDocument(const FitLraAnswer& answer, bool has_figures);

}  // namespace haptometer::tools
