#pragma once

#include <string>
#include <string_view>

#include "base/error.h"
#include "sim/scene.h"

namespace haptometer::sim {

/// Reads a scene.toml (docs/notation.md lists the keys).
///
/// Strict: an unknown key is an error that names the nearest known one, and what the format knows
/// but this version does not simulate is refused by name. A relative [actuator] or [drive] file is
/// looked for beside the scene.
/// Errors: the file's (base/input_file.h), Cause::kUsage for keys and values.
[[nodiscard]] Result<Scene> ReadSceneFile(const std::string& path);

/// The same from text; `where` stands for the file's path in errors and for relative files.
[[nodiscard]] Result<Scene> ReadSceneText(std::string_view text, const std::string& where);

}  // namespace haptometer::sim
