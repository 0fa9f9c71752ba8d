#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/finding.h"
#include "tools/document/document.h"
#include "tools/session/session_log.h"
#include "tools/session/session_plan.h"
#include "trial/byte_io.h"

namespace haptometer::tools {

/// Where the files of a session differ from its log; those without a remark are of a file.
enum class FolderFinding : std::uint8_t {
  kLogDamaged,        ///< lines, line: the first; of the log
  kExcludedByUser,    ///< reason: by `trial exclude`; a study does not use it
  kOtherExclusion,    ///< in_trial, in_log: whether it is excluded, in words
  kOtherLabels,       ///< label, in_trial, in_log: by `trial label`
  kFileMissing,       ///< a finished attempt has no file, or none that can be read
  kFileDamaged,       ///< what: of the file of a finished attempt is lost
  kUnknownFile,       ///< in the folder trials, and not in the log
  kUnfinishedHeader,  ///< NAME.new: its attempt was killed before its header was written
};

/// The words of a kind.
[[nodiscard]] document::Sentence SentenceOf(FolderFinding kind);

/// Whether a trial is not there as it was recorded: kFileMissing and kFileDamaged.
[[nodiscard]] inline bool IsOfLostTrial(FolderFinding kind) {
  return kind == FolderFinding::kFileMissing || kind == FolderFinding::kFileDamaged;
}

/// The files of a session: session.toml (the plan), log.csv (the state) and the folder trials.
///
/// The log is append-only. A line is handed to the disk before the next step is taken, so the state
/// survives the end of the process at any moment. Nothing is deleted or written over.
class SessionFolder {
 public:
  /// Makes the folder and its files, session.toml last. Errors: Cause::kUsage where the folder
  /// holds something; Cause::kFailed where it cannot be made.
  [[nodiscard]] static Result<void> Create(const std::string& folder, const SessionPlan& plan);

  /// Reads plan and log. Errors: Cause::kCannotAnswer where it is no session; as ParsePlan.
  [[nodiscard]] static Result<SessionFolder> Read(const std::string& folder);

  /// The same for a command that records or changes something, one at a time: the log stays locked
  /// (flock) as long as the object lives, and what the last attempt's cell lacks is made up for
  /// (Settle). Errors: Cause::kFailed where another process has it, with that one's number.
  [[nodiscard]] static Result<SessionFolder> Open(const std::string& folder);

  [[nodiscard]] const std::string& folder() const { return folder_; }
  [[nodiscard]] const SessionPlan& plan() const { return plan_; }
  [[nodiscard]] const std::vector<SessionCell>& cells() const { return cells_; }
  [[nodiscard]] const SessionState& state() const { return state_; }
  [[nodiscard]] SessionCounts Counts() const { return CountCells(cells_, state_); }
  [[nodiscard]] std::string plan_path() const;
  [[nodiscard]] std::string trials() const;  ///< the folder, with a '/' at its end

  /// Whether a process records the attempt at this moment.
  [[nodiscard]] bool IsRunning(const SessionAttempt& attempt) const;

  /// Appends a line, which gets the time, and syncs it; state() follows. Errors (Cause::kFailed):
  /// the disk is full or the log was cut.
  [[nodiscard]] Result<void> Append(SessionLogLine line);

  /// Why the log excludes the attempt from studies, beginning with kSessionReason; empty where it
  /// is the one that counts, and GOOD or CHECK.
  [[nodiscard]] std::string ExclusionOf(const SessionAttempt& attempt) const;

  /// Whether the attempt's trial can be read, and is not excluded by hand. Cost: reads it.
  [[nodiscard]] bool IsUsable(const SessionAttempt& attempt) const;

  /// Brings the trials of a cell in agreement with the log: labels, and ExclusionOf(). An exclusion
  /// by the user stays. Events are appended to trials that lack them. Errors: as
  /// trial::AppendEvent.
  [[nodiscard]] Result<void> Settle(const SessionCell& cell) const;

  /// What is wrong with log.csv, in words; empty where nothing is.
  [[nodiscard]] std::string DamageInWords() const;

  /// Where the folder differs from the log, in the order of the attempts. A file that is missing or
  /// damaged is a doubt where the attempt counts for its cell, else a note. Cost: reads the trials.
  [[nodiscard]] Findings<FolderFinding> CompareWithLog() const;

  /// Counts() without the trials that `found`, of CompareWithLog(), names missing or damaged.
  [[nodiscard]] SessionCounts CountsWithout(const Findings<FolderFinding>& found) const;

  /// The trials that the log counts, GOOD or CHECK, and that are not in the folder.
  [[nodiscard]] std::vector<std::string> MissingTrials() const;

 private:
  [[nodiscard]] bool IsCounting(const SessionAttempt& attempt) const;
  [[nodiscard]] Result<void> SettleTrial(const SessionAttempt& attempt) const;
  void CompareTrial(const SessionAttempt& attempt, Findings<FolderFinding>& findings) const;
  void FindStrangers(Findings<FolderFinding>& findings) const;
  [[nodiscard]] Result<void> ReadState();

  std::string folder_;
  SessionPlan plan_;
  std::vector<SessionCell> cells_;
  SessionState state_;
  bool ends_in_line_ = true;              // the log's last byte is a line end
  std::unique_ptr<trial::ByteSink> log_;  // locked; nullptr: read only
};

/// What the reason of an attempt without a file ends with, as of an import that cannot be read.
inline constexpr std::string_view kNoTrial = "no trial was written";

/// What the reasons of exclusions by a session begin with.
inline constexpr std::string_view kSessionReason = "session: ";
/// The reasons that a trial's header has from the beginning: of a floor, and of every other trial,
/// which is included when its attempt has ended. A killed attempt is so in no study.
inline constexpr std::string_view kFloorReason = "session: floor, drive off";
inline constexpr std::string_view kInterruptedReason = "session: interrupted";

/// SessionFolder::ExclusionOf() of a file in the folder trials of a session; empty of any other.
[[nodiscard]] std::string ExclusionBySession(const std::string& path);

/// The labels of a cell's trials: subject, condition and repeat; of a floor the subject.
[[nodiscard]] std::map<std::string, std::string> LabelsOf(const SessionCell& cell);

}  // namespace haptometer::tools
