#include "acquire/sensor/modbus_sensor.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "acquire/protocol/wire.h"
#include "acquire/transport/port_list.h"
#include "trial/trial_format.h"

namespace haptometer::acquire {
namespace {

using trial::SampleStatus;

// What the registers of a Modbus sensor mean by its profile. `registers` are those of one reading,
// as many as profile.count, two bytes each.

// how a trial stores the numbers of a register type without loss
trial::Encoding EncodingOf(RegisterType type) {
  switch (type) {
    case RegisterType::kF32:
      return trial::Encoding::kF32;
    case RegisterType::kU32:  // beyond the counts of i32; exact
      return trial::Encoding::kF64;
    default:
      return trial::Encoding::kI32;
  }
}

// the bits of a reading as the trial's raw number, before scale and offset
trial::RawValue RawOf(std::uint32_t bits, RegisterType type) {
  switch (EncodingOf(type)) {
    case trial::Encoding::kF32:
      return trial::RawValue::Bits(bits);
    case trial::Encoding::kF64:
      return trial::RawValue::F64(NumberOf(bits, type));
    case trial::Encoding::kI32:
      break;
  }
  return trial::RawValue::Counts(static_cast<std::int32_t>(NumberOf(bits, type)));
}

// place of a register in the reply, 0 for the first
std::size_t Offset(const SensorProfile& profile, int address) {
  return static_cast<std::size_t>(address - profile.address);
}

// order of the checks: status register, listed bit patterns, limits of the number as sent
SampleStatus StatusOf(const SensorProfile& profile, std::string_view registers,
                      std::uint32_t bits) {
  if (profile.status_address) {
    const std::uint16_t flags = RegisterAt(registers, Offset(profile, *profile.status_address));
    if ((flags & profile.status_mask) != 0) {
      return profile.status_meaning == StatusMeaning::kInvalid ? SampleStatus::kInvalid
                                                               : SampleStatus::kDeviceError;
    }
  }
  const double number = NumberOf(bits, profile.type);
  const bool is_listed =
      std::ranges::find(profile.invalid_bits, bits) != profile.invalid_bits.end();
  if (!std::isfinite(number) || is_listed) return SampleStatus::kInvalid;
  if (profile.least_number && number < *profile.least_number) return SampleStatus::kUnder;
  if (profile.most_number && number > *profile.most_number) return SampleStatus::kOver;
  return SampleStatus::kOk;
}

// The channel that a trial keeps of it: numbers as sent (f64 for u32, which i32 does not hold).
// `register_scale` is the number in the profile's scale register, else 1.
trial::ChannelFormat ChannelOf(const SensorProfile& profile, double register_scale) {
  trial::ChannelFormat channel;
  channel.name = "displacement";
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.encoding = EncodingOf(profile.type);
  // displacement in m = (number * scale + offset) * unit_m
  channel.scale = profile.scale * register_scale * profile.unit_m;
  channel.offset = profile.offset * profile.unit_m;
  // a whole number changes in steps of one count; for f32 the profile alone states a resolution
  const bool is_whole = profile.type != RegisterType::kF32;
  channel.resolution = profile.resolution_m.value_or(is_whole ? std::abs(channel.scale) : 0);
  // ends of the range in m; `otherwise` where the profile states no limit
  const auto end_m = [&](const std::optional<double>& number, double otherwise) {
    return number ? *number * channel.scale + channel.offset : otherwise;
  };
  const double least_m = end_m(profile.least_number, channel.range_min);
  const double most_m = end_m(profile.most_number, channel.range_max);
  // a negative scale exchanges the two ends: no range is stated then
  if (channel.scale > 0) {
    channel.range_min = profile.range_min_m.value_or(least_m);
    channel.range_max = profile.range_max_m.value_or(most_m);
  }
  return channel;
}

// the number as sent, with its status by the profile and the status register
trial::Sample DecodeReading(const SensorProfile& profile, std::string_view registers) {
  std::array<std::uint16_t, 2> words{};
  const std::size_t count = RegistersOf(profile.type);
  const std::size_t first = Offset(profile, profile.value_address);
  // 16-bit words in the order of the wire; type and word order join them
  for (std::size_t i = 0; i < count; ++i) words[i] = RegisterAt(registers, first + i);
  const std::uint32_t bits = BitsFrom(std::span(words).first(count), profile.type, profile.order);
  return {RawOf(bits, profile.type), StatusOf(profile, registers, bits)};
}

// the number of a row without a reading: NaN, or kNoCounts where the channel holds counts
trial::RawValue NoValue(RegisterType type) {
  switch (EncodingOf(type)) {
    case trial::Encoding::kF32:
      return trial::RawValue::F32(std::numeric_limits<float>::quiet_NaN());
    case trial::Encoding::kF64:
      return trial::RawValue::F64(std::numeric_limits<double>::quiet_NaN());
    case trial::Encoding::kI32:
      break;
  }
  return trial::RawValue::Counts(kNoCounts);
}

// the timestamp registers; the profile has some
std::string_view TimestampOf(const SensorProfile& profile, std::string_view registers) {
  return registers.substr(2 * Offset(profile, *profile.timestamp_address),
                          2 * static_cast<std::size_t>(profile.timestamp_count));
}

}  // namespace

std::string InWords(const ModbusErrors& errors) {
  std::string text;
  const auto add = [&](std::uint64_t count, std::string what) {
    if (count == 0) return;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  };
  // damaged and missing replies first, then exceptions by their code
  for (std::size_t fault = 0; fault < kModbusFaultCount; ++fault) {
    add(errors.faults[fault], std::string(Name(static_cast<ModbusFault>(fault))));
  }
  for (std::size_t code = 0; code < errors.exceptions.size(); ++code) {
    add(errors.exceptions[code],
        fmt::format("exception {:02} ({})", code, ModbusExceptionText(static_cast<int>(code))));
  }
  return text;
}

// --- the wire and the recording ---
namespace {

constexpr MonotonicNs kQuietNs = 20'000'000;  // damage is over when nothing came for so long
// TCP: a peer that is one reply behind does not recover, so the connection counts as lost then
constexpr int kMostBadRows = 8;

// a sound reply with as many registers as the request asks for
bool IsReplyTo(const ReadRequest& request, const ModbusReply& reply) {
  if (reply.arrival != ModbusArrival::kFrame) return false;
  // only RTU needs it: its frames carry no identifier, so the length distinguishes replies
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
  // lower limit of a reply time: both frames at the baud rate of the wire
  if (is_rtu()) exchanges_ = ResponseDeadline(RtuExchangeNs(profile_));
  timestamp_.reserve(kLongestModbusAdu);
}

// --- the wire ---

bool ModbusSensor::Send(ReadRequest request, Phase next) {
  // bytes that wait now belong to no open request; TCP omits the call while all rows are sound,
  // since the transaction identifier excludes old replies
  if (is_rtu() || bad_rows_ > 0) {
    const std::size_t flushed = link_->Flush();
    discarded_bytes_ += flushed;
    // a whole reply while nothing is outstanding is a second one to a request already answered
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
  const std::size_t bytes = ReplyBytes(link_->framing(), request_.count);
  ModbusReply reply = link_->Receive(bytes, deadline);
  if (reply.arrival == ModbusArrival::kEcho) {
    ++echoes_;
    reply = link_->Receive(bytes, deadline);
  }
  // RTU: silent interval of 3.5 characters after a frame, or the sensor's own gap if longer
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
  // one reply counts once: as a fault or as an exception
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
    phase_ = Phase::kFree;  // the identifier distinguishes its reply
  } else if (phase_ == Phase::kWaiting || phase_ == Phase::kStepping) {
    // what was asked before stays outstanding, but its row is none of this recording
    phase_ = has_checks_ ? Phase::kDraining : Phase::kSettling;
    drain_until_ns_ = request_ns_ + profile_.longest_reply_ns;
  } else if (phase_ == Phase::kFree && std::exchange(start_was_silent_, false) && is_rtu()) {
    // a late reply to Start() must not become the first row
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
  // the silent interval has passed, and the poll is due
  const MonotonicNs due_ns = std::max(free_from_ns_, next_poll_ns_);
  // one slice at most, so that the caller can stop the recording
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
  // a reply that is held waits for a usual exchange; otherwise the maker's timeout
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
    case ModbusArrival::kEcho:
    case ModbusArrival::kNothing:
      break;
  }
  // replies to other requests do not prolong the wait
  if (clock_.Now() < deadline) return Outcome::kNothing;
  if (is_held_) {
    // nothing followed: it is the reply
    return Accept(held_sample_, held_registers_, held_ns_, reading);
  }
  // a part of a reply is a damaged one
  const bool is_cut = reply.arrival == ModbusArrival::kNothing && reply.fault != ModbusFault::kNone;
  const ModbusFault fault = is_cut ? reply.fault : ModbusFault::kTimeout;
  if (is_cut || !other_transaction_) ++errors_.faults[static_cast<std::size_t>(fault)];
  return GiveFault(reading, fault);
}

Outcome ModbusSensor::TakeReply(const ReadReply& reply, Reading& reading) {
  if (reply.fault == ModbusFault::kTransaction) {
    // a reply to an older request; the right one may still come
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
  // held: sooner than the wire or the fastest exchanges allow; the right reply may follow
  if (std::exchange(is_held_, now - request_ns_ < exchanges_.EarliestNs())) {
    ++replies_.surplus;
    discarded_bytes_ += ReplyBytes(link_->framing(), request_.count);
  }
  // the earlier held reply, if any, was surplus; the latest one is the candidate
  if (!is_held_) return Accept(sample, reply.registers, now, reading);
  held_sample_ = sample;
  held_registers_.assign(reply.registers);
  held_ns_ = now;
  return Outcome::kNothing;
}

Outcome ModbusSensor::Accept(trial::Sample sample, std::string_view registers, MonotonicNs reply_ns,
                             Reading& reading) {
  const MonotonicNs exchange_ns = reply_ns - request_ns_;
  // sooner than both frames on the wire: the reply may be one of an earlier request
  if (exchange_ns < exchanges_.wire_ns()) ++replies_.too_soon;
  ++replies_.taken;
  if (is_rtu()) exchanges_.Note(exchange_ns);
  const Outcome given = GiveRow(reading, sample, Phase::kFree, 0);
  reading.reply_ns = reply_ns;
  MarkRepeated(registers, reading);
  return given;
}

// A row without a reading. What may still come of it is waited for before the next request, but
// over TCP the identifier distinguishes a late reply from the next one.
Outcome ModbusSensor::GiveFault(Reading& reading, ModbusFault fault) {
  const bool is_late = fault == ModbusFault::kTimeout;
  if (!is_rtu() && ++bad_rows_ > kMostBadRows) return Outcome::kGone;
  // late only where nothing came: a reply to another request is a bad frame
  const SampleStatus status =
      is_late && !other_transaction_ ? SampleStatus::kLate : SampleStatus::kBadFrame;
  // a late reply comes within longest_reply_ns; after damage a silent wire is sufficient
  const bool wait_long = is_late || (is_rtu() && !has_checks_);
  const MonotonicNs until_ns =
      wait_long ? request_ns_ + profile_.longest_reply_ns : clock_.Now() + kQuietNs;
  // with checks, replies of two lengths alternate; without them, only time separates replies
  Phase next = has_checks_ ? Phase::kDraining : Phase::kSettling;
  if (!is_rtu() && is_late) next = Phase::kFree;
  return GiveRow(reading, {NoValue(profile_.type), status}, next, until_ns);
}

Outcome ModbusSensor::Drain(Reading& reading) {
  const MonotonicNs now = clock_.Now();
  // a wire that never becomes silent gives bad rows, not an endless wait
  if (now - settle_since_ns_ > profile_.longest_reply_ns + kNsPerS) {
    request_ns_ = now;
    return GiveRow(reading, {NoValue(profile_.type), SampleStatus::kBadFrame}, phase_,
                   now + kQuietNs);
  }
  // the wait is over: poll again, or send the next of the two steps
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
  // every reply in this phase is an old one
  discarded_bytes_ += reply.bytes.size();
  if (phase_ == Phase::kSettling) {
    // each frame starts the silent time again
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
  // a reading's reply is followed by a check; the check's reply ends the resynchronisation
  if (IsReplyTo(request_, reply)) {
    const bool is_over = std::exchange(next_step_is_check_, !next_step_is_check_);
    phase_ = is_over ? Phase::kFree : Phase::kDraining;
    drain_until_ns_ = free_from_ns_;
    return Outcome::kNothing;
  }
  // an exception to the reading step is a row of its own: the step is still open
  if (reply.arrival == ModbusArrival::kFrame && !next_step_is_check_) {
    const ReadReply refused = ParseReadReply(link_->framing(), request_, reply.bytes);
    if (refused.exception != 0) {
      ++errors_.exceptions[static_cast<std::size_t>(refused.exception)];
      return GiveRow(reading, {NoValue(profile_.type), SampleStatus::kDeviceError},
                     Phase::kDraining, clock_.Now() + kQuietNs);
    }
  }
  if (clock_.Now() < deadline) return Outcome::kNothing;
  // no reply to the step: a late row, and the step is sent again
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
  // unchanged timestamp registers: no new measurement since the last poll
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

// What comes before the recording: the first answers, the header, the findings.
namespace {

// for the scale register and the first reading
constexpr int kTries = 3;

}  // namespace

// first sound reply within `tries` requests, else the last fault
Result<ReadReply> ModbusSensor::Exchange(ReadRequest request, int tries,
                                         const std::atomic<bool>& stop) {
  ReadReply answer{.fault = ModbusFault::kTimeout};
  for (int attempt = 0; attempt < tries; ++attempt) {
    clock_.SleepUntil(free_from_ns_);
    // what is there belongs to the try before
    if (attempt > 0) discarded_bytes_ += link_->Flush();
    if (!Send(request, Phase::kFree)) {
      return Failed(link_->name(), "the connection was lost", "check cable and power");
    }
    const MonotonicNs deadline = request_ns_ + profile_.longest_reply_ns;
    while (clock_.Now() < deadline) {
      if (stop.load()) {
        return Failed(link_->name(), "was not recorded: interrupted before the first reading");
      }
      const ModbusReply reply = Receive(std::min(deadline, clock_.Now() + kSliceNs));
      if (reply.arrival == ModbusArrival::kGone) {
        return Failed(link_->name(), "the connection was lost", "check cable and power");
      }
      if (reply.arrival == ModbusArrival::kNothing) {
        // a part of a reply
        if (reply.fault != ModbusFault::kNone) answer.fault = reply.fault;
        continue;
      }
      answer = Parse(reply);
      if (answer.fault == ModbusFault::kNone) return answer;
      // a damaged reply: the right one may follow before the deadline
      discarded_bytes_ += reply.bytes.size();
    }
    // a reply to this try may come during the next one, or after Start()
    start_was_silent_ = true;
  }
  return answer;
}

// the registers, or why there are none
Result<std::string> ModbusSensor::Ask(ReadRequest request, const std::atomic<bool>& stop) {
  HAPTOMETER_LET(const auto answer, Exchange(request, kTries, stop));
  if (answer.fault == ModbusFault::kNone && answer.exception == 0) {
    return std::string(answer.registers);
  }
  const std::string asked =
      fmt::format("slave {}, function {:02}, {} registers from {}", request.unit, request.function,
                  request.count, request.address + profile_.address_base);
  if (answer.exception != 0) {
    return CannotAnswer(
        link_->name(),
        fmt::format("refuses {} with exception {:02} ({})", asked, answer.exception,
                    ModbusExceptionText(answer.exception)),
        profile_.advice.empty() ? "give the <profile> of this sensor" : profile_.advice);
  }
  if (echoes_ > 0 && answer.fault == ModbusFault::kTimeout) {
    return CannotAnswer(link_->name(),
                        fmt::format("sends each request back, and nothing answers to {}", asked),
                        std::string(kEchoRemedy));
  }
  const std::string settings =
      fmt::format("{} baud, parity {}", profile_.wire.baud, Name(profile_.wire.parity));
  std::string remedy = fmt::format("check that the sensor is on, <slave>{}",
                                   is_rtu() ? ", baud rate and parity in the profile, and A and B "
                                              "of the cable"
                                            : " and the <profile>");
  if (!profile_.advice.empty()) remedy += "; " + profile_.advice;
  return CannotAnswer(
      link_->name(),
      answer.fault == ModbusFault::kTimeout
          ? fmt::format("nothing answers to {}{}", asked, is_rtu() ? " at " + settings : "")
          : fmt::format("answers to {} come damaged ({})", asked, Name(answer.fault)),
      remedy);
}

Result<void> ModbusSensor::Start(const std::atomic<bool>& stop) {
  double register_scale = 1;
  // the register, for example the measuring range in mm, multiplies the scale of the profile
  if (profile_.scale_address) {
    ReadRequest request = ReadingRequest(profile_);
    request.address = static_cast<std::uint16_t>(*profile_.scale_address - profile_.address_base);
    request.count = 1;
    HAPTOMETER_LET(const auto registers, Ask(request, stop));
    register_scale = RegisterAt(registers, 0);
    if (register_scale == 0) {
      return CannotAnswer(
          link_->name(),
          fmt::format("register {}, which scales its values, holds 0", *profile_.scale_address),
          profile_.advice.empty() ? "check the <profile>" : profile_.advice);
    }
  }
  // no trial is made unless one reading succeeds
  HAPTOMETER_TRY(Ask(ReadingRequest(profile_), stop));
  MakeHeader(register_scale);
  return LearnCheck(stop);
}

// TCP needs no checks: the transaction identifiers distinguish replies
Result<void> ModbusSensor::LearnCheck(const std::atomic<bool>& stop) {
  if (!is_rtu()) return {};
  const bool was_silent = std::exchange(start_was_silent_, false);
  HAPTOMETER_LET(const auto answer, Exchange(CheckRequest(profile_), 1, stop));
  // exceptions to both requests have one length, so only registers are an answer
  has_checks_ = answer.fault == ModbusFault::kNone && answer.exception == 0;
  // replies come in order: registers of the check follow all older replies
  start_was_silent_ = !has_checks_ && (start_was_silent_ || was_silent);
  // errors before the recording do not count
  errors_ = {};
  return {};
}

void ModbusSensor::MakeHeader(double register_scale) {
  header_.timing = trial::Timing::kPolled;
  header_.channels = {ChannelOf(profile_, register_scale)};
  Describe(header_.metadata);
  // without a timestamp, a repetition is inferred from the sensor's own period
  if (!profile_.timestamp_address && profile_.fastest_rate_hz) {
    repeats_.emplace(NsFromSeconds(1.0 / *profile_.fastest_rate_hz));
  }
}

void ModbusSensor::Describe(trial::Metadata& metadata) const {
  metadata.sensor = "modbus";
  metadata.source = link_->Source();
  AddLatencyTimer(link_->LatencyTimer(), metadata);
  metadata.head = profile_.model.empty() ? profile_.name : profile_.maker + " " + profile_.model;
  // nominal rate in Hz: least of sensor, wire and requested rate
  double highest_hz = profile_.fastest_rate_hz.value_or(std::numeric_limits<double>::infinity());
  if (is_rtu()) highest_hz = HighestRateHz(profile_);
  highest_hz = std::min(highest_hz, rate_hz_.value_or(highest_hz));
  if (highest_hz < std::numeric_limits<double>::infinity()) metadata.nominal_rate_hz = highest_hz;
  const ReadRequest request = ReadingRequest(profile_);
  metadata.fields["modbus_profile"] = profile_.name;
  metadata.fields["modbus_slave"] = std::to_string(request.unit);
  metadata.fields["modbus_function"] = std::to_string(request.function);
  metadata.fields["modbus_address_on_the_wire"] = std::to_string(request.address);
  metadata.fields["modbus_count"] = std::to_string(request.count);
  metadata.fields["modbus_value"] =
      fmt::format("{} {} at {}", Name(profile_.type), Name(profile_.order), profile_.value_address);
}

Findings ModbusSensor::Found() const {
  // of the connection that is used, whichever the profile is written for
  SensorProfile connected = profile_;
  connected.transport = is_rtu() ? ModbusFraming::kRtu : ModbusFraming::kTcp;
  Findings found = FindWireRate(connected);
  if (is_rtu() && profile_.transport == ModbusFraming::kTcp) {
    found.Doubt(FindingKind::kTcpProfile, {{"profile", profile_.name}});
  }
  if (is_rtu() && !has_checks_) {
    found.Doubt(FindingKind::kNoCheckRequest,
                {{"profile", profile_.name},
                 {"longest_reply_s", SecondsFromNs(profile_.longest_reply_ns)}});
  }
  if (const std::string errors = InWords(errors_); !errors.empty()) {
    found.Doubt(FindingKind::kWireErrors, {{"errors", errors}});
  }
  if (echoes_ > 0) found.Doubt(FindingKind::kEcho, {{"echoes", echoes_}});
  found.AddAll(DoubtfulReplies(replies_, exchanges_.wire_ns()));
  return found;
}

}  // namespace haptometer::acquire
