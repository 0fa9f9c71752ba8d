#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string>

#include "tests/residual.h"
#include "tools/reproduce/reproduce.h"
#include "tools/reproduce/thesis_numbers.h"

namespace haptometer::tools {
namespace {

TEST(ThesisNumbers, HaveEachAKeyOfTheirOwnAndAPlaceWhereTheyArePrinted) {
  std::set<std::string_view> keys;
  for (const ThesisNumber& number : ThesisNumbers()) {
    EXPECT_TRUE(keys.insert(number.key).second) << number.key;
    EXPECT_FALSE(number.what.empty()) << number.key;
    EXPECT_LE(number.what.size(), 49U) << number.key << ": the table's first column";
    if (number.relation != Relation::kNotPrinted) {
      EXPECT_NE(number.where.find("p. "), std::string_view::npos) << number.key << ": no page";
    }
    EXPECT_EQ(number.half_step > 0, number.relation == Relation::kEquals) << number.key;
  }
}

TEST(ThesisNumbers, OfOneGroupStandTogether) {
  std::set<std::string_view> groups;
  std::string_view last;
  for (const ThesisNumber& number : ThesisNumbers()) {
    if (number.group == last) continue;
    last = number.group;
    EXPECT_TRUE(groups.insert(last).second) << last << " begins twice";
  }
}

// 0.0438 mm: from 0.04375 to 0.04385
TEST(RowVerdict, HoldsToHalfAUnitOfTheLastPrintedDigit) {
  ThesisRow row{.key = "rms-direct", .ours = 43.8499e-6};
  EXPECT_EQ(VerdictOf(row), RowVerdict::kReproduced);
  row.ours = 43.85e-6;
  EXPECT_EQ(VerdictOf(row), RowVerdict::kReproduced) << "the very end";
  row.ours = 43.8501e-6;
  EXPECT_EQ(VerdictOf(row), RowVerdict::kDisagrees);
  row.ours = 43.7499e-6;
  EXPECT_EQ(VerdictOf(row), RowVerdict::kDisagrees);
  EXPECT_REL(*DeviationOf(row), 43.7499 / 43.8 - 1, 1e-12, "one division");
}

TEST(RowVerdict, IsExplainedByACauseThatGivesThePrintedNumberOnly) {
  ThesisRow row{.key = "rms-direct", .ours = 45e-6};
  row.candidates = {{.text = "no", .gives = 44e-6}};
  EXPECT_EQ(VerdictOf(row), RowVerdict::kDisagrees);
  row.candidates.push_back({.text = "yes", .gives = 43.82e-6});
  EXPECT_EQ(VerdictOf(row), RowVerdict::kExplained);
  row.ours = 43.81e-6;
  EXPECT_EQ(VerdictOf(row), RowVerdict::kReproduced) << "no cause is needed";
}

TEST(RowVerdict, ACauseFromRoundedNumbersHitsWhereItsIntervalDoes) {
  const ThesisNumber& number = ThesisNumberOf("resonant-frequency");
  CandidateCause cause{.text = "", .gives = 218.515, .from_rounded = dsp::Interval{218.4, 218.6}};
  EXPECT_TRUE(Hits(number, cause));
  cause.from_rounded = dsp::Interval{218.51, 218.6};
  EXPECT_FALSE(Hits(number, cause));
  cause.from_rounded.reset();
  EXPECT_FALSE(Hits(number, cause));
}

TEST(RowVerdict, OfBoundsIsStrict) {
  ThesisRow row{.key = "sensitivity-Ks", .ours = 0.0199};
  EXPECT_EQ(VerdictOf(row), RowVerdict::kReproduced);
  row.ours = 0.02;
  EXPECT_EQ(VerdictOf(row), RowVerdict::kDisagrees);
  row.key = "sensitivity-Ka";
  EXPECT_EQ(VerdictOf(row), RowVerdict::kDisagrees);
  row.ours = 0.0201;
  EXPECT_EQ(VerdictOf(row), RowVerdict::kReproduced);
  EXPECT_FALSE(DeviationOf(row).has_value());
}

TEST(RowVerdict, OfGeneratedTrialsAsksTheInterval) {
  ThesisRow row{.key = "factor-ia1", .ours = 3.3, .interval = dsp::Interval{3.2, 3.4}};
  EXPECT_EQ(VerdictOf(row), RowVerdict::kReproduced);
  row.interval = dsp::Interval{3.28, 3.4};
  EXPECT_EQ(VerdictOf(row), RowVerdict::kDisagrees);
}

TEST(RowVerdict, OfWhatIsNotDeterminedIsNoAgreement) {
  EXPECT_EQ(VerdictOf({.key = "rms-direct", .ours = std::nullopt}), RowVerdict::kDisagrees);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(VerdictOf({.key = "rms-direct", .ours = kNaN}), RowVerdict::kDisagrees);
  EXPECT_EQ(VerdictOf({.key = "latency-adapter", .ours = kNaN}), RowVerdict::kDisagrees);
  EXPECT_EQ(VerdictOf({.key = "optimum-rms", .ours = 1}), RowVerdict::kNotPrinted);
}

TEST(ChainRow, HoldsWhereTheIntervalHoldsTheTruth) {
  ChainRow row;
  EXPECT_TRUE(row.holds()) << "no truth, no answer";
  row.answer = 1;
  EXPECT_FALSE(row.holds()) << "an answer where none can be";
  row.truth = 1;
  EXPECT_TRUE(row.holds()) << "the same to the last bit";
  row.answer = 1 + 1e-15;
  EXPECT_FALSE(row.holds());
  row.interval = dsp::Interval{0.9, 1.1};
  EXPECT_TRUE(row.holds());
  row.interval = dsp::Interval{1.01, 1.1};
  EXPECT_FALSE(row.holds());
  row.answer.reset();
  EXPECT_FALSE(row.holds());
}

}  // namespace
}  // namespace haptometer::tools
