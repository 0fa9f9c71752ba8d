#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/study/contrast.h"
#include "tools/study/further_statistics.h"
#include "tools/study/linearity_result.h"
#include "tools/study/manifest.h"
#include "tools/study/matching_result.h"
#include "tools/study/study_quality.h"
#include "tools/study/trial_files.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

Outcome Study(const std::vector<std::string>& words) { return Captured(RunStudy, "study", words); }

std::string ContentOf(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

class StudyVerb : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }

  std::string Write(const std::string& name, const std::string& content) const {
    std::ofstream file(directory_ / name);
    file << content;
    return directory_ / name;
  }

  // `rms_um` at 250 Hz on 1 mm, 1.2 s at 2 kHz: whole periods are whole samples
  std::string Trial(const std::string& name, double rms_um, const std::string& labels = "") const {
    std::ostringstream text;
    text.precision(9);
    text << labels << "time_s,displacement_um\n";
    for (int k = 0; k < 2400; ++k) {
      const double t_s = k / 2000.0;
      text << t_s << ','
           << 1000 + rms_um * std::numbers::sqrt2 * std::sin(2 * std::numbers::pi * 250 * t_s)
           << '\n';
    }
    return Write(name, text.str());
  }

  // 3 subjects x 2 conditions x 1 repeat, named by a pattern: 10, 11 and 12 um, and twice to 2.2
  // times that
  void WriteNamedTrials() const {
    for (int s = 0; s < 3; ++s) {
      static_cast<void>(Trial(fmt::format("s{}_a.csv", s + 9), 10 + s));
      static_cast<void>(Trial(fmt::format("s{}_b.csv", s + 9), (10 + s) * (2 + 0.1 * s)));
    }
  }

  [[nodiscard]] std::string directory() const { return directory_; }

  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("study_test_" + std::to_string(::getpid()));
};

TEST_F(StudyVerb, ComparesConditionsNamedByAPattern) {
  WriteNamedTrials();
  const Outcome outcome =
      Study({directory(), "--pattern", "s{subject}_{condition}", "--contrast", "b:a", "--all"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, HasSubstr("6 trials, 3 subjects, 2 conditions"));
  EXPECT_THAT(outcome.out, HasSubstr("b against a, n = 3 subjects"));
  // (2 x 2.1 x 2.2)^(1/3)
  EXPECT_THAT(outcome.out, HasSubstr("ratio           2.098 (95 % CI"));
  EXPECT_THAT(outcome.out, HasSubstr("t(2) ="));
  // 10, 12.1, 14.4 um
  EXPECT_THAT(outcome.out, HasSubstr("difference      12.17 um (95 % CI"));
  EXPECT_THAT(outcome.out, HasSubstr("sign flips      p = 0.25"));
  EXPECT_THAT(outcome.out, HasSubstr("F(1, 2) ="));
}

TEST_F(StudyVerb, JsonKeepsItsNamesAndVerifiesItself) {
  WriteNamedTrials();
  const std::vector<std::string> words{directory(), "--pattern", "s{subject}_{condition}"};
  std::vector<std::string> with_json = words;
  with_json.emplace_back("--json");
  const Outcome outcome = Study(with_json);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json document = Json::parse(outcome.out);
  EXPECT_EQ(document["subjects"], Json({"9", "10", "11"})) << "9 before 10";
  EXPECT_EQ(document["contrasts_planned"], false);
  const Json& contrast = document["contrasts"].at(0);
  EXPECT_EQ(contrast["treatment"], "b");
  EXPECT_EQ(contrast["n"], 3);
  EXPECT_REL(contrast["ratio"].get<double>(), std::cbrt(2 * 2.1 * 2.2), 1e-5, "printed digits");
  EXPECT_REL(contrast["mean_difference_m"].get<double>(), 36.5e-6 / 3, 1e-5, "printed digits");
  EXPECT_TRUE(document["trials"].at(0)["reasons"].empty());
  EXPECT_TRUE(document["conditions"].at(0)["icc"].is_null()) << "one repeat";

  std::vector<std::string> verify = words;
  verify.insert(verify.end(), {"--verify", Write("r.json", outcome.out)});
  const Outcome same = Study(verify);
  EXPECT_EQ(same.status, 0) << same.err;
  EXPECT_THAT(same.err, HasSubstr("every number is the same again"));
  Json changed = document;
  changed["contrasts"][0]["ratio"] = 2.5;
  changed["trials"][2]["gone"] = 1;
  Write("r.json", changed.dump());
  const Outcome differs = Study(verify);
  EXPECT_EQ(differs.status, 1);
  EXPECT_THAT(differs.err, HasSubstr("/contrasts/0/ratio was 2.5, is 2.0"));
  EXPECT_THAT(differs.err, HasSubstr("/trials/2/gone is gone"));
  Write("r.json", "{");
  EXPECT_THAT(Study(verify).err, HasSubstr("is no JSON document"));
}

TEST_F(StudyVerb, NamesWhatIsMissingAndAnswersTheRest) {
  WriteNamedTrials();
  fs::remove(directory_ / "s9_a.csv");
  Write("s9_a.csv", "nothing\n");
  Trial("other.csv", 5);
  const Outcome outcome = Study({directory(), "--pattern", "s{subject}_{condition}"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("other.csv: has a name that does not fit the pattern"));
  EXPECT_THAT(outcome.err, HasSubstr("s9_a.csv: "));
  EXPECT_THAT(outcome.out, HasSubstr("b against a, n = 2 subjects"));
  EXPECT_THAT(outcome.out, HasSubstr("without         subject 9: one of the two is missing"));
  EXPECT_THAT(outcome.out, HasSubstr("subject 9 in a: 0 of 1 trials"));
  EXPECT_THAT(outcome.out, HasSubstr("no contrast was planned: every condition against a"));
}

TEST_F(StudyVerb, TakesLabelsFromTheFilesAndSaysWhereTheyLack) {
  Trial("1.csv", 10, "# label.subject = x\n# label.condition = a\n");
  Trial("2.csv", 10, "# label.subject = x\n");
  const Outcome outcome = Study({directory()});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("2.csv: has no label condition; say haptometer trial label"));
  EXPECT_THAT(outcome.out, HasSubstr("2 trials, 1 subjects, 1 conditions"));
}

TEST_F(StudyVerb, WritesTablesAndTheParagraph) {
  WriteNamedTrials();
  Write("study.toml",
        "conditions = [\"b\", \"a\"]\ncontrasts = [[\"b\", \"a\"]]\nband = \"30-600Hz\"\n"
        "pattern = \"s{subject}_{condition}\"\n[[trials]]\nfiles = \"s*_a.csv\"\n"
        "[[trials]]\nfiles = \"s*_b.csv\"\nrepeat = \"7\"\n");
  const std::vector<std::string> words{
      directory_ / "study.toml", "--table",   directory_ / "long.csv",  "--wide",
      directory_ / "wide.csv",   "--methods", directory_ / "methods.md"};
  const Outcome outcome = Study(words);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(ContentOf(directory_ / "long.csv"), HasSubstr("\n9,b,7,1.9999"));
  EXPECT_THAT(ContentOf(directory_ / "wide.csv"),
              HasSubstr("subject,b_mean_m,b_trials,a_mean_m,a_trials\n9,"));
  const std::string methods = ContentOf(directory_ / "methods.md");
  EXPECT_THAT(methods, HasSubstr("from 30 to 600 Hz"));
  EXPECT_THAT(methods, HasSubstr("Planned contrasts (b against a)"));
  EXPECT_THAT(methods, HasSubstr("The unit of analysis was the subject"));
  const Outcome again = Study(words);
  EXPECT_EQ(again.status, 2);
  EXPECT_THAT(again.err, HasSubstr("already exists; name another file, or say --overwrite"));
}

TEST_F(StudyVerb, DrawsAPanelAContrast) {
  WriteNamedTrials();
  const fs::path plot = directory_ / "study.svg";
  const Outcome outcome =
      Study({directory(), "--pattern", "s{subject}_{condition}", "--plot", plot});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string svg = ContentOf(plot);
  EXPECT_THAT(svg, HasSubstr("b against a: mean and standard deviation over subjects"));
  EXPECT_THAT(svg, HasSubstr("RMS displacement / um"));
}

TEST_F(StudyVerb, RefusesWhatIsWrong) {
  WriteNamedTrials();
  const std::string pattern = "s{subject}_{condition}";
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{directory(), "--contrast", "ia1"}, "'ia1' is no pair of conditions"},
      {{directory(), "--contrast", "a:a"}, "'a:a' is no pair of conditions"},
      {{directory(), "--pattern", "{who}"}, "{who} is not a label"},
      {{directory(), "--pattern", "{subject}{subject}"}, "stands in it twice"},
      {{directory(), "--pattern", "x"}, "holds no label"},
      {{directory(), "--pattern", pattern, "--contrast", "bb:a"}, "did you mean b?"},
      {{directory(), "--band", "5-2Hz"}, ""},
      {{directory_ / "s9_a.csv"}, "is neither a folder nor a manifest"},
      {{Write("a.toml", "contrast = []\n")}, "did you mean contrasts?"},
      {{Write("b.toml", "contrasts = [[\"a\"]]\n")}, "something else than pairs"},
      {{Write("c.toml", "conditions = [1]\n")}, "is not a list of texts"},
      {{Write("d.toml", "contrasts = [\"a\"]\n")}, "is not a list of lists of texts"},
      {{Write("e.toml", "[[trials]]\nsubject = \"1\"\n")}, "files: is missing"},
      {{Write("f.toml", "order = 12\n[[trials]]\nfiles = \"s9_a.csv\"\n")}, "outside 1 to 8"},
  };
  for (const auto& [words, message] : cases) {
    const Outcome outcome = Study(words);
    EXPECT_EQ(outcome.status, 2) << words.back();
    EXPECT_THAT(outcome.err, HasSubstr(message));
  }
  EXPECT_EQ(Study({Write("g.toml", "[[trials]]\nfiles = \"none*\"\n")}).status, 3);
}

TEST(LabelsOf, MatchesNamesAndFolders) {
  const auto labels = LabelsOf("data/s10/ia1_2.csv", "{subject}/{condition}_{repeat}");
  ASSERT_TRUE(labels);
  EXPECT_EQ(labels->at("subject"), "s10");
  EXPECT_EQ(labels->at("condition"), "ia1");
  EXPECT_EQ(labels->at("repeat"), "2");
  EXPECT_EQ(LabelsOf("x/p(1)+a.bin", "p({subject})+{condition}")->at("subject"), "1");
  const auto least = LabelsOf("s1_ia1_big_2.csv", "{subject}_{condition}_{repeat}");
  EXPECT_EQ(least->at("subject"), "s1") << "a label takes as little as it can";
  EXPECT_EQ(least->at("repeat"), "big_2");
  EXPECT_FALSE(LabelsOf("ia1.csv", "{condition}_{repeat}"));
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

// 8 x 4 x 3 trials with factors and scatter of 5 %
std::vector<StudyTrial> FullStudy() {
  std::mt19937 engine(3);
  std::vector<StudyTrial> trials;
  for (int s = 0; s < 8; ++s) {
    for (int c = 0; c < 4; ++c) {
      const double cell = 20e-6 * (c + 1) * std::exp(0.2 * NormalDraw(engine) / 2);
      for (int repeat = 1; repeat <= 3; ++repeat) {
        trials.push_back(Answered(s, std::string(1, static_cast<char>('a' + c)), repeat,
                                  cell * std::exp(0.05 * NormalDraw(engine))));
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

TEST(AnalyzeMatching, AveragesTheStartsAndNamesMissingHalves) {
  const auto result = AnalyzeMatching(MatchingTable({{"2", "ia", "p", "1.6", "high"},
                                                     {"2", "ia", "p", "0.9", "low"},
                                                     {"2", "ia", "q", "1.5", "high"},
                                                     {"4", "ia", "p", "2", "high"},
                                                     {"4", "ia", "p", "2", "low"}}));
  ASSERT_TRUE(result);
  const MatchedCondition& ia = result->conditions.at(0);
  // p: sqrt(1.6 x 0.9) / 2 = 0.6, q: 0.75
  EXPECT_REL(ia.levels.at(0).ratio(), std::sqrt(0.6 * 0.75), 1e-15, "rounding");
  // p over both levels: sqrt(0.6 x 0.5)
  EXPECT_REL(ia.overall.ratio(), std::sqrt(std::sqrt(0.6 * 0.5) * 0.75), 1e-15, "rounding");
  EXPECT_FALSE(ia.levels.at(1).log_ratio.test);
  EXPECT_THAT(result->missing,
              ElementsAre("subject q, ia at 2 V: none started low; the other counts by itself",
                          "subject q, ia at 4 V: no setting"));
  EXPECT_THAT(MatchingText(*result), HasSubstr("not tested"));
}

TEST(AnalyzeMatching, RefusesImpossibleLines) {
  EXPECT_THAT(AnalyzeMatching(MatchingTable({{"2", "a", "p", "0", "low"}})).error().Text(),
              HasSubstr("m.csv:2: has a voltage that is not above 0"));
  EXPECT_THAT(AnalyzeMatching(MatchingTable({{"2", "a", "p", "1", "up"}})).error().Text(),
              HasSubstr("started 'up'; write high or low"));
  EXPECT_THAT(AnalyzeMatching(MatchingTable({{"2", "a", "p", "1V", "low"}})).error().Text(),
              HasSubstr("matched_v '1V' is no number"));
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
        AnalyzeMatching(MatchingTable(rows))->conditions[0].overall.ratio_interval();
    // reduction and power saving fall with the ratio, so they are held as often
    held += interval->lower <= 0.65 && 0.65 <= interval->upper ? 1 : 0;
  }
  EXPECT_ABS(static_cast<double>(held) / kRepetitions, 0.95, 0.02, "the bar");
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
  EXPECT_THAT(LinearityText(own), HasSubstr("floor         3 um, subtracted in power"));
  EXPECT_THAT(LinearityText(own), Not(HasSubstr("nan")));
}

TEST_F(StudyVerb, ReadsSweepsFromTablesAndTrials) {
  const std::string table =
      Write("sweep.csv", "drive_v,rms_m\n1,8e-6\n2,16e-6\n3,24.3e-6\n4,32e-6\n");
  const Outcome outcome = Study({"linearity", table, "--plot", directory_ / "l.svg"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("floor         not known"));
  EXPECT_TRUE(fs::exists(directory_ / "l.svg"));
  const std::string told = Trial("t.csv", 8, "# drive_amplitude_v = 1\n");
  const std::string untold = Trial("u.csv", 8);
  const Outcome trials = Study({"linearity", told, untold, "--json"});
  EXPECT_EQ(trials.status, 3);
  EXPECT_THAT(trials.err, HasSubstr("u.csv: does not say its drive_amplitude_v"));
  const Json line = Json::parse(trials.out)["lines"].at(0);
  EXPECT_EQ(line["readings"], 1);
  EXPECT_TRUE(line["slope_m_per_v"].is_null());
}

TEST_F(StudyVerb, MatchingSaysWhichColumnIsMissing) {
  const Outcome outcome = Study(
      {"matching", Write("m.csv", "reference_v,condition,subject,matched,started\n1,a,b,1,low\n")});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("has no column matched_v; is it the column matched?"));
  const Outcome fixture = Study({"matching", std::string(HAPTOMETER_FIXTURES) + "/matching.csv",
                                 "--plot", directory_ / "m.svg"});
  EXPECT_EQ(fixture.status, 0) << fixture.err;
  EXPECT_THAT(ContentOf(directory_ / "m.svg"), HasSubstr("matched / V"));
}

}  // namespace
}  // namespace haptometer::tools
