// NumPy arrays, by the format of the numpy.lib.format page of NumPy's reference: magic, version,
// length, a Python dictionary of descr, fortran_order and shape, then the numbers.
#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "trial/block.h"
#include "trial/export/object_names.h"
#include "trial/import/exported_trial.h"
#include "trial/import/number_table.h"
#include "trial/import/readers.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr const char* kRemedy =
    "save an array of plain numbers (numpy.save), or export its columns as a CSV";

// one field of a row: "<f8" is 8 bytes of a float, the least first
struct Field {
  std::string name{};
  char kind = 'f';
  std::size_t bytes = 8;
  std::size_t offset = 0;
  bool is_big_endian = false;
};

struct Array {
  std::vector<Field> fields{};
  bool is_structured = false;
  bool is_by_column = false;
  std::vector<std::size_t> shape{};
  std::size_t item_bytes = 0;
  std::string_view data{};

  [[nodiscard]] std::size_t items() const { return data.size() / item_bytes; }
};

// Reads the dictionary word by word; what is not as NumPy writes it gives nothing.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  bool Take(char sign) {
    SkipBlanks();
    if (!text_.starts_with(sign)) return false;
    text_.remove_prefix(1);
    return true;
  }

  // 'name' or "name"; a sign behind a backslash stands for itself
  std::optional<std::string> Text() {
    SkipBlanks();
    if (text_.empty() || (text_[0] != '\'' && text_[0] != '"')) return std::nullopt;
    const char quote = text_[0];
    std::string word;
    for (std::size_t i = 1; i < text_.size(); ++i) {
      if (text_[i] == quote) {
        text_.remove_prefix(i + 1);
        return word;
      }
      if (text_[i] == '\\' && i + 1 < text_.size()) ++i;
      word += text_[i];
    }
    return std::nullopt;
  }

  std::optional<std::size_t> Count() {
    SkipBlanks();
    std::size_t number = 0;
    const char* const begin = std::to_address(text_.begin());
    const auto parsed = std::from_chars(begin, begin + text_.size(), number);
    if (parsed.ec != std::errc()) return std::nullopt;
    text_.remove_prefix(static_cast<std::size_t>(parsed.ptr - begin));
    return number;
  }

  std::optional<bool> Truth() {
    SkipBlanks();
    for (const auto& [word, value] : {std::pair("True", true), std::pair("False", false)}) {
      if (!text_.starts_with(word)) continue;
      text_.remove_prefix(std::string_view(word).size());
      return value;
    }
    return std::nullopt;
  }

 private:
  void SkipBlanks() { text_.remove_prefix(std::min(text_.find_first_not_of(" \n"), text_.size())); }

  std::string_view text_;
};

// The parts of the head of an array; each gives false where the file's words are not understood.
class Head {
 public:
  Head(std::string_view text, Array* array) : words_(text), array_(*array) {}

  bool Read() {
    if (!words_.Take('{')) return false;
    std::size_t keys = 0;
    while (!words_.Take('}')) {
      const auto key = words_.Text();
      if (!key || !words_.Take(':') || !ReadValue(*key)) return false;
      ++keys;
      words_.Take(',');
    }
    return keys == 3 && array_.item_bytes > 0 && !array_.fields.empty();
  }

  // the type that is no number, for the message
  [[nodiscard]] const std::string& odd_type() const { return odd_type_; }

 private:
  bool ReadValue(const std::string& key) {
    if (key == "descr") return words_.Take('[') ? ReadFields() : ReadType("");
    if (key == "shape") return ReadShape();
    if (key != "fortran_order") return false;
    const auto is_fortran = words_.Truth();
    array_.is_by_column = is_fortran.value_or(false);
    return is_fortran.has_value();
  }

  // [('time_s', '<f8'), ...]; a field with a shape of its own is not understood
  bool ReadFields() {
    array_.is_structured = true;
    while (!words_.Take(']')) {
      if (array_.fields.size() == kMostColumns || !words_.Take('(')) return false;
      // (title, name) in place of a name
      const bool has_title = words_.Take('(');
      if (has_title && (!words_.Text() || !words_.Take(','))) return false;
      const auto name = words_.Text();
      if (!name || (has_title && !words_.Take(')')) || !words_.Take(',')) return false;
      if (!ReadType(*name) || !words_.Take(')')) return false;
      words_.Take(',');
    }
    return true;
  }

  // '<f8': order of bytes, kind, bytes
  bool ReadType(const std::string& name) {
    const auto type = words_.Text();
    if (!type || type->size() < 3) return false;
    Field field{.name = name, .kind = (*type)[1], .offset = array_.item_bytes};
    const char* end = type->data() + type->size();
    const auto parsed = std::from_chars(type->data() + 2, end, field.bytes);
    constexpr std::size_t kMostBytes = std::size_t{1} << 30;
    if (parsed.ec != std::errc() || parsed.ptr != end || field.bytes > kMostBytes) {
      odd_type_ = *type;
      return false;
    }
    field.is_big_endian = (*type)[0] == '>';
    array_.item_bytes += field.bytes;
    // bytes between fields have no name
    if (field.kind == 'V' && name.empty() && array_.is_structured) return true;
    const bool is_whole =
        field.bytes == 1 || field.bytes == 2 || field.bytes == 4 || field.bytes == 8;
    const bool is_number = (field.kind == 'f' && (field.bytes == 4 || field.bytes == 8)) ||
                           ((field.kind == 'i' || field.kind == 'u') && is_whole) ||
                           (field.kind == 'b' && field.bytes == 1);
    const bool is_text = field.kind == 'S' && !array_.is_structured && field.bytes > 0;
    if (!is_number && !is_text) odd_type_ = *type;
    array_.fields.push_back(std::move(field));
    return is_number || is_text;
  }

  bool ReadShape() {
    if (!words_.Take('(')) return false;
    while (!words_.Take(')')) {
      const auto length = words_.Count();
      if (!length || array_.shape.size() == 8) return false;
      array_.shape.push_back(*length);
      words_.Take(',');
    }
    return true;
  }

  Words words_;
  Array& array_;
  std::string odd_type_{};
};

// bytes that the items of `shape` take, where they are no more than `most`
std::optional<std::size_t> BytesOf(const Array& array, std::size_t most) {
  std::size_t items = 1;
  for (const std::size_t length : array.shape) {
    if (length > 0 && items > most / length) return std::nullopt;
    items *= length;
  }
  if (items > most / array.item_bytes) return std::nullopt;
  return items * array.item_bytes;
}

// the head's length stands behind the version in 2 bytes (1.0) or 4; its dictionary
std::optional<std::string_view> TakeDictionary(std::string_view* bytes) {
  constexpr std::size_t kMagicBytes = 8;
  if (bytes->size() < kMagicBytes + 4 || !bytes->starts_with(kMagic)) return std::nullopt;
  const auto* length = reinterpret_cast<const std::byte*>(bytes->data() + kMagicBytes);
  const char version = (*bytes)[6];
  if (version < 1 || version > 3) return std::nullopt;
  const std::size_t size = version == 1 ? LoadLittleEndian<std::uint16_t>(length)
                                        : LoadLittleEndian<std::uint32_t>(length);
  bytes->remove_prefix(kMagicBytes + (version == 1 ? 2 : 4));
  constexpr std::size_t kMostHeadBytes = std::size_t{1} << 20;
  if (size > bytes->size() || size > kMostHeadBytes) return std::nullopt;
  const std::string_view dictionary = bytes->substr(0, size);
  bytes->remove_prefix(size);
  return dictionary;
}

// the array that `bytes` begin with; they then begin behind it
Result<Array> TakeArray(std::string_view* bytes, const std::string& name) {
  Array array;
  const auto dictionary = TakeDictionary(bytes);
  if (!dictionary) return CannotAnswer(name, "is a NumPy array whose head is damaged", kRemedy);
  Head head(*dictionary, &array);
  if (!head.Read()) {
    return CannotAnswer(name,
                        head.odd_type().empty()
                            ? "is a NumPy array whose head is not understood"
                            : fmt::format("is a NumPy array that holds '{}', which is no number",
                                          Printable(head.odd_type())),
                        kRemedy);
  }
  const auto size = BytesOf(array, bytes->size());
  if (!size) return CannotAnswer(name, "is a NumPy array that was cut short", "copy it again");
  array.data = bytes->substr(0, *size);
  bytes->remove_prefix(*size);
  // numbers of a byte take eight in memory
  if (array.items() > kMostNumbers / array.fields.size()) {
    return CannotAnswer(name, "is a NumPy array that is too long to be read", "save a part of it");
  }
  return array;
}

// one number of a row
double NumberAt(const char* row, const Field& field) {
  HAPTOMETER_CHECK(field.bytes >= 1 && field.bytes <= 8, "{} bytes", field.bytes);
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < field.bytes; ++i) {
    const std::size_t at = field.is_big_endian ? i : field.bytes - 1 - i;
    bits = bits << 8U | static_cast<unsigned char>(row[field.offset + at]);
  }
  if (field.kind == 'f') {
    return field.bytes == 8
               ? std::bit_cast<double>(bits)
               : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
  }
  if (field.kind != 'i') return static_cast<double>(bits);
  // the sign of a shorter number stands in its highest bit
  const std::size_t shift = 64 - 8 * field.bytes;
  return static_cast<double>(static_cast<std::int64_t>(bits << shift) >> shift);
}

NumberColumn ColumnOf(const Array& array, const Field& field) {
  NumberColumn column{.name = field.name, .is_count = field.kind != 'f'};
  column.values.reserve(array.items());
  for (std::size_t i = 0; i < array.items(); ++i) {
    column.values.push_back(NumberAt(array.data.data() + i * array.item_bytes, field));
  }
  return column;
}

// the trial that the fields of the first array and the text of the second hold
Result<Recording> ReadExport(const Array& array, std::string_view description,
                             const std::string& name) {
  ObjectsInMemory objects(name);
  HAPTOMETER_TRY(AddDescription(description, &objects));
  for (const Field& field : array.fields) {
    NumberColumn column = ColumnOf(array, field);
    if (field.kind == 'f') {
      objects.numbers[field.name] = std::move(column.values);
    } else if (field.kind == 'u' && field.bytes == 1) {
      auto& bytes = objects.bytes[field.name];
      bytes.reserve(column.values.size());
      for (const double value : column.values) bytes.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return ReadExportedTrial(objects, FileKind::kNpy);
}

Result<NumberTable> TableOf(const Array& array, const std::string& name,
                            const ImportOptions& options) {
  NumberTable table;
  if (array.fields.front().kind == 'S' || array.shape.empty() || array.shape.size() > 2 ||
      (array.is_structured && array.shape.size() > 1)) {
    return CannotAnswer(name, "is a NumPy array that is no table of numbers", kRemedy);
  }
  if (array.is_structured || array.shape.size() == 1) {
    for (const Field& field : array.fields) table.columns.push_back(ColumnOf(array, field));
    return table;
  }
  HAPTOMETER_LET(table.columns,
                 ColumnsOfMatrix(ColumnOf(array, array.fields.front()).values, array.shape[0],
                                 array.shape[1], !array.is_by_column, "", name, options));
  return table;
}

}  // namespace

Result<Recording> ParseNpy(std::string_view bytes, const std::string& name,
                           const ImportOptions& options) {
  HAPTOMETER_LET(const auto array, TakeArray(&bytes, name));
  // an array of bytes behind an array of fields: an export of this program
  if (array.is_structured && array.shape.size() == 1 && bytes.starts_with(kMagic)) {
    HAPTOMETER_LET(const auto second, TakeArray(&bytes, name));
    if (second.shape.empty() && second.fields.front().kind == 'S') {
      return ReadExport(array, second.data, name);
    }
  }
  HAPTOMETER_LET(auto table, TableOf(array, name, options));
  return ReadNumberTable(std::move(table), FileKind::kNpy, name, options);
}

}  // namespace haptometer::trial
