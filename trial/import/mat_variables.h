#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace haptometer::trial {

/// A variable of a MATLAB file, or a field of a struct; its data are views into the file's bytes.
class MatVariable {
 public:
  std::string name{};
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<MatVariable> fields{};  ///< of a struct of one element

  [[nodiscard]] std::size_t size() const { return rows * columns; }
  [[nodiscard]] bool is_struct() const { return matrix_class == kStruct; }
  /// Whether it holds real numbers, and whether these are of a class of whole numbers.
  [[nodiscard]] bool is_numeric() const { return matrix_class >= kDouble; }
  [[nodiscard]] bool is_whole() const { return matrix_class >= kInt8; }
  /// Whether the class is uint8, as statuses have, and `data` are the numbers.
  [[nodiscard]] bool is_bytes() const { return matrix_class == kUint8 && storage == kUint8Type; }

  /// The numbers, column by column. size() are there: the parser has checked it.
  [[nodiscard]] std::vector<double> Numbers() const;
  /// The text of a variable of class char; a character above 127 that is stored in two bytes is a
  /// question mark. Nothing for other classes.
  [[nodiscard]] std::optional<std::string> Text() const;

  // numbers of the classes in the file
  static constexpr std::uint8_t kStruct = 2;
  static constexpr std::uint8_t kChar = 4;
  static constexpr std::uint8_t kDouble = 6;
  static constexpr std::uint8_t kInt8 = 8;
  static constexpr std::uint8_t kUint8 = 9;
  static constexpr std::uint8_t kUint64 = 15;
  // number of the type in the file whose numbers are bytes
  static constexpr std::uint8_t kUint8Type = 2;

  std::uint8_t matrix_class = 0;  ///< 0: of a kind that is not read
  std::uint8_t storage = 0;       ///< type of the numbers in the file
  std::string_view data{};
};

/// What stands in a MATLAB file of version 5.
struct MatVariables {
  std::vector<MatVariable> variables{};
  std::list<std::string> inflated{};  ///< what was compressed, which the variables look at
  bool is_whole = false;              ///< false: the file ends within a variable, or is damaged
};

/// Reads the variables of a MATLAB file of version 5 with the least byte first, compressed or not
/// (The MathWorks, MAT-File Format, chapter 1). Complex, sparse, cell and object variables, arrays
/// of more than two dimensions, arrays of structs and structs in structs come without data.
///
/// At most 2 GiB are taken out of compressed variables, and 2^28 numbers and 100 000 variables and
/// fields are kept; what is beyond makes the file damaged. Memory: what was compressed.
[[nodiscard]] MatVariables ReadMatVariables(std::string_view bytes);

}  // namespace haptometer::trial
