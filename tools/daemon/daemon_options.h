#pragma once

#include <optional>
#include <string>

#include "tools/cli/options.h"

namespace haptometer::tools {

/// The options of acquire that ask for the daemon, or for one that runs.
struct DaemonOptions {
  std::string config;  ///< --daemon
  bool wants_status = false;
  std::string asked;  ///< --status: a socket, a daemon's file, or empty for the one there is
};

void DeclareDaemon(cli::Options& options, DaemonOptions& wanted);

/// Does what they ask for and returns the exit status, or nothing where they ask for nothing. What
/// else stands on the command line is refused: the daemon's file says it.
[[nodiscard]] std::optional<int> RunDaemonOptions(const cli::Options& options,
                                                  const DaemonOptions& wanted, int argc,
                                                  const char* const* argv);

}  // namespace haptometer::tools
