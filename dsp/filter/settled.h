#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "dsp/filter/zero_phase_blocks.h"

namespace haptometer::dsp {

/// Samples count as settled where the two continuations agree to this part of the band RMS.
inline constexpr double kSettledTolerance = 2.5e-5;

/// How far the filtered signal hangs on what lay beyond its ends: the odd continuation's result
/// less the constant one's. Between the two parts it is below rounding.
struct EndDependence {
  std::vector<double> first;  ///< of the first samples; of all, where the signal is short
  std::vector<double> last;   ///< of the last samples; empty where the signal is short
};

/// Measures it: a zero-phase run over the lead-ins at both ends only, whatever the length.
///
/// The filter is linear: the difference of the two continuations is filtered once. Errors:
/// `read`'s.
[[nodiscard]] Result<EndDependence> MeasureEndDependence(const ZeroPhaseBlocks& blocks,
                                                         const ReadSamples& read,
                                                         ZeroPhaseBlocks::Scratch& scratch);

/// The RMS of the filtered signal over a range of at least one sample.
using RangeRms = std::function<double(const SampleRange& range)>;

/// What has settled of a filtered signal of `size` samples, continued oddly.
///
/// From the middle outwards, settled samples reach to the last one on each side at which the
/// dependence is at most kSettledTolerance times the RMS over the settled samples themselves
/// (repeated until that holds). Large motion below the band, such as a hand's tremor, so takes more
/// from the ends than a clean tone does. Nothing settled: count 0.
[[nodiscard]] SampleRange SettledRange(std::size_t size, const EndDependence& dependence,
                                       const RangeRms& rms);

/// A filtered signal and the part of it that does not depend on what lay beyond its ends.
struct SettledSignal {
  std::vector<double> filtered;  ///< all of it, continued oddly; the ends are not to be trusted
  std::size_t begin = 0;         ///< first settled sample
  std::size_t end = 0;           ///< one past the last; begin == end: nothing has settled
};

/// Filters with zero phase (FilterZeroPhase) and measures, instead of assuming, where the result
/// has settled (SettledRange).
[[nodiscard]] SettledSignal FilterSettled(const FilterDesign& design,
                                          std::span<const double> signal, int threads = 1);

}  // namespace haptometer::dsp
