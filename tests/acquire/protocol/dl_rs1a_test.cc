// The DL-RS1A's lines against the maker's manual: bytes as they stand there, never as we write
// them.
#include "acquire/protocol/keyence/dl_rs1a.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

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
                                 {"+9.999", 9999},
                                 {"-9.999", -9999},
                                 {"+1.234", 1234}}) {
    EXPECT_EQ(ParseAnalogMv(text), mv) << text;
    EXPECT_EQ(FormatAnalogMv(mv), text);
  }
  // a current output has five characters
  for (const char* text : {"12.00", "+12.00", "1.2345", "+1.23a", "", "+1,234", "++.123", "-1.23a",
                           "+1.23", "+1.2345", "11.234", " 1.234"}) {
    EXPECT_FALSE(ParseAnalogMv(text)) << text;
  }
  EXPECT_DEATH((void)FormatAnalogMv(10'000), "mv = 10000");
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
                                      "MS",
                                      "DR",
                                      "MS,04,+00.00",
                                      "MS,x,+00.001",
                                      "MS,04,+00.001,04",
                                      "SR,00,195",
                                      "SR,0,195,1",
                                      "SR,00,19,1",
                                      "SR,00,195,12345678901",
                                      "ER,SR",
                                      "ER,SR,5",
                                      "ER,SR,222",
                                      "ER,SR,22,1",
                                      "ER,S\x01,22",
                                      "SW,00,132,1",
                                      "AW,00,132",
                                      "AW,13",
                                      "SR,00,200,\x7f",
                                      "SR,00,200,\x1f",
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

TEST(DlRs1aValue, IsWrittenWithOneToThreeDecimals) {
  EXPECT_EQ(FormatValue({99'999, 1, SampleStatus::kOk}), "+9999.9");
  EXPECT_EQ(FormatValue({0, 3, SampleStatus::kOk}), "+00.000");
  EXPECT_DEATH((void)FormatValue({1, 0, SampleStatus::kOk}), "decimals = 0");
  EXPECT_DEATH((void)FormatValue({1, 4, SampleStatus::kOk}), "decimals = 4");
  EXPECT_DEATH((void)FormatValue({100'000, 3, SampleStatus::kOk}), "counts = 100000");
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

struct CatalogueHead {
  int code;
  std::string_view name;
  int decimals;
  double reference_mm, nearest_mm, farthest_mm;
};

TEST(DlRs1aTables, HeadsHaveTheDistancesOfTheCatalogue) {
  // Keyence AS_98890_IL: reference distance and measuring range
  for (const CatalogueHead& printed :
       {CatalogueHead{1, "IL-030", 3, 30, 20, 45}, CatalogueHead{2, "IL-065", 3, 65, 55, 105},
        CatalogueHead{3, "IL-100", 3, 100, 75, 130}, CatalogueHead{4, "IL-300", 2, 300, 160, 450},
        CatalogueHead{5, "IL-600", 2, 600, 200, 1000},
        CatalogueHead{106, "IL-S025", 3, 25, 20, 30}}) {
    const Head* head = FindHead(printed.name);
    ASSERT_NE(head, nullptr) << printed.name;
    EXPECT_EQ(head, FindHead(printed.code));
    EXPECT_EQ(head->decimals, printed.decimals) << printed.name;
    EXPECT_EQ(head->reference_mm, printed.reference_mm) << printed.name;
    EXPECT_EQ(head->nearest_mm, printed.nearest_mm) << printed.name;
    EXPECT_EQ(head->farthest_mm, printed.farthest_mm) << printed.name;
  }
  // where the catalogue has no range, the name's distance alone
  for (const CatalogueHead& named :
       {CatalogueHead{107, "IL-S065", 3, 65, 0, 0}, CatalogueHead{208, "IL-S100", 3, 100, 0, 0},
        CatalogueHead{311, "IL-2000", 1, 2000, 0, 0}}) {
    const Head* head = FindHead(named.code);
    ASSERT_NE(head, nullptr) << named.name;
    EXPECT_EQ(head->name, named.name);
    EXPECT_EQ(head->decimals, named.decimals) << named.name;
    EXPECT_EQ(head->reference_mm, named.reference_mm) << named.name;
    EXPECT_EQ(head->nearest_mm, 0) << named.name;
    EXPECT_EQ(head->farthest_mm, 0) << named.name;
    EXPECT_EQ(head->linear_half_range_mm, 0) << named.name;
  }
}

TEST(DlRs1aTables, EveryCodeOfASettingHasItsValue) {
  const std::array samplings_s{0.33e-3, 1e-3, 2e-3, 5e-3};
  for (std::size_t i = 0; i < samplings_s.size(); ++i) {
    const int code = static_cast<int>(i) + 1;
    EXPECT_EQ(SamplingSeconds(code), samplings_s[i]);
    EXPECT_EQ(SamplingCode(samplings_s[i]), code);
  }
  for (int code = 0; code <= 12; ++code) {
    EXPECT_EQ(Averages(code), 1 << code);
    EXPECT_EQ(AveragingCode(1 << code), code);
  }
  EXPECT_EQ(AveragingCode(8192), std::nullopt);
  EXPECT_EQ(AveragingCode(3), std::nullopt);
  // 1, 2 and 5 in each decade from 0.1 Hz
  const std::array cutoffs_hz{0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0};
  for (std::size_t i = 0; i < cutoffs_hz.size(); ++i) {
    EXPECT_EQ(HighPassHz(static_cast<int>(i)), cutoffs_hz[i]);
  }
  EXPECT_EQ(HighPassHz(-1), std::nullopt);
  EXPECT_EQ(HoldName(-1), "");
  EXPECT_EQ(HoldName(3), "peak-to-peak");
}

TEST(DlRs1aTables, ASamplingPeriodIsKnownWithinANanosecond) {
  for (const double known_s : {0.33e-3, 1e-3, 2e-3, 5e-3}) {
    for (const double side : {-1.0, 1.0}) {
      EXPECT_TRUE(SamplingCode(known_s + side * 0.99e-9)) << known_s;
      EXPECT_FALSE(SamplingCode(known_s + side * 1.01e-9)) << known_s;
    }
  }
}

TEST(DlRs1aTables, EachErrorNumberHasItsWords) {
  for (const int number : {0, 20, 21, 22, 29, 65, 66, 67}) {
    EXPECT_NE(ErrorText(number), "unknown error") << number;
  }
  EXPECT_NE(ErrorText(65).find("identification number"), std::string_view::npos);
  EXPECT_NE(ErrorText(29).find("baud rate"), std::string_view::npos);
}

TEST(DlRs1aTables, TheLongestLineIsMsOfFifteenAmplifiers) {
  const std::vector<Value> values(15, Value{-99'999, 3, {}});
  const std::string line = dl::FormatMsReply(Spelling(), std::vector<int>(15, 16), values);
  EXPECT_EQ(kLongestLine, Line(line).size());
  const auto reply = dl::ParseReply(Spelling(), Line(line));
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->units, 15U);
  EXPECT_EQ(reply->outputs[14], 16);
}

// a reply's bytes are those of a written one; MS may have outputs of one digit
TEST(DlRs1aTables, NoExchangeIsShorterThanItsBytes) {
  for (const std::size_t units : {1U, 3U, 15U}) {
    const std::vector<Value> values(units, Value{1, 3, {}});
    const std::vector<int> outputs(units, 4);
    const std::size_t m0 = 4 + dl::FormatM0Reply(Spelling(), values).size();
    const std::size_t ms = 4 + dl::FormatMsReply(Spelling(), outputs, values).size();
    EXPECT_EQ(LeastExchangeNs(9600, units), WireTimeNs(m0, 9600));
    EXPECT_EQ(LeastExchangeNs(9600, units, Command::kMs), WireTimeNs(ms - units, 9600));
    EXPECT_EQ(PollPeriodNs(19200, units), WireTimeNs(m0, 19200) + 4'000'000);
    EXPECT_EQ(PollPeriodNs(19200, units, Command::kMs), WireTimeNs(ms, 19200) + 4'000'000);
  }
}

TEST(DlRs1aTables, RefreshesOfOneToEightAmplifiers) {
  // IB and GT-70A Editions, in ms
  const std::array<MonotonicNs, 8> printed_ms{7, 9, 13, 15, 19, 21, 25, 27};
  for (std::size_t i = 0; i < printed_ms.size(); ++i) {
    EXPECT_EQ(RefreshNs(i + 1), printed_ms[i] * 1'000'000);
  }
}

TEST(DlNumber, IsAWholeNumberWithOrWithoutASign) {
  EXPECT_EQ(dl::NumberOf("+000000004"), 4);
  EXPECT_EQ(dl::NumberOf("-12"), -12);
  EXPECT_EQ(dl::NumberOf("007"), 7);
  EXPECT_EQ(dl::NumberOf("+4"), 4);
  EXPECT_EQ(dl::NumberOf(std::string_view("12345").substr(0, 2)), 12) << "not what lies behind";
  for (const std::string_view text : {"", "+", "1x", "1.5", " 1", "99999999999"}) {
    EXPECT_FALSE(dl::NumberOf(text)) << text;
  }
}

TEST(DlRs1aReply, AnErrorAnswersTheCommandThatItNamesLast) {
  const auto error = [](std::string_view line) { return dl::ParseReply(Spelling(), line).value(); };
  EXPECT_TRUE(dl::Answers(error("ER,M0,00"), Command::kM0));
  EXPECT_TRUE(dl::Answers(error("ER,SRM0,00"), Command::kM0)) << "half a command stood before it";
  EXPECT_FALSE(dl::Answers(error("ER,M0,00"), Command::kMs));
  EXPECT_TRUE(dl::Answers(error("SW,00,132"), Command::kSw));
  EXPECT_FALSE(dl::Answers(error("SW,00,132"), Command::kSr));
  EXPECT_FALSE(dl::Answers(error("SR,00,200,M0"), Command::kM0)) << "data are no command";
}

TEST(DlRs1aReply, HasTenCharactersOfDataAtMost) {
  EXPECT_EQ(dl::ParseReply(Spelling(), "SR,00,200,1234567890")->data, "1234567890");
  EXPECT_FALSE(dl::ParseReply(Spelling(), "SR,00,200,12345678901"));
  EXPECT_EQ(dl::ParseReply(Spelling(), "SR,00,200, ~")->data, " ~") << "the ends of ASCII";
  EXPECT_EQ(dl::FormatDataReply(Command::kSr, 0, 200, "1234567890"), "SR,00,200,1234567890\r\n");
  EXPECT_DEATH((void)dl::FormatDataReply(Command::kSr, 0, 200, "12345678901"), "data = 123");
}

TEST(DlRs1aReply, NamesTheDataNumberOfAllAmplifiers) {
  const auto all = dl::ParseReply(Spelling(), "AW,132");
  ASSERT_TRUE(all);
  EXPECT_EQ(all->kind, ReplyKind::kAw);
  EXPECT_EQ(all->number, 132);
  EXPECT_EQ(all->unit, 0);
  EXPECT_EQ(dl::FormatWriteReply({Command::kAw, 3, 132, "1"}), "AW,132\r\n");
  EXPECT_EQ(dl::FormatWriteReply({Command::kSw, 3, 132, "1"}), "SW,03,132\r\n");
}

TEST(DlFields, ThirtyOneAreReadAndOneMoreIsTooMany) {
  const std::string most = "a" + std::string(30, ',');
  const Fields all(most);
  EXPECT_FALSE(all.too_many());
  EXPECT_EQ(all.size(), 31U);
  EXPECT_EQ(all.Rest().size(), 30U);
  const std::string longer = most + ",z";
  const Fields cut(longer);
  EXPECT_TRUE(cut.too_many());
  EXPECT_EQ(cut.size(), 31U);
  EXPECT_EQ(cut[0], "a");
  EXPECT_EQ(Fields("").size(), 1U);
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
