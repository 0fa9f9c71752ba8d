#include "trial/trial_reader.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/clock.h"
#include "base/mapped.h"
#include "base/names.h"
#include "base/text.h"
#include "trial/block.h"
#include "trial/line_numbers.h"
#include "trial/time_base.h"
#include "trial/time_lines.h"

namespace haptometer::trial {
namespace {

// a place on the grid beyond this has no exact time
constexpr std::int64_t kMaxIndex = 1LL << 53;

// bytes that were written as a signature: its letters are there, what surrounds them is changed
bool IsNearSignature(std::span<const std::byte> start) {
  constexpr std::string_view kLetters = "haptrial";
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  return text.size() > kLetters.size() && text.substr(1, kLetters.size()) == kLetters;
}

// whether the bytes are a sound signature of any version
bool IsSignature(std::span<const std::byte> start) {
  constexpr std::size_t kVersionAt = 13;
  if (start.size() < kSignature.size()) return false;
  const auto version = std::to_integer<unsigned>(start[kVersionAt]);
  const auto complement = std::to_integer<unsigned>(start[kVersionAt + 1]);
  return std::memcmp(start.data(), kSignature.data(), kVersionAt) == 0 &&
         start.back() == std::byte{0} && version + complement == 0xff;
}

// success, with or without the loss of the signature, or why the file cannot be read
Result<void> CheckSignature(const ByteSource& source, const std::string& name,
                            std::vector<Loss>* losses) {
  std::array<std::byte, kSignature.size() + kBlockHeadBytes> bytes{};
  HAPTOMETER_LET(const auto got, source.ReadAt(0, bytes));
  const std::span start = std::span(bytes).first(std::min(got, kSignature.size()));
  if (IsSignature(start)) {
    if (std::memcmp(start.data(), kSignature.data(), kSignature.size()) == 0) return {};
    // sound, but of another version: newer, not damaged
    return CannotAnswer(name,
                        fmt::format("is a trial of format version {}, this program reads {}",
                                    std::to_integer<int>(start[13]), kFormatVersion),
                        "update haptometer");
  }
  // a damaged signature loses no rows if the first block behind it is sound
  const std::span rest = std::span(bytes).first(got).subspan(start.size());
  if (DecodeBlockHead(rest)) {
    losses->push_back({.offset = 0,
                       .bytes = kSignature.size(),
                       .kind = FindingKind::kSignatureDamaged,
                       .first_row = 0,
                       .rows = 0});
    return {};
  }
  if (got < kSignature.size() && std::memcmp(start.data(), kSignature.data(), got) == 0) {
    return CannotAnswer(name, "is cut short within its first bytes", "record it again");
  }
  if (IsNearSignature(start)) {
    return CannotAnswer(name, "was changed on its way here, as a text-mode transfer does",
                        "copy it again in binary mode");
  }
  return CannotAnswer(name, "is not a trial", std::string(kGiveATrial));
}

// what a source begins with; of a replay behind the path: "replay of PATH (SOURCE)"
std::optional<DataSource> StatedSource(std::string_view source) {
  constexpr std::array<std::pair<std::string_view, DataSource>, 6> kBegins{
      {{"device", DataSource::kDevice},
       {"emulated", DataSource::kEmulated},
       {"virtual terminal", DataSource::kEmulated},
       {"simulated", DataSource::kSimulated},
       {"imported", DataSource::kImported},
       {"piped in", DataSource::kImported}}};
  // a replay has the source of the recording that it repeats
  if (source.starts_with("replay of ")) {
    for (std::size_t at = source.find(" ("); at != std::string_view::npos;
         at = source.find(" (", at + 1)) {
      if (const auto stated = StatedSource(source.substr(at + 2))) return stated;
    }
    return std::nullopt;
  }
  for (const auto& [begin, stated] : kBegins) {
    if (source.starts_with(begin)) return stated;
  }
  return std::nullopt;
}

}  // namespace

std::string_view NameOf(DataSource source) {
  constexpr Names<DataSource, 5> kNames{
      {"device", "emulated", "simulated", "imported", "interrupted"}};
  return kNames.Of(source);
}

std::vector<DataSource> SourcesOf(const Metadata& metadata, const ReadReport& report) {
  std::vector<DataSource> sources;
  if (const auto stated = StatedSource(metadata.source)) {
    sources.push_back(*stated);
  } else if (report.kind != FileKind::kTrial && metadata.source.empty()) {
    // a foreign file that states no source is an import
    sources.push_back(DataSource::kImported);
  }
  if (report.IsInterrupted()) sources.push_back(DataSource::kInterrupted);
  return sources;
}

std::string_view Name(FileKind kind) {
  constexpr Names<FileKind, 7> kNames{
      {"trial", "CSV", "HDF5", "LabVIEW measurement", "NPY", "MAT", "WAV"}};
  return kNames.Of(kind);
}

Finding FindingOfLoss(const Loss& loss) {
  Finding finding{.severity = Severity::kDoubt, .kind = loss.kind};
  const auto add = [&](std::string_view name, std::uint64_t count) {
    finding.numbers.emplace_back(name, count);
  };
  if (loss.block) add(loss.last_block ? "first_block" : "block", *loss.block);
  if (loss.last_block) add("last_block", *loss.last_block);
  // blocks that are missing altogether occupy no bytes
  if (loss.bytes > 0) {
    add("from_byte", loss.offset);
    add("to_byte", loss.offset + loss.bytes - 1);
  }
  // without a sound block behind the loss the number of lost rows is unknown
  if (!loss.rows) {
    add("after_row", loss.first_row);
  } else if (*loss.rows == 1) {
    add("row", loss.first_row);
  } else if (*loss.rows > 1) {
    add("first_row", loss.first_row);
    add("last_row", loss.first_row + *loss.rows - 1);
  }
  return finding;
}

std::optional<std::uint64_t> ReadReport::RowsLost() const {
  std::uint64_t sum = 0;
  for (const Loss& loss : losses) {
    if (!loss.rows) return std::nullopt;
    sum += *loss.rows;
  }
  return sum;
}

bool ReadReport::IsInterrupted() const {
  return !closed || std::ranges::find(events, kInterruptedText, &Event::text) != events.end();
}

Findings ReadReport::AllFindings() const {
  Findings all;
  for (const Loss& loss : losses) all.Add(FindingOfLoss(loss));
  if (!closed) all.Doubt(FindingKind::kNotFinished);
  for (const Event& event : events) {
    if (event.kind != EventKind::kRemark || !event.text.starts_with(kDoubtMark)) continue;
    all.Doubt(FindingKind::kDoubtedAtRecording, {{"text", event.text.substr(kDoubtMark.size())}});
  }
  all.AddAll(findings);
  return all;
}

const std::byte* Chunk::RowAt(std::size_t row) const {
  HAPTOMETER_CHECK(row < rows_, "row {} of {}", row, rows_);
  return payload_.data() + row * layout_->row_bytes;
}

// a row is its time (0, 8 or 16 bytes), one raw value a channel, one status byte a channel
std::int64_t Chunk::TimeNs(std::size_t row) const {
  return layout_->time_bytes == 0 ? 0 : LoadLittleEndian<std::int64_t>(RowAt(row));
}

std::int64_t Chunk::ReplyNs(std::size_t row) const {
  return layout_->time_bytes < 16 ? 0 : LoadLittleEndian<std::int64_t>(RowAt(row) + 8);
}

Sample Chunk::At(std::size_t row, std::size_t channel) const {
  const std::byte* bytes = RowAt(row);
  const std::byte* value = bytes + layout_->value_offsets[channel];
  const std::uint64_t bits = layout_->value_bytes[channel] == 8
                                 ? LoadLittleEndian<std::uint64_t>(value)
                                 : LoadLittleEndian<std::uint32_t>(value);
  const auto status = std::to_integer<std::uint8_t>(bytes[layout_->status_offset + channel]);
  // a status of a later version is no measurement that this one can vouch for
  if (status >= kSampleStatusCount) return {RawValue::Bits(bits), SampleStatus::kInvalid};
  return {RawValue::Bits(bits), static_cast<SampleStatus>(status)};
}

double Chunk::ValueAt(std::size_t row, std::size_t channel) const {
  const Sample sample = At(row, channel);
  if (!IsMeasurement(sample.status)) return std::numeric_limits<double>::quiet_NaN();
  const ChannelFormat& format = header_->channels[channel];
  // value = raw * scale + offset, in the channel's unit
  return sample.raw.Number(format.encoding) * format.scale + format.offset;
}

struct TrialReader::State {
  std::unique_ptr<ByteSource> source;
  std::string name;
  TrialHeader header;
  RowLayout layout;
  std::optional<BlockScanner> scanner;
  std::vector<Loss> first_losses;  // before the scanner began
  std::int64_t next_index = 0;
  Chunk chunk;
  ReadReport report;

  // the header is the first sound block; there are two copies
  Result<void> FindHeader() {
    // a header that is not the first sound block would leave rows without a meaning
    HAPTOMETER_LET(const auto block, scanner->Next(&chunk.payload_));
    if (block && block->head.kind == BlockKind::kHeader) {
      if (auto found = HeaderFromJson(PayloadText())) {
        header = std::move(*found);
        layout = LayoutOf(header);
        chunk.header_ = &header;
        chunk.layout_ = &layout;
        return {};
      }
    }
    return CannotAnswer(name,
                        "both copies of its header are damaged or cut off, so its rows cannot "
                        "be read",
                        "take another copy of the file, or record it again");
  }

  [[nodiscard]] std::string_view PayloadText() const {
    return {reinterpret_cast<const char*>(chunk.payload_.data()), chunk.payload_.size()};
  }

  // takes over a block of rows; false where it does not fit the header
  bool TakeRows(const FoundBlock& block) {
    const BlockHead& head = block.head;
    const bool is_uniform = header.timing == Timing::kUniform;
    // places of a uniform grid increase; beyond 2^53 a place has no exact time
    const bool index_fits =
        !is_uniform || (head.first_index >= next_index && head.first_index <= kMaxIndex);
    // a sound payload holds whole rows of the size that the header gives
    const std::uint64_t bytes = std::uint64_t{head.rows} * layout.row_bytes;
    if (head.rows == 0 || bytes != head.payload_bytes || !index_fits) return false;
    chunk.rows_ = head.rows;
    chunk.first_row_ = head.first_row;
    // without a grid the writer's row number is the place
    chunk.first_index_ = is_uniform ? head.first_index : static_cast<std::int64_t>(head.first_row);
    chunk.offset_ = block.offset + kBlockHeadBytes;
    if (is_uniform) next_index = head.first_index + head.rows;
    report.rows += head.rows;
    return true;
  }

  // takes over anything else
  void Take(const FoundBlock& block) {
    switch (block.head.kind) {
      case BlockKind::kEvent:
      case BlockKind::kLaterEvent: {
        auto event = EventFromJson(PayloadText());
        if (event) {
          report.events.push_back(std::move(*event));
        } else {
          // sound bytes whose text is no event are a loss of this block alone
          scanner->Reject(block, FindingKind::kBlockNoEvent);
        }
        return;
      }
      case BlockKind::kClose:
        report.closed = true;
        return;
      case BlockKind::kHeader:
      case BlockKind::kRows:
        return;
    }
  }

  void CompleteReport() {
    // losses in the order of the file: signature first
    report.losses = first_losses;
    const std::vector<Loss>& found = scanner->losses();
    report.losses.insert(report.losses.end(), found.begin(), found.end());
    report.next_sequence = scanner->next_sequence();
    report.next_row = scanner->next_row();
  }
};

TrialReader::TrialReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
TrialReader::TrialReader(TrialReader&&) noexcept = default;
TrialReader& TrialReader::operator=(TrialReader&&) noexcept = default;
TrialReader::~TrialReader() = default;

Result<TrialReader> TrialReader::Open(const std::string& path) {
  HAPTOMETER_LET(auto source, OpenFileSource(path));
  return OpenFrom(std::move(source), path);
}

Result<TrialReader> TrialReader::OpenFrom(std::unique_ptr<ByteSource> source, std::string name) {
  auto state = std::make_unique<State>();
  HAPTOMETER_TRY(CheckSignature(*source, name, &state->first_losses));
  state->source = std::move(source);
  state->name = std::move(name);
  // blocks begin directly behind the signature, also behind a damaged one
  state->scanner.emplace(state->source.get(), kSignature.size());
  state->report.file_bytes = state->source->size();
  HAPTOMETER_TRY(state->FindHeader());
  return TrialReader(std::move(state));
}

const TrialHeader& TrialReader::header() const { return state_->header; }

std::size_t TrialReader::most_rows() const {
  return static_cast<std::size_t>(state_->source->size() / state_->layout.row_bytes);
}

Result<const Chunk*> TrialReader::Next() {
  State& state = *state_;
  for (;;) {
    HAPTOMETER_LET(const auto block, state.scanner->Next(&state.chunk.payload_));
    if (!block) {
      state.CompleteReport();
      return nullptr;
    }
    // events and the closing block are taken over on the way to the next rows
    if (block->head.kind != BlockKind::kRows) {
      state.Take(*block);
      continue;
    }
    if (state.TakeRows(*block)) return &state.chunk;
    state.scanner->Reject(*block, FindingKind::kBlockUnfit);
  }
}

Result<void> TrialReader::CheckRows(int threads) {
  BlockScanner& scanner = *state_->scanner;
  HAPTOMETER_LET(const auto end, SoundUntil(*state_->source, scanner.offset(), threads));
  // payloads up to `end` have right CRCs, so the scanner need not read them again
  scanner.Trust(end);
  return {};
}

const ReadReport& TrialReader::report() const { return state_->report; }

std::unique_ptr<ByteSource> TrialReader::TakeSource() && { return std::move(state_->source); }

Metadata MetadataOf(const TrialHeader& header, const ReadReport& report) {
  Metadata metadata = header.metadata;
  for (const Event& event : report.events) {
    // labels given later override earlier ones
    for (const auto& [key, value] : event.labels) metadata.labels[key] = value;
    // so do exclusions and what takes them back
    if (event.kind == EventKind::kExcluded) {
      metadata.fields[std::string(kExcludedField)] = event.text.empty() ? "not stated" : event.text;
    } else if (event.kind == EventKind::kIncluded) {
      metadata.fields.erase(std::string(kExcludedField));
    }
  }
  return metadata;
}

std::optional<std::string> ExclusionOf(const Metadata& metadata) {
  const auto found = metadata.fields.find(std::string(kExcludedField));
  return found == metadata.fields.end() ? std::nullopt : std::optional(found->second);
}

namespace {

// what the chunks add up to, beside the channels' values
struct Gathered {
  std::vector<std::int64_t> time_ns;
  std::vector<std::int64_t> reply_ns;
  UniformGrid grid;                 // kUniform
  std::vector<std::size_t> breaks;  // rows before which rows are missing
  std::uint64_t next_row = 0;       // as counted by the writer
};

// values in SI units, NaN where the status is no measurement
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
  // a jump of the writer's row number: blocks between the two are lost
  if (chunk.first_row() != gathered->next_row) gathered->breaks.push_back(gathered->time_ns.size());
  gathered->next_row = chunk.first_row() + chunk.rows();
  for (std::size_t row = 0; row < chunk.rows(); ++row) {
    gathered->time_ns.push_back(chunk.TimeNs(row));
    if (timing == Timing::kPolled) gathered->reply_ns.push_back(chunk.ReplyNs(row));
  }
}

}  // namespace

std::optional<std::vector<Stretch>> StoredTimeBase(const ReadReport& report) {
  std::vector<Stretch> stretches;
  std::size_t next_row = 0;
  for (const Event& event : report.events) {
    if (event.kind != EventKind::kTimeBase || !event.stretch) continue;
    const Stretch& stretch = *event.stretch;
    // segments follow each other without a gap or an overlap
    const bool is_usable = stretch.first_row == next_row && stretch.rows > 0 &&
                           stretch.rows <= report.rows - next_row &&
                           std::isfinite(stretch.start_s) && stretch.rate_hz > 0;
    if (!is_usable) return std::nullopt;
    stretches.push_back(stretch);
    next_row += stretch.rows;
  }
  // where rows were lost since the recording, its fit does not apply
  if (!report.losses.empty() || stretches.empty() || next_row != report.rows) return std::nullopt;
  return stretches;
}

namespace {

// where rows are missing: blocks lost in the file, or losses that the recorder noted
std::vector<MissingRows> Missing(const Gathered& gathered, const ReadReport& report) {
  auto missing = Mapped<MissingRows>(
      gathered.breaks, [](const std::size_t row) { return MissingRows{row, std::nullopt}; });
  // event.row counts the rows that were written, so it applies only where all were read
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

// how a source numbers its lines, of its fields: "0 to 999", and the seconds of one on its wire
NumberedLines LinesOf(const Metadata& metadata) {
  NumberedLines lines;
  const auto numbers = metadata.fields.find(std::string(kLineNumbersField));
  constexpr std::string_view kTo = "0 to ";
  if (numbers != metadata.fields.end() && numbers->second.starts_with(kTo)) {
    const auto last = NumberFrom<std::uint32_t>(numbers->second.substr(kTo.size()));
    if (last) lines.turn = std::uint64_t{*last} + 1;
  }
  const auto latency = metadata.fields.find(std::string(kLatencyField));
  if (latency != metadata.fields.end()) {
    const auto wire_s = NumberFrom<double>(latency->second);
    if (wire_s && *wire_s > 0) lines.wire_ns = kNsPerSecond * *wire_s;
  }
  return lines;
}

// the losses of numbered lines that their times hold; a doubt where one is refused
JudgedLosses HeldLosses(const Gathered& gathered, const std::vector<MissingRows>& missing,
                        const Metadata& metadata, Findings* findings) {
  JudgedLosses judged = JudgeLosses(gathered.time_ns, missing, LinesOf(metadata));
  if (!judged.refused.empty()) {
    const MissingRows& first = judged.refused.front();
    findings->Doubt(FindingKind::kNumbersRefuted, {{"lines", judged.refused.size()},
                                                   {"row", first.row},
                                                   {"missing", first.count.value_or(0)}});
  }
  return judged;
}

void SetTimes(const TrialHeader& header, Gathered gathered, ReadReport& report, Record* record) {
  if (header.timing == Timing::kUniform) {
    record->stretches = StoredTimeBase(report).value_or(gathered.grid.stretches());
    return;
  }
  // raw time: of arrival, or the middle of request and reply
  record->raw_times_s.reserve(record->rows);
  for (std::size_t row = 0; row < record->rows; ++row) {
    const double time_s = SecondsFromNs(gathered.time_ns[row]);
    const bool is_polled = header.timing == Timing::kPolled;
    const double reply_s = is_polled ? SecondsFromNs(gathered.reply_ns[row]) : time_s;
    record->raw_times_s.push_back(0.5 * (time_s + reply_s));
  }
  // the recorder's fit overrides a new one
  if (auto stored = StoredTimeBase(report)) {
    record->stretches = std::move(*stored);
    return;
  }
  // no usable fit in the file: a new one from the raw times
  std::vector<MissingRows> missing = Missing(gathered, report);
  const auto nominal_rate_hz = header.metadata.nominal_rate_hz;
  if (header.timing == Timing::kPolled) {
    const auto breaks = Mapped<std::size_t>(missing, &MissingRows::row);
    record->stretches =
        FitPolledTimes(gathered.time_ns, gathered.reply_ns, nominal_rate_hz, breaks);
    return;
  }
  // a lost block may have held the event of a loss: then the list of losses is not complete
  bool is_numbered =
      report.losses.empty() && header.metadata.fields.contains(std::string(kLineNumbersField));
  if (is_numbered) {
    JudgedLosses judged = HeldLosses(gathered, missing, header.metadata, &report.findings);
    missing = std::move(judged.missing);
    // numbers of which some are wrong do not state every loss
    is_numbered = judged.refused.empty();
  }
  record->stretches = FitArrivalTimes(gathered.time_ns, nominal_rate_hz, missing, is_numbered);
}

// the whole file in memory: values, statuses, time base, metadata and report
Result<Recording> Gather(TrialReader* reader) {
  const TrialHeader& header = reader->header();
  Recording recording{.record = {}, .report = {}};
  Record& record = recording.record;
  record.timing = header.timing;
  for (const ChannelFormat& format : header.channels) record.channels.push_back(ChannelOf(format));
  // So that nothing is moved; memory that is not used is not taken from the system. A file of more
  // than that may consist of holes.
  const std::size_t rows = std::min(reader->most_rows(), std::size_t{1} << 28);
  for (Channel& channel : record.channels) {
    channel.values.reserve(rows);
    channel.statuses.reserve(rows);
  }
  Gathered gathered{
      .time_ns = {}, .reply_ns = {}, .grid = UniformGrid(header.rate_hz), .breaks = {}};
  if (header.timing != Timing::kUniform) gathered.time_ns.reserve(rows);
  for (;;) {
    HAPTOMETER_LET(const auto chunk, reader->Next());
    if (chunk == nullptr) break;
    AppendValues(*chunk, &record);
    if (header.timing == Timing::kUniform) {
      gathered.grid.Append(chunk->first_index(), chunk->rows());
    } else {
      AppendTimes(*chunk, header.timing, &gathered);
    }
    record.rows += chunk->rows();
  }
  // the report is complete only behind the last block
  recording.report = reader->report();
  recording.report.first_labels = header.metadata.labels;
  SetTimes(header, std::move(gathered), recording.report, &record);
  record.metadata = MetadataOf(header, recording.report);
  return recording;
}

}  // namespace

Result<Recording> ReadRecord(const std::string& path) {
  HAPTOMETER_LET(auto reader, TrialReader::Open(path));
  return Gather(&reader);
}

Result<Recording> ReadRecordFrom(std::unique_ptr<ByteSource> source, std::string name) {
  HAPTOMETER_LET(auto reader, TrialReader::OpenFrom(std::move(source), std::move(name)));
  return Gather(&reader);
}

}  // namespace haptometer::trial
