#pragma once

#include <optional>
#include <vector>

namespace haptometer::fit {

/// A pair of poles as the polynomial s^2 + 2 decay s + stiffness, which stays well conditioned when
/// the poles coalesce.
struct PolePair {
  double decay_per_s = 0;
  double stiffness_per_s2 = 0;
};

/// The strongest oscillation's frequency in Hz, from the largest line of the zero-padded spectrum
/// above two periods a record (FFTW); a start value, good to half a line. Nothing for less than 16
/// samples or a constant record.
[[nodiscard]] std::optional<double> StrongestFrequency(const std::vector<double>& values,
                                                       double step_s);

/// Start values of one damped oscillation by the matrix pencil.
///
/// The record is averaged in blocks down to about 8 samples a period and at most 240 samples; of
/// its Hankel matrix (N - L) x (L + 1), L = N/3, the two leading right singular vectors V span the
/// signal, and the poles' powers z are the eigenvalues of V1^+ V2 (V without its last and its first
/// row); trace and determinant of that 2 x 2 matrix give the polynomial, so a double pole is not
/// special. Y. Hua, T. K. Sarkar, IEEE Trans. ASSP 38 (1990) 814-824. Efficient to about 1.1 of the
/// Cramer-Rao bound with five periods or more; the offset must be gone.
///
/// Where noise gives growing or absent poles: the spectrum's frequency with Q = 30.
/// Cost: one SVD of at most 160 x 81, about 1 ms, and one FFT.
[[nodiscard]] std::optional<PolePair> EstimatePoles(const std::vector<double>& values,
                                                    double step_s);

}  // namespace haptometer::fit
