#pragma once

#include <memory>
#include <optional>
#include <string>

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
  [[nodiscard]] std::string LatencyCost(MonotonicNs period_ns) const override;
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

}  // namespace haptometer::acquire
