#pragma once

#include <fmt/core.h>

#include <string>

namespace haptometer::internal {

/// Prints `FILE:LINE: check failed: EXPRESSION (DETAIL)` on stderr and aborts.
[[noreturn]] void CheckFailed(const char* file, int line, const char* expression,
                              const std::string& detail);

}  // namespace haptometer::internal

/// Guards against a programmer's error; always on. The further arguments are an fmt format and its
/// values, printed when the condition is false:
///   HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz);
/// Anything that a user, file or device can cause is a Result (base/result.h), never a check.
#define HAPTOMETER_CHECK(condition, ...)                                  \
  do {                                                                    \
    if (!(condition)) {                                                   \
      ::haptometer::internal::CheckFailed(__FILE__, __LINE__, #condition, \
                                          fmt::format(__VA_ARGS__));      \
    }                                                                     \
  } while (false)
