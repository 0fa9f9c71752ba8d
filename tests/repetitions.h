#pragma once

#include <cstdlib>

namespace haptometer::tests {

/// Whether the address sanitizer, which costs a factor of ten, watches.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kIsSanitized = true;
#elif defined(__has_feature)
inline constexpr bool kIsSanitized = __has_feature(address_sanitizer);
#else
inline constexpr bool kIsSanitized = false;
#endif

/// How often a seeded case is repeated: `quick` times, HAPTOMETER_REPETITIONS times in the long run
/// (tests/long/README.md).
inline int Repetitions(int quick) {
  const char* text = std::getenv("HAPTOMETER_REPETITIONS");
  return text == nullptr ? quick : std::atoi(text);
}

}  // namespace haptometer::tests
