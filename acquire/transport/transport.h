#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "acquire/findings.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// How a read ended.
enum class ReadState : std::uint8_t {
  kBytes,    ///< at least one byte
  kTimeout,  ///< none before the deadline, or a signal came first: look at the clock and at the
             ///< flag
  kGone,     ///< the other end hung up; nothing will ever come again
};

struct ReadOutcome {
  ReadState state = ReadState::kTimeout;
  std::size_t bytes = 0;  ///< how many were written to the buffer; 0 unless kBytes
};

/// Moves bytes to and from a device, with deadlines on the sensor's clock. One thread only.
class Transport {
 public:
  virtual ~Transport() = default;

  /// Waits for bytes until `deadline` and takes what is there, at most buffer.size() (not 0). A
  /// deadline in the past takes what is there without waiting.
  [[nodiscard]] virtual ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) = 0;

  /// Sends all of `bytes` before `deadline`. Errors (Cause::kFailed): hung up, or not taken in
  /// time.
  [[nodiscard]] virtual Result<void> Write(std::string_view bytes, MonotonicNs deadline) = 0;

  /// Where the bytes come from, for a trial's metadata: "device: serial port /dev/ttyUSB0, 9600
  /// baud 8N1", or "virtual terminal ./sensor (not a hardware port)".
  [[nodiscard]] virtual std::string Source() const = 0;
  /// Whether the other end may be real hardware: false for virtual terminals and sockets.
  [[nodiscard]] virtual bool IsHardware() const { return true; }
  /// The adapter's latency timer (acquire/transport/port_list.h), as read when the port was opened;
  /// empty where there is none.
  [[nodiscard]] virtual std::optional<MonotonicNs> LatencyTimer() const { return std::nullopt; }
  /// What the adapter's habit of keeping short replies costs a sensor that could be polled every
  /// `period_ns` (acquire/transport/port_list.h); nothing where it costs nothing.
  [[nodiscard]] virtual Findings LatencyCost(MonotonicNs /*period_ns*/) const { return {}; }
  /// The port as the user named it, for messages.
  [[nodiscard]] virtual const std::string& name() const = 0;
};

}  // namespace haptometer::acquire
