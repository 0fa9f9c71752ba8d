#pragma once

#include <string>

#include "base/error.h"
#include "tools/tune/tune_output.h"

namespace haptometer::tools {

/// Draws the objective and the mover's travel around the optimum, each of the adapter's numbers
/// from 0.7 to 1.3 of itself with the others held (and the spring with the skin side's mass chosen
/// anew), and the ridge where there is one. Errors: as plot::DrawPanels.
[[nodiscard]] Result<void> DrawTune(const std::string& path, const TuneAnswer& answer);

}  // namespace haptometer::tools
