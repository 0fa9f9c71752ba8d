// What reading a file finds, in sentences: one for each kind.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "tools/document/document.h"

namespace haptometer::document {
namespace {

using enum trial::FindingKind;

struct Case {
  trial::FindingKind kind;
  std::vector<FindingNumber> numbers;
  std::string sentence;
};

const std::vector<Case> kCases{
    {kSignatureDamaged,
     {{"from_byte", 0}, {"to_byte", 15}},
     "the file's signature is damaged (bytes 0 to 15)"},
    {kBlocksDamaged,
     {{"block", 7}, {"from_byte", 4096}, {"to_byte", 8191}, {"first_row", 512}, {"last_row", 1023}},
     "block 7 is damaged (bytes 4096 to 8191): rows 512 to 1023 are lost"},
    {kBlocksMissing,
     {{"first_block", 3}, {"last_block", 5}, {"row", 10}},
     "blocks 3 to 5 are missing: row 10 is lost"},
    {kBlockOutOfOrder, {{"block", 3}}, "block 3 is out of order"},
    {kBlockNoEvent, {{"block", 3}}, "block 3 holds no event"},
    {kBlockUnfit, {{"block", 3}}, "block 3 does not fit the header"},
    {kEndsInBlock,
     {{"block", 3}, {"after_row", 20}},
     "the file ends inside block 3: what followed row 20 is lost"},
    {kDamagedFromBlock, {{"block", 3}}, "the file is damaged from block 3 on"},
    {kNotFinished, {}, "the file was not finished by its writer"},
    {kDoubtedAtRecording, {{"text", "errors on the wire"}}, "at the recording: errors on the wire"},
    {kNumbersRefuted,
     {{"lines", 1}, {"row", 700}, {"missing", 999}},
     "by the number of 1 line more lines are missing than the times hold (999 before row 700): a "
     "line sent twice, a wrong number or a counter that was reset; these losses do not count"},
    {kFormatFound,
     {{"format", "plain"}, {"title", "plain table"}, {"channels", "CH1 [V]"}},
     "the file is read as plain table (found; --format plain), channels CH1 [V]"},
    {kFormatGiven,
     {{"format", "plain"}, {"title", "plain table"}, {"channels", "a"}, {"separator", "blanks"}},
     "the file is read as plain table (--format plain), cells separated by blanks, channels a"},
    {kFormatNotUsed, {}, "the file has a layout of its own; --format is not used"},
    {kUnitOverridden,
     {{"column", 2},
      {"file_factor", 1e-3},
      {"file_unit", "m"},
      {"given_factor", 1e-6},
      {"given_unit", "m"}},
     "column 2 is in units of 0.001 m by the file and of 1e-06 m by --columns or --scale, which is "
     "used"},
    {kStatedRowsDiffer, {{"stated_rows", 3}, {"rows", 2}}, "the file states 3 rows and holds 2"},
    {kLastLineCutOff,
     {{"line", 301}},
     "line 301, the last one, has no line end and is shorter than those before: it was cut off and "
     "is excluded; is the file complete?"},
    {kRateContradicted,
     {{"rate_hz", 1.0}, {"stated_hz", 1e3}, {"stated_by", "Increment"}},
     "the times give 1 Hz and 'Increment' gives 1000 Hz; --rate decides"},
    {kTimesInOtherUnit,
     {{"rate_hz", 1.0}, {"stated_hz", 1e3}},
     "the times give 1 Hz where the file states 1000 Hz; they are used as they are, but may be in "
     "another unit than their column states"},
    {kRateReplaced,
     {{"rate_hz", 500.0}, {"stated_hz", 1e3}, {"stated_by", "Increment"}},
     "--rate 500 Hz replaces 1000 Hz by 'Increment'"},
    {kStartAssumed, {}, "the time of the first row is not in the file; it is assumed to be 0 s"},
    {kRowsMissing,
     {{"missing", 23}, {"places", 2}, {"line", 1502}},
     "rows are missing by the row numbers in the first column: 23 in 2 places, the first before "
     "line 1502"},
    {kRowNumbersUneven,
     {{"line", 7}},
     "the row numbers in the first column do not grow by whole steps in line 7: whether rows are "
     "missing is not known; all rows are taken to follow each other"},
    {kRowsExcluded,
     {{"excluded", 1}, {"rows", 300}, {"line", 203}},
     "rows with the time of the row before are excluded: 1 of 300, the first in line 203"},
    {kTimesRebuilt,
     {{"repeated", 7}, {"rows", 300}, {"rate_hz", 500.0}, {"rate_uncertainty_hz", 0.02}},
     "7 of 300 times equal that of the row before, because they have too few digits; they are "
     "replaced by the uniform grid that explains all of them, whose rate is 500.000(20) Hz"},
    {kChannelsApart,
     {{"apart_s", 1.5e-3}},
     "the channels begin up to 1.5 ms apart (t0); all are given the times of the first one"},
    {kTransitionsOnly,
     {},
     "digital channels list their transitions only: their rows are not samples"},
    {kValueUnitAssumed,
     {{"title", "LeCroy"}, {"unit", "V"}},
     "the unit of the values is not in the file; LeCroy writes V"},
    {kTimeUnitAssumed,
     {{"title", "LeCroy"}, {"unit", "s"}},
     "the unit of the times is not in the file; LeCroy writes s"},
    {kCalibrationOf, {{"channel", "Laser"}}, "the calibration is applied to the channel 'Laser'"},
    {kInputTooLarge,
     {{"most_v", 3e3}},
     "the input of the calibration reaches 3000 V, more than an analog output gives: is its column "
     "in mV? Name it by --columns time_s,voltage_mv, or that of the pairs voltage_mv"},
    {kRowsBeginAt,
     {{"first", 22.0}, {"earlier_s", 4.4e-3}},
     "the rows begin at number 22: times are Start + number x Increment; if Start is the first "
     "row's time, all are 4.4 ms earlier"},
    {kNotedAtExport, {{"text", "block 3 is missing"}}, "block 3 is missing"},
};

TEST(FindingsOfTrials, EachKindHasItsSentence) {
  std::set<std::string_view> names;
  for (std::size_t k = 0; k < kCases.size(); ++k) {
    const auto& [kind, numbers, sentence] = kCases[k];
    EXPECT_EQ(static_cast<std::size_t>(kind), k) << "every kind once, in their order";
    EXPECT_EQ(Fill(SentenceOf(kind).text, numbers), sentence);
    EXPECT_TRUE(names.insert(SentenceOf(kind).kind).second) << SentenceOf(kind).kind;
  }
  EXPECT_EQ(kCases.size(), static_cast<std::size_t>(kNotedAtExport) + 1);
}

TEST(FindingsOfTrials, AUnitThatIsNotKnownIsQuoted) {
  const std::vector<FindingNumber> numbers{
      {"column", 2}, {"unknown_unit", "mm/s"}, {"given_factor", 1e-6}, {"given_unit", "m"}};
  EXPECT_EQ(Fill(SentenceOf(kUnitOverridden).text, numbers),
            "column 2 is in units of 'mm/s' by the file and of 1e-06 m by --columns or --scale, "
            "which is used");
}

}  // namespace
}  // namespace haptometer::document
