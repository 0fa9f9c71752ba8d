#pragma once

#include <memory>
#include <string>

#include "acquire/transport/transport.h"

namespace haptometer::acquire {

/// Opens what `name` says: HOST:PORT, a pseudo-terminal, or a serial port; links are followed, so
/// /dev/serial/by-id/... and an emulator's --link work.
///
/// `baud` is for serial ports; the others have none. Errors: those of the transport, and
/// Cause::kCannotAnswer for a path that is no terminal.
[[nodiscard]] Result<std::unique_ptr<Transport>> OpenPort(const std::string& name, int baud);

}  // namespace haptometer::acquire
