#include "acquire/sensor/replay.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kSliceNs = 100'000'000;

}  // namespace

PacedSensor::PacedSensor(std::unique_ptr<Sensor> inner, double speed, Clock& clock)
    : inner_(std::move(inner)), speed_(speed), clock_(clock) {
  HAPTOMETER_CHECK(speed > 0, "speed = {}", speed);
}

MonotonicNs PacedSensor::Begin() {
  is_held_ = false;  // a row of the beginning before, with its index
  inner_begin_ns_ = inner_->Begin();
  begin_ns_ = clock_.Now();
  return begin_ns_;
}

// time at which a row is given: its time in the recording, over `speed`, from this beginning
MonotonicNs PacedSensor::DueNs() const {
  const trial::TrialHeader& header = inner_->header();
  double since_begin_s = 0;
  if (header.timing == trial::Timing::kUniform) {
    // uniform rows: index / rate
    since_begin_s = static_cast<double>(held_.index) / header.rate_hz;
  } else {
    // polled rows existed when their reply came
    const bool is_polled = header.timing == trial::Timing::kPolled;
    const MonotonicNs time_ns = is_polled ? held_.reply_ns : held_.time_ns;
    since_begin_s = SecondsFromNs(time_ns - inner_begin_ns_);
  }
  return begin_ns_ + NsFromSeconds(since_begin_s / speed_);
}

Outcome PacedSensor::Next(Reading& reading) {
  if (!is_held_) {
    if (const Outcome outcome = inner_->Next(held_); outcome != Outcome::kReading) return outcome;
    is_held_ = true;
  }
  // an infinite speed gives each row at once
  if (std::isfinite(speed_)) {
    const MonotonicNs due_ns = DueNs();
    const MonotonicNs now_ns = clock_.Now();
    // one slice at most, so that the caller can stop
    if (due_ns > now_ns) clock_.SleepUntil(std::min(due_ns, now_ns + kSliceNs));
    if (clock_.Now() < due_ns) return Outcome::kNothing;
  }
  is_held_ = false;
  reading = held_;
  // the same distances from this beginning
  reading.time_ns += begin_ns_ - inner_begin_ns_;
  reading.reply_ns += begin_ns_ - inner_begin_ns_;
  return Outcome::kReading;
}

namespace {

// report of the whole file: losses and labels may follow behind the rows
Result<trial::ReadReport> ReadToTheEnd(const std::string& path) {
  HAPTOMETER_LET(auto reader, trial::TrialReader::Open(path));
  while (true) {
    HAPTOMETER_LET(const auto chunk, reader.Next());
    if (chunk == nullptr) return reader.report();
  }
}

}  // namespace

Replay::Replay(trial::TrialReader reader) : reader_(std::move(reader)), header_(reader_.header()) {}

Result<std::unique_ptr<Sensor>> Replay::Open(const std::string& path) {
  HAPTOMETER_LET(const auto report, ReadToTheEnd(path));
  HAPTOMETER_LET(auto reader, trial::TrialReader::Open(path));
  std::unique_ptr<Replay> replay(new Replay(std::move(reader)));
  // the header of the new trial: the old one, with labels and exclusion as last given
  trial::Metadata& metadata = replay->header_.metadata;
  metadata = trial::MetadataOf(replay->header_, report);
  metadata.source = fmt::format("replay of {} ({})", path, metadata.source);
  // where it begins anew: its fit of times would run across the pauses
  for (const trial::Event& event : report.events) {
    if (!event.BeginsStretch() || event.row == 0) continue;
    replay->missing_[event.row] = event.missing.value_or(std::nullopt);
  }
  // what the recording itself cannot give
  if (!report.closed) {
    replay->found_.Add(
        {.severity = Severity::kDoubt, .kind = FindingKind::kReplayCutShort, .subject = path});
  }
  if (!report.losses.empty()) {
    Finding losses{.severity = Severity::kDoubt,
                   .kind = FindingKind::kReplayLosses,
                   .numbers = {{"losses", report.losses.size()}},
                   .subject = path};
    if (const auto rows = report.RowsLost()) losses.numbers.emplace_back("rows_lost", *rows);
    replay->found_.Add(std::move(losses));
  }
  return replay;
}

Result<void> Replay::Start(const std::atomic<bool>& /*stop*/) { return {}; }

Outcome Replay::Next(Reading& reading) {
  while (chunk_ == nullptr || row_ == chunk_->rows()) {
    // a damaged rest of the file ends the replay as a lost connection
    const auto next = reader_.Next();
    if (!next) return Outcome::kGone;
    if (*next == nullptr) return Outcome::kEnd;
    chunk_ = *next;
    row_ = 0;
  }
  reading.index = chunk_->first_index() + static_cast<std::int64_t>(row_);
  reading.time_ns = chunk_->TimeNs(row_);
  reading.reply_ns = chunk_->ReplyNs(row_);
  reading.samples.clear();
  for (std::size_t channel = 0; channel < header_.channels.size(); ++channel) {
    reading.samples.push_back(chunk_->At(row_, channel));
  }
  NoteGap(reading);
  ++row_;
  return Outcome::kReading;
}

void Replay::NoteGap(Reading& reading) {
  // the index of a clocked source says what is missing
  if (header_.timing == trial::Timing::kUniform) return;
  const std::uint64_t row = chunk_->first_row() + row_;
  const auto missing = missing_.find(row);
  const bool is_counted = missing != missing_.end() && missing->second.has_value();
  reading.lost_before = is_counted ? static_cast<std::int64_t>(*missing->second) : 0;
  // blocks that are lost in the file leave a jump of the rows
  reading.follows_gap = (missing != missing_.end() && !is_counted) || row != next_row_;
  next_row_ = row + 1;
}

}  // namespace haptometer::acquire
