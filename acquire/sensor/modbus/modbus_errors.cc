#include "acquire/sensor/modbus/modbus_errors.h"

#include <fmt/core.h>

namespace haptometer::acquire {

std::string InWords(const ModbusErrors& errors) {
  std::string text;
  const auto add = [&](std::uint64_t count, std::string what) {
    if (count == 0) return;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  };
  for (std::size_t fault = 0; fault < kModbusFaultCount; ++fault) {
    add(errors.faults[fault], std::string(Name(static_cast<ModbusFault>(fault))));
  }
  for (std::size_t code = 0; code < errors.exceptions.size(); ++code) {
    add(errors.exceptions[code],
        fmt::format("exception {:02} ({})", code, ModbusExceptionText(static_cast<int>(code))));
  }
  return text;
}

}  // namespace haptometer::acquire
