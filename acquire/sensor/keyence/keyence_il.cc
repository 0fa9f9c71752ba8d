#include "acquire/sensor/keyence/keyence_il.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/wire.h"
#include "acquire/transport/port_list.h"
#include "base/band.h"
#include "base/text.h"

namespace haptometer::acquire {
namespace {

using dl::Command;
using dl::Reply;
using dl::ReplyKind;

// requests M0 before the unit counts as absent
constexpr int kProbes = 3;
constexpr int kMostSilences = 2;  // a unit without SR is not polled for settings any longer

// "2400, 4800, 9600 or 19200": the rates of the unit but `baud`
std::string OtherBauds(int baud) {
  std::vector<int> others(dl_rs1a::kBauds.begin(), dl_rs1a::kBauds.end());
  std::erase(others, baud);
  std::ranges::sort(others);
  std::string text;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const std::string_view comma = i == 0 ? "" : i + 1 == others.size() ? " or " : ", ";
    text += fmt::format("{}{}", comma, others[i]);
  }
  return text;
}

// suffix of a channel's or field's name; "" for the first amplifier
std::string Suffix(std::size_t place, int unit) {
  return place == 0 ? "" : fmt::format("_{:02}", unit);
}

}  // namespace

KeyenceIl::KeyenceIl(std::unique_ptr<Transport> transport, KeyenceIlSetup setup, Clock& clock)
    : setup_(std::move(setup)),
      traits_(TraitsOf(setup_.unit)),
      clock_(clock),
      line_(std::move(transport), clock, Delimiter::kCrLf, traits_.longest_line),
      poll_(traits_.spelling, setup_.command) {}

Result<void> KeyenceIl::Start(const std::atomic<bool>& stop) {
  // order: values, settings of the amplifiers, their decimals, changes; the header shows the result
  IlTalk talk(line_, traits_, stop);
  HAPTOMETER_TRY(Probe(talk));
  HAPTOMETER_TRY(ReadSettings(talk));
  HAPTOMETER_TRY(ReadDecimals(talk));
  HAPTOMETER_TRY(Change(talk));
  MakeHeader();
  return {};
}

// --- what is there ---

Result<void> KeyenceIl::Probe(IlTalk& talk) {
  std::optional<int> refusal;
  for (int probe = 0; probe < kProbes; ++probe) {
    HAPTOMETER_LET(const auto reply, talk.Ask({}));
    if (!reply) continue;
    // half a command of another program makes the first request invalid: it is sent again
    if (reply->kind == ReplyKind::kError) {
      refusal = reply->number;
      continue;
    }
    // one value per amplifier: the reply states how many there are
    for (std::size_t i = 0; i < reply->units; ++i) decimals_.push_back(reply->values[i].decimals);
    settings_.resize(decimals_.size());
    return {};
  }
  if (refusal) {
    return CannotAnswer(line_.name(),
                        fmt::format("the unit refuses M0 with error {:0{}}: {}", *refusal,
                                    traits_.spelling.error_digits, traits_.error_text(*refusal)),
                        fmt::format("see the error list of the {}'s manual", traits_.name));
  }
  return std::unexpected(NoAnswer());
}

Error KeyenceIl::NoAnswer() const {
  // bytes without a reply: wrong baud rate, or another device
  const bool heard_bytes = discarded_bytes() > 0;
  Error error{Cause::kCannotAnswer, line_.name(), {}, {}};
  if (line_.echoes() > 0) {
    error.what = fmt::format("sends each request back, and no reply of a {} follows", traits_.name);
    error.remedy = kEchoRemedy;
    return error;
  }
  if (setup_.unit == IlUnit::kDlEn1) {
    error.what = heard_bytes ? "bytes come, but no reply of a DL-EN1" : "nothing answers";
    error.remedy =
        "check the address, that the unit's socket port is the one given (64000 as delivered), and "
        "that no other program is connected: it serves one at a time";
    if (heard_bytes) {
      error.remedy += "; a sensor that sends without request is read by <sensor> stream";
    }
    return error;
  }
  error.what = heard_bytes
                   ? fmt::format("bytes come at {} baud, but no reply of a DL-RS1A", setup_.baud)
                   : fmt::format("nothing answers at {} baud", setup_.baud);
  error.remedy = fmt::format(
      "try <baud> {}, and check that the amplifier is on, the unit set to 8 data bits "
      "without parity, and the cable the maker's",
      OtherBauds(setup_.baud));
  if (heard_bytes) {
    error.remedy += "; a sensor that sends without request is read by <sensor> stream";
  }
  return error;
}

// identification numbers: from 00 (DL-RS1A) or 01 (DL-EN1), without gaps
std::vector<int> KeyenceIl::Units() const {
  std::vector<int> units;
  units.reserve(settings_.size());
  for (std::size_t i = 0; i < settings_.size(); ++i) {
    units.push_back(traits_.first_unit + static_cast<int>(i));
  }
  return units;
}

Result<void> KeyenceIl::ReadSettings(IlTalk& talk) {
  const std::vector<int> units = Units();
  for (std::size_t i = 0; i < units.size(); ++i) {
    for (const int number : UnitSettings::kNumbers) {
      HAPTOMETER_LET(const auto data, talk.Read(units[i], number));
      // silence also ends it: a unit without SR would need one second per number
      if (talk.silences() == kMostSilences) return {};
      if (data) settings_[i].Set(number, *data);
    }
  }
  return {};
}

// where a line's values have no point: <decimals>, else FR, else the head's table
Result<void> KeyenceIl::ReadDecimals(IlTalk& talk) {
  std::vector<IlChannel> channels;
  channels.reserve(decimals_.size());
  for (std::size_t i = 0; i < decimals_.size(); ++i) {
    const dl_rs1a::Head* head = settings_[i].head();
    channels.push_back({.sent_decimals = decimals_[i],
                        // only of a known head are the special values of the IL series certain
                        .has_il_specials = setup_.unit == IlUnit::kDlEn1 && head != nullptr});
  }
  poll_.SetChannels(std::move(channels));
  // a DL-RS1A sends the point with each value
  if (setup_.unit == IlUnit::kDlRs1a) return {};

  const std::vector<int> units = Units();
  for (std::size_t i = 0; i < units.size(); ++i) {
    std::optional<int> told = setup_.decimals;
    if (!told && talk.silences() < kMostSilences) {
      HAPTOMETER_LET(
          const auto reply,
          talk.Ask({.command = Command::kFr, .unit = units[i], .number = dl_rs1a::kPresentValue}));
      if (reply && reply->kind == ReplyKind::kFr) told = dl::NumberOf(reply->data);
    }
    // decimals of the connected head by its code (data 195)
    if (!told && settings_[i].head() != nullptr) told = settings_[i].head()->decimals;
    if (!told || *told < 0 || *told > 9) {
      return CannotAnswer(
          line_.name(), fmt::format("amplifier {:02} does not report its decimal places", units[i]),
          "give them with <decimals>, e.g. 3 for an IL-030");
    }
    decimals_[i] = *told;
  }
  return {};
}

// --- changes that the user requires ---

Result<void> KeyenceIl::Change(IlTalk& talk) {
  const std::vector<int> units = Units();
  HAPTOMETER_LET(auto changes, WriteSettings(talk, units, setup_.writes));
  changes_ = std::move(changes);
  // the header shows the settings after the changes
  if (!changes_.empty()) {
    HAPTOMETER_TRY(ReadSettings(talk));
    // two response times of the slowest amplifier, and 2 s
    double longest_s = 2;
    for (const UnitSettings& settings : settings_) {
      longest_s = std::max(longest_s, 2 + 2 * settings.ResponseSeconds());
    }
    HAPTOMETER_LET(const auto valid,
                   WaitUntilValid(talk, RefreshNs(), NsFromSeconds(longest_s), clock_));
    is_unsettled_ = !valid;
  }
  // the zero shift comes last: it uses readings of the final settings
  if (!setup_.device_zero) return {};
  HAPTOMETER_LET(auto shifts, ShiftZeros(talk, units, clock_));
  changes_.insert(changes_.end(), shifts.begin(), shifts.end());
  return {};
}

Result<IlAnalog> KeyenceIl::ReadAnalog(const std::atomic<bool>& stop) {
  IlTalk talk(line_, traits_, stop);
  HAPTOMETER_LET(const auto raw, talk.Read(traits_.first_unit, dl_rs1a::kRawValue));
  HAPTOMETER_LET(const auto output, talk.Read(traits_.first_unit, dl_rs1a::kAnalogOutput));
  if (!raw || !output) return IlAnalog{};
  // a DL-EN1 sends neither point: decimals are those of the amplifier, and mV
  const bool is_en1 = setup_.unit == IlUnit::kDlEn1;
  auto value = traits_.spelling.parse_value(*raw);
  if (value && is_en1) value = dl_en1::WithIlSpecials(*value);
  const auto mv = is_en1 ? dl::NumberOf(*output) : dl_rs1a::ParseAnalogMv(*output);
  if (!mv) {
    return CannotAnswer(line_.name(),
                        fmt::format("the analog output is '{}', no voltage", Printable(*output)),
                        "set the amplifier's analog output to a voltage");
  }
  if (!value) return IlAnalog{.status = trial::SampleStatus::kBadFrame};
  // +5.5 V is the state of the output, whatever the value says
  if (*mv == dl_rs1a::kAnalogErrorMv && value->status == trial::SampleStatus::kOk) {
    value->status = trial::SampleStatus::kInvalid;
  }
  const int decimals = is_en1 ? decimals_.front() : value->decimals;
  return IlAnalog{.status = value->status,
                  .displacement_m = 1e-3 * value->counts / std::pow(10.0, decimals),
                  .volts = 1e-3 * *mv};
}

// --- header and findings ---

MonotonicNs KeyenceIl::RefreshNs() const {
  return setup_.refresh_ns.value_or(traits_.refresh_ns(settings_.size()));
}

// in Hz: limit of the wire or the requested rate; the time of a DL-EN1 reply is not known
std::optional<double> KeyenceIl::NominalRateHz() const {
  if (setup_.unit == IlUnit::kDlEn1) return setup_.rate_hz;
  const double most_hz =
      1.0 / SecondsFromNs(dl_rs1a::PollPeriodNs(setup_.baud, settings_.size(), setup_.command));
  return setup_.rate_hz ? std::min(most_hz, *setup_.rate_hz) : most_hz;
}

// channels: displacements of all amplifiers, then, with MS, their outputs
void KeyenceIl::MakeHeader() {
  header_.timing = trial::Timing::kPolled;
  header_.channels.clear();
  const std::vector<int> units = Units();
  for (std::size_t i = 0; i < units.size(); ++i) {
    // one count is 10^-decimals mm, in m
    trial::ChannelFormat channel = trial::DisplacementCounts("displacement" + Suffix(i, units[i]),
                                                             1e-3 * std::pow(10.0, -decimals_[i]));
    if (const dl_rs1a::Head* head = settings_[i].head(); head && head->farthest_mm > 0) {
      // the reading is reference - distance, so the farthest distance is the least reading
      channel.range_min = 1e-3 * (head->reference_mm - head->farthest_mm);
      channel.range_max = 1e-3 * (head->reference_mm - head->nearest_mm);
    }
    header_.channels.push_back(channel);
  }
  for (std::size_t i = 0; setup_.command == Command::kMs && i < units.size(); ++i) {
    header_.channels.push_back(
        {.name = "outputs" + Suffix(i, units[i]), .encoding = trial::Encoding::kI32});
  }
  trial::Metadata& metadata = header_.metadata;
  metadata.sensor = traits_.sensor;
  metadata.source = line_.link().Source(settings_.front().is_emulated());
  AddLatencyTimer(line_.link().transport().LatencyTimer(), metadata);
  metadata.nominal_rate_hz = NominalRateHz();
  settings_.front().Describe(metadata);
  for (std::size_t i = 0; i < units.size(); ++i) {
    settings_[i].AddFields(metadata, Suffix(i, units[i]));
  }
  // "changed_KEY": before -> after
  for (const IlChange& change : changes_) {
    const auto place = static_cast<std::size_t>(change.unit - traits_.first_unit);
    metadata.fields["changed_" + change.key + Suffix(place, change.unit)] =
        change.before + " -> " + change.after;
  }
}

Findings KeyenceIl::Found() const {
  const bool is_serial = setup_.unit == IlUnit::kDlRs1a;
  // new readings per second; polls beyond that give repeated values
  const double fresh_hz = 1.0 / SecondsFromNs(RefreshNs());
  const double poll_hz = NominalRateHz().value_or(fresh_hz);
  // the fastest that the unit can do at all: one amplifier, highest baud rate
  const double best_hz =
      1.0 / SecondsFromNs(is_serial ? dl_rs1a::PollPeriodNs(38400, 1) : traits_.refresh_ns(1));
  const std::string device(traits_.name);
  Finding rate{.kind = FindingKind::kUnitRate,
               .numbers = {{"device", device},
                           {"rate_hz", poll_hz},
                           {"observable_hz", HighestObservableHz(std::min(poll_hz, fresh_hz))}}};
  if (is_serial) rate.numbers.emplace_back("baud", setup_.baud);
  if (fresh_hz < poll_hz) rate.numbers.emplace_back("new_rate_hz", fresh_hz);
  Findings found;
  found.Add(std::move(rate));
  found.Note(
      FindingKind::kUnitTooSlow,
      {{"device", device}, {"rate_hz", best_hz}, {"needed_hz", NeededRateHz(kDefaultUpperHz)}});
  // cost of the adapter's latency timer per poll period
  if (is_serial) {
    found.AddAll(line_.link().transport().LatencyCost(
        dl_rs1a::PollPeriodNs(setup_.baud, settings_.size(), setup_.command)));
  }
  for (const IlChange& change : changes_) {
    found.Add(
        {.kind = FindingKind::kSettingChanged,
         .numbers = {{"setting", change.key}, {"before", change.before}, {"after", change.after}},
         .subject = AmplifierName(change.unit)});
  }
  // readings were still invalid after the waiting time
  if (is_unsettled_) found.Doubt(FindingKind::kNotSettled);
  const std::vector<int> units = Units();
  for (std::size_t i = 0; i < units.size(); ++i) {
    // findings of the first amplifier have no subject
    for (Finding finding : settings_[i].Found().list()) {
      if (i > 0) finding.subject = AmplifierName(units[i]);
      found.Add(std::move(finding));
    }
  }
  found.AddAll(line_.Found());
  return found;
}

MonotonicNs KeyenceIl::Begin() {
  // over Ethernet no wire time limits the exchange: 0
  const bool has_baud = setup_.unit == IlUnit::kDlRs1a;
  return line_.Begin(
      poll_,
      {.channels = poll_.samples(),
       .refresh_ns = RefreshNs(),
       .rate_hz = setup_.rate_hz,
       .wire_ns =
           has_baud ? dl_rs1a::LeastExchangeNs(setup_.baud, settings_.size(), setup_.command) : 0});
}

}  // namespace haptometer::acquire
