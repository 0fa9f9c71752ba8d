#include "acquire/emulator/fault.h"

#include <fmt/core.h>

#include <array>
#include <charconv>

#include "acquire/protocol/wire.h"

namespace haptometer::acquire::emulator {
namespace {

// By the makers a reply comes within 1 s; a host that has measured the unit waits less.
constexpr std::array kFaults = {
    Fault{.name = "silent", .summary = "no answer", .damage = Damage::kMissing},
    Fault{.name = "slow", .summary = "the answer comes after 0.4 s", .delay_ns = kNsPerS * 2 / 5},
    Fault{.name = "late", .summary = "the answer comes after 1.5 s", .delay_ns = 3 * kNsPerS / 2},
    Fault{.name = "byte-gap", .summary = "a pause of 0.3 s in it", .pause_ns = kNsPerS * 3 / 10},
    Fault{.name = "truncate", .summary = "half an answer", .damage = Damage::kTruncated},
    Fault{.name = "garbage", .summary = "noise for an answer", .damage = Damage::kGarbled},
    Fault{.name = "merged", .summary = "the answer comes with the next", .holds_back = true},
    Fault{.name = "wrong-id", .summary = "another amplifier's answer", .wrong_id = true},
    Fault{.name = "error",
          .summary = "the unit answers ER (error-NN: with that number), or Modbus exception 04",
          .refuses = true},
    Fault{.name = "invalid", .summary = "no target", .status = trial::SampleStatus::kInvalid},
    Fault{.name = "over", .summary = "beyond the range", .status = trial::SampleStatus::kOver},
    Fault{.name = "under", .summary = "below the range", .status = trial::SampleStatus::kUnder},
    Fault{.name = "amplifier-error",
          .summary = "the amplifier is broken",
          .status = trial::SampleStatus::kDeviceError},
    Fault{.name = "disconnect", .summary = "the line drops", .hangs_up = true},
    Fault{.name = "crc",
          .summary = "Modbus RTU: a wrong CRC",
          .damage = Damage::kWrongCrc,
          .is_modbus = true},
    Fault{.name = "slave",
          .summary = "Modbus: the answer of another slave",
          .damage = Damage::kWrongSlave,
          .is_modbus = true},
    Fault{.name = "transaction",
          .summary = "Modbus TCP: an identifier that is off by one",
          .damage = Damage::kWrongTransaction,
          .is_modbus = true},
    Fault{.name = "word-order",
          .summary = "Modbus: the value's words swapped",
          .damage = Damage::kSwappedWords,
          .is_modbus = true},
};

std::string KnownNames() {
  std::string names;
  for (const Fault& fault : kFaults) {
    if (!names.empty()) names += ", ";
    names += fault.name;
  }
  return names;
}

// the line's end: CR, LF or both
std::size_t BodySize(std::string_view answer) {
  const std::size_t last = answer.find_last_not_of("\r\n");
  return last == std::string_view::npos ? 0 : last + 1;
}

// "error-22": the name up to the number, and the number
struct Named {
  std::string_view name;
  std::optional<int> error_number{};
};

// a number behind "error-" is the error number of the reply
Named ReadName(std::string_view text) {
  constexpr std::string_view kNumbered = "error-";
  const auto number =
      text.starts_with(kNumbered) ? ParseDigits(text.substr(kNumbered.size())) : std::nullopt;
  if (!number) return {.name = text};
  return {.name = text.substr(0, kNumbered.size() - 1), .error_number = number};
}

}  // namespace

std::span<const Fault> Faults() { return kFaults; }

// faults that have an effect only on replies to requests
bool NeedsAQuestion(const Fault& fault) {
  return fault.refuses || fault.delay_ns > 0 || fault.pause_ns > 0 || fault.holds_back ||
         fault.wrong_id;
}

// each `every`-th answer, counted from 1
const Fault* FaultPlan::At(std::int64_t number) const {
  return fault != nullptr && number % every == 0 ? fault : nullptr;
}

Result<FaultPlan> ParseFaultPlan(std::string_view text) {
  const std::size_t colon = text.find(':');
  const auto [name, error_number] = ReadName(text.substr(0, colon));
  FaultPlan plan;
  plan.error_number = error_number;
  for (const Fault& fault : kFaults) {
    if (fault.name == name) plan.fault = &fault;
  }
  if (plan.fault == nullptr) {
    return Usage("<fault>", fmt::format("'{}' is not a fault", name),
                 fmt::format("give one of {}", KnownNames()));
  }
  if (colon == std::string_view::npos) return plan;

  // NAME:EVERY
  const std::string_view every = text.substr(colon + 1);
  const auto [stop, code] = std::from_chars(every.begin(), every.end(), plan.every);
  if (code != std::errc() || stop != every.end() || plan.every < 1) {
    return Usage("<fault>", fmt::format("'{}' does not state how often", every),
                 fmt::format("give {}:EVERY with a whole number from 1", name));
  }
  return plan;
}

std::string Damaged(std::string answer, Damage damage, std::int64_t number) {
  switch (damage) {
    case Damage::kNone:
    case Damage::kWrongCrc:
    case Damage::kWrongSlave:
    case Damage::kWrongTransaction:
    case Damage::kSwappedWords:
      break;
    case Damage::kMissing:
      answer.clear();
      break;
    case Damage::kTruncated:
      // half of the text, with no line end
      answer.resize(BodySize(answer) / 2);
      break;
    case Damage::kGarbled: {
      // bytes with the top bit set appear in no answer and end no line
      auto state = static_cast<std::uint32_t>(number);
      for (std::size_t i = 0; i < BodySize(answer); ++i) {
        // linear congruential generator (Numerical Recipes): the same noise in each run
        state = state * 1664525U + 1013904223U;
        answer[i] = static_cast<char>(0x80U | (state >> 24U));
      }
      break;
    }
  }
  return answer;
}

}  // namespace haptometer::acquire::emulator
