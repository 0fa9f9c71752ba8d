#pragma once

#include <string>

#include "base/error.h"
#include "sim/scene/scene.h"

namespace haptometer::tools {

/// A scene that can be played as a motion. Errors: those of sim::ReadSceneFile;
/// Cause::kCannotAnswer for a steady state that does not exist.
[[nodiscard]] Result<sim::Scene> ReadPlayedScene(const std::string& path);

}  // namespace haptometer::tools
