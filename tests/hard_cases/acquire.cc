#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>

#include "acquire/protocol/modbus.h"
#include "tests/hard_cases/hard_case.h"

namespace haptometer::hard_cases {
namespace {

using acquire::BitsFrom;
using acquire::NumberOf;
using acquire::RegisterType;
using acquire::WordOrder;

/// The number as a reader with the fixed order ABCD decodes it.
double FixedOrder(std::array<std::uint16_t, 2> registers) {
  const std::uint32_t bits = (std::uint32_t{registers[0]} << 16) | registers[1];
  return static_cast<double>(std::bit_cast<float>(bits));
}

void CheckFloat(const char* name, WordOrder order, std::array<std::uint16_t, 2> registers) {
  const double ours = NumberOf(BitsFrom(registers, RegisterType::kF32, order), RegisterType::kF32);
  // 0x3f9e0652 is 1 + 1967698 / 2^23
  Check({"acquire", name, "Modbus does not state the order of a float's bytes", "fixed order ABCD",
         0},
        {1 + 1967698.0L / 8388608, ours, FixedOrder(registers)});
}

TEST(HardCasesAcquire, FloatWithItsLowWordFirst) {
  CheckFloat("float 1.2346, low word first", WordOrder::kCdab, {0x0652, 0x3f9e});
}

TEST(HardCasesAcquire, FloatWithSwappedBytes) {
  CheckFloat("float 1.2346, bytes of words swapped", WordOrder::kBadc, {0x9e3f, 0x5206});
}

TEST(HardCasesAcquire, FloatWithItsLowestByteFirst) {
  CheckFloat("float 1.2346, lowest byte first", WordOrder::kDcba, {0x5206, 0x9e3f});
}

TEST(HardCasesAcquire, NegativeIntegerOfTwoRegisters) {
  const std::array<std::uint16_t, 2> registers = {0xffff, 0xfffe};
  const std::uint32_t bits = BitsFrom(registers, RegisterType::kI32, WordOrder::kAbcd);
  Check({"acquire", "-2 in two registers", "each register is unsigned",
         "65536 high + low of unsigned registers", 0},
        {-2, NumberOf(bits, RegisterType::kI32), 65536.0 * registers[0] + registers[1]});
}

TEST(HardCasesAcquire, UnsignedBeyondThePrecisionOfFloat) {
  const std::array<std::uint16_t, 2> registers = {0x0100, 0x0001};
  const std::uint32_t bits = BitsFrom(registers, RegisterType::kU32, WordOrder::kAbcd);
  Check({"acquire", "16777217 counts", "2^24 + 1 is no float", "counts held as float", 0},
        {16777217, NumberOf(bits, RegisterType::kU32),
         static_cast<double>(static_cast<float>(bits))});
}

}  // namespace
}  // namespace haptometer::hard_cases
