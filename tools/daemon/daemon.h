#pragma once

#include <string>

namespace haptometer::tools {

/// Records all sensors of the file at `config_path` until SIGTERM or SIGINT, tells systemd how it
/// goes, and answers `acquire --status`. Returns the exit status: 0 once it was asked to end and
/// all trials are closed; that of the error when the file is wrong or its socket cannot be had.
[[nodiscard]] int RunDaemon(const std::string& config_path, const std::string& command_line);

}  // namespace haptometer::tools
