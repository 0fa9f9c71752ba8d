#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "fuzz/require.h"

namespace haptometer::fuzz {

/// What a verb answers with on standard output is not looked at: it goes to /dev/null.
inline void DiscardOutput() {
  static const bool discarded = std::freopen("/dev/null", "w", stdout) != nullptr;
  Require(discarded);
}

/// Runs a verb in this process, with words behind its name. Its status must be one of those that
/// docs/reference/common.md lists.
inline void RunVerb(int (*run)(int argc, const char* const* argv),
                    const std::vector<std::string>& words) {
  DiscardOutput();
  std::vector<const char*> argv;
  argv.reserve(words.size() + 1);
  for (const std::string& word : words) argv.push_back(word.c_str());
  argv.push_back(nullptr);
  const int status = run(static_cast<int>(words.size()), argv.data());
  Require(status >= 0 && status <= 3);
}

}  // namespace haptometer::fuzz
