#include "acquire/emulator/stream_head.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "acquire/protocol/wire.h"

namespace haptometer::acquire::emulator {
namespace {

// bytes are given in batches of about 1 ms
constexpr MonotonicNs kBatchNs = 1'000'000;
// what serial ports offer, for the advice only
constexpr std::array kCommonBauds = {9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600};

// whether lines of this length fit between two samples; 1e-12 allows for rounding
bool Fits(std::size_t bytes, int baud, double sampling_s) {
  return static_cast<double>(bytes) * kBitsPerCharacter <= sampling_s * baud * (1 + 1e-12);
}

// "use <baud> 921600 or <sampling> 782us": the slowest common rate and the shortest period that fit
std::string Advice(const StreamSetup& setup) {
  const std::size_t bytes = LineBytes(setup.format);
  // shortest period in whole microseconds at the given baud rate
  const auto period_us = static_cast<std::int64_t>(
      std::ceil(1e6 / MostLinesPerSecond(setup.format, setup.baud) - 1e-6));
  std::string advice = fmt::format("<sampling> {}us", period_us);
  for (const int baud : kCommonBauds) {
    if (Fits(bytes, baud, setup.head.head.sampling_s)) {
      return fmt::format("use <baud> {} or {}", baud, advice);
    }
  }
  return "use " + advice;
}

}  // namespace

Result<void> Validate(const StreamSetup& setup) {
  const Fault* fault = setup.faults.fault;
  // a stream has no requests, so faults of replies have no effect
  if (fault != nullptr && NeedsAQuestion(*fault)) {
    return Usage(
        "<fault>",
        fmt::format("'{}' is a fault of replies, and a stream has no requests", fault->name),
        "choose another, or <protocol> dl-rs1a");
  }
  if (setup.baud < 1 || !Fits(LineBytes(setup.format), setup.baud, setup.head.head.sampling_s)) {
    return Usage("<baud>",
                 fmt::format("{} characters at {} baud allow {:.0f} lines/s, the head gives {:g}",
                             LineBytes(setup.format), setup.baud,
                             std::floor(MostLinesPerSecond(setup.format, setup.baud)),
                             1 / setup.head.head.sampling_s),
                 Advice(setup));
  }
  return {};
}

StreamHead::StreamHead(StreamSetup setup) : setup_(std::move(setup)), wire_(setup_.baud) {
  HAPTOMETER_CHECK(Validate(setup_).has_value(), "{}", Validate(setup_).error().Text());
}

void StreamHead::Receive(std::string_view bytes, MonotonicNs /*now*/) {
  // the answer to the identity request goes before the next line
  is_asked_ = is_asked_ || bytes.find(kIdentityRequest.front()) != std::string_view::npos;
}

void StreamHead::Advance(MonotonicNs now, std::string& out) {
  advanced_to_ = now;
  while (true) {
    // between two lines: the next one begins when its sample is taken
    if (sent_ == line_.size()) {
      if (setup_.head.SampleTime(next_) > now) return;
      PrepareLine();
    } else {
      if (departure_ > now) return;
      out += line_[sent_++];
      // bytes leave one after the other at the baud rate
      if (sent_ < line_.size()) departure_ = wire_.Send(setup_.head.SampleTime(next_ - 1));
    }
  }
}

void StreamHead::PrepareLine() {
  const std::int64_t number = next_++;
  const trial::HeadReading reading = setup_.head.Reading(number);
  // faults count lines from 1
  const Fault* fault = setup_.faults.At(number + 1);

  // counts of the last decimal, as the line carries them; what it cannot hold is one more than that
  const double beyond = 1.0 + MostCounts(setup_.format);
  const double counts = reading.value_m / MetresPerCount(setup_.format);
  Value value{.counts = static_cast<std::int32_t>(std::lround(std::clamp(counts, -beyond, beyond))),
              .decimals = setup_.format.decimals,
              .status = reading.status};
  if (fault != nullptr && fault->status != trial::SampleStatus::kOk) value.status = fault->status;
  line_ = FormatStreamLine(setup_.format, value, number);
  if (fault != nullptr) line_ = Damaged(std::move(line_), fault->damage, number + 1);
  if (std::exchange(is_asked_, false)) {
    line_ = fmt::format("{}{}{}", kEmulatedIdentity, Bytes(setup_.format.delimiter), line_);
  }
  // a hang-up replaces the line
  if (fault != nullptr && fault->hangs_up) {
    hang_up_ = true;
    line_.clear();
  }
  sent_ = 0;
  if (!line_.empty()) departure_ = wire_.Send(setup_.head.SampleTime(number));
}

std::optional<MonotonicNs> StreamHead::NextDue() const {
  const MonotonicNs due = sent_ < line_.size() ? departure_ : setup_.head.SampleTime(next_);
  // not before the last batch is 1 ms old
  return std::max(due, advanced_to_ + kBatchNs);
}

bool StreamHead::TakeHangUp() { return std::exchange(hang_up_, false); }

char StreamHead::line_end() const { return Bytes(setup_.format.delimiter).back(); }

}  // namespace haptometer::acquire::emulator
