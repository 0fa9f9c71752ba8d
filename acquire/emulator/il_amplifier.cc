#include "acquire/emulator/il_amplifier.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "acquire/protocol/digits.h"

namespace haptometer::acquire::emulator {
namespace {

using trial::SampleStatus;

constexpr int kHighestAveraging = 14;

// codes that a data number takes: 0 to this; nothing for one that cannot be written
std::optional<int> HighestCode(int number) {
  switch (number) {
    case dl_rs1a::kBank:
      return 3;
    case dl_rs1a::kSamplingCycle:
      return 4;
    case dl_rs1a::kAveraging:
      return kHighestAveraging;
    case dl_rs1a::kHold:
      return 5;
    case dl_rs1a::kZeroShiftMemory:
      return 1;
    case dl_rs1a::kHighPassCutoff:
      return 9;
    default:
      return std::nullopt;
  }
}

const dl_rs1a::Head& TypeOf(const std::string& name) {
  const dl_rs1a::Head* type = dl_rs1a::FindHead(name);
  return type != nullptr ? *type : *dl_rs1a::FindHead("IL-030");
}

IlDatum ValueDatum(const Value& value) { return {.kind = IlDatum::Kind::kValue, .value = value}; }
IlDatum NumberDatum(int number, int digits) { return {.number = number, .digits = digits}; }

}  // namespace

Result<void> ValidateIlHead(const trial::SensorHead& head) {
  if (!dl_rs1a::SamplingCode(head.sampling_s)) {
    return Usage("--sampling",
                 fmt::format("an IL-1000 does not sample every {:g} ms", 1e3 * head.sampling_s),
                 "give 0.33ms, 1ms, 2ms or 5ms");
  }
  if (!dl_rs1a::AveragingCode(head.averages)) {
    return Usage("--averages", fmt::format("an IL-1000 does not average {}", head.averages),
                 "give a power of two from 1 to 4096");
  }
  return {};
}

IlAmplifier::IlAmplifier(MovingHead head, bool is_main)
    : head_(std::move(head)), type_(TypeOf(head_.head.name)), is_main_(is_main) {
  for (const int number :
       {dl_rs1a::kBank, dl_rs1a::kHold, dl_rs1a::kZeroShiftMemory, dl_rs1a::kHighPassCutoff}) {
    codes_[number] = 0;
  }
  codes_[dl_rs1a::kSamplingCycle] = dl_rs1a::SamplingCode(head_.head.sampling_s).value_or(0);
  codes_[dl_rs1a::kAveraging] = dl_rs1a::AveragingCode(head_.head.averages).value_or(0);
}

Value IlAmplifier::ReadingAt(MonotonicNs sampled, MonotonicNs now) const {
  if (now < settled_at_) return {.decimals = type_.decimals, .status = SampleStatus::kInvalid};
  const trial::HeadReading reading = head_.Reading(head_.LastSample(sampled));
  const double steps_per_m = 1e3 * PowerOfTen(type_.decimals);
  const auto counts = static_cast<std::int32_t>(std::lround(steps_per_m * reading.value_m));
  return {.counts = counts - zero_counts_, .decimals = type_.decimals, .status = reading.status};
}

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
    case dl_rs1a::kPeak:  // peak and bottom do not exist in sample hold
    case dl_rs1a::kBottom:
      return ValueDatum({.decimals = type_.decimals, .status = SampleStatus::kInvalid});
    case dl_rs1a::kZeroShiftResult:
      return NumberDatum(1, 1);
    case dl_rs1a::kProductCode:
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
  const std::optional<int> highest = HighestCode(number);
  if (!highest) {
    return Read(number, {}) ? IlWriteOutcome::kReadOnly : IlWriteOutcome::kNoSuchNumber;
  }
  if (code < 0 || code > *highest) return IlWriteOutcome::kOutOfRange;
  codes_[number] = code;
  // "default" is 1 ms; the filters average nothing here
  head_.head.sampling_s = dl_rs1a::SamplingSeconds(codes_[dl_rs1a::kSamplingCycle]).value_or(1e-3);
  head_.head.averages = dl_rs1a::Averages(codes_[dl_rs1a::kAveraging]).value_or(1);
  const bool unsettles = number == dl_rs1a::kSamplingCycle || number == dl_rs1a::kAveraging ||
                         number == dl_rs1a::kHold;
  if (unsettles) {
    settled_at_ = now + NsFromSeconds(2 * head_.head.sampling_s * head_.head.averages);
  }
  return IlWriteOutcome::kDone;
}

void IlAmplifier::ShiftZero(int number, int code, MonotonicNs now) {
  const bool is_edge = requests_[number] == 0 && code == 1;
  requests_[number] = code;
  if (!is_edge) return;
  zero_counts_ = number == dl_rs1a::kZeroShift ? zero_counts_ + ReadingAt(now, now).counts : 0;
}

}  // namespace haptometer::acquire::emulator
