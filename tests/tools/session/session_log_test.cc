#include "tools/session/session_log.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "trial/byte_io.h"

namespace haptometer::tools {
namespace {

using enum SessionEvent;
using enum SessionVerdict;

const SessionCell kOne{"1", "stock", 1};
const SessionCell kTwo{"1", "cone, wide", 2};  // a comma, which the table has to quote
const SessionCell kThree{"2", "stock", 1};
const SessionCell kFloor{"1", "", 1};

SessionLogLine Begin(const SessionCell& cell, std::int64_t attempt, const std::string& file) {
  return {"2026-11-24T12:00:00.000Z", kBegin, cell, attempt, file, {}, ""};
}

SessionLogLine End(const SessionCell& cell, std::int64_t attempt, const std::string& file,
                   SessionVerdict verdict, const std::string& reason = "") {
  return {"2026-11-24T12:00:04.000Z", kEnd, cell, attempt, file, verdict, reason};
}

std::string LogOf(const std::vector<SessionLogLine>& lines) {
  std::string text(kSessionLogHeader);
  for (const SessionLogLine& line : lines) text += TextOf(line);
  return text;
}

// a day: floor, good, killed, bad, redone, rejected, relabelled
const std::vector<SessionLogLine> kDay{
    Begin(kFloor, 1, "f.bin"),
    End(kFloor, 1, "f.bin", kGood),
    Begin(kOne, 1, "a.bin"),
    End(kOne, 1, "a.bin", kGood),
    Begin(kTwo, 1, "b.bin"),
    Begin(kTwo, 2, "c.bin"),
    End(kTwo, 2, "c.bin", kBad, "no drive, \"none\""),
    Begin(kTwo, 3, "d.bin"),
    End(kTwo, 3, "d.bin", kCheck, "=1+1; the tone is at 230 Hz"),
    Begin(kThree, 1, "e.bin"),
    End(kThree, 1, "e.bin", kGood),
    {"2026-11-24T11:00:00.000Z", kReject, kThree, 1, "e.bin", {}, "finger slipped"},
    {"2026-11-24T11:00:00.000Z", kRelabel, kThree, 2, "a.bin", kCheck, "subjects swapped", 2e-5}};
const std::vector<SessionCell> kPlanned{kFloor, kOne, kTwo, kThree};

TEST(SessionLog, ALineIsReadAsItWasWritten) {
  for (const SessionLogLine& line : kDay) {
    const std::string text = TextOf(line);
    ASSERT_TRUE(text.ends_with('\n'));
    const auto read = ReadLogLine(std::string_view(text).substr(0, text.size() - 1));
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(TextOf(*read), text);
    EXPECT_EQ(read->cell, line.cell);
    EXPECT_EQ(read->reason, line.reason);
  }
}

TEST(SessionLog, ALineThatIsCutOrChangedIsNone) {
  const std::string text = TextOf(kDay[6]);
  const std::string line = text.substr(0, text.size() - 1);
  for (std::size_t cut = 0; cut < line.size(); ++cut) {
    EXPECT_FALSE(ReadLogLine(line.substr(0, cut))) << cut;
  }
  for (std::size_t at = 0; at < line.size(); ++at) {
    std::string changed = line;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    EXPECT_FALSE(ReadLogLine(changed)) << at;
  }
}

// a log from elsewhere, with sound checksums
TEST(SessionLog, WhatALineNamesIsPrintableAndInTheSessionsFolder) {
  const auto read = [](const std::string& file, const std::string& reason) {
    // written by hand, as TextOf() escapes
    std::string text = "u,end,1,a,1,1," + file + ",GOOD," + reason + ",,";
    text += fmt::format("{:08x}", trial::Crc32(std::as_bytes(std::span(text))));
    return ReadLogLine(text);
  };
  EXPECT_EQ(read("a.bin", "\x1b[2J")->reason, "\\x1b[2J");
  EXPECT_FALSE(read("../a.bin", ""));
  EXPECT_FALSE(read("/etc/passwd", ""));
}

TEST(SessionLog, CellsCountByTheirLatestFinishedAttempt) {
  const std::size_t before_rejection = kDay.size() - 2;
  const auto counts = [](std::size_t lines) {
    return CountCells(
        kPlanned,
        ReadLog(LogOf({kDay.begin(), kDay.begin() + static_cast<std::ptrdiff_t>(lines)})));
  };
  const SessionCounts none = counts(0);
  EXPECT_EQ(none.planned, 3U) << "a floor is counted apart";
  EXPECT_EQ(none.floors, 1U);
  EXPECT_EQ(none.next, kFloor);
  // the attempt of kTwo that did not end is no cell: it comes next again
  const SessionCounts killed = counts(5);
  EXPECT_EQ(killed.done, 1U);
  EXPECT_EQ(killed.attempts, 3U);
  EXPECT_EQ(killed.interrupted, 1U);
  EXPECT_EQ(killed.next, kTwo);
  // a bad cell lets the next one come first
  const SessionCounts bad = counts(7);
  EXPECT_EQ(bad.bad, 1U);
  EXPECT_EQ(bad.next, kThree);
  const SessionCounts done = counts(before_rejection);
  EXPECT_EQ(done.good, 2U);
  EXPECT_EQ(done.check, 1U);
  EXPECT_EQ(done.done, 3U);
  EXPECT_EQ(done.floors_done, 1U);
  EXPECT_EQ(done.next, std::nullopt);
  const SessionCounts rejected = counts(before_rejection + 1);
  EXPECT_EQ(rejected.bad, 1U);
  EXPECT_EQ(rejected.done, 2U);
  EXPECT_EQ(rejected.next, kThree) << "where all are finished, what is bad comes again";
  // a.bin is of kThree from now on, so kOne has none; e.bin was recorded later, and counts
  const SessionCounts relabelled = counts(before_rejection + 2);
  EXPECT_EQ(relabelled.good, 0U);
  EXPECT_EQ(relabelled.bad, 1U);
  EXPECT_EQ(relabelled.next, kOne);
}

TEST(SessionLog, ARelabellingMovesNoAttemptAndIsUndoneTheSameWay) {
  std::vector<SessionLogLine> lines = kDay;
  SessionState state = ReadLog(LogOf(lines));
  EXPECT_EQ(state.Latest(kOne), nullptr);
  EXPECT_EQ(state.Latest(kThree)->file, "e.bin") << "recorded later than a.bin";
  EXPECT_EQ(state.LastFinished()->file, "e.bin");
  const SessionAttempt& moved = *state.Find("a.bin");
  EXPECT_EQ(moved.verdict, kCheck) << "as it was judged in its new cell";
  EXPECT_EQ(moved.band_rms_m, 2e-5);
  EXPECT_EQ(moved.reason, "relabelled: subjects swapped");
  EXPECT_EQ(state.last_cells, (std::vector<SessionCell>{kThree, kOne})) << "both are to be settled";
  lines.push_back({"", kRelabel, kOne, 2, "a.bin", kGood, "they were not", 1e-5});
  state = ReadLog(LogOf(lines));
  EXPECT_EQ(state.Latest(kOne)->file, "a.bin");
  EXPECT_EQ(state.Latest(kOne)->verdict, kGood);
  EXPECT_EQ(state.NextNumber(kOne), 3);
  EXPECT_EQ(state.damaged_lines, 0U);
  // of an earlier version, without a verdict: the old one stays
  lines.push_back({"", kRelabel, kThree, 3, "a.bin", {}, "of 2025"});
  EXPECT_EQ(ReadLog(LogOf(lines)).Find("a.bin")->verdict, kGood);
}

TEST(SessionLog, AnAcceptanceUndoesRejectionsAndLetsItsAttemptCount) {
  std::vector<SessionLogLine> lines{End(kOne, 1, "a.bin", kCheck, "230 Hz"),
                                    {"", kReject, kOne, 1, "a.bin", {}, "slipped"},
                                    {"", kReject, kOne, 1, "a.bin", {}, "and too loud"},
                                    End(kOne, 2, "b.bin", kGood)};
  const auto state = [&] { return ReadLog(LogOf(lines)); };
  EXPECT_EQ(state().Find("a.bin")->verdict, kBad);
  EXPECT_EQ(state().Find("a.bin")->Reasons(), "rejected: slipped; and too loud; 230 Hz");
  EXPECT_EQ(state().Latest(kOne)->file, "b.bin");
  lines.push_back({"", kAccept, kOne, 1, "a.bin", {}, "wrong key"});
  EXPECT_EQ(state().Latest(kOne)->file, "a.bin");
  EXPECT_EQ(state().Latest(kOne)->verdict, kCheck) << "as it was judged";
  EXPECT_EQ(state().Latest(kOne)->Reasons(), "230 Hz");
  EXPECT_EQ(state().Find("a.bin")->notes, (std::vector<std::string>{"accepted: wrong key"}));
  // of two acceptances the later one counts
  lines.push_back({"", kAccept, kOne, 2, "b.bin", {}, "no"});
  lines.push_back({"", kAccept, kOne, 1, "a.bin", {}, "yes"});
  EXPECT_EQ(state().Latest(kOne)->file, "a.bin");
  lines.push_back(Begin(kOne, 3, "c.bin"));
  EXPECT_EQ(state().Latest(kOne)->file, "a.bin") << "the newer one has not ended";
  lines.push_back(End(kOne, 3, "c.bin", kGood));
  EXPECT_EQ(state().Latest(kOne)->file, "c.bin");
  EXPECT_EQ(state().damaged_lines, 0U);
  lines.push_back({"", kAccept, kOne, 1, "none.bin", {}, "no such attempt"});
  EXPECT_EQ(state().damaged_lines, 1U);
}

// stopped, lost, or a full disk; a floor before its subject's trials
TEST(SessionLog, WhatWasCutShortAndAFloorThatIsBadComeAgainAtOnce) {
  std::vector<SessionLogLine> lines;
  const auto next = [&] { return CountCells(kPlanned, ReadLog(LogOf(lines))).next; };
  lines.push_back(End(kFloor, 1, "f.bin", kBad, "a drive is on"));
  EXPECT_EQ(next(), kFloor);
  EXPECT_EQ(CountCells(kPlanned, ReadLog(LogOf(lines))).floors_done, 0U);
  lines.push_back({"", kSkip, kFloor, 0, "", {}, "no time"});
  EXPECT_EQ(next(), kOne) << "without it";
  for (const std::string& reason : {std::string(kStopped), fmt::format("{}: no room", kStopped),
                                    fmt::format("{}; no drive", kConnectionLost)}) {
    lines.push_back(End(kOne, 1, reason + ".bin", kBad, reason));
    EXPECT_EQ(next(), kOne) << reason;
  }
  lines.push_back(End(kOne, 4, "a.bin", kBad, "no drive"));
  EXPECT_EQ(next(), kTwo) << "BAD in full: at the end";
  lines.push_back(End(kTwo, 1, "b.bin", kGood));
  lines.push_back(End(kTwo, 2, "c.bin", kBad, std::string(kStopped)));
  EXPECT_EQ(next(), kTwo) << "a redo too";
  lines.push_back(End(kTwo, 3, "d.bin", kGood));
  EXPECT_EQ(next(), kThree);
  // another subject's floor, and one behind the trials, do not come first
  lines.push_back(End(kFloor, 2, "g.bin", kBad, "a drive is on"));
  EXPECT_EQ(next(), kThree);
}

TEST(SessionLog, LineEndsOfASpreadsheetAreRead) {
  std::string text = "\xEF\xBB\xBF";
  for (const char c : LogOf(kDay)) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const SessionState state = ReadLog(text);
  EXPECT_EQ(state.damaged_lines, 0U);
  EXPECT_EQ(state.attempts.size(), 6U);
  // what else it changes is no line
  EXPECT_EQ(ReadLog("x\r\n" + LogOf(kDay)).first_damaged, 1U);
  EXPECT_EQ(ReadLog(LogOf(kDay) + "x\n\ny\n").first_damaged, kDay.size() + 2);
}

// a clock that is set back by an hour during the day: the order of the lines decides
TEST(SessionLog, TimesDecideNothing) {
  const auto at = [](const char* utc, SessionLogLine line) {
    line.utc = utc;
    return line;
  };
  const SessionState state =
      ReadLog(LogOf({at("2026-11-26T12:00:00.000Z", Begin(kOne, 1, "a.bin")),
                     at("2026-11-26T12:00:05.000Z", End(kOne, 1, "a.bin", kBad)),
                     at("2026-11-26T11:00:10.000Z", Begin(kOne, 2, "b.bin")),
                     at("2026-11-26T11:00:15.000Z", End(kOne, 2, "b.bin", kGood))}));
  ASSERT_NE(state.Latest(kOne), nullptr);
  EXPECT_EQ(state.Latest(kOne)->file, "b.bin");
  EXPECT_EQ(state.NextNumber(kOne), 3);
  EXPECT_EQ(state.damaged_lines, 0U);
}

TEST(SessionLog, AnImportStatesItsFileWhenItBegins) {
  SessionLogLine begin = Begin(kOne, 1, "a.bin");
  begin.reason = "12 bytes, modified 3, run1.csv";
  const SessionState state = ReadLog(LogOf({begin, End(kOne, 1, "a.bin", kGood)}));
  EXPECT_EQ(state.attempts.at(0).origin, begin.reason);
  EXPECT_EQ(state.attempts.at(0).reason, "");
}

TEST(SessionLog, RepeatsAreTheGoodOnesThatCount) {
  const auto end = [](std::int64_t repeat, const std::string& file, double rms_m,
                      SessionVerdict verdict = kGood) {
    SessionLogLine line = End({"1", "stock", repeat}, 1, file, verdict);
    line.band_rms_m = rms_m;
    return line;
  };
  std::vector<SessionLogLine> lines{end(1, "a.bin", 1e-5), end(2, "b.bin", 9e-5, kCheck)};
  const SessionCell of{"1", "stock", 9};
  EXPECT_FALSE(ReadLog(LogOf(lines)).RepeatsRms(of)) << "one is GOOD, two are needed";
  lines.push_back(end(3, "c.bin", 2.123456789012345e-5));
  EXPECT_EQ(ReadLog(LogOf(lines)).RepeatsRms(of), (1e-5 + 2.123456789012345e-5) / 2)
      << "to the last digit";
  EXPECT_FALSE(ReadLog(LogOf(lines)).RepeatsRms({"1", "stock", 3})) << "not by itself";
  EXPECT_FALSE(ReadLog(LogOf(lines)).RepeatsRms({"2", "stock", 9}));
  lines.push_back(end(1, "d.bin", 3e-5));
  EXPECT_EQ(ReadLog(LogOf(lines)).RepeatsRms(of), (3e-5 + 2.123456789012345e-5) / 2)
      << "done again: the later one counts";
}

// what kill -9 at any moment leaves: whole lines and a part of one
// first(kOne), last: what is skipped comes behind all others, also behind what is bad
TEST(SessionLog, ASkippedCellComesAgainBehindTheOthersAndIsUndoneByAnAttempt) {
  const std::vector<SessionCell> planned{kOne, kTwo, kThree};
  std::vector<SessionLogLine> lines{{"", kSkip, kOne, 0, "", {}, "cone is broken"}};
  const auto counts = [&] { return CountCells(planned, ReadLog(LogOf(lines))); };
  EXPECT_EQ(counts().next, kTwo);
  EXPECT_EQ(counts().skipped, 1U);
  lines.push_back({"", kSkip, kTwo, 0, "", {}, "too"});
  lines.push_back(Begin(kThree, 1, "c.bin"));
  lines.push_back(End(kThree, 1, "c.bin", kBad));
  EXPECT_EQ(counts().next, kThree) << "what is bad comes before what is skipped";
  lines.push_back(End(kThree, 2, "d.bin", kGood));
  EXPECT_EQ(counts().next, kOne) << "skipped first";
  lines.push_back({"", kSkip, kOne, 0, "", {}, "still"});
  EXPECT_EQ(counts().next, kTwo) << "skipped again, behind the other";
  lines.push_back(Begin(kTwo, 1, "e.bin"));
  EXPECT_EQ(counts().skipped, 1U) << "an attempt of it has begun";
  EXPECT_EQ(counts().next, kTwo);
  lines.push_back(End(kTwo, 1, "e.bin", kGood));
  lines.push_back({"", kRelabel, kOne, 1, "d.bin", {}, "it was the other"});
  EXPECT_EQ(counts().skipped, 0U) << "an attempt is of it";
  EXPECT_EQ(counts().next, kThree);
  EXPECT_EQ(ReadLog(LogOf(lines)).damaged_lines, 0U);
}

TEST(SessionLog, NotesStayWithTheirAttemptOrCell) {
  std::vector<SessionLogLine> lines{{"", kNote, kOne, 0, "", {}, "cold room"},
                                    End(kOne, 1, "a.bin", kGood),
                                    {"", kNote, kOne, 1, "a.bin", {}, "cold finger, \"loud\""},
                                    {"", kNote, kOne, 1, "a.bin", {}, "twice"},
                                    {"", kRelabel, kTwo, 1, "a.bin", {}, "swapped"},
                                    {"", kNote, kOne, 1, "none.bin", {}, "of nothing"}};
  const SessionState state = ReadLog(LogOf(lines));
  ASSERT_EQ(state.attempts.size(), 1U);
  EXPECT_EQ(state.attempts[0].notes, (std::vector<std::string>{"cold finger, \"loud\"", "twice"}));
  ASSERT_EQ(state.notes.size(), 1U);
  EXPECT_EQ(state.notes[0].text, "cold room");
  EXPECT_EQ(state.damaged_lines, 1U);
  // a beginning without a file and a skip of an attempt are no lines
  EXPECT_EQ(ReadLog(LogOf({Begin(kOne, 1, "")})).damaged_lines, 1U);
  EXPECT_EQ(ReadLog(LogOf({{"", kSkip, kOne, 1, "a.bin", {}, "x"}})).damaged_lines, 1U);
}

TEST(SessionLog, AFloorServesTheTrialsThatBeganBehindIt) {
  const SessionCell other{"2", "", 1};
  const SessionState state = ReadLog(LogOf(
      {End(kOne, 1, "a.bin", kGood), End(kFloor, 1, "f.bin", kGood), End(other, 1, "o.bin", kGood),
       End(kTwo, 1, "b.bin", kGood), End(kFloor, 2, "g.bin", kBad), Begin(kTwo, 2, "c.bin"),
       End(kFloor, 3, "h.bin", kGood), Begin(kTwo, 3, "d.bin")}));
  std::string excluded;  // by hand
  const auto floor_in = [&](const SessionState& of, const std::string& file) {
    const auto* found =
        of.FloorOf(*of.Find(file), [&](const SessionAttempt& one) { return one.file != excluded; });
    return found == nullptr ? std::string() : found->file;
  };
  const auto floor = [&](const std::string& file) { return floor_in(state, file); };
  EXPECT_EQ(floor("a.bin"), "") << "recorded before it";
  EXPECT_EQ(floor("b.bin"), "f.bin");
  EXPECT_EQ(floor("c.bin"), "f.bin") << "one that is BAD is none";
  EXPECT_EQ(floor("d.bin"), "h.bin");
  excluded = "h.bin";
  EXPECT_EQ(floor("d.bin"), "f.bin") << "the last that is not excluded";
  excluded = "f.bin";
  EXPECT_EQ(floor("b.bin"), "");
  // one that is accepted counts for what is recorded behind its acceptance
  excluded.clear();
  const SessionState accepted = ReadLog(LogOf({End(kFloor, 1, "f.bin", kGood),
                                               End(kFloor, 2, "g.bin", kGood),
                                               End(kOne, 1, "a.bin", kGood),
                                               {"", kAccept, kFloor, 1, "f.bin", {}, "x"},
                                               End(kTwo, 1, "b.bin", kGood)}));
  EXPECT_EQ(floor_in(accepted, "a.bin"), "g.bin");
  EXPECT_EQ(floor_in(accepted, "b.bin"), "f.bin");
}

TEST(SessionLog, AnyBeginningOfTheLogGivesTheStateOfItsWholeLines) {
  const std::string log = LogOf(kDay);
  for (std::size_t bytes = 0; bytes <= log.size(); ++bytes) {
    const std::string text = log.substr(0, bytes);
    // a line that lacks its end alone is whole: its checksum is there
    const auto ends = std::ranges::count(log.substr(0, bytes + 1), '\n');
    const std::ptrdiff_t whole_lines = std::max<std::ptrdiff_t>(ends, 1) - 1;
    const bool is_torn =
        bytes < log.size() && bytes > 0 && log[bytes] != '\n' && log[bytes - 1] != '\n';
    const SessionState state = ReadLog(text);
    const SessionState expected = ReadLog(LogOf({kDay.begin(), kDay.begin() + whole_lines}));
    ASSERT_EQ(state.damaged_lines, 0U) << bytes;
    ASSERT_EQ(state.is_torn, is_torn) << bytes;
    ASSERT_EQ(state.attempts.size(), expected.attempts.size()) << bytes;
    for (std::size_t i = 0; i < state.attempts.size(); ++i) {
      EXPECT_EQ(state.attempts[i].file, expected.attempts[i].file);
      EXPECT_EQ(state.attempts[i].cell, expected.attempts[i].cell);
      EXPECT_EQ(state.attempts[i].verdict, expected.attempts[i].verdict);
    }
    // going on behind a torn line: it is passed over, and what follows counts
    const bool has_end = text.empty() || text.ends_with('\n');
    const std::string more = text + (has_end ? "" : "\n") + TextOf(Begin(kOne, 9, "z.bin")) +
                             TextOf(End(kOne, 9, "z.bin", kGood));
    const SessionState after = ReadLog(more);
    ASSERT_EQ(after.damaged_lines, state.is_torn ? 1U : 0U) << bytes;
    ASSERT_EQ(after.Latest(kOne)->file, "z.bin") << bytes;
    ASSERT_EQ(after.attempts.size(), state.attempts.size() + 1) << bytes;
  }
}

TEST(SessionLog, WhatFitsNothingIsCountedAndPassedOver) {
  std::string log = LogOf({Begin(kOne, 1, "a.bin")});
  log += TextOf({"", kReject, kOne, 1, "a.bin", {}, "it has not ended"});
  log += TextOf({"", kRelabel, kOne, 1, "none.bin", {}, "no such attempt"});
  log += TextOf(Begin(kOne, 1, "a.bin"));
  log += "a line of somebody else\n";
  const SessionState state = ReadLog(log);
  EXPECT_EQ(state.damaged_lines, 4U);
  ASSERT_EQ(state.attempts.size(), 1U);
  EXPECT_EQ(state.attempts[0].verdict, std::nullopt);
  EXPECT_EQ(CountCells({}, ReadLog(LogOf(kDay))).outside, 5U) << "finished, without a plan";
  // an end whose beginning is lost says all of the attempt
  EXPECT_EQ(ReadLog(LogOf({End(kOne, 4, "a.bin", kGood)})).NextNumber(kOne), 5);
}

}  // namespace
}  // namespace haptometer::tools
