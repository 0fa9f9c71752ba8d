#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/transport/descriptor.h"
#include "acquire/transport/transport.h"

namespace haptometer::acquire {

/// A serial port of the computer, opened and set up by libserialport: 8N1, no flow control.
///
/// libserialport's own reads spin after a hang-up and cannot tell it from silence (0.1.1), so bytes
/// are moved on its descriptor (transport/descriptor.h). The port is taken exclusively: flock
/// before anything is set, and TIOCEXCL against programs that do not ask.
class SerialPort final : public Transport {
 public:
  /// `path`: as libserialport wants it, below /dev; `name`: as the user gave it, for messages.
  /// What waited in the port is thrown away. A low-latency driver setting is asked for
  /// (ASYNC_LOW_LATENCY: FTDI adapters then answer within 1 ms and not 16 ms); it may be refused,
  /// so the adapter's timer is read back.
  /// Errors (Cause::kCannotAnswer): absent, no permission, busy, a baud rate that it does not have.
  [[nodiscard]] static Result<std::unique_ptr<Transport>> Open(const std::string& path,
                                                               const std::string& name, int baud);
  ~SerialPort() override;
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  [[nodiscard]] ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override;
  [[nodiscard]] Result<void> Write(std::string_view bytes, MonotonicNs deadline) override;
  /// Says the latency timer, where the adapter has one and it was read back.
  [[nodiscard]] std::string Source() const override;
  [[nodiscard]] std::optional<MonotonicNs> LatencyTimer() const override { return latency_ns_; }
  [[nodiscard]] Findings LatencyCost(MonotonicNs period_ns) const override;
  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  struct Handle;  // libserialport's port, closed and freed with it
  SerialPort(std::unique_ptr<Handle> handle, std::string name, int baud);

  std::unique_ptr<Handle> handle_;
  int descriptor_ = -1;
  std::string name_;
  int baud_;
  bool low_latency_ = false;  ///< the driver took the setting
  std::string path_;
  std::optional<MonotonicNs> latency_ns_;  ///< of the adapter's timer, after the setting
};

/// A pseudo-terminal, such as the emulator or socat gives: raw, 8N1, no hardware behind it.
///
/// Plain termios, because libserialport refuses pseudo-terminals. Always 8N1: a pseudo-terminal
/// carries no parity, and setting one fails. There is no baud rate; the wire is as fast as its
/// other end. Taken with flock, not TIOCEXCL, which would outlive us as long as the other end is
/// open.
class VirtualTerminal final : public Transport {
 public:
  /// Errors (Cause::kCannotAnswer): absent, no permission, busy, not a terminal.
  [[nodiscard]] static Result<std::unique_ptr<Transport>> Open(const std::string& path);

  [[nodiscard]] ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override;
  [[nodiscard]] Result<void> Write(std::string_view bytes, MonotonicNs deadline) override;
  [[nodiscard]] std::string Source() const override;
  [[nodiscard]] bool IsHardware() const override { return false; }
  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  VirtualTerminal(OwnedDescriptor descriptor, std::string name);

  OwnedDescriptor descriptor_;
  std::string name_;
};

/// A TCP connection, as to a serial-to-network adapter or an emulator. Small packets leave at once
/// (TCP_NODELAY).
class TcpStream final : public Transport {
 public:
  /// Connects to `host`:`service` before `timeout_ns` has passed; each address of the host is
  /// tried. Errors (Cause::kCannotAnswer): unknown host, refused, no answer in time.
  [[nodiscard]] static Result<std::unique_ptr<Transport>> Connect(const std::string& host,
                                                                  const std::string& service,
                                                                  MonotonicNs timeout_ns);

  [[nodiscard]] ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override;
  [[nodiscard]] Result<void> Write(std::string_view bytes, MonotonicNs deadline) override;
  [[nodiscard]] std::string Source() const override;
  [[nodiscard]] bool IsHardware() const override { return false; }
  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  TcpStream(OwnedDescriptor descriptor, std::string name);

  OwnedDescriptor descriptor_;
  std::string name_;
};

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

/// Bytes that another program writes: standard input, a named pipe, or a file. Nothing can be sent.
///
/// The kernel is asked to keep 1 MiB for a pipe, so that a writer is not held up while we are.
class InputPipe final : public Transport {
 public:
  /// `path`: empty or "-" is standard input. Errors (Cause::kCannotAnswer): a terminal, of which no
  /// samples come; absent, no permission, a directory.
  [[nodiscard]] static Result<std::unique_ptr<Transport>> Open(const std::string& path);

  /// kGone at the end of the input.
  [[nodiscard]] ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override;
  /// Always an error.
  [[nodiscard]] Result<void> Write(std::string_view bytes, MonotonicNs deadline) override;
  [[nodiscard]] std::string Source() const override;
  [[nodiscard]] bool IsHardware() const override { return false; }
  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  InputPipe(OwnedDescriptor descriptor, std::string name);

  OwnedDescriptor descriptor_;
  std::string name_;
};

}  // namespace haptometer::acquire
