#pragma once

#include <span>

/// What rounding to the steps of a converter may do to a sine.
namespace haptometer::dsp {

/// The step that all of `samples` are multiples of, apart from an offset: the least change from
/// sample to sample, if every other change is a multiple of it (to 1 %); 0 otherwise.
[[nodiscard]] double StepOf(std::span<const double> samples);

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

}  // namespace haptometer::dsp
