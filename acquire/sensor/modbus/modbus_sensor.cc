// The wire and the recording; modbus_sensor_start.cc has what comes before it.
#include "acquire/sensor/modbus/modbus_sensor.h"

#include <algorithm>
#include <utility>

#include "acquire/sensor/modbus/modbus_reading.h"

namespace haptometer::acquire {
namespace {

using trial::SampleStatus;

constexpr MonotonicNs kQuietNs = 20'000'000;  // damage is over when nothing came for so long
constexpr int kMostBadRows = 8;

// a sound one with registers, as many as were asked for
bool IsReplyTo(const ReadRequest& request, const ModbusReply& reply) {
  if (reply.arrival != ModbusArrival::kFrame) return false;
  // lengths are told apart on RTU alone
  const ReadReply parsed = ParseReadReply(ModbusFraming::kRtu, request, reply.bytes);
  return parsed.fault == ModbusFault::kNone && parsed.exception == 0;
}

}  // namespace

ModbusSensor::ModbusSensor(std::unique_ptr<ModbusLink> link, ModbusSetup setup, Clock& clock)
    : profile_(std::move(setup.profile)),
      rate_hz_(setup.rate_hz),
      link_(std::move(link)),
      clock_(clock) {
  frame_.reserve(kLongestModbusAdu);
  held_registers_.reserve(kLongestModbusAdu);
  if (is_rtu()) exchanges_ = ResponseDeadline(RtuExchangeNs(profile_));
  timestamp_.reserve(kLongestModbusAdu);
}

// --- the wire ---

bool ModbusSensor::Send(ReadRequest request, Phase next) {
  // whatever is there now answers nothing that is still asked; over TCP its identifier says so, and
  // a call is saved while all is well
  if (is_rtu() || bad_rows_ > 0) {
    const std::size_t flushed = link_->Flush();
    discarded_bytes_ += flushed;
    const bool is_answered = phase_ == Phase::kFree && next == Phase::kWaiting;
    const bool is_reply = flushed >= ReplyBytes(link_->framing(), request.count);
    if (is_rtu() && is_answered && is_reply && replies_.taken > 0) ++replies_.surplus;
  }
  request.transaction = next_transaction_++;
  frame_.clear();
  AppendReadRequest(link_->framing(), request, frame_);
  request_ = request;
  request_ns_ = clock_.Now();
  other_transaction_ = false;
  phase_ = next;
  return link_->Send(frame_);
}

ModbusReply ModbusSensor::Receive(MonotonicNs deadline) {
  const ModbusReply reply = link_->Receive(ReplyBytes(link_->framing(), request_.count), deadline);
  if (reply.arrival == ModbusArrival::kFrame || reply.arrival == ModbusArrival::kDamaged) {
    const MonotonicNs silent_ns = is_rtu() ? SilentIntervalNs(profile_.wire) : 0;
    free_from_ns_ = clock_.Now() + std::max(silent_ns, profile_.least_gap_ns);
  }
  return reply;
}

ReadReply ModbusSensor::Parse(const ModbusReply& reply) {
  ReadReply parsed{.fault = reply.fault};
  if (reply.arrival == ModbusArrival::kFrame) {
    parsed = ParseReadReply(link_->framing(), request_, reply.bytes);
  }
  if (parsed.fault != ModbusFault::kNone) ++errors_.faults[static_cast<std::size_t>(parsed.fault)];
  if (parsed.exception != 0) ++errors_.exceptions[static_cast<std::size_t>(parsed.exception)];
  return parsed;
}

// --- the recording ---

MonotonicNs ModbusSensor::Begin() {
  const MonotonicNs now = clock_.Now();
  next_poll_ns_ = settle_since_ns_ = now;
  is_held_ = false;
  if (phase_ == Phase::kWaiting && !is_rtu()) {
    phase_ = Phase::kFree;  // its identifier will tell
  } else if (phase_ == Phase::kWaiting || phase_ == Phase::kStepping) {
    // what was asked before stays outstanding, but its row is none of this recording
    phase_ = has_checks_ ? Phase::kDraining : Phase::kSettling;
    drain_until_ns_ = request_ns_ + profile_.longest_reply_ns;
  } else if (phase_ == Phase::kFree && std::exchange(start_was_silent_, false) && is_rtu()) {
    phase_ = Phase::kSettling;
    drain_until_ns_ = now + profile_.longest_reply_ns;
  }
  return now;
}

Outcome ModbusSensor::Next(Reading& reading) {
  switch (phase_) {
    case Phase::kDraining:
    case Phase::kSettling:
      return Drain(reading);
    case Phase::kStepping:
      return WaitForStep(reading);
    case Phase::kFree: {
      const Outcome asked = AskForReading();
      if (phase_ != Phase::kWaiting || asked == Outcome::kGone) return asked;
      break;
    }
    case Phase::kWaiting:
      break;
  }
  return Wait(reading);
}

// sends the request when its time has come
Outcome ModbusSensor::AskForReading() {
  const MonotonicNs due_ns = std::max(free_from_ns_, next_poll_ns_);
  const MonotonicNs latest_ns = clock_.Now() + kSliceNs;
  if (due_ns > clock_.Now()) clock_.SleepUntil(std::min(due_ns, latest_ns));
  if (clock_.Now() < due_ns) return Outcome::kNothing;
  if (!Send(ReadingRequest(profile_), Phase::kWaiting)) return Outcome::kGone;
  if (rate_hz_) {
    // on a grid; polls that could not be made are not made up for
    const MonotonicNs period_ns = NsFromSeconds(1.0 / *rate_hz_);
    next_poll_ns_ = std::max(next_poll_ns_ + period_ns, request_ns_);
  }
  return Outcome::kNothing;
}

Outcome ModbusSensor::Wait(Reading& reading) {
  const MonotonicNs deadline =
      request_ns_ + (is_held_ ? exchanges_.UsualNs() : profile_.response_timeout_ns);
  const ModbusReply reply = Receive(std::min(deadline, clock_.Now() + kSliceNs));
  switch (reply.arrival) {
    case ModbusArrival::kGone:
      return Outcome::kGone;
    case ModbusArrival::kFrame:
      if (has_checks_ && IsReplyTo(CheckRequest(profile_), reply)) {
        // to one of several that were sent; all of them are older than this reading
        discarded_bytes_ += reply.bytes.size();
        break;
      }
      [[fallthrough]];
    case ModbusArrival::kDamaged:
      if (const auto taken = TakeReply(Parse(reply), reading); taken != Outcome::kNothing) {
        return taken;
      }
      if (is_held_) return Outcome::kNothing;  // with another deadline
      break;
    case ModbusArrival::kNothing:
      break;
  }
  // replies to other requests do not prolong the wait
  if (clock_.Now() < deadline) return Outcome::kNothing;
  if (is_held_) {
    // nothing followed: it is the reply
    return Accept(held_sample_, held_registers_, held_ns_, reading);
  }
  if (!other_transaction_) ++errors_.faults[static_cast<std::size_t>(ModbusFault::kTimeout)];
  return GiveFault(reading, ModbusFault::kTimeout);
}

Outcome ModbusSensor::TakeReply(const ReadReply& reply, Reading& reading) {
  if (reply.fault == ModbusFault::kTransaction) {
    // an older request's reply; ours may still come
    discarded_bytes_ += ReplyBytes(ModbusFraming::kTcp, request_.count);
    other_transaction_ = true;
    return Outcome::kNothing;
  }
  if (reply.fault != ModbusFault::kNone) return GiveFault(reading, reply.fault);
  bad_rows_ = 0;
  if (reply.exception != 0) {
    // an exception has no length: it may be one in reply to an older check
    return GiveRow(reading, {NoValue(profile_.type), SampleStatus::kDeviceError},
                   has_checks_ ? Phase::kDraining : Phase::kFree, clock_.Now() + kQuietNs);
  }
  const MonotonicNs now = clock_.Now();
  const trial::Sample sample = DecodeReading(profile_, reply.registers);
  if (std::exchange(is_held_, now - request_ns_ < exchanges_.EarliestNs())) {
    ++replies_.surplus;
    discarded_bytes_ += ReplyBytes(link_->framing(), request_.count);
  }
  if (!is_held_) return Accept(sample, reply.registers, now, reading);
  held_sample_ = sample;
  held_registers_.assign(reply.registers);
  held_ns_ = now;
  return Outcome::kNothing;
}

Outcome ModbusSensor::Accept(trial::Sample sample, std::string_view registers, MonotonicNs reply_ns,
                             Reading& reading) {
  const MonotonicNs exchange_ns = reply_ns - request_ns_;
  if (exchange_ns < exchanges_.wire_ns()) ++replies_.too_soon;
  ++replies_.taken;
  if (is_rtu()) exchanges_.Note(exchange_ns);
  const Outcome given = GiveRow(reading, sample, Phase::kFree, 0);
  reading.reply_ns = reply_ns;
  MarkRepeated(registers, reading);
  return given;
}

// A row without a reading. What may still come of it is waited for before the next question, but
// over TCP a missing reply can be told from the next by its identifier.
Outcome ModbusSensor::GiveFault(Reading& reading, ModbusFault fault) {
  const bool is_late = fault == ModbusFault::kTimeout;
  if (!is_rtu() && ++bad_rows_ > kMostBadRows) return Outcome::kGone;
  const SampleStatus status =
      is_late && !other_transaction_ ? SampleStatus::kLate : SampleStatus::kBadFrame;
  const bool wait_long = is_late || (is_rtu() && !has_checks_);
  const MonotonicNs until_ns =
      wait_long ? request_ns_ + profile_.longest_reply_ns : clock_.Now() + kQuietNs;
  Phase next = has_checks_ ? Phase::kDraining : Phase::kSettling;
  if (!is_rtu() && is_late) next = Phase::kFree;
  return GiveRow(reading, {NoValue(profile_.type), status}, next, until_ns);
}

Outcome ModbusSensor::Drain(Reading& reading) {
  const MonotonicNs now = clock_.Now();
  // a wire that never falls silent gives bad rows, not nothing for ever
  if (now - settle_since_ns_ > profile_.longest_reply_ns + kNsPerS) {
    request_ns_ = now;
    return GiveRow(reading, {NoValue(profile_.type), SampleStatus::kBadFrame}, phase_,
                   now + kQuietNs);
  }
  if (now >= drain_until_ns_) {
    if (phase_ == Phase::kSettling) {
      phase_ = Phase::kFree;
      return Outcome::kNothing;
    }
    const ReadRequest step =
        next_step_is_check_ ? CheckRequest(profile_) : ReadingRequest(profile_);
    return Send(step, Phase::kStepping) ? Outcome::kNothing : Outcome::kGone;
  }
  const ModbusReply reply = Receive(std::min(drain_until_ns_, now + kSliceNs));
  if (reply.arrival == ModbusArrival::kGone) return Outcome::kGone;
  if (reply.arrival == ModbusArrival::kNothing) return Outcome::kNothing;
  discarded_bytes_ += reply.bytes.size();
  if (phase_ == Phase::kSettling) {
    drain_until_ns_ = std::max(drain_until_ns_, clock_.Now() + kQuietNs);
  } else {
    // the late reply may be the one that a step would wait for
    const bool is_sound = IsReplyTo(ReadingRequest(profile_), reply);
    next_step_is_check_ = next_step_is_check_ || is_sound;
    drain_until_ns_ = is_sound ? free_from_ns_ : clock_.Now() + kQuietNs;
  }
  return Outcome::kNothing;
}

Outcome ModbusSensor::WaitForStep(Reading& reading) {
  const MonotonicNs deadline = request_ns_ + profile_.longest_reply_ns;
  const ModbusReply reply = Receive(std::min(deadline, clock_.Now() + kSliceNs));
  if (reply.arrival == ModbusArrival::kGone) return Outcome::kGone;
  discarded_bytes_ += reply.bytes.size();
  if (IsReplyTo(request_, reply)) {
    const bool is_over = std::exchange(next_step_is_check_, !next_step_is_check_);
    phase_ = is_over ? Phase::kFree : Phase::kDraining;
    drain_until_ns_ = free_from_ns_;
    return Outcome::kNothing;
  }
  if (reply.arrival == ModbusArrival::kFrame && !next_step_is_check_) {
    const ReadReply refused = ParseReadReply(link_->framing(), request_, reply.bytes);
    if (refused.exception != 0) {
      ++errors_.exceptions[static_cast<std::size_t>(refused.exception)];
      return GiveRow(reading, {NoValue(profile_.type), SampleStatus::kDeviceError},
                     Phase::kDraining, clock_.Now() + kQuietNs);
    }
  }
  if (clock_.Now() < deadline) return Outcome::kNothing;
  ++errors_.faults[static_cast<std::size_t>(ModbusFault::kTimeout)];
  return GiveRow(reading, {NoValue(profile_.type), SampleStatus::kLate}, Phase::kDraining,
                 free_from_ns_);
}

// --- rows ---

void ModbusSensor::MarkRepeated(std::string_view registers, Reading& reading) {
  if (repeats_) repeats_->Mark(reading);
  if (!profile_.timestamp_address) return;
  const std::string_view stamp = TimestampOf(profile_, registers);
  trial::Sample& sample = reading.samples.front();
  if (stamp == timestamp_ && sample.status == SampleStatus::kOk) {
    sample.status = SampleStatus::kRepeated;
  }
  timestamp_.assign(stamp);
}

Outcome ModbusSensor::GiveRow(Reading& reading, trial::Sample sample, Phase next,
                              MonotonicNs drain_until_ns) {
  reading.time_ns = request_ns_;
  reading.reply_ns = clock_.Now();
  reading.samples.assign(1, sample);
  is_held_ = false;
  phase_ = next;
  drain_until_ns_ = drain_until_ns;
  settle_since_ns_ = reading.reply_ns;
  return Outcome::kReading;
}

}  // namespace haptometer::acquire
