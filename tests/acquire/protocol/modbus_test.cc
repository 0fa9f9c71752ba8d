// Registers and frames of Modbus, pinned to the makers' bytes and to an independent CRC.
#include "acquire/protocol/modbus.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

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

TEST(ModbusValue, OneRegisterIsWrittenInTwoOrders) {
  for (const RegisterType type : {RegisterType::kU16, RegisterType::kI16}) {
    for (const auto& [order, expected] : {std::pair(WordOrder::kAbcd, 0x1234),
                                          {WordOrder::kCdab, 0x1234},
                                          {WordOrder::kBadc, 0x3412},
                                          {WordOrder::kDcba, 0x3412}}) {
      std::array<std::uint16_t, 1> word{};
      BitsTo(0x1234, type, order, word);
      EXPECT_EQ(word[0], expected) << Name(order);
      EXPECT_EQ(BitsFrom(word, type, order), 0x1234U) << Name(order);
    }
  }
}

struct IntegerEnds {
  RegisterType type;
  double least, most;
};

TEST(ModbusValue, EachTypeHoldsItsEndsAndNoMore) {
  for (const auto& [type, least, most] :
       {IntegerEnds{RegisterType::kU16, 0, 65535}, IntegerEnds{RegisterType::kI16, -32768, 32767},
        IntegerEnds{RegisterType::kU32, 0, 4294967295.0},
        IntegerEnds{RegisterType::kI32, -2147483648.0, 2147483647.0}}) {
    for (const double end : {least, most}) {
      ASSERT_TRUE(BitsOf(end, type)) << end;
      EXPECT_EQ(NumberOf(*BitsOf(end, type), type), end);
    }
    // rounded to the nearest: 0.4 beyond the end is the end, 0.6 is not
    EXPECT_TRUE(BitsOf(least - 0.4, type)) << least;
    EXPECT_TRUE(BitsOf(most + 0.4, type)) << most;
    EXPECT_FALSE(BitsOf(least - 0.6, type)) << least;
    EXPECT_FALSE(BitsOf(most + 0.6, type)) << most;
  }
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
  for (const std::size_t of_crc : {5U, 6U}) {
    std::string changed = kWt53rReply;
    changed[of_crc] ^= 1;
    EXPECT_EQ(FaultOf(changed), ModbusFault::kCrc) << "byte " << of_crc;
  }
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
  EXPECT_EQ(FaultOf(Rtu({.unit = 0x50, .function = 0x83, .data = Bytes({2, 0})})),
            ModbusFault::kLength);
  // the byte count is right, the bytes are not
  EXPECT_EQ(FaultOf(Rtu({.unit = 0x50, .function = 3, .data = Bytes({2, 7, 11, 0})})),
            ModbusFault::kLength);
}

TEST(ModbusFrame, BytesBehindATcpReplyAreNoPartOfIt) {
  const std::string reply = Bytes({0, 7, 0, 0, 0, 5, 1, 3, 2, 0, 5});
  const ReadRequest asked{.transaction = 7};
  EXPECT_EQ(ParseReadReply(ModbusFraming::kTcp, asked, reply).fault, ModbusFault::kNone);
  EXPECT_EQ(ParseReadReply(ModbusFraming::kTcp, asked, reply + "x").fault, ModbusFault::kLength);
}

TEST(ModbusFrame, ARequestHoldsBothBytesOfAnAddress) {
  const ReadRequest asked{
      .transaction = 0xABCD, .unit = 2, .function = 4, .address = 0x1234, .count = 125};
  std::string tcp;
  AppendReadRequest(ModbusFraming::kTcp, asked, tcp);
  EXPECT_EQ(tcp, Bytes({0xAB, 0xCD, 0, 0, 0, 6, 2, 4, 0x12, 0x34, 0, 125}));
  std::string rtu;
  AppendReadRequest(ModbusFraming::kRtu, asked, rtu);
  const ParsedAdu parsed = ParseAdu(ModbusFraming::kRtu, rtu);
  EXPECT_EQ(parsed.adu.transaction, 0) << "serial frames have none";
  EXPECT_EQ(parsed.adu.unit, 2);
  EXPECT_EQ(parsed.adu.function, 4);
  EXPECT_EQ(parsed.adu.data, Bytes({0x12, 0x34, 0, 125}));
  EXPECT_EQ(parsed.bytes, 8U);
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
  const std::string_view http = "GET / HTTP/1.1\r\n";
  EXPECT_EQ(ParseAdu(ModbusFraming::kTcp, http).state, AduState::kBadLength);
  EXPECT_EQ(ParseAdu(ModbusFraming::kTcp, http.substr(0, 8)).state, AduState::kBadLength);
  EXPECT_EQ(ParseAdu(ModbusFraming::kTcp, http.substr(0, 7)).state, AduState::kNeedMore)
      << "a header and a function are needed to judge";
}

TEST(ModbusFrame, ARepliesLengthIsThatOfItsFrame) {
  for (const std::size_t count : {1U, 13U, 125U}) {
    const std::string data(1 + 2 * count, static_cast<char>(2 * count));
    for (const ModbusFraming framing : {ModbusFraming::kRtu, ModbusFraming::kTcp}) {
      std::string frame;
      AppendAdu(framing, {.unit = 1, .function = 3, .data = data}, frame);
      EXPECT_EQ(ReplyBytes(framing, count), frame.size());
    }
  }
}

// serial line 256 bytes with slave and CRC, TCP 260 with its header; 252 bytes of data in both
TEST(ModbusFrame, TheLongestFrameIsRead) {
  const std::string data(252, 'x');
  for (const ModbusFraming framing : {ModbusFraming::kRtu, ModbusFraming::kTcp}) {
    std::string frame;
    AppendAdu(framing, {.unit = 1, .function = 3, .data = data}, frame);
    const ParsedAdu parsed = ParseAdu(framing, frame);
    EXPECT_EQ(parsed.state, AduState::kWhole);
    EXPECT_EQ(parsed.adu.data, data);
  }
  std::string long_rtu = std::string(255, 'x');
  const std::uint16_t crc = ModbusCrc(long_rtu);
  long_rtu += static_cast<char>(crc & 0xFFU);
  long_rtu += static_cast<char>(crc >> 8U);
  EXPECT_EQ(ParseAdu(ModbusFraming::kRtu, long_rtu).state, AduState::kBadLength) << "257 bytes";
}

TEST(ModbusFrame, ATcpHeaderStatesALengthThatExists) {
  const auto state = [](unsigned protocol, unsigned length) {
    return ParseAdu(ModbusFraming::kTcp,
                    Bytes({0, 1, 0, protocol, length >> 8U, length & 0xFFU, 1, 3}))
        .state;
  };
  // unit and function are 2; 254 make 260 bytes with the six before them
  EXPECT_EQ(state(0, 1), AduState::kBadLength);
  EXPECT_EQ(state(0, 2), AduState::kWhole);
  EXPECT_EQ(state(0, 254), AduState::kNeedMore);
  EXPECT_EQ(state(0, 255), AduState::kBadLength);
  EXPECT_EQ(state(1, 2), AduState::kBadLength);
}

TEST(ModbusFrame, ShorterThanFourBytesIsNoSerialFrame) {
  std::string frame = Bytes({1, 3});
  const std::uint16_t crc = ModbusCrc(frame);
  frame += static_cast<char>(crc & 0xFFU);
  frame += static_cast<char>(crc >> 8U);
  EXPECT_EQ(ParseAdu(ModbusFraming::kRtu, frame).state, AduState::kWhole);
  EXPECT_EQ(ParseAdu(ModbusFraming::kRtu, frame.substr(0, 3)).state, AduState::kBadLength);
}

TEST(ModbusFrame, ExceptionsHaveTheNamesOfTheStandard) {
  // Modbus Application Protocol V1.1b3, section 7
  EXPECT_EQ(ModbusExceptionText(1), "illegal function");
  EXPECT_EQ(ModbusExceptionText(3), "illegal data value");
  EXPECT_EQ(ModbusExceptionText(4), "device failure");
  EXPECT_EQ(ModbusExceptionText(6), "device busy");
  EXPECT_EQ(ModbusExceptionText(11), "gateway target silent");
  for (const int code : {-1, 0, 9, 12}) EXPECT_EQ(ModbusExceptionText(code), "unknown") << code;
}

TEST(ModbusFrame, ACharacterHasTenToTwelveBits) {
  EXPECT_EQ(BitsPerCharacter({.parity = Parity::kNone, .stop_bits = 1}), 10);
  EXPECT_EQ(BitsPerCharacter({.parity = Parity::kNone, .stop_bits = 2}), 11);
  EXPECT_EQ(BitsPerCharacter({.parity = Parity::kEven, .stop_bits = 1}), 11);
  EXPECT_EQ(BitsPerCharacter({.parity = Parity::kOdd, .stop_bits = 2}), 12);
}

TEST(ModbusFrame, ASilentIntervalFollowsTheBaudRateUpTo19200) {
  // 3.5 characters of 11 bits; beyond 19200 baud the standard fixes 1.75 ms
  EXPECT_EQ(SilentIntervalNs({.baud = 19200}), 2'005'208);
  EXPECT_EQ(SilentIntervalNs({.baud = 19201}), 1'750'000);
  EXPECT_EQ(SilentIntervalNs({.baud = 4000, .parity = Parity::kNone}), 8'750'000);
}

TEST(ModbusFrame, ASilentIntervalIsThreeAndAHalfCharactersOr1750Us) {
  // Modbus over Serial Line V1.02, 2.5.1.1
  EXPECT_EQ(SilentIntervalNs({.baud = 9600}), 4'010'416);  // 38.5 bits
  EXPECT_EQ(SilentIntervalNs({.baud = 57600}), 1'750'000);
  EXPECT_EQ(SilentIntervalNs({.baud = 1}), 38'500'000'000);
  EXPECT_DEATH((void)SilentIntervalNs({.baud = 0}), "baud = 0");
}

}  // namespace
}  // namespace haptometer::acquire
