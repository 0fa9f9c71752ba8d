#pragma once

#include <memory>
#include <string>

#include "acquire/sensor/sensor.h"
#include "base/error.h"

namespace haptometer::tools {

/// The sensor of a scene, without a wire between: the rows that `simulate -o` writes, as fast as
/// they are asked for, up to the scene's duration, or without an end. Its trial says "simulated".
/// Each Begin() plays it from its start.
///
/// A scene without [sensor] gets an ideal one on the skin, with a remark.
/// Errors: those of ReadPlayedScene (tools/played_scene.h).
[[nodiscard]] Result<std::unique_ptr<acquire::Sensor>> OpenScene(const std::string& path);

}  // namespace haptometer::tools
