#pragma once

#include "base/error.h"
#include "sim/sweep/sweep_points.h"
#include "sim/sweep/varied_scene.h"

namespace haptometer::tools {

/// Whether the scene takes what the axes give it, asked before any work: each value (of more than
/// 1000 on an axis some 1000, of a sampled one its ends and some points') with the other keys at
/// their first values and at their last. One that is taken beside neither is refused; one that is
/// refused only beside others is for the row of its point to tell.
///
/// Errors: the scene's, under the key's name ("--vary drive.frequency_hz = 0").
/// Cost: about 20 us a value.
[[nodiscard]] Result<void> CheckAxes(const sim::VariedScene& scene, const sim::SweepPoints& points);

}  // namespace haptometer::tools
