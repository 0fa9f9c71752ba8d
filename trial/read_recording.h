#pragma once

#include <string>

#include "base/result.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A measurement from a file of either kind, trial.bin or CSV, told apart by its first bytes.
///
/// For a CSV the report says closed, no losses, and the rows.
/// Errors (Cause::kCannotAnswer): as TrialReader::Open and ReadCsv; bytes that are neither give one
/// message that names both.
[[nodiscard]] Result<Recording> ReadRecording(const std::string& path);

}  // namespace haptometer::trial
