// Bytes as a Modbus frame: read or refused, in either framing; what was read is written back as it
// was; a reply that passes holds as many registers as were asked for.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "acquire/protocol/modbus.h"
#include "fuzz/require.h"

namespace {

using namespace haptometer::acquire;
using namespace haptometer::fuzz;

void CheckFrame(ModbusFraming framing, std::string_view bytes) {
  const ParsedAdu parsed = ParseAdu(framing, bytes);
  if (parsed.state != AduState::kWhole) return;
  Require(parsed.bytes <= bytes.size() && parsed.bytes <= kLongestModbusAdu);
  std::string again;
  AppendAdu(framing, parsed.adu, again);
  Require(again == bytes.substr(0, parsed.bytes));
}

void CheckReply(ModbusFraming framing, const ReadRequest& request, std::string_view bytes) {
  const ReadReply reply = ParseReadReply(framing, request, bytes);
  const bool has_registers = reply.fault == ModbusFault::kNone && reply.exception == 0;
  Require(has_registers == !reply.registers.empty());
  if (!has_registers) return;
  Require(reply.registers.size() == std::size_t{2} * request.count);
  Require(bytes.size() == ReplyBytes(framing, request.count));
  static_cast<void>(RegisterAt(reply.registers, request.count - 1U));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  ReadRequest request{.unit = 1, .function = 3};
  request.count = static_cast<std::uint16_t>(1 + data[0] % kMostModbusRegisters);
  for (const ModbusFraming framing : {ModbusFraming::kRtu, ModbusFraming::kTcp}) {
    CheckFrame(framing, bytes);
    CheckReply(framing, request, bytes);
  }
  // the same bytes with the CRC that they need get past it
  std::string sealed = bytes;
  const std::uint16_t crc = ModbusCrc(bytes);
  sealed += static_cast<char>(crc & 0xFFU);
  sealed += static_cast<char>(crc >> 8U);
  CheckFrame(ModbusFraming::kRtu, sealed);
  CheckReply(ModbusFraming::kRtu, request, sealed);
  return 0;
}
