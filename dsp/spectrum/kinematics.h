#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// Central differences that multiply by j 2 pi f up to a frequency:
///
///   x'[n] = rate sum over k = 1 .. M of c_k (x[n+k] - x[n-k]),
///   c_k = (-1)^(k+1) M!^2 / (k (M-k)! (M+k)!)
///
/// The response is j rate D(theta), theta = 2 pi f / rate, flat to order 2M at 0, with
/// 0 <= theta - D(theta) <= theta 4^M / binomial(2M, M) sin(theta/2)^(2M): a bound, not an
/// estimate.
struct Differentiator {
  std::vector<double> taps;   ///< c_1 .. c_M
  double relative_error = 0;  ///< that bound at the upper frequency; less below
};

/// The shortest differentiator within 1e-8 up to `upper_hz`; nothing where M would exceed 64, for
/// `upper_hz` above 0.32 rate.
///
/// Maximally flat: Khan and Ohba, Electronics Letters 34(20), 1998, p. 1919. Chosen over a division
/// in the FFT's bins because it sees M samples on either side only: no window, no leakage, no
/// whole periods, and any band-limited signal keeps the bound.
[[nodiscard]] std::optional<Differentiator> DesignDifferentiator(double rate_hz, double upper_hz);

/// Velocity and acceleration of a vibration, per second and per second squared of the signal's
/// unit.
struct Kinematics {
  double velocity_rms = 0;
  double velocity_peak = 0;  ///< largest magnitude among the samples
  double acceleration_rms = 0;
  double acceleration_peak = 0;
  std::size_t begin = 0;      ///< first sample used; later than asked where the signal begins
  std::size_t end = 0;        ///< one past the last
  double relative_error = 0;  ///< bound of the method, for velocity; twice that for acceleration
};

/// Velocity and acceleration over the samples [begin, end) of a signal whose power lies below
/// `upper_hz`, from the differentiator once and twice.
///
/// The signal's samples outside of the window are used too (2 M on either side); where there are
/// too few, the window shrinks. For a window of whole periods of a tone the RMS values are the
/// tone's. Above `upper_hz` the gain falls below 2 pi f, so what a band-pass has left there is not
/// raised. Nothing where no differentiator reaches `upper_hz`, or the window is left empty.
/// Cost: 4 M flops per sample; memory: two copies of the window.
[[nodiscard]] std::optional<Kinematics> DescribeKinematics(std::span<const double> signal,
                                                           double rate_hz, double upper_hz,
                                                           std::size_t begin, std::size_t end);

}  // namespace haptometer::dsp
