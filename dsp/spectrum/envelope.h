#pragma once

#include <complex>
#include <optional>
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

/// Where the quiet and the steady amplitude of an edge are read, in the envelope's time.
struct EdgeSearch {
  double quiet_begin_s = 0;
  double quiet_end_s = 0;
  double steady_begin_s = 0;
  double steady_end_s = 0;
};

/// An edge of a vibration: how its amplitude comes up, or dies away, between quiet and steady.
///
/// Levels are amplitudes, with the quiet part's power (noise) taken off: 0 is quiet, 1 is steady
/// (the root of the mean square over each part). The edge is where the amplitude passes
/// `low_level`: 10 %, or three times the noise where that is more.
struct Edge {
  double time_s = 0;              ///< where the amplitude passes `low_level`
  double time_uncertainty_s = 0;  ///< standard: noise, and what the window's own rise may hide
  double low_level = 0.1;         ///< as a share of the steady amplitude
  /// Time from 10 % to 90 %; nothing where `low_level` had to be raised, or where the edge is too
  /// sudden for the window (below two thirds of its own rise).
  std::optional<double> rise_s;
  double rise_uncertainty_s = 0;         ///< standard, where rise_s is known
  std::optional<double> rise_at_most_s;  ///< where it is too sudden: an upper bound
  double steady_amplitude = 0;
  double quiet_amplitude = 0;  ///< root mean square of the envelope there
};

/// The edge from quiet to steady that follows it: the onset of a vibration.
///
/// The envelope passes the half level first; from there the low level is sought backwards and 90 %
/// forwards, between values by a straight line. What the envelope's window adds is taken off:
/// times are drawn towards the half level by sqrt(1 - (own_rise/measured rise)^2), which is exact
/// on average over the tone's phase, for a sudden edge and for one that is slow against the window.
/// For sudden, exponential and straight rises of any duration and phase the time is off by at most
/// 0.18 and the rise by 0.12 of own_rise_s (tests; at 225 Hz and three periods 1.2 ms and 0.8 ms),
/// which the uncertainties hold. No zero-phase filter is involved, so nothing rings ahead of the
/// truth. Nothing ("not determined") where a part lies outside of the envelope or is empty, or
/// where the noise is above a sixth of the steady amplitude.
[[nodiscard]] std::optional<Edge> FindOnset(const Envelope& envelope, const EdgeSearch& search);

}  // namespace haptometer::dsp
