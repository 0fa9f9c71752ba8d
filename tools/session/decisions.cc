#include "tools/session/decisions.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/text.h"

namespace haptometer::tools {
namespace {

// the attempt that is meant: the last, or that of a file
Result<SessionAttempt> AttemptOf(const SessionFolder& session, const std::string& file) {
  if (file.empty()) {
    HAPTOMETER_TRY(ChooseLast(session));
    return *session.state().LastFinished();
  }
  const std::string name = file.substr(file.rfind('/') + 1);
  const auto& attempts = session.state().attempts;
  const auto found = std::ranges::find(attempts, name, &SessionAttempt::file);
  if (found != attempts.end() && found->verdict) return *found;
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

Result<SessionCell> ChooseLast(const SessionFolder& session) {
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

Result<std::string> Reject(SessionFolder& session, const Decision& decision) {
  HAPTOMETER_TRY(CheckReason(decision.reason));
  HAPTOMETER_LET(const auto attempt, AttemptOf(session, decision.file));
  HAPTOMETER_TRY(session.Append(LineOf(attempt, SessionEvent::kReject, decision.reason)));
  HAPTOMETER_TRY(session.Settle(attempt.cell));
  return fmt::format("rejected: {}, attempt {}, {}", NameOf(attempt.cell), attempt.number,
                     attempt.file);
}

// the new cell is one of the plan; what is not given stays
Result<std::string> Relabel(SessionFolder& session, const Decision& decision,
                            const OtherCell& other) {
  HAPTOMETER_TRY(CheckReason(decision.reason));
  HAPTOMETER_LET(const auto attempt, AttemptOf(session, decision.file));
  SessionCell cell = attempt.cell;
  if (!other.subject.empty()) cell.subject = other.subject;
  if (!other.condition.empty()) cell.condition = other.condition;
  cell.repeat = other.repeat.value_or(cell.repeat);
  if (std::ranges::count(session.cells(), cell) == 0) {
    return Usage(NameOf(cell), "is not in the plan", "see subjects and conditions in session.toml");
  }
  if (cell == attempt.cell) return Usage(attempt.file, "is of this cell already");
  SessionLogLine line = LineOf(attempt, SessionEvent::kRelabel, decision.reason);
  line.cell = cell;
  line.attempt = session.state().NextNumber(cell);
  HAPTOMETER_TRY(session.Append(line));
  HAPTOMETER_TRY(session.Settle(cell));
  HAPTOMETER_TRY(session.Settle(attempt.cell));
  return fmt::format("{}: {} is now {}", attempt.file, NameOf(attempt.cell), NameOf(cell));
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
