#include "fit/drop_test/consistency.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "fit/drop_test/ring_fit.h"
#include "fit/residuals.h"
#include "fit/uncertainty.h"

namespace haptometer::fit {
namespace {

constexpr double kSamplesPerPeriod = 16;
constexpr std::size_t kLeastBlocks = 64;
constexpr double kMostDamping = 0.3;   // of critical
constexpr double kDeviations = 4;      // of a difference that is reported
constexpr double kMostFriction = 0.1;  // of the spring's force, of a part that is compared
constexpr double kLeastKnown = 0.25;   // of a decay rate

// a logarithm and its standard uncertainty
struct Estimate {
  double logarithm = 0;
  double deviation = 0;
};

struct Rates {
  Estimate frequency;  // natural
  Estimate decay;
  double frequency_widening = 1;
  double decay_widening = 1;
  double noise_v = 0;         // of one sample, if it were white
  double amplitude_v = 0;     // of the ringing at its begin
  double friction_share = 0;  // of the spring's force there
  double blocks = 0;
};

// the part's record as it would be without dry friction
ImpulseRecord WithoutFriction(const PreparedRecord& drop) {
  ImpulseRecord linear = drop.record;
  const auto& more_v = drop.part.linear_less_friction_v;
  for (std::size_t n = 0; n < more_v.size(); ++n) {
    linear.voltage_v[drop.part.first_sample + n] += more_v[n];
  }
  return linear;
}

// By how much the poles are less certain than in a fit without friction, of the record that
// friction is removed from: the friction is not known exactly and ends the motion, and it is not
// exactly one force. Of its part in the decay of the first swing (2 f/(pi zeta) of the viscous
// decay), a fiftieth is left open in the decay and 1e-4 in the frequency.
void WidenForFriction(const PreparedRecord& drop, const RingFit& fit, std::size_t block,
                      double variance, Rates* rates) {
  RingBackground background = drop.part.background;
  background.has_friction = false;
  const auto samples =
      BlocksOf(WithoutFriction(drop), drop.part.first_sample, drop.part.end_sample, block);
  const RingFit linear = FitRing(samples, fit.poles, background);
  const double taken = 2 * drop.part.friction_share / std::numbers::pi *
                       std::sqrt(fit.poles.stiffness_per_s2) / fit.poles.decay_per_s;
  // uncertainty with the friction fitted and left open, over that of the linear fit
  rates->decay_widening = std::max(
      std::hypot(rates->decay.deviation, 0.02 * taken) / linear.Deviation(0, variance), 1.0);
  rates->frequency_widening = std::max(
      std::hypot(rates->frequency.deviation, 1e-4 * taken) / (0.5 * linear.Deviation(1, variance)),
      1.0);
}

// `poles` of the blocks from `first` on, with uncertainties from the residuals' density
std::optional<Rates> RatesFrom(const PreparedRecord& drop, const PolePair& start,
                               std::size_t first) {
  const double natural = std::sqrt(start.stiffness_per_s2);
  const double period = 2 * std::numbers::pi / natural / drop.record.step_s;
  const auto all = static_cast<double>(drop.record.voltage_v.size());
  const auto block = static_cast<std::size_t>(std::clamp(period / kSamplesPerPeriod, 1.0, all));
  const auto samples = BlocksOf(drop.record, first, drop.part.end_sample, block);
  if (samples.values_v.size() < kLeastBlocks) return std::nullopt;
  const RingFit fit = FitRing(samples, start, drop.part.background);
  if (!fit.converged) return std::nullopt;
  const auto rows = static_cast<double>(fit.jacobian.rows);
  // variance of the residuals per degree of freedom, at the resonance's density
  double square = fit.Squares() / (rows - static_cast<double>(fit.jacobian.columns));
  const ResidualDensity density =
      DensityAt(fit.jacobian.residuals, samples.step_s, natural / (2 * std::numbers::pi));
  if (density.is_coloured) square *= density.ratio;
  // amplitude of the motion: a voltage's over w
  const double motion =
      fit.Envelope(0) / (samples.signal == RecordedSignal::kVoltage ? natural : 1);
  Rates rates{
      .frequency = {0.5 * std::log(fit.poles.stiffness_per_s2), 0.5 * fit.Deviation(1, square)},
      .decay = {std::log(fit.poles.decay_per_s), fit.Deviation(0, square)},
      .noise_v = std::sqrt(square * static_cast<double>(block)),
      .amplitude_v = fit.Envelope(0),
      .friction_share = fit.friction / motion,
      .blocks = rows};
  if (first == drop.part.first_sample && !drop.part.linear_less_friction_v.empty()) {
    WidenForFriction(drop, fit, block, square, &rates);
  }
  return rates;
}

// R_B = sqrt(chi^2/(n - 1)) where chi^2 exceeds its 99 % quantile, else 1
DropScatter ScatterOf(const std::vector<Estimate>& estimates) {
  if (estimates.size() < 2) return {};
  // weighted mean, then chi^2 about it
  double weight = 0;
  double sum = 0;
  for (const auto& [value, deviation] : estimates) {
    weight += 1 / (deviation * deviation);
    sum += value / (deviation * deviation);
  }
  double chi_square = 0;
  for (const auto& [value, deviation] : estimates) {
    chi_square += std::pow((value - sum / weight) / deviation, 2);
  }
  const auto degrees = static_cast<double>(estimates.size() - 1);
  const double ratio = std::sqrt(chi_square / degrees);
  return Scatters(ratio, degrees) ? DropScatter{ratio, degrees} : DropScatter{};
}

// by how many deviations, and by which share, the later fit differs from the whole
struct Shift {
  double share = 0;
  double deviations = 0;
};

// `noise_ratio`: the later noise over the whole's, which a misfit may increase
Shift ShiftOf(const Estimate& whole, const Estimate& later, double noise_ratio) {
  // the later part is contained in the whole: variance of the difference (Hausman 1978)
  const double square =
      later.deviation * later.deviation - std::pow(std::min(noise_ratio, 1.0) * whole.deviation, 2);
  const double share = later.logarithm - whole.logarithm;
  return {share, square > 0 ? std::abs(share) / std::sqrt(square) : 0};
}

// Where a later begin gives other values, the whole's interval is widened to hold them.
void DoubtLinearity(const PreparedRecord& drop, Rates& whole, Findings& findings) {
  const double decay_per_s = std::exp(whole.decay.logarithm);
  const PolePair poles{decay_per_s, std::exp(2 * whole.frequency.logarithm)};
  const double left = static_cast<double>(drop.part.end_sample - drop.part.first_sample);
  // the later part begins one decay time 1/d after the whole
  const double decay_samples = 1 / (decay_per_s * drop.record.step_s);
  if (!(decay_samples < left)) return;
  const std::size_t later_first = drop.part.first_sample + static_cast<std::size_t>(decay_samples);
  const auto later = RatesFrom(drop, poles, later_first);
  if (!later) return;
  // a motion that friction soon ends, or noise, has no poles to compare
  if (later->friction_share > kMostFriction || later->decay.deviation > kLeastKnown) return;
  const double noise_ratio = later->noise_v / whole.noise_v;
  const Shift frequency = ShiftOf(whole.frequency, later->frequency, noise_ratio);
  if (frequency.deviations > kDeviations) {
    findings.Add(
        About(drop.record.name, Severity::kDoubt,
              frequency.share < 0 ? FindingKind::kSpringStiffens : FindingKind::kSpringSoftens,
              {{"share", frequency.share}, {"deviations", std::lround(frequency.deviations)}}));
    whole.frequency_widening =
        std::hypot(whole.frequency_widening, std::abs(frequency.share) / whole.frequency.deviation);
  }
  const Shift decay = ShiftOf(whole.decay, later->decay, noise_ratio);
  if (decay.deviations > kDeviations) {
    whole.decay_widening =
        std::hypot(whole.decay_widening, std::abs(decay.share) / whole.decay.deviation);
    findings.Add(About(drop.record.name, Severity::kDoubt,
                       decay.share > 0 ? FindingKind::kFrictionSlows : FindingKind::kDampingGrows,
                       {{"share", decay.share}, {"deviations", std::lround(decay.deviations)}}));
  }
}

// refuses a drop that its own ring-down explains much better than the fit of all together
void DoubtBelonging(const ComparedDrop& drop, const Rates& whole, Findings& findings) {
  // both are estimates from some blocks, of noise that may be coloured by chance; and what is below
  // a millionth of the ringing is rounding
  const double most_ratio = 1.1 + 4 / std::sqrt(2 * whole.blocks);
  const double ratio = drop.noise_v / whole.noise_v;
  if (ratio < most_ratio || drop.noise_v < 1e-6 * whole.amplitude_v) return;
  findings.Add(About(drop.prepared->record.name, Severity::kRefusal, FindingKind::kRecordOfAnother,
                     {{"ratio", ratio}}));
}

}  // namespace

Consistency CheckConsistency(const std::vector<ComparedDrop>& drops) {
  std::map<std::pair<double, double>, std::vector<Rates>> alike;
  Consistency consistency;
  double noise_share = 0;  // most of a drop's own noise over that in the fit together
  // each drop alone; those with equal load and mass ring alike and are compared
  for (const ComparedDrop& drop : drops) {
    const PolePair& poles = drop.prepared->part.poles;
    if (poles.decay_per_s > kMostDamping * std::sqrt(poles.stiffness_per_s2)) continue;
    auto whole = RatesFrom(*drop.prepared, poles, drop.prepared->part.first_sample);
    if (!whole) continue;
    alike[{drop.load_ohm, drop.mass_ratio}].push_back(*whole);
    noise_share = std::max(noise_share, std::min(whole->noise_v / drop.noise_v, 1.0));
    DoubtBelonging(drop, *whole, consistency.findings);
    DoubtLinearity(*drop.prepared, *whole, consistency.findings);
    consistency.frequency_widening =
        std::max(consistency.frequency_widening, whole->frequency_widening);
    consistency.decay_widening = std::max(consistency.decay_widening, whole->decay_widening);
  }
  // scatter within each group of equal drops
  for (const auto& [condition, rates] : alike) {
    std::vector<Estimate> frequencies;
    std::vector<Estimate> decays;
    for (const Rates& rate : rates) {
      frequencies.push_back(rate.frequency);
      decays.push_back(rate.decay);
    }
    consistency.frequency.TakeLarger(ScatterOf(frequencies));
    consistency.decay.TakeLarger(ScatterOf(decays));
  }
  // the Birge ratio, less what the drops' larger noise in the common fit has widened already
  consistency.frequency_widening =
      std::max(consistency.frequency_widening, consistency.frequency.birge_ratio * noise_share);
  consistency.decay_widening =
      std::max(consistency.decay_widening, consistency.decay.birge_ratio * noise_share);
  for (const auto& [kind, scatter] :
       {std::pair(FindingKind::kFrequenciesScatter, consistency.frequency),
        {FindingKind::kDecaysScatter, consistency.decay}}) {
    if (scatter.birge_ratio == 1) continue;
    consistency.findings.Doubt(kind, {{"birge_ratio", scatter.birge_ratio},
                                      {"degrees_of_freedom", std::lround(scatter.degrees)}});
  }
  return consistency;
}

}  // namespace haptometer::fit
