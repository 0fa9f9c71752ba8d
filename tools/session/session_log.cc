#include "tools/session/session_log.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "base/names.h"
#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "trial/byte_io.h"

namespace haptometer::tools {
namespace {

constexpr Names<SessionVerdict, 3> kVerdictNames{{"GOOD", "CHECK", "BAD"}};
constexpr Names<SessionEvent, 4> kEventNames{{"begin", "end", "reject", "relabel"}};

constexpr std::size_t kCells = 10;

std::string CrcOf(std::string_view text) {
  return fmt::format("{:08x}", trial::Crc32(std::as_bytes(std::span(text))));
}

}  // namespace

std::string_view Name(SessionVerdict verdict) { return kVerdictNames.Of(verdict); }
std::string_view Name(SessionEvent event) { return kEventNames.Of(event); }

std::string TextOf(const SessionLogLine& line) {
  const std::string text = fmt::format(
      "{},{},{},{},{},{},{},{},{},", line.utc, Name(line.event), cli::CellOf(line.cell.subject),
      cli::CellOf(line.cell.condition), line.cell.repeat, line.attempt, cli::CellOf(line.file),
      line.verdict ? Name(*line.verdict) : "", cli::CellOf(line.reason));
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
  if (!event || !repeat || !attempt || *repeat < 1 || *attempt < 1) return std::nullopt;
  // an attempt is known by its file, and its end has a verdict
  const bool has_verdict = verdict.has_value() || *event != SessionEvent::kEnd;
  if (cells[2].empty() || cells[6].empty() || !has_verdict) return std::nullopt;
  // a name of another folder is none of the session's
  if (cells[6].contains('/')) return std::nullopt;
  // any program may have written it: the code behind this place meets no control character
  return SessionLogLine{.utc = Printable(cells[0]),
                        .event = *event,
                        .cell = {Printable(cells[2]), Printable(cells[3]), *repeat},
                        .attempt = *attempt,
                        .file = Printable(cells[6]),
                        .verdict = verdict,
                        .reason = Printable(cells[8])};
}

const SessionAttempt* SessionState::Latest(const SessionCell& cell) const {
  const auto found = std::ranges::find_if(
      attempts.rbegin(), attempts.rend(),
      [&](const SessionAttempt& attempt) { return attempt.verdict && attempt.cell == cell; });
  return found == attempts.rend() ? nullptr : &*found;
}

const SessionAttempt* SessionState::LastFinished() const {
  const auto found = std::ranges::find_if(
      attempts.rbegin(), attempts.rend(),
      [](const SessionAttempt& attempt) { return attempt.verdict.has_value(); });
  return found == attempts.rend() ? nullptr : &*found;
}

std::int64_t SessionState::NextNumber(const SessionCell& cell) const {
  std::int64_t next = 1;
  for (const SessionAttempt& attempt : attempts) {
    if (attempt.cell == cell) next = std::max(next, attempt.number + 1);
  }
  return next;
}

namespace {

// false: the line does not fit what is known
bool Take(const SessionLogLine& line, std::vector<SessionAttempt>& attempts) {
  auto known = std::ranges::find(attempts, line.file, &SessionAttempt::file);
  const bool is_known = known != attempts.end();
  using enum SessionEvent;
  // an end whose beginning was damaged says all of it
  if (!is_known && (line.event == kBegin || line.event == kEnd)) {
    attempts.push_back({line.cell, line.attempt, line.file, line.verdict, line.reason, false});
    return true;
  }
  if (!is_known || line.event == kBegin) return false;
  if (line.event == kEnd) {
    if (known->verdict) return false;
    known->verdict = line.verdict;
    known->reason = line.reason;
    return true;
  }
  if (!known->verdict) return false;
  if (line.event == kReject) {
    known->is_rejected = true;
    known->verdict = SessionVerdict::kBad;
    known->reason = line.reason;
    return true;
  }
  // relabelled: the latest of its new cell
  SessionAttempt moved = *known;
  moved.cell = line.cell;
  moved.number = line.attempt;
  attempts.erase(known);
  attempts.push_back(std::move(moved));
  return true;
}

}  // namespace

SessionState ReadLog(std::string_view text) {
  constexpr std::string_view kHeader = kSessionLogHeader.substr(0, kSessionLogHeader.size() - 1);
  SessionState state;
  bool is_first = true;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const bool has_end = end != std::string_view::npos;
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(has_end ? end + 1 : text.size());
    const bool is_header = std::exchange(is_first, false) && line == kHeader;
    if (is_header || line.empty()) continue;
    const auto read = ReadLogLine(line);
    // what is no line at the end was being written when the program was killed
    if (!read && !has_end) {
      state.is_torn = true;
    } else if (!read || !Take(*read, state.attempts)) {
      ++state.damaged_lines;
    }
  }
  return state;
}

SessionCounts CountCells(const std::vector<SessionCell>& cells, const SessionState& state) {
  SessionCounts counts;
  std::optional<SessionCell> first_bad;
  for (const SessionCell& cell : cells) {
    const SessionAttempt* latest = state.Latest(cell);
    const bool is_done = latest != nullptr && *latest->verdict != SessionVerdict::kBad;
    if (latest == nullptr && !counts.next) counts.next = cell;
    if (latest != nullptr && !is_done && !first_bad) first_bad = cell;
    if (cell.is_floor()) {
      ++counts.floors;
      counts.floors_done += static_cast<std::size_t>(is_done);
      continue;
    }
    ++counts.planned;
    if (latest == nullptr) continue;
    ++(*latest->verdict == SessionVerdict::kGood    ? counts.good
       : *latest->verdict == SessionVerdict::kCheck ? counts.check
                                                    : counts.bad);
  }
  counts.done = counts.good + counts.check;
  if (!counts.next) counts.next = first_bad;
  counts.attempts = state.attempts.size();
  // some may be of cells that were planned once
  for (const SessionAttempt& attempt : state.attempts) {
    if (!attempt.verdict) ++counts.interrupted;
    if (attempt.verdict && std::ranges::count(cells, attempt.cell) == 0) ++counts.outside;
  }
  return counts;
}

}  // namespace haptometer::tools
