#pragma once

#include <optional>
#include <span>

namespace haptometer::dsp {

/// A number with its standard uncertainty, in the unit that the field's name says.
struct Estimate {
  double value = 0;
  double uncertainty = 0;
};

/// What a drive at one frequency puts into an actuator. Noise is in the RMS values and, where it is
/// common to both channels, in the power.
struct ElectricalState {
  Estimate voltage_rms_v;
  Estimate current_rms_a;
  Estimate real_power_w;       ///< mean of voltage x current; below 0: it flows back
  Estimate apparent_power_va;  ///< product of the two RMS values
  Estimate phase_rad;          ///< of the current relative to the voltage, at the tone
  Estimate resistance_ohm;     ///< real part of voltage / current, at the tone
  Estimate reactance_ohm;      ///< imaginary part; inductive: above 0
};

/// Voltage, current, power, phase and impedance from samples taken together, at a known tone.
///
///   Z = V / I,   P = |V| |I| cos(phase) / 2 + V_0 I_0 + mean(rest_V rest_I)
///
/// V and I are the least-squares phasors at the tone (FitSineAt), V_0 and I_0 the offsets: so the
/// window need not hold whole periods of the tone, only its multiples would ask for that.
/// Uncertainties are statistical, from what the fits leave (taken as white noise): gain and skew of
/// the two channels are the caller's. Nothing where the window holds less than one period, the tone
/// is not below rate/2, a fit does not converge, or voltage or current at the tone is below three
/// uncertainties.
[[nodiscard]] std::optional<ElectricalState> DescribeElectrical(std::span<const double> voltage_v,
                                                                std::span<const double> current_a,
                                                                double rate_hz, double tone_hz);

}  // namespace haptometer::dsp
