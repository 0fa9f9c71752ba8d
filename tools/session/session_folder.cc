#include "tools/session/session_folder.h"

#include <fmt/core.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/clock.h"
#include "base/input_file.h"
#include "base/text.h"
#include "tools/cli/output_file.h"
#include "trial/block.h"
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

std::string ReasonOf(const SessionAttempt& attempt, bool counts) {
  if (attempt.cell.is_floor()) return std::string(kFloorReason);
  if (!attempt.verdict) return std::string(kInterruptedReason);
  const std::string later = counts ? "" : "a later attempt counts";
  if (*attempt.verdict != SessionVerdict::kBad)
    return counts ? "" : std::string(kSessionReason) + later;
  return fmt::format("{}{}: {}{}{}", kSessionReason, attempt.is_rejected ? "rejected" : "BAD",
                     attempt.reason, counts ? "" : "; ", later);
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
  fs::create_directories(fs::path(folder) / "trials", error);
  if (error) return Failed(folder, "cannot be made: " + error.message(), "name another folder");
  {
    HAPTOMETER_LET(const auto log,
                   trial::CreateFileSink(LogPath(folder), trial::IfExists::kRefuse));
    HAPTOMETER_TRY(WriteDurably(*log, kSessionLogHeader, LogPath(folder)));
  }
  // last, because it makes the folder a session
  return cli::WriteOutput(PlanPath(folder), kPlanOutput, false, TomlOf(plan));
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
  if (!session.state_.attempts.empty()) {
    HAPTOMETER_TRY(session.Settle(session.state_.attempts.back().cell));
  }
  return session;
}

Result<void> SessionFolder::Append(SessionLogLine line) {
  HAPTOMETER_CHECK(log_ != nullptr, "the session was opened to read");
  line.utc = UtcNow();
  // behind a line that was torn, a line end first; the torn one stays as it is
  const std::string text = (ends_in_line_ ? "" : "\n") + TextOf(line);
  HAPTOMETER_TRY(WriteDurably(*log_, text, LogPath(folder_)));
  return ReadState();
}

Result<void> SessionFolder::Settle(const SessionCell& cell) const {
  const SessionAttempt* latest = state_.Latest(cell);
  for (const SessionAttempt& attempt : state_.attempts) {
    if (attempt.cell == cell) HAPTOMETER_TRY(SettleTrial(attempt, &attempt == latest));
  }
  return {};
}

Result<void> SessionFolder::SettleTrial(const SessionAttempt& attempt, bool counts) const {
  const std::string path = trials() + attempt.file;
  std::error_code error;
  // an attempt that was killed before its first byte has no file
  if (!fs::exists(path, error)) return {};
  const auto read = trial::ReadRecord(path);
  // and one killed in its header, or damaged since, has nothing that a study would read
  ForgetInput(path);
  if (!read) return {};
  const trial::Metadata& metadata = read->record.metadata;
  for (const auto& [key, value] : LabelsOf(attempt.cell)) {
    const auto found = metadata.labels.find(key);
    if (found != metadata.labels.end() && found->second == value) continue;
    HAPTOMETER_TRY(trial::AppendEvent(path, {.kind = trial::EventKind::kLabels,
                                             .text = "session: relabelled",
                                             .labels = LabelsOf(attempt.cell)}));
    break;
  }
  const std::string wanted = ReasonOf(attempt, counts);
  const std::string present = trial::ExclusionOf(metadata).value_or("");
  // what the user excluded stays excluded
  const bool is_users = !present.empty() && !present.starts_with(kSessionReason);
  if (is_users || present == wanted) return {};
  if (!wanted.empty()) {
    return trial::AppendEvent(path, {.kind = trial::EventKind::kExcluded, .text = wanted});
  }
  return trial::AppendEvent(path, {.kind = trial::EventKind::kIncluded,
                                   .text = fmt::format("{}it counts", kSessionReason)});
}

}  // namespace haptometer::tools
