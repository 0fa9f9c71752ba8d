#include "fit/drop_test/ring_evidence.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "base/mapped.h"
#include "fit/poles.h"

namespace haptometer::fit {
namespace {

// limits of ring_evidence.h, as shares of the ringing's power
constexpr double kMostShare = 0.015;
constexpr double kSurely = 5;  // deviations
constexpr double kMostLasting = 0.01;
constexpr double kLeastDecays = 0.1;
constexpr double kMostDamping = 0.7;  // of critical
// Variance of the mean square of residuals less that of their third differences, for one of white
// noise: 2, and 2 sum rho^2 = 4.62 of the differences, less twice their covariance of 2.
constexpr double kDifferenceVariance = 2.62;

// Variance of white noise under an oscillation, weighted: of third differences, whose power is that
// of 1 + 9 + 9 + 1 samples. An outlying sample counts here as much as in the weighted power itself.
double NoiseSquare(const std::vector<double>& residuals, const std::vector<double>& weights) {
  double sum = 0;
  double all = 0;
  for (std::size_t n = 3; n < residuals.size(); ++n) {
    const double third =
        residuals[n] - 3 * residuals[n - 1] + 3 * residuals[n - 2] - residuals[n - 3];
    const double weight = (weights[n - 1] + weights[n - 2]) / 2;
    sum += weight * third * third;
    all += weight;
  }
  return all > 0 ? sum / 20 / all : 0;
}

// sqrt(q)/(2 pi)
double NaturalHz(const PolePair& poles) {
  return std::sqrt(poles.stiffness_per_s2) / (2 * std::numbers::pi);
}

RingSamples Some(const RingSamples& samples, std::size_t first, std::size_t end) {
  RingSamples some{
      .step_s = samples.step_s, .signal = samples.signal, .times_s = {}, .values_v = {}};
  const auto slice = [&](const std::vector<double>& all) {
    return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(first),
                               all.begin() + static_cast<std::ptrdiff_t>(end));
  };
  some.times_s = slice(samples.times_s);
  some.values_v = slice(samples.values_v);
  return some;
}

// standard uncertainty of one of a fit's parameters
double DeviationOf(const RingFit& fit, std::size_t column) {
  const auto degrees = std::max(
      static_cast<double>(fit.jacobian.rows) - static_cast<double>(fit.jacobian.columns), 1.0);
  return fit.Deviation(column, fit.Squares() / degrees);
}

// Frequencies of the begin and of what follows, where they surely differ. Each of a third of the
// decay time, or of one and a half periods; nothing where hum or drift lie under the ringing, from
// which so short a part does not distinguish it.
std::string FrequencyChange(const RingSamples& samples, const RingFit& fit) {
  constexpr double kChange = 0.05;
  constexpr double kSurelyOther = 6;
  constexpr std::size_t kLeastPart = 24;  // samples
  constexpr double kPartPeriods = 1.5;
  constexpr double kMostDeviation = 0.02;  // beyond which it is not that of a linear fit
  if (fit.HumAmplitude() > 0 || fit.drift_v != 0) return {};
  const double energy_s =
      std::min(1 / fit.poles.decay_per_s, samples.times_s.back() - samples.times_s.front());
  const double part_s = std::max(0.35 * energy_s, kPartPeriods / NaturalHz(fit.poles));
  const auto half = std::max(static_cast<std::size_t>(part_s / samples.step_s), kLeastPart);
  if (2 * half > samples.times_s.size()) return {};
  const RingFit early = FitRing(Some(samples, 0, half), fit.poles, {});
  const RingFit late = FitRing(Some(samples, half, 2 * half), fit.poles, {});
  if (!early.converged || !late.converged) return {};
  // ln of the frequencies' ratio: 0.5 ln(q2/q1)
  const double change = 0.5 * std::log(late.poles.stiffness_per_s2 / early.poles.stiffness_per_s2);
  const double deviation = 0.5 * std::hypot(DeviationOf(early, 1), DeviationOf(late, 1));
  if (!(deviation < kMostDeviation)) return {};
  if (std::abs(change) < std::max(kChange, kSurelyOther * deviation)) return {};
  return fmt::format(
      "is not a single decaying oscillation: its frequency goes from {:.4g} to {:.4g} Hz (a "
      "chirp?)",
      NaturalHz(early.poles), NaturalHz(late.poles));
}

// the weights of EvidenceOf: of the ringing's own power
std::vector<double> PowerWeights(const RingSamples& samples, const RingFit& fit) {
  return Mapped<double>(samples.times_s, [&](const double time_s) {
    return std::exp(-2 * fit.poles.decay_per_s * (time_s - samples.times_s.front()));
  });
}

// The misfit in standard deviations, of the logarithm of the residuals' power over the noise's: of
// few samples, both are far from normal.
double MisfitDeviations(const RingEvidence& evidence, const RingSamples& samples,
                        const RingFit& fit) {
  double sum = 0;
  double squares = 0;
  for (const double weight : PowerWeights(samples, fit)) {
    sum += weight;
    squares += weight * weight;
  }
  const double deviation = std::sqrt(kDifferenceVariance * squares) / sum;
  // without noise any misfit is certain
  const double beyond = evidence.misfit_share_deviation > 0
                            ? evidence.misfit_share / evidence.misfit_share_deviation
                            : std::numeric_limits<double>::max();
  return std::log1p(std::max(beyond * deviation, 0.0)) / deviation;
}

// the strongest oscillation in the residual, as far as the ringing lasts
std::string Other(const RingSamples& samples, const RingFit& fit) {
  std::vector<double> left = fit.jacobian.residuals;
  for (std::size_t n = 0; n < left.size(); ++n) {
    left[n] *= std::exp(-fit.poles.decay_per_s * (samples.times_s[n] - samples.times_s.front()));
  }
  const auto other_hz = StrongestFrequency(left, samples.step_s);
  if (!other_hz) return {};
  const double ratio = *other_hz / NaturalHz(fit.poles);
  // a whole multiple within 3 %: a harmonic
  if (std::abs(ratio - std::round(ratio)) < 0.03 && ratio > 1.5) {
    return fmt::format(": what is left has {:.0f} times its frequency (no sinusoid)", ratio);
  }
  return fmt::format(": what is left is strongest at {:.4g} Hz (a second mode, a beat, or noise?)",
                     *other_hz);
}

// the residuals' power beyond noise, of all samples alike
void WriteWhatLasts(const std::vector<double>& residuals, const RingFit& fit, double floor_v,
                    RingEvidence* evidence) {
  const auto rows = static_cast<double>(residuals.size());
  const std::vector<double> even(residuals.size(), 1.0);
  const double noise = std::max(NoiseSquare(residuals, even), floor_v * floor_v);
  double square = 0;
  for (const double residual : residuals) square += residual * residual / rows;
  // mean power of the ringing at its begin: A^2/2
  const double first = 0.5 * fit.Envelope(0) * fit.Envelope(0);
  evidence->lasting_share = (square - noise) / first;
  evidence->lasting_share_deviation = noise * std::sqrt(kDifferenceVariance / rows) / first;
}

}  // namespace

RingEvidence EvidenceOf(const RingSamples& samples, const RingFit& fit, double floor_v) {
  const auto& residuals = fit.jacobian.residuals;
  const auto rows = static_cast<double>(residuals.size());
  const auto degrees = std::max(rows - static_cast<double>(fit.jacobian.columns), 1.0);
  const std::vector<double> weights = PowerWeights(samples, fit);
  // weighted by e^(-2 d t): residual power, and the ringing's A(t)^2/2
  double misfit = 0;
  double ringing = 0;
  double weight_sum = 0;
  double weight_squares = 0;
  for (std::size_t n = 0; n < residuals.size(); ++n) {
    const double since_s = samples.times_s[n] - samples.times_s.front();
    const double envelope = fit.Envelope(since_s);
    misfit += weights[n] * residuals[n] * residuals[n];
    ringing += 0.5 * weights[n] * envelope * envelope;
    weight_sum += weights[n];
    weight_squares += weights[n] * weights[n];
  }
  RingEvidence evidence;
  if (!(ringing > 0)) return evidence;
  WriteWhatLasts(residuals, fit, floor_v, &evidence);
  const double noise = std::max(NoiseSquare(residuals, weights), floor_v * floor_v);
  // noise leaves degrees/rows of its power in the residuals
  evidence.misfit_share = (misfit - noise * weight_sum * degrees / rows) / ringing;
  evidence.misfit_share_deviation =
      noise * std::sqrt(kDifferenceVariance * weight_squares) / ringing;
  const double length_s = samples.times_s.back() - samples.times_s.front();
  evidence.decays = fit.poles.decay_per_s * length_s;
  evidence.damping_ratio = fit.poles.decay_per_s / std::sqrt(fit.poles.stiffness_per_s2);
  evidence.decays_deviation = evidence.decays * DeviationOf(fit, 0);
  return evidence;
}

std::string NoRingDown(const RingEvidence& evidence, const RingSamples& samples, const RingFit& fit,
                       bool is_stated_drop) {
  // a stated drop or release may be heavily damped
  if (evidence.damping_ratio > kMostDamping && !is_stated_drop) {
    return "does not oscillate: it is a step or an aperiodic decay";
  }
  if (evidence.cuts > kMostCuts) {
    return fmt::format("begins to ring {} times and more: no ring-down is left alone",
                       evidence.cuts + 1);
  }
  if (!evidence.begins && evidence.decays + 2 * evidence.decays_deviation < kLeastDecays) {
    return fmt::format("does not decay: a driven oscillation of {:.4g} Hz (hum?)",
                       NaturalHz(fit.poles));
  }
  if (std::string change = FrequencyChange(samples, fit); !change.empty()) return change;
  if (evidence.misfit_share > kMostShare && MisfitDeviations(evidence, samples, fit) > kSurely) {
    return fmt::format(
        "is not a single decaying oscillation: {:.2g} % of the power at {:.4g} Hz is not explained "
        "by one{}",
        100 * evidence.UnexplainedShare(), NaturalHz(fit.poles), Other(samples, fit));
  }
  // power that does not decay with the oscillation
  if (evidence.lasting_share > kMostLasting &&
      evidence.lasting_share > kSurely * evidence.lasting_share_deviation) {
    return fmt::format(
        "does not end with its oscillation of {:.4g} Hz: {:.2g} % of its first power stays (a "
        "chirp, or another source?)",
        NaturalHz(fit.poles), 100 * evidence.lasting_share);
  }
  return {};
}

}  // namespace haptometer::fit
