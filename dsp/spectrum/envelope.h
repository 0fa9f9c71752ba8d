#pragma once

#include <complex>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// The amplitude of a tone over time, as moving windows see it.
struct Envelope {
  std::vector<double> amplitude;  ///< >= 0, in the signal's unit; one per step
  double start_s = 0;             ///< of the first value, counted from the signal's first sample
  double step_s = 0;              ///< between values
  double support_s =
      0;  ///< a value depends on samples within half of this of its time, on no others
  double own_rise_s = 0;  ///< 10-90 % rise time that a sudden tone shows
};

/// How a tone is demodulated.
struct Demodulation {
  double rate_hz = 0;
  double tone_hz = 0;
  /// Length of the moving window. Its noise bandwidth is 1.5 tone / periods, and multiples of the
  /// tone are rejected from 3 up.
  double periods = 3;
};

/// Amplitude of the tone in a moving window: at each step the least-squares fit of the tone and a
/// parabola, under Hann weights.
///
/// The parabola takes an offset, a slope and the bend of a slow motion out, so no filter needs to
/// settle before it, and nothing before or after a window can ring into it: a value is exactly zero
/// while its window has seen nothing but rest. A sudden tone rises over 0.48 of the window
/// (own_rise_s), half of it on either side of the truth. Empty where the signal is shorter than a
/// window, the window holds fewer than 8 samples, or the tone is not below rate/2.
/// Cost: about 100 flops per sample (32 steps a window); memory: the envelope.
[[nodiscard]] Envelope DemodulateTone(std::span<const double> signal, const Demodulation& how);

/// x + j H[x]: magnitude and phase of a band-passed signal, by FFT (frequencies below zero left
/// out).
///
/// The signal is taken as periodic: within about a period of the band's lower corner of either end
/// the result is not to be trusted. 1 to kLongestTransform samples. Memory: five copies.
[[nodiscard]] std::vector<std::complex<double>> AnalyticSignal(std::span<const double> signal);

}  // namespace haptometer::dsp
