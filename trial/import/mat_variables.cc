#include "trial/import/mat_variables.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <utility>

#include "trial/block.h"
#include "trial/import/exported_trial.h"

namespace haptometer::trial {
namespace {

using std::string_view_literals::operator""sv;

// types of elements in the file
constexpr std::uint32_t kInt8Type = 1;
constexpr std::uint32_t kUint16Type = 4;
constexpr std::uint32_t kInt32Type = 5;
constexpr std::uint32_t kUint32Type = 6;
constexpr std::uint32_t kMatrixType = 14;
constexpr std::uint32_t kCompressedType = 15;
constexpr std::uint32_t kUtf8Type = 16;

// bytes of one number of each type of element; 0: no numbers
constexpr std::array<std::size_t, 14> kNumberBytes{0, 1, 1, 2, 2, 4, 4, 4, 0, 8, 0, 0, 8, 8};

template <typename T>
T At(std::string_view bytes, std::size_t at) {
  return LoadLittleEndian<T>(reinterpret_cast<const std::byte*>(bytes.data() + at));
}

constexpr std::size_t kTagBytes = 8;

struct Element {
  std::uint32_t type = 0;
  std::string_view data{};
};

// The element that `bytes` begin with; they then begin behind it. Nothing where it is not whole.
std::optional<Element> TakeElement(std::string_view* bytes) {
  if (bytes->size() < kTagBytes) return std::nullopt;
  const auto word = At<std::uint32_t>(*bytes, 0);
  // up to four bytes stand in the tag itself, their number in its upper half
  if (const std::size_t size = word >> 16U; size > 0) {
    if (size > 4) return std::nullopt;
    const Element element{.type = word & 0xffffU, .data = bytes->substr(4, size)};
    bytes->remove_prefix(kTagBytes);
    return element;
  }
  const std::size_t size = At<std::uint32_t>(*bytes, 4);
  bytes->remove_prefix(kTagBytes);
  if (size > bytes->size()) return std::nullopt;
  const Element element{.type = word, .data = bytes->substr(0, size)};
  // elements begin at multiples of eight bytes, but for those behind a compressed one
  const std::size_t padded = word == kCompressedType ? size : (size + 7) / 8 * 8;
  bytes->remove_prefix(std::min(padded, bytes->size()));
  return element;
}

// the element of `type`; nothing for another
std::optional<std::string_view> TakeData(std::string_view* bytes, std::uint32_t type) {
  const auto element = TakeElement(bytes);
  if (!element || element->type != type) return std::nullopt;
  return element->data;
}

// The bytes of the element of which these are the first, with its tag. Nothing where they are no
// element, or one of a matrix of more numbers than are read.
std::optional<std::size_t> StatedBytes(std::string_view beginning) {
  if (beginning.size() < kTagBytes) return std::nullopt;
  // one of up to four bytes stands in its tag
  const auto type = At<std::uint32_t>(beginning, 0);
  if (type >> 16U > 0) return kTagBytes;
  const std::size_t size = At<std::uint32_t>(beginning, 4);
  beginning.remove_prefix(kTagBytes);
  const auto flags = type == kMatrixType ? TakeData(&beginning, kUint32Type) : std::nullopt;
  const auto sides = flags ? TakeData(&beginning, kInt32Type) : std::nullopt;
  if (sides && sides->size() == 8) {
    const std::uint64_t rows = At<std::uint32_t>(*sides, 0);
    if (rows * At<std::uint32_t>(*sides, 4) > kMostNumbers) return std::nullopt;
  }
  return kTagBytes + (size + 7) / 8 * 8;
}

// the element that a zlib stream holds, at most `most` bytes
std::optional<std::string> Inflated(std::string_view stream, std::size_t most) {
  // what deflate makes of one byte at most (zlib's technical details)
  constexpr std::size_t kMostBytesOfOne = 1032;
  z_stream state{};
  if (inflateInit(&state) != Z_OK) return std::nullopt;
  // zlib reads the input only
  state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(stream.data()));
  state.avail_in = static_cast<uInt>(stream.size());
  std::string content;
  std::array<char, 1U << 16U> piece{};
  int status = Z_OK;
  std::size_t stated = 0;
  while (status == Z_OK && content.size() <= stated) {
    state.next_out = reinterpret_cast<Bytef*>(piece.data());
    state.avail_out = static_cast<uInt>(piece.size());
    status = inflate(&state, Z_NO_FLUSH);
    // the first piece states how many bytes there are
    if (content.empty()) {
      stated = StatedBytes({piece.data(), piece.size() - state.avail_out}).value_or(most + 1);
      if (stated > most) break;
      content.reserve(std::min(stated, kMostBytesOfOne * stream.size()) + piece.size());
    }
    content.append(piece.data(), piece.size() - state.avail_out);
  }
  inflateEnd(&state);
  if (status != Z_STREAM_END || content.size() > stated) return std::nullopt;
  return content;
}

// the parts of one file
class Parser {
 public:
  MatVariables Read(std::string_view bytes) {
    constexpr std::size_t kHeadBytes = 128;
    // the least byte first: "IM"; version 1
    const bool is_known = bytes.size() >= kHeadBytes && bytes.substr(124, 4) == "\x00\x01IM"sv;
    if (!is_known) return std::move(file_);
    bytes.remove_prefix(kHeadBytes);
    while (!bytes.empty()) {
      const auto element = TakeElement(&bytes);
      if (!element || !AddElement(*element)) return std::move(file_);
    }
    file_.is_whole = true;
    return std::move(file_);
  }

 private:
  // false: the file is damaged
  bool AddElement(Element element) {
    if (element.type == kCompressedType) {
      constexpr std::size_t kMostBytes = std::size_t{1} << 31U;
      auto content = Inflated(element.data, kMostBytes - inflated_bytes_);
      if (!content) return false;
      inflated_bytes_ += content->size();
      std::string_view rest = file_.inflated.emplace_back(std::move(*content));
      const auto inner = TakeElement(&rest);
      if (!inner) return false;
      element = *inner;
    }
    // other elements than matrices are no variables
    if (element.type != kMatrixType) return true;
    auto variable = ReadMatrix(element.data, true);
    // one without a name belongs to MATLAB's objects
    if (variable && !variable->name.empty()) file_.variables.push_back(std::move(*variable));
    return variable.has_value();
  }

  // flags, sides and name, then the numbers or the fields; an empty element is an empty matrix
  std::optional<MatVariable> ReadMatrix(std::string_view bytes, bool may_have_fields) {
    // an empty element takes eight bytes, its variable many more
    constexpr std::size_t kMostVariables = 100'000;
    if (++variables_ > kMostVariables) return std::nullopt;
    MatVariable variable;
    if (bytes.empty()) return variable;
    const auto flags = TakeData(&bytes, kUint32Type);
    if (!flags || flags->size() != 8) return std::nullopt;
    constexpr std::uint32_t kComplexFlag = 0x800;
    const auto word = At<std::uint32_t>(*flags, 0);
    const auto matrix_class = static_cast<std::uint8_t>(word & 0xffU);
    // what lies behind the flags of functions and objects is their own
    if (matrix_class > MatVariable::kUint64) return variable;
    const auto sides = TakeData(&bytes, kInt32Type);
    const auto name = TakeData(&bytes, kInt8Type);
    if (!sides || sides->size() < 8 || !name) return std::nullopt;
    variable.name = *name;
    // more than two sides and complex numbers are not read
    if (sides->size() != 8 || (word & kComplexFlag) != 0) return variable;
    variable.rows = At<std::uint32_t>(*sides, 0);
    variable.columns = At<std::uint32_t>(*sides, 4);
    if (matrix_class == MatVariable::kStruct) {
      if (!may_have_fields || variable.size() != 1) return variable;
      variable.matrix_class = matrix_class;
      return ReadFields(bytes, &variable) ? std::optional(std::move(variable)) : std::nullopt;
    }
    const bool is_read =
        matrix_class == MatVariable::kChar ||
        (matrix_class >= MatVariable::kDouble && matrix_class <= MatVariable::kUint64);
    if (!is_read) return variable;
    variable.matrix_class = matrix_class;
    return ReadNumbers(bytes, &variable) ? std::optional(std::move(variable)) : std::nullopt;
  }

  bool ReadNumbers(std::string_view bytes, MatVariable* variable) {
    const auto element = TakeElement(&bytes);
    if (!element) return false;
    const bool is_utf8 = element->type == kUtf8Type && variable->matrix_class == MatVariable::kChar;
    const std::size_t width = is_utf8                               ? 1
                              : element->type < kNumberBytes.size() ? kNumberBytes[element->type]
                                                                    : 0;
    // a text of another encoding is not read
    if (width == 0) {
      variable->matrix_class = 0;
      return true;
    }
    if (element->data.size() % width != 0) return false;
    const std::size_t count = element->data.size() / width;
    // a text in UTF-8 may have more bytes than characters
    if (count != variable->size() && !(is_utf8 && count >= variable->size())) return false;
    numbers_ += count;
    variable->storage = static_cast<std::uint8_t>(element->type);
    variable->data = element->data;
    return numbers_ <= kMostNumbers;
  }

  // the length of a name, all names, then a matrix for each
  bool ReadFields(std::string_view bytes, MatVariable* variable) {
    constexpr std::size_t kMostFields = 10'000;
    const auto length = TakeData(&bytes, kInt32Type);
    const auto names = TakeData(&bytes, kInt8Type);
    if (!length || length->size() != 4 || !names) return false;
    const std::size_t width = At<std::uint32_t>(*length, 0);
    if (width == 0 || names->size() % width != 0 || names->size() / width > kMostFields) {
      return false;
    }
    for (std::size_t at = 0; at < names->size(); at += width) {
      const auto matrix = TakeData(&bytes, kMatrixType);
      auto field = matrix ? ReadMatrix(*matrix, false) : std::nullopt;
      if (!field) return false;
      const std::string_view name = names->substr(at, width);
      field->name = name.substr(0, name.find('\0'));
      variable->fields.push_back(std::move(*field));
    }
    return true;
  }

  MatVariables file_{};
  std::size_t inflated_bytes_ = 0;
  std::size_t numbers_ = 0;
  std::size_t variables_ = 0;  // and fields
};

template <typename T>
std::vector<double> NumbersAs(std::string_view data) {
  std::vector<double> numbers;
  numbers.reserve(data.size() / sizeof(T));
  for (std::size_t at = 0; at < data.size(); at += sizeof(T)) {
    numbers.push_back(static_cast<double>(At<T>(data, at)));
  }
  return numbers;
}

}  // namespace

// a class of numbers may be stored in any type that holds them
std::vector<double> MatVariable::Numbers() const {
  switch (storage) {
    case 1:
      return NumbersAs<std::int8_t>(data);
    case 2:
      return NumbersAs<std::uint8_t>(data);
    case 3:
      return NumbersAs<std::int16_t>(data);
    case 4:
      return NumbersAs<std::uint16_t>(data);
    case 5:
      return NumbersAs<std::int32_t>(data);
    case 6:
      return NumbersAs<std::uint32_t>(data);
    case 7:
      return NumbersAs<float>(data);
    case 9:
      return NumbersAs<double>(data);
    case 12:
      return NumbersAs<std::int64_t>(data);
    case 13:
      return NumbersAs<std::uint64_t>(data);
    default:
      return {};
  }
}

std::optional<std::string> MatVariable::Text() const {
  if (matrix_class != kChar) return std::nullopt;
  if (storage != kUint16Type) return std::string(data);
  std::string text;
  for (std::size_t at = 0; at < data.size(); at += 2) {
    const auto character = At<std::uint16_t>(data, at);
    text += character < 0x80 ? static_cast<char>(character) : '?';
  }
  return text;
}

MatVariables ReadMatVariables(std::string_view bytes) { return Parser().Read(bytes); }

}  // namespace haptometer::trial
