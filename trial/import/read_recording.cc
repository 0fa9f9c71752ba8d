#include "trial/import/read_recording.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"
#include "trial/block.h"
#include "trial/calibration.h"
#include "trial/import/readers.h"
#include "trial/import/table/table_cells.h"
#include "trial/trial_format.h"
#include "trial/trial_rows.h"

namespace haptometer::trial {
namespace {

// whether these first bytes can be text, UTF-16 included: no control characters but tabs and line
// ends
bool IsText(std::span<const std::byte> start) {
  const auto first = std::to_integer<unsigned>(start[0]);
  // byte order marks ff fe and fe ff
  if (start.size() >= 2 && (first == 0xff || first == 0xfe)) {
    return first + std::to_integer<unsigned>(start[1]) == 0xff + 0xfe;
  }
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  const bool is_utf16 = Utf16WithoutMark(text).has_value();
  return std::ranges::none_of(start, [&](std::byte b) {
    const auto c = std::to_integer<unsigned>(b);
    // the upper bytes of characters of other scripts may be any
    if (is_utf16 && c < 0x20) return false;
    return (c < 0x20 && c != '\t' && c != '\r' && c != '\n') || c == 0x7f;
  });
}

// whether `signature` stands in the file from byte `at` on
bool HasAt(std::span<const std::byte> start, std::size_t at, std::string_view signature) {
  return start.size() >= at + signature.size() &&
         std::ranges::equal(start.subspan(at, signature.size()), BytesOfText(signature));
}

// the kind of a binary file that holds columns of numbers; nothing for any other
std::optional<FileKind> KindOfColumns(std::span<const std::byte> start) {
  if (HasAt(start, 0, "\x89HDF\r\n\x1a\n")) return FileKind::kHdf5;
  if (HasAt(start, 0, "\x93NUMPY")) return FileKind::kNpy;
  if (HasAt(start, 0, "MATLAB 5.0 MAT-file")) return FileKind::kMat;
  if (HasAt(start, 0, "RIFF") && HasAt(start, 8, "WAVE")) return FileKind::kWav;
  return std::nullopt;
}

// a kind of file that is recognised and not read
struct UnreadKind {
  std::string_view signature;
  std::size_t at;  // of the signature's first byte
  const char* what;
};

// kinds that come from laboratories and spreadsheets
constexpr std::array<UnreadKind, 18> kUnreadKinds{{
    {"MATLAB 7.3 MAT-file", 0, "a MATLAB file of version 7.3; save it with -v7"},
    {"RF64", 0, "a WAV file of more than 4 GiB (RF64)"},
    {"\x89PNG", 0, "a picture (PNG)"},
    {"\xff\xd8\xff", 0, "a picture (JPEG)"},
    {"%PDF-", 0, "a PDF document"},
    {"PK\x03\x04", 0, "a ZIP archive (XLSX, NPZ, ODS, Saleae SAL and sigrok SR are such)"},
    {"\x1f\x8b", 0, "compressed by gzip"},
    {"\xd0\xcf\x11\xe0", 0, "an old Excel or Word document"},
    {"TDSm", 0, "a LabVIEW TDMS file"},
    {"<SALEAE>", 0, "a binary export of Saleae Logic"},
    {"RG01", 0, "a binary waveform of a Rigol oscilloscope"},
    {"RG03", 0, "a binary waveform of a Rigol oscilloscope"},
    {"AG10", 0, "a binary waveform of a Keysight oscilloscope"},
    {"AG01", 0, "a binary waveform of a Keysight oscilloscope"},
    {":WFM#", 2, "a binary waveform of a Tektronix oscilloscope"},
    {"WAVEDESC", 11, "a binary waveform of a LeCroy oscilloscope"},
    {"WAVEDESC", 0, "a binary waveform of a LeCroy oscilloscope"},
    {"PAR1", 0, "an Apache Parquet table"},
}};

// the first kind whose signature is at its place in the file
const UnreadKind* FindUnreadKind(std::span<const std::byte> start) {
  const auto is_it = [&](const UnreadKind& kind) { return HasAt(start, kind.at, kind.signature); };
  const auto* found = std::ranges::find_if(kUnreadKinds, is_it);
  return found == kUnreadKinds.end() ? nullptr : found;
}

// "FILE.h5/NAME": an object in a file of several, the file and the name
std::pair<std::string, std::string> SplitTrialName(const std::string& path) {
  // a path below a regular file can only be FILE.h5/NAME, where the name may be a path itself
  std::error_code ignored;
  std::filesystem::path file = path;
  while (file.has_relative_path() && !std::filesystem::exists(file, ignored)) {
    file = file.parent_path();
  }
  const bool is_below = file != path && std::filesystem::is_regular_file(file, ignored);
  if (!is_below) return {path, ""};
  const std::string found = file.string();
  return {found, path.substr(std::min(found.size() + 1, path.size()))};
}

Result<Recording> ReadColumns(FileKind kind, const std::string& path, const std::string& name,
                              const ImportOptions& options) {
  if (kind == FileKind::kHdf5) return ReadHdf5(path, name, options);
  if (!name.empty() && kind != FileKind::kMat) {
    return CannotAnswer(fmt::format("{}/{}", path, name), "lies in a file that holds one recording",
                        "name the file");
  }
  HAPTOMETER_LET(const auto bytes, ReadInputFile(path));
  if (kind == FileKind::kMat) return ParseMat(bytes, path, name, options);
  return kind == FileKind::kNpy ? ParseNpy(bytes, path, options) : ParseWav(bytes, path, options);
}

Result<Recording> ReadTextRecording(const std::string& path, const ImportOptions& options) {
  HAPTOMETER_LET(const auto text, ReadInputFile(path));
  Recording recording;
  // LabVIEW measurement files have a magic line; all other text is a table
  constexpr std::size_t kMagicBytes = 64;
  std::string begin_utf8, text_utf8;
  const bool is_lvm = IsLvm(Utf8Text(std::string_view(text).substr(0, kMagicBytes), &begin_utf8));
  HAPTOMETER_LET(auto record, is_lvm ? ParseLvm(Utf8Text(text, &text_utf8), path, options,
                                                &recording.report.findings)
                                     : ParseCsv(text, path, options, &recording.report.findings));
  recording.report.kind = is_lvm ? FileKind::kLvm : FileKind::kCsv;
  // a text file has no closing block: it is complete as it is
  recording.report.closed = true;
  recording.report.rows = recording.report.next_row = record.rows;
  recording.record = std::move(record);
  return recording;
}

// Names, units, labels and notes of a foreign file, which any program may have written, are made
// printable here: the code behind this place meets no control character.
void MakePrintable(Recording* recording) {
  for (Channel& channel : recording->record.channels) {
    channel.name = Printable(channel.name);
    channel.unit = Printable(channel.unit);
  }
  Metadata& metadata = recording->record.metadata;
  for (const auto& [key, member] : kMetadataTexts) metadata.*member = Printable(metadata.*member);
  for (auto* texts : {&metadata.labels, &metadata.fields}) {
    std::map<std::string, std::string> printable;
    for (const auto& [key, value] : *texts) printable[Printable(key)] = Printable(value);
    *texts = std::move(printable);
  }
  for (std::string& note : metadata.notes) note = Printable(note);
}

}  // namespace

Result<Recording> ReadRecording(const std::string& whole_path, const ImportOptions& options) {
  const auto [path, name] = SplitTrialName(whole_path);
  HAPTOMETER_LET(auto source, OpenFileSource(path));
  // 512 bytes are enough for all signatures
  std::array<std::byte, 512> bytes;
  HAPTOMETER_LET(const auto got, source->ReadAt(0, bytes));
  const std::span<const std::byte> start = std::span(bytes).first(got);
  const std::uint64_t file_bytes = source->size();
  // kinds with a signature of their own first, for a message that names them
  if (const UnreadKind* kind = FindUnreadKind(start)) {
    return CannotAnswer(path, fmt::format("is {}", kind->what),
                        "give the trial itself, or export its columns as a CSV whose header line "
                        "is such as time_s,displacement_m");
  }
  Result<Recording> recording;
  if (const auto kind = KindOfColumns(start)) {
    recording = ReadColumns(*kind, path, name, options);
  } else if (!name.empty()) {
    return CannotAnswer(whole_path, "lies in a file that holds one recording", "name the file");
  } else if (got > 0 && !IsText(start)) {
    recording = ReadRecordFrom(std::move(source), path);
    // the message of the trial reader, with the alternative of a table
    if (!recording && recording.error().remedy == kGiveATrial) {
      recording.error().remedy += ", or a CSV whose header line begins with time_s";
    }
  } else {
    recording = ReadTextRecording(path, options);
  }
  if (!recording) return recording;
  // as all options, of foreign tables alone
  const bool is_table =
      recording->report.kind == FileKind::kCsv || recording->report.kind == FileKind::kLvm;
  if (is_table && !options.calibration.empty()) {
    HAPTOMETER_TRY(CalibrateRecord(options.calibration, path, &recording->record,
                                   &recording->report.findings));
  }
  MakePrintable(&*recording);
  recording->report.file_bytes = file_bytes;
  return recording;
}

bool IsTable(const std::string& whole_path) {
  const std::string path = SplitTrialName(whole_path).first;
  std::error_code ignored;
  // a pipe would lose the bytes that are looked at
  if (!std::filesystem::is_regular_file(path, ignored)) return true;
  const auto source = OpenFileSource(path);
  if (!source) return true;
  std::array<std::byte, 512> bytes;
  const auto got = (*source)->ReadAt(0, bytes);
  if (!got || *got == 0) return true;
  const std::span<const std::byte> start = std::span(bytes).first(*got);
  if (!KindOfColumns(start)) return IsText(start);
  // only its objects show whether this program exported it
  const auto recording = ReadRecording(whole_path);
  return !recording || !recording->report.is_export;
}

namespace {

// a record in memory that lives as long as its rows
class OwnedRows final : public RowSource {
 public:
  explicit OwnedRows(Record record) : record_(std::move(record)), rows_(record_) {}

  [[nodiscard]] const Record& head() const override { return rows_.head(); }
  [[nodiscard]] Result<void> Read(std::size_t channel, std::size_t first, std::span<double> values,
                                  std::span<SampleStatus> statuses) const override {
    return rows_.Read(channel, first, values, statuses);
  }

 private:
  Record record_;
  RecordRows rows_;
};

}  // namespace

Result<OpenedRows> OpenRows(const std::string& path, const ImportOptions& options, int threads) {
  // what is no trial, or none that can be read by range, gets the messages of ReadRecording
  if (auto reader = TrialReader::Open(path); reader && TrialRows::CanRead(reader->header())) {
    HAPTOMETER_LET(auto rows, TrialRows::From(std::move(*reader), path, threads));
    OpenedRows opened{.rows = nullptr, .report = rows->report()};
    opened.rows = std::move(rows);
    return opened;
  }
  HAPTOMETER_LET(auto recording, ReadRecording(path, options));
  return OpenedRows{std::make_unique<OwnedRows>(std::move(recording.record)),
                    std::move(recording.report)};
}

}  // namespace haptometer::trial
