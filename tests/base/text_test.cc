#include "base/text.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace haptometer {
namespace {

TEST(Nearest, FindsTheWordThatWasMeant) {
  const std::vector<std::string> keys{"stiffness_n_per_m", "damping_n_s_per_m", "resistance_ohm"};
  EXPECT_EQ(Nearest("stifness_n_per_m", keys), "stiffness_n_per_m");
  EXPECT_EQ(Nearest("resistence_ohms", keys), "resistance_ohm");
}

TEST(Nearest, KnowsTheDistanceOfTheTextbook) {
  // kitten -> sitting is 3 (Levenshtein): as near as half of six letters allows, and not 4
  EXPECT_EQ(Nearest("kitten", {"sitting"}), "sitting");
  EXPECT_EQ(Nearest("kitten", {"mutton's"}), "");
}

TEST(Nearest, NamesThoseOfWhichTheWordIsAPart) {
  const std::vector<std::string> options{"--all", "--moving-mass", "--case-mass", "--massive"};
  EXPECT_EQ(Nearest("--mass", options), "--moving-mass or --case-mass");
  EXPECT_EQ(Nearest("--moving", options), "--moving-mass");
  EXPECT_EQ(Nearest("load", {"load_ohm", "reload"}), "load_ohm");
  EXPECT_EQ(Nearest("m", {"rms_m"}), "rms_m");
  EXPECT_EQ(Nearest("x", {"x_um", "x_mm", "x_m", "x_nm"}), "") << "too many";
  // a letter of difference comes first
  EXPECT_EQ(Nearest("--al", {"--al-foil", "--all"}), "--all");
}

TEST(Nearest, SaysNothingWhereNothingIsNear) {
  EXPECT_EQ(Nearest("xyz", {"stiffness", "damping"}), "");
  EXPECT_EQ(Nearest("xyz", {}), "");
}

}  // namespace
// Which text is printable, and how the rest is shown. The code points are those of The Unicode
// Standard 15 (C0 and C1, 2.4; bidirectional formatting, 23.2), the byte forms those of its table
// 3-7.
namespace {

using std::string_literals::operator""s;

TEST(Printable, LeavesWhatStandsForItself) {
  for (const char* const text :
       {"", "x", "drive 50 % at 3 V, 'cone' \"b\" `c` {d}^2_e @f ~g &h <i> ]]> %s",
        "µm äöü 漢字 🙂", "C:\\new\\table.csv", "\u00a0", "\ufffd", "\U0010ffff"}) {
    EXPECT_TRUE(IsPrintable(text)) << text;
    EXPECT_EQ(Printable(text), text);
    EXPECT_EQ(PrintableLines(text), text);
  }
}

TEST(Printable, EscapesWhatDoesNot) {
  struct Case {
    std::string text;
    std::string shown;
  };
  const std::vector<Case> cases{
      {"x\n!touch", "x\\n!touch"},
      {"a\tb\rc", "a\\tb\\rc"},
      {"\x1b[31mred", "\\x1b[31mred"},
      {"nul\0nul"s, "nul\\x00nul"},
      {"\x7f", "\\u007f"},
      {"\u009b2J", "\\u009b2J"},
      {"\u0085", "\\u0085"},
      {"\u2028\u2029", "\\u2028\\u2029"},
      {"\u202egnp", "\\u202egnp"},
      {"\u2066x\u2069", "\\u2066x\\u2069"},
      {"\xef\xbf\xbe", "\\ufffe"},
      {"latin \xfc", "latin \\xfc"},
      {"\xc0\xaf", "\\xc0\\xaf"},
      {"\xed\xa0\x80", "\\xed\\xa0\\x80"},
      {"\xf4\x90\x80\x80", "\\xf4\\x90\\x80\\x80"},
      {"cut \xe2\x82", "cut \\xe2\\x82"},
  };
  for (const Case& a : cases) {
    EXPECT_FALSE(IsPrintable(a.text)) << a.shown;
    EXPECT_EQ(Printable(a.text), a.shown);
    EXPECT_TRUE(IsPrintable(Printable(a.text))) << a.shown;
    EXPECT_EQ(Printable(Printable(a.text)), a.shown) << "once is enough";
  }
}

TEST(Printable, OfSeveralLinesTheLineEndsStay) {
  EXPECT_EQ(PrintableLines("a\tb\n\x1b"
                           "c\r\n"),
            "a\tb\n\\x1bc\\r\n");
}

TEST(Printable, EveryByteAndEveryCharacterOfTwoBytesComesOutPrintable) {
  for (int first = 0; first < 256; ++first) {
    for (int second = 0; second < 256; ++second) {
      const std::string text{static_cast<char>(first), static_cast<char>(second)};
      EXPECT_TRUE(IsPrintable(Printable(text))) << first << ' ' << second;
    }
  }
}

TEST(Printable, NewTextIsRefusedInOneLine) {
  EXPECT_TRUE(CheckPrintable("--note", "fine"));
  const auto refused = CheckPrintable("--note", "x\n\x1b[2J");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::kUsage);
  EXPECT_EQ(refused.error().Text(),
            "--note: 'x\\n\\x1b[2J' holds a character that cannot be printed; write it without "
            "control characters, on one line, in UTF-8");
}

// whatever a name, a cell or a key holds that an error repeats
TEST(Printable, AnErrorIsOneLineOfPrintableText) {
  const Error error{Cause::kUsage, "a\nb.csv", "cell '\x1b]0;title\x07' is not a number",
                    "see\r\xff"};
  EXPECT_EQ(error.Text(), "a\\nb.csv: cell '\\x1b]0;title\\x07' is not a number; see\\r\\xff");
}

TEST(NumberFrom, IsTheWholeText) {
  EXPECT_EQ(NumberFrom<double>("-1.5e-3"), -1.5e-3);
  EXPECT_EQ(NumberFrom<int>("17"), 17);
  for (const char* text : {"", " 1", "1 ", "1x", "+1", "x", "1e999"}) {
    EXPECT_FALSE(NumberFrom<double>(text)) << text;
  }
  EXPECT_FALSE(NumberFrom<int>("1.5"));
  EXPECT_FALSE(NumberFrom<unsigned>("-1"));
}

}  // namespace
}  // namespace haptometer
