#pragma once

#include <string_view>

namespace haptometer {

/// The band of tactile vibration that is measured and asked for where none is stated, in Hz: the
/// range of interest of J. Lindsay's thesis, chapter 3, above the hand's tremor.
inline constexpr double kDefaultLowerHz = 20;
inline constexpr double kDefaultUpperHz = 500;
/// The same as --band takes it.
inline constexpr std::string_view kDefaultBand = "20-500Hz";

}  // namespace haptometer
