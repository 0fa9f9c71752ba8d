#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/error.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_log.h"

// What a user decides in a session; the verbs and the terminal's screen call the same functions.

namespace haptometer::tools {

/// The cell that comes next. Errors (Cause::kCannotAnswer): all cells are done.
[[nodiscard]] Result<SessionCell> ChooseNext(const SessionFolder& session);

/// The cell of the last attempt that ended, or of that of `file`. Errors (Cause::kCannotAnswer):
/// there is none; Cause::kUsage for a file of no finished attempt.
[[nodiscard]] Result<SessionCell> ChooseLast(const SessionFolder& session,
                                             const std::string& file = {});

/// The floor of the subject that comes next, or was last.
[[nodiscard]] Result<SessionCell> ChooseFloor(const SessionFolder& session);

/// A decision on a finished attempt.
struct Decision {
  std::string file{};  ///< of the attempt; empty: the last that ended
  std::string reason{};
};

/// The attempt is BAD from now on. Returns what was done, in words. Errors: as ChooseLast;
/// Cause::kUsage for a reason that is empty or not printable and for a file of no finished attempt;
/// as SessionFolder::Append.
[[nodiscard]] Result<std::string> Reject(SessionFolder& session, const Decision& decision);

/// The attempt is not rejected any more, and counts for its cell until a newer one ends. Returns
/// what was done, in words. Errors: as Reject; Cause::kUsage where nothing would change, or the
/// attempt is BAD without a rejection.
[[nodiscard]] Result<std::string> Accept(SessionFolder& session, const Decision& decision);

/// Another cell; what is empty stays as it is.
struct OtherCell {
  std::string subject{};
  std::string condition{};
  bool is_floor = false;  ///< the subject's floor
  std::optional<std::int64_t> repeat{};
};

/// The attempt is of another cell of the plan from now on, with the verdict that its file has there
/// (JudgeAs); its place in the order of recording stays. Returns what was done and which attempt
/// counts, in words. Errors: as Reject; Cause::kUsage for a cell that is not in the plan, or no
/// other.
[[nodiscard]] Result<std::string> Relabel(SessionFolder& session, const Decision& decision,
                                          const OtherCell& other);

/// Keeps `text` with the attempt, or with the cell that comes next where none has ended. Returns
/// what was done, in words. Errors: as Reject.
[[nodiscard]] Result<std::string> Note(SessionFolder& session, const std::string& file,
                                       const std::string& text);

/// The cell that comes next comes again behind all others. Returns what was done, in words. Errors:
/// as ChooseNext and Reject.
[[nodiscard]] Result<std::string> Skip(SessionFolder& session, const std::string& reason);

}  // namespace haptometer::tools
