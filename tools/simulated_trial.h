#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "trial/byte_io.h"
#include "trial/record.h"

namespace haptometer::tools {

/// Writes a simulated record as a trial.bin; `overwrite` replaces an older one.
/// Errors: as cli::OutputFile.
[[nodiscard]] Result<void> WriteSimulatedTrial(const std::string& path, const trial::Record& record,
                                               bool overwrite);

/// The same into any sink; `name` stands for the path in messages.
[[nodiscard]] Result<void> WriteSimulatedTrialIn(std::unique_ptr<trial::ByteSink> sink,
                                                 const std::string& name,
                                                 const trial::Record& record);

}  // namespace haptometer::tools
