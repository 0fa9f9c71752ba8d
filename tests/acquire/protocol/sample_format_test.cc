// Rows of samples from bytes that another language wrote.
#include "acquire/protocol/sample_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace haptometer::acquire {
namespace {

using ::testing::ElementsAre;
using trial::SampleStatus;
using Statuses = std::vector<SampleStatus>;

struct Parsed {
  std::vector<double> numbers;
  Statuses statuses;
  std::size_t waiting = 0;
  std::uint64_t discarded = 0;
};

Parsed Parse(SampleFormat format, std::size_t channels, std::string_view bytes,
             const trial::RawLimits& limits = {}, std::size_t piece = 7) {
  SampleParser parser(format, std::vector(channels, limits));
  std::vector<trial::Sample> row(channels);
  Parsed parsed;
  while (!bytes.empty()) {
    parser.Feed(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    while (parser.Next(row) != RowState::kNeedMore) {
      for (const trial::Sample& sample : row) {
        parsed.numbers.push_back(sample.raw.Number(EncodingOf(format)));
        parsed.statuses.push_back(sample.status);
      }
    }
  }
  parsed.waiting = parser.waiting_bytes();
  parsed.discarded = parser.discarded_bytes();
  return parsed;
}

// python3 -c 'import struct; print(struct.pack("<4d", 1.5, -2e-7, 0.1, 3).hex())', and so on
TEST(SampleFormat, ReadsDoublesThatPythonWrote) {
  const std::string bytes(
      "\x00\x00\x00\x00\x00\x00\xf8\x3f\x48\xaf\xbc\x9a\xf2\xd7\x8a\xbe"
      "\x9a\x99\x99\x99\x99\x99\xb9\x3f\x00\x00\x00\x00\x00\x00\x08\x40",
      32);
  EXPECT_THAT(Parse(SampleFormat::kF64, 2, bytes).numbers, ElementsAre(1.5, -2e-7, 0.1, 3));
}

TEST(SampleFormat, ReadsFloatsAndCounts) {
  EXPECT_THAT(
      Parse(SampleFormat::kF32, 1, std::string("\x00\x00\xc0\xbf\xcd\xcc\xcc\x3d", 8)).numbers,
      ElementsAre(-1.5, static_cast<double>(0.1F)));
  EXPECT_THAT(
      Parse(SampleFormat::kI16, 2, std::string("\xff\xff\x00\x80\xff\x7f\x02\x01", 8)).numbers,
      ElementsAre(-1, -32768, 32767, 258));
}

TEST(SampleFormat, ARowThatIsCutWaits) {
  const Parsed parsed =
      Parse(SampleFormat::kI16, 2, std::string("\x01\x00\x02\x00\x03\x00\x04", 7));
  EXPECT_THAT(parsed.numbers, ElementsAre(1, 2));
  EXPECT_EQ(parsed.waiting, 3U);
}

TEST(SampleFormat, WhatIsNoNumberIsInvalid) {
  // NaN, +infinity, 1
  const std::string bytes(
      "\x00\x00\x00\x00\x00\x00\xf8\x7f\x00\x00\x00\x00\x00\x00\xf0\x7f\x00\x00\x00\x00\x00\x00"
      "\xf0\x3f",
      24);
  EXPECT_EQ(Parse(SampleFormat::kF64, 1, bytes).statuses,
            (Statuses{SampleStatus::kInvalid, SampleStatus::kInvalid, SampleStatus::kOk}));
  EXPECT_EQ(Parse(SampleFormat::kText, 1, "nan\ninf\n-inf\n1\n").statuses,
            (Statuses{SampleStatus::kInvalid, SampleStatus::kInvalid, SampleStatus::kInvalid,
                      SampleStatus::kOk}));
}

TEST(SampleFormat, LimitsAreOfTheNumbersAsTheyCome) {
  const trial::RawLimits limits{.rail_min = -10, .rail_max = 10, .bad_above = 5.25};
  EXPECT_EQ(Parse(SampleFormat::kText, 1, "5.25\n5.5\n10\n-10\n", limits).statuses,
            (Statuses{SampleStatus::kOk, SampleStatus::kInvalid, SampleStatus::kClipped,
                      SampleStatus::kClipped}));
}

TEST(SampleFormat, TextTakesAnySeparator) {
  for (const char* text : {"1 2.5 -3e-3\n", "1,2.5,-3e-3\n", "1;2.5;-3e-3\r\n", "1\t2.5\t-3e-3\n",
                           "  +1 ,  2.5 ; -0.003 \t\n", "1  2.5\t \t-3e-3\n"}) {
    const Parsed parsed = Parse(SampleFormat::kText, 3, text);
    EXPECT_THAT(parsed.numbers, ElementsAre(1, 2.5, -3e-3)) << text;
    EXPECT_EQ(parsed.statuses, Statuses(3, SampleStatus::kOk)) << text;
  }
}

TEST(SampleFormat, AWrongLineIsABadRowAndTheNextIsRead) {
  for (const char* line :
       {"1", "1,2,3", "1,", ",1", "1,,2", "1 x", "1,2,", "0x1,2", "1e999 1", "1 2 # no"}) {
    const Parsed parsed = Parse(SampleFormat::kText, 2, "1,2\n" + std::string(line) + "\n3,4\n");
    EXPECT_EQ(parsed.statuses,
              (Statuses{SampleStatus::kOk, SampleStatus::kOk, SampleStatus::kBadFrame,
                        SampleStatus::kBadFrame, SampleStatus::kOk, SampleStatus::kOk}))
        << line;
    EXPECT_EQ(parsed.numbers.back(), 4) << line;
    EXPECT_EQ(parsed.discarded, std::string(line).size()) << line;
  }
}

TEST(SampleFormat, CommasMayBeMeantAsDecimalSigns) {
  const auto is_row = [](std::size_t channels, const std::string& line) {
    SampleParser parser(SampleFormat::kText, std::vector<trial::RawLimits>(channels));
    std::vector<trial::Sample> row(channels);
    parser.Feed(line + "\n");
    (void)parser.Next(row);
    return parser.IsRowWithDecimalCommas();
  };
  EXPECT_TRUE(is_row(2, "-0,326;0,0000"));
  EXPECT_TRUE(is_row(2, "1,5\t2"));
  EXPECT_TRUE(is_row(1, "1,5e-3"));
  for (const char* line : {"1.5;2.5;3", "Weg,1;Spannung", "1,2,3", "1,5;2,5;3,5", "1,5", ""}) {
    EXPECT_FALSE(is_row(2, line)) << line;
  }
}

TEST(SampleFormat, ALineWithoutEndIsOneBadRow) {
  std::string line(5000, '1');
  const Parsed parsed = Parse(SampleFormat::kText, 1, line.append("\n2\n"));
  EXPECT_EQ(parsed.statuses, (Statuses{SampleStatus::kBadFrame, SampleStatus::kOk}));
  EXPECT_EQ(parsed.discarded, 5001U);
}

TEST(SampleFormat, TheLastLineMayBeCutSoItWaits) {
  const Parsed parsed = Parse(SampleFormat::kText, 1, "1\n\n\n23");
  EXPECT_THAT(parsed.numbers, ElementsAre(1));
  EXPECT_EQ(parsed.waiting, 2U);
}

TEST(SampleFormat, NamesAreThoseOfTheOption) {
  for (const char* name : {"f64", "f32", "i16", "text"}) {
    EXPECT_EQ(Name(*SampleFormatFromName(name)), name);
  }
  EXPECT_FALSE(SampleFormatFromName("f16"));
}

TEST(SampleFormat, ALineHas48CharactersAChannelAtMost) {
  for (const std::size_t channels : {1U, 3U}) {
    std::string row = "1";
    for (std::size_t channel = 1; channel < channels; ++channel) row += ",1";
    const std::string fits = std::string(48 * channels - row.size(), ' ') + row;
    EXPECT_EQ(Parse(SampleFormat::kText, channels, fits + "\n").statuses,
              Statuses(channels, SampleStatus::kOk));
    const Parsed parsed = Parse(SampleFormat::kText, channels, " " + fits + "\n");
    EXPECT_EQ(parsed.statuses, Statuses(channels, SampleStatus::kBadFrame));
    EXPECT_EQ(parsed.discarded, 48 * channels + 2) << "with its end";
  }
}

}  // namespace
}  // namespace haptometer::acquire
