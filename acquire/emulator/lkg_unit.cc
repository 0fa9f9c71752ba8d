#include "acquire/emulator/lkg_unit.h"

#include <cmath>
#include <utility>

#include "acquire/protocol/wire.h"

namespace haptometer::acquire::emulator {
namespace {

using lkg::Command;
using trial::SampleStatus;

}  // namespace

Result<void> Validate(const LkgSetup& setup) {
  if (setup.baud < 1) return Usage("<baud>", "must be above 0", "give 9600");
  if (setup.heads.empty() || setup.heads.size() > lkg::kMostOuts) {
    return Usage("<amplifiers>", "an LK-G3001 has one or two heads", "give 1 or 2");
  }
  return {};
}

LkgUnit::LkgUnit(LkgSetup setup)
    : AskedUnit(setup.baud, lkg::kLongestLine, lkg::kLineEnd, setup.faults),
      setup_(std::move(setup)) {}

MonotonicNs LkgUnit::ProcessingNs(std::string_view /*line*/) const { return setup_.processing_ns; }

std::string LkgUnit::AnswerToOverlong(std::string_view line) const {
  return lkg::FormatErrorReply(line.substr(0, 2), lkg::kCommandLength);
}

std::string LkgUnit::AnswerTo(std::string_view line, MonotonicNs now, const Fault* fault) {
  const std::string_view word = line.substr(0, 2);
  // an injected refusal, with the requested number or "another error"
  if (fault != nullptr && fault->refuses) {
    return lkg::FormatErrorReply(word, faults().error_number.value_or(lkg::kOther));
  }
  const auto command = lkg::ParseRequest(line);
  if (!command) return lkg::FormatErrorReply(word, lkg::kInvalidCommand);
  // Q0 enters the communication mode, R0 leaves it
  if (*command == Command::kQ0 || *command == Command::kR0) {
    setup_.in_communication_mode = *command == Command::kQ0;
    return lkg::FormatReply(*command, {});
  }
  // no measured values in communication mode
  if (setup_.in_communication_mode) return lkg::FormatErrorReply(word, lkg::kStatus);
  // wrong_id: the answer of the other output
  Command answered = *command;
  if (fault != nullptr && fault->wrong_id) {
    answered = *command == Command::kM1 ? Command::kM2 : Command::kM1;
  }
  std::vector<Value> values;
  // M0 has both outputs, M1 the first, M2 the second
  if (answered != Command::kM2) values.push_back(ValueOf(0, now, fault));
  if (answered != Command::kM1) values.push_back(ValueOf(1, now, fault));
  return lkg::FormatReply(answered, values);
}

Value LkgUnit::ValueOf(std::size_t out, MonotonicNs now, const Fault* fault) const {
  // no head at this output
  if (out >= setup_.heads.size()) return {.status = SampleStatus::kInvalid};
  const MovingHead& head = setup_.heads[out];
  const trial::HeadReading reading = head.Reading(head.LastSample(now));
  const double steps_per_m = 1e3 * PowerOfTen(setup_.decimals);
  // seven characters with the point: six digits, or seven without decimals
  const std::int32_t most = PowerOfTen(setup_.decimals == 0 ? 7 : 6) - 1;
  Value value{.counts = static_cast<std::int32_t>(std::lround(steps_per_m * reading.value_m)),
              .decimals = setup_.decimals,
              .status = reading.status};
  // beyond the display
  if (value.counts > most) value.status = SampleStatus::kOver;
  if (value.counts < -most) value.status = SampleStatus::kUnder;
  if (fault != nullptr && fault->status != SampleStatus::kOk) value.status = fault->status;
  return value;
}

}  // namespace haptometer::acquire::emulator
