#include "acquire/sensor/stream_sensor.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "acquire/protocol/wire.h"
#include "acquire/transport/port_list.h"
#include "base/band.h"
#include "base/error.h"
#include "base/text.h"

namespace haptometer::acquire {

std::int64_t LineCounter::LostBefore(std::int32_t number) {
  HAPTOMETER_CHECK(number >= 0 && number < turn_, "number {} of {}", number, turn_);
  // damaged lines since the last number are lines that arrived, so they are not lost
  const std::int64_t damaged = std::exchange(damaged_, 0);
  const std::optional<std::int32_t> last = std::exchange(last_, number);
  if (!last) return 0;
  // lines between the two numbers, 0 to turn - 1: the same number again is a whole turn later
  const std::int32_t between = (number - *last - 1 + turn_) % turn_;
  // noise may cut one line into several damaged ones, never make one of none
  return std::max<std::int64_t>(between - damaged, 0);
}

namespace {

using trial::SampleStatus;

constexpr MonotonicNs kSliceNs = 100'000'000;
// time for the first line after the port was opened
constexpr MonotonicNs kPatienceNs = 3 * kNsPerS;
// time for an emulator to identify itself, at the head of a line
constexpr MonotonicNs kIdentityNs = 200'000'000;
constexpr std::size_t kMostShown = 24;  // characters of a line that is no reading
constexpr double kHeldByPortsS = 1;

// longest line that is kept whole: a few lines run together are still shown and counted as one
std::size_t LongestLine(const StreamFormat& format) { return 4 * LineBytes(format); }

}  // namespace

StreamSensor::StreamSensor(std::unique_ptr<Transport> transport, StreamSetup setup, Clock& clock)
    : setup_(setup),
      clock_(clock),
      link_(std::move(transport), clock, setup.format.delimiter, LongestLine(setup.format)),
      counter_(CounterTurn(setup.format)) {}

Result<void> StreamSensor::Start(const std::atomic<bool>& stop) {
  // bytes from before are discarded; the line that is on the wire now may be cut
  link_.Flush();
  AskWhetherEmulated();
  bool is_first = true;  // the first line may be cut
  bool has_line = false;
  std::string example;
  const MonotonicNs deadline = clock_.Now() + kPatienceNs;
  while (clock_.Now() < deadline) {
    if (stop.load()) {
      return Failed(link_.transport().name(),
                    "was not recorded: interrupted before the first reading");
    }
    // one line in the expected format, and the emulator's time to answer has passed
    if (has_line && (is_emulated_ || clock_.Now() >= identity_deadline_ns_)) {
      MakeHeader();
      return {};
    }
    const LinkLine line = link_.Read(std::min(deadline, clock_.Now() + kSliceNs));
    if (line.state == LinkState::kGone) {
      return Failed(link_.transport().name(), "the connection was lost", "check cable and power");
    }
    if (line.state != LinkState::kLine) continue;
    if (line.text == kEmulatedIdentity) {
      is_emulated_ = true;
    } else if (!std::exchange(is_first, false) && ParseStreamLine(setup_.format, line.text)) {
      // the first line is not judged: its beginning may be missing
      has_line = true;
    } else {
      // a line of another format is shown in the error
      example = Printable(line.text.substr(0, kMostShown));
      link_.CountDiscarded(line.text.size());
    }
  }
  return std::unexpected(NoLines(example));
}

void StreamSensor::AskWhetherEmulated() {
  identity_deadline_ns_ = clock_.Now();
  // a hardware port is never an emulator: nothing is written to it
  if (link_.transport().IsHardware()) return;
  identity_deadline_ns_ += kIdentityNs;
  // a peer that does not take the question is no emulator, and is not waited for
  if (!link_.transport().Write(kIdentityRequest, identity_deadline_ns_)) {
    identity_deadline_ns_ = clock_.Now();
  }
}

Error StreamSensor::NoLines(const std::string& example) const {
  const std::string& name = link_.transport().name();
  if (!example.empty()) {
    return {Cause::kCannotAnswer, name,
            fmt::format("sends lines of another form at {} baud: \"{}\"", setup_.baud, example),
            "give the sensor's <baud>, or its line as <format> +00.0000,mm,CR; a polled Keyence "
            "unit is <sensor> keyence-il, keyence-en1 or keyence-lkg"};
  }
  // bytes without a delimiter: wrong baud rate or wrong delimiter
  if (discarded_bytes() > 0 || link_.waiting_bytes() > 0) {
    return {Cause::kCannotAnswer, name,
            fmt::format("bytes come at {} baud, but no line", setup_.baud),
            "give the sensor's <baud>, or its line as <format> +00.0000,mm,CR"};
  }
  return {Cause::kCannotAnswer, name, fmt::format("nothing comes at {} baud", setup_.baud),
          "check that the sensor is on and sends without request; a DL-RS1A is polled with "
          "<sensor> keyence-il"};
}

void StreamSensor::MakeHeader() {
  const StreamFormat& format = setup_.format;
  trial::ChannelFormat channel = trial::DisplacementCounts("displacement", MetresPerCount(format));
  // the range is that of the number format: all digits 9
  channel.range_max = MostCounts(format) * channel.scale;
  channel.range_min = format.sign == SignRule::kAlways ? -channel.range_max : 0.0;
  header_.timing = trial::Timing::kArrival;
  header_.channels = {channel};
  header_.metadata.sensor = "stream";
  header_.metadata.source = link_.Source(is_emulated_);
  StateAveraging(setup_.averaging, &header_.metadata);
  AddLatencyTimer(link_.transport().LatencyTimer(), header_.metadata);
  if (format.counter_digits > 0) {
    header_.metadata.fields[std::string(trial::kLineNumbersField)] =
        fmt::format("0 to {}", CounterTurn(format) - 1);
  }
  // a line's time is that of its last byte: the reading is older by its wire time at least
  header_.metadata.fields[std::string(trial::kLatencyField)] =
      fmt::format("{:.6g}", SecondsFromNs(WireTimeNs(LineBytes(format), setup_.baud)));
}

Findings StreamSensor::Found() const {
  // limit of the wire in lines per second
  const double most_hz = MostLinesPerSecond(setup_.format, setup_.baud);
  const double band_hz = HighestObservableHz(most_hz);
  Findings found;
  found.Note(FindingKind::kLinesRate, {{"baud", setup_.baud},
                                       {"characters", LineBytes(setup_.format)},
                                       {"rate_hz", most_hz},
                                       {"observable_hz", band_hz}});
  if (!Observes(most_hz, kDefaultUpperHz)) {
    found.Note(FindingKind::kLinesTooSlow, {{"needed_hz", NeededRateHz(kDefaultUpperHz)}});
  }
  if (setup_.format.counter_digits > 0) {
    found.Note(FindingKind::kLinesNumbered, {{"last", CounterTurn(setup_.format) - 1}});
  }
  // the lines that came must have fitted on the wire since the beginning; more is a wrong baud rate
  // what the port held from before the beginning may come as well
  const double wire_s = SecondsFromNs(WireTimeNs(LineBytes(setup_.format), setup_.baud)) *
                        static_cast<double>(lines_);
  const double elapsed_s = SecondsFromNs(link_.last_bytes_ns() - begin_ns_);
  if (lines_ > 0 && wire_s > elapsed_s + kHeldByPortsS) {
    found.Doubt(
        FindingKind::kLinesTooSoon,
        {{"lines", lines_}, {"elapsed_s", elapsed_s}, {"baud", setup_.baud}, {"wire_s", wire_s}});
  }
  return found;
}

MonotonicNs StreamSensor::Begin() {
  counter_ = LineCounter(CounterTurn(setup_.format));
  // a line whose beginning was flushed is incomplete
  drop_line_ = link_.Flush() > 0;
  discarded_before_ = link_.discarded_bytes();
  lines_ = 0;
  begin_ns_ = last_ns_ = clock_.Now();
  return last_ns_;
}

Outcome StreamSensor::Next(Reading& reading) {
  const LinkLine line = link_.Read(clock_.Now() + kSliceNs);
  if (line.state == LinkState::kGone) return Outcome::kGone;
  if (line.state == LinkState::kNothing) return Outcome::kNothing;
  // the rest of that line
  if (std::exchange(drop_line_, false)) return Outcome::kNothing;
  const std::optional<Value> value =
      line.state == LinkState::kLine ? ParseStreamLine(setup_.format, line.text) : std::nullopt;
  reading.lost_before = 0;
  if (value) ++lines_;
  // a damaged line is a row without a value: its time and its place are kept
  if (!value) {
    link_.CountDiscarded(line.text.size());
    counter_.CountDamaged();
  } else if (setup_.format.counter_digits > 0) {
    reading.lost_before = counter_.LostBefore(LineCount(setup_.format, line.text));
  }
  // On a wire of known speed the bytes behind this line were under way after it had arrived. A
  // network hands them on at once. Times do not decrease, though chunks arrive with scatter.
  const MonotonicNs behind_ns =
      link_.transport().IsHardware() ? WireTimeNs(line.bytes_behind, setup_.baud) : 0;
  last_ns_ = std::max(last_ns_, line.chunk_ns - behind_ns);
  reading.time_ns = last_ns_;
  reading.samples.assign(1, {trial::RawValue::Counts(value ? value->counts : kNoCounts),
                             value ? value->status : SampleStatus::kBadFrame});
  return Outcome::kReading;
}

}  // namespace haptometer::acquire
