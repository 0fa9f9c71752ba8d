#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/transport/transport.h"

namespace haptometer::acquire {

/// Opens a serial port of the computer, set up by libserialport: 8N1, no flow control.
///
/// libserialport's own reads spin after a hang-up and cannot tell it from silence (0.1.1), so bytes
/// are moved on its descriptor (transport/descriptor.h). The port is taken exclusively: flock
/// before anything is set, and TIOCEXCL against programs that do not ask.
///
/// `path`: as libserialport wants it, below /dev; `name`: as the user gave it, for messages. What
/// waited in the port is thrown away. A low-latency driver setting is asked for
/// (ASYNC_LOW_LATENCY: FTDI adapters then answer within 1 ms and not 16 ms); it may be refused, so
/// the adapter's timer is read back, and Source() says it.
/// Errors (Cause::kCannotAnswer): absent, no permission, busy, a baud rate that it does not have.
[[nodiscard]] Result<std::unique_ptr<Transport>> OpenSerialPort(const std::string& path,
                                                                const std::string& name, int baud);

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

/// Opens what `name` says: HOST:PORT, a pseudo-terminal, or a serial port (OpenSerialPort); links
/// are followed, so /dev/serial/by-id/... and an emulator's --link work.
///
/// A pseudo-terminal, such as the emulator or socat gives, has no hardware behind it and carries no
/// parity: always 8N1, set with plain termios, because libserialport refuses it. Taken with flock,
/// not TIOCEXCL, which would outlive us as long as the other end is open.
/// A TCP connection, as to a serial-to-network adapter or an emulator: each address of the host is
/// tried within 5 s, and small packets leave at once (TCP_NODELAY).
///
/// `baud` is for serial ports; the others have none: they are as fast as their other end.
/// Errors (Cause::kCannotAnswer): absent, no permission, busy, no terminal; unknown host, refused,
/// no answer in time.
[[nodiscard]] Result<std::unique_ptr<Transport>> OpenPort(const std::string& name, int baud);

/// Opens bytes that another program writes: standard input (`path` is empty or "-"), a named pipe,
/// or a file. Nothing can be sent; the end of the input is ReadState::kGone.
///
/// The kernel is asked to keep 1 MiB for a pipe, so that a writer is not held up while we are.
/// Errors (Cause::kCannotAnswer): a terminal, of which no samples come; absent, no permission, a
/// directory.
[[nodiscard]] Result<std::unique_ptr<Transport>> OpenInputPipe(const std::string& path);

/// Starts `command` by /bin/sh and reads its standard output as OpenInputPipe does; its end is
/// ReadState::kGone. The command and all that it has started end with the object: SIGTERM, and
/// SIGKILL after 1 s. Errors (Cause::kFailed): the shell does not start.
[[nodiscard]] Result<std::unique_ptr<Transport>> OpenCommandPipe(const std::string& command);

}  // namespace haptometer::acquire
