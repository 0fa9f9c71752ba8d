#pragma once

#include <memory>
#include <string>

#include "acquire/protocol/modbus/modbus_frame.h"
#include "acquire/transport/modbus_link.h"
#include "base/error.h"

namespace haptometer::acquire {

/// Opens `name` by libmodbus: RTU on a serial port or virtual terminal,
/// TCP for HOST:PORT, and for a HOST alone port 502.
///
/// libmodbus (3.1.6) sets the port up, connects, and takes and checks the replies. It is kept from
/// its traps: error recovery is off (it would retry for ever inside a call); a reply is only taken
/// once its first byte is there, so no call blocks in its select(); requests are written on its
/// descriptor, because modbus_send_raw_request() leaves TCP's transaction identifier at zero and
/// modbus_read_registers() waits for the whole response timeout; descriptors beyond FD_SETSIZE are
/// refused. A serial port is taken for us alone (flock before its settings change, then TIOCEXCL);
/// a virtual terminal by flock, and always 8N1, since it carries no parity.
/// Errors (Cause::kCannotAnswer): absent, no permission, busy, refused, no answer.
[[nodiscard]] Result<std::unique_ptr<ModbusLink>> OpenModbusPort(const std::string& name,
                                                                 const ModbusWire& wire);

}  // namespace haptometer::acquire
