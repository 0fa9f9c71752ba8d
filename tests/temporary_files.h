#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace haptometer::tests {

/// A test with a directory of its own, which goes when the test ends.
class TemporaryFiles : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(directory_); }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  /// The path of a file `name` that holds `text`.
  [[nodiscard]] std::string File(const std::string& name, const std::string& text) const {
    std::ofstream out(directory_ / name);
    out << text;
    return directory_ / name;
  }

  /// What the file `name` holds; nothing where there is none.
  [[nodiscard]] std::string Content(const std::string& name) const {
    std::ifstream in(directory_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  const std::filesystem::path directory_ =
      std::filesystem::path(::testing::TempDir()) /
      (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + "_" +
       std::to_string(::getpid()));
};

}  // namespace haptometer::tests
