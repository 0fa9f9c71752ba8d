// Tables of trials, matched voltages and drive sweeps, without files.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/repetitions.h"
#include "tests/residual.h"
#include "tools/document/render.h"
#include "tools/study/alike_names.h"
#include "tools/study/study_document.h"

namespace haptometer::tools {
namespace {

using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::string TextOf(const document::Document& document) {
  return document::TextOf(document, document::Detail::kAll);
}

StudyTrial Answered(int subject, const std::string& condition, int repeat, double rms_m) {
  StudyTrial trial;
  trial.file = fmt::format("{}_{}_{}", subject, condition, repeat);
  trial.subject = std::to_string(subject);
  trial.condition = condition;
  trial.repeat = std::to_string(repeat);
  trial.answered = true;
  trial.rms_m = rms_m;
  return trial;
}

double NormalDraw(std::mt19937& engine) {
  const double u = (static_cast<double>(engine()) + 0.5) / 4294967296.0;
  const double v = static_cast<double>(engine()) / 4294967296.0;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

TEST(CompareConditions, HoldsFivePercentThoughTrialsOfASubjectAreAlike) {
  std::mt19937 engine(24);
  constexpr int kRepetitions = 1000;
  int found = 0;
  for (int k = 0; k < kRepetitions; ++k) {
    std::vector<StudyTrial> trials;
    for (int s = 0; s < 8; ++s) {
      // the subject answers the conditions differently, in no direction on the average
      const double effect = NormalDraw(engine);
      for (int repeat = 0; repeat < 3; ++repeat) {
        trials.push_back(Answered(s, "a", repeat, 50 + effect + 0.35 * NormalDraw(engine)));
        trials.push_back(Answered(s, "b", repeat, 50 + 0.35 * NormalDraw(engine)));
      }
    }
    const StudyTable table = MakeStudyTable(std::move(trials), {});
    const auto contrasts = CompareConditions(table, {{"a", "b"}});
    ASSERT_EQ(contrasts->at(0).difference.n, 8U);
    found += contrasts->at(0).difference.test->p < 0.05 ? 1 : 0;
  }
  EXPECT_ABS(static_cast<double>(found) / kRepetitions, 0.05, 0.021,
             "three standard deviations; 24 pairs taken for independent give 0.24");
}

// 8 subjects, 3 trials a cell, with factors and scatter of 5 %
std::vector<StudyTrial> FullStudy(int conditions = 4, std::uint32_t seed = 3,
                                  double scatter = 0.05) {
  std::mt19937 engine(seed);
  std::vector<StudyTrial> trials;
  for (int s = 0; s < 8; ++s) {
    for (int c = 0; c < conditions; ++c) {
      const double cell = 20e-6 * (c + 1) * std::exp(0.2 * NormalDraw(engine) / 2);
      for (int repeat = 1; repeat <= 3; ++repeat) {
        trials.push_back(Answered(s, std::string(1, static_cast<char>('a' + c)), repeat,
                                  cell * std::exp(scatter * NormalDraw(engine))));
      }
    }
  }
  return trials;
}

TEST(FindOutlying, NamesTrialsAndCellsThatStandApartAndKeepsThem) {
  std::vector<StudyTrial> trials = FullStudy();
  EXPECT_TRUE(FindOutlying(MakeStudyTable(trials, {})).empty());
  *trials[7].rms_m *= 2;                                                // subject 0, c, repeat 2
  for (std::size_t i = 12 + 3; i < 12 + 6; ++i) *trials[i].rms_m *= 5;  // subject 1, b
  const StudyTable table = MakeStudyTable(trials, {});
  const auto outlying = FindOutlying(table);
  ASSERT_EQ(outlying.size(), 2U);
  EXPECT_EQ(outlying[0].file, "0_c_2");
  EXPECT_ABS(outlying[0].times, 2.0, 0.4, "scatter of 5 % in the cell");
  EXPECT_EQ(outlying[1].file, "");
  EXPECT_EQ(outlying[1].subject, "1");
  EXPECT_EQ(outlying[1].condition, "b");
  EXPECT_EQ(table.cells[0][2].rms_m.size(), 3U) << "it counts";
}

// the stated 5 %, of 8 subjects x 4 conditions x 3 repeats, of subjects that answer differently;
// and one trial 30 % too large or too small
TEST(FindOutlying, FalseAlarmsAreAsStatedAndThirtyPercentAreFound) {
  const int studies = tests::Repetitions(tests::kIsSanitized ? 20 : 400);
  for (const double scatter : {0.03, 0.04, 0.05}) {
    int alarms = 0;
    int found = 0;
    for (int k = 1; k <= studies; ++k) {
      std::vector<StudyTrial> trials = FullStudy(4, static_cast<std::uint32_t>(k), scatter);
      alarms += FindOutlying(MakeStudyTable(trials, {})).empty() ? 0 : 1;
      StudyTrial& wrong = trials[static_cast<std::size_t>(k) % trials.size()];
      *wrong.rms_m *= k % 2 == 0 ? 1.3 : 0.7;
      const auto outlying = FindOutlying(MakeStudyTable(trials, {}));
      found += std::ranges::count(outlying, wrong.file, &Outlying::file) > 0 ? 1 : 0;
    }
    fmt::print("scatter {:.0f} %: false alarms in {} of {} studies, found in {}\n", 100 * scatter,
               alarms, studies, found);
    const double three = 3 * std::sqrt(0.05 * 0.95 / studies);
    EXPECT_LE(alarms, studies * (0.05 + three)) << scatter;
    EXPECT_GE(found, studies * (scatter < 0.045 ? 0.9 : 0.75)) << scatter;
  }
}

TEST(FindOutlying, AFewPercentAreNoNewsHoweverCloselyRepeatsAgree) {
  std::vector<StudyTrial> trials;
  for (int s = 0; s < 4; ++s) {
    for (const char* condition : {"a", "b", "c"}) {
      for (int repeat = 1; repeat <= 3; ++repeat) {
        trials.push_back(Answered(s, condition, repeat, 20e-6 * (1 + 1e-4 * repeat)));
      }
    }
  }
  *trials[4].rms_m *= 1.03;
  for (std::size_t i = 9; i < 12; ++i) *trials[i].rms_m *= 1.03;
  EXPECT_TRUE(FindOutlying(MakeStudyTable(trials, {})).empty());
  *trials[4].rms_m *= 1.04;
  ASSERT_EQ(FindOutlying(MakeStudyTable(trials, {})).size(), 1U) << "7 % of a scatter of 1 %";
  trials[4].rms_uncertainty_m = 0.02 * *trials[4].rms_m;
  EXPECT_TRUE(FindOutlying(MakeStudyTable(trials, {})).empty()) << "7 % of 2 % uncertainty";
}

TEST(FindDeviations, NamesEachOnceWithItsTrials) {
  std::vector<StudyTrial> trials = FullStudy();
  trials.resize(3);
  for (StudyTrial& trial : trials) trial.findings.Note(StudyFinding::kNoNoiseCorrection);
  trials[1].findings.Note(StudyFinding::kOrderLowered, {{"order", 4}});
  trials[2].findings.Note(StudyFinding::kOrderLowered, {{"order", 2}});
  StudyResult study;
  study.table = MakeStudyTable(trials, {});
  const auto deviations = FindDeviations(study.table.trials);
  ASSERT_EQ(deviations.size(), 3U) << "another order is another deviation";
  EXPECT_EQ(deviations[0].finding.kind, StudyFinding::kNoNoiseCorrection);
  EXPECT_EQ(deviations[0].files.size(), 3U);
  EXPECT_THAT(deviations[1].files, ElementsAre("0_a_2"));
  const auto exceptions = ExceptionsOf(study);
  EXPECT_EQ(exceptions.list()[0].subject, "") << "all of them";
  EXPECT_EQ(exceptions.list()[1].subject, "0_a_2");
  const std::string text =
      document::Fill(SentenceOf(StudyFinding::kOrderLowered).text, exceptions.list()[1].numbers);
  EXPECT_THAT(text, HasSubstr("filter of order 4"));
  EXPECT_THAT(text, HasSubstr(", 1 of 3 trials"));
}

TEST(DescribeFurther, FindsATrendOverRepeatsOrStarts) {
  std::vector<StudyTrial> trials;
  for (int s = 0; s < 3; ++s) {
    for (const std::string condition : {"a", "b"}) {
      for (int repeat = 1; repeat <= 10; repeat += 3) {
        // 1, 4, 7, 10 are places 0 to 3; subjects grow by 1, 2 and 3 % a place
        const double rms_m = 20e-6 * std::exp(0.01 * (s + 1) * (repeat - 1) / 3.0);
        trials.push_back(Answered(s, condition, repeat, condition == "a" ? rms_m : 3 * rms_m));
      }
    }
  }
  const FurtherStatistics further = DescribeFurther(MakeStudyTable(trials, {}));
  ASSERT_TRUE(further.trend);
  EXPECT_FALSE(further.trend->by_start);
  EXPECT_REL(further.trend->per_trial.mean, 0.02, 1e-12, "logarithms of about 10");
  EXPECT_REL(*further.trend->per_trial.standard_deviation, 0.01, 1e-12, "logarithms of about 10");

  // by their starts, backwards and the conditions one after the other
  for (std::size_t i = 0; i < trials.size(); ++i) {
    trials[i].utc_start = fmt::format("2026-03-01T12:00:{:02}Z", trials.size() - i);
  }
  const FurtherStatistics started = DescribeFurther(MakeStudyTable(trials, {}));
  EXPECT_TRUE(started.trend->by_start);
  EXPECT_REL(started.trend->per_trial.mean, -0.02, 1e-12, "logarithms of about 10");
}

TEST(MakeStudyTable, NumbersRepeatsAndRefusesTheSameTwice) {
  std::vector<StudyTrial> trials{Answered(1, "a", 2, 1e-6), Answered(1, "a", 2, 1e-6),
                                 Answered(1, "a", 9, 1e-6)};
  trials[2].repeat = "";
  const StudyTable table = MakeStudyTable(trials, {"z", "a"});
  EXPECT_EQ(table.trials[2].repeat, "1");
  ASSERT_TRUE(table.trials[1].error);
  EXPECT_THAT(table.trials[1].error->Text(), HasSubstr("second repeat 2 of subject 1 in a"));
  EXPECT_THAT(table.conditions, ElementsAre("a"));
  EXPECT_EQ(table.cells[0][0].trials.size(), 2U);
}

TextTable MatchingTable(const std::vector<std::vector<std::string>>& rows) {
  TextTable table;
  table.name = "m.csv";
  const std::vector<std::string> names{"reference_v", "condition", "subject", "matched_v",
                                       "started"};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t i = 0; i < names.size(); ++i) table.columns[names[i]].push_back(rows[r][i]);
    table.lines.push_back(r + 2);
  }
  return table;
}

// values of `treatment` and `control` of a subject each, as a study that was analysed
StudyResult StudyOf(const std::vector<double>& treatment, const std::vector<double>& control) {
  std::vector<StudyTrial> trials;
  for (std::size_t s = 0; s < treatment.size(); ++s) {
    trials.push_back(Answered(static_cast<int>(s), "a", 1, treatment[s]));
  }
  for (std::size_t s = 0; s < control.size(); ++s) {
    trials.push_back(Answered(static_cast<int>(s), "b", 1, control[s]));
  }
  StudyResult study;
  study.table = MakeStudyTable(std::move(trials), {});
  EXPECT_TRUE(study.Compare({{"a", "b"}}));
  return study;
}

TEST(CompareConditions, RefusesAPairTwiceInEitherOrder) {
  const StudyTable table = MakeStudyTable(FullStudy(3), {});
  for (const PlannedContrast& again : {PlannedContrast{"a", "b"}, PlannedContrast{"b", "a"}}) {
    const auto contrasts = CompareConditions(table, {{"a", "b"}, {"a", "c"}, again});
    ASSERT_FALSE(contrasts) << "Holm's correction would count it twice";
    EXPECT_EQ(
        contrasts.error().Text(),
        NameOf(again) + ": is a pair of conditions that is planned twice; write each pair once");
  }
}

// the methods state no test that was not made, and count those that were
TEST(MethodsText, NamesTestedAndUntestedContrasts) {
  const std::string alone = MethodsText(StudyOf({2e-5}, {1e-5}), {});
  EXPECT_THAT(alone, Not(HasSubstr("paired t")));
  EXPECT_THAT(alone, HasSubstr("Not tested, as of fewer than 2 subjects or without scatter over "
                               "them: a against b. "));
  std::vector<StudyTrial> trials = FullStudy(3);
  // one subject has the third condition
  std::erase_if(trials, [](const StudyTrial& trial) {
    return trial.condition == "c" && trial.subject != "1";
  });
  StudyResult study;
  study.table = MakeStudyTable(std::move(trials), {});
  ASSERT_TRUE(study.Compare({}));
  const std::string methods = MethodsText(study, {});
  EXPECT_THAT(methods, HasSubstr("Conditions against the first, unplanned (b against a) were"));
  EXPECT_THAT(methods, HasSubstr("Holm's method over 1 test. "));
  EXPECT_THAT(methods, HasSubstr("over them: c against a. "));
}

// a mean of 2 with a standard uncertainty of 1: t(2) = 2 < 4.3, so that the ratio may be anything
TEST(StudyDocument, StatesWhyARatioOfMeansHasNoInterval) {
  const double spread = std::sqrt(3.0);
  const auto text = [](const std::vector<double>& control) {
    return TextOf(StudyDocument(StudyOf({5e-6, 5.1e-6, 5.2e-6}, control), false));
  };
  EXPECT_THAT(
      text({(2 - spread) * 1e-6, 2e-6, (2 + spread) * 1e-6}),
      ContainsRegex("ratio of means +2.55, 95 %, by Fieller: unbounded, the control's mean"));
  EXPECT_THAT(text({2e-6, 2.01e-6, 2.02e-6}), Not(HasSubstr("unbounded")));
}

TEST(StudyDocument, StatesWhyRepeatsAreNotAssessed) {
  const auto text = [](std::vector<StudyTrial> trials) {
    StudyResult study;
    study.table = MakeStudyTable(std::move(trials), {});
    EXPECT_TRUE(study.Compare({}));
    return TextOf(StudyDocument(study, false));
  };
  std::vector<StudyTrial> trials = FullStudy(2);
  EXPECT_THAT(text(trials), Not(HasSubstr("ICC and variation within cells not determined")));
  trials.pop_back();  // of condition b
  EXPECT_THAT(text(trials), HasSubstr("note: b: ICC and variation within cells not determined"));
  std::erase_if(trials, [](const StudyTrial& trial) { return trial.repeat != "1"; });
  EXPECT_THAT(text(trials), Not(HasSubstr("within cells not determined"))) << "nothing to assess";
}

// one name in two encodings looks alike on every page
TEST(LikenessOf, IsOfAccentsAndTheirEncoding) {
  const std::string composed = "J\u00f6rg";
  for (const std::string other : {"Jo\u0308rg", "Jorg", "J\u00d6RG", "jo\u0308 rg"}) {
    EXPECT_EQ(LikenessOf(composed, other), Likeness::kAccents) << other;
    EXPECT_EQ(LikenessOf(other, composed), Likeness::kAccents) << other;
  }
  EXPECT_EQ(LikenessOf("\u0160imon", "Simon"), Likeness::kAccents);
  EXPECT_EQ(LikenessOf("rig\u00a0a", "rig a"), Likeness::kSpelling);
  EXPECT_EQ(LikenessOf("J\u00f6rg", "J\u00fcrg"), Likeness::kNone) << "other letters";
  EXPECT_EQ(LikenessOf("\u03b1", "\u03b2"), Likeness::kNone);
  EXPECT_EQ(LikenessOf("\u00d7", "\u00f7"), Likeness::kNone) << "no letters";
  EXPECT_EQ(WordsOf(Likeness::kAccents), "case, accents or their encoding");
}

TEST(AnalyzeMatching, AveragesTheStartsAndNamesMissingHalves) {
  const auto result = AnalyzeMatching(MatchingTable({{"2", "ia", "p", "1.6", "high"},
                                                     {"2", "ia", "p", "0.9", "low"},
                                                     {"2", "ia", "q", "1.5", "high"},
                                                     {"4", "ia", "p", "2", "high"},
                                                     {"4", "ia", "p", "2", "low"}}),
                                      {});
  ASSERT_TRUE(result);
  const MatchedCondition& ia = result->conditions.at(0);
  // p: sqrt(1.6 x 0.9) / 2 = 0.6, q: 0.75
  EXPECT_REL(ia.levels.at(0).ratio.ratio(), std::sqrt(0.6 * 0.75), 1e-15, "rounding");
  // p over both levels: sqrt(0.6 x 0.5)
  EXPECT_REL(ia.overall.ratio(), std::sqrt(std::sqrt(0.6 * 0.5) * 0.75), 1e-15, "rounding");
  EXPECT_FALSE(ia.levels.at(1).ratio.log_ratio.test);
  ASSERT_EQ(result->missing.size(), 2U);
  EXPECT_EQ(result->missing[0].subject, "q");
  EXPECT_EQ(result->missing[0].reference_v, 2);
  EXPECT_EQ(result->missing[0].started, "low");
  EXPECT_EQ(result->missing[1].reference_v, 4);
  EXPECT_EQ(result->missing[1].started, "") << "no setting at all";
  const std::string text = TextOf(MatchingDocument(*result, false));
  EXPECT_THAT(text, HasSubstr("note: subject q, ia at 2 V: no setting started low"));
  EXPECT_THAT(text, HasSubstr("note: subject q, ia at 4 V: no setting\n"));
}

TEST(AnalyzeMatching, RefusesImpossibleLines) {
  EXPECT_THAT(AnalyzeMatching(MatchingTable({{"2", "a", "p", "0", "low"}}), {}).error().Text(),
              HasSubstr("m.csv:2: has a voltage that is not above 0"));
  EXPECT_THAT(AnalyzeMatching(MatchingTable({{"2", "a", "p", "1", "up"}}), {}).error().Text(),
              HasSubstr("started 'up'; write high or low"));
  EXPECT_THAT(AnalyzeMatching(MatchingTable({{"2", "a", "p", "1V", "low"}}), {}).error().Text(),
              HasSubstr("matched_v '1V' is not a number"));
}

TEST(AnalyzeMatching, ContrastsWithinSubjectsWhereBothHaveALevel) {
  const auto table = MatchingTable({{"1", "stock", "p", "1.1", "low"},
                                    {"1", "stock", "q", "0.9", "low"},
                                    {"2", "stock", "p", "2", "low"},
                                    {"1", "ia", "p", "0.55", "low"},
                                    {"1", "ia", "q", "0.72", "low"},
                                    {"4", "ia", "q", "4", "low"},
                                    {"1", "ia", "r", "0.5", "low"}});
  const auto result = AnalyzeMatching(table, {{"ia", "stock"}});
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->planned);
  const MatchedContrast& contrast = result->contrasts.at(0);
  EXPECT_THAT(contrast.left_out, ElementsAre("r"));
  ASSERT_EQ(contrast.levels.size(), 1U) << "2 V and 4 V are in one condition only";
  // p: 0.55/1.1, q: 0.72/0.9
  EXPECT_REL(contrast.levels[0].ratio(), std::sqrt(0.5 * 0.8), 1e-15, "rounding");
  EXPECT_REL(contrast.overall->ratio(), std::sqrt(0.5 * 0.8), 1e-15, "rounding");
  EXPECT_EQ(contrast.overall->p_holm, contrast.overall->log_ratio.test->p) << "one contrast";
  EXPECT_THAT(TextOf(MatchingDocument(*result, false)),
              HasSubstr("ia against stock: their matched voltages"));

  const auto unplanned = AnalyzeMatching(table, {});
  EXPECT_THAT(
      TextOf(MatchingDocument(*unplanned, false)),
      HasSubstr("no contrast is planned, so every condition is compared with the first, stock"));
  EXPECT_THAT(AnalyzeMatching(table, {{"ib", "stock"}}).error().Text(),
              HasSubstr("did you mean ia?"));
}

TEST(AnalyzeMatching, ContrastOfNobodyHasNoNumbers) {
  const auto result = AnalyzeMatching(
      MatchingTable({{"1", "a", "p", "1", "low"}, {"1", "b", "q", "1", "low"}}), {{"b", "a"}});
  EXPECT_FALSE(result->contrasts.at(0).overall);
  const document::Document document = MatchingDocument(*result, false);
  EXPECT_THAT(document::JsonOf(document), HasSubstr("\"overall\": null"));
  EXPECT_THAT(TextOf(document), HasSubstr("without subject  p, q, no level in both"));
  EXPECT_THAT(TextOf(document), HasSubstr("not answered: b against a: not tested: 0 subjects"));
}

TEST(AnalyzeMatching, CoversReductionAndPowerSaving) {
  std::mt19937 engine(65);
  int held = 0;
  constexpr int kRepetitions = 2000;
  for (int k = 0; k < kRepetitions; ++k) {
    std::vector<std::vector<std::string>> rows;
    for (int s = 0; s < 8; ++s) {
      const double log = std::log(0.65) + 0.1 * NormalDraw(engine);
      rows.push_back(
          {"2", "ia", fmt::format("{}", s), fmt::format("{}", 2 * std::exp(log)), "low"});
    }
    const auto interval =
        AnalyzeMatching(MatchingTable(rows), {})->conditions[0].overall.ratio_interval();
    // reduction and power saving fall with the ratio, so they are held as often
    held += interval->lower <= 0.65 && 0.65 <= interval->upper ? 1 : 0;
  }
  EXPECT_ABS(static_cast<double>(held) / kRepetitions, 0.95, 0.02, "the bar");
}

TEST(AnalyzeLinearity, FindsThatSubjectsBendAlike) {
  std::vector<DriveReading> readings;
  for (int subject = 0; subject < 4; ++subject) {
    for (const double v : {1.0, 2.0, 3.0, 4.0, 5.0}) {
      // each its own slope, the same bend to 10 %
      const double bend = -1e-7 * (0.9 + subject / 15.0);
      readings.push_back(
          {std::to_string(subject), "a", v, (8e-6 + 1e-6 * subject) * v + bend * v * v});
    }
  }
  for (const double v : {1.0, 2.0, 3.0}) readings.push_back({"9", "b", v, 1e-6 * v});
  const LinearityResult result = AnalyzeLinearity(readings, 0.0);
  const dsp::Curvature& first = result.lines.at(0).curvature.value();
  EXPECT_REL(first.quadratic, -0.9e-7, 1e-9, "rounding of 40 um over a bend of 2 um");
  EXPECT_EQ(first.df, 2);
  const dsp::OneSample& over = result.slopes.at(0).curvature_m_per_v2.value();
  EXPECT_EQ(over.n, 4U);
  EXPECT_REL(over.mean, -1e-7, 1e-9, "rounding of 40 um over a bend of 2 um");
  EXPECT_LT(over.test->p, 1e-3);
  const document::Document document = LinearityDocument(result, false);
  // the standard deviation of the bends is 0.1 / 15 sqrt(5/3) um/V^2, over sqrt(4)
  EXPECT_THAT(TextOf(document),
              HasSubstr("curvature  -0.1000(43) um/V^2; 95 %: -0.1137 to -0.0863"));
  EXPECT_THAT(TextOf(document),
              ContainsRegex("b, subject 9\n(    .*\n)*    note: curvature not determined"));
  EXPECT_THAT(document::JsonOf(document), HasSubstr("\"curvature_p\": null"));
}

TEST(AnalyzeLinearity, SortsSubjectsByNumberAndNamesThoseAlike) {
  std::vector<DriveReading> readings;
  for (const char* subject : {"s10", "s2", "S2"}) {
    for (int v = 1; v <= 4; ++v) readings.push_back({subject, "a", 1.0 * v, 1e-5 * v});
  }
  const LinearityResult result = AnalyzeLinearity(readings, 1e-7);
  ASSERT_EQ(result.lines.size(), 3U);
  EXPECT_EQ(result.lines[1].subject, "s2");
  EXPECT_EQ(result.lines[2].subject, "s10");
  EXPECT_THAT(TextOf(LinearityDocument(result, false)),
              HasSubstr("doubt: the subjects S2 and s2 differ by case, blanks or zeros in front"));
}

TEST(AnalyzeLinearity, SubtractsTheFloorInPower) {
  std::vector<DriveReading> readings{{"", "", 0, 3e-6}, {"", "", 0.1, 2e-6}};
  for (const double v : {1.0, 2.0, 3.0})
    readings.push_back({"", "", v, std::hypot(8e-6 * v, 3e-6)});
  const LinearityResult own = AnalyzeLinearity(readings, std::nullopt);
  const DriveLine& line = own.lines.at(0);
  EXPECT_EQ(line.below_floor, 1U);
  EXPECT_REL(line.line->slope, 8e-6, 1e-14, "rounding");
  EXPECT_ABS(line.line->intercept, 0, 1e-19, "rounding of 24 um");
  EXPECT_LT(line.line->largest_deviation, 1e-19);
  // without the floor's removal the same readings bend
  const LinearityResult bent = AnalyzeLinearity(readings, 0.0);
  EXPECT_GT(bent.lines.at(0).line->largest_deviation, 1e-7);
  const std::string text = TextOf(LinearityDocument(own, false));
  EXPECT_THAT(text, HasSubstr("noise correction             3 um, RMS, subtracted in mean square"));
  EXPECT_THAT(text, HasSubstr("1 reading below the noise floor: excluded"));
  EXPECT_THAT(text, ContainsRegex("RMS at 0 V +-?0[.0]*(\\(1\\))? um")) << "rounding";
  EXPECT_THAT(text, Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace haptometer::tools
