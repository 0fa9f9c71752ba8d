#pragma once

#include <cstdlib>

namespace haptometer::tests {

#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kIsSanitized = true;
#elif defined(__has_feature)
inline constexpr bool kIsSanitized = __has_feature(address_sanitizer);
#else
inline constexpr bool kIsSanitized = false;
#endif

/// How often a seeded experiment is repeated: `often`, a tenth of it under a sanitizer,
/// or what HAPTOMETER_REPETITIONS says.
inline int Repetitions(int often) {
  const char* text = std::getenv("HAPTOMETER_REPETITIONS");
  return text != nullptr ? std::atoi(text) : kIsSanitized ? often / 10 : often;
}

}  // namespace haptometer::tests
