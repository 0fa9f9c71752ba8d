#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "fit/drop_test/impulse_record.h"

namespace haptometer::tools {

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

/// Reads a drops file (docs/commands.md):
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

}  // namespace haptometer::tools
