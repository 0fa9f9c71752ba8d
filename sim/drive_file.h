#pragma once

#include <string>

#include "base/toml.h"
#include "sim/drive.h"

namespace haptometer::sim {

/// Reads [drive] of a scene: every kind of Drive, docs/notation.md lists the keys.
///
/// A kind's keys that it has no use for are unknown keys. `file` of samples is looked for beside
/// `scene_path`: text, the line `voltage_v`, then a number of volts a line; its faults are told
/// with its own line. Errors show in the table's Finish().
[[nodiscard]] Drive ReadDrive(TomlTable& table, const std::string& scene_path);

/// What [mounting] says.
struct Mounting {
  Grip grip;
  double blow_m_per_s =
      0;  ///< the mover's speed at t = 0: of a case that fell and was stopped dead
};

/// Reads [mounting] kind = "free", "grip", "held" or "drop"; absent: free.
[[nodiscard]] Mounting ReadMounting(TomlTable* table);

/// Reads the finger's motion out of a table: amplitude_m, frequency_hz and phase_rad of one tone,
/// or several of those as [[...tone]].
[[nodiscard]] FingerMotion ReadFingerMotion(TomlTable& table);

}  // namespace haptometer::sim
