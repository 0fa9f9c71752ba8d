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

/// Declares --drop-height, --rebound, --release-current, --voltage-scale or --time-scale for
/// `stated`.
cli::Option& DeclareDropNumber(cli::Options& options, std::string_view name,
                               fit::ImpulseRecord& stated);

/// Seconds of a record, both ends may be infinite.
struct FitWindow {
  double from_s = 0;
  double to_s = 0;
};

/// What the command line of fit-lra says; every statement here overrides the files' headers
/// and a drops file, which overrides the headers too.
struct FitLraOptions {
  std::vector<std::string> files;              ///< with the load of their header; or one drops file
  std::vector<std::vector<std::string>> open;  ///< groups of files, open circuit
  std::vector<std::vector<std::string>> loads;  ///< groups: a resistance, then files
  ActuatorWords actuator;
  bool is_robust = false;           ///< Huber's loss in place of squares
  fit::ImpulseRecord stated;        ///< of every drop; without samples
  std::optional<FitWindow> window;  ///< the part of each record that is fitted; absent: all
  trial::ImportOptions import;      ///< how to read tables of other programs
};

/// Reads "A:B", either of which may be left out, of --window. Errors: Cause::kUsage.
[[nodiscard]] Result<FitWindow> ParseWindow(const std::string& text);

/// The drops that can be fitted, what is known of the actuator, and what was left out.
struct FitLraInput {
  std::vector<fit::ImpulseRecord> records;
  std::vector<fit::PreparedRecord> prepared;  ///< one of each, for the fit
  fit::ActuatorKnowns knowns;
  trial::Findings reading;                    ///< what is lost and what was assumed, by files
  document::Section replaced;                 ///< its findings: statements that replaced others
  fit::Findings findings;                     ///< of headers, and of what was done with drops
  std::vector<document::DataSource> sources;  ///< of the recordings, each once
  std::vector<Error> left_out;                ///< files that cannot be fitted; the others still are
  std::vector<fit::LeftOutDrop> left_out_drops;  ///< those of them that could be read
};

/// Reads the files and lays options over headers.
///
/// Errors: Cause::kUsage for impossible options (no file, a group without files);
/// Cause::kCannotAnswer for an actuator that cannot be read and for files whose headers contradict
/// each other. Files that cannot be used are in `left_out`.
[[nodiscard]] Result<FitLraInput> GatherFitLraInput(const FitLraOptions& options);

/// The drops of one actuator.
struct DropsFile {
  std::string path;
  fit::ActuatorKnowns knowns;
  /// At least one, in the file's order, without samples. The name is the recording's path, from
  /// where the program runs; what is absent is left to the recording's header.
  std::vector<fit::ImpulseRecord> drops;
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

/// One drop or tap counts once: the same file again, or a copy of it, would narrow the intervals
/// without new data. Errors (Cause::kUsage): two paths lead to one file, or to two files with the
/// same bytes. Cost: files of equal size are read once, for a checksum that the provenance has too.
[[nodiscard]] Result<void> CheckDistinct(const std::vector<std::string>& paths);

}  // namespace haptometer::tools
