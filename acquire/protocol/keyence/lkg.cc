#include "acquire/protocol/keyence/lkg.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>

#include "acquire/protocol/keyence/dl_line.h"
#include "base/error.h"
#include "base/names.h"

namespace haptometer::acquire::lkg {
namespace {

using trial::SampleStatus;

constexpr std::size_t kValueWidth = 8;  // sign and seven characters
// display: seven characters with the point, at least one digit before it
constexpr int kMostDecimals = 5;
constexpr std::array kCommands = {Command::kM0, Command::kM1, Command::kM2, Command::kQ0,
                                  Command::kR0};

// the controller accepts small letters too
char Upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

bool SameWord(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return Upper(x) == Upper(y); });
}

// values behind the command, in the order of the outputs
bool ReadValues(std::span<const std::string_view> fields, Reply& reply) {
  if (fields.size() > kMostOuts) return false;
  for (const std::string_view field : fields) {
    const std::optional<Value> value = ParseValue(field);
    if (!value) return false;
    reply.values[reply.outs++] = *value;
  }
  return true;
}

// ER,CC,nn
bool ReadError(std::span<const std::string_view> fields, Reply& reply) {
  if (fields.size() != 2 || fields[1].size() != 2) return false;
  const std::optional<int> number = ParseDigits(fields[1]);
  if (!number) return false;
  reply.kind = ReplyKind::kError;
  reply.refused = fields[0];
  reply.error = *number;
  return true;
}

}  // namespace

std::string_view Name(Command command) {
  constexpr Names<Command, 5> kNames{{"M0", "M1", "M2", "Q0", "R0"}};
  return kNames.Of(command);
}

// values in the reply to a command; Q0 and R0 have none
std::size_t ValuesOf(Command command) {
  if (command == Command::kM0) return 2;
  return command == Command::kM1 || command == Command::kM2 ? 1 : 0;
}

std::string_view ErrorText(int number) {
  static constexpr ErrorWords kErrors[] = {
      {kInvalidCommand, "the controller does not know the command"},
      {kStatus, "not in the controller's present mode"},
      {kCommandLength, "wrong length of the command"},
      {kParameterCount, "wrong number of parameters"},
      {kParameter, "a parameter is out of range"},
      {kTimeout, "the controller ran out of time"},
      {kOther, "another error"},
  };
  return ErrorTextIn(kErrors, number);
}

std::optional<Value> ParseValue(std::string_view text) {
  if (text.size() != kValueWidth) return std::nullopt;
  // all places X or -: no valid value
  if (ConsistsOf(text, 'X') || ConsistsOf(text, '-')) {
    return Value{kNoCounts, 0, SampleStatus::kInvalid};
  }
  const char sign = text[0];
  if (sign != '+' && sign != '-') return std::nullopt;
  text.remove_prefix(1);
  // F: beyond the range of the display, on the side of the sign
  if (ConsistsOf(text, 'F')) {
    return Value{kNoCounts, 0, sign == '-' ? SampleStatus::kUnder : SampleStatus::kOver};
  }
  // a point is optional, but not at either end
  const std::size_t point = text.find('.');
  if (point == 0 || point + 1 == text.size()) return std::nullopt;
  std::string digits(text.substr(0, point));
  if (point != std::string_view::npos) digits.append(text.substr(point + 1));
  const std::optional<std::int32_t> size = ParseDigits(digits);
  if (!size) return std::nullopt;
  const int decimals =
      point == std::string_view::npos ? 0 : static_cast<int>(text.size() - point - 1);
  return Value{sign == '-' ? -*size : *size, decimals, SampleStatus::kOk};
}

std::string FormatValue(const Value& value) {
  if (value.status == SampleStatus::kOver) return "+FFFFFFF";
  if (value.status == SampleStatus::kUnder) return "-FFFFFFF";
  if (!trial::IsMeasurement(value.status)) return std::string(kValueWidth, 'X');
  HAPTOMETER_CHECK(value.decimals >= 0 && value.decimals <= kMostDecimals, "decimals = {}",
                   value.decimals);
  // seven characters: the point takes the place of a digit
  const int digits = value.decimals == 0 ? 7 : 6;
  const std::int32_t size = std::abs(value.counts);
  HAPTOMETER_CHECK(size < PowerOfTen(digits), "counts = {}", value.counts);
  std::string text = fmt::format("{}{:0{}}", value.counts < 0 ? '-' : '+', size, digits);
  if (value.decimals > 0) text.insert(text.size() - static_cast<std::size_t>(value.decimals), ".");
  return text;
}

std::optional<Command> ParseRequest(std::string_view line) {
  const auto known = std::ranges::find_if(
      kCommands, [=](Command command) { return SameWord(Name(command), line); });
  return known == kCommands.end() ? std::nullopt : std::optional(*known);
}

std::string FormatRequest(Command command) { return fmt::format("{}{}", Name(command), kLineEnd); }

std::optional<Reply> ParseReply(std::string_view line) {
  const Fields fields(line);
  if (fields.too_many()) return std::nullopt;
  const std::span<const std::string_view> rest = fields.Rest();
  Reply reply;
  bool valid = false;
  if (fields[0] == "ER") {
    valid = ReadError(rest, reply);
  } else if (fields[0] == "G1" || fields[0] == "G2") {
    // lines without request, from the timing input
    reply.kind = ReplyKind::kOutput;
    valid = rest.size() == 1 && ReadValues(rest, reply);
  } else if (const std::optional<Command> command = ParseRequest(fields[0])) {
    reply.command = *command;
    valid = rest.size() == ValuesOf(*command) && ReadValues(rest, reply);
  }
  return valid ? std::optional(reply) : std::nullopt;
}

std::string FormatReply(Command command, std::span<const Value> values) {
  std::string line(Name(command));
  for (const Value& value : values) line.append(",").append(FormatValue(value));
  return line + kLineEnd;
}

std::string FormatErrorReply(std::string_view command, int number) {
  return fmt::format("ER,{},{:02}{}", command, number, kLineEnd);
}

bool Answers(const Reply& reply, Command command) {
  const std::string_view name = Name(command);
  // an error reply may hold bytes of an earlier command before its own name
  if (reply.kind == ReplyKind::kError) {
    const std::size_t before = reply.refused.size() - std::min(name.size(), reply.refused.size());
    return SameWord(reply.refused.substr(before), name);
  }
  return reply.kind == ReplyKind::kCommand && reply.command == command;
}

}  // namespace haptometer::acquire::lkg
