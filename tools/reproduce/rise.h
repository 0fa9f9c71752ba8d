#pragma once

#include <optional>

#include "sim/scene/scene.h"

namespace haptometer::tools {

/// When the skin is first `level_m` > 0 away from rest, to either side, after the drive began at
/// rest: sought in steps of a hundredth of a period, then halved. Nothing within 1 s: nothing.
[[nodiscard]] std::optional<double> TimeToReach(sim::Scene scene, double level_m);

}  // namespace haptometer::tools
