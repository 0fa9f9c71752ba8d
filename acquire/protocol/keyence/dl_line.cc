#include "acquire/protocol/keyence/dl_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>

#include "base/error.h"
#include "base/names.h"

namespace haptometer::acquire {

// splits a line at its commas; more than kMost fields are marked as too many
Fields::Fields(std::string_view line) {
  while (size_ < kMost) {
    const std::size_t comma = line.find(',');
    fields_[size_++] = line.substr(0, comma);
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
  too_many_ = true;
}

}  // namespace haptometer::acquire

namespace haptometer::acquire::dl {
namespace {

constexpr std::size_t kMostData = 10;  // characters of a reply's data

std::optional<Command> CommandOf(const Spelling& spelling, std::string_view word) {
  const auto known = std::ranges::find(spelling.commands, word, Name);
  return known == spelling.commands.end() ? std::nullopt : std::optional(*known);
}

// fields of a request, with the command itself
std::size_t FieldsOf(Command command) {
  switch (command) {
    case Command::kM0:
    case Command::kMs:
      return 1;
    case Command::kSr:
    case Command::kAw:
    case Command::kFr:
      return 3;
    case Command::kSw:
      return 4;
  }
  return 0;
}

// commands that address one amplifier
bool HasUnit(Command command) {
  return command == Command::kSr || command == Command::kSw || command == Command::kFr;
}

// a field of exactly `width` digits
std::optional<int> FixedDigits(std::string_view field, std::size_t width) {
  return field.size() == width ? ParseDigits(field) : std::nullopt;
}

bool IsPrintable(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

// values without outputs: M0,v0,v1,...
bool ReadValues(const Spelling& spelling, std::span<const std::string_view> fields, Reply& reply) {
  if (fields.empty() || fields.size() > kMostUnits) return false;
  for (const std::string_view field : fields) {
    const std::optional<Value> value = spelling.parse_value(field);
    if (!value) return false;
    reply.values[reply.units++] = *value;
  }
  return true;
}

// pairs of output and value: MS,o0,v0,o1,v1,...
bool ReadPairs(const Spelling& spelling, std::span<const std::string_view> fields, Reply& reply) {
  if (fields.empty() || fields.size() % 2 != 0 || fields.size() > 2 * kMostUnits) return false;
  for (std::size_t i = 0; i < fields.size(); i += 2) {
    const std::optional<int> output = fields[i].size() <= 2 ? ParseDigits(fields[i]) : std::nullopt;
    const std::optional<Value> value = spelling.parse_value(fields[i + 1]);
    if (!output || !value) return false;
    reply.outputs[reply.units] = *output;
    reply.values[reply.units++] = *value;
  }
  return true;
}

// what a direct command was about: SR,ii,ddd,data  SW,ii,ddd  AW,ddd
bool ReadDirect(Command command, std::span<const std::string_view> fields, Reply& reply) {
  const bool has_unit = HasUnit(command);
  const bool has_data = command == Command::kSr || command == Command::kFr;
  // fields behind the command
  const std::size_t size = 1 + (has_unit ? 1U : 0U) + (has_data ? 1U : 0U);
  if (fields.size() != size) return false;
  // identification number of 2 digits, data number of 3
  const std::optional<int> unit = has_unit ? FixedDigits(fields[0], 2) : std::optional(0);
  const std::optional<int> number = FixedDigits(fields[has_unit ? 1 : 0], 3);
  if (!unit || !number) return false;
  reply.unit = *unit;
  reply.number = *number;
  if (has_data) reply.data = fields.back();
  return reply.data.size() <= kMostData && IsPrintable(reply.data);
}

// ER,CC,nn: command and error number
bool ReadError(const Spelling& spelling, std::span<const std::string_view> fields, Reply& reply) {
  if (fields.size() != 2 || !IsPrintable(fields[0])) return false;
  const std::optional<int> number = FixedDigits(fields[1], spelling.error_digits);
  if (!number) return false;
  reply.data = fields[0];
  reply.number = *number;
  return true;
}

// a command's own reply
ReplyKind KindOf(Command command) { return static_cast<ReplyKind>(command); }
static_assert(static_cast<int>(ReplyKind::kM0) == static_cast<int>(Command::kM0) &&
              static_cast<int>(ReplyKind::kFr) == static_cast<int>(Command::kFr));

}  // namespace

std::string_view Name(Command command) {
  constexpr Names<Command, 6> kNames{{"M0", "MS", "SR", "SW", "AW", "FR"}};
  return kNames.Of(command);
}

ParsedRequest ParseRequest(const Spelling& spelling, std::string_view line) {
  const Fields fields(line);
  // checked in this order: command, number of fields, their content
  ParsedRequest parsed{.request = std::nullopt, .refusal = {fields[0], spelling.invalid_command}};
  const std::optional<Command> command = CommandOf(spelling, fields[0]);
  if (!command) return parsed;
  if (fields.too_many() || fields.size() != FieldsOf(*command)) {
    parsed.refusal.number = spelling.parameter_count;
    return parsed;
  }
  // the fields behind the command, by position: SR,ii,ddd  SW,ii,ddd,data  AW,ddd,data
  Request request;
  request.command = *command;
  parsed.refusal.number = spelling.parameter;
  std::size_t next = 1;
  if (HasUnit(*command)) {
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

// a request with its line end; numbers have fixed widths
std::string FormatRequest(const Request& request) {
  const std::string_view name = Name(request.command);
  switch (request.command) {
    case Command::kM0:
    case Command::kMs:
      return fmt::format("{}{}", name, kLineEnd);
    case Command::kSr:
    case Command::kFr:
      return fmt::format("{},{:02},{:03}{}", name, request.unit, request.number, kLineEnd);
    case Command::kSw:
      return fmt::format("{},{:02},{:03},{}{}", name, request.unit, request.number, request.data,
                         kLineEnd);
    case Command::kAw:
      return fmt::format("{},{:03},{}{}", name, request.number, request.data, kLineEnd);
  }
  return {};
}

std::optional<Reply> ParseReply(const Spelling& spelling, std::string_view line) {
  const Fields fields(line);
  if (fields.too_many()) return std::nullopt;
  const std::span<const std::string_view> rest = fields.Rest();
  Reply reply;
  bool valid = false;
  // ER: error; DR: sent without request; else the command itself
  if (fields[0] == "ER") {
    reply.kind = ReplyKind::kError;
    valid = ReadError(spelling, rest, reply);
  } else if (fields[0] == "DR") {
    reply.kind = ReplyKind::kDr;
    valid = ReadPairs(spelling, rest, reply);
  } else if (const auto command = CommandOf(spelling, fields[0])) {
    reply.kind = KindOf(*command);
    if (command == Command::kM0) {
      valid = ReadValues(spelling, rest, reply);
    } else if (command == Command::kMs) {
      valid = ReadPairs(spelling, rest, reply);
    } else {
      valid = ReadDirect(*command, rest, reply);
    }
  }
  return valid ? std::optional(reply) : std::nullopt;
}

// values in the order of the amplifiers
std::string FormatM0Reply(const Spelling& spelling, std::span<const Value> values) {
  std::string line = "M0";
  for (const Value& value : values) line.append(",").append(spelling.format_value(value));
  return line.append(kLineEnd);
}

std::string FormatMsReply(const Spelling& spelling, std::span<const int> outputs,
                          std::span<const Value> values) {
  HAPTOMETER_CHECK(outputs.size() == values.size(), "{} outputs for {} values", outputs.size(),
                   values.size());
  std::string line = "MS";
  for (std::size_t i = 0; i < values.size(); ++i) {
    line += fmt::format(",{:02},{}", outputs[i], spelling.format_value(values[i]));
  }
  return line.append(kLineEnd);
}

std::string FormatDataReply(Command command, int unit, int number, std::string_view data) {
  HAPTOMETER_CHECK(data.size() <= kMostData, "data = {}", data);
  return fmt::format("{},{:02},{:03},{}{}", Name(command), unit, number, data, kLineEnd);
}

std::string FormatWriteReply(const Request& request) {
  const std::string_view name = Name(request.command);
  return HasUnit(request.command)
             ? fmt::format("{},{:02},{:03}{}", name, request.unit, request.number, kLineEnd)
             : fmt::format("{},{:03}{}", name, request.number, kLineEnd);
}

std::string FormatErrorReply(const Spelling& spelling, const Refusal& refusal) {
  return fmt::format("ER,{},{:0{}}{}", refusal.command, refusal.number, spelling.error_digits,
                     kLineEnd);
}

// an integer with optional sign; nothing where other characters follow
std::optional<int> NumberOf(std::string_view data) {
  if (data.starts_with('+')) data.remove_prefix(1);
  int number = 0;
  const auto [end, error] = std::from_chars(data.data(), data.data() + data.size(), number);
  if (error != std::errc{} || end != data.data() + data.size()) return std::nullopt;
  return number;
}

bool Answers(const Reply& reply, Command command) {
  // an error reply repeats the command, possibly with bytes of an earlier one before it
  return reply.kind == KindOf(command) ||
         (reply.kind == ReplyKind::kError && reply.data.ends_with(Name(command)));
}

}  // namespace haptometer::acquire::dl
