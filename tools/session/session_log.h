#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/session/session_plan.h"

namespace haptometer::tools {

/// What a trial is good for.
enum class SessionVerdict : std::uint8_t {
  kGood,
  kCheck,  ///< it has a value that deviates from what is accepted, or is doubted
  kBad,    ///< it has none, or was rejected
};

/// "GOOD", "CHECK", "BAD".
[[nodiscard]] std::string_view Name(SessionVerdict verdict);

enum class SessionEvent : std::uint8_t {
  kBegin,    ///< before an attempt: its file does not exist yet
  kEnd,      ///< after it, with the verdict
  kReject,   ///< of a finished attempt, with the reason
  kRelabel,  ///< a finished attempt is of this cell from now on, with its verdict there; the reason
             ///< is the user's, and behind it those of the verdict
  kAccept,   ///< a finished attempt is not rejected any more and counts, with the reason
  kNote,     ///< what was seen at an attempt, or at a cell that has none
  kSkip,     ///< the cell comes again behind all others, with the reason
};

/// "begin", "end", "reject", "relabel", "accept", "note", "skip".
[[nodiscard]] std::string_view Name(SessionEvent event);

/// A line of log.csv.
struct SessionLogLine {
  std::string utc;
  SessionEvent event = SessionEvent::kBegin;
  SessionCell cell;          ///< of kRelabel the new one
  std::int64_t attempt = 1;  ///< its number within the cell, from 1; 0 of a cell alone
  std::string file;          ///< in the folder trials; names the attempt. Empty: of a cell alone,
                             ///< which kNote may and kSkip must be
  std::optional<SessionVerdict> verdict;  ///< kEnd, kRelabel
  std::string reason;                     ///< of kNote its text
  std::optional<double> band_rms_m = {};  ///< kEnd, kRelabel, of a trial that has one
};

/// The first line of log.csv, with its end.
inline constexpr std::string_view kSessionLogHeader =
    "utc,event,subject,condition,repeat,attempt,file,verdict,reason,band_rms_m,crc32\n";

/// The line with its end. The last cell is the CRC-32 of all before it, so a line of which a part
/// is missing or changed is known.
[[nodiscard]] std::string TextOf(const SessionLogLine& line);

/// What the reason of an end begins with where the recording was cut short: stopped, or not to be
/// written to the disk; or where it lost its device.
inline constexpr std::string_view kStopped = "stopped before its end";
inline constexpr std::string_view kConnectionLost = "the connection was lost";

/// A line without its end; nothing where it is not whole.
[[nodiscard]] std::optional<SessionLogLine> ReadLogLine(std::string_view text);

/// One recording of a cell, begun.
struct SessionAttempt {
  SessionCell cell;
  std::int64_t number = 1;
  std::string file = {};
  std::optional<SessionVerdict> verdict = {};  ///< BAD where it is rejected, or else `judged`
  std::string reason = {};                     ///< of `judged`
  std::optional<SessionVerdict> judged = {};   ///< by what is in the file; empty: it did not end
  std::vector<std::string> rejections = {};    ///< their reasons, since it was accepted
  std::optional<double> band_rms_m = {};
  std::size_t begun = 0;  ///< place of its beginning among all beginnings and acceptances
  std::size_t place = 0;  ///< that of its last acceptance, or of its beginning
  std::vector<std::string> notes = {};
  std::string origin = {};    ///< of an import its file (watched_folder.h): the reason of kBegin
  bool is_cut_short = false;  ///< the recording, or its device was lost: the cell stays open

  /// Of the verdict: the rejections, and behind them `reason`; empty where there are none.
  [[nodiscard]] std::string Reasons() const;
};

/// A cell with what was said of it.
struct SessionRemark {
  SessionCell cell;
  std::string text;
};

/// What log.csv says.
struct SessionState {
  std::vector<SessionAttempt> attempts;  ///< in the order of their beginnings
  std::vector<SessionRemark> notes;      ///< of cells; those of attempts are there
  std::vector<SessionRemark> skipped;  ///< cells of which no attempt has begun since, with reasons
  std::size_t damaged_lines = 0;  ///< passed over: no line of this log, or one of no known attempt
  std::size_t first_damaged = 0;  ///< the number of the first of them, from 1
  bool is_torn = false;           ///< the last line is a part: the program was killed in it
  std::size_t places = 0;         ///< beginnings and acceptances so far
  std::vector<SessionCell> last_cells;  ///< whose attempts the last line is of

  /// The attempt of that file; nullptr where there is none.
  [[nodiscard]] const SessionAttempt* Find(const std::string& file) const;
  /// The finished attempt of a cell that began or was accepted last, which is the one that counts;
  /// nullptr where there is none.
  [[nodiscard]] const SessionAttempt* Latest(const SessionCell& cell) const;
  /// The last attempt that ended, of any cell; nullptr where there is none.
  [[nodiscard]] const SessionAttempt* LastFinished() const;
  /// The subject's last floor that is GOOD and `is_usable` and began (or was accepted) before
  /// `attempt`; nullptr where there is none.
  [[nodiscard]] const SessionAttempt* FloorOf(
      const SessionAttempt& attempt,
      const std::function<bool(const SessionAttempt& floor)>& is_usable) const;
  /// The median RMS of the other repeats of the cell's subject and condition that count and are
  /// GOOD; nothing of fewer than 2.
  [[nodiscard]] std::optional<double> RepeatsRms(const SessionCell& cell) const;
  /// Whether the cell is skipped.
  [[nodiscard]] bool IsSkipped(const SessionCell& cell) const;
  /// The number of the cell's next attempt: numbers of unfinished ones are not given again.
  [[nodiscard]] std::int64_t NextNumber(const SessionCell& cell) const;
};

/// The state after the lines of `text`. Any text has one: what is no line is counted and passed
/// over, so a log that was cut at any byte gives the state of its whole lines. Lines may end with
/// CR LF, and a byte order mark may stand first, as programs for spreadsheets write them. Cost:
/// O(n) and O(attempts) a line.
[[nodiscard]] SessionState ReadLog(std::string_view text);

/// What of the plan is done; cells count by their latest finished attempt.
struct SessionCounts {
  std::size_t planned = 0;  ///< cells that are no floors
  std::size_t done = 0;     ///< good + check
  std::size_t good = 0;
  std::size_t check = 0;
  std::size_t bad = 0;
  std::size_t floors = 0;       ///< planned
  std::size_t floors_done = 0;  ///< GOOD
  std::size_t attempts = 0;     ///< begun, of all cells
  std::size_t interrupted = 0;  ///< of these not ended
  std::size_t outside = 0;      ///< finished, of cells that the plan does not have
  std::size_t skipped = 0;      ///< cells, floors too
  /// The first cell without a finished attempt, or whose attempt was cut short; before it the
  /// subject's floor where that is not GOOD. Where there is none the first that is bad; behind
  /// these the skipped ones, in the order in which they were skipped; nothing where all are done.
  std::optional<SessionCell> next;
};

[[nodiscard]] SessionCounts CountCells(const std::vector<SessionCell>& cells,
                                       const SessionState& state);

}  // namespace haptometer::tools
