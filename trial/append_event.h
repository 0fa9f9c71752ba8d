#pragma once

#include <string>

#include "base/error.h"
#include "trial/trial_format.h"

namespace haptometer::trial {

/// Appends `event` to a trial that exists, finished or cut short: labels given later, a remark.
///
/// Nothing that the file holds is changed. event.row is filled in. Errors: as TrialReader::Open;
/// Cause::kCannotAnswer when the file may not be written; Cause::kFailed when it is still being
/// recorded or the disk is full. Cost: reads the file once; one sync.
[[nodiscard]] Result<void> AppendEvent(const std::string& path, Event event);

}  // namespace haptometer::trial
