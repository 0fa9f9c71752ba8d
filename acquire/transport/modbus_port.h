#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/protocol/modbus.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// How waiting for a reply ended.
enum class ModbusArrival : std::uint8_t {
  kFrame,    ///< `bytes` is a whole frame, of which CRC (RTU) and length hold
  kDamaged,  ///< bytes came and were taken that are no such frame; `fault` says why
  kEcho,     ///< RTU: the request that was sent last came back and was taken; once a request
  kNothing,  ///< no whole one before the deadline, or a signal came first; TCP: `fault` is kLength
             ///< where a part of one is there
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
  /// what came instead. RTU: waits until `deadline` for its first byte and at most 20 ms longer for
  /// its last: a frame that needs more time on the wire is waited for in further calls. TCP: waits
  /// until `deadline` for its last byte, in as many pieces as it comes in; what has come by then is
  /// kept for the next call. A header that is none of Modbus, or states more than 254 bytes, is
  /// damage at once, and what waits behind it is thrown away.
  [[nodiscard]] virtual ModbusReply Receive(std::size_t expected_bytes, MonotonicNs deadline) = 0;

  /// Throws away what is there now, a part of a reply too; how many bytes it was.
  virtual std::size_t Flush() = 0;

  [[nodiscard]] virtual ModbusFraming framing() const = 0;
  /// Where the frames come from, for a trial's metadata.
  [[nodiscard]] virtual std::string Source() const = 0;
  /// As Transport::LatencyTimer().
  [[nodiscard]] virtual std::optional<MonotonicNs> LatencyTimer() const { return std::nullopt; }
  /// The port as the user named it, for messages.
  [[nodiscard]] virtual const std::string& name() const = 0;
};

/// Opens `name` by libmodbus: RTU on a serial port or virtual terminal,
/// TCP for HOST:PORT, and for a HOST alone port 502.
///
/// libmodbus (3.1.6) sets the port up, connects, and takes and checks the replies. It is kept from
/// its traps: error recovery is off (it would retry for ever inside a call); a reply is only taken
/// once its first byte is there, so no call blocks in its select(), and over TCP not by libmodbus,
/// which waits for it in one call; requests are written on its
/// descriptor, because modbus_send_raw_request() leaves TCP's transaction identifier at zero and
/// modbus_read_registers() waits for the whole response timeout; descriptors beyond FD_SETSIZE are
/// refused; a request that an adapter with local echo gives back is taken off before the reply.
/// A serial port is taken for us alone (flock before its settings change, then TIOCEXCL);
/// a virtual terminal by flock, and always 8N1, since it carries no parity.
/// Errors (Cause::kCannotAnswer): absent, no permission, busy, refused, no answer.
[[nodiscard]] Result<std::unique_ptr<ModbusLink>> OpenModbusPort(const std::string& name,
                                                                 const ModbusWire& wire);

}  // namespace haptometer::acquire
