#pragma once

#include <optional>
#include <string>

#include "base/error.h"
#include "tools/cli/options.h"
#include "tools/document/present.h"

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
///
/// The daemon records all sensors of its file until SIGTERM or SIGINT, tells systemd how it goes,
/// and answers `acquire --status`. Its status is 0 once it was asked to end and all trials are
/// closed. Errors: the file is wrong, its socket cannot be had, or no daemon answers.
[[nodiscard]] Result<std::optional<int>> RunDaemonOptions(const DaemonOptions& wanted,
                                                          const document::Outputs& outputs,
                                                          int argc, const char* const* argv);

}  // namespace haptometer::tools
