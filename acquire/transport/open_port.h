#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/transport/transport.h"

namespace haptometer::acquire {

enum class PortKind : std::uint8_t { kNetwork, kVirtualTerminal, kSerial };

/// What `name` names: HOST:PORT, or a pseudo-terminal or serial port behind any links. Errors:
/// Cause::kUsage for a PORT that is none; Cause::kCannotAnswer where it is absent, or no terminal.
[[nodiscard]] Result<PortKind> KindOfPort(const std::string& name);

/// HOST:PORT or [HOST]:PORT in its parts.
struct NetworkName {
  std::string host;
  std::string service;
};
[[nodiscard]] NetworkName SplitNetworkName(const std::string& name);

/// The TCP port that `text` spells in decimal digits, 0 to 65535; nothing for other text. The
/// system's own functions take larger numbers modulo 65536.
[[nodiscard]] std::optional<int> TcpPort(std::string_view text);

/// Opens what `name` says: HOST:PORT, a pseudo-terminal, or a serial port; links are followed, so
/// /dev/serial/by-id/... and an emulator's --link work.
///
/// `baud` is for serial ports; the others have none. Errors: those of the transport, and
/// Cause::kCannotAnswer for a path that is no terminal.
[[nodiscard]] Result<std::unique_ptr<Transport>> OpenPort(const std::string& name, int baud);

}  // namespace haptometer::acquire
