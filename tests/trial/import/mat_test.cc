// MATLAB files of version 5, made here element by element as The MathWorks' MAT-File Format says.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/residual.h"
#include "trial/import/mat_variables.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// `number` in `bytes` bytes, the least first
std::string Le(std::uint64_t number, std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i) text += static_cast<char>(number >> (8 * i) & 0xffU);
  return text;
}

std::string Element(std::uint32_t type, const std::string& data) {
  return Le(type, 4) + Le(data.size(), 4) + data + std::string((8 - data.size() % 8) % 8, '\0');
}

// one of 1 to 4 bytes, which stand in the tag
std::string SmallElement(std::uint32_t type, const std::string& data) {
  return Le(data.size() << 16U | type, 4) + data + std::string(4 - data.size(), '\0');
}

std::string File(const std::string& elements) {
  return "MATLAB 5.0 MAT-file" + std::string(105, ' ') + std::string("\0\1IM", 4) + elements;
}

constexpr std::uint32_t kComplex = 0x800;

// flags, sides and name of a matrix
std::string Head(std::uint32_t matrix_class, const std::vector<std::uint32_t>& sides,
                 const std::string& name) {
  std::string lengths;
  for (const std::uint32_t side : sides) lengths += Le(side, 4);
  return Element(6, Le(matrix_class, 4) + Le(0, 4)) + Element(5, lengths) + Element(1, name);
}

// classes and types by their numbers in the file
constexpr std::uint32_t kChar = 4, kDouble = 6, kInt16 = 10;
constexpr std::uint32_t kMatrix = 14, kDoubles = 9;

std::string Vector(const std::string& name, const std::vector<double>& numbers) {
  std::string data;
  for (const double number : numbers) data += Le(std::bit_cast<std::uint64_t>(number), 8);
  return Element(kMatrix, Head(kDouble, {static_cast<std::uint32_t>(numbers.size()), 1}, name) +
                              Element(kDoubles, data));
}

MatVariables Read(const std::string& bytes) {
  MatVariables read = ReadMatVariables(bytes);
  EXPECT_TRUE(read.is_whole);
  return read;
}

// --- variables -----------------------------------------------------------------------------------

TEST(MatVariables, NumbersOfEachTypeKeepTheirSign) {
  struct Stored {
    std::uint32_t type;
    std::size_t bytes;
    std::uint64_t bits;
    double number;
  };
  for (const Stored& stored : {Stored{1, 1, 0x80, -128},
                               {2, 1, 0x80, 128},
                               {3, 2, 0xfffe, -2},
                               {4, 2, 0xfffe, 65534},
                               {5, 4, 0xfffffffe, -2},
                               {6, 4, 0xfffffffe, 4294967294},
                               {7, 4, 0xc0200000, -2.5},
                               {9, 8, 0xc004000000000000, -2.5},
                               {12, 8, ~std::uint64_t{1}, -2},
                               {13, 8, std::uint64_t{3} << 62, 0x3p62}}) {
    // a double may be stored in any type
    const std::string data = Le(stored.bits, stored.bytes) + std::string(stored.bytes, '\0');
    const std::string bytes =
        File(Element(kMatrix, Head(kDouble, {2, 1}, "x") + Element(stored.type, data)));
    const MatVariables read = Read(bytes);
    ASSERT_EQ(read.variables.size(), 1U) << stored.type;
    EXPECT_THAT(read.variables[0].Numbers(), ElementsAre(stored.number, 0)) << stored.type;
  }
}

TEST(MatVariables, AShortElementStandsInItsTag) {
  const std::string bytes = File(
      Element(kMatrix, Element(6, Le(kInt16, 4) + Le(0, 4)) + Element(5, Le(1, 4) + Le(2, 4)) +
                           SmallElement(1, "abc") + SmallElement(3, Le(0xffff, 2) + Le(7, 2))));
  const MatVariables read = Read(bytes);
  ASSERT_EQ(read.variables.size(), 1U);
  EXPECT_EQ(read.variables[0].name, "abc");
  EXPECT_EQ(read.variables[0].rows, 1U);
  EXPECT_EQ(read.variables[0].columns, 2U);
  EXPECT_TRUE(read.variables[0].is_whole());
  EXPECT_THAT(read.variables[0].Numbers(), ElementsAre(-1, 7));
}

TEST(MatVariables, ATextHasOneCharacterANumber) {
  const auto text = [](std::uint32_t type, std::uint32_t length, const std::string& data) {
    const std::string bytes =
        File(Element(kMatrix, Head(kChar, {1, length}, "t") + Element(type, data)));
    const MatVariables read = ReadMatVariables(bytes);
    return read.is_whole ? read.variables.at(0).Text().value_or("none") : "damaged";
  };
  EXPECT_EQ(text(4, 3, Le('a', 2) + Le(0x7f, 2) + Le(0x80, 2)), "a\x7f?");
  EXPECT_EQ(text(4, 2, Le('a', 2) + Le(0x161, 2)), "a?");
  EXPECT_EQ(text(16, 2, "a\xc3\xa4"), "a\xc3\xa4");
  EXPECT_EQ(text(16, 4, "a\xc3\xa4"), "damaged") << "fewer bytes than characters";
  EXPECT_EQ(text(1, 3, "abc"), "abc");
  // UTF-16 and UTF-32 are not read, and nothing of the file is damaged
  EXPECT_EQ(text(17, 2, Le('a', 2) + Le('b', 2)), "none");
  EXPECT_EQ(text(18, 2, Le('a', 4) + Le('b', 4)), "none");
  EXPECT_EQ(text(17, 4, "abcd"), "none") << "as many bytes as characters";
}

// types that the format reserves, and those of texts and elements
TEST(MatVariables, NumbersOfOtherTypesComeWithoutData) {
  for (const std::uint32_t type : {0U, 8U, 10U, 11U, 14U, 16U, 17U, 18U, 19U}) {
    for (const std::size_t bytes : {2U, 4U, 8U, 16U}) {
      const std::string odd =
          Element(kMatrix, Head(kDouble, {2, 1}, "odd") + Element(type, std::string(bytes, '\1')));
      const std::string file = File(odd + Vector("x", {1, 2}));
      const MatVariables read = Read(file);
      ASSERT_EQ(read.variables.size(), 2U) << type << " " << bytes;
      EXPECT_FALSE(read.variables[0].is_numeric()) << type << " " << bytes;
      EXPECT_THAT(read.variables[1].Numbers(), ElementsAre(1, 2)) << type << " " << bytes;
    }
  }
}

TEST(MatVariables, ComplexAndCubicOnesComeWithoutData) {
  const std::string data = Element(kDoubles, std::string(16, '\0'));
  const std::string bytes =
      File(Element(kMatrix, Head(kDouble | kComplex, {2, 1}, "z") + data + data) +
           Element(kMatrix, Head(kDouble, {2, 1, 1}, "cube") + data) + Vector("x", {1, 2}));
  const MatVariables read = Read(bytes);
  ASSERT_EQ(read.variables.size(), 3U);
  EXPECT_FALSE(read.variables[0].is_numeric());
  EXPECT_FALSE(read.variables[1].is_numeric());
  EXPECT_TRUE(read.variables[2].is_numeric());
  EXPECT_FALSE(read.variables[2].is_whole());
}

TEST(MatVariables, AFileThatEndsWithinAnElementIsNotWhole) {
  const std::string whole = File(Vector("x", {1, 2}));
  EXPECT_TRUE(ReadMatVariables(whole).is_whole);
  for (std::size_t cut = 129; cut < whole.size(); ++cut) {
    EXPECT_FALSE(ReadMatVariables(whole.substr(0, cut)).is_whole) << cut;
  }
  EXPECT_FALSE(ReadMatVariables(whole.substr(0, 127)).is_whole);
  std::string swapped = whole;
  std::swap(swapped[126], swapped[127]);
  EXPECT_FALSE(ReadMatVariables(swapped).is_whole) << "the highest byte first";
  // one number more, and one less, than the sides say
  for (const std::uint32_t rows : {1U, 3U}) {
    EXPECT_FALSE(
        ReadMatVariables(File(Element(kMatrix, Head(kDouble, {rows, 1}, "x") +
                                                   Element(kDoubles, std::string(16, 'a')))))
            .is_whole);
  }
}

TEST(MatVariables, AHundredThousandAreRead) {
  std::string empty;
  for (int i = 0; i < 100'000; ++i) empty += Element(kMatrix, "");
  EXPECT_TRUE(ReadMatVariables(File(empty)).is_whole);
  EXPECT_FALSE(ReadMatVariables(File(empty + Element(kMatrix, ""))).is_whole);
}

std::string Packed(const std::string& plain) {
  std::string packed(compressBound(plain.size()), '\0');
  uLongf length = packed.size();
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &length,
                     reinterpret_cast<const Bytef*>(plain.data()), plain.size()),
            Z_OK);
  return Le(15, 4) + Le(length, 4) + packed.substr(0, length);
}

TEST(MatVariables, ACompressedOneIsFollowedByTheNextAtOnce) {
  const std::string one = Packed(Vector("x", {1, -2}));
  const std::string bytes = File(one + Vector("y", {3}) + one);
  const MatVariables read = Read(bytes);
  ASSERT_EQ(read.variables.size(), 3U);
  EXPECT_THAT(read.variables[0].Numbers(), ElementsAre(1, -2));
  EXPECT_EQ(read.variables[1].name, "y");
  EXPECT_THAT(read.variables[2].Numbers(), ElementsAre(1, -2));
  EXPECT_FALSE(ReadMatVariables(File(Le(15, 4) + Le(one.size() - 9, 4) + one.substr(8))).is_whole);
}

// of a stream no more is unpacked than the element in it states
TEST(MatVariables, ACompressedOneIsAsLongAsItStates) {
  const std::string inner = Element(5, Le(7, 4));
  EXPECT_TRUE(ReadMatVariables(File(Packed(inner))).is_whole);
  EXPECT_FALSE(ReadMatVariables(File(Packed(inner + std::string(1U << 20U, '\0')))).is_whole);
  EXPECT_FALSE(ReadMatVariables(File(Packed(std::string(1U << 20U, '\0')))).is_whole);
  // 2^28 + 2^14 bytes of a matrix, which are more numbers than are read
  const std::string head = Head(9, {1U << 14U, (1U << 14U) + 1}, "x");
  const std::string many = Le(kMatrix, 4) + Le((1U << 28U) + (1U << 15U), 4) + head;
  EXPECT_FALSE(ReadMatVariables(File(Packed(many))).is_whole);
}

// classes by their numbers: 1 cells, 3 objects, 5 sparse, 6 double, 7 single, 8 to 15 int8 to
// uint64
TEST(MatVariables, ClassesFromDoubleToUint64AreNumbers) {
  const std::string data = Element(kDoubles, Le(std::bit_cast<std::uint64_t>(3.0), 8) +
                                                 Le(std::bit_cast<std::uint64_t>(-4.5), 8));
  for (std::uint32_t c = 1; c <= 18; ++c) {
    if (c == 2 || c == kChar) continue;
    const std::string bytes =
        File(Element(kMatrix, Head(c, {2, 1}, c <= 15 ? "v" : "") + data) + Vector("x", {1, 2}));
    const MatVariables read = Read(bytes);
    // functions and objects of MATLAB have no name
    ASSERT_EQ(read.variables.size(), c <= 15 ? 2U : 1U) << c;
    EXPECT_EQ(read.variables.back().name, "x") << c;
    if (c > 15) continue;
    const MatVariable& variable = read.variables[0];
    EXPECT_EQ(variable.is_numeric(), c >= 6) << c;
    EXPECT_EQ(variable.is_whole(), c >= 8) << c;
    EXPECT_FALSE(variable.is_bytes()) << c;
    EXPECT_FALSE(variable.Text()) << c;
    EXPECT_EQ(variable.Numbers(), c >= 6 ? (std::vector<double>{3, -4.5}) : std::vector<double>{});
  }
  // bytes are of the class uint8 and stored as such
  for (const auto& [c, type] : {std::pair{9U, 2U}, {9U, 1U}, {8U, 2U}}) {
    const std::string bytes =
        File(Element(kMatrix, Head(c, {1, 1}, "v") + SmallElement(type, "a")));
    EXPECT_EQ(Read(bytes).variables.at(0).is_bytes(), c == 9 && type == 2) << c << " " << type;
  }
}

TEST(MatVariables, AMatrixThatLacksAPartIsDamaged) {
  const std::string flags = Element(6, Le(kDouble, 4) + Le(0, 4));
  const std::string sides = Element(5, Le(2, 4) + Le(1, 4));
  const std::string name = Element(1, "x");
  const std::string data = Element(kDoubles, std::string(16, '\0'));
  const auto is_whole = [](const std::string& parts) {
    return ReadMatVariables(File(Element(kMatrix, parts))).is_whole;
  };
  EXPECT_TRUE(is_whole(flags + sides + name + data));
  // parts of another type, of another length, and none
  EXPECT_FALSE(is_whole(Element(5, Le(kDouble, 4) + Le(0, 4)) + sides + name + data));
  EXPECT_FALSE(is_whole(Element(6, Le(kDouble, 4)) + sides + name + data));
  EXPECT_FALSE(is_whole(Element(6, Le(kDouble, 4) + Le(0, 8)) + sides + name + data));
  EXPECT_FALSE(is_whole(flags + Element(6, Le(2, 4) + Le(1, 4)) + name + data));
  EXPECT_FALSE(is_whole(flags + Element(5, Le(2, 4)) + name + data));
  EXPECT_FALSE(is_whole(flags + sides + Element(2, "x") + data));
  EXPECT_FALSE(is_whole(flags.substr(0, 7)));
  EXPECT_FALSE(is_whole(flags));
  EXPECT_FALSE(is_whole(flags + sides));
  EXPECT_FALSE(is_whole(flags + sides + name));
  // 17 bytes are no doubles, and a tag holds four bytes
  EXPECT_FALSE(is_whole(flags + sides + name + Element(kDoubles, std::string(17, '\0'))));
  EXPECT_FALSE(is_whole(flags + sides + Le(5U << 16U | 1, 4) + "abcd" + data));
  EXPECT_TRUE(is_whole(flags + sides + SmallElement(1, "abcd") + data));
}

TEST(MatVariables, OtherElementsThanMatricesArePassedOver) {
  const std::string other = Element(5, Le(7, 4));
  for (const std::string& elements :
       {other + Vector("x", {1, 2}), Packed(other) + Vector("x", {1, 2})}) {
    const std::string bytes = File(elements);
    const MatVariables read = Read(bytes);
    ASSERT_EQ(read.variables.size(), 1U);
    EXPECT_EQ(read.variables[0].name, "x");
  }
  // what is compressed is an element of eight bytes at least
  EXPECT_FALSE(ReadMatVariables(File(Packed("1234567"))).is_whole);
}

// --- tables --------------------------------------------------------------------------------------

const ImportOptions kAtRate{.rate_hz = 10.0};

Record Parsed(const std::string& bytes, const ImportOptions& options,
              const std::string& name = "") {
  auto recording = ParseMat(bytes, "f.mat", name, options);
  EXPECT_TRUE(recording) << recording.error().Text();
  return recording ? std::move(recording->record) : Record{};
}

std::string ErrorOf(const std::string& bytes, const std::string& name = "",
                    const ImportOptions& options = kAtRate) {
  const auto recording = ParseMat(bytes, "f.mat", name, options);
  return recording ? "was read" : recording.error().Text();
}

TEST(Mat, TheLongestVectorsAreTheColumns) {
  const std::string bytes = File(Vector("fs", {8000}) + Vector("displacement_mm", {1, 2, 3}) +
                                 Vector("other", {1, 2}) + Vector("voltage_v", {4, 5, 6}));
  const Record record = Parsed(bytes, kAtRate);
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_THAT(record.channels[0].values, ElementsAre(1e-3, 2e-3, 3e-3));
  EXPECT_THAT(record.channels[1].values, ElementsAre(4, 5, 6));
  EXPECT_THAT(Parsed(bytes, kAtRate, "other").channels.at(0).values, ElementsAre(1, 2));
  EXPECT_THAT(
      ErrorOf(bytes, "none"),
      HasSubstr("f.mat: holds no variable 'none', but fs, displacement_mm, other, voltage_v"));
}

std::string Matrix(const std::string& name, std::uint32_t rows, std::uint32_t columns) {
  std::string data;
  for (std::uint32_t c = 0; c < columns; ++c) {
    for (std::uint32_t r = 0; r < rows; ++r) data += Le(10 * r + c, 2);
  }
  return Element(kMatrix, Head(kInt16, {rows, columns}, name) + Element(3, data));
}

TEST(Mat, TheOnlyMatrixIsATable) {
  const Record record = Parsed(File(Matrix("m", 3, 2)), {.columns = {"a", "b"}, .rate_hz = 10.0});
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_THAT(record.channels[0].values, ElementsAre(0, 10, 20));
  EXPECT_THAT(record.channels[1].values, ElementsAre(1, 11, 21));
  EXPECT_THAT(ErrorOf(File(Matrix("m", 3, 2))), HasSubstr("is a matrix of 3 x 2 numbers"));
}

// whichever stands first in the file, and along whichever side the rows of the matrix lie
TEST(Mat, AVectorBesideAMatrixIsAColumnBesideItsColumns) {
  const std::string time = Vector("t", {0, 0.1, 0.2});
  ImportOptions names{.columns = {"time_s", "a", "b"}};
  for (const std::string& matrix : {Matrix("m", 3, 2), Matrix("m", 2, 3)}) {
    EXPECT_EQ(Parsed(File(time + matrix), names).channels.size(), 2U);
  }
  Record record = Parsed(File(time + Matrix("m", 3, 2)), names);
  EXPECT_THAT(record.channels.at(1).values, ElementsAre(1, 11, 21));
  EXPECT_REL(record.stretches.at(0).rate_hz, 10, 1e-12, "a line through three doubles");
  names.columns = {"a", "b", "time_s"};
  record = Parsed(File(Matrix("m", 3, 2) + time), names);
  EXPECT_THAT(record.channels.at(1).values, ElementsAre(1, 11, 21));
  EXPECT_REL(record.stretches.at(0).rate_hz, 10, 1e-12, "a line through three doubles");
}

TEST(Mat, EachColumnBesideAMatrixNeedsAName) {
  const std::string time = Vector("t", {0, 0.1, 0.2});
  const ImportOptions two{.columns = {"a", "b"}, .rate_hz = 10.0};
  for (const std::string& bytes :
       {File(time + Matrix("m", 3, 2)), File(Matrix("m", 3, 2) + time)}) {
    for (const ImportOptions& options : {ImportOptions{}, two}) {
      EXPECT_THAT(ErrorOf(bytes, "", options),
                  AllOf(HasSubstr("3 columns in all"), HasSubstr("m of 2"),
                        HasSubstr("name each in <columns>"), HasSubstr("f.mat/m")));
    }
    EXPECT_EQ(Parsed(bytes, two, "m").channels.size(), 2U);
  }
}

TEST(Mat, AStructIsATableOfItsFields) {
  // names of twelve bytes; a field's matrix has none
  const std::string names = "voltage_v" + std::string(3, '\0') + "n" + std::string(11, '\0');
  const auto with_sides = [&](std::uint32_t elements) {
    return File(Element(kMatrix, Head(2, {1, elements}, "s") + SmallElement(5, Le(12, 4)) +
                                     Element(1, names) + Vector("", {4, 5}) + Vector("", {9})));
  };
  const Record record = Parsed(with_sides(1), kAtRate);
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kVoltage);
  EXPECT_THAT(record.channels[0].values, ElementsAre(4, 5));
  EXPECT_THAT(ErrorOf(with_sides(2)), HasSubstr("holds no column of numbers"));
}

// a struct `s` of one element: the length of a name, the names, a matrix for each
std::string Struct(const std::string& length, const std::string& names, const std::string& fields) {
  return File(Element(kMatrix, Head(2, {1, 1}, "s") + length + names + fields));
}

TEST(MatVariables, AStructHasAMatrixForEachName) {
  const std::string four = SmallElement(5, Le(4, 4));
  const std::string ab = Element(1, std::string("a\0\0\0b\0\0\0", 8));
  const std::string fields = Vector("", {1, 2}) + Element(kMatrix, "");
  const std::string whole = Struct(four, ab, fields);
  const MatVariables read = Read(whole);
  ASSERT_EQ(read.variables.size(), 1U);
  ASSERT_EQ(read.variables[0].fields.size(), 2U);
  EXPECT_EQ(read.variables[0].fields[0].name, "a");
  EXPECT_THAT(read.variables[0].fields[0].Numbers(), ElementsAre(1, 2));
  EXPECT_EQ(read.variables[0].fields[1].name, "b");
  EXPECT_EQ(read.variables[0].fields[1].size(), 0U);
  // names of another length, of another type, and a field that is none, or lacks a part
  for (const std::string& bytes :
       {Struct(SmallElement(6, Le(4, 4)), ab, fields), Struct(Element(5, Le(4, 8)), ab, fields),
        Struct(SmallElement(5, Le(4, 2)), ab, fields),
        Struct(SmallElement(5, Le(0, 4)), ab, fields),
        Struct(SmallElement(5, Le(3, 4)), ab, fields),
        Struct(four, Element(2, std::string(8, 'a')), fields), Struct(four, "", fields),
        Struct(four, ab, Vector("", {1, 2})), Struct(four, ab, Vector("", {1, 2}) + Element(5, "")),
        Struct(four, ab, Vector("", {1, 2}) + Element(kMatrix, Element(6, Le(kDouble, 4))))}) {
    EXPECT_FALSE(ReadMatVariables(bytes).is_whole);
  }
}

TEST(MatVariables, AStructHasTenThousandFieldsAtMost) {
  const auto with_fields = [](std::size_t count) {
    std::string fields;
    for (std::size_t i = 0; i < count; ++i) fields += Element(kMatrix, "");
    return Struct(SmallElement(5, Le(1, 4)), Element(1, std::string(count, 'a')), fields);
  };
  const std::string most = with_fields(10'000);
  EXPECT_EQ(Read(most).variables.at(0).fields.size(), 10'000U);
  EXPECT_FALSE(ReadMatVariables(with_fields(10'001)).is_whole);
}

TEST(MatVariables, AStructInAStructComesWithoutData) {
  const std::string four = SmallElement(5, Le(4, 4));
  const std::string inner =
      Element(kMatrix, Head(2, {1, 1}, "") + four + Element(1, "abcd") + Vector("", {1, 2}));
  const std::string bytes =
      Struct(four, Element(1, std::string("in\0\0v\0\0\0", 8)), inner + Vector("", {3}));
  const MatVariables read = Read(bytes);
  const auto& fields = read.variables.at(0).fields;
  ASSERT_EQ(fields.size(), 2U);
  EXPECT_FALSE(fields[0].is_struct());
  EXPECT_TRUE(fields[0].fields.empty());
  EXPECT_THAT(fields[1].Numbers(), ElementsAre(3));
}

TEST(Mat, VectorsStandAlongEitherSideAndEmptyOnesAreNoColumns) {
  const Record record =
      Parsed(File(Matrix("along", 1, 3) + Matrix("down", 3, 1) + Matrix("none", 0, 3)), kAtRate);
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[0].name, "along");
  EXPECT_THAT(record.channels[0].values, ElementsAre(0, 1, 2));
  EXPECT_THAT(record.channels[1].values, ElementsAre(0, 10, 20));
}

// 1005 ns off a grid of 1 s are beyond the millionth of whole numbers (NumberTable)
TEST(Mat, WholeNumbersAreExactTimes) {
  for (const std::uint32_t matrix_class : {12U, kDouble}) {
    const std::string bytes = File(
        Element(kMatrix, Head(matrix_class, {3, 1}, "time_ns") +
                             Element(5, Le(0, 4) + Le(1'000'001'005, 4) + Le(2'000'000'000, 4))) +
        Vector("voltage_v", {4, 5, 6}));
    EXPECT_EQ(Parsed(bytes, {}).raw_times_s.size(), matrix_class == kDouble ? 0U : 3U);
  }
}

TEST(Mat, TheFirstEightVariablesAreNamed) {
  EXPECT_THAT(ErrorOf(File(Vector("x", {1, 2})).substr(0, 150)),
              HasSubstr("f.mat: is a MATLAB file that was cut short or is damaged"));
  EXPECT_EQ(ErrorOf(File("")), "f.mat: holds no variable; name one of its variables");
  EXPECT_EQ(ErrorOf(File(""), "x"), "f.mat: holds no variable; name one of its variables");
  std::string vectors;
  for (const char* name : {"a", "b", "c", "d", "e", "f", "g", "h"}) vectors += Vector(name, {1, 2});
  EXPECT_EQ(ErrorOf(File(vectors), "x"),
            "f.mat: holds no variable 'x', but a, b, c, d, e, f, g, h; name one of its variables");
  EXPECT_EQ(
      ErrorOf(File(vectors + Vector("i", {1, 2})), "x"),
      "f.mat: holds no variable 'x', but a, b, c, d, e, f, g, h, ...; name one of its variables");
}

// a struct with a header is a trial
TEST(Mat, OneOfSeveralTrialsIsNamed) {
  const auto trial = [](const char* name) {
    return Element(kMatrix, Head(2, {1, 1}, name) + SmallElement(5, Le(12, 4)) +
                                Element(1, "header_json" + std::string(1, '\0')) +
                                Element(kMatrix, Head(kChar, {1, 2}, "") + SmallElement(16, "{}")));
  };
  EXPECT_EQ(ErrorOf(File(trial("t1") + trial("t2"))),
            "f.mat: holds 2 trials: t1, t2; name one as f.mat/t1");
  EXPECT_THAT(ErrorOf(File(trial("t1") + trial("t2")), "t2"),
              HasSubstr("f.mat/t2: its header_json is not a trial's header"));
}

}  // namespace
}  // namespace haptometer::trial
