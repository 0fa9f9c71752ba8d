#pragma once

#include <ctime>
#include <string>

#include "base/error.h"

namespace haptometer::tools {

/// The instant that `text` names in local time: "17:30", "17:30:15" (the next one after `now`), or
/// "2026-03-01T17:30[:15]" (after `now`). Wall clock: only the distance from `now` is meant to be
/// used, once, on a monotonic clock.
///
/// Across a change to or from summer time it is the wall's clock that counts; of an hour that comes
/// twice, the system's choice. Errors (Cause::kUsage, naming --until): another form, a time that
/// the calendar does not have, one that has passed or is beyond 30 years.
[[nodiscard]] Result<std::time_t> ParseUntil(const std::string& text, std::time_t now);

}  // namespace haptometer::tools
