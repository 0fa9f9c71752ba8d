#include "tools/session/decisions.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "tools/session/attempt.h"

namespace haptometer::tools {
namespace {

// the attempt that is meant: the last, or that of a file
Result<SessionAttempt> AttemptOf(const SessionFolder& session, const std::string& file) {
  if (file.empty()) {
    HAPTOMETER_TRY(ChooseLast(session));
    return *session.state().LastFinished();
  }
  // a path has to be that of a trial of this session
  const std::string name = file.substr(file.rfind('/') + 1);
  std::error_code error;
  if (name != file && !std::filesystem::equivalent(file, session.trials() + name, error)) {
    return Usage(file, "is no file in " + session.trials(), "give the name of one of its trials");
  }
  const SessionAttempt* found = session.state().Find(name);
  if (found != nullptr && found->verdict) return *found;
  return Usage(file, "is not a finished attempt of the session",
               "see session status --all for its files");
}

// a text of the user's own, which is kept
Result<void> CheckText(const std::string& option, const std::string& text,
                       const std::string& example) {
  HAPTOMETER_TRY(CheckPrintable(option, text));
  if (text.find_first_not_of(' ') != std::string::npos) return {};
  return Usage(option, "is missing", fmt::format("write, for example, {} '{}'", option, example));
}

Result<void> CheckReason(const std::string& reason) {
  return CheckText("--reason", reason, "finger slipped");
}

SessionLogLine LineOf(const SessionAttempt& attempt, SessionEvent event, std::string reason) {
  return {.utc = {},
          .event = event,
          .cell = attempt.cell,
          .attempt = attempt.number,
          .file = attempt.file,
          .verdict = {},
          .reason = std::move(reason)};
}

}  // namespace

Result<SessionCell> ChooseNext(const SessionFolder& session) {
  const auto next = session.Counts().next;
  if (next) return *next;
  return CannotAnswer(session.folder(), "is done: every cell is GOOD or CHECK",
                      "record one again with session redo");
}

Result<SessionCell> ChooseLast(const SessionFolder& session, const std::string& file) {
  if (!file.empty()) {
    HAPTOMETER_LET(const auto attempt, AttemptOf(session, file));
    return attempt.cell;
  }
  const SessionAttempt* last = session.state().LastFinished();
  if (last != nullptr) return last->cell;
  return CannotAnswer(session.folder(), "has no finished attempt", "record with session next");
}

Result<SessionCell> ChooseFloor(const SessionFolder& session) {
  const auto next = session.Counts().next;
  const SessionAttempt* last = session.state().LastFinished();
  const std::string& subject = next   ? next->subject
                               : last ? last->cell.subject
                                      : session.plan().subjects.front();
  return SessionCell{.subject = subject, .condition = "", .repeat = 1};
}

namespace {

// the verdict of an attempt now, and whether its cell counts by it
std::string StandingOf(const SessionFolder& session, const std::string& file) {
  const SessionAttempt& attempt = *session.state().Find(file);
  const SessionAttempt& counting = *session.state().Latest(attempt.cell);
  const bool is_good = *attempt.verdict == SessionVerdict::kGood;
  return fmt::format(
      "{}{}, {}", Name(*attempt.verdict), is_good ? "" : fmt::format(" ({})", attempt.Reasons()),
      counting.file == file ? "and counts" : "but a later attempt counts: " + counting.file);
}

// the line of a decision on a finished attempt, and its trials
Result<void> Write(SessionFolder& session, const SessionAttempt& attempt, SessionEvent event,
                   const std::string& reason) {
  HAPTOMETER_TRY(session.Append(LineOf(attempt, event, reason)));
  return session.Settle(attempt.cell);
}

}  // namespace

Result<std::string> Reject(SessionFolder& session, const Decision& decision) {
  HAPTOMETER_TRY(CheckReason(decision.reason));
  HAPTOMETER_LET(const auto attempt, AttemptOf(session, decision.file));
  HAPTOMETER_TRY(Write(session, attempt, SessionEvent::kReject, decision.reason));
  return fmt::format("rejected: {}, attempt {}, {}", NameOf(attempt.cell), attempt.number,
                     attempt.file);
}

Result<std::string> Accept(SessionFolder& session, const Decision& decision) {
  HAPTOMETER_TRY(CheckReason(decision.reason));
  HAPTOMETER_LET(const auto attempt, AttemptOf(session, decision.file));
  if (attempt.rejections.empty()) {
    if (attempt.judged == SessionVerdict::kBad) {
      return Usage(attempt.file, "is BAD, and not by a rejection: " + attempt.reason,
                   "record the cell again with session redo");
    }
    if (session.state().Latest(attempt.cell)->file == attempt.file) {
      return Usage(attempt.file, "is not rejected and counts; unchanged");
    }
  }
  HAPTOMETER_TRY(Write(session, attempt, SessionEvent::kAccept, decision.reason));
  return fmt::format(
      "accepted: {}, attempt {}, {}: {}{}", NameOf(attempt.cell), attempt.number, attempt.file,
      StandingOf(session, attempt.file),
      session.IsUsable(attempt) ? "" : "; studies leave it out until trial include includes it");
}

namespace {

// a cell of the plan; a floor of its subjects too where none is planned
Result<void> CheckCell(const SessionFolder& session, const SessionCell& cell) {
  const auto& subjects = session.plan().subjects;
  const bool is_planned = cell.is_floor() ? std::ranges::count(subjects, cell.subject) > 0
                                          : std::ranges::count(session.cells(), cell) > 0;
  if (is_planned) return {};
  return Usage(NameOf(cell), "is not in the plan", "see subjects and conditions in session.toml");
}

}  // namespace

// the new cell is one of the plan; what is not given stays
Result<std::string> Relabel(SessionFolder& session, const Decision& decision,
                            const OtherCell& other) {
  HAPTOMETER_TRY(CheckReason(decision.reason));
  HAPTOMETER_LET(const auto attempt, AttemptOf(session, decision.file));
  SessionCell cell = attempt.cell;
  if (!other.subject.empty()) cell.subject = other.subject;
  if (!other.condition.empty()) cell.condition = other.condition;
  if (cell.is_floor() != attempt.cell.is_floor() && !other.repeat && session.plan().repeats > 1) {
    return Usage("--repeat", "is missing: a floor has none", "write the repeat of the cell");
  }
  cell.repeat = other.repeat.value_or(cell.repeat);
  if (other.is_floor) cell = {.subject = cell.subject, .condition = "", .repeat = 1};
  HAPTOMETER_TRY(CheckCell(session, cell));
  if (cell == attempt.cell) return Usage(attempt.file, "is of this cell already");
  HAPTOMETER_LET(const auto judged, JudgeAs(session, attempt, cell));
  SessionLogLine line = LineOf(attempt, SessionEvent::kRelabel, decision.reason);
  line.cell = cell;
  line.attempt = session.state().NextNumber(cell);
  line.verdict = judged.attempt.verdict;
  line.band_rms_m = judged.band_rms_m;
  for (const std::string& reason : judged.reasons) {
    if (!reason.empty()) line.reason += "; " + reason;
  }
  HAPTOMETER_TRY(session.Append(line));
  HAPTOMETER_TRY(session.Settle(cell));
  HAPTOMETER_TRY(session.Settle(attempt.cell));
  return fmt::format("{}: {} is now {}: {}", attempt.file, NameOf(attempt.cell), NameOf(cell),
                     StandingOf(session, attempt.file));
}

Result<std::string> Note(SessionFolder& session, const std::string& file, const std::string& text) {
  HAPTOMETER_TRY(CheckText("--text", text, "cold finger"));
  const auto next = session.Counts().next;
  SessionAttempt of{.cell = next.value_or(SessionCell{}), .number = 0};
  if (!file.empty() || session.state().LastFinished() != nullptr || !next) {
    HAPTOMETER_LET(of, AttemptOf(session, file));
  }
  HAPTOMETER_TRY(session.Append(LineOf(of, SessionEvent::kNote, text)));
  return fmt::format("of {}{}{}", NameOf(of.cell), of.file.empty() ? "" : ", ", of.file);
}

Result<std::string> Skip(SessionFolder& session, const std::string& reason) {
  HAPTOMETER_TRY(CheckReason(reason));
  HAPTOMETER_LET(const auto cell, ChooseNext(session));
  HAPTOMETER_TRY(session.Append(LineOf({.cell = cell, .number = 0}, SessionEvent::kSkip, reason)));
  return fmt::format("skipped: {}", NameOf(cell));
}

}  // namespace haptometer::tools
