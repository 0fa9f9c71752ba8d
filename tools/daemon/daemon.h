#pragma once

#include <optional>
#include <string>

#include "base/clock.h"
#include "tools/cli/options.h"
#include "tools/document/present.h"

namespace haptometer::tools {

/// Records all sensors of the file at `config_path` until SIGTERM or SIGINT, tells systemd how it
/// goes, and answers `acquire --status`. Returns the exit status: 0 once it was asked to end and
/// all trials are closed; that of the error when the file is wrong or its socket cannot be had.
[[nodiscard]] int RunDaemon(const std::string& config_path, const std::string& command_line);

/// The options of acquire that ask for the daemon, or for one that runs.
struct DaemonOptions {
  std::string config;  ///< --daemon
  bool wants_status = false;
  std::string asked;  ///< --status: a socket, a daemon's file, or empty for the one there is
};

void DeclareDaemon(cli::Options& options, DaemonOptions& wanted);

/// Does what they ask for and returns the exit status, or nothing where they ask for nothing. What
/// else stands on the command line is refused: the daemon's file says it.
[[nodiscard]] std::optional<int> RunDaemonOptions(const DaemonOptions& wanted,
                                                  const document::Outputs& outputs, int argc,
                                                  const char* const* argv);

/// Tells the service manager that started this process (sd_notify(3)): "READY=1\nSTATUS=...".
/// Nothing happens where none did.
void NotifyService(const std::string& assignments);

/// Within which time the service manager wants a sign of life ("WATCHDOG=1"), where it does
/// (sd_watchdog_enabled(3)).
[[nodiscard]] std::optional<MonotonicNs> WatchdogInterval();

}  // namespace haptometer::tools
