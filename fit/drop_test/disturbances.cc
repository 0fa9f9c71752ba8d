#include "fit/drop_test/disturbances.h"

#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/drop_test/suspects.h"

namespace haptometer::fit {
namespace {

// blocks per period that the record is averaged to before the trials
constexpr double kSamplesPerPeriod = 16;
constexpr double kLeastPeriods = 3;
constexpr double kLeastPeriodsAboveStep = 1.5;
constexpr std::size_t kLeastBlocks = 32;
constexpr double kQuietShare = 0.2;  // of the ringing's first amplitude
constexpr int kMostRounds = 12;

// Standard deviation of the decay rate per unit of noise for a ring-down of amplitude A over a
// length T, up to a factor. Cramer-Rao bound: variance I0/(A^2 (I0 I2 - I1^2)), I_k the integral
// of t^k e^(-2 d t) from 0 to T
double DecayBound(double amplitude_v, double decay_per_s, double length_s) {
  const double x = 2 * decay_per_s * length_s;
  if (!(length_s > 0 && amplitude_v > 0)) return std::numeric_limits<double>::infinity();
  const double left = std::exp(-x);
  const double i0 = (1 - left) / x;
  const double i1 = (1 - left * (1 + x)) / (x * x);
  const double i2 = (2 - left * (2 + x * (2 + x))) / (x * x * x);
  const double determinant = std::max(i0 * i2 - i1 * i1, 1e-300);
  return std::sqrt(i0 / determinant / length_s) / (amplitude_v * length_s);
}

// first sample at or behind `time_s`
std::size_t SampleAt(const ImpulseRecord& record, double time_s) {
  const double position = (time_s - record.start_s) / record.step_s;
  return static_cast<std::size_t>(
      std::clamp(std::ceil(position), 0.0, static_cast<double>(record.voltage_v.size())));
}

// the name of a number of the record's values: with its unit's ending, or none of other units
std::string_view InUnit(const ImpulseRecord& record, std::string_view volts,
                        std::string_view metres) {
  const bool is_length = record.unit == "m" || record.signal == RecordedSignal::kDisplacement;
  if (is_length) return metres;
  return record.unit == "V" ? volts : volts.substr(0, volts.size() - 2);
}

// cuts the part at the impact and keeps the side with the smaller bound of the decay rate
void CutAt(const ImpulseRecord& record, const RingFit& fit, const Suspect& blow,
           Disturbances* part) {
  const double period_s = PeriodOf(fit.poles);
  const double first_s = record.start_s + static_cast<double>(part->first_sample) * record.step_s;
  const double end_s = record.start_s + static_cast<double>(part->end_sample) * record.step_s;
  // excluded: a sixteenth of a period before the impact, a quarter behind it
  const double before_s = blow.value - period_s / 16 - first_s;
  const double after_s = end_s - (blow.value + period_s / 4);
  const double at_blow_v = fit.Envelope(blow.value - first_s);
  const double before = DecayBound(fit.Envelope(0), fit.poles.decay_per_s, before_s);
  const double after =
      DecayBound(std::max(at_blow_v, blow.amplitude_v), fit.poles.decay_per_s, after_s);
  // a stated height belongs to the first impact: its part is kept if it is long enough
  const bool height_holds = record.drop_height_m && !part->follows_a_later_blow;
  const bool keeps_first =
      before_s >= kLeastPeriods * period_s && (height_holds || before <= after);
  part->found.Add(About(record.name, Severity::kNote, FindingKind::kLaterImpact,
                        {{"at_s", blow.value},
                         {InUnit(record, "amplitude_v", "amplitude_m"), blow.amplitude_v},
                         {InUnit(record, "ringing_v", "ringing_m"), at_blow_v},
                         {"kept", std::string(keeps_first ? "before" : "behind")}}));
  if (keeps_first) {
    part->end_sample = SampleAt(record, blow.value - period_s / 16);
  } else {
    part->first_sample = SampleAt(record, blow.value + period_s / 4);
    part->follows_a_later_blow = true;
  }
}

// sample from which A e^(-d t) is below the converter's step, so that only the offset's code
// remains; the part's end where rounding is random, and where too little would be left
std::size_t EndAboveStep(const ImpulseRecord& record, const RingStart& start, const RingFit& fit,
                         const Disturbances& part) {
  const double step_v = ConverterStep(record.voltage_v);
  const double noise_v = start.quiet_samples > 0 ? start.quiet_noise_v : start.residual_rms_v;
  // with noise above a quarter of a step, the rounding is random
  if (step_v == 0 || noise_v > 0.25 * step_v || !(fit.Envelope(0) > step_v)) return part.end_sample;
  const double since_s = std::log(fit.Envelope(0) / step_v) / fit.poles.decay_per_s;
  const double samples = std::min(since_s / record.step_s, static_cast<double>(part.end_sample));
  const double periods = std::floor(samples) * record.step_s / PeriodOf(fit.poles);
  if (periods < kLeastPeriodsAboveStep) return part.end_sample;
  return std::min(part.end_sample, part.first_sample + static_cast<std::size_t>(samples));
}

// excludes that tail from the fit, once
void CutQuantisedTail(const ImpulseRecord& record, const RingStart& start, const RingFit& fit,
                      Disturbances* part) {
  const std::size_t end = EndAboveStep(record, start, fit, *part);
  if (end >= part->end_sample || part->found.Has(FindingKind::kQuantisedTail)) return;
  part->end_sample = end;
  part->found.Add(About(record.name, Severity::kNote, FindingKind::kQuantisedTail,
                        {{InUnit(record, "step_v", "step_m"), ConverterStep(record.voltage_v)},
                         {"from_s", record.start_s + static_cast<double>(end) * record.step_s}}));
}

// whether the part shows no more than two neighbouring codes beside one from a sample on
bool IsSilentFrom(const ImpulseRecord& record, std::size_t first, const Disturbances& part) {
  if (first >= part.end_sample) return false;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t n = first; n < part.end_sample; ++n) {
    if (!std::isfinite(record.voltage_v[n])) continue;
    low = std::min(low, record.voltage_v[n]);
    high = std::max(high, record.voltage_v[n]);
  }
  return high - low < 2.5 * ConverterStep(record.voltage_v);
}

// Whether the excluded side of a cut rings at a frequency that no impact explains. A case that is
// held in one part and free in the other changes the frequency by far more.
std::string OtherSide(const ImpulseRecord& record, const Disturbances& whole,
                      const Disturbances& part, const RingFit& kept) {
  // changes of ln frequency, and amplitude over that of the kept part
  constexpr double kLeastChange = 0.03;
  constexpr double kMostChange = 0.3;
  constexpr double kLeastAmplitude = 0.2;
  const bool is_before = part.first_sample > whole.first_sample;
  const std::size_t first = is_before ? whole.first_sample : part.end_sample;
  const std::size_t end = is_before ? part.first_sample : whole.end_sample;
  const double wanted = PeriodOf(kept.poles) / (kSamplesPerPeriod * record.step_s);
  const std::size_t block = std::max<std::size_t>(static_cast<std::size_t>(wanted), 1);
  const auto samples = BlocksOf(record, first, end, block);
  const double periods = static_cast<double>(end - first) * record.step_s / PeriodOf(kept.poles);
  if (samples.values_v.size() < 2 * kLeastBlocks || periods < kLeastPeriods) return {};
  const RingFit other = FitRing(samples, kept.poles, {});
  if (!other.converged || other.Envelope(0) < kLeastAmplitude * kept.Envelope(0)) return {};
  const double change =
      // ln of the frequencies' ratio: 0.5 ln(q1/q2)
      std::abs(0.5 * std::log(other.poles.stiffness_per_s2 / kept.poles.stiffness_per_s2));
  if (change < kLeastChange || change > kMostChange) return {};
  return fmt::format(
      "is not a single decaying oscillation: its parts ring at {:.4g} and {:.4g} Hz (a chirp or a "
      "beat?)",
      1 / PeriodOf(kept.poles), 1 / PeriodOf(other.poles));
}

// beyond this share of the spring's force the motion ends within five swings: not a ring-down
constexpr double kMostFriction = 0.045;

// friction over the spring's force at the first swing
double FrictionShare(const RingFit& fit, RecordedSignal signal) {
  const double per_motion =
      signal == RecordedSignal::kVoltage ? std::sqrt(fit.poles.stiffness_per_s2) : 1;
  return fit.friction * per_motion / fit.Envelope(0);
}

// whether friction explains the record better than no friction does, and slows the motion
bool Holds(const RingFit& without, const RingFit& with, RecordedSignal signal) {
  // F ratio of the one friction parameter
  const double left = with.Squares();
  const auto degrees = static_cast<double>(with.jacobian.rows - with.jacobian.columns);
  const double share = FrictionShare(with, signal);
  return with.converged && share > 0 && share < kMostFriction &&
         without.Squares() - left > kLeastFrictionGain * left / degrees;
}

// whether more friction than that explains most of what is left
bool StopsAtOnce(const RingFit& without, const RingFit& with, RecordedSignal signal) {
  constexpr double kMostLeft = 0.25;
  return with.converged && FrictionShare(with, signal) >= kMostFriction &&
         with.Squares() < kMostLeft * without.Squares();
}

// writes the difference between a motion without friction and the part's samples
void WriteLinearLessFriction(const ImpulseRecord& record, const RingStart& start,
                             const RingSamples& samples, const RingFit& fit, Disturbances* part) {
  // the fit's time begins in the middle of the first block, whose mean is less than the motion
  const double middle_s =
      samples.times_s.front() -
      (record.start_s + static_cast<double>(part->first_sample) * record.step_s);
  // mean of a sine over a block: sin(a)/a of its value in the middle, a = w T/2
  const double half_angle = 0.5 * std::sqrt(fit.poles.stiffness_per_s2) * samples.step_s;
  const double mean_share =
      samples.step_s > 1.5 * record.step_s ? std::sin(half_angle) / half_angle : 1;
  const double first_s = record.start_s + static_cast<double>(part->first_sample) * record.step_s;
  std::vector<double> since_s;
  for (std::size_t n = part->first_sample; n < part->end_sample; ++n) {
    since_s.push_back(static_cast<double>(n - part->first_sample) * record.step_s - middle_s);
  }
  const FrictionRing ring{.poles = fit.poles,
                          .even_v = fit.even_v / mean_share,
                          .odd_v_per_s = fit.odd_v_per_s / mean_share,
                          .friction = fit.friction / mean_share,
                          .signal = record.signal};
  const bool is_release = record.release_current_a.has_value();
  // begin of the motion from the fit's origin of time, s
  const double begin_s = (is_release ? start.release_s : start.impact_s) - first_s - middle_s;
  part->linear_less_friction_v = LinearLessFriction(ring, begin_s, is_release, since_s);
  part->friction_share = FrictionShare(fit, record.signal);
  part->found.Add(About(record.name, Severity::kNote, FindingKind::kDryFriction,
                        {{"share", part->friction_share}}));
}

// Whether a strong hum is missing in what precedes the motion: then it stands for something that
// the motion itself does.
bool HumIsMissingBefore(const ImpulseRecord& record, const RingStart& start,
                        const RingSamples& samples, const RingFit& fit) {
  constexpr double kStrong = 0.2;     // of the ringing
  constexpr double kMostLeft = 0.25;  // of the hum's power
  const double seen_s = static_cast<double>(start.quiet_samples) * record.step_s;
  const double amplitude_v = fit.HumAmplitude();
  // a weak hum, or less than half of its period before the motion: not tested
  if (fit.hum.empty() || amplitude_v < kStrong * fit.Envelope(0) ||
      seen_s * fit.hum.front().frequency_hz < 0.5) {
    return false;
  }
  // samples before the motion, less the fitted hum
  std::vector<double> left;
  for (std::size_t n = 0; n < start.quiet_samples; ++n) {
    if (!std::isfinite(record.voltage_v[n])) continue;
    const double time_s = record.start_s + static_cast<double>(n) * record.step_s;
    left.push_back(record.voltage_v[n]);
    for (const HumLine& line : fit.hum) left.back() -= line.At(time_s);
  }
  const double block = samples.step_s / record.step_s;
  // noise power of single samples: that of the blocks times the block's length
  const double noise = fit.Squares() / static_cast<double>(fit.jacobian.residuals.size()) * block;
  const Eigen::Map<const Eigen::ArrayXd> all(left.data(), static_cast<Eigen::Index>(left.size()));
  const double square = (all - all.mean()).square().mean();
  // remaining power beyond the noise, against the hum's own A^2/2
  return square - 2 * noise > kMostLeft * 0.5 * amplitude_v * amplitude_v;
}

// Whether another motion precedes the part: the end of a chirp or of a beat resembles a ring-down
// when it is cut off. What precedes may be noise, or a ring-down before a later impact; what no
// decaying oscillation explains of it, beyond noise, is compared with the part's first power.
bool FollowsAnotherMotion(const ImpulseRecord& record, const RingStart& start,
                          const Disturbances& part, const RingSamples& samples,
                          const RingFit& fit) {
  // share of the part's first power, and deviations: see disturbances.h
  constexpr double kMostOther = 0.15;
  constexpr double kSurely = 5;
  const double period_s = PeriodOf(fit.poles);
  const auto block = static_cast<std::size_t>(std::lround(samples.step_s / record.step_s));
  const auto margin = static_cast<std::size_t>(period_s / 4 / record.step_s);
  // behind a cut, from the ring-down's first sample on; else from the record's
  const std::size_t first = part.first_sample > start.first_sample ? start.first_sample : 0;
  if (part.first_sample <= first + margin) return false;
  const std::size_t end = part.first_sample - margin;
  const double seen_s = static_cast<double>(end - first) * record.step_s;
  const RingSamples before = BlocksOf(record, first, end, block);
  if (before.values_v.size() < kLeastBlocks || seen_s < period_s / 2) return false;
  // one decaying oscillation may precede, on the same drift and hum: only its residual counts as
  // another motion
  RingBackground background = part.background;
  background.has_friction = false;
  const RingFit other = FitRing(before, fit.poles, background);
  const RingEvidence left = EvidenceOf(before, other, 0);
  // powers in units of the part's first amplitude squared
  const double share = std::pow(other.Envelope(0) / fit.Envelope(0), 2);
  return left.lasting_share * share > kMostOther &&
         left.lasting_share > kSurely * left.lasting_share_deviation;
}

// Whether an oscillation of few periods leaves what the noise before it does not explain. A wrong
// one leaves little of so short a part that its samples alone do not call noise.
std::string TooShortToTell(const RingSamples& samples, const RingFit& fit, double noise_v) {
  constexpr double kFewPeriods = 2;
  constexpr double kMuchNoise = 10;       // times that before the impact
  constexpr double kMostResidual = 0.01;  // of the first amplitude
  const double periods = (samples.times_s.back() - samples.times_s.front()) / PeriodOf(fit.poles);
  const double left_v =
      std::sqrt(fit.Squares() / static_cast<double>(fit.jacobian.residuals.size()));
  if (noise_v == 0 || periods >= kFewPeriods || left_v < kMuchNoise * noise_v ||
      left_v < kMostResidual * fit.Envelope(0)) {
    return {};
  }
  return fmt::format(
      "holds only {:.2g} periods of a ring-down, and {:.2g} times the noise before it remains",
      periods, left_v / noise_v);
}

// A doubt where what is slower than the ringing, and no line, remains: means of the residuals over
// two periods that are five times as far from 0 as their white noise gives. It leaks into the
// ringing's own decay and frequency.
void DoubtSlowRest(const ImpulseRecord& record, const RingSamples& samples, const RingFit& fit,
                   Disturbances* part) {
  constexpr double kPeriods = 2;
  constexpr std::size_t kLeastMeans = 8;
  constexpr double kFar = 5;
  constexpr double kLeastShare = 5e-4;  // of the ringing's first amplitude, as of a drift
  const auto& residuals = fit.jacobian.residuals;
  const auto length = static_cast<std::size_t>(kPeriods * PeriodOf(fit.poles) / samples.step_s);
  const std::size_t count = length > 0 ? residuals.size() / length : 0;
  if (count < kLeastMeans) return;
  const Eigen::Map<const Eigen::ArrayXXd> columns(
      residuals.data(), static_cast<Eigen::Index>(length), static_cast<Eigen::Index>(count));
  const Eigen::ArrayXd means = columns.colwise().mean();
  const Eigen::Map<const Eigen::ArrayXd> all(residuals.data(), std::ssize(residuals));
  const double noise = 0.5 * (all.tail(all.size() - 1) - all.head(all.size() - 1)).square().mean();
  const double largest = means.abs().maxCoeff();
  if (means.square().mean() * static_cast<double>(length) < kFar * kFar * noise ||
      largest < kLeastShare * fit.Envelope(0)) {
    return;
  }
  part->found.Add(About(record.name, Severity::kDoubt, FindingKind::kSlowRest,
                        {{InUnit(record, "amplitude_v", "amplitude_m"), largest}}));
}

// whether what is left of the part is one ring-down, and where its tail ends
void Judge(const ImpulseRecord& record, const RingStart& start, const RingSamples& samples,
           const RingFit& fit, Disturbances* part) {
  // what changes with the amplitude is for consistency.h to judge
  if (fit.friction > 0) WriteLinearLessFriction(record, start, samples, fit, part);
  const double step_v = ConverterStep(record.voltage_v);
  const double quiet_v = start.quiet_samples > 0 ? start.quiet_noise_v : 0;
  // least noise of a block, V: rounding step/sqrt(12), or the noise before the impact
  const double floor_v =
      std::max(step_v / std::sqrt(12.0), std::min(quiet_v, 0.1 * fit.Envelope(0))) /
      std::sqrt(samples.step_s / record.step_s);
  const std::size_t cuts = part->evidence.cuts;
  part->evidence = EvidenceOf(samples, fit, floor_v);
  part->evidence.cuts = cuts;
  // quiet: noise before the impact below twice the residual, or a fifth of the ringing
  part->evidence.begins =
      start.quiet_samples > 0 &&
      quiet_v < std::hypot(2 * start.residual_rms_v, kQuietShare * fit.Envelope(0));
  part->no_ring_down =
      NoRingDown(part->evidence, samples, fit, record.drop_height_m || record.release_current_a);
  if (part->no_ring_down.empty() && part->evidence.begins) {
    part->no_ring_down = TooShortToTell(samples, fit, std::max(quiet_v, step_v));
  }
  if (part->no_ring_down.empty() && !part->follows_a_later_blow &&
      HumIsMissingBefore(record, start, samples, fit)) {
    part->no_ring_down = fmt::format(
        "is not a single decaying oscillation: what looks like hum of {:g} Hz does not precede it "
        "(a chirp or a beat?)",
        fit.hum.front().frequency_hz);
  }
  if (part->no_ring_down.empty() && FollowsAnotherMotion(record, start, *part, samples, fit)) {
    part->no_ring_down = fmt::format(
        "is not a single decaying oscillation: another motion precedes that of {:.4g} Hz (a chirp "
        "or a beat?)",
        1 / PeriodOf(fit.poles));
  }
  if (part->no_ring_down.empty()) DoubtSlowRest(record, samples, fit, part);
  // the evidence is of the whole part; a tail that is not silent is cut only then
  CutQuantisedTail(record, start, fit, part);
}

// hum of the mains, or a slow course, becomes part of the background that is fitted
void TakeIntoBackground(const ImpulseRecord& record, const Suspect& found, Disturbances* part) {
  const FindingNumber amplitude{InUnit(record, "amplitude_v", "amplitude_m"), found.amplitude_v};
  if (found.kind == Suspect::Kind::kHum) {
    part->background.hum_hz.push_back(found.value);
    part->found.Add(About(record.name, Severity::kNote, FindingKind::kHum,
                          {{"frequency_hz", found.value}, amplitude}));
  } else {
    part->background.drifts = true;
    part->found.Add(About(record.name, Severity::kNote, FindingKind::kDrift, {amplitude}));
  }
}

// friction is accepted only if the fit with friction as a parameter confirms the first-order trial
bool TakesFriction(const ImpulseRecord& record, const RingSamples& above, Disturbances* part) {
  if (above.values_v.size() < kLeastBlocks) return false;
  RingBackground rubbing = part->background;
  const RingFit without = FitRing(above, part->poles, rubbing);
  rubbing.has_friction = true;
  const RingFit with = FitRing(above, part->poles, rubbing);
  const bool holds = Holds(without, with, record.signal);
  if (!holds && StopsAtOnce(without, with, record.signal)) {
    part->no_ring_down = "is stopped by dry friction within its first swings";
  }
  part->background.has_friction = holds;
  if (holds) part->poles = with.poles;
  return holds;
}

// FindDisturbances(), with later impacts or as if there were none
Disturbances Search(const ImpulseRecord& record, const RingStart& start, bool may_have_blows) {
  constexpr double kLightDamping = 0.3;  // of critical
  Disturbances part;
  part.first_sample = start.first_sample;
  part.end_sample = record.voltage_v.size();
  part.poles = start.poles;
  bool may_have_friction = true;
  std::size_t cuts = 0;
  std::size_t above_step_end = 0;  // of the samples by which friction is judged
  // each round accepts the disturbance with the largest gain, until none is left
  for (int round = 0; round < kMostRounds; ++round) {
    // 16 blocks per period, but at least 256 blocks in the part
    const double wanted = PeriodOf(part.poles) / (kSamplesPerPeriod * record.step_s);
    const std::size_t length = part.end_sample - part.first_sample;
    const std::size_t block = std::clamp<std::size_t>(static_cast<std::size_t>(wanted), 1,
                                                      std::max<std::size_t>(length / 256, 1));
    const std::size_t end = part.background.has_friction ? above_step_end : part.end_sample;
    const auto samples = BlocksOf(record, part.first_sample, end, block);
    if (samples.values_v.size() < kLeastBlocks) break;
    RingFit fit = FitRing(samples, part.poles, part.background);
    if (fit.converged) part.poles = fit.poles;
    // a tail at one code is no ringing: its sudden end would resemble an impact
    if (fit.converged && !part.found.Has(FindingKind::kQuantisedTail) &&
        IsSilentFrom(record, EndAboveStep(record, start, fit, part), part)) {
      CutQuantisedTail(record, start, fit, &part);
      continue;
    }
    // dry friction is fitted to lightly damped motions only
    may_have_friction =
        may_have_friction &&
        part.poles.decay_per_s < kLightDamping * std::sqrt(part.poles.stiffness_per_s2);
    const Suspect worst = fit.converged ? WorstSuspect(samples, fit, part.background,
                                                       may_have_friction, may_have_blows)
                                        : Suspect{};
    if (worst.kind == Suspect::Kind::kBlow) {
      const Disturbances before = part;
      CutAt(record, fit, worst, &part);
      ++cuts;
      // a cut changes the part: friction is tried again
      part.background.has_friction = false;
      may_have_friction = true;
      part.no_ring_down = OtherSide(record, before, part, fit);
      if (!part.no_ring_down.empty()) return part;
    } else if (worst.kind == Suspect::Kind::kHum || worst.kind == Suspect::Kind::kDrift) {
      TakeIntoBackground(record, worst, &part);
    } else if (worst.kind == Suspect::Kind::kFriction) {
      // a motion whose last swings the converter does not show resembles one that friction stops
      above_step_end = EndAboveStep(record, start, fit, part);
      may_have_friction =
          TakesFriction(record, BlocksOf(record, part.first_sample, above_step_end, block), &part);
      if (!part.no_ring_down.empty()) return part;
    } else {
      part.evidence.cuts = cuts;
      Judge(record, start, samples, fit, &part);
      return part;
    }
  }
  part.evidence.cuts = cuts;
  part.no_ring_down = "is disturbed again and again: no ring-down is left alone";
  return part;
}

}  // namespace

Disturbances FindDisturbances(const ImpulseRecord& record, const RingStart& start) {
  Disturbances part = Search(record, start, true);
  if (part.no_ring_down.empty() || part.evidence.cuts <= kMostCuts) return part;
  // Repeated cuts may be caused by something small and lasting, such as another mode or a slow
  // tail, and not by impacts: the record without cuts decides.
  Disturbances whole = Search(record, start, false);
  if (!whole.no_ring_down.empty()) return part;
  whole.found.Add(About(record.name, Severity::kNote, FindingKind::kOtherMode,
                        {{"unexplained_share", whole.evidence.UnexplainedShare()}}));
  return whole;
}

}  // namespace haptometer::fit
