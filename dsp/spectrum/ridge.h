#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// Pieces of a signal that follow each other, all of one size; they may overlap.
struct RidgeFrames {
  std::function<std::span<const double>(std::size_t)> frame;  ///< samples of frame k
  std::size_t count = 0;
  double rate_hz = 0;  ///< of the samples
};

/// Frequencies of the strongest line within [lower_hz, upper_hz] through the spectra of `frames`,
/// one a frame, in hertz.
///
/// With Hann's window and zeros up to four times a frame, the ridge is the path b(k) through the
/// bins that makes
///   sum over k of |X_k(b(k))| - bin_cost M |b(k) - b(k - 1)|
/// greatest, M the largest magnitude of all and two bins a frame at most; a jump to any other bin
/// costs M (Viterbi's algorithm: Forney, Proceedings of the IEEE 61(3), 1973, p. 268). Between
/// bins, a parabola through the logarithms of three magnitudes. `lower_hz` < `upper_hz` <= rate / 2
/// with three bins between them. Cost: one transform a frame; 10 B a bin and frame.
[[nodiscard]] std::vector<double> FindRidge(const RidgeFrames& frames, double lower_hz,
                                            double upper_hz, double bin_cost);

}  // namespace haptometer::dsp
