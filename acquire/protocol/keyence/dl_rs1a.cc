#include "acquire/protocol/keyence/dl_rs1a.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/error.h"

namespace haptometer::acquire::dl_rs1a {
namespace {

using dl::Command;

constexpr std::size_t kValueWidth = 7;  // sign, five digits, point
// -99998: invalid
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
  // two to four digits before the point, so 1 to 3 decimals
  const std::size_t point = text.find('.');
  if (point == std::string_view::npos || point < 3 || point > 5) return std::nullopt;
  const std::string five = std::string(text.substr(1, point - 1)).append(text.substr(point + 1));
  const int decimals = static_cast<int>(kValueWidth - 1 - point);
  // EEEEE: the amplifier reports an error
  if (ConsistsOf(five, 'E')) return Value{kNoCounts, decimals, trial::SampleStatus::kDeviceError};
  const std::optional<std::int32_t> digits = ParseDigits(five);
  if (!digits) return std::nullopt;
  // counts of the last decimal
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
    // every other status has no value: -99998
    default:
      return WithPoint('-', "99998", value.decimals);
  }
  const std::int32_t size = std::abs(value.counts);
  HAPTOMETER_CHECK(size <= kMostCounts, "counts = {}", value.counts);
  return WithPoint(value.counts < 0 ? '-' : '+', fmt::format("{:05}", size), value.decimals);
}

std::optional<int> ParseAnalogMv(std::string_view text) {
  constexpr std::size_t kWidth = 6;  // sign, digit, point, three digits
  if (text.size() != kWidth || (text[0] != '+' && text[0] != '-') || text[2] != '.') {
    return std::nullopt;
  }
  const auto mv = ParseDigits(std::string(text.substr(1, 1)).append(text.substr(3)));
  return mv && text[0] == '-' ? -*mv : mv;
}

std::string FormatAnalogMv(int mv) {
  HAPTOMETER_CHECK(std::abs(mv) <= 9999, "mv = {}", mv);
  return WithPoint(mv < 0 ? '-' : '+', fmt::format("{:04}", std::abs(mv)), 3);
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

// The maker's tables: what the numbers of the DL-RS1A and of the IL series mean.
namespace {

// codes of data 195; distances and linear ranges of the IL series catalogue (AS_98890_IL), 0 where
// it has none
constexpr std::array<Head, 9> kHeads = {{
    {1, "IL-030", 3, 30, 20, 45, 5},
    {2, "IL-065", 3, 65, 55, 105, 10},
    {3, "IL-100", 3, 100, 75, 130, 20},
    {4, "IL-300", 2, 300, 160, 450, 140},
    {5, "IL-600", 2, 600, 200, 1000, 400},
    {106, "IL-S025", 3, 25, 20, 30, 5},
    {107, "IL-S065", 3, 65, 0, 0, 0},
    {208, "IL-S100", 3, 100, 0, 0, 0},
    {311, "IL-2000", 1, 2000, 0, 0, 0},
}};

constexpr std::array<std::string_view, 6> kHolds = {"sample",       "peak",      "bottom",
                                                    "peak-to-peak", "auto peak", "auto bottom"};
constexpr std::array<double, 10> kHighPasses_hz = {0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100};
// T2 of one to eight amplifiers; kRefreshNs for one
constexpr std::array<MonotonicNs, 8> kRefreshes_ns = {
    kRefreshNs, 9'000'000, 13'000'000, 15'000'000, 19'000'000, 21'000'000, 25'000'000, 27'000'000};
// 2^12 = 4096 averages; codes above select filters
constexpr int kMostAveragingCode = 12;

}  // namespace

std::string_view ErrorText(int number) {
  static constexpr ErrorWords kErrors[] = {
      {kInvalidCommand, "the unit does not know the command"},
      {kDataLength, "the command was too long, or its end (CR) did not arrive"},
      {kParameterCount, "wrong number of parameters"},
      {kParameter,
       "a parameter is out of range or cannot be read, or the amplifier is still starting"},
      {kCommunication, "characters arrived damaged; check baud rate, parity and wiring"},
      {kUnitNumber, "no amplifier has this identification number"},
      {kExpansionLine,
       "the unit cannot communicate with the amplifier next to it; check the D-bus connectors"},
      {kWriteControl, "writing is locked; the unit's R/W switch is in position R"},
  };
  return ErrorTextIn(kErrors, number);
}

const Head* FindHead(int code) {
  const auto head = std::ranges::find(kHeads, code, &Head::code);
  return head == kHeads.end() ? nullptr : &*head;
}

const Head* FindHead(std::string_view name) {
  const auto head = std::ranges::find(kHeads, name, &Head::name);
  return head == kHeads.end() ? nullptr : &*head;
}

std::optional<double> SamplingSeconds(int code) {
  if (code < 1 || code > static_cast<int>(kSamplings_s.size())) return std::nullopt;
  return kSamplings_s[static_cast<std::size_t>(code - 1)];
}

std::optional<int> Averages(int code) {
  if (code < 0 || code > kMostAveragingCode) return std::nullopt;
  return 1 << code;
}

std::optional<int> SamplingCode(double sampling_s) {
  // a tolerance of 1 ns: 0.33 ms has no exact double
  const auto known = std::ranges::find_if(
      kSamplings_s, [=](double known_s) { return std::abs(known_s - sampling_s) < 1e-9; });
  if (known == kSamplings_s.end()) return std::nullopt;
  return 1 + static_cast<int>(known - kSamplings_s.begin());
}

std::optional<int> AveragingCode(int averages) {
  for (int code = 0; code <= kMostAveragingCode; ++code) {
    if (Averages(code) == averages) return code;
  }
  return std::nullopt;
}

std::string_view HoldName(int code) {
  if (code < 0 || code >= static_cast<int>(kHolds.size())) return "";
  return kHolds[static_cast<std::size_t>(code)];
}

std::optional<double> HighPassHz(int code) {
  if (code < 0 || code >= static_cast<int>(kHighPasses_hz.size())) return std::nullopt;
  return kHighPasses_hz[static_cast<std::size_t>(code)];
}

// wire time of request and reply, in ns, without processing: no reply comes sooner
MonotonicNs LeastExchangeNs(int baud, std::size_t units, Command command) {
  const std::size_t value_bytes = command == Command::kMs ? 10 : 8;
  return WireTimeNs(8 + value_bytes * units, baud);
}

// request, reply and the maker's processing time T4
MonotonicNs PollPeriodNs(int baud, std::size_t units, Command command) {
  constexpr std::size_t kRequestBytes = 4;  // M0 CR LF; the reply has 4, and 8 for each value
  const std::size_t value_bytes = command == Command::kMs ? 11 : 8;
  return WireTimeNs(kRequestBytes + 4 + value_bytes * units, baud) + kProcessingNs;
}

// more amplifiers than in the table: the longest refresh
MonotonicNs RefreshNs(std::size_t units) {
  const std::size_t amplifiers = std::clamp<std::size_t>(units, 1, kRefreshes_ns.size());
  return kRefreshes_ns[amplifiers - 1];
}

}  // namespace haptometer::acquire::dl_rs1a
