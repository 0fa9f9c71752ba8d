#include "trial/read_recording.h"

#include <algorithm>
#include <array>
#include <utility>

#include "trial/import/csv.h"

namespace haptometer::trial {
namespace {

// whether these first bytes can be text: no control characters but tabs and line ends. UTF-16
// counts as text, because the CSV reader knows what to say about it.
bool IsText(std::span<const std::byte> start) {
  const auto first = std::to_integer<unsigned>(start[0]);
  if (start.size() >= 2 && (first == 0xff || first == 0xfe)) {
    return first + std::to_integer<unsigned>(start[1]) == 0xff + 0xfe;
  }
  return std::ranges::none_of(start, [](std::byte b) {
    const auto c = std::to_integer<unsigned>(b);
    return (c < 0x20 && c != '\t' && c != '\r' && c != '\n') || c == 0x7f;
  });
}

}  // namespace

Result<Recording> ReadRecording(const std::string& path) {
  auto source = OpenFileSource(path);
  if (!source) return std::unexpected(source.error());
  std::array<std::byte, 512> start;
  const auto got = (*source)->ReadAt(0, start);
  if (!got) return std::unexpected(got.error());
  const bool is_text = *got == 0 || IsText(std::span(start).first(*got));
  if (!is_text) {
    auto recording = ReadRecordFrom(std::move(*source), path);
    if (!recording && recording.error().remedy == kGiveATrial) {
      recording.error().remedy += ", or a CSV whose header line begins with time_s";
    }
    return recording;
  }
  auto record = ReadCsv(path);
  if (!record) return std::unexpected(record.error());
  Recording recording;
  recording.report.closed = true;
  recording.report.rows = record->rows;
  recording.report.next_row = record->rows;
  recording.report.file_bytes = (*source)->size();
  recording.record = std::move(*record);
  return recording;
}

}  // namespace haptometer::trial
