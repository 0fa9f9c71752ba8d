#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace haptometer::tools {

/// What a verb that was called in this process left behind.
struct Outcome {
  int status = -1;
  std::string out;
  std::string err;
};

/// Calls `verb` with `words` behind `name` and captures both outputs.
inline Outcome Captured(int (*verb)(int, const char* const*), const std::string& name,
                        const std::vector<std::string>& words) {
  std::vector<const char*> argv{name.c_str()};
  for (const std::string& word : words) argv.push_back(word.c_str());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.status = verb(static_cast<int>(argv.size()), argv.data());
  std::fflush(nullptr);
  outcome.out = ::testing::internal::GetCapturedStdout();
  outcome.err = ::testing::internal::GetCapturedStderr();
  return outcome;
}

}  // namespace haptometer::tools
