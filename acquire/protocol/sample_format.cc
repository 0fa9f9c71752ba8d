#include "acquire/protocol/sample_format.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/names.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::acquire {
namespace {

using trial::RawValue;
using trial::Sample;
using trial::SampleStatus;

static_assert(std::endian::native == std::endian::little, "binary samples are read as they lie");

constexpr Names<SampleFormat, 4> kNames{{"f64", "f32", "i16", "text"}};

// a number with its blanks: "-1.7976931348623157e+308" and as much room again
constexpr std::size_t kLongestCell = 48;

// bytes of one binary number; 0 for text
std::size_t BytesOf(SampleFormat format) {
  switch (format) {
    case SampleFormat::kF64:
      return 8;
    case SampleFormat::kF32:
      return 4;
    case SampleFormat::kI16:
      return 2;
    case SampleFormat::kText:
      break;
  }
  return 0;
}

// a number from bytes at any alignment
template <typename T>
T Load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

// raw number as sent, with its status by the limits of the channel
Sample BinarySample(SampleFormat format, const char* bytes, const trial::RawLimits& limits) {
  if (format == SampleFormat::kF64) {
    const auto value = Load<double>(bytes);
    return {RawValue::F64(value), StatusOf(limits, value)};
  }
  if (format == SampleFormat::kF32) {
    const auto value = Load<float>(bytes);
    return {RawValue::F32(value), StatusOf(limits, static_cast<double>(value))};
  }
  const auto value = Load<std::int16_t>(bytes);
  return {RawValue::Counts(value), StatusOf(limits, value)};
}

// characters that may separate two numbers
bool IsMark(char c) { return c == ',' || c == ';' || c == ' ' || c == '\t'; }

// takes the first number off `line`, with what separates it from the next; an empty cell stays
std::string_view TakeCell(std::string_view& line) {
  const std::string_view cell = {line.begin(), std::ranges::find_if(line, IsMark)};
  line.remove_prefix(cell.size());
  // blanks around a comma or semicolon belong to the separator
  line = trial::Trimmed(line);
  if (!line.empty() && (line[0] == ',' || line[0] == ';')) {
    line.remove_prefix(1);
    line = trial::Trimmed(line);
    // a mark promises a further number
    if (line.empty()) line = ",";
  }
  return cell;
}

}  // namespace

std::string_view Name(SampleFormat format) { return kNames.Of(format); }

std::optional<SampleFormat> SampleFormatFromName(std::string_view name) {
  return kNames.From(name);
}

trial::Encoding EncodingOf(SampleFormat format) {
  if (format == SampleFormat::kI16) return trial::Encoding::kI32;
  return format == SampleFormat::kF32 ? trial::Encoding::kF32 : trial::Encoding::kF64;
}

// a line that is longer than its numbers can be is damaged
SampleParser::SampleParser(SampleFormat format, std::vector<trial::RawLimits> limits)
    : format_(format),
      limits_(std::move(limits)),
      framer_(Delimiter::kLf, std::max<std::size_t>(limits_.size(), 1) * kLongestCell) {
  HAPTOMETER_CHECK(!limits_.empty(), "{} channels", limits_.size());
}

void SampleParser::Feed(std::string_view bytes) {
  line_ = {};
  if (format_ == SampleFormat::kText) {
    framer_.Feed(bytes);
    return;
  }
  // rows that were taken leave the buffer, a begun row remains
  buffer_.erase(0, row_begin_);
  row_begin_ = 0;
  buffer_.append(bytes);
}

RowState SampleParser::Next(std::span<Sample> row) {
  HAPTOMETER_CHECK(row.size() == limits_.size(), "{} samples, {} channels", row.size(),
                   limits_.size());
  return format_ == SampleFormat::kText ? NextLine(row) : NextBinary(row);
}

RowState SampleParser::NextBinary(std::span<Sample> row) {
  const std::size_t bytes = BytesOf(format_);
  // rows are complete or wait for more bytes: binary data have no marks to find a row again
  if (buffer_.size() - row_begin_ < bytes * row.size()) return RowState::kNeedMore;
  for (std::size_t channel = 0; channel < row.size(); ++channel) {
    row[channel] = BinarySample(format_, buffer_.data() + row_begin_, limits_[channel]);
    row_begin_ += bytes;
  }
  return RowState::kRow;
}

RowState SampleParser::NextLine(std::span<Sample> row) {
  while (true) {
    const Frame frame = framer_.Next();
    if (frame.framing == Framing::kNeedMore) return RowState::kNeedMore;
    line_ = trial::Trimmed(frame.text);
    const bool is_line = frame.framing == Framing::kValid;
    // empty lines are no rows
    if (is_line && line_.empty()) continue;
    if (is_line && ReadLine(line_, row)) return RowState::kRow;
    discarded_bytes_ += frame.text.size();
    // a damaged row keeps its place: all channels bad_frame
    std::ranges::fill(row, Sample{RawValue(), SampleStatus::kBadFrame});
    return RowState::kBadRow;
  }
}

bool SampleParser::ReadLine(std::string_view line, std::span<Sample> row) const {
  for (std::size_t channel = 0; channel < row.size(); ++channel) {
    const auto number = trial::ReadNumber(TakeCell(line));
    if (!number) return false;
    row[channel] = {RawValue::F64(*number), StatusOf(limits_[channel], *number)};
  }
  // numbers behind the last channel make the row invalid
  return line.empty();
}

bool SampleParser::IsRowWithDecimalCommas() const {
  if (!line_.contains(',')) return false;
  std::string line(line_);
  std::ranges::replace(line, ',', '.');
  std::vector<Sample> row(limits_.size());
  return ReadLine(line, row);
}

std::size_t SampleParser::waiting_bytes() const {
  return format_ == SampleFormat::kText ? framer_.waiting_bytes() : buffer_.size() - row_begin_;
}

}  // namespace haptometer::acquire
