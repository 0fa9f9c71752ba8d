#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// What Modbus registers mean: numbers of one or two registers in any order of their bytes.
///
/// Our own decode, because libmodbus changed the meaning of modbus_get_float_* between versions
/// (on little-endian hosts 3.1.7 and older read DCBA under the name abcd).
namespace haptometer::acquire {

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
