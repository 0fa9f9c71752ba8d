#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/quantity.h"
#include "tests/hard_cases/hard_case.h"
#include "tests/trial/trial_file.h"
#include "trial/byte_io.h"
#include "trial/calibration.h"
#include "trial/export/export.h"
#include "trial/import/readers.h"
#include "trial/import/table/table_cells.h"
#include "trial/sensor_head.h"
#include "trial/time_base.h"
#include "trial/trial_rows.h"

namespace haptometer::hard_cases {
namespace {

TEST(HardCasesTrial, AveragingGainAtTheSamplingRate) {
  const double f = 1000, t = 1e-3;
  const double sine = std::sin(0.0 * f);
  Check({"trial", "averaging of a tone at the sampling rate", "sin(pi f n T)/sin(pi f T) is 0/0",
         "the formula as printed, its sines rounded to 0", 0},
        {1, trial::AveragingGain(f, t, 16), sine / (16 * sine)});
}

TEST(HardCasesTrial, AveragingGainOfAveragesOfDiscreteSamples) {
  // sin(pi 225 0.016)/(16 sin(pi 225 0.001)) with arguments below a turn
  const long double pi = 3.14159265358979323846264338327950288L;
  const long double truth = std::fabs(std::sin(pi * 1.6L)) / (16 * std::sin(pi * 0.225L));
  const double x = static_cast<double>(pi) * 225 * 16e-3;
  Check({"trial", "averaging of 16 samples of 1 ms at 225 Hz", "samples are points, not areas",
         "sin(pi f n T)/(pi f n T)", 1e-15},
        {truth, trial::AveragingGain(225, 1e-3, 16), std::fabs(std::sin(x)) / x});
}

// lines of a 10 kHz source that arrive in bursts: each waits for the next multiple of `burst_s`
std::vector<std::int64_t> Bursts(std::size_t rows, double rate_hz, std::int64_t burst_ns) {
  std::vector<std::int64_t> time_ns;
  for (std::size_t k = 0; k < rows; ++k) {
    const auto sent_ns =
        static_cast<std::int64_t>(std::llround(1e9 * static_cast<double>(k) / rate_hz));
    time_ns.push_back((sent_ns / burst_ns + 1) * burst_ns);
  }
  return time_ns;
}

TEST(HardCasesTrial, RateOfLinesInBursts) {
  constexpr double kRate = 10'000;
  const auto time_ns = Bursts(30'000, kRate, 16'000'000);
  const auto stretches = trial::FitArrivalTimes(time_ns, std::nullopt);
  ASSERT_EQ(stretches.size(), 1U);
  // the last burst is cut off, so that its arrival is late: one burst in 3 s
  const double naive = 29'999 / (1e-9 * static_cast<double>(time_ns.back() - time_ns.front()));
  Check({"trial", "rate of lines in bursts of 16 ms, 3 s", "arrival is late by up to a burst",
         "rows over the time from the first to the last", 1e-6},
        {static_cast<long double>(kRate), stretches.front().rate_hz, naive});
}

TEST(HardCasesTrial, TimesOfARowFarOut) {
  trial::UniformGrid grid(44'100);
  grid.Append(0, 100'000'000);
  const trial::Stretch& stretch = grid.stretches().front();
  const double ours = stretch.start_s + 99'999'999 / stretch.rate_hz;
  float sum = 0;
  for (int k = 0; k < 1'000'000; ++k) sum += 1 / 44'100.0F;
  Check({"trial", "time of row 1e8 at 44.1 kHz", "the interval is no binary number",
         "the interval added up in float, here 1e6 times and scaled", 2.3e-16},
        {99'999'999.0L / 44'100, ours, static_cast<double>(sum) * 99.999999});
}

TEST(HardCasesTrial, TwoBytesThatChangedPlaces) {
  const std::array<std::byte, 4> right{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}};
  const std::array<std::byte, 4> wrong{std::byte{1}, std::byte{3}, std::byte{2}, std::byte{4}};
  const auto sum = [](const auto& bytes) {
    int total = 0;
    for (const std::byte byte : bytes) total += std::to_integer<int>(byte);
    return total;
  };
  Check({"trial", "two bytes that changed places", "their sum is the same",
         "a checksum that adds bytes: 1 where it differs", 0},
        {1, trial::Crc32(right) != trial::Crc32(wrong) ? 1.0 : 0.0,
         sum(right) != sum(wrong) ? 1.0 : 0.0});
}

// the remainder of `bytes` by the polynomial of CRC-32, bit by bit, the lowest bit of a byte first
std::uint32_t RemainderFrom(std::uint32_t crc, std::string_view bytes) {
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xedb8'8320U : 0U);
  }
  return crc;
}

// the same, the highest bit of a byte first
std::uint32_t RemainderOfHighFirst(std::string_view bytes) {
  std::uint32_t crc = 0xffff'ffff;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint32_t>(static_cast<unsigned char>(byte)) << 24U;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc << 1U) ^ ((crc & 0x8000'0000U) != 0 ? 0x04c1'1db7U : 0U);
    }
  }
  return crc;
}

double CrcOf(std::string_view text) {
  return trial::Crc32(std::as_bytes(std::span(text.data(), text.size())));
}

TEST(HardCasesTrial, CrcOfThePublishedCheckText) {
  // 0xcbf43926: check value of CRC-32/ISO-HDLC in the catalogue of parametrised CRC algorithms
  Check({"trial", "CRC-32 of 123456789", "wires send the lowest bit first",
         "CRC-32/MPEG-2, the highest bit first", 0},
        {0xcbf4'3926, CrcOf("123456789"), static_cast<double>(RemainderOfHighFirst("123456789"))});
}

void CheckZeros(const char* name, std::size_t bytes) {
  std::string text(bytes, '\0');
  for (int k = 0; k < 5; ++k) text += "row";
  const long double truth = RemainderFrom(0xffff'ffff, text) ^ 0xffff'ffff;
  Check({"trial", name, "a remainder does not change by zeros in front", "a CRC begun at 0", 0},
        {truth, CrcOf(text), static_cast<double>(RemainderFrom(0, text))});
}

// below 64 bytes, of 64 and more, and of 256 and more the methods differ
TEST(HardCasesTrial, CrcBehindAFewZeros) { CheckZeros("CRC-32 behind 20 zeros", 20); }

TEST(HardCasesTrial, CrcBehindManyZeros) { CheckZeros("CRC-32 behind 180 zeros", 180); }

TEST(HardCasesTrial, CrcBehindZerosOfABlock) { CheckZeros("CRC-32 behind 4000 zeros", 4000); }

// counts of 0.1 um about 30 mm at 1 kHz; row `bad` has no target
constexpr int kRows = 4001;
std::string TrialOfCounts(std::optional<int> bad) {
  trial::MemoryDisk disk;
  ManualClock clock;
  trial::TrialHeader header = trial::CountsHeader(trial::Timing::kUniform);
  header.channels[0].scale = 1e-7;
  header.channels[0].offset = 0.03;
  auto writer = trial::WriterInto(&disk, header, clock);
  for (int k = 0; k < kRows; ++k) {
    const bool is_bad = k == bad;
    EXPECT_TRUE(
        trial::AppendCounts(&writer, is_bad ? -99998 : k % 7 - 3, {.index = k},
                            is_bad ? trial::SampleStatus::kInvalid : trial::SampleStatus::kOk));
  }
  EXPECT_TRUE(writer.Finish());
  return disk.bytes;
}

// values of all rows, as they are read by range
std::vector<double> DecodedRows(const std::string& bytes) {
  auto reader = trial::TrialReader::OpenFrom(trial::MakeMemorySource(bytes), "t.bin");
  EXPECT_TRUE(reader);
  const auto rows = trial::TrialRows::From(std::move(*reader), "t.bin");
  EXPECT_TRUE(rows);
  std::vector<double> values((*rows)->head().rows);
  std::vector<trial::SampleStatus> statuses(values.size());
  EXPECT_TRUE((*rows)->Read(0, 0, values, statuses));
  return values;
}

TEST(HardCasesTrial, CountsBesideAStandingDistance) {
  const std::vector<double> values = DecodedRows(TrialOfCounts(std::nullopt));
  ASSERT_EQ(values.size(), kRows);
  const float scale = 1e-7F, offset = 0.03F;
  double ours = 0, naive = 0;
  int squares = 0;
  for (int k = 0; k < kRows; ++k) {
    const int counts = k % 7 - 3;
    squares += counts * counts;
    ours += counts * (values[static_cast<std::size_t>(k)] - 0.03);
    naive += counts * (static_cast<double>(static_cast<float>(counts) * scale + offset) - 0.03);
  }
  // slope of the values over the counts of the same rows
  // the bar: a value of 30 mm rounds by 3.5e-18 m, 2e-11 of a deviation
  Check({"trial", "step of counts of 0.1 um about 30 mm, by 4001 decoded rows",
         "the counts are 3e-6 of the distance", "decoded as float", 1e-10},
        {1e-7L, ours / squares, naive / squares});
}

TEST(HardCasesTrial, RowWithoutATarget) {
  const std::vector<double> values = DecodedRows(TrialOfCounts(2000));
  double sum = 0, all = 0;
  int measured = 0;
  for (int k = 0; k < kRows; ++k) {
    const double value = values[static_cast<std::size_t>(k)];
    const int counts = k == 2000 ? -99998 : k % 7 - 3;
    all += 0.03 + 1e-7 * counts;
    if (std::isnan(value)) continue;
    sum += value;
    ++measured;
  }
  long double truth = 0;
  for (int k = 0; k < kRows; ++k) truth += k == 2000 ? 0 : k % 7 - 3;
  // the bar: 4000 additions to a sum of 120 m
  Check({"trial", "mean distance beside one row of -99998 counts",
         "the counts of a row without a target are a code", "mean of all counts", 1e-13},
        {0.03L + 1e-7L * truth / (kRows - 1), sum / measured, all / kRows});
}

TEST(HardCasesTrial, FlippedBitOfARow) {
  std::string bytes = trial::CountingTrial(1000, 100);
  // four bytes of row 550, then its status
  const std::string row({static_cast<char>(550 & 0xff), 550 >> 8, 0, 0, 0});
  const std::size_t at = bytes.find(row);
  ASSERT_NE(at, std::string::npos);
  bytes[at + 1] = static_cast<char>(bytes[at + 1] ^ 0x40);
  const auto recording = trial::ReadBytes(bytes);
  ASSERT_TRUE(recording);
  int wrong = 0;
  for (const double value : recording->record.channels[0].values) {
    const double counts = (value - 0.25) / 1e-6;
    wrong += std::isnan(value) || (counts > -0.5 && counts < 999.5) ? 0 : 1;
  }
  Check({"trial", "wrong values of a trial of 1000 rows with a flipped bit",
         "a flipped bit leaves a number", "rows taken as they lie", 0},
        {0, static_cast<double>(wrong), bytes.find(row) == std::string::npos ? 1.0 : 0.0});
}

TEST(HardCasesTrial, TornLastBlock) {
  const std::string bytes = trial::CountingTrial(1000, 100);
  // two rows of five bytes are gone, and the block of the totals
  const std::string last({static_cast<char>(997 & 0xff), 997 >> 8, 0, 0, 0});
  const std::size_t end = bytes.find(last) + 2;
  const auto recording = trial::ReadBytes(bytes.substr(0, end));
  ASSERT_TRUE(recording);
  const std::size_t begin = bytes.find(std::string("\0\0\0\0\0\1\0\0\0\0", 10));
  ASSERT_NE(begin, std::string::npos);
  const std::size_t by_size = (end - begin) / 5;
  Check({"trial", "rows of a trial that ends within its tenth block",
         "a row of a torn block may be cut", "bytes over bytes of a row", 0},
        {900, static_cast<double>(recording->record.rows), static_cast<double>(by_size)});
}

TEST(HardCasesTrial, TimeOfAPolledReading) {
  // asked every 10 ms, answered after 4 ms: the reading is from between
  std::vector<std::int64_t> request_ns, reply_ns;
  for (std::int64_t k = 0; k < 100; ++k) {
    request_ns.push_back(k * 10'000'000);
    reply_ns.push_back(k * 10'000'000 + 4'000'000);
  }
  const auto stretches = trial::FitPolledTimes(request_ns, reply_ns, std::nullopt);
  ASSERT_EQ(stretches.size(), 1U);
  // the bar: sums over 100 rows of times to 1 s
  Check({"trial", "time of the first of 100 polled readings", "it is of any age up to the request",
         "time of the reply", 1e-12},
        {0.002L, stretches[0].start_s, 1e-9 * static_cast<double>(reply_ns[0])});
}

TEST(HardCasesTrial, TimeBehindLostLines) {
  // 1 kHz; 300 numbered lines are lost before row 1000
  std::vector<std::int64_t> time_ns;
  for (std::int64_t k = 0; k < 2000; ++k) {
    time_ns.push_back((k + (k < 1000 ? 0 : 300)) * 1'000'000);
  }
  const std::array missing{trial::MissingRows{1000, 300}};
  const auto stretches = trial::FitArrivalTimes(time_ns, std::nullopt, missing, true);
  ASSERT_EQ(stretches.size(), 2U);
  const trial::Stretch& second = stretches[1];
  const double ours = second.start_s + 999 / second.rate_hz;
  // the bar: rounding of a line through times of up to 2.3 s
  Check({"trial", "time of row 1999 behind 300 lost lines", "rows are numbered as they came",
         "row over the rate", 1e-12},
        {2.299L, ours, 1999 / 1000.0});
}

TEST(HardCasesTrial, RateOfLinesWhoseEndIsLate) {
  // 1 kHz for 3 s; the lines of the last 0.2 s arrive together
  std::vector<std::int64_t> time_ns;
  for (std::int64_t k = 0; k < 3000; ++k) {
    time_ns.push_back(k < 2800 ? k * 1'000'000 : 3'000'000'000);
  }
  const auto stretches = trial::FitArrivalTimes(time_ns, std::nullopt);
  ASSERT_EQ(stretches.size(), 1U);
  // least squares of time over row, about the means
  double tt = 0, rt = 0, rr = 0, mean_s = 0;
  for (const std::int64_t time : time_ns) mean_s += 1e-9 * static_cast<double>(time) / 3000;
  for (std::size_t k = 0; k < time_ns.size(); ++k) {
    const double row = static_cast<double>(k) - 1499.5;
    const double time_s = 1e-9 * static_cast<double>(time_ns[k]) - mean_s;
    tt += time_s * time_s;
    rt += row * time_s;
    rr += row * row;
  }
  ASSERT_GT(tt, 0);
  // the bar: a nanosecond over the span of 2.8 s
  Check({"trial", "rate of lines of which the last 0.2 s come together",
         "lines are late, never early", "least squares of time over row", 1e-9},
        {1000, stretches[0].rate_hz, rr / rt});
}

TEST(HardCasesTrial, TimesPrintedFromFloats) {
  std::string text = "time_s,displacement_m\n";
  std::vector<double> times_s;
  for (int k = 0; k < 20'000; ++k) {
    const float time_s = static_cast<float>(k * 1e-4);
    times_s.push_back(static_cast<double>(time_s));
    text += fmt::format("{:.9f},0.25\n", times_s.back());
  }
  const auto record = trial::ParseCsv(text, "t.csv");
  ASSERT_TRUE(record) << record.error().Text();
  ASSERT_EQ(record->stretches.size(), 1U);
  // the bar: a float's rounding of either end, over the span
  Check({"trial", "rate of times kept as 32-bit floats",
         "intervals of 100 us have steps of 0.12 us", "1 over the last interval", 5e-7},
        {10'000, record->stretches[0].rate_hz, 1 / (times_s[19'999] - times_s[19'998])});
}

TEST(HardCasesTrial, DecimalComma) {
  const auto ours = trial::ReadNumberWithComma("-0,0123");
  ASSERT_TRUE(ours.has_value());
  // the bar: -0.0123 is no binary number
  Check({"trial", "-0,0123", "half of the world writes a decimal comma", "strtod", 1.2e-16},
        {-0.0123L, *ours, std::strtod("-0,0123", nullptr)});
}

TEST(HardCasesTrial, UnitWithACapitalM) {
  // units in lower case, of which "mv" is 1e-3 V; 0 where there is no factor
  const auto unit = trial::FindUnit("MV");
  Check({"trial", "factor of a column in MV, 0 where it is refused", "m is milli, M is mega",
         "names of units in lower case", 0},
        {0, unit ? unit->factor : 0, trial::FindUnit(trial::LowerCase("MV"))->factor});
}

TEST(HardCasesTrial, DisplacementThroughATable) {
  trial::Record record;
  record.rows = 2;
  record.stretches = {{.rows = 2, .rate_hz = 1000}};
  const double value = 0.03 + 1e-9 / 3;
  record.channels = {{.name = "displacement",
                      .role = trial::ChannelRole::kDisplacement,
                      .unit = "m",
                      .values = {value, 0.03},
                      .statuses = {trial::SampleStatus::kOk, trial::SampleStatus::kOk}}};
  std::string text;
  ASSERT_TRUE(trial::WriteCsv(record, [&](std::string_view piece) -> Result<void> {
    text += piece;
    return {};
  }));
  const auto read = trial::ParseCsv(text, "t.csv");
  ASSERT_TRUE(read) << read.error().Text();
  const auto& values = read->channels[0].values;
  const double printed = std::strtod(fmt::format("{:g}", value).c_str(), nullptr);
  Check({"trial", "a third of a nm beside 30 mm through a CSV", "it is the eleventh digit",
         "printf's %g", 0},
        {static_cast<long double>(value) - static_cast<long double>(0.03), values[0] - values[1],
         printed - 0.03});
}

TEST(HardCasesTrial, UncertaintyInBrackets) {
  const auto mass = ParseQuantity("1.40(3)g", Dimension::kMass, "mass");
  ASSERT_TRUE(mass.has_value());
  // the bar: two roundings
  Check({"trial", "uncertainty of 1.40(3) g in kg", "the bracket counts units of the last digit",
         "3 units of g", 3e-16},
        {3e-5L, mass->standard_uncertainty, 3 * 1e-3});
}

TEST(HardCasesTrial, HighestCountOfAConverter) {
  // 16 bits over +-10 V: 32767 is 9.9997 V
  trial::ChannelCalibration line;
  line.limits.rail_min = -10;
  line.limits.rail_max = 10;
  trial::ChannelFormat format = trial::DisplacementCounts("displacement", 1);
  const trial::RawLimits limits = trial::Calibrate(line, 10.0 / 32768, 0, &format);
  const bool clipped = trial::StatusOf(limits, 32767) == trial::SampleStatus::kClipped;
  Check({"trial", "clipped counts in a reading of 32767",
         "the highest count stands for one step less than the rail", "input of 10 V and more", 0},
        {1, clipped ? 1.0 : 0.0, 32767 * 10.0 / 32768 >= 10 ? 1.0 : 0.0});
}

}  // namespace
}  // namespace haptometer::hard_cases
