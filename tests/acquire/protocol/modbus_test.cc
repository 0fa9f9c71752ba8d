// Registers and frames of Modbus, pinned to the makers' bytes and to an independent CRC.
#include "acquire/protocol/modbus.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using Words = std::array<std::uint16_t, 2>;

std::string Bytes(std::initializer_list<unsigned> bytes) {
  std::string text;
  for (const unsigned byte : bytes) text += static_cast<char>(byte);
  return text;
}

// --- registers ---

TEST(ModbusValue, ReadsBaumersFloatLowWordFirst) {
  // Baumer OM20/OM30 manual, p. 34: 202 = 0x7C37, 203 = 0x428B
  const std::uint32_t bits = BitsFrom(Words{0x7C37, 0x428B}, RegisterType::kF32, WordOrder::kCdab);
  EXPECT_EQ(bits, 0x428B7C37U);
  EXPECT_ABS(NumberOf(bits, RegisterType::kF32), 69.7426, 5e-5, "the manual prints 4 decimals");
}

struct Order {
  WordOrder order;
  Words words;
};

class ModbusOrders : public ::testing::TestWithParam<Order> {};

// the bytes A B C D are 12 34 56 78; the orders are telegraf's and MATLAB's names
TEST_P(ModbusOrders, PutEachByteInItsPlace) {
  const auto& [order, words] = GetParam();
  EXPECT_EQ(BitsFrom(words, RegisterType::kU32, order), 0x12345678U);
  Words back{};
  BitsTo(0x12345678U, RegisterType::kU32, order, back);
  EXPECT_EQ(back, words);
}

INSTANTIATE_TEST_SUITE_P(All, ModbusOrders,
                         ::testing::Values(Order{WordOrder::kAbcd, {0x1234, 0x5678}},
                                           Order{WordOrder::kCdab, {0x5678, 0x1234}},
                                           Order{WordOrder::kBadc, {0x3412, 0x7856}},
                                           Order{WordOrder::kDcba, {0x7856, 0x3412}}));

TEST(ModbusValue, KeepsEveryBitOfAFloat) {
  for (const std::uint32_t bits : {0x7FC00001U, 0x7F812345U, 0xFFC0DEADU, 0x80000000U, 1U}) {
    for (const auto order :
         {WordOrder::kAbcd, WordOrder::kCdab, WordOrder::kBadc, WordOrder::kDcba}) {
      Words words{};
      BitsTo(bits, RegisterType::kF32, order, words);
      EXPECT_EQ(BitsFrom(words, RegisterType::kF32, order), bits);
    }
  }
}

TEST(ModbusValue, KnowsSignsAndSwappedBytesOfOneRegister) {
  const std::array<std::uint16_t, 1> word{0xFFFE};
  EXPECT_EQ(NumberOf(BitsFrom(word, RegisterType::kI16, WordOrder::kAbcd), RegisterType::kI16), -2);
  EXPECT_EQ(NumberOf(BitsFrom(word, RegisterType::kU16, WordOrder::kCdab), RegisterType::kU16),
            65534);
  EXPECT_EQ(NumberOf(BitsFrom(word, RegisterType::kU16, WordOrder::kDcba), RegisterType::kU16),
            0xFEFF);
  EXPECT_EQ(NumberOf(0xFFFFFFFF, RegisterType::kI32), -1);
  EXPECT_EQ(NumberOf(0xFFFFFFFF, RegisterType::kU32), 4294967295.0);
}

TEST(ModbusValue, RoundsOnlyWhatTheTypeHolds) {
  EXPECT_EQ(BitsOf(1803.4, RegisterType::kU16), 1803U);
  EXPECT_EQ(BitsOf(-2, RegisterType::kI16), 0xFFFFFFFEU & 0xFFFFU);
  EXPECT_EQ(BitsOf(-2, RegisterType::kI32), 0xFFFFFFFEU);
  EXPECT_FALSE(BitsOf(-1, RegisterType::kU16));
  EXPECT_FALSE(BitsOf(65536, RegisterType::kU16));
  EXPECT_FALSE(BitsOf(4294967296.0, RegisterType::kU32));
  EXPECT_FALSE(BitsOf(std::nan(""), RegisterType::kI32));
  EXPECT_EQ(BitsOf(69.7426, RegisterType::kF32), std::bit_cast<std::uint32_t>(69.7426F));
}

TEST(ModbusValue, NamesAreReadBack) {
  for (const char* name : {"u16", "i16", "u32", "i32", "f32"}) {
    EXPECT_EQ(Name(*RegisterTypeFromName(name)), name);
  }
  for (const char* name : {"ABCD", "CDAB", "BADC", "DCBA"}) {
    EXPECT_EQ(Name(*WordOrderFromName(name)), name);
  }
  EXPECT_FALSE(RegisterTypeFromName("f64"));
  EXPECT_FALSE(WordOrderFromName("abcd"));
}

// --- CRC ---

// the table form, from the definition: a byte's remainder by polynomial division of bit strings
std::uint16_t CrcByDivision(const std::string& bytes) {
  std::uint32_t crc = 0xFFFF;
  for (const char byte : bytes) {
    std::uint32_t remainder = (crc ^ static_cast<unsigned char>(byte)) & 0xFFU;
    for (int bit = 0; bit < 8; ++bit) {
      remainder = remainder % 2 == 1 ? remainder / 2 ^ 0xA001U : remainder / 2;
    }
    crc = crc / 256 ^ remainder;
  }
  return static_cast<std::uint16_t>(crc);
}

TEST(ModbusCrc, IsTheStandardsCheckValue) {
  // the catalogue of CRC algorithms gives 0x4B37 for CRC-16/MODBUS of "123456789"
  EXPECT_EQ(ModbusCrc("123456789"), 0x4B37);
  EXPECT_EQ(ModbusCrc(""), 0xFFFF);
}

TEST(ModbusCrc, AgreesWithDivisionOnAnyBytes) {
  std::mt19937 random(1);
  for (int length = 0; length < 260; ++length) {
    std::string bytes(static_cast<std::size_t>(length), '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    EXPECT_EQ(ModbusCrc(bytes), CrcByDivision(bytes));
  }
}

// --- frames ---

const std::string kWt53rRequest = Bytes({0x50, 0x03, 0x00, 0x34, 0x00, 0x01, 0xC8, 0x45});
const std::string kWt53rReply = Bytes({0x50, 0x03, 0x02, 0x07, 0x0B, 0x06, 0x7F});
constexpr ReadRequest kWt53r{.unit = 0x50, .function = 3, .address = 0x34, .count = 1};

TEST(ModbusFrame, IsTheWt53rsExchange) {
  // WIT-motion WT53R manual, p. 24; DFRobot wiki SEN0492: 1803 mm
  std::string request;
  AppendReadRequest(ModbusFraming::kRtu, kWt53r, request);
  EXPECT_EQ(request, kWt53rRequest);
  const ReadReply reply = ParseReadReply(ModbusFraming::kRtu, kWt53r, kWt53rReply);
  EXPECT_EQ(reply.fault, ModbusFault::kNone);
  EXPECT_EQ(RegisterAt(reply.registers, 0), 1803);
  EXPECT_EQ(ReplyBytes(ModbusFraming::kRtu, 1), kWt53rReply.size());
}

TEST(ModbusFrame, IsTheStandardsTcpExample) {
  // Modbus Messaging on TCP/IP V1.0b, 4.2: read one register at 4 of unit 0xFF, transaction 0x1501
  const ReadRequest asked{
      .transaction = 0x1501, .unit = 0xFF, .function = 3, .address = 4, .count = 1};
  std::string request;
  AppendReadRequest(ModbusFraming::kTcp, asked, request);
  EXPECT_EQ(request, Bytes({0x15, 0x01, 0, 0, 0, 6, 0xFF, 3, 0, 4, 0, 1}));
  const std::string bytes = Bytes({0x15, 0x01, 0, 0, 0, 5, 0xFF, 3, 2, 0, 5});
  const ReadReply reply = ParseReadReply(ModbusFraming::kTcp, asked, bytes);
  EXPECT_EQ(reply.fault, ModbusFault::kNone);
  EXPECT_EQ(RegisterAt(reply.registers, 0), 5);
  EXPECT_EQ(ReplyBytes(ModbusFraming::kTcp, 1), bytes.size());
}

std::string Rtu(const ModbusAdu& adu) {
  std::string frame;
  AppendAdu(ModbusFraming::kRtu, adu, frame);
  return frame;
}

ModbusFault FaultOf(const std::string& reply) {
  return ParseReadReply(ModbusFraming::kRtu, kWt53r, reply).fault;
}

TEST(ModbusFrame, NamesWhatIsWrongWithAReply) {
  std::string damaged = kWt53rReply;
  damaged[3] ^= 1;
  EXPECT_EQ(FaultOf(damaged), ModbusFault::kCrc);
  EXPECT_EQ(FaultOf(kWt53rReply.substr(0, 3)), ModbusFault::kLength);
  EXPECT_EQ(FaultOf(""), ModbusFault::kLength);
  EXPECT_EQ(FaultOf(Rtu({.unit = 0x51, .function = 3, .data = Bytes({2, 7, 11})})),
            ModbusFault::kUnit);
  EXPECT_EQ(FaultOf(Rtu({.unit = 0x50, .function = 4, .data = Bytes({2, 7, 11})})),
            ModbusFault::kFunction);
  EXPECT_EQ(FaultOf(Rtu({.unit = 0x50, .function = 3, .data = Bytes({4, 7, 11, 0, 0})})),
            ModbusFault::kLength);
  EXPECT_EQ(FaultOf(Rtu({.unit = 0x50, .function = 3, .data = Bytes({4, 7, 11})})),
            ModbusFault::kLength);
  // no exception has the number 0, and it holds no registers either
  EXPECT_EQ(FaultOf(Rtu({.unit = 0x50, .function = 0x83, .data = Bytes({0})})),
            ModbusFault::kLength);
}

TEST(ModbusFrame, TellsTransactionsApart) {
  const ReadRequest asked{.transaction = 7};
  std::string other;
  AppendAdu(ModbusFraming::kTcp,
            {.transaction = 6, .unit = 1, .function = 3, .data = Bytes({2, 0, 5})}, other);
  EXPECT_EQ(ParseReadReply(ModbusFraming::kTcp, asked, other).fault, ModbusFault::kTransaction);
}

TEST(ModbusFrame, ReadsExceptions) {
  // Modbus Application Protocol V1.1b3: function with 0x80, then the code
  const std::string reply = Rtu({.unit = 0x50, .function = 0x83, .data = Bytes({2})});
  const ReadReply parsed = ParseReadReply(ModbusFraming::kRtu, kWt53r, reply);
  EXPECT_EQ(parsed.fault, ModbusFault::kNone);
  EXPECT_EQ(parsed.exception, 2);
  EXPECT_EQ(ModbusExceptionText(2), "illegal data address");
  EXPECT_EQ(ModbusExceptionText(200), "unknown");
}

TEST(ModbusFrame, WaitsForTheRestOfATcpFrame) {
  std::string bytes;
  AppendReadRequest(ModbusFraming::kTcp, {.transaction = 1}, bytes);
  AppendReadRequest(ModbusFraming::kTcp, {.transaction = 2}, bytes);
  for (std::size_t size = 0; size < 12; ++size) {
    EXPECT_EQ(ParseAdu(ModbusFraming::kTcp, bytes.substr(0, size)).state, AduState::kNeedMore);
  }
  EXPECT_EQ(ParseAdu(ModbusFraming::kTcp, bytes).bytes, 12U);
  EXPECT_EQ(ParseAdu(ModbusFraming::kTcp, "GET / HTTP/1.1\r\n").state, AduState::kBadLength);
}

TEST(ModbusFrame, ASilentIntervalIsThreeAndAHalfCharactersOr1750Us) {
  // Modbus over Serial Line V1.02, 2.5.1.1
  EXPECT_EQ(SilentIntervalNs({.baud = 9600}), 4'010'416);  // 38.5 bits
  EXPECT_EQ(SilentIntervalNs({.baud = 57600}), 1'750'000);
}

}  // namespace
}  // namespace haptometer::acquire
