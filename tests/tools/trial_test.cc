#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "base/clock.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

Outcome Trial(const std::vector<std::string>& words) { return Captured(RunTrial, "trial", words); }

class TrialVerb : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(directory_);
    trial::TrialHeader header;
    header.rate_hz = 1000;
    header.channels.emplace_back();
    trial::ChannelFormat& channel = header.channels.back();
    channel.name = "displacement";
    channel.role = trial::ChannelRole::kDisplacement;
    channel.unit = "m";
    channel.encoding = trial::Encoding::kI32;
    channel.scale = 1e-6;
    channel.resolution = 1e-6;
    header.metadata.source = "emulated device";
    header.metadata.labels = {{"subject", "3"}};
    ManualClock clock;
    auto writer = trial::TrialWriter::Create(trial_, header, {}, clock);
    ASSERT_TRUE(writer);
    // 100 rows, 10 ms lost after the 50th, every tenth over the range
    for (int i = 0; i < 100; ++i) {
      const auto status = i % 10 == 9 ? trial::SampleStatus::kOver : trial::SampleStatus::kOk;
      const trial::Sample sample{trial::RawValue::Counts(i), status};
      ASSERT_TRUE(writer->Append({.index = i < 50 ? i : i + 10, .samples = {&sample, 1}}));
    }
    ASSERT_TRUE(writer->Finish());
  }
  void TearDown() override { fs::remove_all(directory_); }
  std::string Path(const std::string& name) const { return directory_ / name; }
  std::string Content(const std::string& path) const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("trial_verb_test_" + std::to_string(::getpid()));
  const std::string trial_ = directory_ / "t.bin";
};

TEST_F(TrialVerb, InfoSaysWhatTheFileHolds) {
  const Outcome info = Trial({"info", trial_});
  EXPECT_EQ(info.status, 0) << info.err;
  for (const char* text : {"data: emulated\n", "label subject", "90 ok, 10 over\n", "109 ms\n",
                           "1000 Hz\n", "finished by its recorder"}) {
    EXPECT_THAT(info.out, HasSubstr(text));
  }
  EXPECT_THAT(info.out, ::testing::ContainsRegex("resolution +1 um\n"));
  EXPECT_THAT(info.out, ::testing::ContainsRegex("before row +at / ms +length / ms\n"));
  EXPECT_THAT(info.out, ::testing::ContainsRegex(" 50 +50 +10\n"));
  EXPECT_THAT(info.out, Not(HasSubstr("SHA-256")));
  EXPECT_THAT(Trial({"info", trial_, "--all"}).out, HasSubstr("SHA-256"));
  const json document = json::parse(Trial({"info", "--json", trial_}).out);
  EXPECT_EQ(document["closed"], true);
  EXPECT_EQ(document["rows"], 100);
  EXPECT_EQ(document["statuses"]["over"], 10);
  EXPECT_EQ(document["gaps"][0]["row"], 50);
  EXPECT_EQ(document["rows_lost"], 0);
  EXPECT_EQ(document["labels"]["subject"], "3");
  EXPECT_TRUE(document.contains("sensor") && document["sensor"].is_null());
  EXPECT_EQ(document["data_source"], json::parse(R"(["emulated"])"));
  EXPECT_EQ(document["provenance"]["inputs"][0]["path"], trial_);
}

TEST_F(TrialVerb, InfoStatesLosses) {
  std::string bytes = Content(trial_);
  const std::string cut = Path("cut.bin");
  std::ofstream(cut, std::ios::binary) << bytes.substr(0, bytes.size() - 400);
  const Outcome info = Trial({"info", cut});
  EXPECT_EQ(info.status, 0);
  EXPECT_THAT(info.out, HasSubstr("cut short"));
  EXPECT_THAT(info.out, HasSubstr("rows 50 to 99 are lost"));
  const json document = json::parse(Trial({"info", "--json", cut}).out);
  EXPECT_EQ(document["closed"], false);
  EXPECT_EQ(document["rows_lost"], 50);
  EXPECT_EQ(document["losses"][0]["what"], "ends-in-block");
  EXPECT_EQ(document["data_source"], json::parse(R"(["emulated", "interrupted"])"));
  EXPECT_EQ(document["findings"][0]["kind"], "ends-in-block");
  EXPECT_EQ(document["findings"][0]["numbers"]["first_row"], 50);
  EXPECT_EQ(document["findings"][1]["kind"], "not-finished");
}

TEST_F(TrialVerb, LabelsAreAppendedAndTheLastWordCounts) {
  const std::string before = Content(trial_);
  EXPECT_EQ(Trial({"label", trial_, "subject=4", "condition=with = adapter"}).status, 0);
  EXPECT_TRUE(Content(trial_).starts_with(before));
  const json labelled = json::parse(Trial({"label", "--json", trial_, "subject=5"}).out);
  EXPECT_EQ(labelled["labels"]["subject"], "5");
  EXPECT_EQ(labelled["labels"]["condition"], "with = adapter");
  EXPECT_EQ(labelled["closed"], true);
}

TEST_F(TrialVerb, WrongLabelsChangeNothing) {
  const std::string before = Content(trial_);
  for (const char* label : {"subject", "=3", ""}) {
    const Outcome refused = Trial({"label", trial_, label});
    EXPECT_EQ(refused.status, 2);
    EXPECT_THAT(refused.err, HasSubstr("is not KEY=VALUE; write e.g. subject=3"));
  }
  EXPECT_EQ(Trial({"label", trial_}).status, 2);
  EXPECT_EQ(Content(trial_), before);
  const std::string csv = Path("t.csv");
  ASSERT_EQ(Trial({"export", trial_, "-o", csv}).status, 0);
  const Outcome on_csv = Trial({"label", csv, "a=b"});
  EXPECT_EQ(on_csv.status, 3);
  EXPECT_THAT(on_csv.err, HasSubstr("is a CSV; write the label into it"));
  EXPECT_EQ(Trial({"label", Path("none"), "a=b"}).status, 3);
}

TEST_F(TrialVerb, ExportsAreReadAsTheSame) {
  const std::string csv = Path("t.csv");
  const Outcome to_stdout = Trial({"export", trial_});
  EXPECT_EQ(to_stdout.status, 0);
  EXPECT_EQ(Trial({"export", trial_, "-o", csv}).status, 0);
  EXPECT_EQ(Content(csv), to_stdout.out);
  json from_csv = json::parse(Trial({"info", "--json", csv}).out);
  json from_trial = json::parse(Trial({"info", "--json", trial_}).out);
  for (const char* key : {"file", "file_bytes", "kind", "closed", "provenance"}) {
    from_csv.erase(key);
    from_trial.erase(key);
  }
  // an emptied cell is all that a CSV can say of a value over the range
  EXPECT_EQ(from_csv, from_trial);
}

TEST_F(TrialVerb, ExportsDoNotOverwriteSilently) {
  const std::string csv = Path("t.csv");
  std::ofstream(csv) << "precious";
  const Outcome refused = Trial({"export", trial_, "-o", csv});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("already exists; name another file, or give --overwrite"));
  EXPECT_EQ(Content(csv), "precious");
  // not even then: it is no table of ours
  const Outcome other = Trial({"export", trial_, "-o", csv, "--overwrite"});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, HasSubstr("exists and is not a table of time_s"));
  EXPECT_EQ(Content(csv), "precious");
  std::ofstream(csv) << "# source = an older export\ntime_s,displacement_m\n0,1\n";
  EXPECT_EQ(Trial({"export", trial_, "-o", csv, "--overwrite"}).status, 0);
  EXPECT_THAT(Content(csv), HasSubstr("time_s,displacement_m,status"));
  const Outcome full = Trial({"export", trial_, "-o", "/dev/full", "--overwrite"});
  EXPECT_EQ(full.status, 1);
  EXPECT_THAT(full.err, HasSubstr("No space left on device"));
}

TEST_F(TrialVerb, ACsvIsNotCalledFinishedAndItsRemarksAreShown) {
  const std::string csv = Path("t.csv");
  std::ofstream(csv) << "# averages = 1\n# drive_frequency_hz = 10000\n# rate = 1000 Hz\n"
                        "# channel.1.resolution = 8.7e-23\ntime_s,displacement_m\n0,1\n1,2\n2,3\n";
  const Outcome info = Trial({"info", csv});
  EXPECT_EQ(info.status, 0) << info.err;
  for (const char* text :
       {"data: imported\n", "imported from CSV", "10000 Hz",
        "doubt: the times give 1 Hz where the file states 1000 Hz; they are used as they are"}) {
    EXPECT_THAT(info.out, HasSubstr(text));
  }
  EXPECT_THAT(info.out, ::testing::ContainsRegex("resolution +0 um\n"));
  EXPECT_THAT(info.out, Not(HasSubstr("finished")));
  EXPECT_TRUE(json::parse(Trial({"info", csv, "--json"}).out)["closed"].is_null());
}

TEST_F(TrialVerb, InfoShowsAThumbnail) {
  const Outcome info = Trial({"info", trial_});
  // the axes of gnuplot's dumb terminal, and the title with the mean
  EXPECT_THAT(info.out, HasSubstr("displacement about"));
  EXPECT_THAT(info.out, HasSubstr("+------"));
}

// the mean of a sine about 0 is what rounding leaves
// what stands for no reading is none, as for analyze: in counts, mean, drawing and page
TEST_F(TrialVerb, CodesAreNoReadings) {
  std::string text = "time_s,displacement_mm\n";
  for (int i = 0; i < 300; ++i) {
    const bool is_under = i >= 100 && i < 120;
    const bool is_over = i >= 200 && i < 210;
    text += fmt::format("{:.3f},{}\n", 1e-3 * i,
                        is_under  ? "-99.998"
                        : is_over ? "+99.998"
                                  : fmt::format("{:.3f}", 0.02 * std::sin(0.7 * i)));
  }
  std::ofstream(Path("codes.csv")) << text;
  const json info = json::parse(Trial({"info", Path("codes.csv"), "--json"}).out);
  const json& statuses = info.at("channels").at(0).at("statuses");
  EXPECT_EQ(statuses.at("ok"), 270);
  EXPECT_EQ(statuses.at("invalid").get<int>() + statuses.at("over").get<int>() +
                statuses.at("under").get<int>(),
            30);
  const std::string shown = Trial({"info", Path("codes.csv")}).out;
  EXPECT_THAT(shown, HasSubstr("270 ok"));
  EXPECT_THAT(shown, HasSubstr("-99.998 mm is a code for no reading: 20 readings excluded"));
  EXPECT_THAT(shown, HasSubstr(" 99.998 mm is a code for no reading: 10 readings excluded"));
  EXPECT_THAT(shown, Not(HasSubstr("-100000")));
  EXPECT_THAT(Trial({"plot", Path("codes.csv"), "-o", Path("codes.svg")}).err,
              HasSubstr("is a code for no reading: 20 readings"));
}

TEST_F(TrialVerb, AMeanOfNothingIsZero) {
  std::ofstream file(Path("sine.csv"));
  file.precision(17);
  file << "time_s,displacement_m\n";
  for (int k = 0; k < 20'000; ++k) {
    file << k / 1e4 << ',' << 2e-4 * std::sin(2 * std::numbers::pi * 225 * k / 1e4) << '\n';
  }
  file.close();
  EXPECT_THAT(Trial({"info", Path("sine.csv")}).out,
              HasSubstr("displacement about 0\u00a0\u00b5m"));
}

TEST_F(TrialVerb, LabelsKeepTheirReasonAndTakeAcquiresWay) {
  EXPECT_EQ(Trial({"label", trial_, "subject=4", "--reason", "wrong one noted"}).status, 0);
  EXPECT_THAT(Trial({"info", trial_}).out,
              ::testing::ContainsRegex("label +subject: 3 -> 4 \\(wrong one noted\\), "
                                       "20[0-9-]*T[0-9:.]*Z\n"));
  // a correction without a reason, and a label that is new
  EXPECT_EQ(Trial({"label", trial_, "--label", "repeat=2", "subject=5"}).status, 0);
  EXPECT_THAT(Trial({"info", trial_}).out,
              ::testing::ContainsRegex("label +repeat: 2, 20[^ ]*Z\n"
                                       " +label +subject: 4 -> 5, 20[^ ]*Z\n"));
  const json document = json::parse(Trial({"info", "--json", trial_}).out);
  EXPECT_EQ(document["labels"]["repeat"], "2");
  EXPECT_EQ(document["events"][0]["text"], "wrong one noted");
  EXPECT_THAT(Trial({"label", trial_}).err, HasSubstr("labels: are missing"));
}

TEST_F(TrialVerb, AnExclusionIsAppendedAndTheLastWordCounts) {
  const std::string before = Content(trial_);
  EXPECT_EQ(Trial({"exclude", trial_, "--reason", "finger slipped"}).status, 0);
  EXPECT_TRUE(Content(trial_).starts_with(before));
  EXPECT_THAT(Trial({"info", trial_}).out, ::testing::ContainsRegex("excluded +finger slipped\n"));
  const auto excluded = [&] {
    return json::parse(Trial({"info", "--json", trial_}).out)["fields"].value("excluded", "");
  };
  EXPECT_EQ(excluded(), "finger slipped");
  const json again =
      json::parse(Trial({"exclude", trial_, "--reason", "drive was off", "--json"}).out);
  EXPECT_EQ(again["fields"]["excluded"], "drive was off");
  EXPECT_EQ(again["events"][0]["event"], "excluded");
  EXPECT_EQ(again["events"][0]["text"], "finger slipped") << "its history stays";
  EXPECT_EQ(Trial({"include", trial_}).status, 0);
  EXPECT_EQ(excluded(), "");
  EXPECT_EQ(Trial({"exclude", trial_, "--reason", "again"}).status, 0);
  EXPECT_EQ(excluded(), "again");
  EXPECT_TRUE(Content(trial_).starts_with(before));
}

TEST_F(TrialVerb, WrongExclusionsChangeNothing) {
  const std::string before = Content(trial_);
  for (const auto& words :
       std::vector<std::vector<std::string>>{{"exclude", trial_},
                                             {"exclude", trial_, "--reason", " "},
                                             {"exclude", trial_, "--reason", "a\nb"},
                                             {"exclude"},
                                             {"include", trial_, "more"}}) {
    EXPECT_EQ(Trial(words).status, 2) << words.back();
  }
  const Outcome included = Trial({"include", trial_});
  EXPECT_EQ(included.status, 0);
  EXPECT_THAT(included.err, HasSubstr("is not excluded; unchanged"));
  EXPECT_EQ(Content(trial_), before);
  EXPECT_EQ(Trial({"exclude", Path("none"), "--reason", "x"}).status, 3);
}

// an export carries the exclusion; in a CSV it is a line, which is written and removed by hand
TEST_F(TrialVerb, ExclusionsOfOtherKindsAreGivenElsewhere) {
  ASSERT_EQ(Trial({"exclude", trial_, "--reason", "finger slipped"}).status, 0);
  for (const char* name : {"t.csv", "t.h5"}) {
    const std::string file = Path(name);
    ASSERT_EQ(Trial({"export", trial_, "-o", file}).status, 0);
    EXPECT_EQ(json::parse(Trial({"info", "--json", file}).out)["fields"]["excluded"],
              "finger slipped");
    EXPECT_EQ(Trial({"include", file}).status, 3);
  }
  EXPECT_THAT(Trial({"exclude", Path("t.csv"), "--reason", "x"}).err,
              HasSubstr("is a CSV; write the reason into it, as a line '# excluded = "));
  EXPECT_THAT(Trial({"include", Path("t.csv")}).err, HasSubstr("remove its line '# excluded ="));
  EXPECT_THAT(Trial({"exclude", Path("t.h5"), "--reason", "x"}).err,
              HasSubstr("is a HDF5; exclude the trial itself and export it again"));
}

TEST_F(TrialVerb, LabelsOfOtherKindsAreGivenElsewhere) {
  const std::string hdf5 = Path("t.h5");
  ASSERT_EQ(Trial({"export", trial_, "-o", hdf5}).status, 0);
  EXPECT_THAT(Trial({"label", hdf5, "a=b"}).err,
              HasSubstr("is a HDF5; label the trial itself and export it again"));
}

TEST_F(TrialVerb, PlotsAreDrawn) {
  const std::string svg = Path("t.svg");
  const Outcome drawn = Trial({"plot", trial_, "-o", svg});
  EXPECT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_THAT(Content(svg), HasSubstr("10 bad"));
  EXPECT_EQ(Trial({"plot", trial_, "--plot", svg}).status, 0);
  EXPECT_EQ(Trial({"plot", trial_}).status, 2);
  EXPECT_EQ(Trial({"plot", trial_, "-o", Path("t.gif")}).status, 2);
}

TEST_F(TrialVerb, UnknownWordsGetAProposal) {
  const Outcome misspelt = Trial({"exprot", trial_});
  EXPECT_EQ(misspelt.status, 2);
  EXPECT_THAT(misspelt.err, HasSubstr("did you mean trial export?"));
  EXPECT_EQ(Trial({}).status, 2);
  EXPECT_EQ(Trial({"--help"}).status, 0);
  EXPECT_EQ(Trial({"info", "--help"}).status, 0);
}

}  // namespace
}  // namespace haptometer::tools
