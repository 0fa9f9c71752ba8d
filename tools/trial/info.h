#pragma once

#include <string>

#include "trial/trial_reader.h"

namespace haptometer::tools {

/// Prints what a recording holds: source, channels, rows, times, statuses, gaps, labels, losses.
void PrintTrialInfo(const std::string& path, const trial::Recording& recording);

/// The same as one JSON document (docs/reference/trial.md); unknown is null.
void PrintTrialInfoJson(const std::string& path, const trial::Recording& recording);

}  // namespace haptometer::tools
