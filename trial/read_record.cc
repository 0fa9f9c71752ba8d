#include <algorithm>
#include <cmath>
#include <utility>

#include "base/clock.h"
#include "trial/time_base.h"
#include "trial/trial_reader.h"
#include "trial/uniform_grid.h"

namespace haptometer::trial {
namespace {

// what the chunks add up to, beside the channels' values
struct Gathered {
  std::vector<std::int64_t> time_ns;
  std::vector<std::int64_t> reply_ns;
  UniformGrid grid;                 // kUniform
  std::vector<std::size_t> breaks;  // rows before which rows are missing
  std::uint64_t next_row = 0;       // as counted by the writer
};

void AppendValues(const Chunk& chunk, Record* record) {
  for (std::size_t c = 0; c < record->channels.size(); ++c) {
    Channel& channel = record->channels[c];
    for (std::size_t row = 0; row < chunk.rows(); ++row) {
      channel.values.push_back(chunk.ValueAt(row, c));
      channel.statuses.push_back(chunk.At(row, c).status);
    }
  }
}

void AppendTimes(const Chunk& chunk, Timing timing, Gathered* gathered) {
  if (chunk.first_row() != gathered->next_row) gathered->breaks.push_back(gathered->time_ns.size());
  gathered->next_row = chunk.first_row() + chunk.rows();
  for (std::size_t row = 0; row < chunk.rows(); ++row) {
    gathered->time_ns.push_back(chunk.TimeNs(row));
    if (timing == Timing::kPolled) gathered->reply_ns.push_back(chunk.ReplyNs(row));
  }
}

// the recorder's own fit, where it covers exactly the rows that were read
std::optional<std::vector<Stretch>> StoredTimeBase(const ReadReport& report) {
  std::vector<Stretch> stretches;
  std::size_t next_row = 0;
  for (const Event& event : report.events) {
    if (event.kind != EventKind::kTimeBase || !event.stretch) continue;
    const Stretch& stretch = *event.stretch;
    const bool is_usable = stretch.first_row == next_row && stretch.rows > 0 &&
                           stretch.rows <= report.rows - next_row &&
                           std::isfinite(stretch.start_s) && stretch.rate_hz > 0;
    if (!is_usable) return std::nullopt;
    stretches.push_back(stretch);
    next_row += stretch.rows;
  }
  if (!report.losses.empty() || stretches.empty() || next_row != report.rows) return std::nullopt;
  return stretches;
}

// where rows are missing: damaged in the file, or as the recorder knew
std::vector<MissingRows> Missing(const Gathered& gathered, const ReadReport& report) {
  std::vector<MissingRows> missing;
  missing.reserve(gathered.breaks.size());
  for (const std::size_t row : gathered.breaks) missing.push_back({row, std::nullopt});
  if (report.losses.empty()) {
    for (const Event& event : report.events) {
      if (!event.BeginsStretch() || event.row >= report.rows) continue;
      // beyond any recording a number is damage, and would cost the places their digits
      constexpr std::uint64_t kMost = std::uint64_t{1} << 40;
      const auto count = event.missing.value_or(std::nullopt);
      missing.push_back({event.row, count.value_or(0) <= kMost ? count : std::nullopt});
    }
  }
  std::ranges::sort(missing, {}, &MissingRows::row);
  return missing;
}

void SetTimes(const TrialHeader& header, Gathered gathered, const ReadReport& report,
              Record* record) {
  if (header.timing == Timing::kUniform) {
    record->stretches = gathered.grid.stretches();
    return;
  }
  record->raw_times_s.reserve(record->rows);
  for (std::size_t row = 0; row < record->rows; ++row) {
    const double time_s = SecondsFromNs(gathered.time_ns[row]);
    const bool is_polled = header.timing == Timing::kPolled;
    const double reply_s = is_polled ? SecondsFromNs(gathered.reply_ns[row]) : time_s;
    record->raw_times_s.push_back(0.5 * (time_s + reply_s));
  }
  if (auto stored = StoredTimeBase(report)) {
    record->stretches = std::move(*stored);
    return;
  }
  const std::vector<MissingRows> missing = Missing(gathered, report);
  const auto nominal_rate_hz = header.metadata.nominal_rate_hz;
  if (header.timing == Timing::kPolled) {
    std::vector<std::size_t> breaks;
    breaks.reserve(missing.size());
    for (const MissingRows& at : missing) breaks.push_back(at.row);
    record->stretches =
        FitPolledTimes(gathered.time_ns, gathered.reply_ns, nominal_rate_hz, breaks);
    return;
  }
  // where a damaged block is missing, so may be an event that tells of a loss
  const bool is_numbered =
      report.losses.empty() && header.metadata.fields.contains(std::string(kLineNumbersField));
  record->stretches = FitArrivalTimes(gathered.time_ns, nominal_rate_hz, missing, is_numbered);
}

Result<Recording> Gather(TrialReader* reader) {
  const TrialHeader& header = reader->header();
  Recording recording{.record = {}, .report = {}};
  Record& record = recording.record;
  record.timing = header.timing;
  for (const ChannelFormat& format : header.channels) record.channels.push_back(ChannelOf(format));
  Gathered gathered{
      .time_ns = {}, .reply_ns = {}, .grid = UniformGrid(header.rate_hz), .breaks = {}};
  for (;;) {
    const auto chunk = reader->Next();
    if (!chunk) return std::unexpected(chunk.error());
    if (*chunk == nullptr) break;
    AppendValues(**chunk, &record);
    if (header.timing == Timing::kUniform) {
      gathered.grid.Append((*chunk)->first_index(), (*chunk)->rows());
    } else {
      AppendTimes(**chunk, header.timing, &gathered);
    }
    record.rows += (*chunk)->rows();
  }
  recording.report = reader->report();
  SetTimes(header, std::move(gathered), recording.report, &record);
  record.metadata = MetadataOf(header, recording.report);
  return recording;
}

}  // namespace

Result<Recording> ReadRecord(const std::string& path) {
  auto reader = TrialReader::Open(path);
  if (!reader) return std::unexpected(reader.error());
  return Gather(&*reader);
}

Result<Recording> ReadRecordFrom(std::unique_ptr<ByteSource> source, std::string name) {
  auto reader = TrialReader::OpenFrom(std::move(source), std::move(name));
  if (!reader) return std::unexpected(reader.error());
  return Gather(&*reader);
}

}  // namespace haptometer::trial
