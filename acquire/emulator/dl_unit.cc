#include "acquire/emulator/dl_unit.h"

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace haptometer::acquire::emulator {
namespace {

using dl::Command;
using trial::SampleStatus;

Value Struck(Value value, const Fault* fault) {
  if (fault != nullptr && fault->status != SampleStatus::kOk) value.status = fault->status;
  return value;
}

bool AnswersForAnother(const Fault* fault) { return fault != nullptr && fault->wrong_id; }

}  // namespace

DlUnit::DlUnit(const DlModel& model, int baud, std::vector<MovingHead> heads, DlTimes times,
               bool is_writable, FaultPlan faults)
    : AskedUnit(baud, model.longest_line, dl::kLineEnd.back(), faults),
      model_(model),
      times_(times),
      is_writable_(is_writable) {
  HAPTOMETER_CHECK(!heads.empty() && heads.size() <= dl::kMostUnits, "{} heads", heads.size());
  for (MovingHead& head : heads) amplifiers_.emplace_back(std::move(head), amplifiers_.empty());
}

MonotonicNs DlUnit::ProcessingNs(std::string_view line) const {
  const std::string_view command = line.substr(0, 2);
  if (command == "AW") return times_.to_all_ns;
  return command == "SR" || command == "SW" || command == "FR" ? times_.direct_ns
                                                               : times_.polled_ns;
}

std::string DlUnit::AnswerToOverlong(std::string_view line) const {
  return dl::FormatErrorReply(model_.spelling, {line.substr(0, 2), model_.too_long});
}

std::string DlUnit::AnswerTo(std::string_view line, MonotonicNs now, const Fault* fault) {
  const dl::ParsedRequest parsed = dl::ParseRequest(model_.spelling, line);
  const std::string_view command = line.substr(0, 2);
  if (fault != nullptr && fault->refuses) {
    const int number = faults().error_number.value_or(model_.faulty);
    return dl::FormatErrorReply(model_.spelling, {command, number});
  }
  if (!parsed.request) {
    return dl::FormatErrorReply(model_.spelling, {command, parsed.refusal.number});
  }
  switch (parsed.request->command) {
    case Command::kM0:
    case Command::kMs:
      return AnswerValues(parsed.request->command, now, fault);
    case Command::kSr:
      return AnswerData(*parsed.request, now, fault);
    case Command::kFr:
      return AnswerDecimals(*parsed.request, fault);
    case Command::kSw:
    case Command::kAw:
      return AnswerWrite(*parsed.request, now);
  }
  return {};
}

std::string DlUnit::Refuse(Command command, int number) const {
  return dl::FormatErrorReply(model_.spelling, {dl::Name(command), number});
}

std::optional<std::size_t> DlUnit::PlaceOf(int unit) const {
  const int place = unit - model_.first_unit;
  if (place < 0 || place >= static_cast<int>(amplifiers_.size())) return std::nullopt;
  return static_cast<std::size_t>(place);
}

std::string DlUnit::AnswerValues(Command command, MonotonicNs now, const Fault* fault) const {
  const MonotonicNs refreshed = now - now % times_.refresh_ns;
  std::vector<Value> values;
  std::vector<int> outputs;
  for (const IlAmplifier& amplifier : amplifiers_) {
    values.push_back(Struck(amplifier.ReadingAt(refreshed, now), fault));
    outputs.push_back(IlAmplifier::Outputs(values.back()));
  }
  if (AnswersForAnother(fault)) {
    values.push_back(values.back());
    outputs.push_back(outputs.back());
  }
  return command == Command::kM0 ? dl::FormatM0Reply(model_.spelling, values)
                                 : dl::FormatMsReply(model_.spelling, outputs, values);
}

std::string DlUnit::AnswerData(const dl::Request& request, MonotonicNs now,
                               const Fault* fault) const {
  const auto place = PlaceOf(request.unit);
  if (!place) return Refuse(request.command, model_.no_such_unit);
  const IlAmplifier& amplifier = amplifiers_[*place];
  const auto datum = amplifier.Read(request.number, Struck(amplifier.ReadingAt(now, now), fault));
  if (!datum) return Refuse(request.command, model_.no_such_number);
  std::string data = datum->text;
  if (datum->kind == IlDatum::Kind::kValue) data = model_.format_data_value(datum->value);
  if (datum->kind == IlDatum::Kind::kNumber) {
    data = model_.format_number(datum->number, datum->digits);
  }
  return dl::FormatDataReply(request.command, request.unit + (AnswersForAnother(fault) ? 1 : 0),
                             request.number, data);
}

std::string DlUnit::AnswerDecimals(const dl::Request& request, const Fault* fault) const {
  const auto place = PlaceOf(request.unit);
  if (!place) return Refuse(request.command, model_.no_such_unit);
  const auto datum = amplifiers_[*place].Read(request.number, {});
  if (!datum) return Refuse(request.command, model_.no_such_number);
  const bool is_value = datum->kind == IlDatum::Kind::kValue;
  return dl::FormatDataReply(
      request.command, request.unit + (AnswersForAnother(fault) ? 1 : 0), request.number,
      model_.format_number(is_value ? amplifiers_[*place].decimals() : 0, 1));
}

std::string DlUnit::AnswerWrite(const dl::Request& request, MonotonicNs now) {
  const bool to_all = request.command == Command::kAw;
  const auto place = to_all ? std::optional<std::size_t>(0) : PlaceOf(request.unit);
  if (!is_writable_) return Refuse(request.command, model_.write_locked);
  if (!place) return Refuse(request.command, model_.no_such_unit);
  const auto code = dl::NumberOf(request.data);
  if (!code) return Refuse(request.command, model_.out_of_range);
  const std::size_t end = to_all ? amplifiers_.size() : *place + 1;
  for (std::size_t i = *place; i < end; ++i) {
    switch (amplifiers_[i].Write(request.number, *code, now)) {
      case IlWriteOutcome::kNoSuchNumber:
        return Refuse(request.command, model_.no_such_number);
      case IlWriteOutcome::kReadOnly:
        return Refuse(request.command, model_.read_only);
      case IlWriteOutcome::kOutOfRange:
        return Refuse(request.command, model_.out_of_range);
      case IlWriteOutcome::kDone:
        break;
    }
  }
  return dl::FormatWriteReply(request);
}

}  // namespace haptometer::acquire::emulator
