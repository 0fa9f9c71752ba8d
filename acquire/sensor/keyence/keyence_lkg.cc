#include "acquire/sensor/keyence/keyence_lkg.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquire/protocol/wire.h"
#include "acquire/transport/port_list.h"
#include "base/band.h"
#include "base/error.h"

namespace haptometer::acquire {
namespace {

using lkg::Command;
using lkg::Reply;
using lkg::ReplyKind;

// requests before the controller counts as absent
constexpr int kProbes = 3;

// `value` in steps of `decimals`; nothing where that would lose a digit
std::optional<std::int32_t> CountsAt(const Value& value, int decimals) {
  if (value.counts == kNoCounts) return kNoCounts;
  if (value.decimals > decimals) return std::nullopt;
  const std::int64_t counts = std::int64_t{value.counts} * PowerOfTen(decimals - value.decimals);
  // at most 10^9 counts, which 32 bits hold
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

// M0 gives OUT1 and OUT2, M1 OUT1 alone, M2 OUT2 alone
std::string OutName(Command command, std::size_t place) {
  if (command == Command::kM2) return "displacement_OUT2";
  return place == 0 ? "displacement" : "displacement_OUT2";
}

}  // namespace

LkgPoll::LkgPoll(Command command)
    : command_(command),
      // step after a lost reply: another output's command, whose reply has another first word
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
  // lines at the timing input come without request, and the step's reply belongs to an older step
  if (reply->kind == ReplyKind::kOutput || lkg::Answers(*reply, step_command_)) {
    return LineMeaning::kOther;
  }
  if (reply->kind == ReplyKind::kError) {
    return lkg::Answers(*reply, command_) ? LineMeaning::kRefusal : LineMeaning::kOther;
  }
  // a reply to another command, though in the right form
  if (reply->command != command_) return LineMeaning::kDamaged;
  // all values in steps of one count of the channel
  for (std::size_t i = 0; i < reply->outs; ++i) {
    const auto counts = CountsAt(reply->values[i], decimals_);
    if (!counts) return LineMeaning::kOtherForm;
    samples[i] = {trial::RawValue::Counts(*counts), reply->values[i].status};
  }
  return LineMeaning::kReading;
}

KeyenceLkg::KeyenceLkg(std::unique_ptr<Transport> transport, KeyenceLkgSetup setup, Clock& clock)
    : setup_(setup),
      line_(std::move(transport), clock, Delimiter::kCr, lkg::kLongestLine),
      poll_(setup.command) {}

// one exchange before the recording; nothing where no reply to the command came
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
    // the display's decimals fix the step of the channel: stated, or from the first number
    const std::optional<int> decimals = setup_.decimals ? setup_.decimals : DecimalsOf(*last);
    if (!decimals) continue;
    MakeHeader(*decimals);
    return {};
  }
  return std::unexpected(NoNumber(last));
}

Error KeyenceLkg::NoNumber(const std::optional<Reply>& last) const {
  Error error{Cause::kCannotAnswer, line_.name(), {}, {}};
  if (!last && line_.echoes() > 0) {
    error.what = "sends each request back, and no reply of an LK-G follows";
    error.remedy = kEchoRemedy;
  } else if (!last) {
    error.what = discarded_bytes() > 0
                     ? fmt::format("bytes come at {} baud, but no reply of an LK-G", setup_.baud)
                     : fmt::format("nothing answers at {} baud", setup_.baud);
    error.remedy =
        "give the controller's <baud>, and check that it is set to 8 data bits without parity, "
        "that its delimiter is CR, and the cable the maker's";
  } else if (last->kind == ReplyKind::kError) {
    // status error: the controller is in communication mode (Q0) and gives no values
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
  // one channel per output; one count is 10^-decimals mm, in m
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
  // upper limit: the controller's own processing time is not stated
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
  // "M1" CR, then "M1" CR and ",+01.2345" for each value
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
