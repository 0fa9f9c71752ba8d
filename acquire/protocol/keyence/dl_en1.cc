#include "acquire/protocol/keyence/dl_en1.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "base/error.h"

namespace haptometer::acquire::dl_en1 {
namespace {

using dl::Command;
using trial::SampleStatus;

// sign and nine digits, without a point
constexpr std::size_t kDigits = 9;
constexpr std::int32_t kMostCounts = 999'999'999;

constexpr std::array kCommands = {Command::kM0, Command::kMs, Command::kSr, Command::kSw,
                                  Command::kFr};
// of one to eight amplifiers
constexpr std::array<MonotonicNs, 8> kRefreshes_ns = {
    kRefreshNs, 9'800'000, 13'800'000, 15'800'000, 19'800'000, 21'800'000, 25'800'000, 27'800'000};

// the counts that stand for no measurement: `most` is the display's largest number
SampleStatus StatusOf(std::int32_t counts, std::int32_t most) {
  if (counts == most) return SampleStatus::kOver;
  if (counts == -most) return SampleStatus::kUnder;
  if (counts == -(most - 1)) return SampleStatus::kInvalid;
  if (counts == most + 1) return SampleStatus::kDeviceError;
  return SampleStatus::kOk;
}

// the inverse
std::string Formatted(const Value& value, std::int32_t most) {
  switch (value.status) {
    case SampleStatus::kOver:
      return FormatNumber(most);
    case SampleStatus::kUnder:
      return FormatNumber(-most);
    case SampleStatus::kDeviceError:
      return FormatNumber(most + 1);
    case SampleStatus::kOk:
    case SampleStatus::kRepeated:
      return FormatNumber(value.counts);
    default:
      return FormatNumber(-(most - 1));
  }
}

// specials of the communication unit, in its nine digits
constexpr std::int32_t kUnitsMost = 99'999'999;
// specials of the IL display, in five digits
constexpr std::int32_t kIlMost = 99'999;

}  // namespace

std::string WithPort(std::string_view host) {
  // a second colon outside of brackets: an IPv6 address, whose last colon is no port
  const std::size_t colon = host.find(':');
  const bool is_bare_ipv6 = colon != std::string_view::npos && host.front() != '[' &&
                            host.find(':', colon + 1) != std::string_view::npos;
  if (is_bare_ipv6) return fmt::format("[{}]:{}", host, kPort);
  // [::1] without a port ends in a bracket
  const bool has_port = host.front() == '[' ? !host.ends_with(']') : colon != host.npos;
  const bool is_path = host.find('/') != std::string_view::npos;
  return has_port || is_path ? std::string(host) : fmt::format("{}:{}", host, kPort);
}

std::string_view ErrorText(int number) {
  static constexpr ErrorWords kErrors[] = {
      {kOutOfRange, "the data is out of range"},
      {kNotExecutable, "it cannot be done now"},
      {kWriteProtected, "the data cannot be written"},
      {kReadProtected, "the data cannot be read"},
      {kDataNumber, "no data has this number"},
      {kUnitNumber, "no amplifier has this identification number"},
      {kMode, "the unit is in another mode"},
      {kStarting, "the unit or an amplifier is still starting"},
      {kFormat, "the command is not one of the unit's"},
  };
  return ErrorTextIn(kErrors, number);
}

std::optional<Value> ParseValue(std::string_view text) {
  if (text.size() != 1 + kDigits || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const std::optional<std::int32_t> size = ParseDigits(text.substr(1));
  if (!size) return std::nullopt;
  // no decimals: their number comes from elsewhere (FR, the head, or the user)
  const std::int32_t counts = text[0] == '-' ? -*size : *size;
  return Value{counts, 0, StatusOf(counts, kUnitsMost)};
}

std::string FormatValue(const Value& value) { return Formatted(value, kUnitsMost); }

std::string FormatIlValue(const Value& value) { return Formatted(value, kIlMost); }

// a number of the unit may still be a special of the amplifier
Value WithIlSpecials(Value value) {
  if (value.status == SampleStatus::kOk) value.status = StatusOf(value.counts, kIlMost);
  return value;
}

std::string FormatNumber(std::int32_t number) {
  HAPTOMETER_CHECK(number >= -kMostCounts && number <= kMostCounts, "number = {}", number);
  return fmt::format("{}{:09}", number < 0 ? '-' : '+', std::abs(number));
}

const dl::Spelling& Spelling() {
  static constexpr dl::Spelling kSpelling{.parse_value = ParseValue,
                                          .format_value = FormatValue,
                                          .commands = kCommands,
                                          .error_digits = 3,
                                          .invalid_command = kFormat,
                                          .parameter_count = kFormat,
                                          .parameter = kFormat};
  return kSpelling;
}

// more amplifiers than in the table: the longest refresh
MonotonicNs RefreshNs(std::size_t units) {
  const std::size_t amplifiers = std::clamp<std::size_t>(units, 1, kRefreshes_ns.size());
  return kRefreshes_ns[amplifiers - 1];
}

}  // namespace haptometer::acquire::dl_en1
