#pragma once

#include <string>

#include "sim/scene/scene.h"

namespace haptometer::tools {

/// "5 V at 225 Hz", "tones of 1 V at 40 Hz and 2 V at 225 Hz", "a burst of 5 V at 225 Hz from 0 to
/// 0.03 s", with the source's resistance where there is one.
[[nodiscard]] std::string DriveText(const sim::Drive& drive);

/// "a sine", "tones", "a burst", "a chirp", "a pulse", "samples".
[[nodiscard]] std::string KindText(sim::DriveKind kind);

}  // namespace haptometer::tools
