#include "tools/session/session_log.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <utility>

#include "base/median.h"
#include "base/names.h"
#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "trial/byte_io.h"

namespace haptometer::tools {
namespace {

constexpr Names<SessionVerdict, 3> kVerdictNames{{"GOOD", "CHECK", "BAD"}};
constexpr Names<SessionEvent, 7> kEventNames{
    {"begin", "end", "reject", "relabel", "accept", "note", "skip"}};

constexpr std::size_t kCells = 11;

std::string CrcOf(std::string_view text) {
  return fmt::format("{:08x}", trial::Crc32(std::as_bytes(std::span(text))));
}

}  // namespace

std::string_view Name(SessionVerdict verdict) { return kVerdictNames.Of(verdict); }
std::string_view Name(SessionEvent event) { return kEventNames.Of(event); }

std::string TextOf(const SessionLogLine& line) {
  const std::string text = fmt::format(
      "{},{},{},{},{},{},{},{},{},{},", line.utc, Name(line.event), cli::CellOf(line.cell.subject),
      cli::CellOf(line.cell.condition), line.cell.repeat, line.attempt, cli::CellOf(line.file),
      line.verdict ? Name(*line.verdict) : "", cli::CellOf(line.reason),
      line.band_rms_m ? fmt::format("{}", *line.band_rms_m) : "");
  return text + CrcOf(text) + "\n";
}

std::optional<SessionLogLine> ReadLogLine(std::string_view text) {
  constexpr std::size_t kCrcDigits = 8;
  if (text.size() <= kCrcDigits) return std::nullopt;
  const std::size_t at = text.size() - kCrcDigits;
  if (text.substr(at) != CrcOf(text.substr(0, at))) return std::nullopt;
  const std::vector<std::string> cells = cli::CellsOf(text);
  if (cells.size() != kCells) return std::nullopt;
  const auto event = kEventNames.From(cells[1]);
  const auto repeat = NumberFrom<std::int64_t>(cells[4]);
  const auto attempt = NumberFrom<std::int64_t>(cells[5]);
  const auto verdict = kVerdictNames.From(cells[7]);
  if (!event || !repeat || !attempt || *repeat < 1) return std::nullopt;
  // a cell alone has remarks only; an attempt is known by its file, and its end has a verdict
  using enum SessionEvent;
  const bool is_of_cell = cells[6].empty();
  const bool may_be_of_cell = *event == kNote || *event == kSkip;
  if (is_of_cell ? !may_be_of_cell || *attempt != 0 : *event == kSkip || *attempt < 1) {
    return std::nullopt;
  }
  if (cells[2].empty() || (*event == kEnd && !verdict)) return std::nullopt;
  // a name of another folder is none of the session's
  if (cells[6].contains('/')) return std::nullopt;
  // any program may have written it: the code behind this place meets no control character
  return SessionLogLine{.utc = Printable(cells[0]),
                        .event = *event,
                        .cell = {Printable(cells[2]), Printable(cells[3]), *repeat},
                        .attempt = *attempt,
                        .file = Printable(cells[6]),
                        .verdict = verdict,
                        .reason = Printable(cells[8]),
                        .band_rms_m = NumberFrom<double>(cells[9])};
}

std::string SessionAttempt::Reasons() const {
  if (rejections.empty()) return reason;
  return fmt::format("rejected: {}{}{}", fmt::join(rejections, "; "), reason.empty() ? "" : "; ",
                     reason);
}

const SessionAttempt* SessionState::Find(const std::string& file) const {
  const auto found = std::ranges::find(attempts, file, &SessionAttempt::file);
  return found == attempts.end() ? nullptr : &*found;
}

const SessionAttempt* SessionState::Latest(const SessionCell& cell) const {
  const SessionAttempt* latest = nullptr;
  for (const SessionAttempt& attempt : attempts) {
    if (!attempt.verdict || attempt.cell != cell) continue;
    if (latest == nullptr || attempt.place > latest->place) latest = &attempt;
  }
  return latest;
}

const SessionAttempt* SessionState::LastFinished() const {
  const auto found = std::ranges::find_if(
      attempts.rbegin(), attempts.rend(),
      [](const SessionAttempt& attempt) { return attempt.verdict.has_value(); });
  return found == attempts.rend() ? nullptr : &*found;
}

const SessionAttempt* SessionState::FloorOf(
    const SessionAttempt& attempt,
    const std::function<bool(const SessionAttempt& floor)>& is_usable) const {
  // an acceptance is known to what is recorded behind it
  const auto place = [&](const SessionAttempt& floor) {
    return floor.place < attempt.begun ? floor.place : floor.begun;
  };
  std::vector<const SessionAttempt*> floors;
  for (const SessionAttempt& floor : attempts) {
    const bool is_floor = floor.cell.is_floor() && floor.cell.subject == attempt.cell.subject;
    const bool is_good = floor.verdict == SessionVerdict::kGood && floor.begun < attempt.begun;
    if (is_floor && is_good) floors.push_back(&floor);
  }
  std::ranges::sort(floors, std::ranges::greater(),
                    [&](const auto* floor) { return place(*floor); });
  const auto found =
      std::ranges::find_if(floors, [&](const auto* floor) { return is_usable(*floor); });
  return found == floors.end() ? nullptr : *found;
}

std::optional<double> SessionState::RepeatsRms(const SessionCell& cell) const {
  std::vector<double> rms_m;
  for (const SessionAttempt& attempt : attempts) {
    const bool is_repeat = attempt.cell.subject == cell.subject &&
                           attempt.cell.condition == cell.condition &&
                           attempt.cell.repeat != cell.repeat;
    const bool is_good = attempt.verdict == SessionVerdict::kGood && attempt.band_rms_m;
    if (is_repeat && is_good && Latest(attempt.cell) == &attempt) {
      rms_m.push_back(*attempt.band_rms_m);
    }
  }
  if (rms_m.size() < 2) return std::nullopt;
  return Median(std::move(rms_m));
}

bool SessionState::IsSkipped(const SessionCell& cell) const {
  return std::ranges::find(skipped, cell, &SessionRemark::cell) != skipped.end();
}

std::int64_t SessionState::NextNumber(const SessionCell& cell) const {
  std::int64_t next = 1;
  for (const SessionAttempt& attempt : attempts) {
    if (attempt.cell == cell) next = std::max(next, attempt.number + 1);
  }
  return next;
}

namespace {

// a note of an attempt, or of a cell
bool TakeNote(const SessionLogLine& line, SessionState& state) {
  if (line.file.empty()) {
    state.notes.push_back({line.cell, line.reason});
    return true;
  }
  const auto known = std::ranges::find(state.attempts, line.file, &SessionAttempt::file);
  if (known == state.attempts.end()) return false;
  known->notes.push_back(line.reason);
  return true;
}

void TakeEnd(const SessionLogLine& line, SessionAttempt& attempt) {
  attempt.judged = line.verdict;
  attempt.reason = line.reason;
  attempt.band_rms_m = line.band_rms_m;
  attempt.is_cut_short =
      line.verdict == SessionVerdict::kBad &&
      (line.reason.starts_with(kStopped) || line.reason.starts_with(kConnectionLost));
  attempt.verdict = attempt.judged;
}

// a beginning, or an end whose beginning was damaged and that says all of it
bool TakeNew(const SessionLogLine& line, SessionState& state) {
  if (line.event != SessionEvent::kBegin && line.event != SessionEvent::kEnd) return false;
  const bool is_begin = line.event == SessionEvent::kBegin;
  const std::size_t place = state.places++;
  SessionAttempt& attempt = state.attempts.emplace_back(SessionAttempt{.cell = line.cell,
                                                                       .number = line.attempt,
                                                                       .file = line.file,
                                                                       .begun = place,
                                                                       .place = place});
  if (is_begin) {
    attempt.origin = line.reason;
  } else {
    TakeEnd(line, attempt);
  }
  return true;
}

// what is said of an attempt that has begun; false: it does not fit
bool TakeKnown(const SessionLogLine& line, SessionAttempt& known, SessionState& state) {
  using enum SessionEvent;
  if (line.event == kBegin || (line.event == kEnd) == known.judged.has_value()) return false;
  switch (line.event) {
    case kEnd:
      TakeEnd(line, known);
      break;
    case kReject:
      known.rejections.push_back(line.reason);
      break;
    case kAccept:
      known.rejections.clear();
      known.notes.push_back("accepted: " + line.reason);
      known.place = state.places++;
      break;
    default:
      // relabelled; without a verdict by an earlier version of this program
      state.last_cells.push_back(std::exchange(known.cell, line.cell));
      known.number = line.attempt;
      if (!line.verdict) break;
      known.judged = line.verdict;
      known.reason = "relabelled: " + line.reason;
      known.band_rms_m = line.band_rms_m;
  }
  known.verdict = known.rejections.empty() ? known.judged : SessionVerdict::kBad;
  return true;
}

// false: the line does not fit what is known
bool Take(const SessionLogLine& line, SessionState& state) {
  if (line.event == SessionEvent::kNote) return TakeNote(line, state);
  // a cell is skipped until an attempt is of it
  if (line.event != SessionEvent::kReject) {
    std::erase_if(state.skipped, [&](const SessionRemark& one) { return one.cell == line.cell; });
  }
  if (line.event == SessionEvent::kSkip) {
    state.skipped.push_back({line.cell, line.reason});
    return true;
  }
  state.last_cells = {line.cell};
  const auto known = std::ranges::find(state.attempts, line.file, &SessionAttempt::file);
  return known == state.attempts.end() ? TakeNew(line, state) : TakeKnown(line, *known, state);
}

}  // namespace

SessionState ReadLog(std::string_view text) {
  constexpr std::string_view kHeader = kSessionLogHeader.substr(0, kSessionLogHeader.size() - 1);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  SessionState state;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const bool has_end = end != std::string_view::npos;
    std::string_view line = text.substr(0, end);
    text.remove_prefix(has_end ? end + 1 : text.size());
    // saved by a program for spreadsheets
    if (line.ends_with('\r')) line.remove_suffix(1);
    if ((number == 1 && line == kHeader) || line.empty()) continue;
    const auto read = ReadLogLine(line);
    // what is no line at the end was being written when the program was killed
    if (!read && !has_end) {
      state.is_torn = true;
    } else if (!read || !Take(*read, state)) {
      if (state.damaged_lines++ == 0) state.first_damaged = number;
    }
  }
  return state;
}

namespace {

// a trial that is CHECK is done; a floor is subtracted where it is GOOD
bool IsDone(const SessionAttempt& counting) {
  return counting.verdict == SessionVerdict::kGood ||
         (counting.verdict == SessionVerdict::kCheck && !counting.cell.is_floor());
}

// the cell that is recorded next, by the attempts that count and what is skipped
std::optional<SessionCell> NextOf(const std::vector<SessionCell>& cells,
                                  const SessionState& state) {
  std::optional<SessionCell> first_bad;
  std::optional<SessionCell> floor;  // the last that is not GOOD
  for (const SessionCell& cell : cells) {
    if (state.IsSkipped(cell)) continue;
    const SessionAttempt* latest = state.Latest(cell);
    if (latest == nullptr || latest->is_cut_short) {
      return floor && floor->subject == cell.subject ? *floor : cell;
    }
    if (IsDone(*latest)) continue;
    if (cell.is_floor()) floor = cell;
    if (!first_bad) first_bad = cell;
  }
  if (first_bad) return first_bad;
  for (const SessionRemark& one : state.skipped) {
    if (std::ranges::count(cells, one.cell) > 0) return one.cell;
  }
  return std::nullopt;
}

}  // namespace

SessionCounts CountCells(const std::vector<SessionCell>& cells, const SessionState& state) {
  SessionCounts counts;
  for (const SessionCell& cell : cells) {
    const SessionAttempt* latest = state.Latest(cell);
    counts.skipped += static_cast<std::size_t>(state.IsSkipped(cell));
    if (cell.is_floor()) {
      ++counts.floors;
      counts.floors_done += static_cast<std::size_t>(latest != nullptr && IsDone(*latest));
      continue;
    }
    ++counts.planned;
    if (latest == nullptr) continue;
    ++(*latest->verdict == SessionVerdict::kGood    ? counts.good
       : *latest->verdict == SessionVerdict::kCheck ? counts.check
                                                    : counts.bad);
  }
  counts.done = counts.good + counts.check;
  counts.next = NextOf(cells, state);
  counts.attempts = state.attempts.size();
  // some may be of cells that were planned once
  for (const SessionAttempt& attempt : state.attempts) {
    if (!attempt.verdict) ++counts.interrupted;
    if (attempt.verdict && std::ranges::count(cells, attempt.cell) == 0) ++counts.outside;
  }
  return counts;
}

}  // namespace haptometer::tools
