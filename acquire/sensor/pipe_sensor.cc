#include "acquire/sensor/pipe_sensor.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquire/protocol/wire.h"
#include "base/error.h"
#include "base/text.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kSliceNs = 100'000'000;
constexpr MonotonicNs kPatienceNs = 60 * kNsPerS;
constexpr std::size_t kChunkBytes = 65'536;
// a heading is longer than this nowhere
constexpr std::uint64_t kMostHeadingLines = 100;
constexpr std::size_t kMostShown = 24;  // characters of a line that is no row
constexpr std::uint64_t kMostHeadingBytes = 1 << 20;

std::string FormName(const PipeSetup& setup) {
  return fmt::format("{} x {}", setup.channels.formats.size(), Name(setup.format));
}

}  // namespace

PipeSensor::PipeSensor(std::unique_ptr<Transport> transport, PipeSetup setup, Clock& clock)
    : setup_(std::move(setup)),
      clock_(clock),
      transport_(std::move(transport)),
      parser_(setup_.format, setup_.channels.limits),
      chunk_(kChunkBytes),
      row_(setup_.channels.formats.size()) {
  HAPTOMETER_CHECK(std::isfinite(setup_.rate_hz) && setup_.rate_hz > 0, "rate_hz = {}",
                   setup_.rate_hz);
  HAPTOMETER_CHECK(setup_.channels.limits.size() == row_.size(), "{} limits, {} channels",
                   setup_.channels.limits.size(), row_.size());
}

Result<void> PipeSensor::Start(const std::atomic<bool>& stop) {
  if (auto waited = WaitForRow(stop); !waited) return waited;
  Describe();
  return {};
}

Result<void> PipeSensor::WaitForRow(const std::atomic<bool>& stop) {
  const MonotonicNs deadline = clock_.Now() + kPatienceNs;
  while (clock_.Now() < deadline && heading_lines_ <= kMostHeadingLines &&
         bytes_read_ <= kMostHeadingBytes) {
    if (stop.load()) {
      return Failed(transport_->name(), "was not recorded: interrupted before the first row");
    }
    const RowState state = Read(std::min(deadline, clock_.Now() + kSliceNs));
    has_row_ = state == RowState::kRow;
    if (has_row_) {
      heading_bytes_ = parser_.discarded_bytes();
      return {};
    }
    if (state == RowState::kBadRow) {
      ++heading_lines_;
      heading_ = Printable(parser_.line().substr(0, kMostShown));
    } else if (has_ended_) {
      return std::unexpected(NoRow("ended before a whole row came"));
    }
  }
  if (bytes_read_ > kMostHeadingBytes) {
    return std::unexpected(NoRow(fmt::format("{} bytes came, and no row", bytes_read_)));
  }
  return std::unexpected(NoRow(fmt::format("no row came in {} s", kPatienceNs / kNsPerS)));
}

Error PipeSensor::NoRow(std::string what) const {
  if (heading_lines_ > 0) {
    what = fmt::format("no line is a row of {}: \"{}\"", FormName(setup_), heading_);
  } else if (parser_.waiting_bytes() > 0) {
    what += fmt::format(" ({} bytes did)", parser_.waiting_bytes());
  }
  return {Cause::kCannotAnswer, transport_->name(), std::move(what),
          fmt::format("check that the program writes {}, or say what it writes with --channels and "
                      "--format",
                      FormName(setup_))};
}

void PipeSensor::Describe() {
  header_.timing = trial::Timing::kUniform;
  header_.rate_hz = setup_.rate_hz;
  header_.channels = setup_.channels.formats;
  header_.metadata.sensor = "pipe";
  header_.metadata.source = fmt::format("{}, {}", transport_->Source(), FormName(setup_));
  header_.metadata.nominal_rate_hz = setup_.rate_hz;
  header_.metadata.fields = setup_.channels.fields;
  remarks_.push_back(fmt::format(
      "{:g} rows/s, as stated: motion up to {:.0f} Hz can be observed (rate / 2.56) if nothing "
      "above {:g} Hz reaches the converter",
      setup_.rate_hz, HighestObservableHz(setup_.rate_hz), 0.5 * setup_.rate_hz));
  if (heading_lines_ > 0) {
    remarks_.push_back(fmt::format("{} lines before the first row were passed over: \"{}\"",
                                   heading_lines_, heading_));
  }
}

RowState PipeSensor::Read(MonotonicNs deadline) {
  const RowState state = parser_.Next(row_);
  if (state != RowState::kNeedMore || has_ended_) return state;
  const ReadOutcome outcome = transport_->Read(chunk_, deadline);
  has_ended_ = outcome.state == ReadState::kGone;
  if (outcome.state != ReadState::kBytes) return RowState::kNeedMore;
  bytes_read_ += outcome.bytes;
  parser_.Feed(std::string_view(chunk_.data(), outcome.bytes));
  return parser_.Next(row_);
}

MonotonicNs PipeSensor::Begin() {
  next_index_ = 0;
  return clock_.Now();
}

Outcome PipeSensor::Next(Reading& reading) {
  if (!std::exchange(has_row_, false) && Read(clock_.Now() + kSliceNs) == RowState::kNeedMore) {
    return has_ended_ ? Outcome::kEnd : Outcome::kNothing;
  }
  reading.index = next_index_++;
  reading.samples.assign(row_.begin(), row_.end());
  return Outcome::kReading;
}

std::uint64_t PipeSensor::discarded_bytes() const {
  return parser_.discarded_bytes() - heading_bytes_ + (has_ended_ ? parser_.waiting_bytes() : 0);
}

}  // namespace haptometer::acquire
