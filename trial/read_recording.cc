#include "trial/read_recording.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "base/input_file.h"
#include "base/printable.h"
#include "trial/block.h"
#include "trial/import/csv.h"
#include "trial/import/hdf5.h"
#include "trial/import/lvm.h"
#include "trial/metadata_texts.h"

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

bool IsHdf5(std::span<const std::byte> start) {
  constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";
  return start.size() >= kSignature.size() &&
         std::ranges::equal(start.first(kSignature.size()), BytesOfText(kSignature));
}

// "FILE.h5/NAME": a trial in an HDF5 file, the file and the name
std::pair<std::string, std::string> SplitTrialName(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  if (!std::filesystem::is_regular_file(parent, ignored)) return {path, ""};
  return {parent.string(), std::filesystem::path(path).filename().string()};
}

Result<Recording> ReadTextRecording(const std::string& path, const ImportOptions& options) {
  const auto text = ReadInputFile(path);
  if (!text) return std::unexpected(text.error());
  Recording recording;
  const bool is_lvm = IsLvm(*text);
  auto record =
      is_lvm ? ParseLvm(*text, path) : ParseCsv(*text, path, options, &recording.report.remarks);
  if (!record) return std::unexpected(record.error());
  const bool is_told = !options.columns.empty() || options.rate_hz || options.scale_m ||
                       options.scale_v || options.format || options.segment ||
                       !options.channel.empty();
  if (is_lvm && is_told) {
    recording.report.remarks.emplace_back(
        "a LabVIEW measurement names its columns and times itself; what the command line says of "
        "tables is passed over");
  }
  recording.report.kind = is_lvm ? FileKind::kLvm : FileKind::kCsv;
  recording.report.closed = true;
  recording.report.rows = recording.report.next_row = record->rows;
  recording.record = std::move(*record);
  return recording;
}

// Names, units, labels and notes of a foreign file, which anybody may have written: made printable
// here, so that nothing behind this place meets a control character.
void MakePrintable(Recording* recording) {
  for (Channel& channel : recording->record.channels) {
    channel.name = Printable(channel.name);
    channel.unit = Printable(channel.unit);
  }
  Metadata& metadata = recording->record.metadata;
  for (const auto& [key, member] : kMetadataTexts) {
    metadata.*member = Printable(metadata.*member);
  }
  for (auto* texts : {&metadata.labels, &metadata.fields}) {
    std::map<std::string, std::string> printable;
    for (const auto& [key, value] : *texts) printable[Printable(key)] = Printable(value);
    *texts = std::move(printable);
  }
  for (std::string& note : metadata.notes) note = Printable(note);
  for (std::string& remark : recording->report.remarks) remark = Printable(remark);
}

}  // namespace

Result<Recording> ReadRecording(const std::string& whole_path, const ImportOptions& options) {
  const auto [path, name] = SplitTrialName(whole_path);
  auto source = OpenFileSource(path);
  if (!source) return std::unexpected(source.error());
  std::array<std::byte, 512> bytes;
  const auto got = (*source)->ReadAt(0, bytes);
  if (!got) return std::unexpected(got.error());
  const std::span<const std::byte> start = std::span(bytes).first(*got);
  const std::uint64_t file_bytes = (*source)->size();
  Result<Recording> recording;
  if (IsHdf5(start)) {
    recording = ReadHdf5(path, name);
  } else if (!name.empty()) {
    return CannotAnswer(whole_path, "lies in a file that holds one recording", "name the file");
  } else if (*got > 0 && !IsText(start)) {
    recording = ReadRecordFrom(std::move(*source), path);
    if (!recording && recording.error().remedy == kGiveATrial) {
      recording.error().remedy += ", or a CSV whose header line begins with time_s";
    }
  } else {
    recording = ReadTextRecording(path, options);
  }
  if (!recording) return recording;
  MakePrintable(&*recording);
  recording->report.file_bytes = file_bytes;
  return recording;
}

}  // namespace haptometer::trial
