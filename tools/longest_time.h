#pragma once

namespace haptometer::tools {

/// The longest time in s that may be asked for, some 30 years: it still fits in nanoseconds.
inline constexpr double kLongestTimeS = 1e9;

}  // namespace haptometer::tools
