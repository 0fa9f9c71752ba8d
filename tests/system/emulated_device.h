#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tests/system/process.h"

namespace haptometer::tests {

/// The scene that the emulated devices play.
extern const std::string kScene;

/// `haptometer trial info --json` of the trial at `path`, also while it is being written.
[[nodiscard]] nlohmann::json TrialInfo(const std::string& path);

/// A test with a directory of its own and a device in it, `haptometer emulate`.
class EmulatedDeviceTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  /// Starts `haptometer emulate` with `words` and stores its port; the one before ends first.
  void Emulate(const std::vector<std::string>& words);

  /// Ends the device. Its link goes first: the number of its terminal may be another's at once,
  /// and who reconnects would find that one by it.
  void EndDevice();

  /// Waits until `recorder` has put more than `rows` rows into trial_ that a reader sees, which
  /// takes it a flush; 60 s at most.
  [[nodiscard]] ::testing::AssertionResult WaitForRows(Process& recorder, int rows) const;

  const std::filesystem::path directory_;
  const std::string trial_;
  std::unique_ptr<Process> emulator_;
  std::string port_;

  EmulatedDeviceTest();
};

}  // namespace haptometer::tests
