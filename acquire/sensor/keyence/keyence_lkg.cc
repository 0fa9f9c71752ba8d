#include "acquire/sensor/keyence/keyence_lkg.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquire/protocol/wire.h"
#include "acquire/transport/port_list.h"
#include "base/error.h"

namespace haptometer::acquire {
namespace {

using lkg::Command;
using lkg::Reply;
using lkg::ReplyKind;

constexpr int kProbes = 3;

// `value` in steps of `decimals`; nothing where that would lose a digit
std::optional<std::int32_t> CountsAt(const Value& value, int decimals) {
  if (value.counts == kNoCounts) return kNoCounts;
  if (value.decimals > decimals) return std::nullopt;
  const std::int64_t counts = std::int64_t{value.counts} * PowerOfTen(decimals - value.decimals);
  if (std::abs(counts) > PowerOfTen(9)) return std::nullopt;
  return static_cast<std::int32_t>(counts);
}

// the decimals of the first number in `reply`
std::optional<int> DecimalsOf(const Reply& reply) {
  for (std::size_t i = 0; i < reply.outs; ++i) {
    if (reply.values[i].counts != kNoCounts) return reply.values[i].decimals;
  }
  return std::nullopt;
}

std::string OutName(Command command, std::size_t place) {
  if (command == Command::kM2) return "displacement_OUT2";
  return place == 0 ? "displacement" : "displacement_OUT2";
}

}  // namespace

LkgPoll::LkgPoll(Command command)
    : command_(command),
      step_command_(command == Command::kM1 ? Command::kM2 : Command::kM1),
      poll_(lkg::FormatRequest(command)),
      step_(lkg::FormatRequest(step_command_)) {
  HAPTOMETER_CHECK(lkg::ValuesOf(command) > 0, "command {}", lkg::Name(command));
}

bool LkgPoll::AnswersStep(std::string_view line) const {
  const auto reply = lkg::ParseReply(line);
  return reply && lkg::Answers(*reply, step_command_);
}

LineMeaning LkgPoll::Read(std::string_view line, std::span<trial::Sample> samples) const {
  const auto reply = lkg::ParseReply(line);
  if (!reply) return LineMeaning::kDamaged;
  // what comes at the timing input was asked by nobody, and the step before this poll
  if (reply->kind == ReplyKind::kOutput || lkg::Answers(*reply, step_command_)) {
    return LineMeaning::kOther;
  }
  if (reply->kind == ReplyKind::kError) {
    return lkg::Answers(*reply, command_) ? LineMeaning::kRefusal : LineMeaning::kOther;
  }
  if (reply->command != command_) return LineMeaning::kDamaged;
  for (std::size_t i = 0; i < reply->outs; ++i) {
    const auto counts = CountsAt(reply->values[i], decimals_);
    if (!counts) return LineMeaning::kDamaged;
    samples[i] = {trial::RawValue::Counts(*counts), reply->values[i].status};
  }
  return LineMeaning::kReading;
}

KeyenceLkg::KeyenceLkg(std::unique_ptr<Transport> transport, KeyenceLkgSetup setup, Clock& clock)
    : setup_(setup),
      line_(std::move(transport), clock, Delimiter::kCr, lkg::kLongestLine),
      poll_(setup.command) {}

Result<std::optional<Reply>> KeyenceLkg::Ask(const std::atomic<bool>& stop) {
  std::optional<Reply> reply;
  const auto take = [&](std::string_view line) {
    reply = lkg::ParseReply(line);
    const bool answers = reply && lkg::Answers(*reply, setup_.command);
    if (!answers) reply.reset();
    return answers;
  };
  HAPTOMETER_TRY(line_.Exchange(poll_.PollRequest(), take, stop));
  return reply;
}

Result<void> KeyenceLkg::Start(const std::atomic<bool>& stop) {
  std::optional<Reply> last;
  for (int probe = 0; probe < kProbes; ++probe) {
    HAPTOMETER_LET(const auto reply, Ask(stop));
    if (!reply) continue;
    last = *reply;
    if (last->kind == ReplyKind::kError) continue;
    const std::optional<int> decimals = setup_.decimals ? setup_.decimals : DecimalsOf(*last);
    if (!decimals) continue;
    MakeHeader(*decimals);
    return {};
  }
  return std::unexpected(NoNumber(last));
}

Error KeyenceLkg::NoNumber(const std::optional<Reply>& last) const {
  Error error{Cause::kCannotAnswer, line_.name(), {}, {}};
  if (!last) {
    error.what = discarded_bytes() > 0
                     ? fmt::format("bytes come at {} baud, but no reply of an LK-G", setup_.baud)
                     : fmt::format("nothing answers at {} baud", setup_.baud);
    error.remedy =
        "give the controller's <baud>, and check that it is set to 8 data bits without parity, "
        "that its delimiter is CR, and the cable the maker's";
  } else if (last->kind == ReplyKind::kError) {
    error.what = fmt::format("the controller refuses {} with error {:02}: {}",
                             lkg::Name(setup_.command), last->error, lkg::ErrorText(last->error));
    error.remedy = last->error == lkg::kStatus
                       ? "it was left in communication mode: end the program that set it so, or "
                         "send it R0 (its mode is not changed here)"
                       : "see the error list of the LK-G's manual";
  } else {
    error.what = "shows no number, so the place of its decimal point is not known";
    error.remedy = "bring a target into the range, or give <decimals> as the display shows them";
  }
  return error;
}

void KeyenceLkg::MakeHeader(int decimals) {
  poll_.SetDecimals(decimals);
  header_.timing = trial::Timing::kPolled;
  header_.channels.clear();
  for (std::size_t out = 0; out < lkg::ValuesOf(setup_.command); ++out) {
    header_.channels.push_back(
        trial::DisplacementCounts(OutName(setup_.command, out), 1e-3 * std::pow(10.0, -decimals)));
  }
  header_.metadata.sensor = "keyence-lkg";
  header_.metadata.source = line_.link().Source(false);
  AddLatencyTimer(line_.link().transport().LatencyTimer(), header_.metadata);
  header_.metadata.nominal_rate_hz = setup_.rate_hz;
}

Findings KeyenceLkg::Found() const {
  const double wire_hz = 1.0 / SecondsFromNs(LeastExchangeNs());
  const double most_hz = setup_.rate_hz ? std::min(*setup_.rate_hz, wire_hz) : wire_hz;
  Findings found;
  found.Note(FindingKind::kLkgRate, {{"baud", setup_.baud},
                                     {"rate_hz", most_hz},
                                     {"observable_hz", HighestObservableHz(most_hz)}});
  found.Note(FindingKind::kSettingsNotRead);
  found.AddAll(line_.Found());
  return found;
}

// request and reply on the wire; what the controller needs comes on top
MonotonicNs KeyenceLkg::LeastExchangeNs() const {
  const std::size_t bytes = poll_.PollRequest().size() + 3 + 9 * lkg::ValuesOf(setup_.command);
  return WireTimeNs(bytes, setup_.baud);
}

MonotonicNs KeyenceLkg::Begin() {
  return line_.Begin(poll_, {.channels = header_.channels.size(),
                             .refresh_ns = setup_.refresh_ns.value_or(0),
                             .rate_hz = setup_.rate_hz,
                             .wire_ns = LeastExchangeNs()});
}

}  // namespace haptometer::acquire
