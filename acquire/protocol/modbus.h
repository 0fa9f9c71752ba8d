#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/clock.h"

/// Modbus frames as bytes, both directions; nothing here knows a port or a clock.
///
/// Sources: Modbus Application Protocol V1.1b3 (functions 03 and 04, exceptions), Modbus over
/// Serial Line V1.02 (RTU framing, CRC, the silent interval t3.5), Modbus Messaging on TCP/IP V1.0b
/// (the MBAP header).
namespace haptometer::acquire {

enum class ModbusFraming : std::uint8_t { kRtu, kTcp };

enum class Parity : std::uint8_t { kNone, kEven, kOdd };

/// "none", "even", "odd".
[[nodiscard]] std::string_view Name(Parity parity);

/// How a device is reached; TCP needs the slave alone.
struct ModbusWire {
  int baud = 9600;
  Parity parity = Parity::kEven;
  int stop_bits = 1;
  int slave = 1;  ///< 1 to 247; over TCP also 0 and 255
};

/// Start, 8 data, parity and stop bits: 10 to 12.
[[nodiscard]] int BitsPerCharacter(const ModbusWire& wire);

/// The silent interval that ends an RTU frame: 3.5 characters, 1.75 ms above 19200 baud, in ns.
[[nodiscard]] MonotonicNs SilentIntervalNs(const ModbusWire& wire);

inline constexpr int kMostModbusRegisters = 125;       ///< that one request may ask for
inline constexpr std::size_t kLongestModbusAdu = 260;  ///< bytes; an RTU frame has 256 at most

/// What an exception reply says.
enum class ModbusException : std::uint8_t {
  kNone = 0,  ///< there is none
  kIllegalFunction = 1,
  kIllegalAddress = 2,
  kIllegalValue = 3,
  kDeviceFailure = 4,
};

/// "illegal function", ...; "unknown" for codes that the standard does not name.
[[nodiscard]] std::string_view ModbusExceptionText(int code);

/// CRC-16 of RTU: polynomial 0x8005 reflected, started at 0xFFFF; its low byte is sent first.
[[nodiscard]] std::uint16_t ModbusCrc(std::string_view bytes);

/// One message with its address, in either framing.
struct ModbusAdu {
  std::uint16_t transaction = 0;  ///< TCP only
  std::uint8_t unit = 0;          ///< slave address, unit identifier
  std::uint8_t function = 0;      ///< with 0x80 in an exception reply
  std::string_view data{};        ///< behind the function
};

/// Appends the message with CRC or MBAP header; data of at most 252 bytes.
void AppendAdu(ModbusFraming framing, const ModbusAdu& adu, std::string& out);

enum class AduState : std::uint8_t {
  kWhole,
  kNeedMore,   ///< TCP: the header promises more bytes
  kBadLength,  ///< no frame has this length, or (TCP) it is no Modbus header
  kBadCrc,     ///< RTU
};

struct ParsedAdu {
  AduState state = AduState::kBadLength;
  ModbusAdu adu{};        ///< kWhole; views the parsed bytes
  std::size_t bytes = 0;  ///< kWhole: of the frame
};

/// Reads one frame. RTU frames are bounded by silence, so there `bytes` is all that came between
/// two; TCP frames say their length and the next may follow.
[[nodiscard]] ParsedAdu ParseAdu(ModbusFraming framing, std::string_view bytes);

/// A request for registers.
struct ReadRequest {
  std::uint16_t transaction = 0;
  std::uint8_t unit = 1;
  std::uint8_t function = 3;  ///< 3: holding registers; 4: input registers
  std::uint16_t address = 0;  ///< on the wire, from 0
  std::uint16_t count = 1;    ///< 1 to kMostModbusRegisters

  friend bool operator==(const ReadRequest&, const ReadRequest&) = default;
};

/// Appends the request as a frame: 8 bytes in RTU, 12 in TCP.
void AppendReadRequest(ModbusFraming framing, const ReadRequest& request, std::string& out);

/// How many bytes its reply has.
[[nodiscard]] std::size_t ReplyBytes(ModbusFraming framing, std::size_t count);

/// Why bytes are not the reply to a request.
enum class ModbusFault : std::uint8_t {
  kNone,
  kTimeout,      ///< nothing came in time
  kCrc,          ///< RTU: damaged on the wire
  kLength,       ///< cut, or with another number of registers than asked for
  kUnit,         ///< of another slave
  kFunction,     ///< to another function
  kTransaction,  ///< TCP: to another request
};
inline constexpr std::size_t kModbusFaultCount = 7;

/// "timeout", "wrong CRC", "wrong length", "wrong slave", "wrong function", "wrong transaction".
[[nodiscard]] std::string_view Name(ModbusFault fault);

/// What a reply says to `request`.
struct ReadReply {
  ModbusFault fault = ModbusFault::kNone;
  int exception = 0;             ///< code of an exception reply; 0: registers came
  std::string_view registers{};  ///< 2 bytes each, high byte first; empty unless sound
};

[[nodiscard]] ReadReply ParseReadReply(ModbusFraming framing, const ReadRequest& request,
                                       std::string_view bytes);

/// Register `index` of ReadReply::registers.
[[nodiscard]] std::uint16_t RegisterAt(std::string_view registers, std::size_t index);

/// What Modbus registers mean: numbers of one or two registers in any order of their bytes.
///
/// Our own decode, because libmodbus changed the meaning of modbus_get_float_* between versions
/// (on little-endian hosts 3.1.7 and older read DCBA under the name abcd).

enum class RegisterType : std::uint8_t { kU16, kI16, kU32, kI32, kF32 };

/// Which byte comes first, A being the most significant: kCdab sends the low word first. A number
/// of one register is sent AB, or BA in the orders that swap bytes (kBadc, kDcba).
enum class WordOrder : std::uint8_t { kAbcd, kCdab, kBadc, kDcba };

/// "u16", "i16", "u32", "i32", "f32".
[[nodiscard]] std::string_view Name(RegisterType type);
[[nodiscard]] std::optional<RegisterType> RegisterTypeFromName(std::string_view name);
/// "ABCD", "CDAB", "BADC", "DCBA".
[[nodiscard]] std::string_view Name(WordOrder order);
[[nodiscard]] std::optional<WordOrder> WordOrderFromName(std::string_view name);

/// 1 or 2.
[[nodiscard]] std::size_t RegistersOf(RegisterType type);

/// The number's bits, of RegistersOf(type) registers; 16-bit numbers stand in the low half. A
/// float's bits come out as they went in, a NaN's payload too.
[[nodiscard]] std::uint32_t BitsFrom(std::span<const std::uint16_t> registers, RegisterType type,
                                     WordOrder order);

/// The way back: writes RegistersOf(type) registers.
void BitsTo(std::uint32_t bits, RegisterType type, WordOrder order,
            std::span<std::uint16_t> registers);

/// The number that the bits mean; exact.
[[nodiscard]] double NumberOf(std::uint32_t bits, RegisterType type);

/// The bits of `number`, rounded to the nearest the type has; nothing where it has none.
[[nodiscard]] std::optional<std::uint32_t> BitsOf(double number, RegisterType type);

}  // namespace haptometer::acquire
