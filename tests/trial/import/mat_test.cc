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

#include "trial/import/mat_variables.h"
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

TEST(MatVariables, ACompressedOneIsFollowedByTheNextAtOnce) {
  const std::string plain = Vector("x", {1, -2});
  std::string packed(compressBound(plain.size()), '\0');
  uLongf length = packed.size();
  ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &length,
                     reinterpret_cast<const Bytef*>(plain.data()), plain.size()),
            Z_OK);
  packed.resize(length);
  const std::string one = Le(15, 4) + Le(length, 4) + packed;
  const std::string bytes = File(one + Vector("y", {3}) + one);
  const MatVariables read = Read(bytes);
  ASSERT_EQ(read.variables.size(), 3U);
  EXPECT_THAT(read.variables[0].Numbers(), ElementsAre(1, -2));
  EXPECT_EQ(read.variables[1].name, "y");
  EXPECT_THAT(read.variables[2].Numbers(), ElementsAre(1, -2));
  EXPECT_FALSE(ReadMatVariables(File(Le(15, 4) + Le(length - 1, 4) + packed)).is_whole);
}

// --- tables --------------------------------------------------------------------------------------

const ImportOptions kAtRate{.rate_hz = 10.0};

Record Parsed(const std::string& bytes, const ImportOptions& options,
              const std::string& name = "") {
  auto recording = ParseMat(bytes, "f.mat", name, options);
  EXPECT_TRUE(recording) << recording.error().Text();
  return recording ? std::move(recording->record) : Record{};
}

std::string ErrorOf(const std::string& bytes, const std::string& name = "") {
  const auto recording = ParseMat(bytes, "f.mat", name, kAtRate);
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
  EXPECT_THAT(ErrorOf(File(Vector("v", {1, 2, 3}) + Matrix("m", 3, 2))),
              HasSubstr("holds several variables of 3 rows; name one: f.mat/m"));
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

}  // namespace
}  // namespace haptometer::trial
