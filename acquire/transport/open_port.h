#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "acquire/transport/transport.h"

namespace haptometer::acquire {

enum class PortKind : std::uint8_t { kNetwork, kVirtualTerminal, kSerial };

/// What `name` names: HOST:PORT, or a pseudo-terminal or serial port behind any links. Errors
/// (Cause::kCannotAnswer): absent, or no terminal.
[[nodiscard]] Result<PortKind> KindOfPort(const std::string& name);

/// HOST:PORT or [HOST]:PORT in its parts.
struct NetworkName {
  std::string host;
  std::string service;
};
[[nodiscard]] NetworkName SplitNetworkName(const std::string& name);

/// Opens what `name` says: HOST:PORT, a pseudo-terminal, or a serial port; links are followed, so
/// /dev/serial/by-id/... and an emulator's --link work.
///
/// `baud` is for serial ports; the others have none. Errors: those of the transport, and
/// Cause::kCannotAnswer for a path that is no terminal.
[[nodiscard]] Result<std::unique_ptr<Transport>> OpenPort(const std::string& name, int baud);

}  // namespace haptometer::acquire
