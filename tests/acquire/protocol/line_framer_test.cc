// Lines are cut by their bytes alone, however a transport happened to split them.
#include "acquire/protocol/line_framer.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "acquire/protocol/wire.h"

namespace haptometer::acquire {
namespace {

struct Cut {
  std::vector<std::string> lines;  // "!" for an overlong one
  std::uint64_t discarded = 0;
  std::size_t waiting = 0;
  friend bool operator==(const Cut&, const Cut&) = default;
};

void Drain(LineFramer& framer, Cut& cut) {
  for (Frame frame = framer.Next(); frame.framing != Framing::kNeedMore; frame = framer.Next()) {
    cut.lines.emplace_back(frame.framing == Framing::kValid ? frame.text : "!");
  }
}

Cut CutWhole(Delimiter delimiter, const std::string& bytes, std::size_t longest = 8) {
  LineFramer framer(delimiter, longest);
  Cut cut;
  framer.Feed(bytes);
  Drain(framer, cut);
  cut.discarded = framer.discarded_bytes();
  cut.waiting = framer.waiting_bytes();
  return cut;
}

using Lines = std::vector<std::string>;

TEST(LineFramer, EndsLinesAtTheDelimiter) {
  EXPECT_EQ(CutWhole(Delimiter::kCr, "+01.2345\r-01.2345\r+0").lines,
            (Lines{"+01.2345", "-01.2345"}));
  EXPECT_EQ(CutWhole(Delimiter::kCr, "+01.2345\r-01.2345\r+0").waiting, 2U);
  EXPECT_EQ(CutWhole(Delimiter::kLf, "a\nb\n").lines, (Lines{"a", "b"}));
  EXPECT_EQ(CutWhole(Delimiter::kCrLf, "a\r\nb\r\n").lines, (Lines{"a", "b"}));
}

TEST(LineFramer, ToleratesTheOtherHalfOfCrLf) {
  EXPECT_EQ(CutWhole(Delimiter::kCr, "a\r\nb\r\n").lines, (Lines{"a", "b"}));
  EXPECT_EQ(CutWhole(Delimiter::kLf, "a\r\nb\r\n").lines, (Lines{"a", "b"}));
  EXPECT_EQ(CutWhole(Delimiter::kCrLf, "a\nb\n").lines, (Lines{"a", "b"}));
}

TEST(LineFramer, KeepsAStrayCrInsideALine) {
  EXPECT_EQ(CutWhole(Delimiter::kCrLf, "a\rb\r\n").lines, (Lines{"a\rb"}));
}

TEST(LineFramer, SkipsEmptyLines) {
  EXPECT_EQ(CutWhole(Delimiter::kCr, "\r\r\na\r\n\n").lines, (Lines{"a"}));
  EXPECT_EQ(CutWhole(Delimiter::kLf, "\n\r\na\n\n").lines, (Lines{"a"}));
}

TEST(LineFramer, DiscardsAnOverlongLineOnceAndCountsItsBytes) {
  // 8 characters are the longest; 9 and their delimiter are 10 bytes
  EXPECT_EQ(CutWhole(Delimiter::kCr, "123456789\rok\r"), (Cut{{"!", "ok"}, 10, 0}));
  EXPECT_EQ(CutWhole(Delimiter::kCr, "12345678\rok\r"), (Cut{{"12345678", "ok"}, 0, 0}));
  EXPECT_EQ(CutWhole(Delimiter::kLf, "12345678\r\nok\n"), (Cut{{"12345678", "ok"}, 0, 0}));
  EXPECT_EQ(CutWhole(Delimiter::kLf, "123456789\r\nok\n"), (Cut{{"!", "ok"}, 11, 0}));
  EXPECT_EQ(CutWhole(Delimiter::kCr, std::string(100'000, 'x')), (Cut{{}, 100'000, 0}));
  // one character more may wait: the CR of a CR LF
  EXPECT_EQ(CutWhole(Delimiter::kCr, "123456789"), (Cut{{}, 0, 9}));
  EXPECT_EQ(CutWhole(Delimiter::kCr, "1234567890"), (Cut{{}, 10, 0}));
}

TEST(LineFramer, AnySplitGivesTheSameLines) {
  std::mt19937 engine(3);
  const std::string alphabet = "ab\r\n";
  for (int round = 0; round < 2000; ++round) {
    std::string bytes(1 + engine() % 60, ' ');
    for (char& byte : bytes) byte = alphabet[engine() % alphabet.size()];
    for (const Delimiter delimiter : {Delimiter::kCr, Delimiter::kLf, Delimiter::kCrLf}) {
      const Cut whole = CutWhole(delimiter, bytes, 4);
      LineFramer framer(delimiter, 4);
      Cut split;
      for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t size = std::min<std::size_t>(1 + engine() % 7, bytes.size() - at);
        framer.Feed(std::string_view(bytes).substr(at, size));
        Drain(framer, split);
        at += size;
      }
      split.discarded = framer.discarded_bytes();
      split.waiting = framer.waiting_bytes();
      ASSERT_EQ(split, whole) << ::testing::PrintToString(bytes);
    }
  }
}

TEST(LineFramer, SaysHowManyBytesLieBehindALine) {
  LineFramer framer(Delimiter::kCr, 8);
  framer.Feed("ab\rcd\re");
  EXPECT_EQ(framer.Next().bytes_behind, 4U);
  EXPECT_EQ(framer.Next().bytes_behind, 1U);
  EXPECT_EQ(framer.Next().framing, Framing::kNeedMore);
}

TEST(LineFramer, ResetForgetsTheUnfinishedLine) {
  LineFramer framer(Delimiter::kCr, 8);
  framer.Feed("half");
  EXPECT_EQ(framer.Next().framing, Framing::kNeedMore);
  EXPECT_EQ(framer.Reset(), 4U);
  framer.Feed("\ra\r");
  EXPECT_EQ(framer.Next().text, "a") << "behind an empty line";
  framer.Feed("x");
  EXPECT_EQ(framer.Reset(), 1U);
  framer.Feed("b\r");
  EXPECT_EQ(framer.Next().text, "b");
}

TEST(LineFramer, ResetBetweenTwoLinesKeepsTheLfOfTheFirst) {
  LineFramer framer(Delimiter::kCr, 8);
  framer.Feed("a\r");
  EXPECT_EQ(framer.Next().text, "a");
  EXPECT_EQ(framer.Reset(), 0U);
  framer.Feed("\nb\r");
  EXPECT_EQ(framer.Next().text, "b");
}

TEST(LineFramer, TheLongestLineHasACharacterAtLeast) {
  EXPECT_EQ(CutWhole(Delimiter::kLf, "a\nbc\n", 1), (Cut{{"a", "!"}, 3, 0}));
  EXPECT_DEATH(LineFramer(Delimiter::kLf, 0), "longest = 0");
}

TEST(Wire, NumbersHaveOneToNineDigits) {
  EXPECT_EQ(ParseDigits("0"), 0);
  EXPECT_EQ(ParseDigits("019"), 19);
  EXPECT_EQ(ParseDigits("999999999"), 999'999'999);
  for (const char* text : {"", "1000000000", "-1", "+1", "1 ", "1.0", "/", ":"}) {
    EXPECT_FALSE(ParseDigits(text)) << text;
  }
  EXPECT_EQ(PowerOfTen(0), 1);
  EXPECT_EQ(PowerOfTen(9), 1'000'000'000);
  EXPECT_DEATH((void)PowerOfTen(10), "exponent = 10");
  EXPECT_DEATH((void)PowerOfTen(-1), "exponent = -1");
}

TEST(Wire, ACharacterIsTenBits) {
  EXPECT_EQ(WireTimeNs(96, 9600), 100'000'000);  // 960 bits at 9600 bit/s
  EXPECT_EQ(WireTimeNs(9, 921600), 97'656);      // 90 bits: 97.65625 us
  EXPECT_EQ(WireTimeNs(1, 1), 10'000'000'000);
  EXPECT_DEATH((void)WireTimeNs(1, 0), "baud = 0");
}

}  // namespace
}  // namespace haptometer::acquire
