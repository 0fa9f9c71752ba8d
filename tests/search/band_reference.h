#pragma once

#include <complex>
#include <vector>

#include "tests/search/draws.h"

/// A Butterworth band-pass by the textbook, in long double: poles of the low-pass prototype on the
/// unit circle, moved by s -> (s^2 + w0^2)/(bw s), then by z = (1 + s)/(1 - s).
namespace haptometer::search {

struct BandReference {
  int order = 0;
  std::vector<std::complex<Real>> less_one{};  ///< 2 order poles z, each as z - 1
  Real gain = 0;                               ///< of prod (z^2 - 1) / prod (z - pole)
  Real slowest = 0;                            ///< least 1 - |z|
  Real lowest = 0;                             ///< least |z - 1|: rad a sample
  Real narrowness = 0;                         ///< w0 / bw, of the warped corners
};

/// `together`: -3 dB at the corners after two passes, not after each.
[[nodiscard]] BandReference MakeBandReference(int order, double lower_hz, double upper_hz,
                                              double rate_hz, bool together);

/// One pass over `x` from rest.
void FilterOnce(const BandReference& band, std::vector<Real>& x);

/// |H|^2: the gain of two passes.
[[nodiscard]] Real GainOfTwo(const BandReference& band, double frequency_hz, double rate_hz);

}  // namespace haptometer::search
