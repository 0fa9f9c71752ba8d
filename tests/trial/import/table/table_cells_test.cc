// Cells of tables: how texts are encoded, split and read as numbers, times of day, dates and units.
#include "trial/import/table/table_cells.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// --- units ---------------------------------------------------------------------------------------

struct Unit {
  const char* printed;
  const char* si_unit;
  double factor;
};

// the factors of the SI prefixes
constexpr Unit kUnits[]{{"s", "s", 1},
                        {"Second", "s", 1},
                        {"ms", "s", 1e-3},
                        {"msec", "s", 1e-3},
                        {"us", "s", 1e-6},
                        {"\u00b5s", "s", 1e-6},
                        {"\u03bcs", "s", 1e-6},
                        {"ns", "s", 1e-9},
                        {"ps", "s", 1e-12},
                        {"m", "m", 1},
                        {"cm", "m", 1e-2},
                        {"mm", "m", 1e-3},
                        {"um", "m", 1e-6},
                        {"\u00b5m", "m", 1e-6},
                        {"microns", "m", 1e-6},
                        {"nm", "m", 1e-9},
                        {"nanometers", "m", 1e-9},
                        {"V", "V", 1},
                        {"Volts", "V", 1},
                        {"mV", "V", 1e-3},
                        {"uV", "V", 1e-6},
                        {"\u03bcV", "V", 1e-6},
                        {"kV", "V", 1e3},
                        {"A", "A", 1},
                        {"Amps", "A", 1},
                        {"mA", "A", 1e-3},
                        {"uA", "A", 1e-6},
                        {"\u00b5A", "A", 1e-6},
                        // an inch is 25.4 mm, and a mil a thousandth of it
                        {"inch", "m", 25.4e-3},
                        {"Inches", "m", 25.4e-3},
                        {"mil", "m", 25.4e-6},
                        {"mils", "m", 25.4e-6},
                        {"thou", "m", 25.4e-6}};

TEST(Units, EachHasTheFactorOfItsPrefix) {
  for (const Unit& unit : kUnits) {
    const auto found = FindUnit(unit.printed);
    ASSERT_TRUE(found) << unit.printed;
    EXPECT_EQ(found->si_unit, unit.si_unit) << unit.printed;
    EXPECT_EQ(found->factor, unit.factor) << unit.printed;
  }
}

TEST(Units, MegaTorqueAndOtherWordsAreNone) {
  for (const char* word :
       {"MV", "Mm", "Ms", "MA", "Nm", "", " ", "V s", "mm ", "Hz", "volt2", "g"}) {
    EXPECT_FALSE(FindUnit(word)) << word;
  }
  // a word of more letters that begins with a capital is no mega
  EXPECT_FALSE(FindUnit("Mm/s"));
  EXPECT_EQ(FindUnit("MSEC").value().factor, 1e-3);
}

TEST(Units, EachHasTheRoleOfItsQuantity) {
  EXPECT_EQ(RoleOfUnit("m"), ChannelRole::kDisplacement);
  EXPECT_EQ(RoleOfUnit("V"), ChannelRole::kVoltage);
  EXPECT_EQ(RoleOfUnit("A"), ChannelRole::kCurrent);
  EXPECT_EQ(RoleOfUnit("s"), ChannelRole::kOther);
  EXPECT_EQ(RoleOfUnit(""), ChannelRole::kOther);
}

// --- encodings -----------------------------------------------------------------------------------

std::string Utf8Of(const std::string& raw) {
  std::string storage;
  return std::string(Utf8Text(raw, &storage));
}

// `units` as UTF-16 behind a byte-order mark
std::string Utf16(std::u16string_view units, bool is_big_endian) {
  std::string raw = is_big_endian ? "\xfe\xff" : "\xff\xfe";
  for (const char16_t unit : units) {
    const char upper = static_cast<char>(unit >> 8U);
    const char lower = static_cast<char>(unit & 0xffU);
    raw += is_big_endian ? upper : lower;
    raw += is_big_endian ? lower : upper;
  }
  return raw;
}

// the encoded forms by the table of Unicode's chapter 3.9
TEST(Encodings, Utf16BecomesUtf8AtEachLengthOfACharacter) {
  for (const bool is_big_endian : {false, true}) {
    EXPECT_EQ(Utf8Of(Utf16(u"a\u007f\u0080\u07ff\u0800\uffee", is_big_endian)),
              "a\x7f\xc2\x80\xdf\xbf\xe0\xa0\x80\xef\xbf\xae");
  }
}

TEST(Encodings, SurrogatesThatBelongTogetherAreOneCharacter) {
  for (const bool is_big_endian : {false, true}) {
    // U+10000, U+1D6FC, U+10FFFF, and one behind a character above the surrogates
    const std::u16string pairs{0xd800, 0xdc00, 'a',    0xd835, 0xdefc, 'b',
                               0xdbff, 0xdfff, 0xff11, 0xd835, 0xdefc};
    EXPECT_EQ(Utf8Of(Utf16(pairs, is_big_endian)),
              "\xf0\x90\x80\x80"
              "a\xf0\x9d\x9b\xbc"
              "b\xf4\x8f\xbf\xbf\xef\xbc\x91\xf0\x9d\x9b\xbc");
  }
}

TEST(Encodings, AnUnpairedSurrogateIsReplaced) {
  const std::string kReplaced = "\xef\xbf\xbd";
  for (const bool is_big_endian : {false, true}) {
    // in front of a character above the surrogates, of another high one, alone, at the end
    const std::u16string text{'a', 0xd835, 0xff11, 0xd800, 0xd835, 0xdefc, 0xdefc, 'b', 0xdbff};
    EXPECT_EQ(Utf8Of(Utf16(text, is_big_endian)), "a" + kReplaced + "\xef\xbc\x91" + kReplaced +
                                                      "\xf0\x9d\x9b\xbc" + kReplaced + "b" +
                                                      kReplaced);
    // a low one behind characters that are no high one, those next to the surrogates included
    const std::u16string low{'a', 0xdc00, 0xd7ff, 0xdc00, 0xe000, 0xdfff, 0xdfff, 0xdc00};
    EXPECT_EQ(Utf8Of(Utf16(low, is_big_endian)), "a" + kReplaced + "\xed\x9f\xbf" + kReplaced +
                                                     "\xee\x80\x80" + kReplaced + kReplaced +
                                                     kReplaced);
  }
}

TEST(Encodings, Utf16WithoutAMarkNeedsThreeLatinCharactersInFour) {
  const auto text = [](std::size_t characters, std::size_t latin) {
    std::string raw;
    for (std::size_t i = 0; i < characters; ++i) {
      raw += 'a';
      raw += i < latin ? '\0' : 'b';
    }
    return raw;
  };
  EXPECT_EQ(Utf16WithoutMark(text(4, 3)), ByteOrder::kLittleEndian);
  EXPECT_EQ(Utf16WithoutMark(text(4, 2)), std::nullopt);
  EXPECT_EQ(Utf16WithoutMark(text(32, 24)), ByteOrder::kLittleEndian);
  EXPECT_EQ(Utf16WithoutMark(text(32, 23)), std::nullopt);
  // 64 bytes are looked at
  EXPECT_EQ(Utf16WithoutMark(text(32, 24) + std::string(8, '\0')), ByteOrder::kLittleEndian);
  EXPECT_EQ(Utf16WithoutMark(text(31, 31) + std::string(2, '\0')), std::nullopt);
  // eight at least
  EXPECT_EQ(Utf16WithoutMark(text(3, 3) + "a"), std::nullopt);
  const std::string swapped = '\0' + text(31, 31) + 'a';
  EXPECT_EQ(Utf16WithoutMark(swapped), ByteOrder::kBigEndian);
  EXPECT_EQ(Utf8Of(text(5, 5)), "aaaaa");
  EXPECT_EQ(Utf8Of('\0' + text(4, 4) + 'a'), "aaaaa");
}

// characters of the bytes 0x80 to 0x9f by Microsoft's table of code page 1252
TEST(Encodings, WhatIsNoUtf8IsWindows1252) {
  EXPECT_EQ(Utf8Of("\x80 \x8e \x92 \x9f \xa0 \xb5 \xff"),
            "\xe2\x82\xac \xc5\xbd \xe2\x80\x99 \xc5\xb8 \xc2\xa0 \xc2\xb5 \xc3\xbf");
  EXPECT_EQ(Utf8Of("\x81 \x9d"), "\xef\xbf\xbd \xef\xbf\xbd");
  EXPECT_EQ(Utf8Of("\xc2\xb5s"), "\xc2\xb5s");
}

TEST(Encodings, NulBytesAndLineEndsOfAnotherKindAreMended) {
  EXPECT_EQ(Utf8Of(std::string("a,b\n1\0,2\n", 9)), "a,b\n1,2\n");
  EXPECT_EQ(Utf8Of("a,b\r1,2\r"), "a,b\n1,2\n");
  EXPECT_EQ(Utf8Of("a,b\r\n1,2\r\n"), "a,b\r\n1,2\r\n");
  EXPECT_EQ(Utf8Of("\xef\xbb\xbf"
                   "a"),
            "a");
}

// --- numbers -------------------------------------------------------------------------------------

TEST(Numbers, AreReadToTheEndOfTheText) {
  EXPECT_EQ(ReadNumber("-1.5e3"), -1500);
  EXPECT_EQ(ReadNumber("+2"), 2);
  for (const char* text : {"", "1.5 ", "1,5", "1x", "+-1", "++1", "-", "e3"}) {
    EXPECT_FALSE(ReadNumber(text)) << text;
  }
  EXPECT_EQ(ReadNumberWithComma("-1,5"), -1.5);
  EXPECT_EQ(ReadNumberWithComma("2.25"), 2.25);
  EXPECT_FALSE(ReadNumberWithComma("1,000.5"));
}

TEST(Numbers, MayGroupThousandsByGroupsOfThreeDigits) {
  for (const char* text : {"1,234", "12,345", "123,456", "-1,234", "+999,000", "1,234,567"}) {
    EXPECT_TRUE(MayGroupThousands(text, ',')) << text;
  }
  for (const char* text : {"", "-", "1234", "0,123", "-0,123", "1234,567", "1,23", "1,2345", ",123",
                           "1,234,56", "1,,234", "1,234e3", "1.234", "1,234.5", "a,234"}) {
    EXPECT_FALSE(MayGroupThousands(text, ',')) << text;
  }
  EXPECT_TRUE(MayGroupThousands("1.234", '.'));
  EXPECT_FALSE(MayGroupThousands("1,234", '.'));
}

TEST(Numbers, WordsOfTwelveCharactersAtMostMayStandForThem) {
  EXPECT_EQ(ReadNoNumber(std::string(12, '*')), SampleStatus::kClipped);
  EXPECT_EQ(ReadNoNumber(std::string(13, '*')), std::nullopt);
  EXPECT_EQ(ReadNoNumber(std::string(12, '-')), SampleStatus::kInvalid);
  EXPECT_EQ(ReadNoNumber(std::string(13, '-')), std::nullopt);
  EXPECT_EQ(ReadNoNumber("\xe2\x88\x9e"), SampleStatus::kOver);
  EXPECT_EQ(ReadNoNumber("-\xe2\x88\x9e"), SampleStatus::kUnder);
  EXPECT_EQ(ReadNoNumber("+OL"), SampleStatus::kOver);
  EXPECT_EQ(ReadNoNumber("Underflow"), SampleStatus::kUnder);
  EXPECT_EQ(ReadNoNumber("UNDER"), SampleStatus::kUnder);
  for (const char* text : {".", ",", "12", "over range", "--over", "*-", "-.5", "n/a?"}) {
    EXPECT_EQ(ReadNoNumber(text), std::nullopt) << text;
  }
}

// --- times of day and dates ----------------------------------------------------------------------

TEST(TimesOfDay, CountHoursMinutesAndSeconds) {
  EXPECT_EQ(ReadClock("00:00:00"), 0);
  EXPECT_EQ(ReadClock("01:02:03"), 3723);
  EXPECT_EQ(ReadClock("23:59:59.5"), 86'399.5);
  EXPECT_EQ(ReadClock("23:59:59,5"), 86'399.5);
  EXPECT_EQ(ReadClock(" 5/7/2021  12:00:47.25 "), 43'247.25);
  EXPECT_EQ(ReadClock("2021-07-05T12:00:47Z"), 43'247);
  // a second that is put in
  EXPECT_EQ(ReadClock("23:59:60.75"), 86'400.75);
  for (const char* text : {"", "12", "12:00", "12:00:00:00", "12:00:61", "12:61:00", "61:00:00",
                           "-1:00:00", "a:00:00", "12::00", "12:00:"}) {
    EXPECT_FALSE(ReadClock(text)) << text;
  }
}

TEST(TimesOfDay, ADateHasThreeNumbersAndOneYear) {
  for (const char* text :
       {"2024-05-06", "2024/5/6", "6.5.2024", "31.12.24", "5/7/21", "5/7/2021"}) {
    EXPECT_TRUE(IsDate(text)) << text;
  }
  for (const char* text :
       {"", "2024", "2024-05", "2024-05/06", "abcd-05-06", "2024-ab-06", "24-05-ab", "20245-05-6",
        "2024-050-06", "6-5-20245", "2024-05-2024", "2024-05-200", "2024-05-06-07", "-05-06",
        "2024--06", "2024-05-", "12:00:00"}) {
    EXPECT_FALSE(IsDate(text)) << text;
  }
}

// --- cells ---------------------------------------------------------------------------------------

TEST(CellsOfALine, AreSeparatedOutsideOfQuotes) {
  EXPECT_THAT(SplitCells("a,\"b, c\" ,d", ','), ElementsAre("a", "b, c", "d"));
  EXPECT_THAT(SplitCells("\"a,b\",,\"c\"", ','), ElementsAre("a,b", "", "c"));
  // a quote without its like, and one within a cell, are characters as others
  EXPECT_THAT(SplitCells("\"a,b", ','), ElementsAre("\"a", "b"));
  EXPECT_THAT(SplitCells("3.5\",b\"", ','), ElementsAre("3.5\"", "b\""));
  EXPECT_THAT(SplitCells("\t1\t", '\t'), ElementsAre("", "1", ""));
}

TEST(CellsOfALine, BlanksSeparateThemOutsideOfBrackets) {
  EXPECT_THAT(SplitCells(" Time (s)  CH 1 ", ' '), ElementsAre("Time (s)", "CH", "1"));
  EXPECT_THAT(SplitCells("v [m / s] 2", ' '), ElementsAre("v [m / s]", "2"));
  EXPECT_THAT(SplitCells("\"laser head\"\t 1", ' '), ElementsAre("laser head", "1"));
}

TEST(CellsOfALine, TheFirstSeparatorOfSemicolonTabAndCommaCounts) {
  EXPECT_EQ(CellsOf("1,5;2,5").separator, ';');
  EXPECT_EQ(CellsOf("1,5\t2;5").separator, ';');
  EXPECT_EQ(CellsOf("1,5\t2,5").separator, '\t');
  EXPECT_EQ(CellsOf("\"a;b\",c").separator, ',');
  EXPECT_EQ(CellsOf("1 2").separator, ' ');
  EXPECT_EQ(CellsOf("1, 2").separator, ',');
  EXPECT_EQ(CellsOf("a b").separator, ',');
  EXPECT_EQ(NameOfSeparator(';'), "semicolons");
  EXPECT_EQ(NameOfSeparator('\t'), "tabs");
  EXPECT_EQ(NameOfSeparator(' '), "blanks");
  EXPECT_EQ(NameOfSeparator(','), "commas");
}

TEST(CellsOfALine, AreNumbersIfOneIsAndNoneIsAWord) {
  using Cells = std::vector<std::string_view>;
  for (const Cells& cells : {Cells{"1", "nan"},
                             {"12:00:00", "1"},
                             {"2024-05-06", "12:00:00", "1"},
                             {"", "1,5"},
                             {"12:00:00", "OVER"}}) {
    EXPECT_TRUE(IsNumbers(cells)) << cells[0];
  }
  for (const Cells& cells : {Cells{"----", ""},
                             {"1", "12:00:00"},
                             {"2024-05-06", "1"},
                             {"2024-05-06"},
                             {"1", "2024-05-06"},
                             {"1", "a"}}) {
    EXPECT_FALSE(IsNumbers(cells)) << cells[0];
  }
}

// --- bounds --------------------------------------------------------------------------------------

// the refusals just above stand in CsvBounds
TEST(TableBounds, TheLargestLineIsTaken) {
  EXPECT_TRUE(CheckLines(std::string(kMostLineBytes, 'a') + "\n1\n", "f"));
  EXPECT_FALSE(CheckLines("1\n" + std::string(kMostLineBytes + 1, 'a'), "f"));
  for (const char separator : {',', ';', '\t'}) {
    EXPECT_TRUE(CheckLines(std::string(kMostColumns - 1, separator), "f")) << separator;
    EXPECT_FALSE(CheckLines(std::string(kMostColumns, separator), "f")) << separator;
  }
  std::string comments;
  for (std::size_t k = 0; k < kMostHeaderLines; ++k) comments += "#\n";
  EXPECT_TRUE(CheckLines(comments + "1\n", "f"));
  const auto refused = CheckLines(comments + "1\n#", "f");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(), HasSubstr("f: line 100002: "));
}

}  // namespace
}  // namespace haptometer::trial
