#include "tools/session/session_pack.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/input_file.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/document/render.h"
#include "tools/session/session_archive.h"
#include "tools/session/session_folder.h"
#include "tools/study/study.h"
#include "tools/study/study_document.h"
#include "trial/block.h"

// session pack and session verify: a session as one file that can be handed in. An interruption
// leaves both by cli::Interruption, which removes what is half made.

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

using document::Key;
using document::ListOf;
using document::Section;

constexpr cli::OutputKind kArchiveOutput{.name = "an archive of session pack",
                                         .begin = "PK\x03\x04"};
constexpr std::string_view kStudyFolder = "study/";
constexpr std::string_view kResults = "study/results.json";

// keys of both
constexpr Key kSession{"session_name", "session"};
constexpr Key kFiles{"packed_files", "files"};

// The working folder of the process, as long as this lives. A study of `day1` beside it names its
// trials day1/trials/..., wherever that is.
class WorkingFolder {
 public:
  explicit WorkingFolder(const fs::path& folder) : before_(fs::current_path(ignored_)) {
    fs::current_path(folder, ignored_);
  }
  ~WorkingFolder() { fs::current_path(before_, ignored_); }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  std::error_code ignored_;
  fs::path before_;
};

// --- session pack ---

// a file of the archive: of the session, or made here
struct Packed {
  PackedFile file;
  std::string path{};     // empty: made here
  std::string content{};  // of what was made here
};

// whether another program writes the file, which it has locked then
bool IsBeingWritten(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_locked = flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  return is_locked;
}

// all files of the session in the order of their names; links, devices and hidden files are left
// out
Result<std::vector<Packed>> FilesOf(const fs::path& folder, Section& root) {
  std::vector<Packed> files;
  std::error_code error;
  for (auto at = fs::recursive_directory_iterator(folder, error);
       !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    const fs::file_status status = at->symlink_status(error);
    const std::string name = at->path().lexically_relative(folder).generic_string();
    const bool is_hidden = at->path().filename().string().starts_with('.');
    if (is_hidden && fs::is_directory(status)) at.disable_recursion_pending();
    if (fs::is_directory(status) && !is_hidden) continue;
    if (is_hidden || !fs::is_regular_file(status)) {
      root.Find(Severity::kNote, "not-packed", "hidden, a link or a device: not packed", {}, name);
      continue;
    }
    if (!IsSafeName(name) || name.starts_with(kStudyFolder) || name == kPackListName) {
      return Usage(at->path(), "has a name that the archive needs, or cannot hold on every system",
                   "give it another name");
    }
    files.push_back({.file = {.name = name}, .path = at->path()});
  }
  if (error) return Failed(folder, "cannot be read: " + error.message(), "may you read it?");
  std::ranges::sort(files, {}, [](const Packed& packed) { return packed.file.name; });
  return files;
}

// trials that are not there as they were recorded; whether all are that count
bool FindLost(const SessionFolder& session, Section& root) {
  Findings<FolderFinding> lost;
  for (const FindingOf<FolderFinding>& found : session.CompareWithLog().list()) {
    if (IsOfLostTrial(found.kind)) lost.Add(found);
  }
  document::AddFindings(root, lost);
  return std::ranges::count(lost.list(), Severity::kDoubt, &FindingOf<FolderFinding>::severity) ==
         0;
}

// size and hashes of each; the log is locked by this process
Result<void> HashAll(const fs::path& folder, std::vector<Packed>& files) {
  for (Packed& packed : files) {
    packed.file.bytes = packed.content.size();
    std::error_code error;
    if (!packed.path.empty()) packed.file.bytes = fs::file_size(packed.path, error);
    if (packed.path != folder / "log.csv" && IsBeingWritten(packed.path)) {
      return Failed(packed.path, "is being written by another program", "wait for its end");
    }
    // an empty file is no source of bytes
    std::unique_ptr<trial::ByteSource> source = trial::MakeMemorySource(packed.content);
    if (packed.file.bytes > 0 && !packed.path.empty()) {
      HAPTOMETER_LET(source, trial::OpenFileSource(packed.path));
    }
    HAPTOMETER_LET(const auto hash, HashOf(*source, 0, packed.file.bytes));
    packed.file.crc32 = hash.crc32;
    packed.file.sha256 = hash.sha256;
  }
  return {};
}

// the study of the session as `study` gives it: results, report, tables and paragraph
Result<void> AddStudy(const fs::path& folder, int argc, const char* const* argv,
                      std::vector<Packed>& files, Section& root) {
  const WorkingFolder in(folder.parent_path());
  const auto study = AnswerStudy({.source = folder.filename()});
  if (!study) {
    root.Find(Severity::kNote, "no-study", "without results of a study: {reason}",
              {{"reason", study.error().Text()}});
    return {};
  }
  document::Document document = StudyDocument(*study, true);
  document.provenance = document::ProvenanceOf(kSessionPackText.name, argc, argv);
  HAPTOMETER_LET(auto report, document::HtmlOf(document));
  const auto add = [&](std::string name, std::string content) {
    files.push_back({.file = {.name = std::move(name)}, .content = std::move(content)});
  };
  add(std::string(kResults), document::JsonOf(document));
  add("study/report.html", cli::Marked(std::move(report)));
  add("study/long.csv", document::CsvOf(LongTable(*study), document.provenance));
  add("study/wide.csv", document::CsvOf(WideTable(*study), document.provenance));
  add("study/methods.md", MethodsText(*study, document.provenance));
  const std::size_t answered = study->CountAnswered([](const StudyTrial&) { return true; });
  root.Add({"study_trials", "trials of the study"}, study->table.trials.size()).note =
      fmt::format("{} with a value", answered);
  return {};
}

// the archive; its SHA-256
Result<std::string> WriteArchive(const std::string& out, const ArchiveLayout& layout,
                                 const std::vector<Packed>& files) {
  HAPTOMETER_LET(auto file, cli::OutputFile::Begin(out, kArchiveOutput, false));
  document::Sha256 sha256;
  const PieceSink put = [&](std::string_view bytes) -> Result<void> {
    sha256.Add(bytes);
    return file.Write(bytes);
  };
  HAPTOMETER_TRY(put(layout.parts[0].header + layout.list));
  for (std::size_t k = 0; k < files.size(); ++k) {
    const Packed& packed = files[k];
    HAPTOMETER_TRY(put(layout.parts[k + 1].header));
    if (packed.path.empty()) HAPTOMETER_TRY(put(packed.content));
    if (packed.path.empty() || packed.file.bytes == 0) continue;
    HAPTOMETER_LET(const auto source, trial::OpenFileSource(packed.path));
    HAPTOMETER_LET(const auto hash, HashOf(*source, 0, packed.file.bytes, put));
    if (hash.sha256 == packed.file.sha256 && source->size() == packed.file.bytes) continue;
    return Failed(packed.path, "was changed while it was packed", "repeat the command");
  }
  HAPTOMETER_TRY(put(layout.directory));
  HAPTOMETER_TRY(file.Finish());
  return sha256.Hex();
}

// a new file beside the folder
Result<void> CheckTarget(const std::string& out, const fs::path& folder) {
  if (out.empty()) return Usage("-o", "is missing", "name the archive: -o day1.zip");
  std::error_code error;
  if (fs::is_regular_file(out, error)) {
    return Usage(out, "already exists", "name another file: an archive is never replaced");
  }
  const fs::path whole = fs::weakly_canonical(fs::absolute(out, error), error);
  if (error) return Usage(out, "cannot be a file: " + error.message(), "name another file");
  const std::string inside = whole.lexically_relative(folder);
  if (!inside.empty() && !inside.starts_with("..")) {
    return Usage(out, "lies in the folder that is packed", "name a file beside it");
  }
  return cli::CheckOutput(out, kArchiveOutput, false);
}

Result<int> Pack(const std::string& name, const std::string& out, const document::Outputs& outputs,
                 int argc, const char* const* argv) {
  std::error_code error;
  const fs::path folder = fs::canonical(name, error);
  HAPTOMETER_TRY(CheckTarget(out, folder));
  // as long as it is open nothing of the session records
  HAPTOMETER_LET(const auto session, SessionFolder::Open(name));
  document::Document document{.verb = std::string(kSessionPackText.name), .title = out};
  Section& root = document.root;
  PackList list{
      .version = HAPTOMETER_VERSION, .session = folder.filename(), .utc = UtcNow(), .files = {}};
  if (!IsSafeName(list.session)) {
    return Usage(folder, "has a name that an archive cannot hold on every system", "rename it");
  }
  root.Add(kSession, list.session);
  const bool is_whole = FindLost(session, root);
  HAPTOMETER_LET(auto files, FilesOf(folder, root));
  HAPTOMETER_TRY(AddStudy(folder, argc, argv, files, root));
  HAPTOMETER_TRY(HashAll(folder, files));
  for (const Packed& packed : files) list.files.push_back(packed.file);
  const ArchiveLayout layout = LayoutOf(list);
  if (layout.bytes() > kMostArchiveBytes || files.size() >= kMostPackedFiles) {
    return Usage(folder, "holds more than 4 GiB or 65 533 files, which an archive cannot",
                 "record the next subjects into a session of their own");
  }
  HAPTOMETER_LET(const auto sha256, WriteArchive(out, layout, files));
  root.Add(kFiles, files.size());
  root.Add({document::kBytes.name, "bytes"}, static_cast<std::int64_t>(layout.bytes()));
  root.Add({"archive_sha256", "SHA-256"}, sha256);
  // the inputs were read under names of another working folder
  ForgetInputs();
  NoteInput(session.plan_path());
  const int status = document::Present(std::move(document), outputs, argc, argv);
  return is_whole ? status : cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
}

// --- session verify ---

// A new folder for temporary files, removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code error;
    std::string name = fs::temp_directory_path(error) / "haptometer-XXXXXX";
    if (!error && mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;  // empty: it could not be made
};

bool IsOfStudy(const PackedFile& file) { return file.name.starts_with(kStudyFolder); }

// the files of the session, unchanged and of safe names, into a new folder
Result<void> Unpack(const trial::ByteSource& archive, const CheckedArchive& checked,
                    const fs::path& folder) {
  for (const PackedFile& file : checked.list.files) {
    if (IsOfStudy(file)) continue;
    const fs::path path = folder / file.name;
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    HAPTOMETER_LET(const auto sink, trial::CreateFileSink(path, trial::IfExists::kRefuse));
    const PieceSink put = [&](std::string_view piece) -> Result<void> {
      const auto done = trial::WriteAll(sink.get(), trial::BytesOfText(piece));
      if (done) return {};
      return Failed("the temporary folder", "cannot be written: " + done.error().what,
                    "make room, or name another folder by TMPDIR");
    };
    HAPTOMETER_TRY(HashOf(archive, checked.places.at(file.name), file.bytes, put));
  }
  return {};
}

// the results in the archive against those that its trials give now
Result<ResultsComparison> CompareStudy(const trial::ByteSource& archive,
                                       const CheckedArchive& checked, const std::string& where) {
  const auto results = std::ranges::find(checked.list.files, kResults, &PackedFile::name);
  std::string earlier;
  HAPTOMETER_TRY(HashOf(archive, checked.places.at(results->name), results->bytes,
                        [&](std::string_view piece) -> Result<void> {
                          earlier += piece;
                          return {};
                        }));
  const TemporaryFolder temporary;
  if (temporary.path().empty()) {
    return Failed("a temporary folder", "cannot be made", "TMPDIR names the folder for it");
  }
  HAPTOMETER_TRY(Unpack(archive, checked, temporary.path() / checked.list.session));
  const WorkingFolder in(temporary.path());
  HAPTOMETER_LET(const auto study, AnswerStudy({.source = checked.list.session}));
  return CompareResults(earlier, where + ": " + std::string(kResults), StudyDocument(study, false));
}

// why the study cannot be computed again; empty where it can
std::string_view WhyNotCompared(const CheckedArchive& checked) {
  const auto& files = checked.list.files;
  if (std::ranges::find(files, kResults, &PackedFile::name) == files.end()) {
    return "the archive holds no results of a study";
  }
  const bool is_whole = std::ranges::all_of(files, [&](const PackedFile& file) {
    return checked.places.contains(file.name) || (IsOfStudy(file) && file.name != kResults);
  });
  const bool is_one_folder =
      IsSafeName(checked.list.session) && checked.list.session.find('/') == std::string::npos;
  return is_whole && is_one_folder ? "" : "a file that it needs was changed";
}

// whether the study gives the same again, or cannot be computed
Result<bool> AddComparison(const trial::ByteSource& archive, const CheckedArchive& checked,
                           const std::string& where, Section& root) {
  const std::string_view why_not = WhyNotCompared(checked);
  Section& study = root.sections.emplace_back(Section{.name = "study_again"});
  study.Add({"recomputed"}, why_not.empty());
  ResultsComparison compared;
  if (why_not.empty()) {
    HAPTOMETER_LET(compared, CompareStudy(archive, checked, where));
    study.Add({"", "study"}, fmt::format("computed again: {} values are equal, {} differ",
                                         compared.equal, compared.differences.size()));
  } else {
    study.Add({"", "study"}, fmt::format("not computed again: {}", why_not));
  }
  study.Add({"equal"}, compared.equal);
  study.Add({"different"}, compared.differences.size());
  study.sections.push_back(ListOf({.name = "differences", .heading = "differences of the study"},
                                  compared.differences, [](const std::string& difference) {
                                    Section row;
                                    row.Add({document::kText.name, "value"}, difference);
                                    return row;
                                  }));
  return compared.differences.empty();
}

Section ChangesSection(const Findings<ArchiveFinding>& findings) {
  return ListOf({.name = "changes", .heading = "changes"}, findings.list(),
                [](const FindingOf<ArchiveFinding>& finding) {
                  Section row;
                  row.Add({"part", "part"}, document::TextOrNotKnown(finding.subject));
                  row.Add(document::kKind, SentenceOf(finding.kind).kind);
                  row.Add({document::kText.name, "change"}, document::WordsOf(finding));
                  return row;
                });
}

Result<int> Verify(const std::string& path, const document::Outputs& outputs, int argc,
                   const char* const* argv) {
  HAPTOMETER_LET(const auto archive, trial::OpenFileSource(path));
  HAPTOMETER_LET(const auto checked, CheckArchive(*archive, path));
  const PackList& list = checked.list;
  const bool is_intact = checked.findings.list().empty();
  document::Document document{
      .verb = std::string(kSessionVerifyText.name),
      .title = path + (is_intact ? ": as it was packed" : ": not as it was packed")};
  Section& root = document.root;
  root.Add({"intact"}, is_intact);
  root.Add(kSession, list.session);
  root.Add({"packed_utc", "packed"}, list.utc).note = "by haptometer " + list.version;
  root.Add({"packed_by_version"}, list.version);
  root.Add(kFiles, list.files.size());
  root.Add({"unchanged", "of which unchanged"}, checked.places.size());
  root.sections.push_back(ChangesSection(checked.findings));
  HAPTOMETER_LET(const bool is_same, AddComparison(*archive, checked, path, root));
  // what was unpacked is no input
  ForgetInputs();
  NoteInput(path);
  const int status = document::Present(std::move(document), outputs, argc, argv);
  return is_intact && is_same ? status : cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
}

}  // namespace

int RunSessionPack(int argc, const char* const* argv) {
  std::string folder;
  std::string out;
  document::Outputs outputs;
  cli::Options options(kSessionPackText);
  options.Positional("folder", &folder, "Folder of the session");
  options.Output("-o,--output", &out, "FILE.zip", "The new archive, beside the folder");
  return document::RunVerb(kSessionPackText.name, options, outputs, argc, argv, [&]() {
    cli::CatchInterrupts();
    return Pack(folder, out, outputs, argc, argv);
  });
}

int RunSessionVerify(int argc, const char* const* argv) {
  std::string path;
  document::Outputs outputs;
  cli::Options options(kSessionVerifyText);
  options.Positional("archive", &path, "The archive (.zip) that session pack wrote");
  return document::RunVerb(kSessionVerifyText.name, options, outputs, argc, argv, [&]() {
    cli::CatchInterrupts();
    return Verify(path, outputs, argc, argv);
  });
}

}  // namespace haptometer::tools
