#pragma once

#include <cstdint>
#include <optional>
#include <span>

/// Whether a tone was limited: by the range of a sensor or converter, or ahead of it.
namespace haptometer::dsp {

/// What samples at their extreme say of a limit of the sensor or its converter.
enum class ClippingVerdict : std::uint8_t {
  kNone,
  kUndecided,  ///< clipped, or the motion's own shape
  kClipped,
  kBelowNoise,  ///< limited ahead of the noise that the samples hold
};

/// Whether samples are clipped, and which.
struct Clipping {
  ClippingVerdict verdict = ClippingVerdict::kNone;
  double share = 0;                  ///< of the measured samples, at a rail; 0 for kNone
  std::optional<double> low_rail{};  ///< in the samples' unit
  std::optional<double> high_rail{};
  double beyond = 0;  ///< kBelowNoise: how far the tone would go beyond the rails, on average
};

/// Whether a tone is clipped, from `samples` before any filter (NaN where there is no measurement)
/// at `rate_hz`, with the tone at `tone_hz`.
///
/// Equal samples at an extreme are no proof by themselves: of a clean tone of 400 Hz at 2 kHz 19 %
/// may be its maximum. They are where they are ten times as many as those of any other value, which
/// neither rounding nor few phases give. Else the tone, its harmonics up to the third where they
/// explain the samples better, and a quartic drift are fitted to the samples off the rails, in
/// blocks of 0.1 s. Clipped: at the railed samples they lie beyond the rail, on average, by more
/// than two steps (StepOf), four standard deviations of that mean and 1e-5 of the amplitude, which
/// is the rounding of numbers with six digits. Undecided: the sampled phases (as where rate and
/// tone are commensurate) do not determine the harmonics, so that what flattens the tone may be its
/// own; more than half of the samples are at one rail, as of pulses between rests, and no limited
/// tone explains them; or nine harmonics of its own explain all samples to a step, and better than
/// a limited tone (as below). None also where one sine fits all samples, and where less than 0.1 %
/// are at a rail.
///
/// Else a limit that acts ahead of noise, as of an amplifier before a converter, is sought in 24
/// evenly spread blocks: at the densest values of the upper half, the lower one or both; samples
/// from four deviations of the noise inwards are railed, then those where the fit is. The fit to
/// the others, with one harmonic or three and an amplitude that changes in the block, must lie
/// beyond these as above, and ending it there must explain all samples better than the tone with
/// nine harmonics of its own does: half the samples times the logarithm of the variances that are
/// left exceeds eight times sqrt(d / 2), its deviation by d terms more where neither has anything
/// to explain. No limit is where the fit lies beyond it by more than 0.45 of what the samples span,
/// 0.9 of it at one limit alone: a square wave has levels of its own.
///
/// False alarms, misses and what is undecided are counted in
/// tests/dsp/readings/clipping_test.cc. A trapezoid with noise is a limited tone to this. Not
/// found: a limit below noise that lowers the tone by less than about 1 %, that is reached in few
/// of the blocks or on one side for more than half of the period, one of a tone with strong
/// harmonics above the third or with an amplitude that changes faster than once in 0.1 s, one that
/// sets in softly (softer than x / (1 + |x/c|^16)^(1/16)), and one of a tone with fewer than 21
/// phases. Cost: one look at samples; of those with a rail 300 flops each, 1500 where the fit lies
/// beyond it; of at most 24 576 of them 4000 each.
[[nodiscard]] Clipping FindClipping(std::span<const double> samples, double rate_hz,
                                    double tone_hz);

}  // namespace haptometer::dsp
