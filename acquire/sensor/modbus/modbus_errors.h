#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "acquire/protocol/modbus/modbus_frame.h"

namespace haptometer::acquire {

/// What went wrong on the wire so far, by kind.
struct ModbusErrors {
  std::array<std::uint64_t, kModbusFaultCount> faults{};  ///< by ModbusFault
  std::array<std::uint64_t, 256> exceptions{};            ///< by exception code
};

/// "2 timeout, 1 wrong CRC, 3 exception 02 (illegal data address)"; "" where nothing went wrong.
[[nodiscard]] std::string InWords(const ModbusErrors& errors);

}  // namespace haptometer::acquire
