#pragma once

#include <string>

#include "base/toml_table.h"
#include "sim/drive.h"

namespace haptometer::sim {

/// Reads [drive] of a scene: every kind of Drive, docs/notation.md lists the keys.
///
/// A kind's keys that it has no use for are unknown keys. `file` of samples is looked for beside
/// `scene_path`: text, the line `voltage_v`, then a number of volts a line; its faults are told
/// with its own line. Errors show in the table's Finish().
[[nodiscard]] Drive ReadDrive(TomlTable& table, const std::string& scene_path);

/// Reads [mounting] kind = "free" or "grip"; absent: free.
[[nodiscard]] Grip ReadMounting(TomlTable* table);

/// Reads the finger's motion out of a table: amplitude_m, frequency_hz and phase_rad of one tone,
/// or several of those as [[...tone]].
[[nodiscard]] FingerMotion ReadFingerMotion(TomlTable& table);

}  // namespace haptometer::sim
