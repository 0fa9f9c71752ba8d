#include "acquire/sensor/keyence/il_poll.h"

#include "acquire/protocol/keyence/dl_en1.h"
#include "base/error.h"

namespace haptometer::acquire {

using dl::Command;
using dl::Reply;
using dl::ReplyKind;

IlPoll::IlPoll(const dl::Spelling& spelling, Command command)
    : spelling_(spelling),
      command_(command),
      step_command_(command == Command::kM0 ? Command::kMs : Command::kM0),
      poll_(dl::FormatRequest({.command = command})),
      step_(dl::FormatRequest({.command = step_command_})) {
  HAPTOMETER_CHECK(command == Command::kM0 || command == Command::kMs, "command {}",
                   dl::Name(command));
}

std::size_t IlPoll::samples() const {
  return channels_.size() * (command_ == Command::kMs ? 2 : 1);
}

bool IlPoll::AnswersStep(std::string_view line) const {
  const auto reply = dl::ParseReply(spelling_, line);
  return reply && dl::Answers(*reply, step_command_);
}

// a recording's channels and steps are fixed: a reply that differs is not of this unit
bool IlPoll::Fits(const Reply& reply) const {
  if (!dl::Answers(reply, command_) || reply.units != channels_.size()) return false;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (reply.values[i].decimals != channels_[i].sent_decimals) return false;
  }
  return true;
}

LineMeaning IlPoll::Read(std::string_view line, std::span<trial::Sample> samples) const {
  const auto reply = dl::ParseReply(spelling_, line);
  if (!reply) return LineMeaning::kDamaged;
  // a hardware trigger's line was asked by nobody, and the step before this poll
  if (reply->kind == ReplyKind::kDr || dl::Answers(*reply, step_command_)) {
    return LineMeaning::kOther;
  }
  if (reply->kind == ReplyKind::kError) {
    return dl::Answers(*reply, command_) ? LineMeaning::kRefusal : LineMeaning::kOther;
  }
  if (!Fits(*reply)) return LineMeaning::kDamaged;
  const std::size_t amplifiers = channels_.size();
  for (std::size_t i = 0; i < amplifiers; ++i) {
    const Value& sent = reply->values[i];
    const Value value = channels_[i].has_il_specials ? dl_en1::WithIlSpecials(sent) : sent;
    samples[i] = {trial::RawValue::Counts(value.counts), value.status};
    if (command_ == Command::kMs) {
      samples[amplifiers + i] = {trial::RawValue::Counts(reply->outputs[i]), {}};
    }
  }
  return LineMeaning::kReading;
}

}  // namespace haptometer::acquire
