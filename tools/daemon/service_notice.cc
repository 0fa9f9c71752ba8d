#include "tools/daemon/service_notice.h"

#include <systemd/sd-daemon.h>

#include <cstdint>

namespace haptometer::tools {

void NotifyService(const std::string& assignments) { (void)sd_notify(0, assignments.c_str()); }

std::optional<MonotonicNs> WatchdogInterval() {
  std::uint64_t interval_us = 0;
  if (sd_watchdog_enabled(0, &interval_us) <= 0) return std::nullopt;
  return static_cast<MonotonicNs>(interval_us) * 1000;
}

}  // namespace haptometer::tools
