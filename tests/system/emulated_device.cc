#include "tests/system/emulated_device.h"

#include <unistd.h>

#include <nlohmann/json.hpp>

namespace haptometer::tests {

namespace fs = std::filesystem;

const std::string kScene = std::string(HAPTOMETER_FIXTURES) + "/lra_adapter.toml";

nlohmann::json TrialInfo(const std::string& path) {
  return nlohmann::json::parse(RunProgram({"haptometer", "trial", "info", path, "--json"}).out,
                               nullptr, /*allow_exceptions=*/false);
}

EmulatedDeviceTest::EmulatedDeviceTest()
    : directory_(fs::path(::testing::TempDir()) / ("system_test_" + std::to_string(::getpid()))),
      trial_(directory_ / "trial.bin") {}

void EmulatedDeviceTest::SetUp() { fs::create_directories(directory_); }

void EmulatedDeviceTest::TearDown() { fs::remove_all(directory_); }

void EmulatedDeviceTest::Emulate(const std::vector<std::string>& words) {
  std::vector<std::string> arguments{"haptometer", "emulate"};
  arguments.insert(arguments.end(), words.begin(), words.end());
  EndDevice();
  emulator_ = std::make_unique<Process>(arguments);
  const auto port = emulator_->WaitForLine("ready ", 20);
  ASSERT_TRUE(port);
  port_ = *port;
}

void EmulatedDeviceTest::EndDevice() {
  if (fs::is_symlink(port_)) fs::remove(port_);
  emulator_.reset();
}

::testing::AssertionResult EmulatedDeviceTest::WaitForRows(Process& recorder, int rows) const {
  return recorder.WaitUntil(
      [&] {
        if (!fs::exists(trial_)) return false;
        const nlohmann::json info = TrialInfo(trial_);
        return info.is_object() && info["rows"] > rows;
      },
      60);
}

}  // namespace haptometer::tests
