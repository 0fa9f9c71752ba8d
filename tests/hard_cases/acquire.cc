#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/keyence/lkg.h"
#include "acquire/protocol/line_framer.h"
#include "acquire/protocol/modbus.h"
#include "acquire/protocol/sample_format.h"
#include "acquire/protocol/stream_line.h"
#include "acquire/protocol/wire.h"
#include "acquire/reading_noise.h"
#include "acquire/recorder/recording_statistics.h"
#include "acquire/sensor/stream_sensor.h"
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

// CRC of 16 bits with the reflected polynomial 0x8005, bit by bit
std::uint16_t Crc16From(std::uint16_t crc, std::string_view bytes) {
  for (const char byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ static_cast<unsigned char>(byte));
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc >> 1) ^ ((crc & 1) != 0 ? 0xa001 : 0));
    }
  }
  return crc;
}

TEST(HardCasesAcquire, CrcOfThePublishedCheckText) {
  // 0x4b37: check value of CRC-16/MODBUS in the catalogue of parametrised CRC algorithms
  Check({"acquire", "CRC-16 of 123456789", "several CRCs share the polynomial 0x8005",
         "CRC-16/ARC, begun at 0", 0},
        {0x4b37, static_cast<double>(acquire::ModbusCrc("123456789")),
         static_cast<double>(Crc16From(0, "123456789"))});
}

TEST(HardCasesAcquire, CodeAmongValues) {
  constexpr std::array<std::string_view, 4> kTexts = {"+00.020", "-99.998", "+00.021", "+00.019"};
  double sum = 0, all = 0;
  int count = 0;
  for (const std::string_view text : kTexts) {
    const auto value = acquire::dl_rs1a::ParseValue(text);
    ASSERT_TRUE(value.has_value());
    double number = 0;
    std::from_chars(text.data() + (text.front() == '+' ? 1 : 0), text.data() + text.size(), number);
    all += number;
    if (!trial::IsMeasurement(value->status)) continue;
    sum += value->counts;
    ++count;
  }
  // 60 counts of 1 um over three readings
  Check({"acquire", "mean of three readings of 0.02 mm and -99.998",
         "an IL amplifier sends a code in place of a value", "mean of the numbers", 0},
        {20, sum / count, 1e3 * all / 4});
}

TEST(HardCasesAcquire, PlacesOfAnLkgValue) {
  const auto value = acquire::lkg::ParseValue("-00001.2");
  ASSERT_TRUE(value.has_value());
  // the digits alone, of which the default has four behind the point
  const double naive_tenths = value->counts / 1e3;
  Check({"acquire", "tenths of -00001.2 from an LK-G3001", "where the point stands is a setting",
         "four decimals", 0},
        {-12, value->counts * std::pow(10.0, 1 - value->decimals), naive_tenths});
}

TEST(HardCasesAcquire, CodeOfTheEthernetUnit) {
  const auto value = acquire::dl_en1::ParseValue("-000099998");
  ASSERT_TRUE(value.has_value());
  const bool counts = trial::IsMeasurement(acquire::dl_en1::WithIlSpecials(*value).status);
  Check({"acquire", "readings of an IL amplifier in -000099998 of a DL-EN1",
         "nine digits carry the codes of five", "the unit's own codes alone", 0},
        {0, counts ? 1.0 : 0.0, trial::IsMeasurement(value->status) ? 1.0 : 0.0});
}

// lines of +01.2345 of which `lost` bytes in the middle are missing
std::string Damaged(int lines, std::size_t lost) {
  std::string bytes;
  for (int k = 0; k < lines; ++k) bytes += "+01.2345\r";
  return bytes.erase(bytes.size() / 2 + 3, lost);
}

TEST(HardCasesAcquire, LinesBehindALostByte) {
  const std::string bytes = Damaged(1000, 1);
  const acquire::StreamFormat format;
  acquire::LineFramer framer(format.delimiter, acquire::LineWidth(format));
  framer.Feed(bytes);
  int ours = 0, naive = 0;
  for (acquire::Frame frame = framer.Next(); frame.framing != acquire::Framing::kNeedMore;
       frame = framer.Next()) {
    const auto value = acquire::ParseStreamLine(format, frame.text);
    ours += value && value->counts == 12345 ? 1 : 0;
  }
  for (std::size_t k = 0; k + 9 <= bytes.size(); k += 9) {
    naive += bytes.substr(k, 9) == "+01.2345\r" ? 1 : 0;
  }
  Check({"acquire", "whole lines of 1000 of which one lost a byte",
         "all that follows stands one byte earlier", "records of 9 bytes", 0},
        {999, static_cast<double>(ours), static_cast<double>(naive)});
}

TEST(HardCasesAcquire, LostLinesWhereTheCounterBeginsAgain) {
  // three digits; 990 to 999 and 0 to 4 are lost
  acquire::LineCounter counter(1000);
  std::int64_t ours = 0;
  std::int64_t naive = 0;
  std::optional<std::int32_t> last;
  for (int line = 0; line < 2000; ++line) {
    if (line >= 990 && line < 1005) continue;
    ours += counter.LostBefore(line % 1000);
    if (last) naive += line % 1000 - *last - 1;
    last = line % 1000;
  }
  Check({"acquire", "15 lines lost about the turn of a counter of three digits",
         "the number falls from 989 to 5", "differences of the numbers less 1", 0},
        {15, static_cast<double>(ours), static_cast<double>(naive)});
}

TEST(HardCasesAcquire, ScatterOfIntervalsLongAfterTheEpoch) {
  // intervals of 100 us - 100 ns and + 100 ns in turn, from 1.7e18 ns on
  acquire::IntervalStatistics statistics;
  std::vector<double> times_s;
  std::int64_t time_ns = 1'700'000'000'000'000'000;
  for (int k = 0; k <= 1000; ++k) {
    statistics.Add(time_ns, 0);
    times_s.push_back(1e-9 * static_cast<double>(time_ns));
    time_ns += 100'000 + (k % 2 == 0 ? -100 : 100);
  }
  double squares = 0;
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    squares += std::pow(times_s[k] - times_s[k - 1] - 1e-4, 2);
  }
  const auto ours = statistics.DeviationSeconds();
  ASSERT_TRUE(ours.has_value());
  // the bar: each interval of 1e-4 s rounds by 1e-20 s, 1e-13 of its deviation
  Check({"acquire", "scatter of 100 ns in times since 1970",
         "a double of 1.7e9 s has steps of 240 ns", "intervals of seconds as doubles", 1e-12},
        {1e-7L * std::sqrt(1000.0L / 999), *ours, std::sqrt(squares / 999)});
}

TEST(HardCasesAcquire, NoiseOfOverlappingMeans) {
  // means of 16 raw samples, a new one each ms: sin^2(pi f n T)/(n sin^2(pi f T)) of white noise
  constexpr double kFrequency = 20, kPeriod = 1e-3, kRms = 1e-6;
  const long double pi = std::numbers::pi_v<long double>;
  const long double ratio = std::sin(pi * 0.32L) / std::sin(pi * 0.02L);
  const long double white = 2 * 1e-12L * 1e-3L;
  // the bar: sixteen cosines, each to an ulp
  Check({"acquire", "noise density at 20 Hz of means of 16 samples", "successive means overlap",
         "2 s^2/rate of white noise", 1e-14},
        {white * ratio * ratio / 16,
         acquire::NoiseDensity(
             {.rate_hz = 1 / kPeriod, .noise_rms_m = kRms, .span_s = 16 * kPeriod}, kFrequency),
         2 * kRms * kRms * kPeriod});
}

// a reading of one sample that arrives at `time_ns`
acquire::Reading ReadingAt(std::int64_t time_ns) {
  acquire::Reading reading;
  reading.time_ns = time_ns;
  reading.samples.resize(1);
  return reading;
}

TEST(HardCasesAcquire, StallThatIsMadeUpFor) {
  // a line each ms; those of 1.0 to 1.2 s arrive at 1.2 s
  acquire::GapCounter gaps(trial::Timing::kArrival);
  int naive = 0;
  std::int64_t last_ns = 0;
  for (std::int64_t k = 0; k < 3000; ++k) {
    const std::int64_t sent_ns = k * 1'000'000;
    const std::int64_t time_ns = k >= 1000 && k < 1200 ? 1'200'000'000 : sent_ns;
    gaps.Add(ReadingAt(time_ns));
    naive += time_ns - last_ns > 8'000'000 ? 1 : 0;
    last_ns = time_ns;
  }
  Check({"acquire", "gaps in 3000 lines of which none is lost", "the host slept for 0.2 s",
         "intervals of more than eight usual ones", 0},
        {0, static_cast<double>(gaps.gaps()), static_cast<double>(naive)});
}

TEST(HardCasesAcquire, SamplesThatArriveInPieces) {
  std::string bytes;
  for (int k = 0; k < 1000; ++k) {
    bytes.push_back(static_cast<char>(k & 0xff));
    bytes.push_back(static_cast<char>(k >> 8));
  }
  acquire::SampleParser parser(acquire::SampleFormat::kI16, std::vector<trial::RawLimits>(1));
  std::array<trial::Sample, 1> row;
  double ours = 0, naive = 0;
  for (std::size_t k = 0; k < bytes.size(); k += 7) {
    const std::string piece = bytes.substr(k, 7);
    parser.Feed(piece);
    while (parser.Next(row) == acquire::RowState::kRow) {
      ours += row[0].raw.Number(trial::Encoding::kI32);
    }
    for (std::size_t i = 0; i + 1 < piece.size(); i += 2) {
      const auto low = static_cast<unsigned char>(piece[i]);
      naive += low + 256 * static_cast<signed char>(piece[i + 1]);
    }
  }
  Check({"acquire", "sum of the counts 0 to 999 in pieces of 7 bytes",
         "a piece ends within a sample", "each piece decoded alone", 0},
        {499'500, ours, naive});
}

TEST(HardCasesAcquire, TimeOfALongTransferOnTheWire) {
  // 1 MB at 9600 baud and 10 bits: 1e16/9600 ns = 1041666666666.6
  const std::int64_t bit_ns = 1'000'000'000 / 9600;
  Check({"acquire", "1 MB at 9600 baud in ns", "a bit is no whole number of ns",
         "bits times the rounded time of one", 0},
        {1'041'666'666'666.0L, static_cast<double>(acquire::WireTimeNs(1'000'000, 9600)),
         static_cast<double>(10'000'000 * bit_ns)});
}

}  // namespace
}  // namespace haptometer::hard_cases
