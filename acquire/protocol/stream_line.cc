#include "acquire/protocol/stream_line.h"

#include <fmt/core.h>

#include <cstdlib>

#include "base/quantity.h"

namespace haptometer::acquire {
namespace {

constexpr int kMostDigits = 9;  // 999 999 999 still fits in 32 bits
constexpr std::string_view kFormatRemedy =
    "write PICTURE,UNIT,DELIMITER such as +00.0000,mm,CR or 000000,0.1um,CRLF";
constexpr std::string_view kSeparators = ",;: \t";

// characters of the line counter and its separator
std::size_t CounterWidth(const StreamFormat& format) {
  return format.counter_digits > 0 ? static_cast<std::size_t>(format.counter_digits) + 1 : 0;
}

// digits and point, without the sign
std::size_t NumberWidth(const StreamFormat& format) {
  const std::size_t point = format.decimals > 0 ? 1 : 0;
  return static_cast<std::size_t>(format.whole_digits) + static_cast<std::size_t>(format.decimals) +
         point;
}

// "+00.0000": sign, whole digits, point, decimals
Result<void> ReadPicture(std::string_view picture, StreamFormat& format) {
  // a picture: each 0 stands for a digit, a leading + for an obligatory sign
  const bool is_signed = picture.starts_with('+');
  const std::string_view number = picture.substr(is_signed ? 1 : 0);
  const std::size_t point = number.find('.');
  const std::string_view whole = number.substr(0, point);
  const std::string_view decimals =
      point == std::string_view::npos ? std::string_view{} : number.substr(point + 1);
  const bool has_zeros =
      ConsistsOf(whole, '0') && (point == std::string_view::npos || ConsistsOf(decimals, '0'));
  // at most 9 digits together: the counts are 32 bits
  if (!has_zeros || whole.size() + decimals.size() > kMostDigits) {
    return Usage("<format>",
                 fmt::format("\"{}\" is not a picture of a number of 1 to 9 digits", picture),
                 std::string(kFormatRemedy));
  }
  format.sign = is_signed ? SignRule::kAlways : SignRule::kNever;
  format.whole_digits = static_cast<int>(whole.size());
  format.decimals = static_cast<int>(decimals.size());
  return {};
}

// "000,+00.0000": a line counter, where there is one, and the number
Result<void> ReadPictures(std::string_view pictures, StreamFormat& format) {
  // the first separator ends the counter; without one, the picture is the number alone
  const std::size_t mark = pictures.find_first_of(kSeparators);
  if (mark == std::string_view::npos) return ReadPicture(pictures, format);
  const std::string_view counter = pictures.substr(0, mark);
  if (!ConsistsOf(counter, '0') || counter.size() > kMostDigits) {
    return Usage("<format>",
                 fmt::format("\"{}\" is not a picture of a line counter of 1 to 9 digits", counter),
                 "write e.g. 000,+00.0000,mm,CR");
  }
  format.counter_digits = static_cast<int>(counter.size());
  format.separator = pictures[mark];
  return ReadPicture(pictures.substr(mark + 1), format);
}

// "mm" is one millimetre, "0.1um" a tenth of a micrometre
Result<double> ReadUnit(std::string_view unit) {
  // "mm" is completed to "1 mm"
  const bool has_number = !unit.empty() && (unit[0] == '.' || (unit[0] >= '0' && unit[0] <= '9'));
  const std::string text = (has_number ? "" : "1 ") + std::string(unit);
  HAPTOMETER_LET(const Quantity quantity, ParseQuantity(text, Dimension::kLength, "<format>"));
  if (!(quantity.value > 0)) return Usage("<format>", "the unit must be a length above 0");
  return quantity.value;
}

Result<Delimiter> ReadDelimiter(std::string_view word) {
  if (word == "CR") return Delimiter::kCr;
  if (word == "LF") return Delimiter::kLf;
  if (word == "CRLF") return Delimiter::kCrLf;
  return Usage("<format>", fmt::format("\"{}\" is not a delimiter", word), "use CR, LF or CRLF");
}

}  // namespace

Result<StreamFormat> ParseStreamFormat(std::string_view text) {
  // from the right: the picture itself may hold a comma behind the counter
  const std::size_t second = text.rfind(',');
  const std::size_t first = second == std::string_view::npos || second == 0
                                ? std::string_view::npos
                                : text.rfind(',', second - 1);
  if (first == std::string_view::npos) {
    return Usage("<format>", fmt::format("\"{}\" has not three parts", text),
                 std::string(kFormatRemedy));
  }
  StreamFormat format;
  HAPTOMETER_TRY(ReadPictures(text.substr(0, first), format));
  HAPTOMETER_LET(format.unit_m, ReadUnit(text.substr(first + 1, second - first - 1)));
  HAPTOMETER_LET(format.delimiter, ReadDelimiter(text.substr(second + 1)));
  return format;
}

std::int32_t CounterTurn(const StreamFormat& format) { return PowerOfTen(format.counter_digits); }

std::size_t LineWidth(const StreamFormat& format) {
  return CounterWidth(format) + NumberWidth(format) + (format.sign == SignRule::kAlways ? 1 : 0);
}

std::size_t LineBytes(const StreamFormat& format) {
  return LineWidth(format) + Bytes(format.delimiter).size();
}

// one count is one unit of the last decimal, in m
double MetresPerCount(const StreamFormat& format) {
  return format.unit_m / PowerOfTen(format.decimals);
}

// all digits 9
std::int32_t MostCounts(const StreamFormat& format) {
  return PowerOfTen(format.whole_digits + format.decimals) - 1;
}

// rate = baud / (bytes per line * bits per character)
double MostLinesPerSecond(const StreamFormat& format, int baud) {
  HAPTOMETER_CHECK(baud > 0, "baud = {}", baud);
  return static_cast<double>(baud) /
         (static_cast<double>(LineBytes(format)) * static_cast<double>(kBitsPerCharacter));
}

std::optional<Value> ParseStreamLine(const StreamFormat& format, std::string_view line) {
  // lines have a fixed width: any other length is a damaged line
  if (line.size() != LineWidth(format)) return std::nullopt;
  // the counter
  if (format.counter_digits > 0) {
    const auto digits = static_cast<std::size_t>(format.counter_digits);
    if (line[digits] != format.separator || !ParseDigits(line.substr(0, digits))) {
      return std::nullopt;
    }
    line.remove_prefix(digits + 1);
  }
  // X or - in all places: no valid value
  if (ConsistsOf(line, 'X') || ConsistsOf(line, '-')) {
    return Value{kNoCounts, format.decimals, trial::SampleStatus::kInvalid};
  }
  // the sign
  char sign = 0;
  if (format.sign == SignRule::kAlways) {
    sign = line[0];
    if (sign != '+' && sign != '-') return std::nullopt;
    line.remove_prefix(1);
  }
  // F in all digits: beyond the range, the sign states which side
  if (ConsistsOf(line, 'F')) {
    return Value{kNoCounts, format.decimals,
                 sign == '-' ? trial::SampleStatus::kUnder : trial::SampleStatus::kOver};
  }
  // the digits on both sides of the point
  std::string digits(line.substr(0, static_cast<std::size_t>(format.whole_digits)));
  if (format.decimals > 0) {
    if (line[digits.size()] != '.') return std::nullopt;
    digits.append(line.substr(digits.size() + 1));
  }
  const std::optional<std::int32_t> size = ParseDigits(digits);
  if (!size) return std::nullopt;
  // all digits 9: at the end of what a line can hold, as the Keyence units send it
  const bool is_most = *size == MostCounts(format);
  if (sign == '-') {
    return Value{-*size, format.decimals,
                 is_most ? trial::SampleStatus::kUnder : trial::SampleStatus::kOk};
  }
  return Value{*size, format.decimals,
               is_most ? trial::SampleStatus::kOver : trial::SampleStatus::kOk};
}

// number of the line, modulo CounterTurn()
std::int32_t LineCount(const StreamFormat& format, std::string_view line) {
  const auto digits = static_cast<std::size_t>(format.counter_digits);
  const std::optional<std::int32_t> count = ParseDigits(line.substr(0, digits));
  HAPTOMETER_CHECK(count.has_value(), "line \"{}\" has no counter", line);
  return *count;
}

namespace {

// a line's value with its delimiter, without a counter
std::string FormatValue(const StreamFormat& format, const Value& value) {
  const std::string_view end = Bytes(format.delimiter);
  const bool is_signed = format.sign == SignRule::kAlways;
  const bool is_number = trial::IsMeasurement(value.status);
  const std::int32_t most = MostCounts(format);
  // without a sign, negative numbers cannot be sent
  const std::int32_t least = is_signed ? -most : 0;
  // letters where there is no number to send, or none that fits
  const bool over =
      value.status == trial::SampleStatus::kOver || (is_number && value.counts > most);
  const bool under =
      value.status == trial::SampleStatus::kUnder || (is_number && value.counts < least);
  if (over || under) {
    const std::string sign = is_signed ? (over ? "+" : "-") : "";
    return sign + std::string(NumberWidth(format), 'F').append(end);
  }
  if (!is_number) return std::string(LineWidth(format) - CounterWidth(format), 'X').append(end);
  // sign, digits, point
  const std::string digits =
      fmt::format("{:0{}}", std::abs(value.counts), format.whole_digits + format.decimals);
  std::string line = is_signed ? (value.counts < 0 ? "-" : "+") : "";
  line.append(digits, 0, static_cast<std::size_t>(format.whole_digits));
  if (format.decimals > 0) {
    line.append(".").append(digits, static_cast<std::size_t>(format.whole_digits));
  }
  return line.append(end);
}

}  // namespace

std::string FormatStreamLine(const StreamFormat& format, const Value& value, std::int64_t number) {
  if (format.counter_digits == 0) return FormatValue(format, value);
  // the counter starts again at 0 after all digits are 9
  return fmt::format("{:0{}}{}{}", number % CounterTurn(format), format.counter_digits,
                     format.separator, FormatValue(format, value));
}

}  // namespace haptometer::acquire
