#include "acquire/protocol/keyence/dl_rs1a.h"

#include <fmt/core.h>

#include <array>
#include <cstdlib>

#include "acquire/protocol/digits.h"
#include "base/error.h"

namespace haptometer::acquire::dl_rs1a {
namespace {

constexpr std::size_t kValueWidth = 7;  // sign, five digits, point
constexpr std::int32_t kMostCounts = 99'999;
constexpr std::int32_t kInvalidCounts = -99'998;
constexpr std::array kCommands = {Command::kM0, Command::kMs, Command::kSr, Command::kSw,
                                  Command::kAw};

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

const dl::Spelling& Spelling() {
  static constexpr dl::Spelling kSpelling{.parse_value = ParseValue,
                                          .format_value = FormatValue,
                                          .commands = kCommands,
                                          .error_digits = 2,
                                          .invalid_command = kInvalidCommand,
                                          .parameter_count = kParameterCount,
                                          .parameter = kParameter};
  return kSpelling;
}

ParsedRequest ParseRequest(std::string_view line) { return dl::ParseRequest(Spelling(), line); }

std::optional<Reply> ParseReply(std::string_view line) { return dl::ParseReply(Spelling(), line); }

std::string FormatM0Reply(std::span<const Value> values) {
  return dl::FormatM0Reply(Spelling(), values);
}

std::string FormatMsReply(std::span<const int> outputs, std::span<const Value> values) {
  return dl::FormatMsReply(Spelling(), outputs, values);
}

std::string FormatSrReply(int unit, int number, std::string_view data) {
  return dl::FormatDataReply(Command::kSr, unit, number, data);
}

std::string FormatErrorReply(const Refusal& refusal) {
  return dl::FormatErrorReply(Spelling(), refusal);
}

}  // namespace haptometer::acquire::dl_rs1a
