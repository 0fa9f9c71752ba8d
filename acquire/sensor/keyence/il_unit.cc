#include "acquire/sensor/keyence/il_unit.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"

namespace haptometer::acquire {
namespace {

// M0 and MS read the buffer; the others name a data number
bool IsDirect(dl::Command command) {
  return command != dl::Command::kM0 && command != dl::Command::kMs;
}

// whether `reply` is to `request`
bool IsReplyTo(const dl::Request& request, const dl::Reply& reply) {
  if (!dl::Answers(reply, request.command)) return false;
  // replies to direct commands repeat identification and data number
  return reply.kind == dl::ReplyKind::kError || !IsDirect(request.command) ||
         (reply.unit == request.unit && reply.number == request.number);
}

}  // namespace

const IlUnitTraits& TraitsOf(IlUnit unit) {
  static const IlUnitTraits kDlRs1a{
      .sensor = "keyence-il",
      .name = "DL-RS1A",
      .spelling = dl_rs1a::Spelling(),
      .first_unit = 0,
      .longest_line = dl_rs1a::kLongestLine,
      .error_text = dl_rs1a::ErrorText,
      .refresh_ns = dl_rs1a::RefreshNs,
      .format_number = [](int number) { return fmt::to_string(number); },
      .write_locked = dl_rs1a::kWriteControl,
      .write_remedy = "slide the R/W switch of the DL-RS1A to W, and back to R afterwards"};
  static const IlUnitTraits kDlEn1{.sensor = "keyence-en1",
                                   .name = "DL-EN1",
                                   .spelling = dl_en1::Spelling(),
                                   .first_unit = dl_en1::kFirstUnit,
                                   .longest_line = dl_en1::kLongestLine,
                                   .error_text = dl_en1::ErrorText,
                                   .refresh_ns = dl_en1::RefreshNs,
                                   .format_number = dl_en1::FormatNumber,
                                   .write_locked = dl_en1::kWriteProtected,
                                   .write_remedy = "allow writing in the DL-EN1's own settings"};
  return unit == IlUnit::kDlRs1a ? kDlRs1a : kDlEn1;
}

Result<std::optional<dl::Reply>> IlTalk::Ask(const dl::Request& request) {
  std::optional<dl::Reply> reply;
  const auto take = [&](std::string_view line) {
    reply = dl::ParseReply(traits_.spelling, line);
    if (reply && !IsReplyTo(request, *reply)) reply.reset();
    return reply.has_value();
  };
  HAPTOMETER_LET(const auto answered, line_.Exchange(dl::FormatRequest(request), take, stop_));
  // requests in a row without a reply: the caller can stop polling for data
  silences_ = answered ? 0 : silences_ + 1;
  return reply;
}

Result<std::optional<std::string>> IlTalk::Read(int unit, int number) {
  HAPTOMETER_LET(const auto reply,
                 Ask({.command = dl::Command::kSr, .unit = unit, .number = number}));
  // a refusal: the amplifier has no such data
  if (!reply || reply->kind != dl::ReplyKind::kSr) return std::nullopt;
  return std::string(reply->data);
}

Result<void> IlTalk::Write(int unit, int number, std::string_view data) {
  HAPTOMETER_LET(const auto reply,
                 Ask({.command = dl::Command::kSw, .unit = unit, .number = number, .data = data}));
  if (!reply) {
    return CannotAnswer(
        name(),
        fmt::format("the {} does not answer the writing of data {:03}", traits_.name, number),
        "check cable and power");
  }
  // SW acknowledges the write; all other replies are refusals
  if (reply->kind == dl::ReplyKind::kSw) return {};
  const int error = reply->number;
  return CannotAnswer(
      name(),
      fmt::format("the {} refuses to write data {:03} with error {:0{}}: {}", traits_.name, number,
                  error, traits_.spelling.error_digits, traits_.error_text(error)),
      error == traits_.write_locked
          ? std::string(traits_.write_remedy)
          : fmt::format("see the error list of the {}'s manual", traits_.name));
}

using dl::Command;
using dl::Reply;
using dl::ReplyKind;

IlPoll::IlPoll(const dl::Spelling& spelling, Command command)
    : spelling_(spelling),
      command_(command),
      // step after a lost reply: the other of M0 and MS, whose reply differs in its first word
      step_command_(command == Command::kM0 ? Command::kMs : Command::kM0),
      poll_(dl::FormatRequest({.command = command})),
      step_(dl::FormatRequest({.command = step_command_})) {
  HAPTOMETER_CHECK(command == Command::kM0 || command == Command::kMs, "command {}",
                   dl::Name(command));
}

// MS adds one channel of outputs per amplifier
std::size_t IlPoll::samples() const {
  return channels_.size() * (command_ == Command::kMs ? 2 : 1);
}

bool IlPoll::AnswersStep(std::string_view line) const {
  const auto reply = dl::ParseReply(spelling_, line);
  return reply && dl::Answers(*reply, step_command_);
}

// a recording's channels and steps are fixed
bool IlPoll::Fits(const Reply& reply) const {
  if (reply.units != channels_.size()) return false;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (reply.values[i].decimals != channels_[i].sent_decimals) return false;
  }
  return true;
}

LineMeaning IlPoll::Read(std::string_view line, std::span<trial::Sample> samples) const {
  const auto reply = dl::ParseReply(spelling_, line);
  if (!reply) return LineMeaning::kDamaged;
  // DR lines of a hardware trigger come without request; a step's reply belongs to an older step
  if (reply->kind == ReplyKind::kDr || dl::Answers(*reply, step_command_)) {
    return LineMeaning::kOther;
  }
  if (reply->kind == ReplyKind::kError) {
    return dl::Answers(*reply, command_) ? LineMeaning::kRefusal : LineMeaning::kOther;
  }
  if (!dl::Answers(*reply, command_)) return LineMeaning::kDamaged;
  if (!Fits(*reply)) return LineMeaning::kOtherForm;
  // values first, then the outputs of MS
  const std::size_t amplifiers = channels_.size();
  for (std::size_t i = 0; i < amplifiers; ++i) {
    const Value& sent = reply->values[i];
    // without a point on the wire, the IL specials (99999 and so on) depend on the head
    const Value value = channels_[i].has_il_specials ? dl_en1::WithIlSpecials(sent) : sent;
    samples[i] = {trial::RawValue::Counts(value.counts), value.status};
    if (command_ == Command::kMs) {
      samples[amplifiers + i] = {trial::RawValue::Counts(reply->outputs[i]), {}};
    }
  }
  return LineMeaning::kReading;
}

}  // namespace haptometer::acquire
