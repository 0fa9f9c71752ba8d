#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/protocol/modbus/modbus_frame.h"
#include "base/clock.h"

namespace haptometer::acquire {

/// How waiting for a reply ended.
enum class ModbusArrival : std::uint8_t {
  kFrame,    ///< `bytes` is a whole frame, of which CRC (RTU) and length hold
  kDamaged,  ///< bytes came and were taken that are no such frame; `fault` says why
  kNothing,  ///< none before the deadline, or a signal came first
  kGone,     ///< the other end hung up; nothing will ever come again
};

struct ModbusReply {
  ModbusArrival arrival = ModbusArrival::kNothing;
  std::string_view bytes{};  ///< valid until the next call
  ModbusFault fault = ModbusFault::kNone;
};

/// Moves Modbus frames to and from a device; says nothing of what they mean. One thread only.
class ModbusLink {
 public:
  virtual ~ModbusLink() = default;

  /// Sends a whole frame; false when the other end is gone or does not take it.
  [[nodiscard]] virtual bool Send(std::string_view frame) = 0;

  /// The next frame, of which `expected_bytes` are expected (an exception reply is shorter), or
  /// what came instead. Waits until `deadline` for its first byte and at most 20 ms longer for its
  /// last: a frame that needs more time on the wire is waited for in further calls.
  [[nodiscard]] virtual ModbusReply Receive(std::size_t expected_bytes, MonotonicNs deadline) = 0;

  /// Throws away what is there now; how many bytes it was.
  virtual std::size_t Flush() = 0;

  [[nodiscard]] virtual ModbusFraming framing() const = 0;
  /// Where the frames come from, for a trial's metadata.
  [[nodiscard]] virtual std::string Source() const = 0;
  /// As Transport::LatencyTimer().
  [[nodiscard]] virtual std::optional<MonotonicNs> LatencyTimer() const { return std::nullopt; }
  /// The port as the user named it, for messages.
  [[nodiscard]] virtual const std::string& name() const = 0;
};

}  // namespace haptometer::acquire
