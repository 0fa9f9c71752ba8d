#include "acquire/emulator/device.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptometer::acquire::emulator {

MonotonicNs SerialLine::Send(MonotonicNs ready) {
  // a pause on the wire begins a new burst
  if (ready >= burst_end_) {
    burst_start_ = ready;
    burst_bytes_ = 0;
  }
  ++burst_bytes_;
  // time of the whole burst, so that rounding of one character's time does not add up
  burst_end_ = burst_start_ + WireTimeNs(burst_bytes_, baud_, bits_per_character_);
  return burst_end_;
}

// sample k is taken at k * sampling_s
MonotonicNs MovingHead::SampleTime(std::int64_t number) const {
  return std::llround(static_cast<double>(number) * head.sampling_s * static_cast<double>(kNsPerS));
}

std::int64_t MovingHead::LastSample(MonotonicNs now) const {
  // the quotient may be off by one at a sample's own time; SampleTime() decides
  auto number = static_cast<std::int64_t>(SecondsFromNs(now) / head.sampling_s);
  while (SampleTime(number + 1) <= now) ++number;
  while (number > 0 && SampleTime(number) > now) --number;
  return number;
}

// value and status of the head at sample k, with its noise from `seed`
trial::HeadReading MovingHead::Reading(std::int64_t number) const {
  return trial::ReadingAt(head, displacement, number, seed);
}

namespace {

constexpr std::size_t kReceiveBuffer = 256;

}  // namespace

AskedUnit::AskedUnit(int baud, std::size_t longest_line, char line_end, FaultPlan faults)
    : longest_line_(longest_line),
      line_end_(line_end),
      faults_(faults),
      host_to_unit_(baud),
      unit_to_host_(baud) {}

void AskedUnit::Receive(std::string_view bytes, MonotonicNs now) {
  // room is made first, so that what is lost does not depend on how often Advance() was called
  RunTo(now);
  for (const char byte : bytes) {
    if (incoming_.size() < kReceiveBuffer) incoming_.push_back({byte, now});
  }
  RunTo(now);  // the first byte enters the wire: NextDue() needs its arrival
}

void AskedUnit::Advance(MonotonicNs now, std::string& out) {
  RunTo(now);
  out += crossed_;
  crossed_.clear();
}

// when the state changes next; nothing while no byte is on its way
std::optional<MonotonicNs> AskedUnit::NextDue() const {
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

bool AskedUnit::TakeHangUp() { return std::exchange(hang_up_, false); }

// all steps that are due by `now`, each at its own time
void AskedUnit::RunTo(MonotonicNs now) {
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
MonotonicNs AskedUnit::NextArrival() {
  if (!next_arrival_) {
    next_arrival_ = host_to_unit_.Send(std::max(incoming_.front().written, free_since_));
  }
  return *next_arrival_;
}

bool AskedUnit::Listen(MonotonicNs now) {
  if (incoming_.empty()) return false;
  // bytes cross the wire one after the other at the baud rate
  const MonotonicNs arrival = NextArrival();
  if (arrival > now) return false;
  const char byte = incoming_.front().byte;
  incoming_.pop_front();
  next_arrival_.reset();
  TakeByte(byte, arrival);
  return true;
}

void AskedUnit::TakeByte(char byte, MonotonicNs arrival) {
  // the LF of CR LF ends no second line; empty lines have no answer
  const bool ends_delimiter = byte == '\n' && line_feed_may_follow_;
  line_feed_may_follow_ = byte == '\r';
  if (ends_delimiter) return;
  if (byte != '\r') {
    // an overlong line is cut, and has a refusal as its answer
    overlong_ = overlong_ || line_.size() == longest_line_;
    if (!overlong_) line_ += byte;
  } else if (!line_.empty()) {
    BeginProcessing(arrival);
  }
}

void AskedUnit::BeginProcessing(MonotonicNs arrival) {
  // an answer leaves when its processing time, and the delay of a fault, have passed
  processed_at_ = arrival + ProcessingNs(line_);
  const Fault* fault = faults_.At(answers_ + 1);
  if (fault != nullptr) processed_at_ += fault->delay_ns;
  phase_ = Phase::kProcessing;
}

bool AskedUnit::Process(MonotonicNs now) {
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

void AskedUnit::PrepareAnswer() {
  // faults count answers from 1
  ++answers_;
  const Fault* fault = faults_.At(answers_);
  // state of the unit at the end of processing
  answer_ = overlong_ ? AnswerToOverlong(line_) : AnswerTo(line_, processed_at_, fault);
  pause_ns_ = 0;
  if (fault != nullptr) Strike(*fault);
  // an answer that was held back is sent before this one
  const bool holds_back = fault != nullptr && fault->holds_back && held_back_.empty();
  if (holds_back) {
    held_back_ = std::exchange(answer_, {});
  } else {
    answer_.insert(0, std::exchange(held_back_, {}));
  }
  line_.clear();
  overlong_ = false;
  sent_ = 0;
  // requests that arrive while the unit is busy enter the wire from here on
  ready_ = free_since_ = processed_at_;
  phase_ = answer_.empty() ? Phase::kListening : Phase::kAnswering;
  if (!answer_.empty()) next_departure_ = unit_to_host_.Send(ready_);
}

// what a fault does to the bytes of answer_
void AskedUnit::Strike(const Fault& fault) {
  hang_up_ = fault.hangs_up;
  answer_ = hang_up_ ? "" : Damaged(std::move(answer_), fault.damage, answers_);
  pause_ns_ = fault.pause_ns;
  // a pause of the fault begins in the middle of the answer
  pause_before_ = answer_.size() / 2;
}

bool AskedUnit::Answer(MonotonicNs now) {
  if (next_departure_ > now) return false;
  crossed_ += answer_[sent_++];
  if (sent_ < answer_.size()) {
    // bytes behind the pause are ready later
    if (sent_ == pause_before_) ready_ += std::exchange(pause_ns_, 0);
    next_departure_ = unit_to_host_.Send(ready_);
  } else {
    free_since_ = next_departure_;
    phase_ = Phase::kListening;
  }
  return true;
}

}  // namespace haptometer::acquire::emulator
