// NumPy arrays, made here byte by byte as NumPy's format says.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// `number` in `bytes` bytes, the least first
std::string Le(std::uint64_t number, std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i) text += static_cast<char>(number >> (8 * i) & 0xffU);
  return text;
}

std::string Npy(const std::string& dictionary, const std::string& data, int version = 1) {
  const std::string head = dictionary + "\n";
  return std::string("\x93NUMPY") + static_cast<char>(version) + '\0' +
         Le(head.size(), version == 1 ? 2 : 4) + head + data;
}

std::string Dictionary(const std::string& descr, const std::string& shape,
                       bool is_fortran = false) {
  return fmt::format("{{'descr': {}, 'fortran_order': {}, 'shape': {}, }}", descr,
                     is_fortran ? "True" : "False", shape);
}

// a vector of whole numbers of a type such as "<i2"
std::string Vector(const std::string& type, const std::vector<std::int64_t>& numbers) {
  const auto bytes = static_cast<std::size_t>(type[2] - '0');
  std::string data;
  for (const std::int64_t number : numbers) {
    std::string one = Le(static_cast<std::uint64_t>(number), bytes);
    if (type[0] == '>') std::ranges::reverse(one);
    data += one;
  }
  return Npy(Dictionary("'" + type + "'", fmt::format("({},)", numbers.size())), data);
}

const ImportOptions kAtRate{.rate_hz = 10.0};

Record Parsed(const std::string& bytes, const ImportOptions& options = kAtRate) {
  auto recording = ParseNpy(bytes, "f.npy", options);
  EXPECT_TRUE(recording) << recording.error().Text();
  return recording ? std::move(recording->record) : Record{};
}

std::string ErrorOf(const std::string& bytes, const ImportOptions& options = kAtRate) {
  const auto recording = ParseNpy(bytes, "f.npy", options);
  return recording ? "was read" : recording.error().Text();
}

// --- numbers -------------------------------------------------------------------------------------

TEST(Npy, WholeNumbersOfEachLengthAndOrderKeepTheirSign) {
  for (const char order : {'<', '>'}) {
    for (const int bytes : {1, 2, 4, 8}) {
      const std::string type = fmt::format("{}i{}", order, bytes);
      const std::int64_t least = std::numeric_limits<std::int64_t>::min() >> (64 - 8 * bytes);
      EXPECT_THAT(Parsed(Vector(type, {least, -2, 100, 0})).channels.at(0).values,
                  ElementsAre(static_cast<double>(least), -2, 100, 0))
          << type;
      const std::string unsigned_type = fmt::format("{}u{}", order, bytes);
      // 0.75 of the range: the highest bit is no sign
      const auto high = std::uint64_t{3} << (8 * bytes - 2);
      EXPECT_THAT(
          Parsed(Vector(unsigned_type, {static_cast<std::int64_t>(high), 7})).channels.at(0).values,
          ElementsAre(static_cast<double>(high), 7))
          << unsigned_type;
    }
  }
}

TEST(Npy, TruthIsOneByte) {
  EXPECT_THAT(Parsed(Vector("|b1", {1, 0, 1})).channels.at(0).values, ElementsAre(1, 0, 1));
  EXPECT_THAT(ErrorOf(Vector("|b2", {1, 0})), HasSubstr("holds '|b2', which is no number"));
}

TEST(Npy, OtherLengthsAreNoNumbers) {
  for (const char* type : {"<f2", "<f1", "<i3", "<u5", "<i0", "<c8"}) {
    EXPECT_THAT(ErrorOf(Vector(type, {1, 2})),
                HasSubstr(fmt::format("holds '{}', which is no number", type)));
  }
  EXPECT_THAT(ErrorOf(Vector("|S2", {1, 2})), HasSubstr("is no table of numbers"));
}

// --- heads ---------------------------------------------------------------------------------------

TEST(Npy, TheLengthOfTheHeadHasTwoBytesOrFour) {
  const std::string dictionary = Dictionary("'|u1'", "(3,)");
  for (const int version : {1, 2, 3}) {
    EXPECT_THAT(Parsed(Npy(dictionary, "\1\2\3", version)).channels.at(0).values,
                ElementsAre(1, 2, 3));
  }
  for (const int version : {0, 4}) {
    EXPECT_THAT(ErrorOf(Npy(dictionary, "\1\2\3", version)), HasSubstr("whose head is damaged"));
  }
  const std::string whole = Npy(dictionary, "");
  EXPECT_THAT(ErrorOf(whole.substr(0, whole.size() - 1)), HasSubstr("whose head is damaged"));
  EXPECT_THAT(ErrorOf(whole), HasSubstr("was cut short"));
}

TEST(Npy, EachByteOfTheNumbersIsNeeded) {
  const std::string dictionary = Dictionary("'<i2'", "(3,)");
  EXPECT_EQ(Parsed(Npy(dictionary, "aabbcc")).rows, 3U);
  EXPECT_EQ(Parsed(Npy(dictionary, "aabbccd")).rows, 3U);
  EXPECT_THAT(ErrorOf(Npy(dictionary, "aabbc")), HasSubstr("was cut short"));
  // a product that is beyond 64 bits
  EXPECT_THAT(ErrorOf(Npy(Dictionary("'<i2'", "(4294967296, 4294967296, 4294967296)"), "aa")),
              HasSubstr("was cut short"));
}

TEST(Npy, AHeadHasItsThreeKeys) {
  const std::string data = "\1\2\3";
  EXPECT_THAT(ErrorOf(Npy("{'descr': '|u1', 'shape': (3,)}", data)), HasSubstr("not understood"));
  EXPECT_THAT(ErrorOf(Npy("{'descr': '|u1', 'fortran_order': None, 'shape': (3,)}", data)),
              HasSubstr("not understood"));
  EXPECT_THAT(ErrorOf(Npy(Dictionary("'|u1'", "(3,") + "}", data)), HasSubstr("not understood"));
  EXPECT_THAT(Parsed(Npy(R"({"shape":(3,),"fortran_order":False,"descr":"|u1"})", data))
                  .channels.at(0)
                  .values,
              ElementsAre(1, 2, 3));
  // eight lengths at most, of which two at most make a table
  EXPECT_THAT(ErrorOf(Npy(Dictionary("'|u1'", "(1,1,1,1,1,1,1,3)"), data)), HasSubstr("no table"));
  EXPECT_THAT(ErrorOf(Npy(Dictionary("'|u1'", "(1,1,1,1,1,1,1,1,3)"), data)),
              HasSubstr("not understood"));
}

// --- tables --------------------------------------------------------------------------------------

// 2 x 3 numbers 10 row + column, by rows or by columns
TEST(Npy, AMatrixStandsByRowsOrByColumns) {
  const ImportOptions three{.columns = {"a", "b", "c"}, .rate_hz = 10.0};
  const ImportOptions two{.columns = {"a", "b"}, .rate_hz = 10.0};
  const std::string by_rows = Npy(Dictionary("'|i1'", "(2, 3)"), {0, 1, 2, 10, 11, 12});
  const std::string by_columns = Npy(Dictionary("'|i1'", "(2, 3)", true), {0, 10, 1, 11, 2, 12});
  for (const std::string& bytes : {by_rows, by_columns}) {
    const Record along = Parsed(bytes, three);
    ASSERT_EQ(along.channels.size(), 3U);
    EXPECT_THAT(along.channels[1].values, ElementsAre(1, 11));
    EXPECT_THAT(along.channels[2].values, ElementsAre(2, 12));
    const Record across = Parsed(bytes, two);
    ASSERT_EQ(across.channels.size(), 2U);
    EXPECT_THAT(across.channels[0].values, ElementsAre(0, 1, 2));
    EXPECT_THAT(across.channels[1].values, ElementsAre(10, 11, 12));
  }
}

// NumPy writes a name with both kinds of quotes, or with a backslash, with backslashes
TEST(Npy, ASignBehindABackslashStandsForItself) {
  const auto name_of = [](const std::string& written) {
    const std::string bytes =
        Npy(Dictionary(fmt::format("[({}, '|u1')]", written), "(2,)"), "\1\2");
    const Record record = Parsed(bytes);
    EXPECT_THAT(record.channels.at(0).values, ElementsAre(1, 2)) << written;
    return record.channels[0].name;
  };
  EXPECT_EQ(name_of(R"('it\'s "one"')"), R"(it's "one")");
  EXPECT_EQ(name_of(R"('a\\b')"), R"(a\b)");
  EXPECT_EQ(name_of(R"('a\\')"), R"(a\)") << "the quote behind two of them is the end";
  EXPECT_EQ(name_of(R"("it's")"), "it's");
  EXPECT_THAT(ErrorOf(Npy(Dictionary(R"([('a\', '|u1')])", "(2,)"), "\1\2")),
              HasSubstr("not understood"));
}

TEST(Npy, FieldsStandBehindEachOther) {
  // a title beside a name, and three bytes between fields
  const std::string descr =
      "[(('the time', 'time_s'), '<f8'), ('', '|V3'), ('displacement_mm', '>i2')]";
  std::string data;
  for (const auto& [time_s, count] : {std::pair{0.0, 258}, {0.25, -3}, {0.5, 7}}) {
    std::string big = Le(static_cast<std::uint16_t>(count), 2);
    std::ranges::reverse(big);
    data += Le(std::bit_cast<std::uint64_t>(time_s), 8) + "xyz" + big;
  }
  const Record record = Parsed(Npy(Dictionary(descr, "(3,)"), data), {});
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_THAT(record.channels[0].values, ElementsAre(258e-3, -3e-3, 7e-3));
  EXPECT_EQ(record.stretches.at(0).rate_hz, 4);
}

// --- heads that are not as NumPy writes them -----------------------------------------------------

TEST(Npy, OfAHeadEveryWordCounts) {
  const std::string rest = ", 'fortran_order': False, 'shape': (3,), }";
  EXPECT_EQ(Parsed(Npy("{'descr': '|u1'" + rest, "\1\2\3")).rows, 3U);
  for (const std::string& dictionary :
       {std::string("{"), "('descr': '|u1'" + rest, "{descr: '|u1'" + rest, std::string("{'descr"),
        "{'descr' '|u1'" + rest, "{'descr': 5" + rest, "{'descr': 'u1'" + rest,
        std::string("{'descr': '|u1', 'colour': False, 'shape': (3,), }"),
        std::string("{'descr': '|u1', 'fortran_order': False, 'shape': 3, }"),
        std::string("{'descr': '|u1', 'fortran_order': False, 'shape': (many,), }"),
        std::string("{'descr': '|u1', 'fortran_order': False, 'shape': (3,), 'colour': True}")}) {
    EXPECT_EQ(
        ErrorOf(Npy(dictionary, "\1\2\3")),
        "f.npy: is a NumPy array whose head is not understood; save an array of plain numbers "
        "(numpy.save), or export its columns as a CSV")
        << dictionary;
  }
}

TEST(Npy, AFieldIsANameAndAType) {
  const auto error_of = [](const std::string& fields) {
    return ErrorOf(Npy(Dictionary("[" + fields + "]", "(2,)"), "\1\2"));
  };
  EXPECT_EQ(error_of("('a', '|u1')"), "was read");
  EXPECT_EQ(error_of("(('the a', 'a'), '|u1')"), "was read");
  for (const char* fields :
       {"", "'a'", "(, '|u1')", "('a' '|u1')", "('a', 5)", "('a', '|u1', (3,))",
        "((the a, 'a'), '|u1')", "(('the a' 'a'), '|u1')", "(('the a', 'a', '|u1')",
        "(('the a', ), '|u1')", "('', '|V1')"}) {
    EXPECT_THAT(error_of(fields), HasSubstr("head is not understood")) << fields;
  }
}

TEST(Npy, ATypeIsAnOrderAKindAndItsBytes) {
  for (const char* type : {"<fx", "<f8x", "<M8[ns]", "|V3", "|S0", "|O"}) {
    EXPECT_THAT(
        ErrorOf(Npy(Dictionary(fmt::format("'{}'", type), "(2,)"), "\1\2")),
        HasSubstr(type == std::string("|O") ? std::string("head is not understood")
                                            : fmt::format("holds '{}', which is no number", type)));
  }
  // bytes without a name are no field; with a name, and texts beside numbers, they are no numbers
  for (const char* type : {"|V3", "|S2"}) {
    EXPECT_THAT(
        ErrorOf(Npy(Dictionary(fmt::format("[('a', '|u1'), ('b', '{}')]", type), "(1,)"), "abcd")),
        HasSubstr(fmt::format("holds '{}', which is no number", type)));
  }
  // a GiB is the most
  EXPECT_THAT(ErrorOf(Npy(Dictionary("'|S1073741824'", "(2,)"), "a")), HasSubstr("was cut short"));
  EXPECT_THAT(ErrorOf(Npy(Dictionary("'|S1073741825'", "(2,)"), "a")),
              HasSubstr("holds '|S1073741825', which is no number"));
}

TEST(Npy, FloatsHaveFourBytesOrEight) {
  for (const char order : {'<', '>'}) {
    const auto in_order = [&](std::string bytes) {
      if (order == '>') std::ranges::reverse(bytes);
      return bytes;
    };
    const std::string single = in_order(Le(std::bit_cast<std::uint32_t>(-2.5F), 4)) +
                               in_order(Le(std::bit_cast<std::uint32_t>(0.1F), 4));
    EXPECT_THAT(
        Parsed(Npy(Dictionary(fmt::format("'{}f4'", order), "(2,)"), single)).channels.at(0).values,
        ElementsAre(-2.5, static_cast<double>(0.1F)));
    const std::string twice = in_order(Le(std::bit_cast<std::uint64_t>(-2.5), 8)) +
                              in_order(Le(std::bit_cast<std::uint64_t>(0.1), 8));
    EXPECT_THAT(
        Parsed(Npy(Dictionary(fmt::format("'{}f8'", order), "(2,)"), twice)).channels.at(0).values,
        ElementsAre(-2.5, 0.1));
  }
}

TEST(Npy, AVectorOfNoNumbersHasNoRows) {
  EXPECT_THAT(ErrorOf(Npy(Dictionary("'|u1'", "(0,)"), "")), HasSubstr("holds 0 rows"));
  EXPECT_THAT(ErrorOf(Npy(Dictionary("'|u1'", "()"), "\1")), HasSubstr("is no table of numbers"));
  EXPECT_THAT(ErrorOf(Npy(Dictionary("[('a', '|u1')]", "(1, 2)"), "\1\2")),
              HasSubstr("is no table of numbers"));
}

TEST(Npy, AHeadHasTwelveBytesAtLeastAndAMiBAtMost) {
  const std::string begin = std::string("\x93NUMPY\1", 7) + '\0';
  EXPECT_THAT(ErrorOf(begin + Le(2, 2) + "{}"), HasSubstr("head is not understood"));
  EXPECT_THAT(ErrorOf(begin + Le(1, 2) + "{"), HasSubstr("head is damaged"));
  EXPECT_THAT(ErrorOf("\x93NUMPX" + Vector("|u1", {1, 2}).substr(6)), HasSubstr("head is damaged"));
  std::string dictionary = Dictionary("'|u1'", "(3,)");
  dictionary.resize((1U << 20U) - 1, ' ');
  EXPECT_EQ(Parsed(Npy(dictionary, "\1\2\3", 2)).rows, 3U);
  EXPECT_THAT(ErrorOf(Npy(dictionary + " ", "\1\2\3", 2)), HasSubstr("head is damaged"));
}

TEST(Npy, ARowHas4096FieldsAtMost) {
  std::string fields;
  for (int i = 0; i < 4096; ++i) fields += "('a', '|u1'), ";
  EXPECT_THAT(ErrorOf(Npy(Dictionary("[" + fields + "]", "(2,)"), "", 2)),
              HasSubstr("was cut short"));
  EXPECT_THAT(ErrorOf(Npy(Dictionary("[" + fields + "('a', '|u1')]", "(2,)"), "", 2)),
              HasSubstr("head is not understood"));
}

// behind fields a text of no dimension is an export's; other arrays are not looked at
TEST(Npy, AnArrayBehindATableIsPassedOver) {
  const std::string table = Npy(Dictionary("[('a', '|u1')]", "(2,)"), "\1\2");
  for (const std::string& second :
       {Npy(Dictionary("'|u1'", "()"), "\1"), Npy(Dictionary("'|S3'", "(1,)"), "abc"),
        Npy(Dictionary("'|u1'", "(2,)"), "\3\4"), std::string("abc")}) {
    EXPECT_THAT(Parsed(table + second).channels.at(0).values, ElementsAre(1, 2));
  }
  const std::string description = Npy(Dictionary("'|S3'", "()"), "abc");
  EXPECT_EQ(
      ErrorOf(table + description),
      "f.npy: its description is damaged; export the trial again with haptometer trial export");
  EXPECT_THAT(Parsed(Vector("|u1", {5, 6}) + description).channels.at(0).values, ElementsAre(5, 6));
}

}  // namespace
}  // namespace haptometer::trial
