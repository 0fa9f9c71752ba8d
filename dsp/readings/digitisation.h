#pragma once

#include <cstddef>
#include <span>

/// What converters do to readings: rounding to their steps, and readings that are repeated where a
/// converter samples faster than its source gives them.
namespace haptometer::dsp {

/// The step that all differences between the values (NaN left out) are multiples of (to 1 %), an
/// eighth of the least one at least; 0 otherwise. Cost: one sort.
[[nodiscard]] double StepOf(std::span<const double> samples);

/// The share of the samples (NaN where there is no measurement) that equal the one before, where a
/// source that is slower than the record's rate explains it; 0 where chance, rounding or a tone's
/// symmetry does.
///
/// Proof are equal samples within motion, which goes on in the same direction before and behind
/// them by more than 2.5 steps (StepOf) each: 2 % of all samples, and twice as many as changes of
/// at most 2.5 steps, of which chance gives a quarter. Not found: repeats where the signal moves by
/// less than its steps. Cost: two looks and a sort at most.
[[nodiscard]] double RepeatedShare(std::span<const double> samples);

/// Half width of the error of the RMS of a sine of `amplitude`, rounded to `step`, with Gaussian
/// noise of `noise_rms` before the rounding.
///
/// The rounded sine's harmonic n differs from the sine's by at most
///   e(n) = (2 q / pi) sum over k >= 1 of |J_n(2 pi k A / q)| exp(-2 pi^2 k^2 s^2 / q^2) / k
/// whatever the offset between steps (Jacobi and Anger's expansion of the rounding error's Fourier
/// series; Widrow and Kollar, Quantization Noise, 2008, 5.3). The RMS is off by e(1) / sqrt(2) at
/// most, and by the power of the harmonics 2 to `harmonics` that the band holds. Noise of half a
/// step makes it 1e-2 of the amplitude of one step. Cost: 200 terms a harmonic; the rest of the
/// series is bounded by |J_n(x)| <= sqrt(2 / (pi x)).
[[nodiscard]] double QuantisationBound(double step, double amplitude, double noise_rms,
                                       int harmonics);

/// What rounding adds to that where tone and rate are commensurate: half width of the RMS's error
/// of a sine of `cycles_per_sample` in `samples` samples, which are of P phases alone.
///
/// Rounding errors of P phases do not average out further: a = q / (2 sqrt(P)), a rectangle with
/// the standard deviation q / sqrt(12 P) of the mean of P errors; noise s ahead of the rounding
/// takes exp(-2 pi^2 s^2 / q^2) of it. P is the least over p of p + N |r| 2 pi A / q, where r is
/// what p samples lack of whole cycles: phases that drift over the N samples are others as far as
/// they move the sine by a step q. Cost: O(sqrt(N A / q)).
[[nodiscard]] double CommensurateBound(double step, double amplitude, double noise_rms,
                                       double cycles_per_sample, std::size_t samples);

}  // namespace haptometer::dsp
