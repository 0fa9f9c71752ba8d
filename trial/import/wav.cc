// WAV files: RIFF chunks of a format, samples and lists (IBM and Microsoft, Multimedia Programming
// Interface and Data Specifications 1.0, 1991; of the extensible format: Microsoft, Multiple
// Channel Audio Data and WAVE Files, 2001).
#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trial/block.h"
#include "trial/export/object_names.h"
#include "trial/import/exported_trial.h"
#include "trial/import/number_table.h"
#include "trial/import/readers.h"
#include "trial/import/table/csv_header.h"
#include "trial/import/table/table_cells.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

constexpr std::size_t kTagBytes = 8;  // name and length of a chunk
constexpr const char* kRemedy = "export the trial again, or save the sound as 16-bit PCM or floats";

// what the chunks of a file hold; views into its bytes
struct Chunks {
  std::string_view format{};
  std::string_view samples{};
  std::size_t stated_bytes = 0;  // of samples, as the chunk states them
  std::string_view description{};
  std::string_view statuses{};
};

// how samples are stored
struct Format {
  bool is_float = false;
  std::size_t channels = 0;
  std::uint32_t rate_hz = 0;
  std::size_t bytes = 0;  // of one sample
  std::size_t bits = 0;   // of these, from the highest on, that hold it

  [[nodiscard]] std::size_t row_bytes() const { return channels * bytes; }
};

template <typename T>
T At(std::string_view bytes, std::size_t at) {
  return LoadLittleEndian<T>(reinterpret_cast<const std::byte*>(bytes.data() + at));
}

// a chunk's name and content, as far as it is there; `bytes` then begin behind it
struct Chunk {
  std::string_view name{};
  std::string_view content{};
  std::size_t stated_bytes = 0;
};
// whether `bytes` begin with a chunk that is a whole one
bool IsChunk(std::string_view bytes) {
  if (bytes.size() < kTagBytes) return false;
  const bool is_name = std::ranges::all_of(bytes.substr(0, 4), [](char c) {
    return c == ' ' || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
  });
  return is_name && At<std::uint32_t>(bytes, 4) <= bytes.size() - kTagBytes;
}

Chunk TakeChunk(std::string_view* bytes) {
  Chunk chunk{.name = bytes->substr(0, 4), .stated_bytes = At<std::uint32_t>(*bytes, 4)};
  bytes->remove_prefix(kTagBytes);
  // samples that went to a pipe: their number was not known ahead of them
  if (chunk.name == "data" && chunk.stated_bytes == 0 && !IsChunk(*bytes)) {
    chunk.stated_bytes = bytes->size();
  }
  chunk.content = bytes->substr(0, chunk.stated_bytes);
  // an odd length is padded
  bytes->remove_prefix(std::min(chunk.stated_bytes + chunk.stated_bytes % 2, bytes->size()));
  return chunk;
}

// the list that only this program writes
void TakeOwnChunks(std::string_view list, Chunks* chunks) {
  while (list.size() >= kTagBytes) {
    const Chunk chunk = TakeChunk(&list);
    if (chunk.name == "desc") chunks->description = chunk.content;
    if (chunk.name == "stat") chunks->statuses = chunk.content;
  }
}

Chunks ChunksOf(std::string_view bytes) {
  constexpr std::size_t kHeadBytes = 12;  // RIFF, length, WAVE
  bytes.remove_prefix(std::min(kHeadBytes, bytes.size()));
  Chunks chunks;
  while (bytes.size() >= kTagBytes) {
    const Chunk chunk = TakeChunk(&bytes);
    if (chunk.name == "fmt ") chunks.format = chunk.content;
    if (chunk.name == "data" && chunks.samples.empty()) {
      chunks.samples = chunk.content;
      chunks.stated_bytes = chunk.stated_bytes;
    }
    if (chunk.name == "LIST" && chunk.content.starts_with("hapt")) {
      TakeOwnChunks(chunk.content.substr(4), &chunks);
    }
  }
  return chunks;
}

// whole numbers of 1 to 4 bytes or floats of 4 or 8; nothing for what else there is
std::optional<Format> FormatOf(std::string_view chunk) {
  constexpr std::size_t kLeast = 16;
  constexpr std::size_t kSubFormat = 24;
  if (chunk.size() < kLeast) return std::nullopt;
  std::uint16_t tag = At<std::uint16_t>(chunk, 0);
  constexpr std::uint16_t kExtensible = 0xfffe;
  constexpr std::uint16_t kPcm = 1;
  constexpr std::uint16_t kFloat = 3;
  // the extensible form has the tag at the beginning of a GUID
  const std::size_t bits = At<std::uint16_t>(chunk, 14);
  std::size_t valid_bits = bits;
  if (tag == kExtensible && chunk.size() >= kSubFormat + 2) {
    tag = At<std::uint16_t>(chunk, kSubFormat);
    // 24 bits in 32, say
    const std::size_t stated = At<std::uint16_t>(chunk, 18);
    if (stated > 0 && stated < bits) valid_bits = stated;
  }
  const Format format{.is_float = tag == kFloat,
                      .channels = At<std::uint16_t>(chunk, 2),
                      .rate_hz = At<std::uint32_t>(chunk, 4),
                      .bytes = bits / 8,
                      .bits = valid_bits};
  const bool is_known = (tag == kPcm && (bits == 8 || bits == 16 || bits == 24 || bits == 32)) ||
                        (tag == kFloat && (bits == 32 || bits == 64));
  const bool is_sound = is_known && format.channels > 0 && format.channels <= kMostColumns * 2 &&
                        format.rate_hz > 0 && At<std::uint16_t>(chunk, 12) == format.row_bytes();
  return is_sound ? std::optional(format) : std::nullopt;
}

// one sample; a whole number as a part of full scale, -1 to 1
double SampleAt(const Format& format, std::string_view samples, std::size_t at) {
  if (format.is_float && format.bytes == 8) return At<double>(samples, at);
  if (format.is_float) return static_cast<double>(At<float>(samples, at));
  std::uint32_t bits = 0;
  // the bytes of the number lie at the upper end of 32 bits, so that the sign is in its place
  for (std::size_t i = 0; i < format.bytes; ++i) {
    const std::size_t shift = 8 * (4 - format.bytes + i);
    bits |= static_cast<std::uint32_t>(static_cast<unsigned char>(samples[at + i])) << shift;
  }
  // a single byte counts from 128
  if (format.bytes == 1) bits ^= 0x80000000U;
  return static_cast<double>(std::bit_cast<std::int32_t>(bits)) / 0x1p31;
}

std::vector<NumberColumn> ColumnsOf(const Format& format, std::string_view samples) {
  const std::size_t rows = samples.size() / format.row_bytes();
  std::vector<NumberColumn> columns(format.channels);
  for (std::size_t c = 0; c < format.channels; ++c) {
    columns[c].values.reserve(rows);
    for (std::size_t row = 0; row < rows; ++row) {
      columns[c].values.push_back(
          SampleAt(format, samples, row * format.row_bytes() + c * format.bytes));
    }
  }
  return columns;
}

// whole numbers at an end of the converter's range are no measurement
void MarkClipped(const Format& format, std::vector<NumberColumn>* columns) {
  if (format.is_float) return;
  const double most = 1 - std::ldexp(1.0, 1 - static_cast<int>(format.bits));
  for (NumberColumn& column : *columns) {
    column.statuses.reserve(column.values.size());
    for (const double value : column.values) {
      const bool is_at_end = value <= -1 || value >= most;
      column.statuses.push_back(is_at_end ? SampleStatus::kClipped : SampleStatus::kOk);
    }
  }
}

// the statuses of channel `c` of `channels`, all ok where the file holds none
std::vector<std::uint8_t> StatusesOf(std::string_view statuses, std::size_t c, std::size_t channels,
                                     std::size_t rows) {
  std::vector<std::uint8_t> column;
  column.reserve(rows);
  if (statuses.empty()) column.resize(rows);
  for (std::size_t at = c; at < statuses.size(); at += channels) {
    column.push_back(static_cast<std::uint8_t>(statuses[at]));
  }
  return column;
}

// the trial that the samples and the list of this program hold
Result<Recording> ReadExport(const Chunks& chunks, std::vector<NumberColumn> columns,
                             const std::string& name) {
  ObjectsInMemory objects(name);
  HAPTOMETER_TRY(AddDescription(chunks.description, &objects));
  const auto header = HeaderFromJson(objects.texts[objects::kHeader]);
  if (!header || header->channels.size() != columns.size()) {
    return objects.Wrong(objects::kHeader, "is not that of its samples");
  }
  const auto& offsets = objects.numbers[kSampleOffsets];
  if (offsets.size() != columns.size()) return objects.Wrong(kSampleOffsets, "are not its own");
  std::vector<Channel> channels;
  for (const ChannelFormat& format : header->channels) channels.push_back(ChannelOf(format));
  const std::vector<std::string> names = CsvColumnNames(channels);
  const std::size_t rows = columns.front().values.size();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    // value = sample + offset; an offset of 0 keeps the sign of a zero
    if (offsets[c] != 0) {
      for (double& value : columns[c].values) value += offsets[c];
    }
    objects.numbers[names[c]] = std::move(columns[c].values);
    objects.bytes[objects::StatusName(names[c])] =
        StatusesOf(chunks.statuses, c, columns.size(), rows);
  }
  // the times follow from the stretches; only their number counts
  objects.numbers[objects::kTimes].resize(rows);
  return ReadExportedTrial(objects, FileKind::kWav);
}

}  // namespace

Result<Recording> ParseWav(std::string_view bytes, const std::string& name,
                           const ImportOptions& options) {
  const Chunks chunks = ChunksOf(bytes);
  const auto format = FormatOf(chunks.format);
  if (!format) {
    return CannotAnswer(name, "is a WAV file that holds neither PCM of 8 to 32 bits nor floats",
                        kRemedy);
  }
  if (chunks.samples.size() / format->bytes > kMostNumbers) {
    return CannotAnswer(name, "is a WAV file that is too long to be read", "save a part of it");
  }
  std::vector<NumberColumn> columns = ColumnsOf(*format, chunks.samples);
  if (!chunks.description.empty()) return ReadExport(chunks, std::move(columns), name);
  MarkClipped(*format, &columns);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    columns[c].name = fmt::format("channel_{}", c + 1);
  }
  NumberTable table{.columns = std::move(columns), .rate_hz = static_cast<double>(format->rate_hz)};
  HAPTOMETER_LET(auto recording, ReadNumberTable(std::move(table), FileKind::kWav, name, options));
  // a file that was cut short; programs that write to a pipe state no length, or the largest
  const std::size_t stated_rows = chunks.stated_bytes / format->row_bytes();
  constexpr std::size_t kNoLength = 0xffff'ff00;
  if (chunks.stated_bytes < kNoLength && stated_rows > recording.record.rows) {
    recording.report.findings.Doubt(
        FindingKind::kStatedRowsDiffer,
        {{"stated_rows", stated_rows}, {"rows", recording.record.rows}});
  }
  return recording;
}

}  // namespace haptometer::trial
