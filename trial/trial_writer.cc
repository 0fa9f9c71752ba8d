#include "trial/trial_writer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "base/clock.h"
#include "trial/block.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {
namespace {

// a block is written when it holds this much; a damaged one then loses few rows
constexpr std::size_t kBlockBytes = 1U << 16;

// conditions that the program must fulfil, not the user
void CheckHeader(const TrialHeader& header) {
  HAPTOMETER_CHECK(!header.channels.empty() && header.channels.size() <= kMaxChannels,
                   "{} channels", header.channels.size());
  HAPTOMETER_CHECK(
      header.timing != Timing::kUniform || (std::isfinite(header.rate_hz) && header.rate_hz > 0),
      "rate {} Hz", header.rate_hz);
  for (const ChannelFormat& channel : header.channels) {
    HAPTOMETER_CHECK(std::isfinite(channel.scale) && std::isfinite(channel.offset),
                     "channel {}: scale {}, offset {}", channel.name, channel.scale,
                     channel.offset);
  }
}

}  // namespace

struct TrialWriter::State {
  std::unique_ptr<ByteSink> sink;
  std::string name;
  TrialHeader header;
  RowLayout layout;
  WriterOptions options;
  Clock* clock = nullptr;

  std::vector<std::byte> rows;  // the block that is being filled
  std::size_t rows_per_block = 0;
  std::size_t rows_waiting = 0;
  std::int64_t first_index = 0;  // of the rows that wait
  std::int64_t next_index = 0;   // least index that may follow
  std::uint32_t sequence = 0;
  MonotonicNs last_flush_ns = 0;
  TrialTotals totals;
  bool finished = false;
  std::optional<Error> error;  // the first one; sticky

  // the first error stays: rows that are kept are counted in it
  Result<void> Broken(const Error& cause) {
    std::string remedy = cause.remedy;
    if (remedy.empty()) {
      remedy = fmt::format("{} of {} rows are kept; make room and record the rest to another file",
                           totals.rows_kept, totals.rows);
    }
    error = Error{Cause::kFailed, name, "could not be written: " + cause.what, std::move(remedy)};
    return std::unexpected(*error);
  }

  // one block of JSON: header, event or totals
  Result<void> WriteText(BlockKind kind, const std::string& json) {
    const BlockHead head{.kind = kind,
                         .sequence = sequence++,
                         .first_row = totals.rows,
                         .first_index = PlaceOfNextRow()};
    if (auto done = WriteBlock(sink.get(), head, BytesOfText(json)); !done) {
      return Broken(done.error());
    }
    return {};
  }

  // the place on the grid, or the row number without a grid
  [[nodiscard]] std::int64_t PlaceOfNextRow() const {
    return header.timing == Timing::kUniform ? next_index : static_cast<std::int64_t>(totals.rows);
  }

  // the rows that wait as one block; only then they count as kept
  Result<void> WriteRows() {
    if (rows_waiting == 0) return {};
    const BlockHead head{.kind = BlockKind::kRows,
                         .sequence = sequence++,
                         .rows = static_cast<std::uint32_t>(rows_waiting),
                         .first_row = totals.rows - rows_waiting,
                         .first_index = first_index};
    const std::span payload(rows.data(), rows_waiting * layout.row_bytes);
    if (auto done = WriteBlock(sink.get(), head, payload); !done) return Broken(done.error());
    rows_waiting = 0;
    totals.rows_kept = totals.rows;
    return {};
  }

  Result<void> Flush() {
    HAPTOMETER_TRY(WriteRows());
    // before the sync, whose duration is part of the interval
    last_flush_ns = clock->Now();
    if (auto done = sink->Sync(); !done) return Broken(done.error());
    return {};
  }

  Result<void> FlushIfDue() {
    const double waited_s = SecondsFromNs(clock->Now() - last_flush_ns);
    if (waited_s < options.flush_interval_s) return {};
    return Flush();
  }

  // address of the next row, whose times are stored
  std::byte* Place(const Row& row) {
    std::byte* place = rows.data() + rows_waiting * layout.row_bytes;
    if (layout.time_bytes >= 8) StoreLittleEndian(row.time_ns, place);
    if (layout.time_bytes == 16) StoreLittleEndian(row.reply_ns, place + 8);
    return place;
  }

  // copies a row into the block that waits: raw bits, then status bytes
  void Store(const Row& row) {
    std::byte* place = Place(row);
    for (std::size_t channel = 0; channel < row.samples.size(); ++channel) {
      const Sample& sample = row.samples[channel];
      const std::uint64_t bits = sample.raw.bits();
      std::memcpy(place + layout.value_offsets[channel], &bits, layout.value_bytes[channel]);
      place[layout.status_offset + channel] = static_cast<std::byte>(sample.status);
      ++totals.statuses[static_cast<std::size_t>(sample.status)];
    }
    ++rows_waiting;
    ++totals.rows;
  }
};

TrialWriter::TrialWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
TrialWriter::TrialWriter(TrialWriter&&) noexcept = default;
TrialWriter& TrialWriter::operator=(TrialWriter&&) noexcept = default;
TrialWriter::~TrialWriter() = default;

Result<TrialWriter> TrialWriter::Create(const std::string& path, TrialHeader header,
                                        WriterOptions options, Clock& clock) {
  HAPTOMETER_TRY(CheckTexts(header));
  HAPTOMETER_LET(auto sink,
                 CreateFileSink(path, options.overwrite ? IfExists::kReplace : IfExists::kRefuse));
  return CreateIn(std::move(sink), path, std::move(header), options, clock);
}

Result<TrialWriter> TrialWriter::CreateIn(std::unique_ptr<ByteSink> sink, std::string name,
                                          TrialHeader header, WriterOptions options, Clock& clock) {
  CheckHeader(header);
  HAPTOMETER_TRY(CheckTexts(header));
  auto state = std::make_unique<State>();
  state->sink = std::move(sink);
  state->name = std::move(name);
  state->layout = LayoutOf(header);
  state->header = std::move(header);
  state->options = options;
  state->clock = &clock;
  // at least one row, even if it is larger than a block should be
  state->rows_per_block = std::max<std::size_t>(1, kBlockBytes / state->layout.row_bytes);
  state->rows.resize(state->rows_per_block * state->layout.row_bytes);
  const auto signature = std::as_bytes(std::span(kSignature));
  if (auto done = WriteAll(state->sink.get(), signature); !done) {
    return std::unexpected(state->Broken(done.error()).error());
  }
  // twice, because no row can be read without it
  const std::string json = HeaderToJson(state->header);
  for (int copy = 0; copy < 2; ++copy) HAPTOMETER_TRY(state->WriteText(BlockKind::kHeader, json));
  // the header is on the disk before the first row comes
  HAPTOMETER_TRY(state->Flush());
  return TrialWriter(std::move(state));
}

Result<void> TrialWriter::Append(const Row& row) {
  State& state = *state_;
  if (state.error) return std::unexpected(*state.error);
  HAPTOMETER_CHECK(!state.finished && row.samples.size() == state.header.channels.size(),
                   "{} samples for {} channels, finished: {}", row.samples.size(),
                   state.header.channels.size(), state.finished);
  const bool is_uniform = state.header.timing == Timing::kUniform;
  // without a grid the row number is the place
  const std::int64_t index = is_uniform ? row.index : static_cast<std::int64_t>(state.totals.rows);
  HAPTOMETER_CHECK(index >= state.next_index, "index {} after {}", index, state.next_index - 1);
  // rows of one block follow each other on the grid
  if (index != state.next_index && state.rows_waiting > 0) HAPTOMETER_TRY(state.WriteRows());
  if (state.rows_waiting == 0) state.first_index = index;
  state.next_index = index + 1;
  state.Store(row);
  if (state.rows_waiting == state.rows_per_block) HAPTOMETER_TRY(state.WriteRows());
  return state.FlushIfDue();
}

Result<void> TrialWriter::AddEvent(Event event) {
  State& state = *state_;
  if (state.error) return std::unexpected(*state.error);
  HAPTOMETER_CHECK(!state.finished, "event after the end");
  // rows that came before the event are written before it
  event.row = state.totals.rows;
  HAPTOMETER_TRY(state.WriteRows());
  return state.WriteText(BlockKind::kEvent, EventToJson(event));
}

Result<void> TrialWriter::FlushIfDue() {
  if (state_->error) return std::unexpected(*state_->error);
  return state_->FlushIfDue();
}

Result<void> TrialWriter::Flush() {
  if (state_->error) return std::unexpected(*state_->error);
  return state_->Flush();
}

Result<TrialTotals> TrialWriter::Finish() {
  State& state = *state_;
  if (state.error) return std::unexpected(*state.error);
  HAPTOMETER_CHECK(!state.finished, "finished twice");
  // order: rows, totals, sync; a file without totals is incomplete
  HAPTOMETER_TRY(state.WriteRows());
  HAPTOMETER_TRY(state.WriteText(BlockKind::kClose, TotalsToJson(state.totals)));
  HAPTOMETER_TRY(state.Flush());
  state.finished = true;
  state.totals.moved_to = state.sink->MovedTo();
  state.sink.reset();
  return state.totals;
}

const TrialHeader& TrialWriter::header() const { return state_->header; }
const TrialTotals& TrialWriter::totals() const { return state_->totals; }

Result<void> AppendEvent(const std::string& path, Event event) {
  HAPTOMETER_TRY(CheckTexts(event));
  // a file that is no trial is refused before it is opened for writing
  HAPTOMETER_LET(auto reader, TrialReader::Open(path));
  HAPTOMETER_LET(auto sink, OpenFileSinkAtEnd(path));
  // again under the lock, because the recorder may have written in between
  HAPTOMETER_LET(reader, TrialReader::Open(path));
  // to the end, for the next sequence number and row
  for (;;) {
    HAPTOMETER_LET(const auto chunk, reader.Next());
    if (chunk == nullptr) break;
  }
  const ReadReport& report = reader.report();
  event.row = report.next_row;
  event.utc = UtcNow();
  // its own kind, because its first row is the count that this reader had
  const BlockHead head{.kind = BlockKind::kLaterEvent,
                       .sequence = report.next_sequence,
                       .first_row = report.next_row,
                       .first_index = static_cast<std::int64_t>(report.next_row)};
  auto done = WriteBlock(sink.get(), head, BytesOfText(EventToJson(event)));
  if (done) done = sink->Sync();
  if (!done) {
    return Failed(path, "could not be written: " + done.error().what,
                  "the recording itself is unchanged; make room and repeat the command");
  }
  return {};
}

}  // namespace haptometer::trial
