#pragma once

#include <optional>
#include <string>

#include "base/clock.h"

namespace haptometer::tools {

/// Tells the service manager that started this process (sd_notify(3)): "READY=1\nSTATUS=...".
/// Nothing happens where none did.
void NotifyService(const std::string& assignments);

/// Within which time the service manager wants a sign of life ("WATCHDOG=1"), where it does
/// (sd_watchdog_enabled(3)).
[[nodiscard]] std::optional<MonotonicNs> WatchdogInterval();

}  // namespace haptometer::tools
