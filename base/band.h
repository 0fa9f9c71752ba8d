#pragma once

#include <string_view>

namespace haptometer {

/// The band of tactile vibration that is measured and asked for where none is stated, in Hz: the
/// range of interest of J. Lindsay's thesis, chapter 3, above the hand's tremor.
inline constexpr double kDefaultLowerHz = 20;
inline constexpr double kDefaultUpperHz = 500;
/// The same as --band takes it.
inline constexpr std::string_view kDefaultBand = "20-500Hz";

/// New readings a period that a frequency needs to be told from its alias, with room for the slope
/// of an anti-alias filter: the customary factor of vibration analysers.
inline constexpr double kReadingsPerPeriod = 2.56;
/// Relative difference that two clocks, a sensor's and a computer's, may have and still be at one
/// rate: quartzes keep to 50 ppm each.
inline constexpr double kOneRate = 1e-4;

/// New readings a second that a band up to `upper_hz` needs: 2.56 x upper_hz.
[[nodiscard]] constexpr double NeededRateHz(double upper_hz) {
  return kReadingsPerPeriod * upper_hz;
}

/// Highest frequency that so many new readings a second can show: rate / 2.56, in Hz.
[[nodiscard]] constexpr double HighestObservableHz(double rate_hz) {
  return rate_hz / kReadingsPerPeriod;
}

/// Whether so many new readings a second, as a clock measured them, observe a band up to
/// `upper_hz`: they may be fewer than needed by what a clock is off.
[[nodiscard]] constexpr bool Observes(double rate_hz, double upper_hz) {
  return rate_hz >= (1 - kOneRate) * NeededRateHz(upper_hz);
}

}  // namespace haptometer
