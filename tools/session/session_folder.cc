#include "tools/session/session_folder.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/clock.h"
#include "base/input_file.h"
#include "base/text.h"
#include "base/toml.h"
#include "tools/cli/output_file.h"
#include "trial/block.h"
#include "trial/import/read_recording.h"
#include "trial/trial_reader.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr cli::OutputKind kPlanOutput{.name = "the plan of a session",
                                      .begin = "# a session of haptometer"};

std::string PlanPath(const std::string& folder) { return fs::path(folder) / "session.toml"; }
std::string LogPath(const std::string& folder) { return fs::path(folder) / "log.csv"; }

// all of `text`, or nothing of it, and on the disk
Result<void> WriteDurably(trial::ByteSink& sink, std::string_view text, const std::string& path) {
  auto done = trial::WriteAll(&sink, std::as_bytes(std::span(text)));
  if (!done) {
    sink.CutToKept();
    return Failed(path, "could not be written: " + done.error().what,
                  "make room and repeat the command");
  }
  sink.Keep();
  done = sink.Sync();
  if (done) return {};
  return Failed(path, "could not be written: " + done.error().what, "check the disk");
}

// the process that holds the lock of `path`, as "process 1234 (haptometer session run day1)";
// nothing where the system does not state it, as on a network file system
std::string HolderOf(const std::string& path) {
  struct stat status{};
  if (stat(path.c_str(), &status) != 0) return {};
  // a line is "1: FLOCK ADVISORY WRITE 1234 08:01:5678 0 EOF": of a process, device and inode
  const std::string inode = fmt::format(":{}", status.st_ino);
  std::ifstream locks("/proc/locks");
  std::string number, kind, is_advisory, mode, process, place;
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    words >> number >> kind >> is_advisory >> mode >> process >> place;
    if (kind != "FLOCK" || !place.ends_with(inode)) continue;
    std::ifstream command(fmt::format("/proc/{}/cmdline", process));
    std::string text{std::istreambuf_iterator<char>(command), {}};
    // words end with a zero each
    while (text.ends_with('\0')) text.pop_back();
    std::ranges::replace(text, '\0', ' ');
    return fmt::format("process {} ({})", process, Printable(text));
  }
  return {};
}

}  // namespace

std::map<std::string, std::string> LabelsOf(const SessionCell& cell) {
  std::map<std::string, std::string> labels{{"subject", cell.subject}};
  if (cell.is_floor()) return labels;
  labels["condition"] = cell.condition;
  labels["repeat"] = std::to_string(cell.repeat);
  return labels;
}

std::string SessionFolder::plan_path() const { return PlanPath(folder_); }
std::string SessionFolder::trials() const { return (fs::path(folder_) / "trials").string() + "/"; }

bool SessionFolder::IsRunning(const SessionAttempt& attempt) const {
  // a trial is locked by who writes it
  return !attempt.verdict && !HolderOf(trials() + attempt.file).empty();
}

Result<void> SessionFolder::Create(const std::string& folder, const SessionPlan& plan) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(folder, error)) &&
      (!fs::is_directory(folder, error) || !fs::is_empty(folder, error))) {
    return Usage(folder, "exists and is not an empty folder", "name a new one");
  }
  const std::string text = TomlOf(plan);
  // what could be written and never read
  if (text.size() > kMostTomlBytes) {
    return CannotAnswer(
        folder,
        fmt::format("would have a plan of {} bytes, of {} at most", text.size(), kMostTomlBytes),
        "move files that are not of this session out of the watched folder");
  }
  const fs::path trials = fs::path(folder) / "trials";
  const bool is_new = fs::create_directories(trials, error);
  if (error) return Failed(folder, "cannot be made: " + error.message(), "name another folder");
  bool has_log = false;
  const auto written = [&]() -> Result<void> {
    {
      HAPTOMETER_LET(const auto log,
                     trial::CreateFileSink(LogPath(folder), trial::IfExists::kRefuse));
      has_log = true;
      HAPTOMETER_TRY(WriteDurably(*log, kSessionLogHeader, LogPath(folder)));
    }
    // last, because it makes the folder a session
    return cli::WriteOutput(PlanPath(folder), kPlanOutput, false, text);
  }();
  if (written) return written;
  // as it was, so that the command can be repeated
  if (has_log) fs::remove(LogPath(folder), error);
  if (is_new) fs::remove(trials, error);
  return written;
}

Result<void> SessionFolder::ReadState() {
  const std::string path = LogPath(folder_);
  std::error_code error;
  // an empty log is one whose header was lost
  std::string text;
  if (!fs::exists(path, error)) {
    return CannotAnswer(path, "is not there", "give the folder of a session");
  }
  if (fs::file_size(path, error) > 0) {
    HAPTOMETER_LET(text, ReadInputFile(path));
  }
  // the log grows: it is no input that a checksum could stand for
  ForgetInput(path);
  state_ = ReadLog(text);
  ends_in_line_ = text.ends_with('\n');
  return {};
}

Result<SessionFolder> SessionFolder::Read(const std::string& folder) {
  SessionFolder session;
  session.folder_ = folder;
  std::error_code error;
  if (!fs::exists(PlanPath(folder), error)) {
    return CannotAnswer(folder, "is not a session: it has no session.toml",
                        "make one with haptometer session new");
  }
  HAPTOMETER_LET(const auto text, ReadInputFile(PlanPath(folder)));
  HAPTOMETER_LET(session.plan_, ParsePlan(text, PlanPath(folder)));
  session.cells_ = CellsOf(session.plan_);
  HAPTOMETER_TRY(session.ReadState());
  return session;
}

Result<SessionFolder> SessionFolder::Open(const std::string& folder) {
  HAPTOMETER_LET(auto session, Read(folder));
  // the state is read again under the lock
  auto log = trial::OpenFileSinkAtEnd(LogPath(folder));
  if (!log) {
    Error error = log.error();
    if (error.cause == Cause::kFailed) {
      const std::string holder = HolderOf(LogPath(folder));
      error.what = "is in use by another command of this session" +
                   (holder.empty() ? holder : ": " + holder);
      error.remedy = "wait for its end; session status reads it meanwhile";
    }
    return std::unexpected(std::move(error));
  }
  session.log_ = *std::move(log);
  HAPTOMETER_TRY(session.ReadState());
  // the program may have been killed between the log and the trial
  for (const SessionCell& cell : session.state_.last_cells) HAPTOMETER_TRY(session.Settle(cell));
  return session;
}

Result<void> SessionFolder::Append(SessionLogLine line) {
  HAPTOMETER_CHECK(log_ != nullptr, "the session was opened to read");
  // an editor that keeps a backup has renamed it: lines would go there
  if (const std::string moved = log_->MovedTo(); !moved.empty()) {
    return Failed(LogPath(folder_), "was renamed to " + moved + " by another program",
                  "close that program, and repeat the command");
  }
  line.utc = UtcNow();
  // behind a line that was torn, a line end first; the torn one stays as it is
  const std::string text = (ends_in_line_ ? "" : "\n") + TextOf(line);
  HAPTOMETER_TRY(WriteDurably(*log_, text, LogPath(folder_)));
  return ReadState();
}

bool SessionFolder::IsCounting(const SessionAttempt& attempt) const {
  const SessionAttempt* latest = state_.Latest(attempt.cell);
  return latest != nullptr && latest->file == attempt.file;
}

std::string SessionFolder::ExclusionOf(const SessionAttempt& attempt) const {
  if (attempt.cell.is_floor()) return std::string(kFloorReason);
  if (!attempt.verdict) return std::string(kInterruptedReason);
  const bool counts = IsCounting(attempt);
  const std::string later = counts ? "" : "a later attempt counts";
  if (*attempt.verdict != SessionVerdict::kBad) {
    return counts ? "" : std::string(kSessionReason) + later;
  }
  return fmt::format("{}{}{}{}", kSessionReason,
                     attempt.rejections.empty()
                         ? "BAD: " + attempt.reason
                         : fmt::format("rejected: {}", fmt::join(attempt.rejections, "; ")),
                     counts ? "" : "; ", later);
}

namespace {

// by `trial exclude`, not by the session
bool IsByHand(const std::string& exclusion) {
  return !exclusion.empty() && !exclusion.starts_with(kSessionReason);
}

// a trial for one question: no input
Result<trial::OpenedRows> OpenTrial(const std::string& path) {
  auto opened = trial::OpenRows(path);
  ForgetInput(path);
  return opened;
}

// what is written in a trial; nothing where it cannot be read
std::optional<trial::Metadata> MetadataIn(const std::string& path) {
  const auto opened = OpenTrial(path);
  if (!opened) return std::nullopt;
  return opened->rows->head().metadata;
}

std::string LabelIn(const trial::Metadata& metadata, const std::string& label) {
  const auto found = metadata.labels.find(label);
  return found == metadata.labels.end() ? "" : found->second;
}

// the labels that the cell's trials have; of a floor that was a trial the others are empty
std::map<std::string, std::string> WantedLabels(const SessionCell& cell,
                                                const trial::Metadata& metadata) {
  auto wanted = LabelsOf(cell);
  for (const char* label : {"condition", "repeat"}) {
    if (!LabelIn(metadata, label).empty()) wanted.try_emplace(label);
  }
  return wanted;
}

}  // namespace

std::string ExclusionBySession(const std::string& path) {
  std::error_code error;
  const fs::path file = fs::absolute(path, error).lexically_normal();
  const std::string folder = file.parent_path().parent_path();
  if (error || file.parent_path().filename() != "trials" || !fs::exists(PlanPath(folder), error)) {
    return {};
  }
  const auto session = SessionFolder::Read(folder);
  const SessionAttempt* known = session ? session->state().Find(file.filename()) : nullptr;
  return known == nullptr ? "" : session->ExclusionOf(*known);
}

bool SessionFolder::IsUsable(const SessionAttempt& attempt) const {
  const auto metadata = MetadataIn(trials() + attempt.file);
  return metadata && !IsByHand(trial::ExclusionOf(*metadata).value_or(""));
}

Result<void> SessionFolder::Settle(const SessionCell& cell) const {
  for (const SessionAttempt& attempt : state_.attempts) {
    if (attempt.cell == cell) HAPTOMETER_TRY(SettleTrial(attempt));
  }
  return {};
}

Result<void> SessionFolder::SettleTrial(const SessionAttempt& attempt) const {
  const std::string path = trials() + attempt.file;
  std::error_code error;
  // an attempt that was killed before its first byte has no file, and one killed in its header, or
  // damaged since, has nothing that a study would read
  if (!fs::exists(path, error)) return {};
  const auto metadata = MetadataIn(path);
  if (!metadata) return {};
  const auto labels = WantedLabels(attempt.cell, *metadata);
  const bool has_labels = std::ranges::all_of(
      labels, [&](const auto& label) { return LabelIn(*metadata, label.first) == label.second; });
  if (!has_labels) {
    HAPTOMETER_TRY(trial::AppendEvent(
        path,
        {.kind = trial::EventKind::kLabels, .text = "session: relabelled", .labels = labels}));
  }
  const std::string wanted = ExclusionOf(attempt);
  const std::string present = trial::ExclusionOf(*metadata).value_or("");
  // what the user excluded stays excluded
  if (IsByHand(present) || present == wanted) return {};
  if (!wanted.empty()) {
    return trial::AppendEvent(path, {.kind = trial::EventKind::kExcluded, .text = wanted});
  }
  return trial::AppendEvent(path, {.kind = trial::EventKind::kIncluded,
                                   .text = fmt::format("{}it counts", kSessionReason)});
}

// --- comparison with the log ---

document::Sentence SentenceOf(FolderFinding kind) {
  using enum FolderFinding;
  static constexpr document::KindSentence<FolderFinding> kSentences[] = {
      {kLogDamaged, "log-damaged",
       "{lines} line{lines s} of log.csv cannot be read, the first is line {line}: what stood "
       "there "
       "is not known to the session"},
      {kExcludedByUser, "excluded-by-user", "excluded from studies by trial exclude: {reason}"},
      {kOtherExclusion, "excluded-otherwise",
       "it is {in_trial} by its header, and {in_log} by the log, which counts: session accept or "
       "session reject writes both"},
      {kOtherLabels, "labels-by-hand",
       "its {label} is '{in_trial}', and '{in_log}' in the log, which counts: set it back by trial "
       "label, or change both by session relabel"},
      {kFileMissing, "trial-missing",
       "its file is not there, or cannot be read: restore it from a copy, or record the cell again "
       "by session redo --file"},
      {kFileDamaged, "trial-damaged",
       "{what}: restore the file from a copy, or record the cell again by session redo --file"},
      {kUnknownFile, "file-unknown", "it is in the folder trials, and not in the log"},
      {kUnfinishedHeader, "header-unfinished",
       "what is left of an attempt that was killed before its header was written"},
  };
  return document::SentenceIn(kSentences, kind);
}

void SessionFolder::CompareTrial(const SessionAttempt& attempt,
                                 Findings<FolderFinding>& findings) const {
  using enum FolderFinding;
  const auto opened = OpenTrial(trials() + attempt.file);
  // what a later attempt has replaced is in no study
  const Severity severity = IsCounting(attempt) ? Severity::kDoubt : Severity::kNote;
  if (!opened) {
    if (attempt.reason.ends_with(kNoTrial)) return;
    findings.Add({severity, kFileMissing, {}, attempt.file});
    return;
  }
  if (const auto& losses = opened->report.losses; !losses.empty()) {
    const std::string what = document::WordsOf(trial::FindingOfLoss(losses.front()));
    findings.Add({severity, kFileDamaged, {{"what", what}}, attempt.file});
  }
  const trial::Metadata& metadata = opened->rows->head().metadata;
  const std::string present = trial::ExclusionOf(metadata).value_or("");
  const std::string wanted = ExclusionOf(attempt);
  const auto words = [](bool is_excluded) { return is_excluded ? "excluded" : "not excluded"; };
  if (IsByHand(present)) {
    findings.Add({Severity::kNote, kExcludedByUser, {{"reason", present}}, attempt.file});
  } else if (present.empty() != wanted.empty()) {
    findings.Add({Severity::kDoubt,
                  kOtherExclusion,
                  {{"in_trial", std::string(words(!present.empty()))},
                   {"in_log", std::string(words(!wanted.empty()))}},
                  attempt.file});
  }
  for (const auto& [label, in_log] : WantedLabels(attempt.cell, metadata)) {
    const std::string in_trial = LabelIn(metadata, label);
    if (in_trial == in_log) continue;
    findings.Add({Severity::kDoubt,
                  kOtherLabels,
                  {{"label", label}, {"in_trial", in_trial}, {"in_log", in_log}},
                  attempt.file});
  }
}

void SessionFolder::FindStrangers(Findings<FolderFinding>& findings) const {
  constexpr std::string_view kNew = ".new";
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(trials(), error), end; !error && at != end; at.increment(error)) {
    names.push_back(Printable(at->path().filename().string()));
  }
  std::ranges::sort(names);
  for (const std::string& name : names) {
    if (state_.Find(name) != nullptr) continue;
    const bool is_begun =
        name.ends_with(kNew) && state_.Find(name.substr(0, name.size() - kNew.size())) != nullptr;
    findings.Add({is_begun ? Severity::kNote : Severity::kDoubt,
                  is_begun ? FolderFinding::kUnfinishedHeader : FolderFinding::kUnknownFile,
                  {},
                  name});
  }
}

namespace {

Findings<FolderFinding> DamageOf(const SessionState& state) {
  Findings<FolderFinding> findings;
  if (state.damaged_lines > 0) {
    findings.Doubt(FolderFinding::kLogDamaged,
                   {{"lines", state.damaged_lines}, {"line", state.first_damaged}});
  }
  return findings;
}

}  // namespace

std::string SessionFolder::DamageInWords() const {
  const auto findings = DamageOf(state_);
  return findings.list().empty() ? "" : document::WordsOf(findings.list().front());
}

Findings<FolderFinding> SessionFolder::CompareWithLog() const {
  Findings<FolderFinding> findings = DamageOf(state_);
  for (const SessionAttempt& attempt : state_.attempts) {
    if (attempt.verdict) CompareTrial(attempt, findings);
  }
  FindStrangers(findings);
  return findings;
}

SessionCounts SessionFolder::CountsWithout(const Findings<FolderFinding>& found) const {
  SessionCounts counts = Counts();
  for (const FindingOf<FolderFinding>& finding : found.list()) {
    const SessionAttempt* attempt = state_.Find(finding.subject);
    const bool is_of_plan = attempt != nullptr && std::ranges::count(cells_, attempt->cell) > 0;
    if (!IsOfLostTrial(finding.kind) || !is_of_plan || !IsCounting(*attempt)) continue;
    const bool is_good = attempt->verdict == SessionVerdict::kGood;
    if (attempt->cell.is_floor()) {
      counts.floors_done -= static_cast<std::size_t>(is_good);
      continue;
    }
    // a trial that is BAD is none of those that are done
    if (attempt->verdict == SessionVerdict::kBad) continue;
    --(is_good ? counts.good : counts.check);
    --counts.done;
  }
  return counts;
}

std::vector<std::string> SessionFolder::MissingTrials() const {
  std::vector<std::string> missing;
  std::error_code error;
  for (const SessionAttempt& attempt : state_.attempts) {
    if (!ExclusionOf(attempt).empty() || fs::exists(trials() + attempt.file, error)) continue;
    missing.push_back(attempt.file);
  }
  return missing;
}

}  // namespace haptometer::tools
