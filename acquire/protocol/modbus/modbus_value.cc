#include "acquire/protocol/modbus/modbus_value.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"

namespace haptometer::acquire {
namespace {

constexpr std::array<std::string_view, 5> kTypeNames{"u16", "i16", "u32", "i32", "f32"};
constexpr std::array<std::string_view, 4> kOrderNames{"ABCD", "CDAB", "BADC", "DCBA"};

bool SwapsBytes(WordOrder order) { return order == WordOrder::kBadc || order == WordOrder::kDcba; }
bool LowWordFirst(WordOrder order) {
  return order == WordOrder::kCdab || order == WordOrder::kDcba;
}

std::uint16_t Swapped(std::uint16_t word) { return static_cast<std::uint16_t>(std::rotl(word, 8)); }

template <typename Enum, std::size_t kNames>
std::optional<Enum> FromName(const std::array<std::string_view, kNames>& names,
                             std::string_view name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

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

std::string_view Name(RegisterType type) { return kTypeNames[static_cast<std::size_t>(type)]; }

std::optional<RegisterType> RegisterTypeFromName(std::string_view name) {
  return FromName<RegisterType>(kTypeNames, name);
}

std::string_view Name(WordOrder order) { return kOrderNames[static_cast<std::size_t>(order)]; }

std::optional<WordOrder> WordOrderFromName(std::string_view name) {
  return FromName<WordOrder>(kOrderNames, name);
}

std::size_t RegistersOf(RegisterType type) {
  return type == RegisterType::kU16 || type == RegisterType::kI16 ? 1 : 2;
}

std::uint32_t BitsFrom(std::span<const std::uint16_t> registers, RegisterType type,
                       WordOrder order) {
  HAPTOMETER_CHECK(registers.size() == RegistersOf(type), "{} registers", registers.size());
  std::array<std::uint16_t, 2> words{};
  std::ranges::copy(registers, words.begin());
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
