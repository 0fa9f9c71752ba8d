#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

/// Samples count as settled where the two continuations agree to this part of the band RMS.
inline constexpr double kSettledTolerance = 2.5e-5;

/// A filtered signal and the part of it that does not depend on what lay beyond its ends.
struct SettledSignal {
  std::vector<double> filtered;  ///< all of it, continued oddly; the ends are not to be trusted
  std::size_t begin = 0;         ///< first settled sample
  std::size_t end = 0;           ///< one past the last; begin == end: nothing has settled
};

/// Filters with zero phase and measures, instead of assuming, where the result has settled.
///
/// The signal is filtered with an odd and with a constant continuation. From the middle outwards,
/// settled samples reach to the last one on each side at which both agree to kSettledTolerance
/// times the RMS over the settled samples themselves (repeated until that holds). Large motion
/// below the band, such as a hand's tremor, so takes more from the ends than a clean tone does.
/// Cost: two zero-phase runs. Memory: twice the signal.
[[nodiscard]] SettledSignal FilterSettled(const FilterDesign& design,
                                          std::span<const double> signal);

}  // namespace haptometer::dsp
