#include "acquire/emulator/dl_rs1a_unit.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/check.h"

namespace haptometer::acquire::emulator {
namespace {

using trial::SampleStatus;

constexpr std::size_t kReceiveBuffer = 256;
constexpr int kDecimals = 3;  // of an IL-030: millimetres in steps of 1 um

// Output bits of MS and of data 036; the comparator's limits are the ends of the range.
int Outputs(const Value& value) {
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

// codes of data 132 and 133, which the unit has only for these settings
std::optional<int> SamplingCode(double sampling_s) {
  for (int code = 1; code <= 4; ++code) {
    const auto known_s = dl_rs1a::SamplingSeconds(code);
    if (known_s && std::abs(*known_s - sampling_s) < 1e-9) return code;
  }
  return std::nullopt;
}

std::optional<int> AveragingCode(int averages) {
  for (int code = 0; code <= 12; ++code) {
    if (dl_rs1a::Averages(code) == averages) return code;
  }
  return std::nullopt;
}

// What SR reads besides values: constants of this amplifier, nothing for a number it does not know.
std::optional<std::string> SettingText(int number, const trial::SensorHead& head) {
  switch (number) {
    case dl_rs1a::kErrorFlags:
      return "00000";
    case dl_rs1a::kSamplingCycle:
      return fmt::to_string(SamplingCode(head.sampling_s).value_or(0));
    case dl_rs1a::kAveraging:
      return fmt::to_string(AveragingCode(head.averages).value_or(0));
    case dl_rs1a::kBank:
    case dl_rs1a::kHold:
    case dl_rs1a::kZeroShiftMemory:
    case dl_rs1a::kHighPassCutoff:
      return "0";
    case 193:  // product code of a main amplifier
      return "4022";
    case dl_rs1a::kConnectedHead:
      return "1";
    case dl_rs1a::kProductName:
      return "EMULATED";
    default:
      return std::nullopt;
  }
}

// What SR reads of the present reading. Peak and bottom do not exist in sample hold.
std::optional<std::string> ValueText(int number, const Value& value) {
  switch (number) {
    case 36:
      return fmt::format("{:02}", Outputs(value));
    case 37:
    case 38:
      return dl_rs1a::FormatValue(value);
    case 39:
    case 40:
      return dl_rs1a::FormatValue({.decimals = kDecimals, .status = SampleStatus::kInvalid});
    default:
      return std::nullopt;
  }
}

}  // namespace

Result<void> Validate(const DlRs1aSetup& setup) {
  if (std::ranges::find(dl_rs1a::kBauds, setup.baud) == dl_rs1a::kBauds.end()) {
    return Usage("--baud", fmt::format("a DL-RS1A has no {} baud", setup.baud),
                 fmt::format("give one of {}", fmt::join(dl_rs1a::kBauds, ", ")));
  }
  if (!SamplingCode(setup.head.head.sampling_s)) {
    return Usage(
        "--sampling",
        fmt::format("an IL-1000 does not sample every {:g} ms", 1e3 * setup.head.head.sampling_s),
        "give 0.33ms, 1ms, 2ms or 5ms");
  }
  if (!AveragingCode(setup.head.head.averages)) {
    return Usage("--averages",
                 fmt::format("an IL-1000 does not average {}", setup.head.head.averages),
                 "give a power of two from 1 to 4096");
  }
  return {};
}

DlRs1aUnit::DlRs1aUnit(DlRs1aSetup setup)
    : setup_(std::move(setup)), host_to_unit_(setup_.baud), unit_to_host_(setup_.baud) {
  HAPTOMETER_CHECK(Validate(setup_).has_value(), "{}", Validate(setup_).error().Text());
}

void DlRs1aUnit::Receive(std::string_view bytes, MonotonicNs now) {
  // room is made first, so that what is lost does not depend on how often Advance() was called
  RunTo(now);
  for (const char byte : bytes) {
    if (incoming_.size() < kReceiveBuffer) incoming_.push_back({byte, now});
  }
  RunTo(now);  // the first byte enters the wire, so that NextDue() knows its arrival
}

void DlRs1aUnit::Advance(MonotonicNs now, std::string& out) {
  RunTo(now);
  out += crossed_;
  crossed_.clear();
}

std::optional<MonotonicNs> DlRs1aUnit::NextDue() const {
  switch (phase_) {
    case Phase::kListening:
      return next_arrival_;
    case Phase::kProcessing:
      return next_arrival_.value_or(processed_at_);
    case Phase::kAnswering:
      return next_departure_;
  }
  return std::nullopt;
}

bool DlRs1aUnit::TakeHangUp() { return std::exchange(hang_up_, false); }

void DlRs1aUnit::RunTo(MonotonicNs now) {
  bool again = true;
  while (again) {
    switch (phase_) {
      case Phase::kListening:
        again = Listen(now);
        break;
      case Phase::kProcessing:
        again = Process(now);
        break;
      case Phase::kAnswering:
        again = Answer(now);
        break;
    }
  }
}

// When the oldest byte not yet taken in has crossed the wire, which it enters once the unit is
// free.
MonotonicNs DlRs1aUnit::NextArrival() {
  if (!next_arrival_) {
    next_arrival_ = host_to_unit_.Send(std::max(incoming_.front().written, free_since_));
  }
  return *next_arrival_;
}

bool DlRs1aUnit::Listen(MonotonicNs now) {
  if (incoming_.empty()) return false;
  const MonotonicNs arrival = NextArrival();
  if (arrival > now) return false;
  const char byte = incoming_.front().byte;
  incoming_.pop_front();
  next_arrival_.reset();
  TakeByte(byte, arrival);
  return true;
}

void DlRs1aUnit::TakeByte(char byte, MonotonicNs arrival) {
  const bool ends_delimiter = byte == '\n' && line_feed_may_follow_;
  line_feed_may_follow_ = byte == '\r';
  if (ends_delimiter) return;
  if (byte != '\r') {
    overlong_ = overlong_ || line_.size() == dl_rs1a::kLongestLine;
    if (!overlong_) line_ += byte;
  } else if (!line_.empty()) {
    BeginProcessing(arrival);
  }
}

void DlRs1aUnit::BeginProcessing(MonotonicNs arrival) {
  const bool direct = line_.starts_with("SR");
  processed_at_ = arrival + (direct ? setup_.direct_processing_ns : setup_.processing_ns);
  const Fault* fault = setup_.faults.At(answers_ + 1);
  if (fault != nullptr) processed_at_ += fault->delay_ns;
  phase_ = Phase::kProcessing;
}

bool DlRs1aUnit::Process(MonotonicNs now) {
  // the LF of a CR+LF belongs to the request if it is on its way before processing ends, and then
  // processing counts from its arrival (at 2400 baud it takes longer than processing does)
  if (line_feed_may_follow_ && !incoming_.empty() && incoming_.front().byte == '\n' &&
      incoming_.front().written <= processed_at_) {
    const MonotonicNs arrival = NextArrival();
    if (arrival > now) return false;
    incoming_.pop_front();
    next_arrival_.reset();
    line_feed_may_follow_ = false;
    BeginProcessing(arrival);
    return true;
  }
  if (processed_at_ > now) return false;
  PrepareAnswer();
  return true;
}

void DlRs1aUnit::PrepareAnswer() {
  ++answers_;
  const Fault* fault = setup_.faults.At(answers_);
  const dl_rs1a::ParsedRequest parsed = dl_rs1a::ParseRequest(line_);
  const std::string_view command = std::string_view(line_).substr(0, 2);
  if (overlong_) {
    answer_ = dl_rs1a::FormatErrorReply({command, dl_rs1a::kDataLength});
  } else if (fault != nullptr && fault->refuses) {
    answer_ = dl_rs1a::FormatErrorReply({command, dl_rs1a::kCommunication});
  } else if (!parsed.request) {
    answer_ = dl_rs1a::FormatErrorReply({command, parsed.refusal.number});
  } else {
    answer_ = AnswerTo(*parsed.request, fault);
  }
  if (fault != nullptr) {
    hang_up_ = fault->hangs_up;
    answer_ = hang_up_ ? "" : Damaged(std::move(answer_), fault->damage, answers_);
  }
  line_.clear();
  overlong_ = false;
  sent_ = 0;
  free_since_ = processed_at_;
  phase_ = answer_.empty() ? Phase::kListening : Phase::kAnswering;
  if (!answer_.empty()) next_departure_ = unit_to_host_.Send(processed_at_);
}

bool DlRs1aUnit::Answer(MonotonicNs now) {
  if (next_departure_ > now) return false;
  crossed_ += answer_[sent_++];
  if (sent_ < answer_.size()) {
    next_departure_ = unit_to_host_.Send(processed_at_);
  } else {
    free_since_ = next_departure_;
    phase_ = Phase::kListening;
  }
  return true;
}

std::string DlRs1aUnit::AnswerTo(const dl_rs1a::Request& request, const Fault* fault) const {
  using dl_rs1a::Command;
  switch (request.command) {
    case Command::kM0:
      return dl_rs1a::FormatM0Reply(std::array{Buffered(fault)});
    case Command::kMs: {
      const std::array values{Buffered(fault)};
      return dl_rs1a::FormatMsReply(std::array{Outputs(values.front())}, values);
    }
    case Command::kSr: {
      if (request.unit != 0) return dl_rs1a::FormatErrorReply({"SR", dl_rs1a::kUnitNumber});
      const Value direct = ValueOf(setup_.head.LastSample(processed_at_), fault);
      auto data = ValueText(request.number, direct);
      if (!data) data = SettingText(request.number, setup_.head.head);
      if (!data) return dl_rs1a::FormatErrorReply({"SR", dl_rs1a::kParameter});
      return dl_rs1a::FormatSrReply(request.unit, request.number, *data);
    }
    case Command::kSw:
      return dl_rs1a::FormatErrorReply({"SW", dl_rs1a::kWriteControl});
    case Command::kAw:
      return dl_rs1a::FormatErrorReply({"AW", dl_rs1a::kWriteControl});
  }
  return {};
}

// The buffer holds the reading that was the head's last at the latest refresh.
Value DlRs1aUnit::Buffered(const Fault* fault) const {
  const MonotonicNs refreshed = processed_at_ - processed_at_ % setup_.refresh_ns;
  return ValueOf(setup_.head.LastSample(refreshed), fault);
}

Value DlRs1aUnit::ValueOf(std::int64_t sample, const Fault* fault) const {
  const trial::HeadReading reading = setup_.head.Reading(sample);
  const bool forced = fault != nullptr && fault->status != SampleStatus::kOk;
  return {.counts = static_cast<std::int32_t>(std::lround(1e6 * reading.value_m)),
          .decimals = kDecimals,
          .status = forced ? fault->status : reading.status};
}

}  // namespace haptometer::acquire::emulator
