#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/window/measured_window.h"
#include "dsp/spectrum/below_band_model.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
// t's 97.5 % point for a density of 48 bins, 96 degrees of freedom
constexpr double kCoverage = 1.985;

// whether a drive that is clear in every block moves by so many bins that no sine holds half of it
bool HasNoSingleTone(const MeasuredWindow& window, const SineFit& tone) {
  const StateInterval& state = window.chosen.part.state;
  if (!window.chosen.part.from_drive || state.coherence < kExplained) return false;
  const double moved_bins = std::abs(state.to_hz - state.from_hz) * window.samples.duration_s();
  double square = 0;
  for (const double value : window.samples.values_m) square += value * value;
  square /= static_cast<double>(window.samples.values_m.size());
  return moved_bins > kReachBins && tone.amplitude * tone.amplitude < square;
}

// subtracts the sine of a fit to all of `samples`
void Subtract(const SineFit& sine, double rate_hz, std::span<double> samples) {
  SubtractSine(kTwoPi * sine.frequency_hz / rate_hz, sine.amplitude * std::cos(sine.phase_rad),
               -sine.amplitude * std::sin(sine.phase_rad), 0, samples);
}

// amplitude at a frequency, where it is clear of the noise; `samples` are without the strong tones
double ClearAmplitude(std::span<const double> samples, const SineFitOptions& options,
                      double frequency_hz) {
  if (frequency_hz <= 0 || 2 * frequency_hz >= options.rate_hz) return 0;
  const SineFit fit = FitSineAt(samples, options, frequency_hz);
  const bool is_clear =
      fit.converged && fit.amplitude > kClearUncertainties * fit.amplitude_uncertainty;
  return is_clear ? fit.amplitude : 0;
}

// the strongest tone of the samples, fitted again without the strongest one of the others
std::optional<SineFit> ToneApart(MeasuredWindow& window) {
  const double rate_hz = window.samples.rate_hz;
  const ToneSearch search{rate_hz, window.band().lower_hz, window.band().upper_hz,
                          window.bandwidth_hz()};
  const auto tone = StrongestTone(window.samples.values_m, search);
  if (!tone) return tone;
  std::vector<double> others = window.samples.values_m;
  Subtract(*tone, rate_hz, others);
  const auto second = StrongestTone(others, search);
  // nearer ones are the tone's own change
  const double least_hz = kReachBins / window.samples.duration_s();
  if (!second || std::abs(second->frequency_hz - tone->frequency_hz) < least_hz) return tone;
  const SineFitOptions options{rate_hz, window.bandwidth_hz(), 0};
  std::vector<double> without = window.samples.values_m;
  Subtract(*second, rate_hz, without);
  const SineFit alone = FitSine(without, options, tone->frequency_hz);
  window.second = second;
  Subtract(*second, rate_hz, others);
  window.mirrored_m =
      ClearAmplitude(others, options, 2 * tone->frequency_hz - second->frequency_hz);
  return alone.converged ? alone : tone;
}

// Leakage from below the band is no noise: a line of amplitude a, D = 2 pi times its distance from
// the tone, moves the tone's fit over the duration T by 2 a / (T D) at most, its frequency by
// 12 a / (A T^2 D) (linear weights of the fit, against a sine); so does its mirror at negative
// frequencies. Of unknown phase, each adds 1 / sqrt(2) of that (GUM 4.3.5).
void AddLeakedLine(const MeasuredWindow& window, SineFit& fit) {
  if (!window.numbers.below_band) return;
  const BelowBand& below = *window.numbers.below_band;
  const double apart = 1 / (kTwoPi * (fit.frequency_hz - below.frequency_hz)) +
                       1 / (kTwoPi * (fit.frequency_hz + below.frequency_hz));
  const double seconds = window.samples.duration_s();
  const double leaked_m = below.leaked_rms_m;  // amplitude / sqrt(2)
  const double moved_m = 2 * leaked_m / seconds * apart;
  const double turned_hz = 12 * leaked_m / (fit.amplitude * seconds * seconds) * apart / kTwoPi;
  fit.amplitude_uncertainty = std::hypot(fit.amplitude_uncertainty, moved_m);
  fit.frequency_uncertainty_hz = std::hypot(fit.frequency_uncertainty_hz, turned_hz);
  // stated at the first sample, half the duration from the middle
  fit.phase_uncertainty_rad = std::hypot(fit.phase_uncertainty_rad, moved_m / fit.amplitude,
                                         std::numbers::pi * seconds * turned_hz);
}

}  // namespace

std::optional<SineFit> ToneOf(MeasuredWindow& window) {
  const auto tone = ToneApart(window);
  return tone && HasNoSingleTone(window, *tone) ? std::nullopt : tone;
}

void FinishTone(MeasuredWindow& window) {
  ToneNumbers& tone = *window.numbers.tone;
  SineFit& fit = tone.fit;
  // two passes: gain |H|^2
  const double gain = std::norm(Response(window.signal().design(), fit.frequency_hz));
  tone.sine_rms_m = fit.amplitude / std::numbers::sqrt2;
  tone.share_of_rms = tone.sine_rms_m / std::sqrt(window.numbers.power.mean_square);
  // noise near the tone differs from white noise: all uncertainties by the same factor
  if (window.tone_variance > 0) {
    const double shape = std::sqrt(window.tone_variance) / fit.amplitude /
                         std::max(fit.amplitude_uncertainty, 1e-300);
    fit.amplitude_uncertainty *= shape;
    fit.frequency_uncertainty_hz *= shape;
    fit.phase_uncertainty_rad *= shape;
  }
  // the fit is of filtered samples: leakage is added there, the filter's gain divided out after it
  AddLeakedLine(window, fit);
  // what steps may change of the RMS, they change of the amplitude: a rectangular distribution
  const double steps_m = window.steps_m * std::numbers::sqrt2 / std::numbers::sqrt3;
  fit.amplitude_uncertainty = std::hypot(fit.amplitude_uncertainty, steps_m);
  fit.amplitude /= gain;
  fit.amplitude_uncertainty /= gain;
  // the rate is a line through times: each of its ends may be off by their uncertainty
  const double segment_s = static_cast<double>(window.signal().size()) / window.rate_hz();
  const double rate_share =
      std::numbers::sqrt2 * window.signal().segment().time_uncertainty_s / segment_s;
  fit.frequency_uncertainty_hz =
      std::hypot(fit.frequency_uncertainty_hz, fit.frequency_hz * rate_share);

  // the sensor's gain last: amplitude at the target
  tone.amplitude_m = fit.amplitude / window.power.sensor_gain;
  tone.amplitude_uncertainty_m = fit.amplitude_uncertainty / window.power.sensor_gain;
  tone.amplitude_lower_m = tone.amplitude_m - kCoverage * tone.amplitude_uncertainty_m;
  tone.amplitude_upper_m = tone.amplitude_m + kCoverage * tone.amplitude_uncertainty_m;
  tone.frequency_lower_hz = fit.frequency_hz - kCoverage * fit.frequency_uncertainty_hz;
  tone.frequency_upper_hz = fit.frequency_hz + kCoverage * fit.frequency_uncertainty_hz;
  // v = w x, a = w^2 x, peak values
  const double turn = kTwoPi * fit.frequency_hz;
  tone.velocity_m_per_s = turn * tone.amplitude_m;
  tone.acceleration_m_per_s2 = turn * turn * tone.amplitude_m;

  // power beside the tone of a drive this weak is hardly told from noise: the interval holds both;
  // sidebands of a modulation are the drive
  RmsEstimate& rms = window.numbers.rms;
  const UsedPart& part = window.chosen.part;
  const bool is_modulated = part.state.modulation > 0 || window.mirrored_m > 0;
  if (part.from_drive && !is_modulated &&
      0.5 * (rms.upper_m - rms.lower_m) > kWideShare * rms.rms_m) {
    const double least_m = tone.sine_rms_m * tone.amplitude_lower_m / fit.amplitude;
    rms.lower_m = std::clamp(least_m, 0.0, rms.lower_m);
  }
  // an upper limit holds the tone, unless that was subtracted with the floor
  if (rms.below_floor && !window.numbers.floor->tone_hz) {
    const double tone_m = tone.sine_rms_m * tone.amplitude_upper_m / fit.amplitude;
    rms.at_most_m = rms.upper_m = std::max(rms.at_most_m, tone_m);
  }
}

Result<void> DescribeHarmonics(MeasuredWindow& window) {
  const double frequency_hz = window.numbers.tone->fit.frequency_hz;
  const double upper_hz = window.analysis.record.observable_upper_hz;
  if (2 * frequency_hz > upper_hz) return {};
  std::vector<double> samples(FittedOf(window.rows));
  const std::size_t first = window.chosen.begin + (window.rows - samples.size()) / 2;
  HAPTOMETER_TRY(window.signal().samples().Read(first, samples));
  if (window.numbers.below_band && window.samples.duration_s() <= kLongestModelledS) {
    const auto model = BelowBandModel::Fit(samples, window.rate_hz(), window.band().lower_hz,
                                           window.band().upper_hz);
    if (model) model->Subtract(0, samples);
  }
  // up to the tenth harmonic: 10.5 leaves a margin for the frequency's uncertainty
  Harmonics harmonics = FitHarmonics(samples, {window.rate_hz(), 0, kHighestDriftDegree},
                                     frequency_hz, std::min(upper_hz, 10.5 * frequency_hz));
  if (harmonics.converged) window.numbers.harmonics = std::move(harmonics);
  return {};
}

}  // namespace haptometer::dsp
