#include "fit/drop_test/consistency.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <ranges>
#include <utility>

#include "fit/consensus_mean.h"
#include "fit/drop_test/ring_fit.h"
#include "fit/residuals.h"
#include "fit/uncertainty.h"

namespace haptometer::fit {
namespace {

constexpr double kSamplesPerPeriod = 16;
constexpr std::size_t kLeastBlocks = 64;
constexpr double kMostDamping = 0.3;   // of critical
constexpr double kDeviations = 4;      // of a difference that is reported
constexpr double kScatters = 3;        // of drops, beyond which one is not of these
constexpr double kMostFriction = 0.1;  // of the spring's force, of a part that is compared
constexpr double kLeastKnown = 0.25;   // of a decay rate
constexpr double kLeastShare = 1e-3;   // of a decay, that counts
constexpr double kRounding = 1e-9;     // of a drop's own fit
constexpr double kMostNoise = 4;       // ratio of the variances of groups that are taken together

// a logarithm and its standard uncertainty
struct Rate {
  double logarithm = 0;
  double deviation = 0;
};

struct Rates {
  Rate frequency;  // natural
  Rate decay;
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

// by how many deviations, and by which share, the later fit differs from the whole
struct Shift {
  double share = 0;
  double deviations = 0;
};

// `noise_ratio`: the later noise over the whole's, which a misfit may increase
Shift ShiftOf(const Rate& whole, const Rate& later, double noise_ratio) {
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

// values of drops by their number, all estimates of one
using Group = std::map<std::size_t, Estimate>;
using Groups = std::map<std::pair<double, double>, Group>;  // by what they have in common

std::vector<Estimate> EstimatesOf(const Group& group) {
  std::vector<Estimate> estimates;
  for (const auto& [drop, estimate] : group) estimates.push_back(estimate);
  return estimates;
}

// how far a drop is from the others' mean, where it is more than `most`, than noise and than the
// others' scatter
std::optional<double> Distance(const Group& group, std::size_t drop, double most) {
  Group others = group;
  const Estimate own = others.extract(drop).mapped();
  const ConsensusMean rest = ConsensusOf(EstimatesOf(others));
  const double distance = own.value - rest.value;
  const double noise = std::sqrt(own.variance + rest.variance - rest.scatter_variance);
  const double scatter = std::sqrt(rest.between_variance + rest.scatter_variance);
  const double least = std::max({most, kDeviations * noise, kScatters * scatter});
  return std::abs(distance) < least ? std::nullopt : std::optional(distance);
}

struct Foreign {
  std::size_t drop = 0;
  double distance = 0;         // of logarithms
  bool is_one_of_two = false;  // which one it is remains open
};

// the drops that are too far from the others, farthest first
std::vector<Foreign> FindForeign(Group group, double most) {
  std::vector<Foreign> foreign;
  while (group.size() > 1) {
    std::map<std::size_t, double> far;
    for (const auto& [drop, estimate] : group) {
      if (const auto distance = Distance(group, drop, most)) far[drop] = *distance;
    }
    if (far.empty()) break;
    if (group.size() == 2) {
      for (const auto& [drop, distance] : far) foreign.push_back({drop, distance, true});
      break;
    }
    const auto farthest =
        std::ranges::max_element(far, {}, [](const auto& one) { return std::abs(one.second); });
    foreign.push_back({.drop = farthest->first, .distance = farthest->second});
    group.erase(farthest->first);
  }
  return foreign;
}

// mean variance by noise, as it weighs
double NoiseOf(const std::vector<Estimate>& group) {
  double weights = 0;
  for (const Estimate& estimate : group) weights += 1 / std::max(estimate.variance, 1e-30);
  return static_cast<double>(group.size()) / weights;
}

// `groups` of at least two drops with a common value each
DropScatter ScatterOver(const std::vector<std::vector<Estimate>>& groups) {
  DropScatter scatter{.degrees = 0};
  for (const auto& group : groups) scatter.degrees += static_cast<double>(group.size() - 1);
  const double ratio = std::sqrt(SquaresOf(groups, 0) / scatter.degrees);
  if (Scatters(ratio, scatter.degrees)) {
    scatter.birge_ratio = ratio;
    scatter.deviation = std::sqrt(BetweenVariance(groups, scatter.degrees));
  }
  scatter.student_deviation = std::sqrt(BetweenVariance(groups, StudentSquares(scatter.degrees)));
  return scatter;
}

// The scatter of all groups, or of the best known ones where it is larger: the noise of others may
// hide it.
DropScatter ScatterOf(std::vector<std::vector<Estimate>> groups) {
  std::erase_if(groups, [](const auto& group) { return group.size() < 2; });
  if (groups.empty()) return {};
  const DropScatter all = ScatterOver(groups);
  const double least = std::ranges::min(groups | std::views::transform(NoiseOf));
  std::erase_if(groups, [&](const auto& group) { return NoiseOf(group) > kMostNoise * least; });
  const DropScatter known = ScatterOver(groups);
  return known.student_deviation > all.student_deviation ? known : all;
}

// each drop's own fit; those that have none are not compared
std::map<std::size_t, Rates> RatesOf(const std::vector<ComparedDrop>& drops,
                                     Consistency& consistency) {
  std::map<std::size_t, Rates> rates;
  for (std::size_t k = 0; k < drops.size(); ++k) {
    const PreparedRecord& prepared = *drops[k].prepared;
    const PolePair& poles = prepared.part.poles;
    if (poles.decay_per_s > kMostDamping * std::sqrt(poles.stiffness_per_s2)) continue;
    auto whole = RatesFrom(prepared, poles, prepared.part.first_sample);
    if (!whole) continue;
    DoubtLinearity(prepared, *whole, consistency.findings);
    consistency.frequency_widening =
        std::max(consistency.frequency_widening, whole->frequency_widening);
    consistency.decay_widening = std::max(consistency.decay_widening, whole->decay_widening);
    consistency.drops[k].noise_v = whole->noise_v;
    consistency.drops[k].amplitude_v = whole->amplitude_v;
    consistency.drops[k].blocks = whole->blocks;
    rates[k] = *whole;
  }
  return rates;
}

// a rate, of which estimates are `power` times the logarithm
struct ComparedRate {
  FindingKind kind{};
  double most_share = 0;
  double power = 1;
};

// refuses drops of `groups` that are not of the others' actuator
void RefuseForeign(const std::vector<ComparedDrop>& drops, const ComparedRate& rate,
                   const Groups& groups, Consistency& consistency) {
  const double most = rate.power * std::log1p(rate.most_share);
  for (const auto& [condition, group] : groups) {
    for (const auto& [drop, distance, is_one_of_two] : FindForeign(group, most)) {
      consistency.findings.Add(About(drops[drop].prepared->record.name, Severity::kRefusal,
                                     rate.kind, {{"share", std::expm1(distance / rate.power)}}));
      // two that remain have their difference as their scatter
      if (!is_one_of_two) consistency.drops[drop].is_of_another = true;
    }
  }
}

// the groups' estimates over `shares` of each drop, without those of another actuator
std::vector<std::vector<Estimate>> Belonging(const Groups& groups, const Consistency& consistency,
                                             const std::vector<double>& shares) {
  std::vector<std::vector<Estimate>> belonging;
  for (const auto& [condition, group] : groups) {
    auto& estimates = belonging.emplace_back();
    for (const auto& [drop, estimate] : group) {
      if (consistency.drops[drop].is_of_another) continue;
      const double share = shares[drop];
      estimates.push_back({estimate.value / share, estimate.variance / (share * share)});
    }
  }
  return belonging;
}

// ln decays above the expected ones, of drops with equal load and mass
Groups CompareDecays(const std::vector<ComparedDrop>& drops,
                     const std::map<std::size_t, Rates>& rates, Consistency& consistency) {
  Groups groups;
  for (const auto& [k, own] : rates) {
    const ComparedDrop& drop = drops[k];
    groups[{drop.load_ohm, drop.mass_ratio}][k] = {
        own.decay.logarithm - std::log(drop.expected.decay_per_s),
        std::pow(std::hypot(own.decay.deviation, kRounding), 2)};
  }
  RefuseForeign(drops, {FindingKind::kDecayOfAnother, kMostDecayShare}, groups, consistency);
  return groups;
}

// ln q above the expected ones, of drops whose masses are known from each other
Groups CompareFrequencies(const std::vector<ComparedDrop>& drops,
                          const std::map<std::size_t, Rates>& rates, Consistency& consistency) {
  Groups groups;
  for (const auto& [k, own] : rates) {
    const ComparedDrop& drop = drops[k];
    // the start values say little of the coil's share
    const double deviation = std::hypot(2 * own.frequency.deviation, drop.coil_share, kRounding);
    groups[{drop.added_mass_kg, 0}][k] = {
        2 * own.frequency.logarithm - std::log(drop.expected.stiffness_per_s2),
        deviation * deviation};
  }
  RefuseForeign(drops, {FindingKind::kFrequencyOfAnother, kMostFrequencyShare, 2}, groups,
                consistency);
  return groups;
}

}  // namespace

Consistency CheckConsistency(const std::vector<ComparedDrop>& drops) {
  Consistency consistency;
  consistency.drops.resize(drops.size());
  const auto rates = RatesOf(drops, consistency);
  std::vector<double> shares;
  shares.reserve(drops.size());
  for (const ComparedDrop& drop : drops) {
    shares.push_back(std::max(drop.damping_share, kLeastShare));
  }
  // by either rate, which drops are of another actuator; then how the others scatter
  const Groups decays = CompareDecays(drops, rates, consistency);
  const Groups frequencies = CompareFrequencies(drops, rates, consistency);
  consistency.decay = ScatterOf(Belonging(decays, consistency, shares));
  const std::vector<double> whole(drops.size(), 1.0);
  consistency.frequency = ScatterOf(Belonging(frequencies, consistency, whole));
  // drops that nothing shows to differ are taken as alike; where one constant scatters, the other
  // may too, and it is below the noise of its estimates
  if (consistency.decay.birge_ratio == 1 && consistency.frequency.birge_ratio == 1) {
    consistency.decay.student_deviation = 0;
    consistency.frequency.student_deviation = 0;
  }
  // where the fit of all begins with each drop
  for (const auto& [mass, group] : frequencies) {
    for (const auto& [k, estimate] : group) consistency.drops[k].stiffness = estimate.value;
  }
  for (const auto& [condition, group] : decays) {
    if (group.size() < 2) continue;
    for (const auto& [k, estimate] : group) {
      consistency.drops[k].damping = std::clamp(estimate.value / shares[k], -1.0, 1.0);
    }
  }
  for (const auto& [kind, scatter] :
       {std::pair(FindingKind::kFrequenciesScatter, consistency.frequency),
        {FindingKind::kDecaysScatter, consistency.decay}}) {
    if (scatter.birge_ratio == 1) continue;
    consistency.findings.Doubt(kind, {{"scatter", scatter.deviation},
                                      {"birge_ratio", scatter.birge_ratio},
                                      {"degrees_of_freedom", std::lround(scatter.degrees)}});
  }
  return consistency;
}

void DoubtStatements(const std::vector<ComparedDrop>& drops, const std::vector<double>& noises_v,
                     Consistency& consistency) {
  for (std::size_t k = 0; k < drops.size(); ++k) {
    const OwnConstants& own = consistency.drops[k];
    if (own.noise_v == 0) continue;
    // both are estimates from some blocks, of noise that may be coloured by chance; and what is
    // below a millionth of the ringing is rounding
    const double most_ratio = 1.1 + 4 / std::sqrt(2 * own.blocks);
    const double ratio = noises_v[k] / own.noise_v;
    if (ratio < most_ratio || noises_v[k] < 1e-6 * own.amplitude_v) continue;
    consistency.findings.Add(About(drops[k].prepared->record.name, Severity::kRefusal,
                                   FindingKind::kRecordOfAnother, {{"ratio", ratio}}));
  }
}

}  // namespace haptometer::fit
