#include "acquire/recorder/row_sink.h"

#include <fmt/core.h>

#include "trial/block.h"

namespace haptometer::acquire {

TrialRotation::TrialRotation(NamePart name, trial::TrialHeader header, RotationLimits limits,
                             Clock& clock, trial::WriterOptions options)
    : name_(std::move(name)),
      header_(std::move(header)),
      limits_(limits),
      clock_(clock),
      options_(options),
      row_bytes_(trial::LayoutOf(header_).row_bytes) {}

Result<std::unique_ptr<TrialRotation>> TrialRotation::Begin(NamePart name,
                                                            trial::TrialHeader header,
                                                            RotationLimits limits, Clock& clock,
                                                            trial::WriterOptions options) {
  std::unique_ptr<TrialRotation> rotation(
      new TrialRotation(std::move(name), std::move(header), limits, clock, options));
  HAPTOMETER_TRY(rotation->BeginPart(nullptr));
  return rotation;
}

// the first part begins with the recording, each other one with the row that is due
Result<void> TrialRotation::BeginPart(const trial::Row* first) {
  trial::TrialHeader header = header_;
  ++part_;
  // fields that only a continuation has: its start in the recording, and the part before
  header.metadata.fields["part"] = std::to_string(part_);
  if (first != nullptr) {
    const bool is_uniform = header.timing == trial::Timing::kUniform;
    start_index_ = first->index;
    // start in ns since the beginning of the recording
    start_ns_ = is_uniform ? NsFromSeconds(static_cast<double>(first->index) / header.rate_hz)
                           : first->time_ns;
    header.metadata.fields["part_start_s"] = fmt::format("{:.9f}", SecondsFromNs(start_ns_));
    header.metadata.fields["continues"] = file_;
    header.metadata.utc_start = UtcNow();
    // notes are on what was before the recording
    header.metadata.notes.clear();
  }
  rows_ = 0;
  const std::string file = name_(part_);
  HAPTOMETER_LET(auto writer,
                 trial::TrialWriter::Create(file, std::move(header), options_, clock_));
  writer_ = std::move(writer);
  // file() is called from other threads
  const std::lock_guard lock(file_mutex_);
  file_ = file;
  return {};
}

bool TrialRotation::IsDue(const trial::Row& row) {
  // a part has at least one row
  if (rows_ == 0) return false;
  // a split on request, then by size, then by duration
  if (is_asked_.exchange(false)) return true;
  if (limits_.bytes && (rows_ + 1) * row_bytes_ > *limits_.bytes) return true;
  if (!limits_.duration_ns) return false;
  const MonotonicNs time_ns =
      header_.timing == trial::Timing::kUniform
          ? NsFromSeconds(static_cast<double>(row.index - start_index_) / header_.rate_hz)
          : row.time_ns - start_ns_;
  return time_ns >= *limits_.duration_ns;
}

Result<void> TrialRotation::Append(const trial::Row& row) {
  // the old part is complete before the new one begins
  if (IsDue(row)) {
    HAPTOMETER_TRY(Finish());
    HAPTOMETER_TRY(BeginPart(&row));
  }
  // times and indices count from the beginning of the part
  trial::Row here = row;
  here.index -= start_index_;
  here.time_ns -= start_ns_;
  here.reply_ns -= start_ns_;
  ++rows_;
  return writer_->Append(here);
}

Result<void> TrialRotation::AddEvent(trial::Event event) {
  if (event.time_ns) *event.time_ns -= start_ns_;
  return writer_->AddEvent(std::move(event));
}

Result<void> TrialRotation::Finish() {
  const auto totals = writer_->Finish();
  return totals ? Result<void>{} : std::unexpected(totals.error());
}

std::string TrialRotation::file() const {
  const std::lock_guard lock(file_mutex_);
  return file_;
}

}  // namespace haptometer::acquire
