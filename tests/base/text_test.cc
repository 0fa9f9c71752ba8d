#include "base/text.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
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
  // neither dashes alone nor nothing is a part of a name
  EXPECT_EQ(Nearest("--", {"_private"}), "");
  EXPECT_EQ(Nearest("", {"_private", "x_"}), "");
  // the name itself is no part, and one that begins with the word is not meant without a mark
  EXPECT_EQ(Nearest("ab", {"abcdef", "cdefab", "-ab-"}), "-ab-");
  // a letter of difference comes first
  EXPECT_EQ(Nearest("--al", {"--al-foil", "--all"}), "--all");
}

TEST(Nearest, NamesUpToThreeOfWhichTheWordIsAPart) {
  EXPECT_EQ(Nearest("x", {"x_um", "x_mm", "x_m"}), "x_um or x_mm or x_m");
}

// half of four letters are two, and of five two as well
TEST(Nearest, LetsHalfOfTheLettersDiffer) {
  EXPECT_EQ(Nearest("abcd", {"abxy"}), "abxy");
  EXPECT_EQ(Nearest("abcd", {"axyz"}), "");
  EXPECT_EQ(Nearest("abcde", {"abcxy"}), "abcxy");
  EXPECT_EQ(Nearest("abcde", {"abxyz"}), "");
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

// the ends of each row of table 3-7, and their neighbours
TEST(Utf8CharacterBytes, HasTheBordersOfTheStandard) {
  const std::vector<std::pair<std::size_t, std::vector<std::string>>> cases{
      {1, {"\0"s, "\x7f", "a\x80"}},
      {2, {"\xc2\x80", "\xdf\xbf", "\xc3\xbf\x80"}},
      {3,
       {"\xe0\xa0\x80", "\xe0\xbf\xbf", "\xe1\x80\x80", "\xec\xbf\xbf", "\xed\x80\x80",
        "\xed\x9f\xbf", "\xee\x80\x80", "\xef\xbf\xbf"}},
      {4,
       {"\xf0\x90\x80\x80", "\xf0\xbf\xbf\xbf", "\xf1\x80\x80\x80", "\xf3\xbf\xbf\xbf",
        "\xf4\x80\x80\x80", "\xf4\x8f\xbf\xbf"}},
      {0,
       {"",
        "\x80",
        "\xbf",
        "\xc1\xbf",
        "\xc2",
        "\xc2\x7f",
        "\xc2\xc0",
        "\xe0\x9f\xbf",
        "\xe1\x80",
        "\xe1\x80\x7f",
        "\xe1\x80\xc0",
        "\xe1\x7f\x80",
        "\xed\xa0\x80",
        "\xf0\x8f\xbf\xbf",
        "\xf1\x80\x80",
        "\xf1\x80\x80\x7f",
        "\xf1\x80\x80\xc0",
        "\xf4\x90\x80\x80",
        "\xf5\x80\x80\x80",
        "\xff"}}};
  for (const auto& [bytes, texts] : cases) {
    for (const std::string& text : texts) {
      EXPECT_EQ(Utf8CharacterBytes(text), bytes) << Printable(text);
    }
  }
}

// the neighbours of each range that is not printable
TEST(Printable, HasTheBordersThatTheHeaderStates) {
  for (const char* const text :
       {" ", "~", "\u00a0", "\u2027", "\u202f", "\u2065", "\u206a", "\ufffd", "\U00010000"}) {
    EXPECT_TRUE(IsPrintable(text)) << text;
  }
  for (const char* const text : {"\x1f", "\x7f", "\u0080", "\u009f", "\u2028", "\u202a", "\u202e",
                                 "\u2066", "\u2069", "\xef\xbf\xbe", "\xef\xbf\xbf"}) {
    EXPECT_FALSE(IsPrintable(text)) << Printable(text);
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
