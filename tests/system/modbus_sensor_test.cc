// A Modbus sensor through real processes: emulate, acquire, and what the trial then says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/system/emulated_device.h"

namespace haptometer::tests {
namespace {

using nlohmann::json;

class ModbusSystem : public EmulatedDeviceTest, public ::testing::WithParamInterface<bool> {};

TEST_P(ModbusSystem, ATrialHoldsWhatTheSensorSent) {
  const bool over_tcp = GetParam();
  std::vector<std::string> words{"--scene",   kScene,        "--protocol", "modbus",
                                 "--profile", "baumer-om20", "--fault",    "invalid:10"};
  if (over_tcp) words.insert(words.end(), {"--tcp", "127.0.0.1:0"});
  Emulate(words);

  const Outcome acquired =
      RunProgram({"acquire", "--sensor", "modbus", "--profile", "baumer-om20", "--port", port_,
                  "--samples", "100", "--rate", "50Hz", "-o", trial_, "--json"});
  ASSERT_EQ(acquired.status, 0) << acquired.err;
  // a serial line limits the rate; over TCP nobody knows that of the sensor
  EXPECT_THAT(acquired.err,
              ::testing::HasSubstr(over_tcp ? "the rate at which baumer-om20 measures is not known"
                                            : "readings at 91.34 Hz at most"));
  const json summary = json::parse(acquired.out);
  EXPECT_EQ(summary["readings"], 100);
  // one answer in ten; a reading that a busy machine delays by half a second may shift the count
  const int invalid = summary["bad_by_kind"]["invalid"];
  EXPECT_GE(invalid, 8);
  EXPECT_LE(invalid, 12);

  const json info = TrialInfo(trial_);
  EXPECT_EQ(info["statuses"]["invalid"], invalid);
  EXPECT_THAT(info.dump(), ::testing::HasSubstr(over_tcp ? "Modbus TCP" : "Modbus RTU"));
  EXPECT_THAT(info.dump(), ::testing::HasSubstr("modbus_profile"));
}

INSTANTIATE_TEST_SUITE_P(Wires, ModbusSystem, ::testing::Bool());

TEST(ModbusCommand, TellsTheErrorsOnTheWireAfterTheRecording) {
  Process emulator({"haptometer", "emulate", "--scene", kScene, "--protocol", "modbus", "--profile",
                    "baumer-om20", "--fault", "crc:5"});
  const auto port = emulator.WaitForLine("ready ", 20);
  ASSERT_TRUE(port);
  const std::string trial = std::filesystem::path(::testing::TempDir()) /
                            ("modbus_errors_" + std::to_string(::getpid()) + ".bin");
  const Outcome acquired = RunProgram({"acquire", "--sensor", "modbus", "--profile", "baumer-om20",
                                       "--port", *port, "--samples", "30", "-o", trial});
  std::filesystem::remove(trial);
  EXPECT_EQ(acquired.status, 0) << acquired.err;
  EXPECT_THAT(acquired.err, ::testing::HasSubstr("errors on the wire: "));
  // what was said before the recording is not said again
  const auto first = acquired.err.find("readings at 91.34 Hz at most");
  EXPECT_NE(first, std::string::npos);
  EXPECT_EQ(acquired.err.find("readings at 91.34 Hz at most", first + 1), std::string::npos);
}

TEST(ModbusCommand, SaysWhatIsMissing) {
  const Outcome bare = RunProgram({"acquire", "--sensor", "modbus", "--port", "x", "-o", "/x"});
  EXPECT_EQ(bare.status, 2);
  EXPECT_THAT(bare.err, ::testing::HasSubstr("--profile"));
  const Outcome fault = RunProgram({"haptometer", "emulate", "--scene", kScene, "--fault", "crc"});
  EXPECT_EQ(fault.status, 2);
  EXPECT_THAT(fault.err, ::testing::HasSubstr("'crc' is for --protocol modbus"));
}

}  // namespace
}  // namespace haptometer::tests
