// trial export: recordings as CSV, HDF5, NPY, WAV and MAT.
#include "trial/export/export.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/recording_files.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/document/document.h"
#include "tools/trial/trial.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr cli::VerbText kText{
    .name = "trial export",
    .summary = "Write recordings as CSV, HDF5, NumPy, WAV or MATLAB files, in SI units.",
    .examples = {"haptometer trial export trial.bin | head",
                 "haptometer trial export trial.bin -o trial.npy",
                 "haptometer trial export recordings/ -o all.h5"}};

enum class Format : std::uint8_t { kCsv, kHdf5, kNpy, kWav, kMat };

std::optional<Format> FormatOf(const std::string& path) {
  const std::string ending = fs::path(path).extension();
  if (ending == ".h5" || ending == ".hdf5") return Format::kHdf5;
  if (ending == ".npy") return Format::kNpy;
  if (ending == ".wav") return Format::kWav;
  if (ending == ".mat") return Format::kMat;
  if (ending == ".csv" || ending == ".txt") return Format::kCsv;
  return std::nullopt;
}

struct Wanted {
  std::vector<std::string> files;
  std::string output;
  bool overwrite = false;
  cli::ImportWords import;
};

// a folder means the recordings in it, without tables of results, in the order of their names
Result<std::vector<std::string>> FilesOf(const std::vector<std::string>& words) {
  std::vector<std::string> files;
  for (const std::string& word : words) {
    std::error_code error;
    if (!fs::is_directory(word, error)) {
      files.push_back(word);
      continue;
    }
    HAPTOMETER_LET(const auto inside, cli::RecordingsIn(word));
    for (const cli::RecordingFile& file : inside) {
      if (!file.is_table) files.push_back(file.path);
    }
  }
  return files;
}

const cli::OutputKind& KindOf(Format format) {
  constexpr std::array kKinds{&cli::kRowsOutput, &cli::kHdf5Output, &cli::kNpyOutput,
                              &cli::kWavOutput, &cli::kMatOutput};
  return *kKinds.at(static_cast<std::size_t>(format));
}

// a finding as a line of an export
std::string Say(const trial::Finding& found) { return Printable(document::WordsOf(found)); }

// formats that are a stream of bytes; WAV reports what it cannot contain
Result<void> WriteBytes(Format format, const trial::Recording& recording,
                        const trial::PieceSink& sink) {
  if (format == Format::kCsv) return trial::WriteCsv(recording.record, sink);
  if (format == Format::kNpy) return trial::WriteNpy(recording, sink, Say);
  HAPTOMETER_LET(const auto left_out, trial::WriteWav(recording, sink, Say));
  cli::Remark(kText.name, left_out);
  return {};
}

// `error` with an advice of the export where the disk failed; other errors with the input's name
Error Explained(Error error, const std::string& input, const std::string& output) {
  if (error.cause != Cause::kFailed) {
    if (error.where.empty()) error.where = input;
    return error;
  }
  return {Cause::kFailed, output, "could not be written whole: " + error.what,
          "make room and export again; the recording itself is unchanged"};
}

Result<void> ExportOne(const Wanted& wanted, Format format, const std::string& input,
                       const trial::ImportOptions& import) {
  HAPTOMETER_LET(const auto recording, ReadAndTell(kText.name, input, import));
  // without -o: CSV to standard output
  const std::string output = wanted.output.empty() ? "/dev/stdout" : wanted.output;
  HAPTOMETER_LET(auto file, cli::OutputFile::Begin(output, KindOf(format), wanted.overwrite));
  auto done =
      WriteBytes(format, recording, [&](std::string_view bytes) { return file.Write(bytes); });
  if (done) done = file.Finish();
  if (!done) return std::unexpected(Explained(done.error(), input, output));
  return {};
}

// names of groups and structs: the file's name as an identifier, unique within the export
class Names {
 public:
  std::string Of(const std::string& path) {
    std::string stem = fs::path(path).stem();
    for (char& c : stem) {
      const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
      const bool is_other = (c >= '0' && c <= '9') || c == '_';
      if (!is_letter && !is_other) c = '_';
    }
    constexpr std::size_t kMostLetters = 50;  // MATLAB takes 63
    const bool begins_well = !stem.empty() && (stem[0] < '0' || stem[0] > '9') && stem[0] != '_';
    // MATLAB names begin with a letter
    if (!begins_well) stem = "trial_" + stem;
    stem.resize(std::min(stem.size(), kMostLetters));
    std::string name = stem;
    // the second of equal names gets _2
    for (int n = 2; !taken_.insert(name).second; ++n) name = fmt::format("{}_{}", stem, n);
    return name;
  }

 private:
  std::set<std::string> taken_;
};

// a trial.bin is opened again for its raw values
Result<void> AddTo(trial::Hdf5Writer* writer, const std::string& name, const std::string& input,
                   const trial::Recording& recording) {
  if (recording.report.kind != trial::FileKind::kTrial) {
    return writer->Add(name, recording, nullptr, Say);
  }
  HAPTOMETER_LET(auto raw, trial::TrialReader::Open(input));
  return writer->Add(name, recording, &raw, Say);
}

Result<void> AddTo(trial::MatWriter* writer, const std::string& name, const std::string& /*input*/,
                   const trial::Recording& recording) {
  return writer->Add(name, recording, Say);
}

// All `inputs` into one file; an unreadable one is reported and the others are exported.
// Returns the exit status.
template <typename Writer>
Result<int> ExportAll(const Wanted& wanted, Format format, const std::vector<std::string>& inputs,
                      const trial::ImportOptions& import) {
  HAPTOMETER_LET(auto file,
                 cli::OutputFile::Begin(wanted.output, KindOf(format), wanted.overwrite));
  HAPTOMETER_LET(const auto part, file.PathForLibrary());
  auto writer = Writer::Create(part);
  if (!writer) return std::unexpected(Explained(writer.error(), "", wanted.output));
  Names names;
  int status = 0;
  std::size_t added = 0;
  for (const std::string& input : inputs) {
    const auto recording = ReadAndTell(kText.name, input, import);
    if (!recording) {
      // a single unreadable input is the error of the export itself
      if (inputs.size() == 1) return std::unexpected(recording.error());
      status = cli::WorseStatus(status, cli::ReportError(kText.name, recording.error()));
      continue;
    }
    auto done = AddTo(&*writer, names.Of(input), input, *recording);
    if (!done) return std::unexpected(Explained(done.error(), input, wanted.output));
    ++added;
  }
  // an export without trials is not written
  if (added == 0) return CannotAnswer(wanted.output, "is not written: no file could be read");
  auto done = writer->Close();
  if (done) done = file.Finish();
  if (!done) return std::unexpected(Explained(done.error(), "", wanted.output));
  return status;
}

Result<int> Export(const Wanted& wanted) {
  const auto format = wanted.output.empty() ? Format::kCsv : FormatOf(wanted.output);
  std::error_code ignored;
  // a character device (/dev/stdout) has no ending: CSV
  const bool is_device = fs::is_character_file(wanted.output, ignored);
  if (!format && !is_device) {
    return Usage(wanted.output, "has an ending that no export writes",
                 "use .csv, .h5, .npy, .wav or .mat");
  }
  HAPTOMETER_LET(const auto inputs, FilesOf(wanted.files));
  HAPTOMETER_LET(const auto import, cli::ImportOf(wanted.import, inputs));
  if (format == Format::kHdf5) return ExportAll<trial::Hdf5Writer>(wanted, *format, inputs, import);
  if (format == Format::kMat) return ExportAll<trial::MatWriter>(wanted, *format, inputs, import);
  // CSV, NumPy and WAV have no groups
  if (inputs.size() > 1) {
    return Usage("-o",
                 fmt::format("a file of this kind holds one trial, not {} ({}, {}{})",
                             inputs.size(), inputs[0], inputs[1], inputs.size() > 2 ? ", ..." : ""),
                 "give one, or write all into one .h5 or .mat");
  }
  HAPTOMETER_TRY(ExportOne(wanted, format.value_or(Format::kCsv), inputs.front(), import));
  return 0;
}

}  // namespace

int RunTrialExport(int argc, const char* const* argv) {
  Wanted wanted;
  cli::Options options(kText);
  options.Positionals(
      "files", &wanted.files,
      "trial.bin, CSV with time_s, LabVIEW .lvm, HDF5, NPY, MAT, WAV, or a folder of them");
  options.Output("-o,--output", &wanted.output, "FILE",
                 "The file to write, .csv, .h5, .npy, .wav or .mat (CSV to stdout)");
  options.Flag("--overwrite,--force", &wanted.overwrite, "Replace FILE where it exists");
  cli::DeclareImport(&options, &wanted.import);
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (options.json()) {
    return cli::ReportError(kText.name, {Cause::kUsage, "--json", "does not apply to an export",
                                         "use haptometer trial info FILE --json"});
  }
  const auto status = Export(wanted);
  // a reader that closed the pipe (head) is no error
  if (!status && wanted.output.empty() && cli::IsUnread()) return cli::kUnreadStatus;
  return status ? *status : cli::ReportError(kText.name, status.error());
}

}  // namespace haptometer::tools
