#include "acquire/protocol/dl_rs1a.h"

#include <fmt/core.h>

#include <cstdlib>
#include <vector>

#include "acquire/protocol/digits.h"
#include "base/check.h"

namespace haptometer::acquire::dl_rs1a {
namespace {

constexpr std::size_t kValueWidth = 7;  // sign, five digits, point
constexpr std::int32_t kMostCounts = 99'999;
constexpr std::int32_t kInvalidCounts = -99'998;
constexpr std::size_t kMostData = 10;  // characters of an SR reply's data

// the fields of a line: "a,b,,c" -> a, b, "", c
std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

// a field of exactly `width` digits
std::optional<int> FixedDigits(std::string_view field, std::size_t width) {
  return field.size() == width ? ParseDigits(field) : std::nullopt;
}

bool IsPrintable(std::string_view text) {
  for (const char character : text) {
    if (character < ' ' || character > '~') return false;
  }
  return true;
}

trial::SampleStatus StatusOf(std::int32_t counts) {
  if (counts == kMostCounts) return trial::SampleStatus::kOver;
  if (counts == -kMostCounts) return trial::SampleStatus::kUnder;
  if (counts == kInvalidCounts) return trial::SampleStatus::kInvalid;
  return trial::SampleStatus::kOk;
}

// "+01234" with the point put `decimals` places from the right
std::string WithPoint(char sign, std::string_view five, int decimals) {
  const std::size_t whole = five.size() - static_cast<std::size_t>(decimals);
  return fmt::format("{}{}.{}", sign, five.substr(0, whole), five.substr(whole));
}

std::optional<Command> CommandOf(std::string_view word) {
  if (word == "M0") return Command::kM0;
  if (word == "MS") return Command::kMs;
  if (word == "SR") return Command::kSr;
  if (word == "SW") return Command::kSw;
  if (word == "AW") return Command::kAw;
  return std::nullopt;
}

std::size_t FieldsOf(Command command) {
  switch (command) {
    case Command::kM0:
    case Command::kMs:
      return 1;
    case Command::kSr:
    case Command::kAw:
      return 3;
    case Command::kSw:
      return 4;
  }
  return 0;
}

// values without outputs: M0,v0,v1,...
bool ReadValues(std::span<const std::string_view> fields, Reply& reply) {
  if (fields.empty() || fields.size() > kMostUnits) return false;
  for (const std::string_view field : fields) {
    const std::optional<Value> value = ParseValue(field);
    if (!value) return false;
    reply.values[reply.units++] = *value;
  }
  return true;
}

// pairs of output and value: MS,o0,v0,o1,v1,...
bool ReadPairs(std::span<const std::string_view> fields, Reply& reply) {
  if (fields.empty() || fields.size() % 2 != 0 || fields.size() > 2 * kMostUnits) return false;
  for (std::size_t i = 0; i < fields.size(); i += 2) {
    const std::optional<int> output = fields[i].size() <= 2 ? ParseDigits(fields[i]) : std::nullopt;
    const std::optional<Value> value = ParseValue(fields[i + 1]);
    if (!output || !value) return false;
    reply.outputs[reply.units] = *output;
    reply.values[reply.units++] = *value;
  }
  return true;
}

bool ReadData(std::span<const std::string_view> fields, Reply& reply) {
  if (fields.size() != 3 || fields[2].size() > kMostData || !IsPrintable(fields[2])) return false;
  const std::optional<int> unit = FixedDigits(fields[0], 2);
  const std::optional<int> number = FixedDigits(fields[1], 3);
  if (!unit || !number) return false;
  reply.unit = *unit;
  reply.number = *number;
  reply.data = fields[2];
  return true;
}

bool ReadError(std::span<const std::string_view> fields, Reply& reply) {
  if (fields.size() != 2 || !IsPrintable(fields[0])) return false;
  const std::optional<int> number = FixedDigits(fields[1], 2);
  if (!number) return false;
  reply.data = fields[0];
  reply.number = *number;
  return true;
}

}  // namespace

std::optional<Value> ParseValue(std::string_view text) {
  if (text.size() != kValueWidth || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const std::size_t point = text.find('.');
  if (point == std::string_view::npos || point < 3 || point > 5) return std::nullopt;
  const std::string five = std::string(text.substr(1, point - 1)).append(text.substr(point + 1));
  const int decimals = static_cast<int>(kValueWidth - 1 - point);
  if (ConsistsOf(five, 'E')) return Value{kNoCounts, decimals, trial::SampleStatus::kDeviceError};
  const std::optional<std::int32_t> digits = ParseDigits(five);
  if (!digits) return std::nullopt;
  const std::int32_t counts = text[0] == '-' ? -*digits : *digits;
  return Value{counts, decimals, StatusOf(counts)};
}

std::string FormatValue(const Value& value) {
  HAPTOMETER_CHECK(value.decimals >= 1 && value.decimals <= 3, "decimals = {}", value.decimals);
  switch (value.status) {
    case trial::SampleStatus::kOver:
      return WithPoint('+', "99999", value.decimals);
    case trial::SampleStatus::kUnder:
      return WithPoint('-', "99999", value.decimals);
    case trial::SampleStatus::kDeviceError:
      return WithPoint('+', "EEEEE", value.decimals);
    case trial::SampleStatus::kOk:
    case trial::SampleStatus::kRepeated:
      break;
    default:
      return WithPoint('-', "99998", value.decimals);
  }
  const std::int32_t size = std::abs(value.counts);
  HAPTOMETER_CHECK(size <= kMostCounts, "counts = {}", value.counts);
  return WithPoint(value.counts < 0 ? '-' : '+', fmt::format("{:05}", size), value.decimals);
}

ParsedRequest ParseRequest(std::string_view line) {
  const std::vector<std::string_view> fields = Split(line);
  ParsedRequest parsed{.request = std::nullopt, .refusal = {fields[0], kInvalidCommand}};
  const std::optional<Command> command = CommandOf(fields[0]);
  if (!command) return parsed;
  if (fields.size() != FieldsOf(*command)) {
    parsed.refusal.number = kParameterCount;
    return parsed;
  }
  // the fields behind the command, by position: SR,ii,ddd  SW,ii,ddd,data  AW,ddd,data
  Request request;
  request.command = *command;
  parsed.refusal.number = kParameter;
  std::size_t next = 1;
  if (*command == Command::kSr || *command == Command::kSw) {
    const std::optional<int> unit = FixedDigits(fields[next++], 2);
    if (!unit) return parsed;
    request.unit = *unit;
  }
  if (next < fields.size()) {
    const std::optional<int> number = FixedDigits(fields[next++], 3);
    if (!number) return parsed;
    request.number = *number;
  }
  if (next < fields.size()) request.data = fields[next];
  parsed.request = request;
  return parsed;
}

std::string FormatRequest(const Request& request) {
  switch (request.command) {
    case Command::kM0:
      return fmt::format("M0{}", kLineEnd);
    case Command::kMs:
      return fmt::format("MS{}", kLineEnd);
    case Command::kSr:
      return fmt::format("SR,{:02},{:03}{}", request.unit, request.number, kLineEnd);
    case Command::kSw:
      return fmt::format("SW,{:02},{:03},{}{}", request.unit, request.number, request.data,
                         kLineEnd);
    case Command::kAw:
      return fmt::format("AW,{:03},{}{}", request.number, request.data, kLineEnd);
  }
  return {};
}

std::optional<Reply> ParseReply(std::string_view line) {
  const std::vector<std::string_view> fields = Split(line);
  const std::span<const std::string_view> rest = std::span(fields).subspan(1);
  Reply reply;
  bool valid = false;
  if (fields[0] == "M0") {
    valid = ReadValues(rest, reply);
  } else if (fields[0] == "MS" || fields[0] == "DR") {
    reply.kind = fields[0] == "MS" ? ReplyKind::kMs : ReplyKind::kDr;
    valid = ReadPairs(rest, reply);
  } else if (fields[0] == "SR") {
    reply.kind = ReplyKind::kSr;
    valid = ReadData(rest, reply);
  } else if (fields[0] == "ER") {
    reply.kind = ReplyKind::kError;
    valid = ReadError(rest, reply);
  }
  return valid ? std::optional(reply) : std::nullopt;
}

std::string FormatM0Reply(std::span<const Value> values) {
  std::string line = "M0";
  for (const Value& value : values) line.append(",").append(FormatValue(value));
  return line.append(kLineEnd);
}

std::string FormatMsReply(std::span<const int> outputs, std::span<const Value> values) {
  HAPTOMETER_CHECK(outputs.size() == values.size(), "{} outputs for {} values", outputs.size(),
                   values.size());
  std::string line = "MS";
  for (std::size_t i = 0; i < values.size(); ++i) {
    line += fmt::format(",{:02},{}", outputs[i], FormatValue(values[i]));
  }
  return line.append(kLineEnd);
}

std::string FormatSrReply(int unit, int number, std::string_view data) {
  HAPTOMETER_CHECK(data.size() <= kMostData, "data = {}", data);
  return fmt::format("SR,{:02},{:03},{}{}", unit, number, data, kLineEnd);
}

std::string FormatErrorReply(const Refusal& refusal) {
  return fmt::format("ER,{},{:02}{}", refusal.command, refusal.number, kLineEnd);
}

}  // namespace haptometer::acquire::dl_rs1a
