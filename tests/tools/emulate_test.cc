#include "tools/emulate/emulate.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

const std::string kScene = std::string(HAPTOMETER_FIXTURES) + "/lra_adapter.toml";

Outcome Emulate(const std::vector<std::string>& words) {
  return Captured(RunEmulate, "emulate", words);
}

// --- command line ------------------------------------------------------------------------------

struct Wrong {
  std::vector<std::string> options;
  int status;
  std::string text;
};

class WrongEmulations : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongEmulations, SayWhatToDo) {
  const Outcome said = Emulate(GetParam().options);
  EXPECT_EQ(said.status, GetParam().status);
  EXPECT_EQ(said.err, "haptometer emulate: " + GetParam().text + "\n");
  EXPECT_EQ(said.out, "");
}

INSTANTIATE_TEST_SUITE_P(
    Options, WrongEmulations,
    ::testing::Values(
        Wrong{{}, 2, "what to play is not clear; give one of --scene FILE and --trial FILE"},
        Wrong{{"--scene", kScene, "--trial", "x.bin"},
              2,
              "what to play is not clear; give one of --scene FILE and --trial FILE"},
        Wrong{{"--scene", kScene, "--json"},
              2,
              "--json: emulate has no document to print; read its line 'ready PATH'"},
        Wrong{{"--scene", kScene, "--link", "l", "--tcp", "127.0.0.1:0"},
              2,
              "--link: is for a terminal, and --tcp makes none; leave one of them out"},
        Wrong{{"--scene", kScene, "--protocol", "stream", "--refresh", "9ms"},
              2,
              "--refresh: is the buffer of a DL-RS1A; leave it out with --protocol stream"},
        Wrong{{"--scene", kScene, "--duration", "0"},
              2,
              "--duration: '0' is not from 1e-09 s to 3.2e+07 s; write one within"},
        Wrong{{"--scene", kScene, "--protocol", "stream", "--baud", "115200"},
              2,
              "--baud: 9 characters at 115200 baud allow 1280 lines/s, the head gives 10000; use "
              "--baud 921600 or --sampling 782us"},
        Wrong{{"--scene", kScene, "--baud", "115200"},
              2,
              "--baud: a DL-RS1A has no 115200 baud; give one of 9600, 2400, 4800, 19200, 38400"},
        Wrong{{"--scene", kScene, "--averages", "3"},
              2,
              "--averages: an IL-1000 does not average 3; give a power of two from 1 to 4096"},
        Wrong{{"--scene", kScene, "--tcp", "5000"},
              2,
              "--tcp: '5000' is not HOST:PORT; give 127.0.0.1:0, for example"}));

TEST(Emulate, TellsWhatIsWrongWithItsFiles) {
  const Outcome scene = Emulate({"--scene", "absent.toml"});
  EXPECT_EQ(scene.status, 3);
  EXPECT_TRUE(scene.err.starts_with("haptometer emulate: absent.toml: ")) << scene.err;
  const Outcome trial = Emulate({"--trial", "absent.bin"});
  EXPECT_EQ(trial.status, 3);
  EXPECT_TRUE(trial.err.starts_with("haptometer emulate: absent.bin: ")) << trial.err;
}

TEST(Emulate, SaysWhereItIsAndWhatItPlays) {
  const Outcome unit = Emulate({"--scene", kScene, "--duration", "10ms"});
  EXPECT_EQ(unit.status, 0) << unit.err;
  EXPECT_TRUE(unit.out.starts_with("ready /dev/pts/")) << unit.out;
  EXPECT_EQ(std::count(unit.out.begin(), unit.out.end(), '\n'), 1);
  EXPECT_EQ(unit.err,
            "emulate: IL-030, sampled every 1 ms, 16 averages; at 9600 baud at most 48.4 "
            "readings/s, new ones every 7 ms\n");

  const Outcome stream = Emulate({"--scene", kScene, "--protocol", "stream", "--tcp", "127.0.0.1:0",
                                  "--sampling", "1ms", "--baud", "115200", "--duration", "10ms"});
  EXPECT_EQ(stream.status, 0) << stream.err;
  EXPECT_TRUE(stream.out.starts_with("ready 127.0.0.1:")) << stream.out;
  EXPECT_EQ(stream.err,
            "emulate: stream-10kHz, sampled every 1 ms, 1 average; 1000 lines/s of 9 characters "
            "at 115200 baud\n");
}

TEST(Emulate, PlaysATrialAndSaysForHowLong) {
  const fs::path file =
      fs::path(::testing::TempDir()) / ("emulate_test_" + std::to_string(::getpid()) + ".csv");
  std::ofstream(file) << "time_s,displacement_m\n0,1e-3\n0.1,2e-3\n0.2,3e-3\n";
  const Outcome said = Emulate({"--trial", file, "--duration", "10ms"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_TRUE(said.err.starts_with("emulate: plays 0.2 s of " + file.string() +
                                   ", then holds its last value; IL-030"))
      << said.err;
  fs::remove(file);
}

// --- a recorded motion ---------------------------------------------------------------------------

trial::Record Recorded(std::vector<double> values_m) {
  trial::Record record;
  record.rows = values_m.size();
  record.stretches = {{.first_row = 0, .rows = record.rows, .start_s = 5, .rate_hz = 100}};
  trial::Channel channel;
  channel.name = "displacement";
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.statuses.assign(record.rows, trial::SampleStatus::kOk);
  channel.values = std::move(values_m);
  record.channels = {channel};
  return record;
}

TEST(RecordedMotion, GoesStraightFromRowToRowAndStaysAtTheEnds) {
  const auto motion = MotionOf(Recorded({1e-3, 3e-3, 2e-3}), "x");
  ASSERT_TRUE(motion);
  EXPECT_ABS(motion->duration_s, 0.02, 1e-15, "difference of two times near 5 s");
  const std::pair<double, double> places[] = {{-1, 1e-3},   {0, 1e-3},         {0.005, 2e-3},
                                              {0.01, 3e-3}, {0.0125, 2.75e-3}, {0.02, 2e-3},
                                              {100, 2e-3}};
  for (const auto& [t_s, position_m] : places) {
    EXPECT_ABS(motion->displacement(t_s), position_m, 1e-15, "a time near 5 s, rounded");
  }
}

TEST(RecordedMotion, BridgesRowsWithoutAMeasurement) {
  trial::Record record = Recorded({1e-3, 9e-3, 3e-3});
  record.channels[0].statuses[1] = trial::SampleStatus::kInvalid;
  record.channels[0].values[1] = std::numeric_limits<double>::quiet_NaN();
  const auto motion = MotionOf(record, "x");
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->left_out, 1U);
  EXPECT_ABS(motion->displacement(0.01), 2e-3, 1e-15, "a time near 5 s, rounded");
}

TEST(RecordedMotion, IsRefusedWhereThereIsNone) {
  trial::Record record = Recorded({1e-3});
  record.channels[0].statuses[0] = trial::SampleStatus::kInvalid;
  EXPECT_EQ(MotionOf(record, "t.bin").error().Text(),
            "t.bin: holds no measured value to play; give another trial");
  record.channels[0].role = trial::ChannelRole::kVoltage;
  EXPECT_EQ(MotionOf(record, "t.bin").error().Text(),
            "t.bin: has no displacement channel to play; give a trial of a distance sensor");
  EXPECT_EQ(MotionOf(record, "t.bin").error().cause, Cause::kCannotAnswer);
}

}  // namespace
}  // namespace haptometer::tools
