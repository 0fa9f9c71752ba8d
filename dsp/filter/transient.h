#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "dsp/filter/zero_phase.h"

namespace haptometer::dsp {

/// Samples count as settled where the odd continuation's result agrees with that of the expected
/// one to this part of the band RMS, what other expectations differ by from that one added.
inline constexpr double kExpectedTolerance = 9.4e-5;
/// The same with the constant continuation: a guard against a wrong expectation.
inline constexpr double kConstantTolerance = 5e-4;
/// The same with the constant continuation of the fast part alone: vibration, which may end where
/// the signal does.
inline constexpr double kFastTolerance = 2.5e-5;
/// What a settled sample may be wrong by, as a part of the band RMS: the bar that these three hold
/// (docs/developer/hard_case_tests.md; 9.8e-5 at worst of 8000 cuts).
inline constexpr double kSettledError = 1e-4;

/// How far the filtered signal hangs on what lay beyond its ends: the results of other
/// continuations less that of the odd one, in units of what each may differ by (the largest of
/// |difference|/tolerance). Settled: at most the band RMS. Between the parts it is below rounding.
///
/// The continuations are those of dsp/filter/transient.cc. The expected one is within some
/// percent of the truth for a hand's tremor, where the constant one can be far off; where the
/// tremor is not one sine, expectations that saw more or less of it disagree, and less settles.
/// Signals of fewer than kLeastExpectedMotionSamples, or filters as short, have the constant one
/// only, to kFastTolerance.
struct EndDependence {
  std::vector<double> first;  ///< of the first samples; of all, where the signal is short
  std::vector<double> last;   ///< of the last samples; empty where the signal is short
};

/// Measures it: zero-phase runs over the lead-ins at both ends only, whatever the length.
///
/// The filter is linear: differences of continuations are filtered, which are 0 inside the signal.
/// Errors: `read`'s.
[[nodiscard]] Result<EndDependence> MeasureEndDependence(const ZeroPhaseBlocks& blocks,
                                                         const ReadSamples& read,
                                                         ZeroPhaseBlocks::Scratch& scratch);

/// The RMS of the filtered signal over a range of at least one sample.
using RangeRms = std::function<double(const SampleRange& range)>;

/// What has settled of a filtered signal of `size` samples, continued oddly.
///
/// The longest stretch in which the dependence is at most the RMS over that stretch itself
/// (repeated until that holds). Large motion below the band, such as a hand's tremor, so takes more
/// from the ends than a clean tone does. A stretch shorter than `least` is widened to that for the
/// RMS, which a part of a period would say wrongly. Nothing settled: count 0.
[[nodiscard]] SampleRange SettledRange(std::size_t size, const EndDependence& dependence,
                                       const RangeRms& rms, std::size_t least);

/// `least` for samples: four time constants of the slowest pole, 2.8 periods of the lower corner
/// for a band-pass of order 6.
[[nodiscard]] std::size_t LeastRmsSamples(const FilterDesign& design);

/// Motion slower than a band at one end of a signal, such as a hand's drift and tremor, and how it
/// is expected to go on:
///
///   a + b t + sum over the sines of c cos(w t) + s sin(w t),   t in samples from the signal's
///   middle.
struct ExpectedMotion {
  struct Sine {
    double rad_per_sample = 0;
    double cosine = 0;
    double sine = 0;
  };

  double offset = 0;
  double slope = 0;
  std::vector<Sine> sines;
  double middle = 0;  ///< index of t = 0

  /// Its value at index `k`, also beyond the signal.
  [[nodiscard]] double At(double k) const;
  /// Its values at the `count` indices from `first` on, each within rounding of At.
  [[nodiscard]] std::vector<double> From(double first, std::size_t count) const;
};

/// Fewest samples that FitExpectedMotion takes.
inline constexpr std::size_t kLeastExpectedMotionSamples = 128;
/// The fastest sine that it looks for turns by this over the signal.
inline constexpr double kFastestExpectedRad = 60;

/// Fits it by least squares to the means of 64 equal pieces, which keep faster motion out, with
/// `sines` (1 or 2) sines, each where the residual is least, of 2 to 60 rad over the signal. At
/// least kLeastExpectedMotionSamples. Cost: 0.5 ms, 3 ms with two.
[[nodiscard]] ExpectedMotion FitExpectedMotion(std::span<const double> signal, int sines);

}  // namespace haptometer::dsp
