#pragma once

#include <string>

#include "base/result.h"
#include "trial/record.h"

namespace haptometer::tools {

/// Writes a simulated record of one channel as a trial.bin; `overwrite` replaces an older one.
/// Errors: as trial::TrialWriter.
[[nodiscard]] Result<void> WriteSimulatedTrial(const std::string& path, const trial::Record& record,
                                               bool overwrite);

}  // namespace haptometer::tools
