#include "acquire/sensor/polled_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquire/protocol/wire.h"
#include "base/median.h"
#include "base/text.h"

namespace haptometer::acquire {
namespace {

// equal raw bits and statuses in all channels
bool SameContent(const std::vector<trial::Sample>& a, const std::vector<trial::Sample>& b) {
  return std::ranges::equal(a, b, [](const trial::Sample& x, const trial::Sample& y) {
    return x.raw.bits() == y.raw.bits() && x.status == y.status;
  });
}

}  // namespace

void RepeatMarker::Mark(Reading& reading) {
  const bool is_equal = SameContent(content_, reading.samples);
  // new: another content, or the buffer has been refilled since it was first read
  if (!is_equal || reading.time_ns - first_seen_ns_ >= refresh_ns_) {
    content_ = reading.samples;
    first_seen_ns_ = reading.time_ns;
    return;
  }
  // the same refresh period: it may be the same buffer content; bad statuses remain
  for (trial::Sample& sample : reading.samples) {
    if (sample.status == trial::SampleStatus::kOk) sample.status = trial::SampleStatus::kRepeated;
  }
}

// ring of the last 64 exchange times
void ResponseDeadline::Note(MonotonicNs exchange_ns) {
  exchanges_ns_[noted_++ % exchanges_ns_.size()] = exchange_ns;
}

MonotonicNs ResponseDeadline::WaitNs() const {
  constexpr MonotonicNs kFactor = 4;
  if (noted_ < exchanges_ns_.size()) return kLongestNs;  // too few to know the slow ones
  // four times the slowest of the last 64 exchanges, within 50 ms and 1 s
  return std::clamp(kFactor * std::ranges::max(exchanges_ns_), kShortestNs, kLongestNs);
}

MonotonicNs ResponseDeadline::EarliestNs() const {
  // until 64 exchanges are noted, only the wire time is a sure lower limit
  if (noted_ < exchanges_ns_.size()) return wire_ns_;
  // 0.9 times the fastest of the last 64 exchanges, and not below the wire time
  return std::max(wire_ns_, std::ranges::min(exchanges_ns_) / 10 * 9);
}

MonotonicNs ResponseDeadline::UsualNs() const {
  if (noted_ < exchanges_ns_.size()) return wire_ns_;
  // 1.5 times the median: the right reply follows one that came too soon within this time
  return std::max(EarliestNs(), UpperMedian(exchanges_ns_) * 3 / 2);
}

Findings DoubtfulReplies(const ReplyCounts& replies, MonotonicNs wire_ns) {
  Findings found;
  if (replies.surplus > 0) {
    found.Doubt(FindingKind::kSurplusReplies, {{"replies", replies.surplus}});
  }
  // rate_hz: highest rate at which request and reply fit on the wire
  if (replies.too_soon > 0) {
    const double wire_s = SecondsFromNs(wire_ns);
    found.Doubt(FindingKind::kRepliesTooSoon, {{"too_soon", replies.too_soon},
                                               {"replies", replies.taken},
                                               {"wire_s", wire_s},
                                               {"rate_hz", 1 / wire_s}});
  }
  return found;
}

namespace {

using trial::SampleStatus;

constexpr MonotonicNs kSliceNs = 100'000'000;  // how long Next() waits at most
constexpr MonotonicNs kQuietNs = 20'000'000;   // 19 characters at 9600 baud
constexpr MonotonicNs kWriteTimeNs = kNsPerS;
constexpr std::size_t kMostShown = 24;  // characters of a reply in another form

}  // namespace

PolledLine::PolledLine(std::unique_ptr<Transport> transport, Clock& clock, Delimiter delimiter,
                       std::size_t longest_line)
    : clock_(clock), link_(std::move(transport), clock, delimiter, longest_line) {}

// --- before the recording ---

Result<bool> PolledLine::Exchange(std::string_view request,
                                  const std::function<bool(std::string_view line)>& take,
                                  const std::atomic<bool>& stop) {
  // bytes before the request are no reply to it
  link_.Flush();
  HAPTOMETER_TRY(link_.transport().Write(request, clock_.Now() + kWriteTimeNs));
  const MonotonicNs deadline = clock_.Now() + ResponseDeadline::kLongestNs;
  while (clock_.Now() < deadline) {
    if (stop.load()) {
      return Failed(name(), "was not recorded: interrupted before the first reading");
    }
    const LinkLine line = link_.Read(std::min(deadline, clock_.Now() + kSliceNs));
    if (line.state == LinkState::kGone) {
      return Failed(name(), "the connection was lost", "check cable and power");
    }
    if (line.state != LinkState::kLine) continue;
    if (take(line.text)) return true;
    // a line of another kind: the reply may still follow
    CountEcho(line.text, request);
    link_.CountDiscarded(line.text.size());
  }
  // a reply may still come: Begin() then waits for silence first
  start_was_silent_ = true;
  return false;
}

// --- the recording ---

MonotonicNs PolledLine::Begin(const LineDialect& dialect, PollPlan plan) {
  dialect_ = &dialect;
  plan_ = plan;
  repeats_ = RepeatMarker(plan.refresh_ns);
  // exchange times of another wire or request do not apply
  if (deadline_.wire_ns() != plan.wire_ns) deadline_ = ResponseDeadline(plan.wire_ns);
  is_held_ = false;
  // what was asked before a second beginning may still be answered
  if (phase_ == Phase::kWaiting || phase_ == Phase::kStepping) phase_ = Phase::kDraining;
  if (phase_ == Phase::kFree && start_was_silent_) phase_ = Phase::kQuieting;
  slot_ = 0;
  slot_is_used_ = false;
  return settle_since_ns_ = begin_ns_ = clock_.Now();
}

Outcome PolledLine::Next(Reading& reading) {
  if (phase_ == Phase::kDraining || phase_ == Phase::kQuieting) return Settle(reading);
  if (phase_ == Phase::kStepping) return WaitForStep(reading);
  if (phase_ == Phase::kFree) {
    if (const Outcome asked = WaitForSlot(); asked == Outcome::kGone) return asked;
    if (phase_ == Phase::kFree) return Outcome::kNothing;
  }
  return Wait(reading);
}

// asks at the grid's next instant that is not over yet, so two polls are never nearer than 1 / rate
Outcome PolledLine::WaitForSlot() {
  if (!plan_.rate_hz) return Ask(dialect_->PollRequest(), Phase::kWaiting);
  const MonotonicNs now = clock_.Now();
  // instant of the slot: begin + slot / rate
  const auto due_ns = [&] {
    return begin_ns_ + NsFromSeconds(static_cast<double>(slot_) / *plan_.rate_hz);
  };
  if (slot_is_used_) {
    // the quotient may be off by one at a slot's own instant
    const double passed = std::floor(SecondsFromNs(now - begin_ns_) * *plan_.rate_hz);
    slot_ = std::max(slot_ + 1, static_cast<std::int64_t>(passed));
    while (due_ns() < now) ++slot_;
    slot_is_used_ = false;
  }
  // between two polls the line is read, so that a disconnection is noticed
  if (now < due_ns()) {
    const LinkLine line = link_.Read(std::min(due_ns(), now + kSliceNs));
    if (line.state == LinkState::kGone) return Outcome::kGone;
    if (line.state != LinkState::kNothing) link_.CountDiscarded(line.text.size());
    if (clock_.Now() < due_ns()) return Outcome::kNothing;
  }
  slot_is_used_ = true;
  return Ask(dialect_->PollRequest(), Phase::kWaiting);
}

// whole replies that wait though no request is outstanding
void PolledLine::DropAnswered() {
  constexpr int kMostLines = 64;  // of a device that never stops; the rest is flushed
  held_.samples.assign(plan_.channels, {trial::RawValue::Counts(kNoCounts), {}});
  for (int i = 0; i < kMostLines; ++i) {
    const LinkLine line = link_.Read(clock_.Now());
    // no further whole line waits
    if (line.state != LinkState::kLine && line.state != LinkState::kOverlong) return;
    if (dialect_->Read(line.text, held_.samples) == LineMeaning::kReading) ++replies_.surplus;
    link_.CountDiscarded(line.text.size());
  }
}

Outcome PolledLine::Ask(std::string_view request, Phase next) {
  // bytes that wait now belong to no open request
  if (phase_ == Phase::kFree) DropAnswered();
  link_.Flush();
  request_ns_ = clock_.Now();
  if (!link_.transport().Write(request, request_ns_ + kWriteTimeNs)) return Outcome::kGone;
  phase_ = next;
  return Outcome::kNothing;
}

Outcome PolledLine::Wait(Reading& reading) {
  // a reply that is held waits for a usual exchange only
  const MonotonicNs deadline = request_ns_ + (is_held_ ? deadline_.UsualNs() : deadline_.WaitNs());
  const LinkLine line = link_.Read(std::min(deadline, clock_.Now() + kSliceNs));
  switch (line.state) {
    case LinkState::kGone:
      return Outcome::kGone;
    case LinkState::kLine:
      if (TakeLine(line.text, reading)) return Outcome::kReading;
      if (is_held_) return Outcome::kNothing;  // with another deadline
      break;  // lines that no request asked for do not prolong the wait
    case LinkState::kOverlong:
      return GiveRow(reading, SampleStatus::kBadFrame, clock_.Now(), Phase::kQuieting);
    case LinkState::kNothing:
      break;
  }
  if (clock_.Now() < deadline) return Outcome::kNothing;
  if (is_held_) {
    // nothing followed: it is the reply
    reading.samples.assign(held_.samples.begin(), held_.samples.end());
    reading.time_ns = request_ns_;
    reading.reply_ns = held_.reply_ns;
    return Accept(reading);
  }
  // half a line is a damaged reply; no byte at all is none yet
  const bool partial = link_.waiting_bytes() > 0;
  return GiveRow(reading, partial ? SampleStatus::kBadFrame : SampleStatus::kLate, deadline,
                 Phase::kDraining);
}

Outcome PolledLine::Settle(Reading& reading) {
  const MonotonicNs now = clock_.Now();
  // a line that never becomes silent gives one bad row per second, not an endless wait
  if (now - settle_since_ns_ > ResponseDeadline::kLongestNs + kQuietNs) {
    request_ns_ = now;
    return GiveRow(reading, SampleStatus::kBadFrame, now, Phase::kQuieting);
  }
  // draining: until a late reply can come no more; quieting: until 20 ms of silence
  const MonotonicNs until = phase_ == Phase::kDraining
                                ? request_ns_ + ResponseDeadline::kLongestNs
                                : std::max(quiet_since_ns_, link_.last_bytes_ns()) + kQuietNs;
  // the line is free: a request of another kind, whose reply shows that the device is in step
  if (now >= until) return Ask(dialect_->StepRequest(), Phase::kStepping);
  const LinkLine line = link_.Read(std::min(until, now + kSliceNs));
  if (line.state == LinkState::kGone) return Outcome::kGone;
  if (line.state != LinkState::kNothing) {
    link_.CountDiscarded(line.text.size());
    quiet_since_ns_ = clock_.Now();
    // the late reply is here: nothing is outstanding any more
    if (phase_ == Phase::kDraining) phase_ = Phase::kQuieting;
  }
  return Outcome::kNothing;
}

Outcome PolledLine::WaitForStep(Reading& reading) {
  const MonotonicNs deadline = request_ns_ + ResponseDeadline::kLongestNs;
  const LinkLine line = link_.Read(std::min(deadline, clock_.Now() + kSliceNs));
  if (line.state == LinkState::kGone) return Outcome::kGone;
  // the device answers in order, so all older replies have come
  if (line.state == LinkState::kLine && dialect_->AnswersStep(line.text)) {
    unanswered_steps_ = 0;
    phase_ = Phase::kFree;
    return Outcome::kNothing;
  }
  if (line.state != LinkState::kNothing) link_.CountDiscarded(line.text.size());
  if (clock_.Now() < deadline) return Outcome::kNothing;
  // a device that answers polls but never the step is polled again, after seconds of silence
  constexpr int kMostSteps = 2;
  const bool again = ++unanswered_steps_ < kMostSteps;
  if (!again) unanswered_steps_ = 0;
  return GiveRow(reading, SampleStatus::kLate, deadline, again ? Phase::kQuieting : Phase::kFree);
}

// whether the line, which is no reply, is the request itself without its end
bool PolledLine::CountEcho(std::string_view line, std::string_view request) {
  if (line.empty() || line != request.substr(0, request.find_first_of("\r\n"))) return false;
  ++echoes_;
  return true;
}

bool PolledLine::TakeLine(std::string_view line, Reading& reading) {
  const MonotonicNs now = clock_.Now();
  // no value until the dialect has read one
  reading.samples.assign(plan_.channels, {trial::RawValue::Counts(kNoCounts), {}});
  switch (dialect_->Read(line, reading.samples)) {
    case LineMeaning::kOther:
      link_.CountDiscarded(line.size());
      return false;
    case LineMeaning::kRefusal:
      (void)GiveRow(reading, SampleStatus::kDeviceError, now, Phase::kFree);
      return true;
    case LineMeaning::kOtherForm:
      if (other_forms_++ == 0) other_form_ = Printable(line.substr(0, kMostShown));
      [[fallthrough]];
    case LineMeaning::kDamaged:
      link_.CountDiscarded(line.size());
      if (CountEcho(line, dialect_->PollRequest())) return false;
      (void)GiveRow(reading, SampleStatus::kBadFrame, now, Phase::kQuieting);
      return true;
    case LineMeaning::kReading:
      break;
  }
  reading.time_ns = request_ns_;
  reading.reply_ns = now;
  // held: sooner than the wire or the fastest exchanges allow; the right reply may follow
  if (std::exchange(is_held_, now - request_ns_ < deadline_.EarliestNs())) {
    ++replies_.surplus;
    link_.CountDiscarded(held_bytes_);
  }
  if (!is_held_) return Accept(reading) == Outcome::kReading;
  held_bytes_ = line.size();
  held_.samples.assign(reading.samples.begin(), reading.samples.end());
  held_.reply_ns = now;
  return false;
}

Outcome PolledLine::Accept(Reading& reading) {
  const MonotonicNs exchange_ns = reading.reply_ns - request_ns_;
  // sooner than request and reply need on the wire
  if (exchange_ns < deadline_.wire_ns()) ++replies_.too_soon;
  ++replies_.taken;
  is_held_ = false;
  phase_ = Phase::kFree;
  // the time of a good exchange moves the deadlines of the next ones
  deadline_.Note(exchange_ns);
  repeats_.Mark(reading);
  return Outcome::kReading;
}

// a row without a value
Outcome PolledLine::GiveRow(Reading& reading, SampleStatus status, MonotonicNs reply_ns,
                            Phase next) {
  reading.time_ns = request_ns_;
  reading.reply_ns = reply_ns;
  reading.samples.assign(plan_.channels, {trial::RawValue::Counts(kNoCounts), status});
  settle_since_ns_ = quiet_since_ns_ = clock_.Now();
  is_held_ = false;
  phase_ = next;
  return Outcome::kReading;
}

Findings PolledLine::Found() const {
  Findings found = DoubtfulReplies(replies_, deadline_.wire_ns());
  if (other_forms_ > 0) {
    found.Doubt(FindingKind::kOtherForm, {{"replies", other_forms_}, {"example", other_form_}});
  }
  if (echoes_ > 0) found.Doubt(FindingKind::kEcho, {{"echoes", echoes_}});
  return found;
}

}  // namespace haptometer::acquire
