#include "acquire/emulator/dl_unit.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "acquire/protocol/keyence/dl_en1.h"

namespace haptometer::acquire::emulator {
namespace {

using trial::SampleStatus;

// the data numbers that can be written; each takes the codes from 0 to this
const std::map<int, int> kHighestCodes{
    {dl_rs1a::kBank, 3},
    {dl_rs1a::kSamplingCycle, static_cast<int>(dl_rs1a::kSamplings_s.size())},
    {dl_rs1a::kAveraging, 14},
    {dl_rs1a::kHold, 5},
    {dl_rs1a::kZeroShiftMemory, 1},
    {dl_rs1a::kHighPassCutoff, 9}};

// data of the head by its name; IL-030 for heads outside of the IL series
const dl_rs1a::Head& TypeOf(const std::string& name) {
  const dl_rs1a::Head* type = dl_rs1a::FindHead(name);
  return type != nullptr ? *type : *dl_rs1a::FindHead("IL-030");
}

// volts per metre of the analog output: 5 V at the end of the linear range
double AnalogVoltsPerMetre(const dl_rs1a::Head& type) {
  constexpr double kUsualMm = 5;  // where the head's range is not known
  return 5e3 / (type.linear_half_range_mm > 0 ? type.linear_half_range_mm : kUsualMm);
}

constexpr double kMostAnalogV = 5;  // beyond, the output stays there

IlDatum ValueDatum(const Value& value) { return {.kind = IlDatum::Kind::kValue, .value = value}; }
IlDatum NumberDatum(int number, int digits) { return {.number = number, .digits = digits}; }

}  // namespace

double AnalogVolts(const trial::SensorHead& head, double displacement_m) {
  if (displacement_m < head.range_min_m || displacement_m > head.range_max_m) {
    return 1e-3 * dl_rs1a::kAnalogErrorMv;
  }
  return std::clamp(AnalogVoltsPerMetre(TypeOf(head.name)) * displacement_m, -kMostAnalogV,
                    kMostAnalogV);
}

Result<void> ValidateIlHead(const trial::SensorHead& head) {
  if (!dl_rs1a::SamplingCode(head.sampling_s)) {
    std::array<double, dl_rs1a::kSamplings_s.size()> periods_ms{};
    std::ranges::transform(dl_rs1a::kSamplings_s, periods_ms.begin(),
                           [](double period_s) { return 1e3 * period_s; });
    return Usage("<sampling>",
                 fmt::format("an IL-1000 does not sample every {:g} ms", 1e3 * head.sampling_s),
                 fmt::format("give one of {:g} ms", fmt::join(periods_ms, ", ")));
  }
  if (!dl_rs1a::AveragingCode(head.averages)) {
    return Usage("<averages>", fmt::format("an IL-1000 does not average {}", head.averages),
                 "give a power of two from 1 to 4096");
  }
  return {};
}

IlAmplifier::IlAmplifier(MovingHead head, bool is_main)
    : head_(std::move(head)), type_(TypeOf(head_.head.name)), is_main_(is_main) {
  // all settings start at code 0; sampling and averages from the head
  for (const auto& [number, highest] : kHighestCodes) codes_[number] = 0;
  codes_[dl_rs1a::kSamplingCycle] = dl_rs1a::SamplingCode(head_.head.sampling_s).value_or(0);
  codes_[dl_rs1a::kAveraging] = dl_rs1a::AveragingCode(head_.head.averages).value_or(0);
}

// value in mm * 10^decimals, whole
double IlAmplifier::CountsOf(const trial::HeadReading& reading) const {
  return std::round(1e3 * PowerOfTen(type_.decimals) * reading.value_m);
}

Value IlAmplifier::ReadingAt(MonotonicNs sampled, MonotonicNs now) const {
  // invalid (-99.998) until two response times after a change of a setting
  if (now < settled_at_) return {.decimals = type_.decimals, .status = SampleStatus::kInvalid};
  const trial::HeadReading reading = head_.Reading(head_.LastSample(sampled));
  const double counts = CountsOf(reading) - zero_counts_;
  // the display's last numbers stand for no measurement: 99999, -99999 and -99998
  constexpr std::int32_t kMost = dl_rs1a::kMostCounts;
  Value value{.counts = static_cast<std::int32_t>(std::clamp<double>(counts, -kMost, kMost)),
              .decimals = type_.decimals,
              .status = reading.status};
  if (value.counts >= kMost) value.status = SampleStatus::kOver;
  if (value.counts <= 1 - kMost) value.status = SampleStatus::kUnder;
  return value;
}

// bit 0 HIGH, bit 1 LOW, bit 3 alarm, else bit 2 GO
int IlAmplifier::Outputs(const Value& value) {
  switch (value.status) {
    case SampleStatus::kOver:
      return 1;
    case SampleStatus::kUnder:
      return 2;
    case SampleStatus::kInvalid:
      return 8;
    default:
      return 4;
  }
}

std::optional<IlDatum> IlAmplifier::Read(int number, const Value& present) const {
  // a setting: the code that was last written
  if (const auto code = codes_.find(number); code != codes_.end()) {
    return NumberDatum(code->second, 1);
  }
  switch (number) {
    case dl_rs1a::kErrorFlags:
      return NumberDatum(0, 5);
    case dl_rs1a::kOutputs:
      return NumberDatum(Outputs(present), 2);
    case dl_rs1a::kPresentValue:
    case dl_rs1a::kRawValue:
      return ValueDatum(present);
    case dl_rs1a::kAnalogOutput: {
      // 5.5 V without a reading
      int mv = dl_rs1a::kAnalogErrorMv;
      if (present.status == SampleStatus::kOk) {
        const double metres = 1e-3 * present.counts / PowerOfTen(type_.decimals);
        const double volts =
            std::clamp(AnalogVoltsPerMetre(type_) * metres, -kMostAnalogV, kMostAnalogV);
        mv = static_cast<int>(
            std::lround(1e3 * (head_.analog.gain_error * volts + head_.analog.offset_error_v)));
      }
      return IlDatum{.kind = IlDatum::Kind::kAnalog, .number = mv};
    }
    case dl_rs1a::kPeak:  // peak and bottom do not exist in sample hold
    case dl_rs1a::kBottom:
      return ValueDatum({.decimals = type_.decimals, .status = SampleStatus::kInvalid});
    // 1: the zero shift succeeded
    case dl_rs1a::kZeroShiftResult:
      return NumberDatum(1, 1);
    case dl_rs1a::kProductCode:
      // 4022 main amplifier, 4023 expansion
      return NumberDatum(is_main_ ? 4022 : 4023, 4);
    case dl_rs1a::kConnectedHead:
      return NumberDatum(type_.code, 1);
    case dl_rs1a::kProductName:
      return IlDatum{.kind = IlDatum::Kind::kText, .text = "EMULATED"};
    default:
      return std::nullopt;
  }
}

IlWriteOutcome IlAmplifier::Write(int number, int code, MonotonicNs now) {
  if (number == dl_rs1a::kZeroShift || number == dl_rs1a::kZeroShiftReset) {
    if (code < 0 || code > 1) return IlWriteOutcome::kOutOfRange;
    ShiftZero(number, code, now);
    return IlWriteOutcome::kDone;
  }
  const auto highest = kHighestCodes.find(number);
  // no setting: read-only where the number can be read
  if (highest == kHighestCodes.end()) {
    return Read(number, {}) ? IlWriteOutcome::kReadOnly : IlWriteOutcome::kNoSuchNumber;
  }
  if (code < 0 || code > highest->second) return IlWriteOutcome::kOutOfRange;
  codes_[number] = code;
  // the filters average nothing here
  head_.head.sampling_s = dl_rs1a::SamplingSeconds(codes_[dl_rs1a::kSamplingCycle])
                              .value_or(dl_rs1a::kDefaultSampling_s);
  head_.head.averages = dl_rs1a::Averages(codes_[dl_rs1a::kAveraging]).value_or(1);
  // the moving average starts again after a change of these
  const bool unsettles = number == dl_rs1a::kSamplingCycle || number == dl_rs1a::kAveraging ||
                         number == dl_rs1a::kHold;
  if (unsettles) {
    // two response times: 2 * sampling cycle * averages
    settled_at_ = now + NsFromSeconds(2 * head_.head.sampling_s * head_.head.averages);
  }
  return IlWriteOutcome::kDone;
}

void IlAmplifier::ShiftZero(int number, int code, MonotonicNs now) {
  // the shift acts at the edge from 0 to 1, not at the level
  const bool is_edge = requests_[number] == 0 && code == 1;
  requests_[number] = code;
  if (!is_edge) return;
  // the present value becomes 0; a reset restores the head's own zero
  if (number != dl_rs1a::kZeroShift) {
    zero_counts_ = 0;
  } else if (now >= settled_at_) {
    zero_counts_ = CountsOf(head_.Reading(head_.LastSample(now)));
  }
}

namespace {

using dl::Command;

// the value with the status that a fault injects
Value Struck(Value value, const Fault* fault) {
  if (fault != nullptr && fault->status != SampleStatus::kOk) value.status = fault->status;
  return value;
}

// a reply with the number of another amplifier
bool AnswersForAnother(const Fault* fault) { return fault != nullptr && fault->wrong_id; }

}  // namespace

DlUnit::DlUnit(const DlModel& model, int baud, std::vector<MovingHead> heads, DlTimes times,
               bool is_writable, FaultPlan faults)
    : AskedUnit(baud, model.longest_line, dl::kLineEnd.back(), faults),
      model_(model),
      times_(times),
      is_writable_(is_writable) {
  HAPTOMETER_CHECK(!heads.empty() && heads.size() <= dl::kMostUnits, "{} heads", heads.size());
  // the first head belongs to the main amplifier
  for (MovingHead& head : heads) amplifiers_.emplace_back(std::move(head), amplifiers_.empty());
}

MonotonicNs DlUnit::ProcessingNs(std::string_view line) const {
  // processing time T by command; SR, SW and FR address one amplifier directly
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
  // an injected refusal precedes the reading of the request
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

// index of the amplifier with this identification number
std::optional<std::size_t> DlUnit::PlaceOf(int unit) const {
  const int place = unit - model_.first_unit;
  if (place < 0 || place >= static_cast<int>(amplifiers_.size())) return std::nullopt;
  return static_cast<std::size_t>(place);
}

std::string DlUnit::AnswerValues(Command command, MonotonicNs now, const Fault* fault) const {
  // last refill of the buffer, at a whole multiple of the refresh time
  const MonotonicNs refreshed = now - now % times_.refresh_ns;
  std::vector<Value> values;
  std::vector<int> outputs;
  for (const IlAmplifier& amplifier : amplifiers_) {
    values.push_back(Struck(amplifier.ReadingAt(refreshed, now), fault));
    outputs.push_back(IlAmplifier::Outputs(values.back()));
  }
  // the fault gives one value too many, as of another amplifier
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
  // SR bypasses the buffer: last complete reading of the head
  const auto datum = amplifier.Read(request.number, Struck(amplifier.ReadingAt(now, now), fault));
  if (!datum) return Refuse(request.command, model_.no_such_number);
  std::string data = datum->text;
  // values and numbers in the spelling of the unit, texts as they are
  if (datum->kind == IlDatum::Kind::kValue) data = model_.format_data_value(datum->value);
  if (datum->kind == IlDatum::Kind::kAnalog) data = model_.format_analog(datum->number);
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
  // FR: digits behind the point; 0 for a number that is no measured value
  constexpr int kOfMillivolts = 3;
  const int decimals = datum->kind == IlDatum::Kind::kValue    ? amplifiers_[*place].decimals()
                       : datum->kind == IlDatum::Kind::kAnalog ? kOfMillivolts
                                                               : 0;
  return dl::FormatDataReply(request.command, request.unit + (AnswersForAnother(fault) ? 1 : 0),
                             request.number, model_.format_number(decimals, 1));
}

std::string DlUnit::AnswerWrite(const dl::Request& request, MonotonicNs now) {
  // AW addresses all amplifiers, SW one
  const bool to_all = request.command == Command::kAw;
  const auto place = to_all ? std::optional<std::size_t>(0) : PlaceOf(request.unit);
  // the unit refuses in this order: lock, amplifier, code, data number
  if (!is_writable_) return Refuse(request.command, model_.write_locked);
  if (!place) return Refuse(request.command, model_.no_such_unit);
  const auto code = dl::NumberOf(request.data);
  if (!code) return Refuse(request.command, model_.out_of_range);
  // AW ends at the first refusal; amplifiers before it keep the new code
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

namespace {

constexpr MonotonicNs kToAllNs = 57'000'000;  // T4 of AW

const DlModel& Rs1aModel() {
  static const DlModel kModel{
      .spelling = dl_rs1a::Spelling(),
      .first_unit = 0,
      .longest_line = dl_rs1a::kLongestLine,
      .no_such_unit = dl_rs1a::kUnitNumber,
      .no_such_number = dl_rs1a::kParameter,
      .out_of_range = dl_rs1a::kParameter,
      .read_only = dl_rs1a::kParameter,
      .write_locked = dl_rs1a::kWriteControl,
      .too_long = dl_rs1a::kDataLength,
      .faulty = dl_rs1a::kCommunication,
      .format_number = [](int number, int digits) { return fmt::format("{:0{}}", number, digits); },
      .format_data_value = dl_rs1a::FormatValue,
      .format_analog = dl_rs1a::FormatAnalogMv};
  return kModel;
}

// head of the main amplifier (00) first, then 01, 02, ...
std::vector<MovingHead> AllHeads(const DlRs1aSetup& setup) {
  std::vector<MovingHead> heads{setup.head};
  heads.insert(heads.end(), setup.expansions.begin(), setup.expansions.end());
  return heads;
}

}  // namespace

Result<void> Validate(const DlRs1aSetup& setup) {
  if (std::ranges::find(dl_rs1a::kBauds, setup.baud) == dl_rs1a::kBauds.end()) {
    return Usage("<baud>", fmt::format("a DL-RS1A has no {} baud", setup.baud),
                 fmt::format("give one of {}", fmt::join(dl_rs1a::kBauds, ", ")));
  }
  // one main amplifier, so 14 expansions
  if (setup.expansions.size() >= dl_rs1a::kMostUnits) {
    return Usage("<amplifiers>", "a DL-RS1A has no more than 15", "give 1 to 15");
  }
  for (const MovingHead& head : setup.expansions) HAPTOMETER_TRY(ValidateIlHead(head.head));
  return ValidateIlHead(setup.head.head);
}

DlRs1aUnit::DlRs1aUnit(const DlRs1aSetup& setup)
    : DlUnit(Rs1aModel(), setup.baud, AllHeads(setup),
             {.polled_ns = setup.processing_ns,
              .direct_ns = setup.direct_processing_ns,
              .to_all_ns = kToAllNs,
              .refresh_ns = setup.refresh_ns},
             setup.is_writable, setup.faults) {
  HAPTOMETER_CHECK(Validate(setup).has_value(), "{}", Validate(setup).error().Text());
}

namespace {

constexpr int kBaud = 125'000'000;  // 100 Mbit/s as characters of 10 bits

// error numbers and spelling of the DL-EN1; numbers have a fixed width there
const DlModel& En1Model() {
  static const DlModel kModel{
      .spelling = dl_en1::Spelling(),
      .first_unit = dl_en1::kFirstUnit,
      .longest_line = dl_en1::kLongestLine,
      .no_such_unit = dl_en1::kUnitNumber,
      .no_such_number = dl_en1::kDataNumber,
      .out_of_range = dl_en1::kOutOfRange,
      .read_only = dl_en1::kWriteProtected,
      .write_locked = dl_en1::kWriteProtected,
      .too_long = dl_en1::kFormat,
      .faulty = dl_en1::kNotExecutable,
      .format_number = [](int number, int /*digits*/) { return dl_en1::FormatNumber(number); },
      .format_data_value = dl_en1::FormatIlValue,
      .format_analog = dl_en1::FormatNumber};
  return kModel;
}

}  // namespace

Result<void> Validate(const DlEn1Setup& setup) {
  if (setup.heads.empty() || setup.heads.size() > dl::kMostUnits) {
    return Usage("<amplifiers>", "a DL-EN1 has 1 to 15", "give as many");
  }
  for (const MovingHead& head : setup.heads) HAPTOMETER_TRY(ValidateIlHead(head.head));
  return {};
}

DlEn1Unit::DlEn1Unit(DlEn1Setup setup)
    : DlUnit(En1Model(), kBaud, std::move(setup.heads),
             {.polled_ns = setup.processing_ns,
              .direct_ns = setup.processing_ns,
              .to_all_ns = setup.processing_ns,
              .refresh_ns = setup.refresh_ns},
             setup.is_writable, setup.faults) {}

}  // namespace haptometer::acquire::emulator
