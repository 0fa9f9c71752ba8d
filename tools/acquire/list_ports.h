#pragma once

#include <string>
#include <vector>

#include "acquire/transport/port_list.h"

namespace haptometer::tools {

/// What `acquire --list-ports` prints: a port with what is known of it, and what its latency timer
/// costs a DL-RS1A.
[[nodiscard]] std::string PortListText(const std::vector<acquire::PortInfo>& ports);

/// The same as a JSON document (docs/commands.md), with a line's end.
[[nodiscard]] std::string PortListJson(const std::vector<acquire::PortInfo>& ports);

}  // namespace haptometer::tools
