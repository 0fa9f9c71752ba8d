// The LK-G3001's lines against the maker's manual (p. 5-5, 5-6, 5-24): bytes as they stand there.
#include "acquire/protocol/keyence/lkg.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace haptometer::acquire::lkg {
namespace {

using trial::SampleStatus;

struct Shown {
  std::string_view text;
  Value value;
};

TEST(LkgValue, TheManualsTableBothWays) {
  for (const auto& [text, value] : {Shown{"+01.2345", {12'345, 4, SampleStatus::kOk}},
                                    Shown{"-00.0120", {-120, 4, SampleStatus::kOk}},
                                    Shown{"+1234.56", {123'456, 2, SampleStatus::kOk}},
                                    Shown{"-00001.2", {-12, 1, SampleStatus::kOk}},
                                    Shown{"XXXXXXXX", {kNoCounts, 0, SampleStatus::kInvalid}},
                                    Shown{"+FFFFFFF", {kNoCounts, 0, SampleStatus::kOver}},
                                    Shown{"-FFFFFFF", {kNoCounts, 0, SampleStatus::kUnder}}}) {
    EXPECT_EQ(ParseValue(text), value) << text;
    EXPECT_EQ(FormatValue(value), text);
  }
  // the point may be absent; the libraries of the maker know a waiting value
  EXPECT_EQ(ParseValue("+0001234"), (Value{1234, 0, SampleStatus::kOk}));
  EXPECT_EQ(FormatValue({-1234, 0, SampleStatus::kOk}), "-0001234");
  EXPECT_EQ(ParseValue("--------")->status, SampleStatus::kInvalid);
}

TEST(LkgValue, RefusesOtherForms) {
  for (const std::string_view text :
       {"", "01.23456", "+01.234", "+01.23456", "+.123456", "+123456.", "+01,2345", "+FFFFFFX",
        "XFFFFFFF", "XXXXXXX", "+1.2.345", "+ 1.2345", "++1.2345", "FFFFFFFF"}) {
    EXPECT_FALSE(ParseValue(text)) << text;
  }
}

TEST(LkgReply, ReadsWhatTheControllerSends) {
  const auto one = ParseReply("M1,+01.2345");
  ASSERT_TRUE(one);
  EXPECT_EQ(one->command, Command::kM1);
  EXPECT_EQ(one->outs, 1U);
  EXPECT_EQ(one->values[0].counts, 12'345);
  const auto both = ParseReply("M0,+01.2345,XXXXXXXX");
  ASSERT_TRUE(both);
  EXPECT_EQ(both->outs, 2U);
  EXPECT_EQ(both->values[1].status, SampleStatus::kInvalid);
  EXPECT_EQ(ParseReply("Q0")->command, Command::kQ0);
  EXPECT_EQ(ParseReply("G2,+01.2345")->kind, ReplyKind::kOutput);
  const auto error = ParseReply("ER,M1,01");
  ASSERT_TRUE(error);
  EXPECT_EQ(error->error, kStatus);
  EXPECT_TRUE(Answers(*error, Command::kM1));
  EXPECT_FALSE(Answers(*error, Command::kM2));
  EXPECT_EQ(FormatErrorReply("M1", kStatus), "ER,M1,01\r");
  EXPECT_EQ(FormatReply(Command::kM1, std::array{Value{12'345, 4, {}}}), "M1,+01.2345\r");
}

TEST(LkgReply, RefusesWhatIsNoReply) {
  for (const std::string_view line :
       {"", "M1", "M1,", "M1,+01.2345,+01.2345", "M0,+01.2345", "M3,+01.2345", "G3,+01.2345",
        "Q0,1", "ER,M1", "ER,M1,1", "ER,M1,001", "ER,M1,01,1", "ER,M1,0x", "G1",
        "G1,+01.2345,+01.2345", "G1,01.23456", "M1,+01.2345M1,+01.2345"}) {
    EXPECT_FALSE(ParseReply(line)) << line;
  }
}

TEST(LkgReply, AnErrorAnswersTheCommandThatItNamesLast) {
  const auto error = [](std::string_view line) { return ParseReply(line).value(); };
  EXPECT_TRUE(Answers(error("ER,SM1,00"), Command::kM1)) << "half a command stood before it";
  EXPECT_TRUE(Answers(error("ER,m1,00"), Command::kM1));
  EXPECT_FALSE(Answers(error("ER,SM1,00"), Command::kM2));
  EXPECT_FALSE(Answers(error("ER,1,00"), Command::kM1)) << "shorter than a command";
  EXPECT_FALSE(Answers(error("G1,+01.2345"), Command::kM1)) << "asked by nobody";
}

TEST(LkgTables, TheLongestLineHasTwoValues) {
  const std::array values{Value{-12'345, 4, {}}, Value{12'345, 4, {}}};
  EXPECT_EQ(kLongestLine, FormatReply(Command::kM0, values).size() - 1);
}

TEST(LkgTables, EachCommandHasItsValuesAndEachErrorItsWords) {
  EXPECT_EQ(ValuesOf(Command::kM0), 2U);
  EXPECT_EQ(ValuesOf(Command::kM1), 1U);
  EXPECT_EQ(ValuesOf(Command::kM2), 1U);
  EXPECT_EQ(ValuesOf(Command::kQ0), 0U);
  EXPECT_EQ(ValuesOf(Command::kR0), 0U);
  for (const int number : {0, 1, 20, 21, 22, 88, 99}) {
    EXPECT_NE(ErrorText(number), "unknown error") << number;
  }
  EXPECT_EQ(ErrorText(2), "unknown error");
}

TEST(LkgValue, EveryPlaceOfThePointSurvivesTheWire) {
  for (int decimals = 0; decimals <= 5; ++decimals) {
    const std::int32_t most = decimals == 0 ? 9'999'999 : 999'999;
    for (const std::int32_t counts : {-most, -1, 0, 7, most}) {
      const Value value{counts, decimals, SampleStatus::kOk};
      EXPECT_EQ(FormatValue(value).size(), 8U);
      EXPECT_EQ(ParseValue(FormatValue(value)), value) << FormatValue(value);
    }
  }
}

TEST(LkgValue, HasNoMoreDigitsThanTheDisplay) {
  EXPECT_EQ(FormatValue({0, 4, SampleStatus::kOk}), "+00.0000") << "nought has a plus";
  EXPECT_EQ(FormatValue({-1, 5, SampleStatus::kOk}), "-0.00001");
  EXPECT_DEATH((void)FormatValue({1'000'000, 1, SampleStatus::kOk}), "counts = 1000000");
  EXPECT_DEATH((void)FormatValue({10'000'000, 0, SampleStatus::kOk}), "counts = 10000000");
  EXPECT_DEATH((void)FormatValue({1, -1, SampleStatus::kOk}), "decimals = -1");
  EXPECT_DEATH((void)FormatValue({1, 6, SampleStatus::kOk}), "decimals = 6");
}

TEST(LkgRequest, IsUnderstoodInEitherCase) {
  EXPECT_EQ(FormatRequest(Command::kM1), "M1\r");
  EXPECT_EQ(ParseRequest("M1"), Command::kM1);
  EXPECT_EQ(ParseRequest("q0"), Command::kQ0);
  EXPECT_EQ(ParseRequest("M1,"), std::nullopt);
  EXPECT_EQ(ParseRequest(""), std::nullopt);
}

}  // namespace
}  // namespace haptometer::acquire::lkg
