// What acquire does before and while recording, through real processes: checking, looking, waiting
// for a trigger or the clock, taring, naming files, coming back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/system/emulated_device.h"

namespace haptometer::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

class BeforeRecording : public EmulatedDeviceTest {
 protected:
  void SetUp() override {
    EmulatedDeviceTest::SetUp();
    port_ = directory_ / "port";
  }
  // a device that plays the scene, or a trial, always at the same port
  void EmulateAtLink(std::vector<std::string> words, const std::string& what = "--scene",
                     const std::string& file = kScene) {
    words.insert(words.end(), {what, file, "--link", port_});
    Emulate(words);
  }
  void EmulateStream() { EmulateAtLink({"--protocol", "stream", "--baud", "921600"}); }
  std::vector<std::string> Acquire(const std::vector<std::string>& more,
                                   const std::string& sensor = "stream") const {
    std::vector<std::string> arguments{"acquire", "--port", port_, "--sensor", sensor};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static json Item(const json& document, const std::string& name) {
    for (const json& item : document["items"]) {
      if (item["name"] == name) return item;
    }
    return {};
  }
  // a target at rest, `offset_m` from the reference distance
  std::string AtRest(double offset_m) const {
    const fs::path path = directory_ / "rest.csv";
    std::ofstream csv(path);
    csv << "time_s,displacement_m\n";
    for (int row = 0; row < 100; ++row) csv << row * 0.01 << ',' << offset_m << '\n';
    return path;
  }
  // a file of `rows` rows to pipe in: 0, 1, 2 ... mm
  std::string Rows(int rows, int turn) const {
    const fs::path path = directory_ / "rows.txt";
    std::ofstream text(path);
    for (int row = 0; row < rows; ++row) text << row % turn * 1e-3 << '\n';
    return path;
  }
};

// --- check -------------------------------------------------------------------------------------

TEST_F(BeforeRecording, AFastStreamIsReadyForTheBand) {
  EmulateStream();
  const Outcome checked = RunProgram(Acquire({"--check", "--duration", "3s", "--json"}));
  EXPECT_EQ(checked.status, 0) << checked.err << checked.out;
  const json document = json::parse(checked.out);
  EXPECT_EQ(document["ready"], true);
  EXPECT_EQ(Item(document, "rate")["verdict"], "ok");
  // the scene's 200 um at 225 Hz are motion, not noise: 0.5 um over 5 kHz, 0.155 um in the band
  EXPECT_NEAR(document["tone_frequency_hz"].get<double>(), 225, 0.5);
  EXPECT_NEAR(document["noise_rms_m"].get<double>(), 0.155e-6, 0.1e-6);
  EXPECT_GT(document["smallest_rms_1_percent_m"], document["smallest_rms_10_percent_m"]);
}

TEST_F(BeforeRecording, AFactorySetUnitIsNotReadyAndEachPointNamesItsCommand) {
  EmulateAtLink({});
  const Outcome checked = RunProgram(Acquire(
      {"--baud", "9600", "--check", "--duration", "2s", "--band", "20-200Hz"}, "keyence-il"));
  EXPECT_EQ(checked.status, 3) << checked.err;
  EXPECT_THAT(checked.out, HasSubstr("FIX  averaging"));
  EXPECT_THAT(checked.out, HasSubstr("->  acquire --port " + port_ +
                                     " --sensor keyence-il --baud 9600 --duration 2s"
                                     " --band 20-200Hz --set averaging=1 --check"));
  EXPECT_THAT(checked.out, HasSubstr("FIX  rate"));
  EXPECT_THAT(checked.out, HasSubstr("ok   distance"));
  EXPECT_THAT(checked.out, HasSubstr("ok   hold"));
  EXPECT_THAT(checked.out, HasSubstr("not ready: "));
}

TEST_F(BeforeRecording, FewerAveragesAndALowerBandAreWithinTheUnitsReach) {
  EmulateAtLink({"--averages", "4", "--baud", "38400"}, "--trial", AtRest(0.001));
  const Outcome checked = RunProgram(
      Acquire({"--baud", "38400", "--band", "1-10Hz", "--check", "--duration", "3s", "--json"},
              "keyence-il"));
  const json document = json::parse(checked.out);
  // how well a polled reading's time is known, and with it the noise, is up to the machine's load
  for (const char* name : {"sensor", "distance", "hold", "high-pass", "averaging", "rate", "bad"}) {
    EXPECT_EQ(Item(document, name)["verdict"], "ok") << Item(document, name).dump();
  }
  EXPECT_NEAR(document["level_m"].get<double>(), 1e-3, 2e-6);
}

TEST_F(BeforeRecording, ATargetBeyondTheLinearRangeIsSeen) {
  EmulateAtLink({"--baud", "38400"}, "--trial", AtRest(0.0072));
  const Outcome checked = RunProgram(
      Acquire({"--baud", "38400", "--check", "--duration", "1s", "--json"}, "keyence-il"));
  EXPECT_EQ(checked.status, 3);
  const json distance = Item(json::parse(checked.out), "distance");
  EXPECT_EQ(distance["verdict"], "fix");
  EXPECT_THAT(distance["remedy"].get<std::string>(), HasSubstr("move the head by 7.2"));
}

TEST_F(BeforeRecording, BadReadingsAreSeen) {
  EmulateAtLink({"--baud", "38400", "--fault", "invalid:3"}, "--trial", AtRest(0));
  const Outcome checked = RunProgram(
      Acquire({"--baud", "38400", "--check", "--duration", "1s", "--json"}, "keyence-il"));
  EXPECT_EQ(checked.status, 3);
  const json bad = Item(json::parse(checked.out), "bad");
  EXPECT_EQ(bad["verdict"], "fix");
  EXPECT_THAT(bad["finding"].get<std::string>(), HasSubstr("invalid"));
}

TEST_F(BeforeRecording, WithoutADisplacementThereIsNothingToCheck) {
  const Outcome checked =
      RunProgram({"acquire", "--sensor", "pipe", "--port", Rows(1000, 100), "--rate", "10Hz",
                  "--format", "text", "--channels", "voltage:V", "--check"});
  EXPECT_EQ(checked.status, 3);
  EXPECT_THAT(checked.err, HasSubstr("has no displacement channel in metres to check"));
}

// --- live --------------------------------------------------------------------------------------

TEST_F(BeforeRecording, LookingKeepsNothingAndShowsTheBand) {
  EmulateStream();
  const Outcome looked = RunProgram(Acquire({"--live", "--duration", "5s"}));
  EXPECT_EQ(looked.status, 0) << looked.err;
  EXPECT_THAT(looked.out, HasSubstr("um RMS, 22"));
  EXPECT_THAT(looked.out, HasSubstr("nothing kept: "));
  // the port and what the emulator made: no file
  const auto files = std::distance(fs::directory_iterator(directory_), {});
  EXPECT_EQ(files, 1);
}

TEST_F(BeforeRecording, LookingThroughASlowWireSaysThatTheBandCannotBeSeen) {
  EmulateAtLink({});
  const Outcome looked =
      RunProgram(Acquire({"--live", "--duration", "4s", "--json"}, "keyence-il"));
  EXPECT_EQ(looked.status, 0) << looked.err;
  EXPECT_THAT(looked.err, HasSubstr("20-500 Hz needs 1280 new readings/s"));
  EXPECT_EQ(json::parse(looked.out)["file"], nullptr);
}

TEST_F(BeforeRecording, AReaderWhoHasSeenEnoughEndsTheLooking) {
  EmulateStream();
  std::vector<std::string> arguments = Acquire({"--live"});
  Process looking(arguments);
  ASSERT_TRUE(looking.WaitForLine("", 30));
  looking.CloseOutput();
  EXPECT_EQ(looking.Wait(30).status, 128 + SIGPIPE);
}

// --- trigger, end, zero, name -------------------------------------------------------------------

// a second of a pipe is what its rate says, however fast it is read, and no row beyond it is lost
TEST_F(BeforeRecording, ATareTakesAPipesFirstSecondAndTheRecordingHasAllThatFollows) {
  const std::vector<std::string> pipe{
      "acquire",  "--sensor", "pipe",       "--port",         Rows(50, 50), "--rate", "10Hz",
      "--format", "text",     "--channels", "displacement:m", "-o",         trial_,   "--tare"};
  const Outcome all = RunProgram(pipe);
  EXPECT_EQ(all.status, 0) << all.err;
  EXPECT_THAT(all.err, HasSubstr("zero: 4.5 mm"));  // the mean of 0 to 9 mm
  EXPECT_THAT(all.out, HasSubstr("40 readings"));
  EXPECT_THAT(all.out, ::testing::ContainsRegex("gaps +0\n"));

  std::vector<std::string> some = pipe;
  some.insert(some.end(), {"--duration", "3s", "--overwrite"});
  const Outcome limited = RunProgram(some);
  EXPECT_EQ(limited.status, 0) << limited.err;
  EXPECT_THAT(limited.out, HasSubstr("30 readings"));

  some[4] = Rows(5, 5);
  const Outcome ended = RunProgram(some);
  EXPECT_EQ(ended.status, 3);
  EXPECT_THAT(ended.err, HasSubstr("ended during --tare"));
}

TEST_F(BeforeRecording, ASceneIsPlayedFromItsStartAfterATareToo) {
  const auto rows = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"acquire", "--sensor", "scene:" + kScene, "--speed",    "max",
                                   "-o",      trial_,     "--overwrite",     "--duration", "0.1s"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome acquired = RunProgram(words);
    EXPECT_EQ(acquired.status, 0) << acquired.err;
    const Outcome exported = RunProgram(
        {"haptometer", "trial", "export", trial_, "-o", directory_ / "rows.csv", "--overwrite"});
    EXPECT_EQ(exported.status, 0) << exported.err;
    std::ifstream csv(directory_ / "rows.csv");
    std::string text;
    for (std::string line; std::getline(csv, line);) {
      if (!line.starts_with('#')) text += line + '\n';
    }
    return text;
  };
  const std::string plain = rows({});
  EXPECT_GT(plain.size(), 1000U);
  EXPECT_EQ(rows({"--tare"}), plain);
}

TEST_F(BeforeRecording, ATriggerBeginsEachShotAndEarlierRowsAreKept) {
  EmulateStream();
  // +-283 um at 225 Hz: it rises through 0.1 mm every 44 rows
  const Outcome acquired =
      RunProgram(Acquire({"--trigger", "rising 0.1mm", "--pre-samples", "50", "--samples", "200",
                          "--shots", "3", "--hold-off", "200ms", "-o", trial_, "--json"}));
  ASSERT_EQ(acquired.status, 0) << acquired.err;
  const json summary = json::parse(acquired.out);
  EXPECT_EQ(summary["triggers"], 3);
  // the first one may have come before 50 rows had
  EXPECT_GE(summary["readings"], 3 * 200 + 2 * 50);
  EXPECT_LE(summary["readings"], 3 * 250);
}

TEST_F(BeforeRecording, ATriggerThatNeverFiresEndsAtTheTimeOfDay) {
  EmulateStream();
  const std::time_t end = std::time(nullptr) + 3;
  std::tm wall{};
  localtime_r(&end, &wall);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &wall);
  const Outcome acquired = RunProgram(
      Acquire({"--trigger", "above 5mm", "--until", text.data(), "-o", trial_, "--json"}));
  EXPECT_EQ(acquired.status, 3) << "nothing was recorded";
  EXPECT_EQ(json::parse(acquired.out)["triggers"], 0);
  EXPECT_EQ(TrialInfo(trial_)["closed"], true);
}

TEST_F(BeforeRecording, TheTareIsKeptBesideReadingsAsSent) {
  EmulateAtLink({"--protocol", "stream", "--baud", "921600"}, "--trial", AtRest(0.002));
  const Outcome acquired =
      RunProgram(Acquire({"--tare", "--samples", "1000", "-o", trial_, "--json"}));
  ASSERT_EQ(acquired.status, 0) << acquired.err;
  EXPECT_THAT(acquired.err, HasSubstr("zero: "));
  const json info = TrialInfo(trial_);
  EXPECT_THAT(info.dump(), HasSubstr("\"tare_m\":0.00"));
  const Outcome csv = RunProgram({"haptometer", "trial", "export", trial_});
  // as sent: about 2 mm
  EXPECT_THAT(csv.out, HasSubstr(",0.00"));
  EXPECT_THAT(csv.out, HasSubstr("tare"));
}

TEST_F(BeforeRecording, ADirectoryNamesTheTrialsAndTheAliasForceReplaces) {
  EmulateStream();
  const fs::path trials = directory_ / "trials";
  fs::create_directory(trials);
  for (int n = 0; n < 2; ++n) {
    const Outcome acquired = RunProgram(Acquire(
        {"-o", trials.string() + "/", "--samples", "100", "--label", "subject=3", "--json"}));
    ASSERT_EQ(acquired.status, 0) << acquired.err;
    const std::string file = json::parse(acquired.out)["file"];
    EXPECT_TRUE(fs::exists(file)) << file;
    EXPECT_THAT(file, HasSubstr("Z_stream_subject-3"));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(trials), {}), 2);

  std::ofstream{trial_} << "old";
  EXPECT_EQ(RunProgram(Acquire({"-o", trial_, "--samples", "100"})).status, 2);
  const Outcome no_trial = RunProgram(Acquire({"-o", trial_, "--samples", "100", "--force"}));
  EXPECT_EQ(no_trial.status, 2);
  EXPECT_THAT(no_trial.err, HasSubstr("exists and is not a trial.bin"));
  fs::remove(trial_);
  EXPECT_EQ(RunProgram(Acquire({"-o", trial_, "--samples", "70"})).status, 0);
  EXPECT_EQ(RunProgram(Acquire({"-o", trial_, "--samples", "100", "--force"})).status, 0);
  EXPECT_EQ(TrialInfo(trial_)["rows"], 100);
}

// --- a device that goes away -------------------------------------------------------------------

TEST_F(BeforeRecording, WithoutReconnectALostDeviceEndsItAndTheMessageNamesTheOption) {
  EmulateStream();
  Process acquire(Acquire({"-o", trial_}));
  ASSERT_TRUE(WaitForRows(acquire, 0));
  EndDevice();
  const Outcome acquired = acquire.Wait(60);
  EXPECT_EQ(acquired.status, 1);
  EXPECT_THAT(acquired.err, HasSubstr("--reconnect"));
  EXPECT_EQ(TrialInfo(trial_)["closed"], true);
}

TEST_F(BeforeRecording, WithReconnectItGoesOnInTheSameTrial) {
  EmulateStream();
  Process acquire(Acquire({"-o", trial_, "--reconnect", "30s", "--json"}));
  ASSERT_TRUE(WaitForRows(acquire, 0));
  EmulateStream();  // the old one ends, another comes at the same name
  const auto is_back = [&] { return TrialInfo(trial_)["events"].dump().contains("\"reconnect\""); };
  ASSERT_TRUE(acquire.WaitUntil(is_back, 60));
  acquire.Signal(SIGINT);
  const Outcome acquired = acquire.Wait(60);
  EXPECT_EQ(acquired.status, 130);
  const json summary = json::parse(acquired.out);
  EXPECT_EQ(summary["reconnects"], 1);
  EXPECT_EQ(summary["connection_lost"], false);
  EXPECT_GE(summary["gaps"], 1);
}

TEST_F(BeforeRecording, ADeviceThatStaysAwayIsGivenUp) {
  EmulateStream();
  Process acquire(Acquire({"-o", trial_, "--reconnect", "1s", "--json"}));
  ASSERT_TRUE(WaitForRows(acquire, 0));
  EndDevice();
  EXPECT_EQ(acquire.Wait(60).status, 1);
}

// --- refusals ----------------------------------------------------------------------------------

TEST_F(BeforeRecording, WhatIsNotMeantTogetherIsRefusedBeforeThePortIsTouched) {
  const auto refused = [&](const std::vector<std::string>& more) {
    const Outcome outcome = RunProgram(Acquire(more));
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(refused({}), HasSubstr("look with --live or --check"));
  EXPECT_THAT(refused({"--check", "-o", trial_}), HasSubstr("--check: keeps nothing"));
  EXPECT_THAT(refused({"--check", "--live"}), HasSubstr("has no use for --live"));
  EXPECT_THAT(refused({"--live", "--band", "500-20Hz"}), HasSubstr("band"));
  EXPECT_THAT(refused({"-o", trial_, "--smallest-rms", "1um"}), HasSubstr("add --check"));
  EXPECT_THAT(refused({"-o", trial_, "--trigger", "up 1mm"}), HasSubstr("--trigger"));
  EXPECT_THAT(refused({"-o", trial_, "--until", "2001-01-01T00:00"}), HasSubstr("has passed"));
}

TEST_F(BeforeRecording, AReplayOfAForeignFileSaysWhatIsPlayed) {
  const std::string csv = AtRest(0);
  const Outcome played = RunProgram({"acquire", "--sensor", "replay", "--port", csv, "-o", trial_});
  EXPECT_EQ(played.status, 3);
  EXPECT_THAT(played.err, HasSubstr("is not a trial; give a trial.bin"));
  EXPECT_THAT(played.err, ::testing::Not(HasSubstr("CSV whose")));
}

}  // namespace
}  // namespace haptometer::tests
