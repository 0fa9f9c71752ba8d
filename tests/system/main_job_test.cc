// The main job through real processes and a real pseudo-terminal: emulate, acquire, analyze.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/residual.h"
#include "tests/system/emulated_device.h"

namespace haptometer::tests {
namespace {

using nlohmann::json;

// closing a file waits for the disk, which may have a build to write first
constexpr double kEndS = 60;

class MainJob : public EmulatedDeviceTest {
 protected:
  void SetUp() override {
    EmulatedDeviceTest::SetUp();
    Emulate({"--scene", kScene, "--protocol", "stream", "--baud", "921600"});
  }
  std::vector<std::string> Acquire(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"acquire", "--port", port_, "--sensor", "stream",
                                       "--baud",  "921600", "-o",  trial_,     "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(MainJob, AStreamedTrialGivesTheScenesRmsAndFrequency) {
  // Where the machine stands still, lines come late: by more than a gap, or the first ones so that
  // the same count took less time. Not in three recordings.
  json summary = {{"gaps", 1}, {"rate_hz", 0}};
  const auto came_late = [&] {
    return summary["gaps"] != 0 || std::abs(summary["rate_hz"].get<double>() - 1e4) > 10;
  };
  for (int recording = 0; recording < 3 && came_late(); ++recording) {
    const Outcome acquired = RunProgram(Acquire({"--duration", "3s", "--overwrite"}));
    ASSERT_EQ(acquired.status, 0) << acquired.err;
    summary = json::parse(acquired.out);
    EXPECT_EQ(summary["bad"], 0);
  }
  // a busy machine may read too late: what the device says that it lost is then a true gap
  emulator_->Signal(SIGINT);
  const std::string remarks = emulator_->Wait(kEndS).err;
  const bool read_all = remarks.find("lines were lost") == std::string::npos;
  EXPECT_TRUE(!read_all || summary["gaps"] == 0) << summary["gaps"] << " gaps; " << remarks;
  EXPECT_REL(summary["rate_hz"].get<double>(), 10000.0, 1e-3, "a 3 s count of a 10 kHz head");

  const json info = TrialInfo(trial_);
  EXPECT_THAT(info.dump(), ::testing::HasSubstr("\"emulated device: "));

  const Outcome analyzed = RunProgram({"analyze", trial_, "--json"});
  ASSERT_EQ(analyzed.status, 0) << analyzed.err;
  const json trial = json::parse(analyzed.out)["trials"][0];
  // truth: the exact steady state of the scene (tests/sim/linear/steady_state_test.cc)
  EXPECT_REL(trial["band_rms_m"].get<double>(), 0.2001762058e-3, 1e-2, "the bar of the product");
  EXPECT_ABS(trial["tone_frequency_hz"].get<double>(), 225.0, 0.05, "the bar of the product");
}

TEST_F(MainJob, CtrlCFinishesTheFile) {
  Process acquire(Acquire({}));
  ASSERT_TRUE(WaitForRows(acquire, 10'000));
  acquire.Signal(SIGINT);
  EXPECT_EQ(acquire.Wait(kEndS).status, 130);
  const json info = TrialInfo(trial_);
  EXPECT_EQ(info["closed"], true);
  EXPECT_GT(info["rows"].get<int>(), 10'000);
}

TEST_F(MainJob, SigtermFinishesTheFile) {
  Process acquire(Acquire({}));
  ASSERT_TRUE(WaitForRows(acquire, 0));
  acquire.Signal(SIGTERM);
  EXPECT_EQ(acquire.Wait(kEndS).status, 143);
  const json info = TrialInfo(trial_);
  EXPECT_EQ(info["closed"], true);
}

TEST_F(MainJob, KillMinusNineKeepsEverythingUpToTheLastFlush) {
  Process acquire(Acquire({}));
  ASSERT_TRUE(WaitForRows(acquire, 20'000));
  acquire.Signal(SIGKILL);
  EXPECT_EQ(acquire.Wait(kEndS).status, 128 + SIGKILL);
  const json info = TrialInfo(trial_);
  EXPECT_EQ(info["closed"], false);
  // what could be read before is still there
  EXPECT_GT(info["rows"].get<int>(), 20'000);
  EXPECT_EQ(RunProgram({"analyze", trial_, "--json"}).status, 0);
}

TEST_F(MainJob, AReplayGivesTheSameRows) {
  ASSERT_EQ(RunProgram(Acquire({"--samples", "5000"})).status, 0);
  const std::string again = directory_ / "again.bin";
  const Outcome replayed =
      RunProgram({"acquire", "--sensor", "replay", "--port", trial_, "-o", again, "--json"});
  ASSERT_EQ(replayed.status, 0) << replayed.err;
  EXPECT_EQ(json::parse(replayed.out)["readings"], 5000);
  const Outcome first = RunProgram({"haptometer", "trial", "export", trial_});
  const Outcome second = RunProgram({"haptometer", "trial", "export", again});
  const auto values = [](const std::string& csv) { return csv.substr(csv.find("\ntime_s")); };
  EXPECT_EQ(values(first.out), values(second.out));
}

}  // namespace
}  // namespace haptometer::tests
