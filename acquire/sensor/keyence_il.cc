#include "acquire/sensor/keyence_il.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquire/protocol/wire.h"

namespace haptometer::acquire {
namespace {

using dl_rs1a::Command;
using dl_rs1a::Reply;
using dl_rs1a::ReplyKind;
using trial::SampleStatus;

constexpr MonotonicNs kSliceNs = 100'000'000;  // how long Next() waits at most
constexpr MonotonicNs kQuietNs = 20'000'000;   // 19 characters at 9600 baud
constexpr MonotonicNs kWriteTimeNs = kNsPerS;
constexpr int kProbes = 3;

Error Interrupted(const std::string& name) {
  return {Cause::kFailed, name, "was not recorded: interrupted before the first reading", ""};
}

bool IsAnswerToMs(const std::optional<Reply>& reply) {
  return reply && (reply->kind == ReplyKind::kMs ||
                   (reply->kind == ReplyKind::kError && reply->data == "MS"));
}

}  // namespace

KeyenceIl::KeyenceIl(std::unique_ptr<Transport> transport, KeyenceIlSetup setup, Clock& clock)
    : setup_(setup),
      clock_(clock),
      link_(std::move(transport), clock, Delimiter::kCrLf, dl_rs1a::kLongestLine) {}

// --- before the recording ---

Result<std::optional<Reply>> KeyenceIl::Exchange(const dl_rs1a::Request& request,
                                                 const std::atomic<bool>& stop) {
  link_.Flush();
  const std::string& name = link_.transport().name();
  if (auto sent =
          link_.transport().Write(dl_rs1a::FormatRequest(request), clock_.Now() + kWriteTimeNs);
      !sent) {
    return std::unexpected(sent.error());
  }
  const MonotonicNs deadline = clock_.Now() + ResponseDeadline::kLongestNs;
  while (clock_.Now() < deadline) {
    if (stop.load()) return std::unexpected(Interrupted(name));
    const LinkLine line = link_.Read(std::min(deadline, clock_.Now() + kSliceNs));
    if (line.state == LinkState::kGone) {
      return Failed(name, "the connection was lost", "check cable and power");
    }
    if (line.state != LinkState::kLine) continue;
    // a line that answers something else is an old one; views in a reply point into the line
    const std::optional<Reply> reply = dl_rs1a::ParseReply(line.text);
    const bool answers =
        reply && (reply->kind == ReplyKind::kError ||
                  (request.command == Command::kM0 && reply->kind == ReplyKind::kM0) ||
                  (request.command == Command::kSr && reply->kind == ReplyKind::kSr &&
                   reply->number == request.number));
    if (answers) return reply;
    link_.CountDiscarded(line.text.size());
  }
  start_was_silent_ = true;
  return std::nullopt;
}

Result<void> KeyenceIl::Probe(const std::atomic<bool>& stop) {
  std::optional<int> refusal;
  for (int probe = 0; probe < kProbes; ++probe) {
    const auto reply = Exchange({}, stop);
    if (!reply) return std::unexpected(reply.error());
    if (!*reply) continue;
    // half a command left in the unit by somebody else spoils our first one: ask again
    if ((*reply)->kind == ReplyKind::kError) {
      refusal = (*reply)->number;
      continue;
    }
    MakeHeader(**reply);
    return {};
  }
  if (refusal) {
    return CannotAnswer(link_.transport().name(),
                        fmt::format("the unit refuses M0 with error {:02}: {}", *refusal,
                                    dl_rs1a::ErrorText(*refusal)),
                        "see the error list of the DL-RS1A's manual");
  }
  return std::unexpected(NoAnswer(discarded_bytes() > 0));
}

Error KeyenceIl::NoAnswer(bool heard_bytes) const {
  std::string others;
  for (const int baud : {2400, 4800, 9600, 19200, 38400}) {
    if (baud == setup_.baud) continue;
    others += fmt::format("{}{}", others.empty() ? "" : baud == 38400 ? " or " : ", ", baud);
  }
  if (setup_.baud == 38400) others.replace(others.rfind(", "), 2, " or ");
  return {Cause::kCannotAnswer, link_.transport().name(),
          heard_bytes ? fmt::format("bytes come at {} baud, but no reply of a DL-RS1A", setup_.baud)
                      : fmt::format("nothing answers at {} baud", setup_.baud),
          fmt::format("try --baud {}, and check that the amplifier is on, the unit set to 8 data "
                      "bits without parity, and the cable the maker's",
                      others)};
}

Result<void> KeyenceIl::ReadSettings(const std::atomic<bool>& stop) {
  int silences = 0;
  for (const int number : UnitSettings::kNumbers) {
    const auto reply =
        Exchange({.command = Command::kSr, .unit = 0, .number = number, .data = {}}, stop);
    if (!reply) return std::unexpected(reply.error());
    silences = *reply ? 0 : silences + 1;
    if (silences == 2) return {};  // it does not know SR: more questions only cost seconds
    if (*reply && (*reply)->kind == ReplyKind::kSr) {
      settings_.Set(number, std::string((*reply)->data));
    }
  }
  return {};
}

void KeyenceIl::MakeHeader(const Reply& reply) {
  header_.timing = trial::Timing::kPolled;
  header_.channels.clear();
  for (std::size_t unit = 0; unit < reply.units; ++unit) {
    trial::ChannelFormat channel;
    channel.name = unit == 0 ? "displacement" : fmt::format("displacement_{:02}", unit);
    channel.role = trial::ChannelRole::kDisplacement;
    channel.unit = "m";
    channel.encoding = trial::Encoding::kI32;
    channel.scale = channel.resolution = 1e-3 * std::pow(10.0, -reply.values[unit].decimals);
    header_.channels.push_back(channel);
  }
  const std::size_t units = reply.units;
  repeats_ = RepeatMarker(setup_.refresh_ns.value_or(dl_rs1a::RefreshNs(units)));
}

Result<void> KeyenceIl::Start(const std::atomic<bool>& stop) {
  if (auto probed = Probe(stop); !probed) return probed;
  if (auto read = ReadSettings(stop); !read) return read;
  // what the settings say of the first amplifier; the others' are not asked
  trial::Metadata& metadata = header_.metadata;
  metadata.sensor = "keyence-il";
  metadata.source = link_.Source(settings_.is_emulated());
  settings_.Describe(metadata);
  metadata.nominal_rate_hz =
      1.0 / SecondsFromNs(dl_rs1a::PollPeriodNs(setup_.baud, header_.channels.size()));
  if (const dl_rs1a::Head* head = settings_.head(); head != nullptr && head->farthest_mm > 0) {
    header_.channels[0].range_min = 1e-3 * (head->reference_mm - head->farthest_mm);
    header_.channels[0].range_max = 1e-3 * (head->reference_mm - head->nearest_mm);
  }
  return {};
}

std::vector<std::string> KeyenceIl::Remarks() const {
  const std::size_t units = header_.channels.size();
  const double poll_hz = 1.0 / SecondsFromNs(dl_rs1a::PollPeriodNs(setup_.baud, units));
  const double fresh_hz =
      1.0 / SecondsFromNs(setup_.refresh_ns.value_or(dl_rs1a::RefreshNs(units)));
  const double best_hz = 1.0 / SecondsFromNs(dl_rs1a::PollPeriodNs(38400, 1));
  const std::string repeats =
      fresh_hz < poll_hz ? fmt::format(", {:.1f} of them fresh", fresh_hz) : "";
  std::vector<std::string> remarks{
      fmt::format(
          "a DL-RS1A at {} baud gives at most {:.1f} readings/s{}: motion up to {:.1f} Hz can "
          "be observed (rate / 2.56)",
          setup_.baud, poll_hz, repeats, HighestObservableHz(std::min(poll_hz, fresh_hz))),
      fmt::format(
          "20-500 Hz vibration cannot be observed through a DL-RS1A at any baud rate "
          "({:.0f} readings/s at most, 1280 are needed): record the amplifier's analog output "
          "with a DAQ, or a head that sends lines by itself (--sensor stream)",
          best_hz)};
  const std::string latency =
      link_.transport().LatencyCost(dl_rs1a::PollPeriodNs(setup_.baud, units));
  if (!latency.empty()) remarks.push_back(latency);
  const std::vector<std::string> settings = settings_.Remarks();
  remarks.insert(remarks.end(), settings.begin(), settings.end());
  return remarks;
}

// --- the recording ---

MonotonicNs KeyenceIl::Begin() {
  phase_ = start_was_silent_ ? Phase::kQuieting : Phase::kFree;
  return clock_.Now();
}

Outcome KeyenceIl::Next(Reading& reading) {
  if (phase_ == Phase::kDraining || phase_ == Phase::kQuieting) return Settle();
  if (phase_ == Phase::kStepping) return WaitForStep(reading);
  if (phase_ == Phase::kFree && Ask(Command::kM0, Phase::kWaiting) == Outcome::kGone) {
    return Outcome::kGone;
  }
  return Wait(reading);
}

Outcome KeyenceIl::Ask(Command command, Phase next) {
  link_.Flush();  // whatever is there now answers nothing that is still asked
  request_ns_ = clock_.Now();
  const std::string request =
      dl_rs1a::FormatRequest({.command = command, .unit = 0, .number = 0, .data = {}});
  if (!link_.transport().Write(request, request_ns_ + kWriteTimeNs)) return Outcome::kGone;
  phase_ = next;
  return Outcome::kNothing;
}

Outcome KeyenceIl::Wait(Reading& reading) {
  const MonotonicNs deadline = request_ns_ + deadline_.WaitNs();
  const LinkLine line = link_.Read(std::min(deadline, clock_.Now() + kSliceNs));
  switch (line.state) {
    case LinkState::kGone:
      return Outcome::kGone;
    case LinkState::kLine:
      return TakeLine(line.text, reading) ? Outcome::kReading : Outcome::kNothing;
    case LinkState::kOverlong:
      return GiveRow(reading, SampleStatus::kBadFrame, clock_.Now(), Phase::kQuieting);
    case LinkState::kNothing:
      break;
  }
  if (clock_.Now() < deadline) return Outcome::kNothing;
  // half a line is a damaged reply; no byte at all is none yet
  const bool partial = link_.waiting_bytes() > 0;
  return GiveRow(reading, partial ? SampleStatus::kBadFrame : SampleStatus::kLate, deadline,
                 Phase::kDraining);
}

Outcome KeyenceIl::Settle() {
  const MonotonicNs now = clock_.Now();
  const MonotonicNs until = phase_ == Phase::kDraining
                                ? request_ns_ + ResponseDeadline::kLongestNs
                                : std::max(quiet_since_ns_, link_.last_bytes_ns()) + kQuietNs;
  if (now >= until) return Ask(Command::kMs, Phase::kStepping);
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

Outcome KeyenceIl::WaitForStep(Reading& reading) {
  const MonotonicNs deadline = request_ns_ + ResponseDeadline::kLongestNs;
  const LinkLine line = link_.Read(std::min(deadline, clock_.Now() + kSliceNs));
  if (line.state == LinkState::kGone) return Outcome::kGone;
  if (line.state == LinkState::kLine && IsAnswerToMs(dl_rs1a::ParseReply(line.text))) {
    unanswered_steps_ = 0;
    phase_ = Phase::kFree;
    return Outcome::kNothing;
  }
  if (line.state != LinkState::kNothing) link_.CountDiscarded(line.text.size());
  if (clock_.Now() < deadline) return Outcome::kNothing;
  // a unit that answers M0 but never MS is asked M0 again, after seconds of silence
  constexpr int kMostSteps = 2;
  const bool again = ++unanswered_steps_ < kMostSteps;
  if (!again) unanswered_steps_ = 0;
  return GiveRow(reading, SampleStatus::kLate, deadline, again ? Phase::kQuieting : Phase::kFree);
}

bool KeyenceIl::TakeLine(std::string_view line, Reading& reading) {
  const MonotonicNs now = clock_.Now();
  const std::optional<Reply> reply = dl_rs1a::ParseReply(line);
  // a hardware trigger's line was asked by nobody, and MS before this M0
  if (reply && (reply->kind == ReplyKind::kDr || IsAnswerToMs(reply))) {
    link_.CountDiscarded(line.size());
    return false;
  }
  if (reply && reply->kind == ReplyKind::kError) {
    (void)GiveRow(reading, SampleStatus::kDeviceError, now, Phase::kFree);
    return true;
  }
  // the recording's channels and steps are fixed: a reply that differs is not of this unit
  bool fits = reply && reply->kind == ReplyKind::kM0 && reply->units == header_.channels.size();
  for (std::size_t unit = 0; fits && unit < reply->units; ++unit) {
    const double step_m = 1e-3 * std::pow(10.0, -reply->values[unit].decimals);
    fits = step_m == header_.channels[unit].scale;
  }
  if (!fits) {
    link_.CountDiscarded(line.size());
    (void)GiveRow(reading, SampleStatus::kBadFrame, now, Phase::kQuieting);
    return true;
  }
  (void)GiveRow(reading, SampleStatus::kOk, now, Phase::kFree);
  for (std::size_t unit = 0; unit < reply->units; ++unit) {
    const Value& value = reply->values[unit];
    reading.samples[unit] = {trial::RawValue::Counts(value.counts), value.status};
  }
  deadline_.Note(now - request_ns_);
  repeats_.Mark(reading);
  return true;
}

Outcome KeyenceIl::GiveRow(Reading& reading, SampleStatus status, MonotonicNs reply_ns,
                           Phase next) {
  reading.time_ns = request_ns_;
  reading.reply_ns = reply_ns;
  reading.samples.assign(header_.channels.size(), {trial::RawValue::Counts(kNoCounts), status});
  quiet_since_ns_ = clock_.Now();
  phase_ = next;
  return Outcome::kReading;
}

}  // namespace haptometer::acquire
