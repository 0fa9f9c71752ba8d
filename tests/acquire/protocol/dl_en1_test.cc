// The DL-EN1's lines against the maker's manual: bytes as they stand there, never as we write them.
#include "acquire/protocol/keyence/dl_en1.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace haptometer::acquire::dl_en1 {
namespace {

using dl::Command;
using dl::ReplyKind;
using trial::SampleStatus;

std::optional<dl::Reply> Parse(std::string_view line) { return dl::ParseReply(Spelling(), line); }

TEST(DlEn1Reply, ReadsTheManualsM0) {
  const auto reply = Parse("M0,+000012345,-000056789");
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->kind, ReplyKind::kM0);
  ASSERT_EQ(reply->units, 2U);
  EXPECT_EQ(reply->values[0], (Value{12345, 0, SampleStatus::kOk}));
  EXPECT_EQ(reply->values[1], (Value{-56789, 0, SampleStatus::kOk})) << "with its sign";
  EXPECT_EQ(dl::FormatM0Reply(Spelling(), std::array{Value{12345, 0, {}}, Value{-56789, 0, {}}}),
            "M0,+000012345,-000056789\r\n");
}

TEST(DlEn1Reply, ReadsDecimalsWritesAndErrors) {
  const auto decimals = Parse("FR,01,037,+000000004");
  ASSERT_TRUE(decimals);
  EXPECT_EQ(decimals->kind, ReplyKind::kFr);
  EXPECT_EQ(decimals->unit, 1);
  EXPECT_EQ(decimals->number, 37);
  EXPECT_EQ(dl::NumberOf(decimals->data), 4);
  EXPECT_EQ(Parse("SW,01,132")->kind, ReplyKind::kSw);
  const auto error = Parse("ER,SW,014");
  ASSERT_TRUE(error);
  EXPECT_EQ(error->number, kWriteProtected);
  EXPECT_EQ(error->data, "SW");
  EXPECT_EQ(dl::FormatErrorReply(Spelling(), {"SR", kDataNumber}), "ER,SR,020\r\n");
  EXPECT_EQ(Parse("MS,04,+000012345,16,-099999998")->outputs[1], 16);
}

TEST(DlEn1Reply, RefusesWhatIsNoReply) {
  for (const std::string_view line :
       {"", "M0", "M0,", "M0,000012345", "M0,+00001234", "M0,+0000123456", "M0,+00012.345",
        "M0,+000012345,", "ER,SR,22", "ER,SR,0022", "SW,1,132", "SW,01,132,1", "AW,132",
        "FR,01,037", "MS,04", "FR,01,037,+0000000040", "M0,0000012345", "M0, 000012345"}) {
    EXPECT_FALSE(Parse(line)) << line;
  }
}

struct SpecialValue {
  std::string_view text;
  std::int32_t counts;
  SampleStatus status;
};

TEST(DlEn1Value, TheUnitsSpecialValuesAreStatusesBothWays) {
  for (const auto& [text, counts, status] :
       {SpecialValue{"+099999999", 99'999'999, SampleStatus::kOver},
        SpecialValue{"-099999999", -99'999'999, SampleStatus::kUnder},
        SpecialValue{"-099999998", -99'999'998, SampleStatus::kInvalid},
        SpecialValue{"+100000000", 100'000'000, SampleStatus::kDeviceError}}) {
    EXPECT_EQ(ParseValue(text), (Value{counts, 0, status})) << text;
    EXPECT_EQ(FormatValue({counts, 0, status}), text);
  }
  EXPECT_EQ(ParseValue("+099999998"), (Value{99'999'998, 0, SampleStatus::kOk}));
}

TEST(DlEn1Value, AnIlAmplifiersOwnAreOnlyItsOwn) {
  for (const auto& [text, counts, status] :
       {SpecialValue{"+000099999", 99'999, SampleStatus::kOver},
        SpecialValue{"-000099999", -99'999, SampleStatus::kUnder},
        SpecialValue{"-000099998", -99'998, SampleStatus::kInvalid},
        SpecialValue{"+000100000", 100'000, SampleStatus::kDeviceError}}) {
    const auto value = ParseValue(text);
    ASSERT_TRUE(value);
    EXPECT_EQ(value->status, SampleStatus::kOk) << "a GT2 measures 9.9999 mm";
    EXPECT_EQ(WithIlSpecials(*value), (Value{counts, 0, status}));
  }
  EXPECT_EQ(WithIlSpecials({99'998, 0, {}}).status, SampleStatus::kOk);
}

TEST(DlEn1Request, KnowsItsCommandsAndRefusesOthers) {
  const auto frac = dl::ParseRequest(Spelling(), "FR,01,037");
  ASSERT_TRUE(frac.request);
  EXPECT_EQ(*frac.request, (dl::Request{Command::kFr, 1, 37, {}}));
  EXPECT_EQ(dl::FormatRequest(*frac.request), "FR,01,037\r\n");
  EXPECT_FALSE(dl::ParseRequest(Spelling(), "AW,001,1").request) << "DL-RS1A only";
  EXPECT_EQ(dl::ParseRequest(Spelling(), "ZZ").refusal.number, kFormat);
}

TEST(DlEn1Tables, ErrorsAndTimes) {
  EXPECT_EQ(ErrorText(kStarting), "the unit or an amplifier is still starting");
  EXPECT_EQ(ErrorText(1), "unknown error");
  EXPECT_EQ(RefreshNs(1), 7'800'000);
  EXPECT_EQ(RefreshNs(8), 27'800'000);
  EXPECT_EQ(RefreshNs(15), 27'800'000);
}

TEST(DlEn1Tables, RefreshesOfOneToEightAmplifiers) {
  // DL-EN1 User's Manual (633GB), data processing time without calculation, in tenths of ms
  const std::array<MonotonicNs, 8> printed{78, 98, 138, 158, 198, 218, 258, 278};
  for (std::size_t i = 0; i < printed.size(); ++i)
    EXPECT_EQ(RefreshNs(i + 1), printed[i] * 100'000);
}

TEST(DlEn1Tables, TheLongestLineIsMsOfFifteenAmplifiers) {
  const std::vector<Value> values(15, Value{-56'789, 0, {}});
  const std::string line = dl::FormatMsReply(Spelling(), std::vector<int>(15, 16), values);
  EXPECT_EQ(kLongestLine, line.size() - 2);
  EXPECT_EQ(Parse(std::string_view(line).substr(0, line.size() - 2))->units, 15U);
}

TEST(DlEn1Tables, EachErrorNumberHasItsWords) {
  for (const int number : {9, 12, 14, 16, 20, 22, 31, 254, 255}) {
    EXPECT_NE(ErrorText(number), "unknown error") << number;
  }
}

TEST(DlEn1Value, SpecialValuesOfTheAmplifierAreWrittenToo) {
  for (const auto& [text, counts, status] :
       {SpecialValue{"+000099999", 0, SampleStatus::kOver},
        SpecialValue{"-000099999", 0, SampleStatus::kUnder},
        SpecialValue{"-000099998", 0, SampleStatus::kInvalid},
        SpecialValue{"+000100000", 0, SampleStatus::kDeviceError},
        SpecialValue{"-000012345", -12'345, SampleStatus::kOk}}) {
    EXPECT_EQ(FormatIlValue({counts, 0, status}), text);
  }
  EXPECT_EQ(FormatNumber(999'999'999), "+999999999");
  EXPECT_EQ(FormatNumber(-999'999'999), "-999999999");
  EXPECT_EQ(FormatNumber(0), "+000000000");
  EXPECT_DEATH((void)FormatNumber(1'000'000'000), "number = 1000000000");
  EXPECT_DEATH((void)FormatNumber(-1'000'000'000), "number = -1000000000");
  EXPECT_EQ(FormatNumber(-1), "-000000001");
}

TEST(DlEn1Port, IsAddedToABareHost) {
  EXPECT_EQ(WithPort("192.168.0.10"), "192.168.0.10:64000");
  EXPECT_EQ(WithPort("sensor.local"), "sensor.local:64000");
  EXPECT_EQ(WithPort("192.168.0.10:8501"), "192.168.0.10:8501");
  EXPECT_EQ(WithPort("::1"), "[::1]:64000");
  EXPECT_EQ(WithPort("[::1]"), "[::1]:64000");
  EXPECT_EQ(WithPort("[::1]:7"), "[::1]:7");
  EXPECT_EQ(WithPort("/dev/ttyUSB0"), "/dev/ttyUSB0");
}

}  // namespace
}  // namespace haptometer::acquire::dl_en1
