#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/study/manifest.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Json = nlohmann::json;

Outcome Study(const std::vector<std::string>& words) { return Captured(RunStudy, "study", words); }

// the file or place of the document's first finding of that kind; "none": there is none
std::string SubjectOf(const Json& document, const std::string& kind) {
  for (const Json& finding : document["findings"]) {
    if (finding["kind"] != kind) continue;
    return finding["subject"].is_null() ? "" : finding["subject"].get<std::string>();
  }
  return "none";
}

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
  std::string Trial(const std::string& name, double rms_um, const std::string& labels = "",
                    double tone_hz = 250) const {
    std::ostringstream text;
    text.precision(9);
    text << labels << "time_s,displacement_um\n";
    for (int k = 0; k < 2400; ++k) {
      const double t_s = k / 2000.0;
      text << t_s << ','
           << 1000 + rms_um * std::numbers::sqrt2 * std::sin(2 * std::numbers::pi * tone_hz * t_s)
           << '\n';
    }
    return Write(name, text.str());
  }

  // white noise of 1 um RMS at the same rate
  std::string WithoutDrive(const std::string& name) const {
    std::ostringstream text;
    text << "time_s,displacement_um\n";
    dsp::Noise noise(3);
    for (int k = 0; k < 2400; ++k) text << k / 2000.0 << ',' << 1000 + noise() << '\n';
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
  EXPECT_THAT(outcome.out, HasSubstr("data: imported\n"));
  EXPECT_THAT(outcome.out, ContainsRegex("b against a\n +subjects +3\n"));
  // (2 x 2.1 x 2.2)^(1/3) with ln 1.1 / sqrt(12) of it
  EXPECT_THAT(outcome.out, ContainsRegex(" ratio +2.098\\(58\\); 95 %: 1.864 to 2.362, of geom"));
  EXPECT_THAT(outcome.out, HasSubstr("t(2) ="));
  // 10, 12.1, 14.4 um
  EXPECT_THAT(outcome.out, ContainsRegex("mean difference +12.2\\(13\\) um; 95 %: 6.7 to 17.6 um"));
  EXPECT_THAT(outcome.out, ContainsRegex("sign flips +p = 0.25"));
  EXPECT_THAT(outcome.out, HasSubstr("F(1, 2) ="));
  EXPECT_THAT(outcome.out, HasSubstr("  command: haptometer study "));
}

// the noise of a trial whose drive was never on is no vibration of 0.7 um
TEST_F(StudyVerb, ATrialWithoutADriveIsCountedAndIsNoMeasurement) {
  WriteNamedTrials();
  const std::string off = WithoutDrive("s9_a.csv");
  const std::vector<std::string> words{directory(), "--pattern", "s{subject}_{condition}"};
  const Outcome outcome = Study(words);
  EXPECT_THAT(outcome.out, ContainsRegex("trials without a drive +1\n"));
  EXPECT_THAT(outcome.out,
              HasSubstr(off + ": no drive found in 1 of 6 trials, none of which counts"));
  std::vector<std::string> with_json = words;
  with_json.emplace_back("--json");
  const Json document = Json::parse(Study(with_json).out);
  const Json& counts = document["counts"];
  EXPECT_EQ(counts["answered"], 5);
  EXPECT_EQ(counts["without_drive"], 1);
  EXPECT_EQ(counts["without_value"], 0);
  EXPECT_TRUE(document["trials"].at(4)["band_rms_m"].is_null());
  EXPECT_EQ(document["contrasts"].at(0)["n"], 2) << "its subject has no value in the condition";
}

// what is excluded is in no number, and is counted and named with its reason in every output
TEST_F(StudyVerb, AnExcludedTrialIsCountedAndNamedAndInNoNumber) {
  WriteNamedTrials();
  const std::vector<std::string> words{directory(), "--pattern", "s{subject}_{condition}",
                                       "--json"};
  const Json before = Json::parse(Study(words).out);
  // a fourth subject, and a condition that only it has, excluded; a second s9_a in a folder below
  const std::string reason = "# excluded = finger slipped\n";
  static_cast<void>(Trial("s12_other.csv", 500, reason));
  fs::create_directories(directory_ / "first");
  const std::string again = Trial("first/s9_a.csv", 500, reason);
  const std::string methods = directory_ / "methods.md";
  const std::string table = directory_ / "long.csv";
  std::vector<std::string> more = words;
  more.insert(more.end(), {"--methods", methods, "--table", table});
  const Outcome outcome = Study(more);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json after = Json::parse(outcome.out);
  for (const char* key : {"subjects", "conditions", "contrasts", "missing", "outlying"}) {
    EXPECT_EQ(after[key], before[key]) << key;
  }
  EXPECT_EQ(after["counts"]["excluded"], 2);
  EXPECT_EQ(after["counts"]["answered"], 6);
  EXPECT_EQ(after["counts"]["without_value"], 0);
  EXPECT_EQ(after["trials"].at(0)["excluded"], "finger slipped") << "first/s9_a.csv";
  EXPECT_EQ(after["trials"].at(0)["reasons"].at(0), "excluded and not analysed: finger slipped");
  EXPECT_TRUE(after["trials"].at(7)["excluded"].is_null());
  EXPECT_THAT(ContentOf(methods),
              HasSubstr("6 of 8 trials of 3 subjects in 2 conditions (a, b) gave a value. 2 trials "
                        "were excluded without analysis. "));
  EXPECT_THAT(ContentOf(methods),
              HasSubstr("- " + again + ": excluded and not analysed: finger slipped\n"));
  EXPECT_THAT(ContentOf(table), HasSubstr(",excluded,"));
  more = {words.begin(), words.end() - 1};
  const Outcome text = Study(more);
  EXPECT_THAT(text.out, ContainsRegex("trials excluded +2\n"));
  EXPECT_THAT(text.out,
              HasSubstr("note: " + again + ": excluded and not analysed: finger slipped"));
}

TEST_F(StudyVerb, ATrialAtAnotherFrequencyIsADoubt) {
  for (int k = 0; k < 4; ++k) {
    static_cast<void>(Trial(fmt::format("s{}_a.csv", k), 10));
  }
  static_cast<void>(Trial("s4_a.csv", 10, "", 255));
  const Outcome outcome = Study({directory(), "--pattern", "s{subject}_{condition}"});
  EXPECT_THAT(outcome.out,
              HasSubstr("s4_a.csv: the tone is at 255 Hz, and the median of the condition's "
                        "trials is 250 Hz"));
  EXPECT_EQ(outcome.out.find("the tone is at"), outcome.out.rfind("the tone is at"));
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
  EXPECT_EQ(document["trials"].at(0)["deviations"], Json({"averaging-unknown"}));
  EXPECT_EQ(document["trials"].at(0)["data_source"], Json({"imported"}));
  EXPECT_TRUE(document["conditions"].at(0)["icc"].is_null()) << "one repeat";
  ASSERT_EQ(document["provenance"]["inputs"].size(), 6U);
  EXPECT_THAT(document["provenance"]["inputs"].at(0)["path"].get<std::string>(),
              HasSubstr("s10_a.csv"));

  std::vector<std::string> verify = words;
  verify.insert(verify.end(), {"--verify", Write("r.json", outcome.out)});
  const Outcome same = Study(verify);
  EXPECT_EQ(same.status, 0) << same.err;
  EXPECT_THAT(same.err, HasSubstr("every number is the same again"));
  Json changed = document;
  changed["contrasts"][0]["ratio"] = 2.5;
  changed["trials"][2]["gone"] = 1;
  changed["findings"] = Json::array();
  // as earlier versions called it
  changed["contrasts"][0]["ratio_interval"] = Json({1, 2});
  Write("r.json", changed.dump());
  const Outcome differs = Study(verify);
  EXPECT_EQ(differs.status, 1);
  EXPECT_THAT(differs.err, HasSubstr("/contrasts/0/ratio was 2.5, is 2.0"));
  EXPECT_THAT(differs.err, HasSubstr("/trials/2/gone is gone"));
  EXPECT_THAT(differs.err, HasSubstr("/contrasts/0/ratio_interval/0 was 1, is 1.86"));
  EXPECT_THAT(differs.err, HasSubstr("4 differences"));
  Write("r.json", "{");
  EXPECT_THAT(Study(verify).err, HasSubstr("is not a JSON document"));
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
  EXPECT_THAT(outcome.out, ContainsRegex("b against a\n +subjects +2\n"));
  EXPECT_THAT(outcome.out,
              ContainsRegex("without subject +9, one of the two conditions is missing"));
  EXPECT_THAT(outcome.out, HasSubstr("note: subject 9 in a: 0 of 1 trial with a value\n"));
  EXPECT_THAT(outcome.out, HasSubstr("no contrast is planned, so every condition is compared"));
}

// one recording under three labels counts three times: named, and not dropped
TEST_F(StudyVerb, FilesOfEqualContentAreADoubt) {
  WriteNamedTrials();
  const fs::path methods = directory_ / "methods.md";
  const std::vector<std::string> words{directory(),  "--pattern", "s{subject}_{condition}",
                                       "--json",     "--methods", methods,
                                       "--overwrite"};
  const auto equal_files = [&] {
    std::vector<Json> found;
    const Json document = Json::parse(Study(words).out);
    for (const Json& finding : document["findings"]) {
      if (finding["kind"] == "equal-files") found.push_back(finding);
    }
    return found;
  };
  EXPECT_TRUE(equal_files().empty());
  for (const char* copy : {"s9_b.csv", "s10_a.csv"}) {
    fs::copy_file(directory_ / "s9_a.csv", directory_ / copy, fs::copy_options::overwrite_existing);
  }
  const auto found = equal_files();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0]["severity"], "doubt");
  EXPECT_EQ(found[0]["numbers"]["files"], 3);
  const std::string folder = directory() + "/";
  const std::string names = folder + "s10_a.csv, " + folder + "s9_a.csv, " + folder + "s9_b.csv";
  EXPECT_EQ(found[0]["subject"], names);
  EXPECT_THAT(ContentOf(methods), HasSubstr("- " + names + ": 3 files of equal content"));
  EXPECT_EQ(Json::parse(Study(words).out)["counts"]["answered"], 6) << "nothing is dropped";
}

TEST_F(StudyVerb, AConditionOfTheManifestThatNoTrialHasIsNamed) {
  WriteNamedTrials();
  const std::string pattern = "pattern = \"s{subject}_{condition}\"\n";
  EXPECT_THAT(Study({Write("m.toml", "conditions = [\"b\", \"aa\"]\n" + pattern)}).out,
              HasSubstr("note: aa: stands in the conditions of the manifest, and is the condition "
                        "of no trial\n"));
  EXPECT_THAT(Study({Write("m.toml", "conditions = [\"b\", \"a\"]\n" + pattern)}).out,
              ::testing::Not(HasSubstr("stands in the conditions")));
}

TEST_F(StudyVerb, APatternReplacesThoseOfTheManifestsGroups) {
  WriteNamedTrials();
  const std::string manifest =
      Write("m.toml", "[[trials]]\nfiles = \"*.csv\"\npattern = \"s{subject}_{condition}\"\n");
  const Json study =
      Json::parse(Study({manifest, "--pattern", "s{condition}_{subject}", "--json"}).out);
  EXPECT_EQ(study["subjects"], Json({"a", "b"}));
}

TEST_F(StudyVerb, ALinkToItselfIsAnErrorOfThisFileAlone) {
  WriteNamedTrials();
  fs::create_symlink("s9_loop.csv", directory_ / "s9_loop.csv");
  const std::string manifest =
      Write("m.toml", "[[trials]]\nfiles = \"*.csv\"\npattern = \"s{subject}_{condition}\"\n");
  const Outcome outcome = Study({manifest});
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("s9_loop.csv"));
  EXPECT_THAT(outcome.out, HasSubstr("trials with a value                        6\n"));
}

TEST_F(StudyVerb, TakesLabelsFromTheFilesAndSaysWhereTheyLack) {
  Trial("1.csv", 10, "# label.subject = x\n# label.condition = a\n");
  Trial("2.csv", 10, "# label.subject = x\n");
  const Outcome outcome = Study({directory()});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("2.csv: has no label condition; use haptometer trial label"));
  EXPECT_THAT(outcome.out, HasSubstr("2 trials, 1 subject, 1 condition\n"));
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
  for (const char* file : {"long.csv", "wide.csv"}) {
    EXPECT_THAT(ContentOf(directory_ / file), StartsWith("# haptometer ")) << file;
  }
  const std::string methods = ContentOf(directory_ / "methods.md");
  EXPECT_THAT(methods, HasSubstr("from 30 to 600 Hz"));
  EXPECT_THAT(methods, HasSubstr("Planned contrasts (b against a)"));
  EXPECT_THAT(methods, HasSubstr("The unit of analysis was the subject"));
  EXPECT_THAT(methods, HasSubstr("Source of the data: imported (6 trials). Sensor: not stated (6"));
  EXPECT_THAT(methods, HasSubstr("\n- command: haptometer study "));
  const Outcome again = Study(words);
  EXPECT_EQ(again.status, 2);
  EXPECT_THAT(again.err, HasSubstr("already exists; name another file, or give --overwrite"));
}

TEST_F(StudyVerb, NamesADeviationOnceAndAStuckSensorByItsReason) {
  WriteNamedTrials();
  std::ostringstream stuck;
  stuck << "time_s,displacement_um\n";
  for (int k = 0; k < 2400; ++k) stuck << k / 2000.0 << ",1000\n";
  Write("s12_a.csv", stuck.str());
  const Outcome outcome = Study({directory(), "--pattern", "s{subject}_{condition}"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.out, ContainsRegex("\n  doubt: amplitude not verified.*, 6 of 6 trials\n"));
  EXPECT_THAT(outcome.out,
              ContainsRegex("not answered: .*s12_a.csv: all 2400 readings are the same"));
  EXPECT_THAT(outcome.out, HasSubstr("subject 12 in a: 0 of 1 trial with a value\n"));
}

// tables of results that lie among the trials, its own too
TEST_F(StudyVerb, IgnoresTablesOfResults) {
  WriteNamedTrials();
  Write("sweep.csv", "# a comment\ndrive_v,rms_m\n1,8e-6\n2,16e-6\n");
  std::vector<std::string> words{
      directory(),   "--pattern", "s{subject}_{condition}", "--table", directory_ / "long.csv",
      "--overwrite", "--json"};
  ASSERT_EQ(Study(words).status, 0);
  const Outcome outcome = Study(words);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json document = Json::parse(outcome.out);
  EXPECT_EQ(document["trials"].size(), 6U);
  std::vector<std::string> ignored;
  for (const Json& finding : document["findings"]) {
    if (finding["kind"] == "table-ignored") ignored.push_back(finding["subject"]);
  }
  EXPECT_THAT(ignored, ElementsAre(directory_ / "long.csv", directory_ / "sweep.csv"));
  for (int s = 0; s < 3; ++s) {
    for (const char* name : {"s{}_a.csv", "s{}_b.csv"}) {
      fs::remove(directory_ / fmt::format(fmt::runtime(name), s + 9));
    }
  }
  EXPECT_THAT(Study({directory()}).err, HasSubstr("holds no recording"));
}

TEST_F(StudyVerb, SaysWhereTheDataComeFrom) {
  WriteNamedTrials();
  Trial("s9_a.csv", 10, "# source = simulated: exact motion\n");
  Trial("s9_b.csv", 20, "# source = emulated device: virtual terminal\n");
  const fs::path methods = directory_ / "methods.md";
  const fs::path page = directory_ / "page.html";
  const Outcome outcome = Study(
      {directory(), "--pattern", "s{subject}_{condition}", "--methods", methods, "--report", page});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("data: emulated, simulated, imported\n"));
  EXPECT_THAT(ContentOf(methods),
              HasSubstr("emulated (1 trial), imported (4 trials), simulated (1 trial)"));
  EXPECT_THAT(ContentOf(page), HasSubstr("<td class=\"word\">emulated</td>"));
}

TEST_F(StudyVerb, ShowsAnIntervalHoweverNarrow) {
  for (int s = 0; s < 3; ++s) {
    static_cast<void>(Trial(fmt::format("s{}_a.csv", s), 10 + s));
    static_cast<void>(Trial(fmt::format("s{}_b.csv", s), (10 + s) * (2 + 1e-4 * s)));
  }
  const std::string text = Study({directory(), "--pattern", "s{subject}_{condition}", "--all"}).out;
  static const std::regex interval(R"(95 %: ([-+0-9.e]+) to ([-+0-9.e]+))");
  int seen = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), interval), end; at != end; ++at, ++seen) {
    EXPECT_NE((*at)[1], (*at)[2]) << at->str();
  }
  EXPECT_GE(seen, 2) << text;
  EXPECT_THAT(text, ContainsRegex(" ratio +2.000100\\(58\\); 95 %: 1.999851 to"));
}

TEST_F(StudyVerb, SaysWhatItsEffectSizesIntervalIsOf) {
  WriteNamedTrials();
  EXPECT_THAT(Study({directory(), "--pattern", "s{subject}_{condition}"}).out,
              HasSubstr("of the population's mean difference / sd"));
}

TEST_F(StudyVerb, SaysHowAnAveragingBecomesKnown) {
  WriteNamedTrials();
  EXPECT_THAT(Study({directory(), "--pattern", "s{subject}_{condition}"}).out,
              HasSubstr("'# averages = 16' and '# sampling_s = 0.00033'"));
}

TEST_F(StudyVerb, AWrongQuestionIsWorseThanAMissingTrial) {
  const std::string trial = Trial("1.csv", 10);
  const std::vector<std::string> words{"linearity", trial, directory_ / "none.csv", "--columns",
                                       "time_s,displacement_um,voltage_v"};
  const Outcome outcome = Study(words);
  EXPECT_EQ(outcome.status, 2) << outcome.err;
}

TEST_F(StudyVerb, DrawsMeansAndIntervals) {
  WriteNamedTrials();
  const fs::path plot = directory_ / "study.svg";
  const Outcome outcome =
      Study({directory(), "--pattern", "s{subject}_{condition}", "--plot", plot});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string svg = ContentOf(plot);
  for (const char* words :
       {"RMS displacement / µm", "a subject, mean of its trials", "mean difference / µm",
        "ratio of geometric means", "b against a, n = "}) {
    EXPECT_THAT(svg, HasSubstr(words));
  }
}

TEST_F(StudyVerb, RefusesWhatIsWrong) {
  WriteNamedTrials();
  const std::string pattern = "s{subject}_{condition}";
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{directory(), "--contrast", "ia1"}, "'ia1' is not a pair of conditions"},
      {{directory(), "--contrast", "a:a"}, "'a:a' is not a pair of conditions"},
      {{directory(), "--pattern", "{who}"}, "{who} is not a label"},
      {{directory(), "--pattern", "{subject}{subject}"}, "stands in it twice"},
      {{directory(), "--pattern", "x"}, "holds no label"},
      {{directory(), "--pattern", pattern, "--contrast", "bb:a"}, "did you mean b?"},
      {{directory(), "--band", "5-2Hz"}, ""},
      {{directory_ / "s9_a.csv"}, "is neither a folder nor a manifest"},
      {{Write("a.toml", "contrast = []\n")}, "did you mean contrasts?"},
      {{Write("b.toml", "contrasts = [[\"a\"]]\n")},
       "holds something other than pairs of two conditions"},
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

TEST_F(StudyVerb, ReadsSweepsFromTablesAndTrials) {
  const std::string table =
      Write("sweep.csv", "drive_v,rms_m\n1,8e-6\n2,16e-6\n3,24.3e-6\n4,32e-6\n");
  const Outcome outcome = Study({"linearity", table, "--plot", directory_ / "l.svg"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("not corrected for noise: neither a reading at 0 V"));
  EXPECT_TRUE(fs::exists(directory_ / "l.svg"));
  const std::string told = Trial("t.csv", 8, "# drive_amplitude_v = 1\n");
  const std::string untold = Trial("u.csv", 8);
  const Outcome trials = Study({"linearity", told, untold, "--json"});
  EXPECT_EQ(trials.status, 3);
  EXPECT_THAT(trials.err, HasSubstr("u.csv: does not state its drive_amplitude_v"));
  const Json line = Json::parse(trials.out)["lines"].at(0);
  EXPECT_EQ(line["readings"], 1);
  EXPECT_TRUE(line["slope_m_per_v"].is_null());
}

// a folder stands for its recordings, as of study; tables of results are named and not read
TEST_F(StudyVerb, LinearityTakesAFolder) {
  std::vector<std::string> words{"linearity"};
  for (int v = 1; v <= 3; ++v) {
    words.push_back(Trial(fmt::format("d{}.csv", v), 8.0 * v + (v == 2 ? 0.1 : 0),
                          fmt::format("# drive_amplitude_v = {}\n", v)));
  }
  words.emplace_back("--json");
  const std::string table = Write("table.csv", "drive_v,rms_m\n1,1\n2,2\n3,3\n");
  const Json files = Json::parse(Study(words).out);
  const Outcome outcome = Study({"linearity", directory(), "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json folder = Json::parse(outcome.out);
  EXPECT_EQ(folder["lines"], files["lines"]);
  EXPECT_EQ(SubjectOf(folder, "table-ignored"), table);
  // a copy counts as a further reading
  fs::copy_file(directory_ / "d2.csv", directory_ / "d4.csv");
  EXPECT_THAT(Study({"linearity", directory()}).out,
              HasSubstr("d4.csv: 2 files of equal content, so that the same data count 2 times"));
}

// a slope rests on its trials, and their doubts are stated as study states them
TEST_F(StudyVerb, LinearityStatesWhatIsDoubtfulOfItsTrials) {
  std::vector<std::string> words{"linearity"};
  for (int v = 1; v <= 4; ++v) {
    const std::string averaging = v == 3 ? "" : "# averages = 1\n# sampling_s = 0.0005\n";
    words.push_back(Trial(fmt::format("d{}.csv", v), 8.0 * v,
                          averaging + fmt::format("# drive_amplitude_v = {}\n", v),
                          v == 2 ? 255 : 250));
  }
  words.emplace_back("--json");
  const Json document = Json::parse(Study(words).out);
  EXPECT_EQ(SubjectOf(document, "averaging-unknown"), words[3]);
  EXPECT_EQ(SubjectOf(document, "other-frequency"), words[2]);
  EXPECT_EQ(SubjectOf(document, "no-noise-correction"), "none") << "the line has its own";
}

// a table of readings is not analysed, so that these options would do nothing
TEST_F(StudyVerb, LinearityRefusesOptionsOfTrialsForTables) {
  const std::string table = Write("sweep.csv", "drive_v,rms_m\n1,8e-6\n2,16e-6\n3,24e-6\n");
  const std::vector<std::pair<std::string, std::string>> options{
      {"--band", "30-400Hz"}, {"--order", "4"}, {"--scale", "2mm"}};
  for (const auto& [option, value] : options) {
    const Outcome outcome = Study({"linearity", table, option, value});
    EXPECT_EQ(outcome.status, 2) << option;
    EXPECT_THAT(outcome.err, HasSubstr(option + ": is for trials, and all files are tables"));
  }
  EXPECT_EQ(Study({"linearity", table, "--floor", "-1um"}).status, 2);
  EXPECT_EQ(Study({"linearity", table, Trial("t.csv", 8, "# drive_amplitude_v = 4\n"), "--band",
                   "30-400Hz"})
                .status,
            0);
}

TEST_F(StudyVerb, LinearitySaysWhichColumnIsInAnotherUnit) {
  const Outcome outcome = Study({"linearity", Write("l.csv", "drive_v,rms_um\n1,2\n2,4\n3,6\n")});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err,
              HasSubstr("has no column rms_m; convert its column rms_um to the unit of "
                        "rms_m, and call it that"));
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
