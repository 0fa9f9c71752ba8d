#include "dsp/spectrum/electrical.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// an amplitude below this many standard uncertainties is not determined
constexpr double kLeastUncertainties = 3;

// residual of `signal` without tone and offset
std::vector<double> Rest(std::span<const double> signal, const SineFit& fit, double rate_hz) {
  const PhasorBlocks phasors(2 * std::numbers::pi * fit.frequency_hz / rate_hz);
  const double c = fit.amplitude * std::cos(fit.phase_rad);
  const double s = fit.amplitude * std::sin(fit.phase_rad);
  std::vector<double> rest(signal.size());
  std::vector<double> cosines(PhasorBlocks::kBlock);
  std::vector<double> sines(PhasorBlocks::kBlock);
  for (std::size_t begin = 0; begin < signal.size(); begin += PhasorBlocks::kBlock) {
    const std::size_t size = std::min(PhasorBlocks::kBlock, signal.size() - begin);
    phasors.Fill(static_cast<double>(begin), std::span(cosines).first(size),
                 std::span(sines).first(size));
    for (std::size_t k = 0; k < size; ++k) {
      rest[begin + k] = signal[begin + k] - (c * cosines[k] - s * sines[k] + fit.offset);
    }
  }
  return rest;
}

// RMS of tone, offset and noise: sqrt(tone^2 / 2 + offset^2 + noise^2); noise s on n samples moves
// its square by 2 s sqrt(signal power / n) and s^2 sqrt(2 / n)
Estimate RmsOf(const SineFit& fit, std::size_t samples) {
  const auto n = static_cast<double>(samples);
  const double noise = fit.residual_rms * fit.residual_rms;
  const double signal = 0.5 * fit.amplitude * fit.amplitude + fit.offset * fit.offset;
  const double rms = std::sqrt(signal + noise);
  return {rms, std::sqrt((4 * signal * noise + 2 * noise * noise) / n) / (2 * rms)};
}

// product of independent estimates, uncertainties in squares
Estimate Product(const Estimate& a, const Estimate& b) {
  return {a.value * b.value, std::hypot(a.value * b.uncertainty, b.value * a.uncertainty)};
}

// Z = V / I: real part |Z| cos(angle), imaginary part |Z| sin(angle), angle of V relative to I
void DescribeImpedance(const SineFit& voltage, const SineFit& current, ElectricalState& state) {
  const double magnitude = voltage.amplitude / current.amplitude;
  // relative uncertainties of amplitudes turn into |Z|, those of phases into its angle
  const double relative = std::hypot(voltage.amplitude_uncertainty / voltage.amplitude,
                                     current.amplitude_uncertainty / current.amplitude);
  const double turned = std::hypot(voltage.phase_uncertainty_rad, current.phase_uncertainty_rad);
  const double angle = std::remainder(voltage.phase_rad - current.phase_rad, 2 * std::numbers::pi);
  const double real = magnitude * std::cos(angle);
  const double imaginary = magnitude * std::sin(angle);
  state.phase_rad = {-angle, turned};
  state.resistance_ohm = {real, std::hypot(real * relative, imaginary * turned)};
  state.reactance_ohm = {imaginary, std::hypot(imaginary * relative, real * turned)};
}

// whether a tone is determined: the quotient of amplitudes needs both
bool StandsOut(const SineFit& fit) {
  return fit.converged && fit.amplitude > kLeastUncertainties * fit.amplitude_uncertainty;
}

}  // namespace

std::optional<ElectricalState> DescribeElectrical(std::span<const double> voltage_v,
                                                  std::span<const double> current_a, double rate_hz,
                                                  double tone_hz) {
  HAPTOMETER_CHECK(rate_hz > 0 && tone_hz > 0 && voltage_v.size() == current_a.size(),
                   "rate_hz = {}, tone_hz = {}, {} and {} samples", rate_hz, tone_hz,
                   voltage_v.size(), current_a.size());
  const auto n = static_cast<double>(voltage_v.size());
  // less than one period does not determine offset and amplitude separately
  if (n / rate_hz * tone_hz < 1) return std::nullopt;
  const SineFit voltage = FitSineAt(voltage_v, {.rate_hz = rate_hz}, tone_hz);
  const SineFit current = FitSineAt(current_a, {.rate_hz = rate_hz}, tone_hz);
  if (!StandsOut(voltage) || !StandsOut(current)) return std::nullopt;

  ElectricalState state;
  state.voltage_rms_v = RmsOf(voltage, voltage_v.size());
  state.current_rms_a = RmsOf(current, current_a.size());
  state.apparent_power_va = Product(state.voltage_rms_v, state.current_rms_a);
  DescribeImpedance(voltage, current, state);

  // power of the noise that both channels have in common: mean of the products of the residuals
  std::vector<double> products = Rest(voltage_v, voltage, rate_hz);
  const std::vector<double> rest = Rest(current_a, current, rate_hz);
  for (std::size_t k = 0; k < products.size(); ++k) products[k] *= rest[k];
  // |V| |I| cos(phase) / 2 + V_0 I_0 + mean of the residuals' products
  state.real_power_w.value =
      0.5 * voltage.amplitude * current.amplitude * std::cos(state.phase_rad.value) +
      voltage.offset * current.offset + Mean(products);
  // noise of each channel weighs with the other channel's RMS
  const double v = state.voltage_rms_v.value * current.residual_rms;
  const double i = state.current_rms_a.value * voltage.residual_rms;
  state.real_power_w.uncertainty = std::hypot(v, i) / std::sqrt(n);
  return state;
}

}  // namespace haptometer::dsp
