#include "acquire/protocol/modbus.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/names.h"

namespace haptometer::acquire {
namespace {

// Modbus TCP header: transaction (2), protocol (2), length (2), unit (1)
constexpr std::size_t kMbapBytes = 7;
// serial line specification: slave (1), PDU (253), CRC (2)
constexpr std::size_t kLongestRtu = 256;
// PDU of 253 bytes less the function code
constexpr std::size_t kMostData = 252;
// set in the function code of an exception response
constexpr std::uint8_t kExceptionBit = 0x80;

std::uint8_t ByteAt(std::string_view bytes, std::size_t index) {
  return static_cast<std::uint8_t>(bytes[index]);
}

// words are big-endian on the wire
void AppendWord(std::uint16_t word, std::string& out) {
  out += static_cast<char>(word >> 8U);
  out += static_cast<char>(word & 0xFFU);
}

// slave, function, data, CRC; the CRC is sent low byte first
ParsedAdu ParseRtu(std::string_view bytes) {
  if (bytes.size() < 4 || bytes.size() > kLongestRtu) return {.state = AduState::kBadLength};
  const std::string_view body = bytes.substr(0, bytes.size() - 2);
  const std::uint16_t crc = ModbusCrc(body);
  if (ByteAt(bytes, body.size()) != (crc & 0xFFU) || ByteAt(bytes, body.size() + 1) != crc >> 8U) {
    return {.state = AduState::kBadCrc};
  }
  return {.state = AduState::kWhole,
          .adu = {.transaction = 0,
                  .unit = ByteAt(bytes, 0),
                  .function = ByteAt(bytes, 1),
                  .data = body.substr(2)},
          .bytes = bytes.size()};
}

// MBAP header, function, data; the length field counts from the unit identifier on
ParsedAdu ParseTcp(std::string_view bytes) {
  if (bytes.size() < kMbapBytes + 1) return {.state = AduState::kNeedMore};
  const std::uint16_t protocol = RegisterAt(bytes, 1);
  const std::size_t length = RegisterAt(bytes, 2);  // from the unit on
  const std::size_t whole = kMbapBytes - 1 + length;
  // protocol 0 is Modbus; the shortest message is unit and function
  if (protocol != 0 || length < 2 || whole > kLongestModbusAdu) {
    return {.state = AduState::kBadLength};
  }
  if (bytes.size() < whole) return {.state = AduState::kNeedMore};
  return {.state = AduState::kWhole,
          .adu = {.transaction = RegisterAt(bytes, 0),
                  .unit = ByteAt(bytes, 6),
                  .function = ByteAt(bytes, 7),
                  .data = bytes.substr(kMbapBytes + 1, length - 2)},
          .bytes = whole};
}

ReadReply Faulty(ModbusFault fault) { return {.fault = fault}; }

}  // namespace

std::string_view ModbusExceptionText(int code) {
  constexpr std::array<std::string_view, 12> kTexts{"unknown",
                                                    "illegal function",
                                                    "illegal data address",
                                                    "illegal data value",
                                                    "device failure",
                                                    "acknowledge",
                                                    "device busy",
                                                    "negative acknowledge",
                                                    "memory parity error",
                                                    "unknown",
                                                    "gateway path unavailable",
                                                    "gateway target silent"};
  return code > 0 && static_cast<std::size_t>(code) < kTexts.size()
             ? kTexts[static_cast<std::size_t>(code)]
             : kTexts[0];
}

// CRC-16/MODBUS: polynomial 0x8005 reflected, start value 0xFFFF, least significant bit first
std::uint16_t ModbusCrc(std::string_view bytes) {
  constexpr std::uint32_t kReflectedPolynomial = 0xA001;
  std::uint32_t crc = 0xFFFF;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    crc ^= ByteAt(bytes, i);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 1U) != 0 ? (crc >> 1U) ^ kReflectedPolynomial : crc >> 1U;
    }
  }
  return static_cast<std::uint16_t>(crc);
}

std::string_view Name(Parity parity) {
  constexpr Names<Parity, 3> kNames{{"none", "even", "odd"}};
  return kNames.Of(parity);
}

// start bit, 8 data bits, parity bit, stop bits
int BitsPerCharacter(const ModbusWire& wire) {
  return 9 + (wire.parity == Parity::kNone ? 0 : 1) + wire.stop_bits;
}

MonotonicNs SilentIntervalNs(const ModbusWire& wire) {
  HAPTOMETER_CHECK(wire.baud > 0, "baud = {}", wire.baud);
  // above 19200 baud the specification fixes t3.5 = 1.75 ms
  constexpr MonotonicNs kAbove19200Ns = 1'750'000;
  if (wire.baud > 19200) return kAbove19200Ns;
  // 3.5 characters: 3.5 * bits / baud
  return 7 * MonotonicNs{BitsPerCharacter(wire)} * kNsPerS / (2 * MonotonicNs{wire.baud});
}

void AppendAdu(ModbusFraming framing, const ModbusAdu& adu, std::string& out) {
  HAPTOMETER_CHECK(adu.data.size() <= kMostData, "{} bytes", adu.data.size());
  const std::size_t begin = out.size();
  // transaction, protocol 0, length of unit, function and data
  if (framing == ModbusFraming::kTcp) {
    AppendWord(adu.transaction, out);
    AppendWord(0, out);
    AppendWord(static_cast<std::uint16_t>(adu.data.size() + 2), out);
  }
  out += static_cast<char>(adu.unit);
  out += static_cast<char>(adu.function);
  out += adu.data;
  // CRC over slave, function and data
  if (framing == ModbusFraming::kRtu) {
    const std::uint16_t crc = ModbusCrc(std::string_view(out).substr(begin));
    out += static_cast<char>(crc & 0xFFU);
    out += static_cast<char>(crc >> 8U);
  }
}

ParsedAdu ParseAdu(ModbusFraming framing, std::string_view bytes) {
  return framing == ModbusFraming::kRtu ? ParseRtu(bytes) : ParseTcp(bytes);
}

void AppendReadRequest(ModbusFraming framing, const ReadRequest& request, std::string& out) {
  const std::array<char, 4> data{
      static_cast<char>(request.address >> 8U), static_cast<char>(request.address & 0xFFU),
      static_cast<char>(request.count >> 8U), static_cast<char>(request.count & 0xFFU)};
  AppendAdu(framing,
            {.transaction = request.transaction,
             .unit = request.unit,
             .function = request.function,
             .data = {data.data(), data.size()}},
            out);
}

// RTU: slave, PDU, CRC (2); TCP: MBAP header, PDU
std::size_t ReplyBytes(ModbusFraming framing, std::size_t count) {
  const std::size_t pdu = 2 + 2 * count;  // function, byte count, registers
  return framing == ModbusFraming::kRtu ? 1 + pdu + 2 : kMbapBytes + pdu;
}

std::string_view Name(ModbusFault fault) {
  constexpr Names<ModbusFault, kModbusFaultCount> kNames{{"none", "timeout", "wrong CRC",
                                                          "wrong length", "wrong slave",
                                                          "wrong function", "wrong transaction"}};
  return kNames.Of(fault);
}

ReadReply ParseReadReply(ModbusFraming framing, const ReadRequest& request,
                         std::string_view bytes) {
  const ParsedAdu parsed = ParseAdu(framing, bytes);
  if (parsed.state == AduState::kBadCrc) return Faulty(ModbusFault::kCrc);
  // one frame, complete and without further bytes
  if (parsed.state != AduState::kWhole || parsed.bytes != bytes.size()) {
    return Faulty(ModbusFault::kLength);
  }
  // first whose reply it is, then its content
  const ModbusAdu& adu = parsed.adu;
  if (framing == ModbusFraming::kTcp && adu.transaction != request.transaction) {
    return Faulty(ModbusFault::kTransaction);
  }
  if (adu.unit != request.unit) return Faulty(ModbusFault::kUnit);
  if (adu.function == (request.function | kExceptionBit)) {
    // there is no exception 0; it must not pass for "registers came"
    if (adu.data.size() != 1 || adu.data[0] == 0) return Faulty(ModbusFault::kLength);
    return {.fault = ModbusFault::kNone, .exception = ByteAt(adu.data, 0)};
  }
  if (adu.function != request.function) return Faulty(ModbusFault::kFunction);
  // byte count, then two bytes per register
  const std::size_t asked = 2 * std::size_t{request.count};
  if (adu.data.size() != 1 + asked || ByteAt(adu.data, 0) != asked) {
    return Faulty(ModbusFault::kLength);
  }
  return {.fault = ModbusFault::kNone, .exception = 0, .registers = adu.data.substr(1)};
}

// big-endian 16-bit register
std::uint16_t RegisterAt(std::string_view registers, std::size_t index) {
  return static_cast<std::uint16_t>((ByteAt(registers, 2 * index) << 8U) |
                                    ByteAt(registers, 2 * index + 1));
}

namespace {

constexpr Names<RegisterType, 5> kTypeNames{{"u16", "i16", "u32", "i32", "f32"}};
constexpr Names<WordOrder, 4> kOrderNames{{"ABCD", "CDAB", "BADC", "DCBA"}};

// letters are the bytes of the number, A the most significant, in the order of the wire
bool SwapsBytes(WordOrder order) { return order == WordOrder::kBadc || order == WordOrder::kDcba; }
bool LowWordFirst(WordOrder order) {
  return order == WordOrder::kCdab || order == WordOrder::kDcba;
}

std::uint16_t Swapped(std::uint16_t word) { return static_cast<std::uint16_t>(std::rotl(word, 8)); }

// rounded to the nearest integer, as bits; nothing beyond the integer's range
template <typename Integer>
std::optional<std::uint32_t> RoundedBits(double number) {
  const double rounded = std::nearbyint(number);
  if (!(rounded >= double{std::numeric_limits<Integer>::min()} &&
        rounded <= double{std::numeric_limits<Integer>::max()})) {
    return std::nullopt;
  }
  return static_cast<std::make_unsigned_t<Integer>>(static_cast<Integer>(rounded));
}

}  // namespace

std::string_view Name(RegisterType type) { return kTypeNames.Of(type); }

std::optional<RegisterType> RegisterTypeFromName(std::string_view name) {
  return kTypeNames.From(name);
}

std::string_view Name(WordOrder order) { return kOrderNames.Of(order); }

std::optional<WordOrder> WordOrderFromName(std::string_view name) { return kOrderNames.From(name); }

std::size_t RegistersOf(RegisterType type) {
  return type == RegisterType::kU16 || type == RegisterType::kI16 ? 1 : 2;
}

std::uint32_t BitsFrom(std::span<const std::uint16_t> registers, RegisterType type,
                       WordOrder order) {
  HAPTOMETER_CHECK(registers.size() == RegistersOf(type), "{} registers", registers.size());
  std::array<std::uint16_t, 2> words{};
  std::ranges::copy(registers, words.begin());
  // bytes within each register first, then the order of the registers
  if (SwapsBytes(order)) std::ranges::transform(words, words.begin(), Swapped);
  if (registers.size() == 1) return words[0];
  if (LowWordFirst(order)) std::swap(words[0], words[1]);
  return (std::uint32_t{words[0]} << 16U) | words[1];
}

void BitsTo(std::uint32_t bits, RegisterType type, WordOrder order,
            std::span<std::uint16_t> registers) {
  HAPTOMETER_CHECK(registers.size() == RegistersOf(type), "{} registers", registers.size());
  if (registers.size() == 1) {
    registers[0] = static_cast<std::uint16_t>(bits);
  } else {
    registers[0] = static_cast<std::uint16_t>(bits >> 16U);
    registers[1] = static_cast<std::uint16_t>(bits);
    if (LowWordFirst(order)) std::swap(registers[0], registers[1]);
  }
  if (SwapsBytes(order)) std::ranges::transform(registers, registers.begin(), Swapped);
}

double NumberOf(std::uint32_t bits, RegisterType type) {
  switch (type) {
    case RegisterType::kI16:
      return static_cast<std::int16_t>(bits);
    case RegisterType::kI32:
      return static_cast<std::int32_t>(bits);
    case RegisterType::kF32:
      return static_cast<double>(std::bit_cast<float>(bits));
    case RegisterType::kU16:
    case RegisterType::kU32:
      break;
  }
  return bits;
}

// inverse of NumberOf(); nothing where the number does not fit
std::optional<std::uint32_t> BitsOf(double number, RegisterType type) {
  switch (type) {
    case RegisterType::kU16:
      return RoundedBits<std::uint16_t>(number);
    case RegisterType::kI16:
      return RoundedBits<std::int16_t>(number);
    case RegisterType::kU32:
      return RoundedBits<std::uint32_t>(number);
    case RegisterType::kI32:
      return RoundedBits<std::int32_t>(number);
    case RegisterType::kF32:
      break;
  }
  return std::bit_cast<std::uint32_t>(static_cast<float>(number));
}

}  // namespace haptometer::acquire
