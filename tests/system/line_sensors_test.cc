// The Keyence protocols through real processes: emulate, acquire, and the trial read back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "tests/residual.h"
#include "tests/system/emulated_device.h"

namespace haptometer::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

class LineSensors : public EmulatedDeviceTest {
 protected:
  void EmulateScene(std::vector<std::string> words) {
    words.insert(words.end(), {"--scene", kScene});
    Emulate(words);
  }
  Outcome Acquire(const std::vector<std::string>& options) const {
    std::vector<std::string> arguments{"acquire", "--port", port_,        "--json",
                                       "-o",      trial_,   "--overwrite"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    if (std::ranges::find(options, "--samples") == options.end()) {
      arguments.insert(arguments.end(), {"--samples", "150"});
    }
    return RunProgram(arguments);
  }
  // a loaded machine can keep an answer beyond the patience with it; nothing else may go wrong
  static void ExpectAllGoodOrLate(const json& summary) {
    const json& kinds = summary["bad_by_kind"];
    EXPECT_EQ(summary["bad"], kinds["late"]) << kinds;
    EXPECT_LT(kinds["late"], 15) << kinds;
  }
  // the numbers of one column of the exported trial
  std::vector<double> Column(const std::string& name) const {
    std::istringstream csv(RunProgram({"haptometer", "trial", "export", trial_}).out);
    std::vector<double> numbers;
    std::optional<std::size_t> place;
    for (std::string line; std::getline(csv, line);) {
      if (line.starts_with("#")) continue;
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      if (!place) {
        const auto found = std::ranges::find(cells, name);
        EXPECT_NE(found, cells.end()) << name << " is not in " << line;
        if (found == cells.end()) return {};
        place = static_cast<std::size_t>(found - cells.begin());
      } else {
        numbers.push_back(cells[*place].empty() ? std::nan("") : std::stod(cells[*place]));
      }
    }
    return numbers;
  }
};

TEST_F(LineSensors, ADlRs1aWithTwoAmplifiersIsSetZeroedAndRecorded) {
  EmulateScene({"--baud", "38400", "--amplifiers", "2", "--writable"});
  const Outcome acquired = Acquire({"--baud", "38400", "--set", "averaging=1", "--set",
                                    "sampling=0.33ms", "--device-zero", "--command", "ms"});
  ASSERT_EQ(acquired.status, 0) << acquired.err;
  EXPECT_THAT(acquired.err, HasSubstr("amplifier 00: changed sampling 1ms -> 0.33ms"));
  EXPECT_THAT(acquired.err, HasSubstr("amplifier 01: changed averaging 16 -> 1"));
  const json summary = json::parse(acquired.out);
  EXPECT_EQ(summary["readings"], 150);
  ExpectAllGoodOrLate(summary);
  const std::string info = TrialInfo(trial_).dump();
  EXPECT_THAT(info, HasSubstr("displacement_01"));
  EXPECT_THAT(info, HasSubstr("outputs_01"));
  EXPECT_THAT(info, HasSubstr("\"averages\":1"));
}

TEST_F(LineSensors, ALockedDlRs1aIsStatusThree) {
  EmulateScene({"--baud", "38400"});
  const Outcome acquired = Acquire({"--baud", "38400", "--set", "averaging=1"});
  EXPECT_EQ(acquired.status, 3);
  EXPECT_THAT(acquired.err, HasSubstr("slide the R/W switch of the DL-RS1A to W"));
  EXPECT_FALSE(fs::exists(trial_));
}

TEST_F(LineSensors, ADlEn1IsRecordedOverTcp) {
  EmulateScene({"--protocol", "en1", "--tcp", "127.0.0.1:0", "--amplifiers", "3"});
  const Outcome acquired = Acquire({"--sensor", "keyence-en1", "--rate", "100Hz"});
  ASSERT_EQ(acquired.status, 0) << acquired.err;
  const json summary = json::parse(acquired.out);
  ExpectAllGoodOrLate(summary);
  EXPECT_EQ(summary["sensor"], "keyence-en1");
  EXPECT_LE(summary["rate_hz"].get<double>(), 100 * 1.001) << "never faster than the grid";
  EXPECT_THAT(TrialInfo(trial_).dump(), HasSubstr("\"head\":\"IL-030\""));
}

TEST_F(LineSensors, AnLkgIsRecordedOverATerminal) {
  EmulateScene({"--protocol", "lkg", "--baud", "115200", "--amplifiers", "2"});
  const Outcome acquired =
      Acquire({"--sensor", "keyence-lkg", "--baud", "115200", "--command", "m0"});
  ASSERT_EQ(acquired.status, 0) << acquired.err;
  const json summary = json::parse(acquired.out);
  EXPECT_EQ(summary["readings"], 150);
  ExpectAllGoodOrLate(summary);
  EXPECT_THAT(TrialInfo(trial_).dump(), HasSubstr("displacement_OUT2"));
}

// a value tells the millisecond in which its answer was made, so one that is taken for another's is
// off by the delay; slow: within the maker's second, but beyond the patience with a unit that is
// known
TEST_F(LineSensors, LateAnswersAreNotTakenForOthersByTheRunningProgram) {
  const std::string ramp = directory_ / "ramp.csv";
  {
    std::ofstream file(ramp);
    file << "time_s,displacement_m\n0,-0.0149\n24,0.0091\n";  // 1 um a ms
  }
  for (const std::string fault : {"slow:100", "late:100"}) {
    SCOPED_TRACE(fault);
    Emulate({"--trial", ramp, "--baud", "38400", "--averages", "1", "--fault", fault});
    const Outcome acquired = Acquire({"--baud", "38400", "--samples", "250"});
    ASSERT_EQ(acquired.status, 0) << acquired.err;
    const std::vector<double> times_s = Column("time_s");
    const std::vector<double> values_m = Column("displacement_m");
    ASSERT_EQ(times_s.size(), 250U);
    std::vector<double> offsets_s;
    for (std::size_t i = 0; i < times_s.size(); ++i) {
      if (!std::isnan(values_m[i])) offsets_s.push_back(values_m[i] * 1e3 - times_s[i]);
    }
    EXPECT_LT(offsets_s.size(), 250U) << "some were late";
    EXPECT_GT(offsets_s.size(), 200U);
    const auto [least, most] = std::ranges::minmax(offsets_s);
    // a machine that is busy delays reading by 0.2 s at times
    EXPECT_LT(most - least, 0.3) << "an answer taken for another's is 0.35 s off or more";
  }
}

}  // namespace
}  // namespace haptometer::tests
