// Lines that a sensor sends by itself, in any drawn form.
#include "acquire/protocol/stream_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using ::testing::HasSubstr;
using trial::SampleStatus;

const StreamFormat kDefault;

StreamFormat Format(std::string_view text) {
  const auto format = ParseStreamFormat(text);
  EXPECT_TRUE(format) << text << ": " << format.error().Text();
  return format.value_or(StreamFormat{});
}

TEST(StreamLine, TheDefaultIsNineBytesOfTenthsOfMicrometres) {
  EXPECT_EQ(ParseStreamLine(kDefault, "+01.2345"), (Value{12'345, 4, SampleStatus::kOk}));
  EXPECT_EQ(ParseStreamLine(kDefault, "-00.0001"), (Value{-1, 4, SampleStatus::kOk}));
  EXPECT_EQ(FormatStreamLine(kDefault, {12'345, 4, SampleStatus::kOk}), "+01.2345\r");
  EXPECT_EQ(LineBytes(kDefault), 9U);
  EXPECT_EQ(MostLinesPerSecond(kDefault, 921600), 10240);
  EXPECT_REL(MetresPerCount(kDefault), 1e-7, 1e-15, "one division");
}

TEST(StreamLine, LettersAreStatuses) {
  EXPECT_EQ(ParseStreamLine(kDefault, "+FFFFFFF"), (Value{kNoCounts, 4, SampleStatus::kOver}));
  EXPECT_EQ(ParseStreamLine(kDefault, "-FFFFFFF"), (Value{kNoCounts, 4, SampleStatus::kUnder}));
  EXPECT_EQ(ParseStreamLine(kDefault, "XXXXXXXX"), (Value{kNoCounts, 4, SampleStatus::kInvalid}));
  EXPECT_EQ(ParseStreamLine(kDefault, "--------"), (Value{kNoCounts, 4, SampleStatus::kInvalid}));
  for (const SampleStatus status :
       {SampleStatus::kOver, SampleStatus::kUnder, SampleStatus::kInvalid}) {
    const std::string line = FormatStreamLine(kDefault, {0, 4, status});
    EXPECT_EQ(ParseStreamLine(kDefault, std::string_view(line).substr(0, 8))->status, status);
  }
  // without a measurement, no number counts
  for (const std::int32_t counts : {0, kNoCounts, 1'000'000, -1'000'000}) {
    EXPECT_EQ(FormatStreamLine(kDefault, {counts, 4, SampleStatus::kDeviceError}), "XXXXXXXX\r");
  }
}

TEST(StreamLine, WhatDoesNotFitIsOverOrUnderAndNeverClamped) {
  EXPECT_EQ(FormatStreamLine(kDefault, {999'999, 4, SampleStatus::kOk}), "+99.9999\r");
  EXPECT_EQ(FormatStreamLine(kDefault, {1'000'000, 4, SampleStatus::kOk}), "+FFFFFFF\r");
  EXPECT_EQ(FormatStreamLine(kDefault, {-1'000'000, 4, SampleStatus::kOk}), "-FFFFFFF\r");
  EXPECT_EQ(FormatStreamLine(Format("000,um,LF"), {-1, 0, SampleStatus::kOk}), "FFF\n");
}

TEST(StreamLine, OnlyTheDrawnFormIsAReading) {
  for (const std::string_view line :
       {"", "+01.234", "+01.23456", "01.2345", " 01.2345", "+012.345", "+01,2345", "+01.234 ",
        "+01.23+01", "1.2345\r+", "+0x.2345", "+FFFFFF0", "XXXXXXX0", "*01.2345"}) {
    EXPECT_FALSE(ParseStreamLine(kDefault, line)) << line;
  }
}

TEST(StreamLine, EveryFormatGivesBackItsNumbers) {
  for (const std::string_view text :
       {"+00.0000,mm,CR", "+000000,0.1um,CRLF", "0.00,mm,LF", "+0.00000000,m,CR", "0,nm,LF",
        "+000.000,mm,CRLF", "+0.0,mm,CR"}) {
    const StreamFormat format = Format(text);
    const std::int32_t most = MostCounts(format);
    const std::int32_t least = format.sign == SignRule::kAlways ? -most : 0;
    for (const std::int32_t counts : {least, least / 7, 0, 1, most / 3, most}) {
      const std::string line = FormatStreamLine(format, {counts, format.decimals, {}});
      ASSERT_EQ(line.size(), LineBytes(format));
      const auto value =
          ParseStreamLine(format, std::string_view(line).substr(0, LineWidth(format)));
      ASSERT_TRUE(value) << line;
      EXPECT_EQ(value->counts, counts) << line;
    }
  }
}

TEST(StreamLine, ACounterStandsInFrontAndTurnsRound) {
  const StreamFormat format = Format("000,+00.0000,mm,CR");
  EXPECT_EQ(CounterTurn(format), 1000);
  EXPECT_EQ(CounterTurn(kDefault), 1);
  EXPECT_EQ(LineBytes(format), 13U);
  EXPECT_EQ(FormatStreamLine(format, {12'345, 4, {}}, 7), "007,+01.2345\r");
  EXPECT_EQ(FormatStreamLine(format, {12'345, 4, {}}, 123'456), "456,+01.2345\r");
  EXPECT_EQ(FormatStreamLine(format, {0, 4, SampleStatus::kOver}, 7), "007,+FFFFFFF\r");
  EXPECT_EQ(FormatStreamLine(format, {0, 4, SampleStatus::kInvalid}, 7), "007,XXXXXXXX\r");
  EXPECT_EQ(ParseStreamLine(format, "456,-01.2345")->counts, -12'345);
  EXPECT_EQ(ParseStreamLine(format, "456,XXXXXXXX")->status, SampleStatus::kInvalid);
  EXPECT_EQ(LineCount(format, "456,-01.2345"), 456);
  for (const char* line : {"+01.2345", "45,-01.2345", "4x6,-01.2345", "456;-01.2345",
                           "-56,-01.2345", "456-01.23450", "XXX,XXXXXXXX", "XXXXXXXXXXXX"}) {
    EXPECT_FALSE(ParseStreamLine(format, line)) << line;
  }
}

TEST(StreamLine, ACounterHasOneDigitToNine) {
  const StreamFormat one = Format("0;0.0,mm,LF");
  EXPECT_EQ(LineBytes(one), 6U);
  EXPECT_EQ(FormatStreamLine(one, {12, 1, {}}, 17), "7;1.2\n");
  EXPECT_EQ(ParseStreamLine(one, "7;1.2"), (Value{12, 1, SampleStatus::kOk}));
  EXPECT_EQ(LineCount(one, "7;1.2"), 7);
  EXPECT_FALSE(ParseStreamLine(one, "7,1.2"));
  const StreamFormat nine = Format("000000000,0.0,mm,LF");
  EXPECT_EQ(CounterTurn(nine), 1'000'000'000);
  EXPECT_EQ(FormatStreamLine(nine, {0, 1, {}}, 1'000'000'003), "000000003,0.0\n");
}

TEST(StreamFormatText, DrawsACounterAndItsSeparator) {
  EXPECT_EQ(Format("+00.0000,mm,CR").counter_digits, 0);
  for (const char separator : {',', ';', ':', ' ', '\t'}) {
    const StreamFormat format = Format(std::string("00000") + separator + "0.00,mm,LF");
    EXPECT_EQ(format.counter_digits, 5);
    EXPECT_EQ(format.separator, separator);
    EXPECT_EQ(format.whole_digits, 1);
    EXPECT_EQ(format.sign, SignRule::kNever);
  }
}

TEST(StreamFormatText, SetsUnitAndDelimiter) {
  const StreamFormat format = Format("+000000,0.1um,CRLF");
  EXPECT_EQ(format.decimals, 0);
  EXPECT_EQ(format.delimiter, Delimiter::kCrLf);
  EXPECT_REL(MetresPerCount(format), 1e-7, 1e-15, "a decimal read once");
  EXPECT_EQ(Format("0.00,mm,LF").sign, SignRule::kNever);
  EXPECT_EQ(Format("0.00,mm,LF").unit_m, 1e-3);
  EXPECT_EQ(Format("0.00,9mm,LF").unit_m, 9e-3);
  EXPECT_EQ(Format("0.00,0.5mm,LF").unit_m, 0.5e-3);
  EXPECT_EQ(Format("0.00,.5mm,LF").unit_m, 0.5e-3);
  EXPECT_FALSE(ParseStreamFormat("0.00,e3mm,LF")) << "it was read as 1e3 mm";
}

TEST(StreamLine, ARateNeedsAWire) {
  EXPECT_REL(MostLinesPerSecond(kDefault, 1), 1.0 / 90, 1e-15, "one division");
  EXPECT_DEATH((void)MostLinesPerSecond(kDefault, 0), "baud = 0");
}

TEST(StreamFormatText, RefusesInOneLineWithTheRemedy) {
  for (const std::string_view text :
       {"", "+00.0000", "+00.0000,mm", "+01.2345,mm,CR", "+,mm,CR", "+00.,mm,CR", ".00,mm,CR",
        "+0000000000,mm,CR", "+00.00,V,CR", "+00.00,0mm,CR", "+00.00,mm,cr", "+00.00,mm,CR,LF",
        "+000,00.0,mm,CR", ",00.0,mm,CR", "00 00 00.0,mm,CR", "0000000000,00.0,mm,CR"}) {
    const auto format = ParseStreamFormat(text);
    ASSERT_FALSE(format) << text;
    EXPECT_EQ(format.error().cause, Cause::kUsage) << text;
    EXPECT_THAT(format.error().Text(), HasSubstr("<format>")) << text;
  }
}

TEST(StreamLine, AllNinesAreOverOrUnder) {
  const StreamFormat millimetres = ParseStreamFormat("+00.0000,mm,CR").value();
  EXPECT_EQ(ParseStreamLine(millimetres, "+99.9999"), (Value{999'999, 4, SampleStatus::kOver}));
  EXPECT_EQ(ParseStreamLine(millimetres, "-99.9999"), (Value{-999'999, 4, SampleStatus::kUnder}));
  EXPECT_EQ(ParseStreamLine(millimetres, "+99.9998"), (Value{999'998, 4, SampleStatus::kOk}));
  EXPECT_EQ(ParseStreamLine(millimetres, "-99.9998"), (Value{-999'998, 4, SampleStatus::kOk}));
  const StreamFormat numbered = ParseStreamFormat("000,000000,0.1um,LF").value();
  EXPECT_EQ(ParseStreamLine(numbered, "999,999999"), (Value{999'999, 0, SampleStatus::kOver}));
  EXPECT_EQ(ParseStreamLine(numbered, "999,000000"), (Value{0, 0, SampleStatus::kOk}));
}

}  // namespace
}  // namespace haptometer::acquire
