#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/quantity.h"
#include "base/toml.h"
#include "sim/scene/effects.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// Ends of every number of a scene in its SI unit; one outside has a wrong unit.
inline constexpr double kSmallest = 1e-9, kLargest = 1e9;
/// Refuses a number that no actuator, adapter or skin of this kind has: outside these ends the
/// arithmetic, not the mechanics, would be under test.
void RefuseUnlessReal(TomlTable& table, std::string_view key, double value);

/// The number under a key that must be there, greater than 0 and real in the sense above.
[[nodiscard]] double Positive(TomlTable& table, std::string_view key, Dimension dimension);

/// The same where 0 is a value too.
[[nodiscard]] double NotNegative(TomlTable& table, std::string_view key, Dimension dimension);

/// The number of either sign under a key that may be absent, which is 0.
[[nodiscard]] double Signed(TomlTable& table, std::string_view key, Dimension dimension);

/// NotNegative where the key is present, `absent` where it is not.
[[nodiscard]] double NotNegativeOr(TomlTable& table, std::string_view key, Dimension dimension,
                                   double absent);

/// A key that only some kinds of a table's subject have.
struct KeyOfKinds {
  std::string_view key;
  std::string_view kinds;  ///< in quotes, as a message lists them: "\"burst\" or \"pulse\""
};

/// Refuses those of the keys that are present and whose kinds `kind` is not one of.
void RefuseKeysOfOtherKinds(TomlTable& table, std::span<const KeyOfKinds> keys,
                            std::string_view kind);

/// Reads [drive] of a scene: every kind of Drive, docs/reference/scene.md lists the keys.
///
/// A key that belongs to other kinds is refused. `file` of samples is looked for beside
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

/// Reads [effects] and the tables of its constants ([gravity], [travel_stops], [stiffening],
/// [coil_heating]; preload_n and contact in [skin], which may be null) out of a scene;
/// docs/reference/scene.md lists the keys. [tremor] is looked for, not read.
///
/// `effects = "auto"` in place of the table asks about every effect whose constants are stated.
/// An effect that is asked for without its constants is an error. Errors show in the root's
/// Finish().
[[nodiscard]] Effects ReadEffects(TomlTable& root, TomlTable* skin);

/// Reads a scene.toml (docs/reference/scene.md lists the keys).
///
/// Strict: an unknown key is an error that names the nearest known one, and what the format knows
/// but this version does not simulate is refused by name. A relative [actuator] or [drive] file is
/// looked for beside the scene.
/// Errors: the file's (base/input_file.h), Cause::kUsage for keys and values.
[[nodiscard]] Result<Scene> ReadSceneFile(const std::string& path);

/// The same from text; `where` stands for the file's path in errors and for relative files.
[[nodiscard]] Result<Scene> ReadSceneText(std::string_view text, const std::string& where);

}  // namespace haptometer::sim
