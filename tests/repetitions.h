#pragma once

#include <cstdlib>

namespace haptometer::tests {

/// How often a seeded experiment is repeated: `few`, or what HAPTOMETER_REPETITIONS says.
inline int Repetitions(int few) {
  const char* text = std::getenv("HAPTOMETER_REPETITIONS");
  return text != nullptr ? std::atoi(text) : few;
}

}  // namespace haptometer::tests
