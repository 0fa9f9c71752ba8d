// The DL-RS1A's lines against the maker's manual: bytes as they stand there, never as we write
// them.
#include "acquire/protocol/keyence/dl_rs1a.h"

#include <gtest/gtest.h>

#include "tests/residual.h"

namespace haptometer::acquire::dl_rs1a {
namespace {

using dl::Command;
using dl::ParsedRequest;
using dl::ReplyKind;
using dl::Request;
using trial::SampleStatus;

std::string FromHex(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 3) {
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
  }
  return bytes;
}

// a line captured from a unit with two amplifiers
const std::string kCaptured =
    FromHex("4D 30 2C 2D 30 30 2E 30 30 37 2C 2B 30 30 2E 30 31 38 0D 0A");

std::string_view Line(std::string_view bytes) { return bytes.substr(0, bytes.size() - 2); }

TEST(DlRs1aReply, ReadsTheCapturedM0) {
  const auto reply = dl::ParseReply(Spelling(), Line(kCaptured));
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->kind, ReplyKind::kM0);
  ASSERT_EQ(reply->units, 2U);
  EXPECT_EQ(reply->values[0], (Value{-7, 3, SampleStatus::kOk}));
  EXPECT_EQ(reply->values[1], (Value{18, 3, SampleStatus::kOk}));
}

TEST(DlRs1aReply, WritesTheCapturedM0) {
  const std::array values{Value{-7, 3, SampleStatus::kOk}, Value{18, 3, SampleStatus::kOk}};
  EXPECT_EQ(dl::FormatM0Reply(Spelling(), values), kCaptured);
}

// data 042: sign, digit, point, three digits; +5.500 in the error state (IL Edition, p. 13-14)
TEST(DlRs1aValue, AnalogOutputInMillivolts) {
  for (const auto& [text, mv] : {std::pair("+5.500", kAnalogErrorMv),
                                 {"-5.000", -5000},
                                 {"+0.000", 0},
                                 {"-0.012", -12},
                                 {"+1.234", 1234}}) {
    EXPECT_EQ(ParseAnalogMv(text), mv) << text;
    EXPECT_EQ(FormatAnalogMv(mv), text);
  }
  // a current output has five characters
  for (const char* text : {"12.00", "+12.00", "1.2345", "+1.23a", "", "+1,234", "++.123"}) {
    EXPECT_FALSE(ParseAnalogMv(text)) << text;
  }
}

TEST(DlRs1aReply, ReadsTheManualsExamples) {
  const auto error = dl::ParseReply(Spelling(), "ER,SR,65");  // SR,06,101: FD-S Edition, p. 10
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind, ReplyKind::kError);
  EXPECT_EQ(error->data, "SR");
  EXPECT_EQ(error->number, kUnitNumber);
  const auto data = dl::ParseReply(Spelling(), "SR,01,134,1");  // IG Edition, p. 10
  ASSERT_TRUE(data);
  EXPECT_EQ(data->kind, ReplyKind::kSr);
  EXPECT_EQ(data->unit, 1);
  EXPECT_EQ(data->number, 134);
  EXPECT_EQ(data->data, "1");
  EXPECT_EQ(dl::FormatDataReply(dl::Command::kSr, 1, 134, "1"), "SR,01,134,1\r\n");
  EXPECT_EQ(dl::FormatErrorReply(Spelling(), {"SR", kUnitNumber}), "ER,SR,65\r\n");
}

TEST(DlRs1aReply, ReadsMsWithOneAndTwoDigitOutputsAndDr) {
  for (const std::string_view line : {"MS,04,-00.007,02,+00.018", "MS,4,-00.007,2,+00.018"}) {
    const auto reply = dl::ParseReply(Spelling(), line);
    ASSERT_TRUE(reply) << line;
    EXPECT_EQ(reply->kind, ReplyKind::kMs);
    ASSERT_EQ(reply->units, 2U);
    EXPECT_EQ(reply->outputs[0], 4);
    EXPECT_EQ(reply->outputs[1], 2);
    EXPECT_EQ(reply->values[1].counts, 18);
  }
  EXPECT_EQ(dl::ParseReply(Spelling(), "DR,04,-00.007")->kind, ReplyKind::kDr);
  const std::array values{Value{-7, 3, SampleStatus::kOk}};
  EXPECT_EQ(dl::FormatMsReply(Spelling(), std::array{4}, values), "MS,04,-00.007\r\n");
}

TEST(DlRs1aReply, RefusesWhatIsNoReply) {
  for (const std::string_view line : {"",
                                      "M",
                                      "M0",
                                      "M0,",
                                      "M1,+00.001",
                                      "m0,+00.001",
                                      "M0,+00.001,",
                                      "M0,+00.00",
                                      "M0,00.0012",
                                      "M0+00.001",
                                      "M0,+00.001M0,+00.002",
                                      "MS,04",
                                      "MS,004,+00.001",
                                      "MS,04,+00.001,04",
                                      "SR,00,195",
                                      "SR,0,195,1",
                                      "SR,00,19,1",
                                      "SR,00,195,12345678901",
                                      "ER,SR",
                                      "ER,SR,5",
                                      "ER,SR,222",
                                      "SR,00,200,\x01\x02",
                                      "M0,+0\x80.001"}) {
    EXPECT_FALSE(dl::ParseReply(Spelling(), line)) << line;
  }
  std::string sixteen = "M0";
  for (int i = 0; i < 16; ++i) sixteen += ",+00.001";
  EXPECT_FALSE(dl::ParseReply(Spelling(), sixteen));
  EXPECT_TRUE(dl::ParseReply(Spelling(), sixteen.substr(0, sixteen.size() - 8)));
}

struct SpecialValue {
  std::string_view text;
  Value value;
};

// IL Edition, p. 13-14: the strings that are no measurement, for each number of decimals
const std::array kSpecialValues{
    SpecialValue{"+EE.EEE", {kNoCounts, 3, SampleStatus::kDeviceError}},
    SpecialValue{"+EEE.EE", {kNoCounts, 2, SampleStatus::kDeviceError}},
    SpecialValue{"+EEEE.E", {kNoCounts, 1, SampleStatus::kDeviceError}},
    SpecialValue{"+99.999", {99'999, 3, SampleStatus::kOver}},
    SpecialValue{"+999.99", {99'999, 2, SampleStatus::kOver}},
    SpecialValue{"+9999.9", {99'999, 1, SampleStatus::kOver}},
    SpecialValue{"-99.999", {-99'999, 3, SampleStatus::kUnder}},
    SpecialValue{"-999.99", {-99'999, 2, SampleStatus::kUnder}},
    SpecialValue{"-9999.9", {-99'999, 1, SampleStatus::kUnder}},
    SpecialValue{"-99.998", {-99'998, 3, SampleStatus::kInvalid}},
    SpecialValue{"-999.98", {-99'998, 2, SampleStatus::kInvalid}},
    SpecialValue{"-9999.8", {-99'998, 1, SampleStatus::kInvalid}},
};

TEST(DlRs1aValue, SpecialStringsAreStatusesBothWays) {
  for (const SpecialValue& special : kSpecialValues) {
    EXPECT_EQ(ParseValue(special.text), special.value) << special.text;
    EXPECT_EQ(FormatValue(special.value), special.text);
  }
  // its positive twin is a measurement
  EXPECT_EQ(ParseValue("+99.998"), (Value{99'998, 3, SampleStatus::kOk}));
}

TEST(DlRs1aValue, EveryNumberSurvivesTheWire) {
  for (int decimals = 1; decimals <= 3; ++decimals) {
    for (std::int32_t counts = -99'997; counts <= 99'998; counts += 13) {
      const Value value{counts, decimals, SampleStatus::kOk};
      const std::string text = FormatValue(value);
      ASSERT_EQ(text.size(), 7U);
      ASSERT_EQ(ParseValue(text), value) << text;
    }
  }
}

TEST(DlRs1aValue, RefusesOtherForms) {
  for (const std::string_view text :
       {"", "+", "12.345", " 12.345", "+12,345", "+123456", "+1.2345", "+12345.", "+.12345",
        "+12.34E", "+E2.EEE", "++2.345", "+12.345 ", "+1 .345", "+FF.FFF"}) {
    EXPECT_FALSE(ParseValue(text)) << text;
  }
}

TEST(DlRs1aRequest, BothWays) {
  EXPECT_EQ(dl::FormatRequest({}), "M0\r\n");
  EXPECT_EQ(dl::FormatRequest({Command::kMs, 0, 0, {}}), "MS\r\n");
  EXPECT_EQ(dl::FormatRequest({Command::kSr, 0, 195, {}}), "SR,00,195\r\n");
  EXPECT_EQ(dl::FormatRequest({Command::kSw, 0, 1, "0"}), "SW,00,001,0\r\n");
  EXPECT_EQ(dl::FormatRequest({Command::kAw, 0, 1, "0"}), "AW,001,0\r\n");
  for (const Request& request :
       {Request{Command::kM0, 0, 0, {}}, Request{Command::kMs, 0, 0, {}},
        Request{Command::kSr, 14, 37, {}}, Request{Command::kSw, 7, 99, "+00012"},
        Request{Command::kAw, 0, 1, "1"}}) {
    const std::string bytes = dl::FormatRequest(request);
    EXPECT_EQ(dl::ParseRequest(Spelling(), Line(bytes)).request, request) << bytes;
  }
}

TEST(DlRs1aRequest, RefusalsCarryTheMakersNumbers) {
  const auto refusal = [](std::string_view line) {
    const ParsedRequest parsed = dl::ParseRequest(Spelling(), line);
    return parsed.request ? std::string("accepted")
                          : dl::FormatErrorReply(Spelling(), parsed.refusal);
  };
  EXPECT_EQ(refusal("XX"), "ER,XX,00\r\n");
  EXPECT_EQ(refusal("m0"), "ER,m0,00\r\n");
  EXPECT_EQ(refusal("M0,1"), "ER,M0,21\r\n");
  EXPECT_EQ(refusal("SR,00"), "ER,SR,21\r\n");
  EXPECT_EQ(refusal("SR,0,195"), "ER,SR,22\r\n");
  EXPECT_EQ(refusal("SR,00,19x"), "ER,SR,22\r\n");
  EXPECT_EQ(refusal("AW,1,0"), "ER,AW,22\r\n");
}

TEST(DlRs1aTables, HeadsSettingsErrors) {
  ASSERT_NE(FindHead(1), nullptr);
  EXPECT_EQ(FindHead(1)->name, "IL-030");
  EXPECT_EQ(FindHead(1)->decimals, 3);
  EXPECT_EQ(FindHead(5)->decimals, 2);
  EXPECT_EQ(FindHead(311)->decimals, 1);
  EXPECT_EQ(FindHead(106)->name, "IL-S025");
  EXPECT_EQ(FindHead(0), nullptr);
  // linear ranges, Keyence AS_98890_IL_C: 25 to 35 mm, 55 to 75 mm, 160 to 440 mm
  EXPECT_EQ(FindHead("IL-030")->linear_half_range_mm, 5);
  EXPECT_EQ(FindHead("IL-065")->linear_half_range_mm, 10);
  EXPECT_EQ(FindHead("IL-100")->linear_half_range_mm, 20);
  EXPECT_EQ(FindHead("IL-300")->linear_half_range_mm, 140);
  EXPECT_EQ(FindHead("IL-600")->linear_half_range_mm, 400);
  EXPECT_EQ(FindHead("IL-S025")->linear_half_range_mm, 5);
  EXPECT_EQ(FindHead("IL-2000")->linear_half_range_mm, 0) << "not known";
  EXPECT_EQ(SamplingSeconds(0), std::nullopt);
  EXPECT_EQ(SamplingSeconds(1), 0.33e-3);
  EXPECT_EQ(SamplingSeconds(4), 5e-3);
  EXPECT_EQ(SamplingSeconds(5), std::nullopt);
  EXPECT_EQ(Averages(0), 1);
  EXPECT_EQ(Averages(4), 16);
  EXPECT_EQ(Averages(12), 4096);
  EXPECT_EQ(Averages(13), std::nullopt);
  EXPECT_EQ(Averages(-1), std::nullopt);
  EXPECT_EQ(HoldName(0), "sample");
  EXPECT_EQ(HoldName(5), "auto bottom");
  EXPECT_EQ(HoldName(6), "");
  EXPECT_EQ(HighPassHz(9), 100);
  EXPECT_EQ(HighPassHz(10), std::nullopt);
  EXPECT_NE(ErrorText(67).find("R/W switch"), std::string_view::npos);
  EXPECT_EQ(ErrorText(1), "unknown error");
}

TEST(DlRs1aTables, PollPeriods) {
  // 4 + 12 characters of 10 bits and 4 ms, by hand
  EXPECT_ABS(static_cast<double>(PollPeriodNs(9600, 1)), 20.666667e6, 1.0, "rounded down to ns");
  EXPECT_ABS(static_cast<double>(PollPeriodNs(38400, 1)), 8.166667e6, 1.0, "rounded down to ns");
  EXPECT_ABS(static_cast<double>(PollPeriodNs(38400, 8)), 22.75e6, 1.0, "rounded down to ns");
  EXPECT_EQ(RefreshNs(1), 7'000'000);
  EXPECT_EQ(RefreshNs(8), 27'000'000);
  EXPECT_EQ(RefreshNs(15), 27'000'000);
}

}  // namespace
}  // namespace haptometer::acquire::dl_rs1a
