#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

/// What may lie beyond the end of a signal: other continuations less the odd one, nearest sample
/// first, as far as they differ.
struct EndContinuations {
  /// The signal stays where it ends.
  std::vector<double> constant;
  /// It goes on as it moved: drift and one sine below the band (dsp/filter/expected_motion.h), seen
  /// for 12 time constants of the filter's slowest pole, and the strongest tone beside them. Less
  /// `constant`, not the odd one: it differs for 8 time constants. Empty where fewer than
  /// kLeastExpectedMotionSamples were seen.
  std::vector<double> expected;
  /// Only what is left without the slow motion stays where it ends; as long as `expected`.
  std::vector<double> fast;
  /// What other expectations of the slow motion (two sines seen for 18 time constants, one for 8)
  /// differ by from the expected one; as long as `expected`.
  std::array<std::vector<double>, 2> doubts;
};

/// The first `count` samples of `constant`. Motion is expected for 8 time constants; later it stays
/// where it is. Cost: 5 ms and an FFT of 12 time constants.
[[nodiscard]] EndContinuations ContinueEnd(const FilterDesign& design,
                                           std::span<const double> signal, std::size_t count);

}  // namespace haptometer::dsp
