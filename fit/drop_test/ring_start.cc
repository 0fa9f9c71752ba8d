#include "fit/drop_test/ring_start.h"

#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "base/median.h"
#include "fit/drop_test/first_look.h"
#include "fit/drop_test/ring_fit.h"
#include "fit/drop_test/ringing_model.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

constexpr std::size_t kLeastSamples = 32;
constexpr double kLeastPeriods = 2;
// of a ring-down of fewer periods the slow course takes swings, and leaves others that are none
constexpr double kPeriodsBesideSlow = 10;
constexpr double kLeastSamplesPerPeriod = 5;
constexpr std::size_t kLeastQuietSamples = 16;
// below this energy over noise density the decay rate is uncertain to 2/sqrt(50) = 28 %
constexpr double kLeastEnergy = 50;
// of critical damping: from here on the motion is treated as one without oscillation
constexpr double kHeavy = 0.7;
// the grid for these: 0.5 to 29 times the pencil's natural frequency, 0.7 to 10 times critical
constexpr int kNaturals = 11;
constexpr int kDampings = 11;
// blocks that the poles of an oscillation are fitted to: enough for a period's shape
constexpr double kBlocksPerPeriod = 16;
constexpr std::size_t kLeastBlocks = 32;

std::vector<double> From(const std::vector<double>& values, std::size_t first, double offset) {
  std::vector<double> rest(values.begin() + static_cast<std::ptrdiff_t>(first), values.end());
  for (double& value : rest) value -= offset;
  return rest;
}

// the first sample beyond half of the largest distance from `middle`
std::size_t FindLargeSample(const std::vector<double>& values, double middle) {
  double peak = 0;
  for (const double value : values) peak = std::max(peak, std::abs(value - middle));
  std::size_t n = 0;
  while (n + 1 < values.size() && std::abs(values[n] - middle) <= peak / 2) ++n;
  return n;
}

double RmsAboutMean(const std::vector<double>& values, std::size_t count) {
  const Eigen::Map<const Eigen::ArrayXd> quiet(values.data(), static_cast<Eigen::Index>(count));
  return std::sqrt((quiet - quiet.mean()).square().sum() / static_cast<double>(count - 1));
}

// voltage = even * E(t) + odd * O(t) + offset, t from the first sample
struct LinearFit {
  double even_v = 0;
  double odd_v_per_s = 0;
  double offset_v = 0;
  double residual_rms_v = 0;
  double energy_v2 = 0;  // sum of squares of the oscillation
};

// linear least squares of E, O and 1 at fixed poles
LinearFit FitLinear(const std::vector<double>& values, double step_s, const PolePair& poles) {
  const auto count = static_cast<Eigen::Index>(values.size());
  Eigen::MatrixX3d basis(count, 3);
  RingingMoments moments(poles.decay_per_s, poles.stiffness_per_s2, 0, step_s);
  for (Eigen::Index n = 0; n < count; ++n) {
    const RingingMoment moment = moments.At(static_cast<double>(n) * step_s);
    basis.row(n) << moment.even, moment.odd, 1.0;
  }
  const Eigen::Map<const Eigen::VectorXd> samples(values.data(), count);
  const Eigen::Vector3d fitted = basis.householderQr().solve(samples);
  const Eigen::VectorXd ringing = basis.leftCols(2) * fitted.head(2);
  return {
      .even_v = fitted[0],
      .odd_v_per_s = fitted[1],
      .offset_v = fitted[2],
      .residual_rms_v = (samples - basis * fitted).norm() / std::sqrt(static_cast<double>(count)),
      .energy_v2 = ringing.squaredNorm()};
}

// `poles` fitted to the record's blocks from `first` on
PolePair Refined(const ImpulseRecord& record, std::size_t first, const PolePair& poles,
                 std::size_t block) {
  const auto samples = BlocksOf(record, first, record.voltage_v.size(), block);
  if (samples.values_v.size() < kLeastSamples) return poles;
  const RingFit fit = FitRing(samples, poles, {});
  return fit.converged ? fit.poles : poles;
}

// The pencil's poles are up to three times as uncertain as they need be: of two noisy records they
// may be so far apart that a joint fit loses the phase of one.
PolePair BestOscillating(const ImpulseRecord& record, std::size_t first, const PolePair& seen) {
  const double period_s = 2 * std::numbers::pi / std::sqrt(seen.stiffness_per_s2);
  const std::size_t most = std::max((record.voltage_v.size() - first) / kLeastBlocks, 1UZ);
  const double block = period_s / (kBlocksPerPeriod * record.step_s);
  const PolePair best =
      Refined(record, first, seen,
              static_cast<std::size_t>(std::clamp(block, 1.0, static_cast<double>(most))));
  return best.decay_per_s > 0 && best.stiffness_per_s2 > 0 ? best : seen;
}

// Of motions without oscillation the matrix pencil determines little: its blocks of an eighth of
// the slow decay time average the fast decay out. The best of a grid of natural frequencies and
// dampings, refined.
PolePair BestHeavilyDamped(const ImpulseRecord& record, std::size_t first,
                           const std::vector<double>& values, const PolePair& seen) {
  PolePair best = seen;
  double least_v = FitLinear(values, record.step_s, seen).residual_rms_v;
  const double lowest = std::sqrt(seen.stiffness_per_s2);
  for (int row = 0; row < kNaturals; ++row) {
    const double natural = lowest / 2 * std::pow(1.5, row);
    for (int column = 0; column < kDampings; ++column) {
      const double zeta = kHeavy * std::pow(1.3, column);
      const PolePair tried{zeta * natural, natural * natural};
      const double rms_v = FitLinear(values, record.step_s, tried).residual_rms_v;
      if (!(rms_v < least_v)) continue;
      least_v = rms_v;
      best = tried;
    }
  }
  return Refined(record, first, best, 1);
}

bool IsHeavilyDamped(const PolePair& poles) {
  return poles.decay_per_s > kHeavy * std::sqrt(poles.stiffness_per_s2);
}

// a motion of these poles: even * E(t) + odd * O(t), and its value at a time
struct Swing {
  double even = 0;
  double odd = 0;

  [[nodiscard]] double At(const PolePair& poles, double time_s) const {
    const auto pair = sim::DampedFundamentals(poles.decay_per_s, poles.stiffness_per_s2, time_s);
    return even * pair.even + odd * pair.odd;
  }
};

// the swing of the slope: E' = (d^2 - q) O - d E and O' = E - d O
Swing SlopeOf(const Swing& swing, const PolePair& poles) {
  const double d = poles.decay_per_s;
  return {swing.odd - d * swing.even,
          (d * d - poles.stiffness_per_s2) * swing.even - d * swing.odd};
}

// the displacement whose velocity is `swing`: x0 = -(odd + d even)/q, E x0 + O (even + d x0)
Swing IntegralOf(const Swing& swing, const PolePair& poles) {
  const double x0 = -(swing.odd + poles.decay_per_s * swing.even) / poles.stiffness_per_s2;
  return {x0, swing.even + poles.decay_per_s * x0};
}

// the zero that is nearest to `near_s`
double ZeroNear(const Swing& swing, const PolePair& poles, double near_s) {
  const double square = poles.stiffness_per_s2 - poles.decay_per_s * poles.decay_per_s;
  if (square > 0) {
    const double angular = std::sqrt(square);
    // zeros of even cos(w t) + odd/w sin(w t): tan(w t) = -w even/odd, half a period apart
    const double zero = std::atan2(-angular * swing.even, swing.odd) / angular;
    const double half_period = std::numbers::pi / angular;
    return zero + half_period * std::round((near_s - zero) / half_period);
  }
  // overdamped: tanh(r t) = -r even/odd, at most one zero
  const double rate = std::sqrt(-square);
  const double ratio = -rate * swing.even / swing.odd;
  return rate > 0 && std::abs(ratio) < 1 ? std::atanh(ratio) / rate : near_s;
}

// `value`, which is below `limit`, with as many decimals as it takes to print otherwise
std::string Below(double value, double limit, int decimals) {
  constexpr int kMostDecimals = 9;
  std::string text = fmt::format("{:.{}f}", value, decimals);
  while (text == fmt::format("{:.{}f}", limit, decimals) && decimals < kMostDecimals) {
    text = fmt::format("{:.{}f}", value, ++decimals);
  }
  return text;
}

std::unexpected<Error> Unfit(const ImpulseRecord& record, std::string what, std::string remedy) {
  return CannotAnswer(record.name, std::move(what), std::move(remedy));
}

// the impact and what precedes it, in samples
struct Blow {
  std::size_t sample = 0;  // the first behind it
  double middle_v = 0;     // median of the record
  double frequency_hz = 0;
  double period_samples = 0;
};

// The sample that divides the quiet part from the ring-down with the least sum of squares: of the
// samples before it, and of the residuals of the ring-down that is continued back from `known`.
std::size_t PartQuietFromRinging(const std::vector<double>& values, double step_s, const Blow& blow,
                                 std::size_t first, std::size_t known) {
  const auto ringing = From(values, known, blow.middle_v);
  const auto poles = EstimatePoles(ringing, step_s);
  if (!poles) return first;
  const LinearFit fit = FitLinear(ringing, step_s, *poles);
  double gain = 0;
  double least = 0;
  std::size_t best = known;
  // one sample earlier: the ring-down's residual is added, the quiet sample's square is removed
  for (std::size_t n = known; n-- > first;) {
    const double before_s = -step_s * static_cast<double>(known - n);
    const auto pair =
        sim::DampedFundamentals(poles->decay_per_s, poles->stiffness_per_s2, before_s);
    const double model = fit.even_v * pair.even + fit.odd_v_per_s * pair.odd + fit.offset_v;
    const double value = values[n] - blow.middle_v;
    const double quiet = value - fit.offset_v;
    gain += (value - model) * (value - model) - quiet * quiet;
    if (gain >= least) continue;
    least = gain;
    best = n;
  }
  return best;
}

// Residual sum of squares of a record that is divided before sample `n`: a constant, then a
// ring-down of these poles, or of those estimated from it; infinite where the rest is none.
double Misfit(const std::vector<double>& values, double step_s, const Blow& blow, std::size_t n,
              std::optional<PolePair> poles) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto ringing = From(values, n, blow.middle_v);
  if (!poles) poles = EstimatePoles(ringing, step_s);
  if (!poles || IsHeavilyDamped(*poles)) return kNone;
  const LinearFit fit = FitLinear(ringing, step_s, *poles);
  double sum = fit.residual_rms_v * fit.residual_rms_v * static_cast<double>(ringing.size());
  // the quiet part lies at the ring-down's own offset
  for (std::size_t k = 0; k < n; ++k) {
    const double quiet = values[k] - blow.middle_v - fit.offset_v;
    sum += quiet * quiet;
  }
  return sum;
}

// the best parting from `first` up to `end` to a sixteenth of a period, or the first sample beyond
// half of the largest where that is better
std::size_t BestParting(const std::vector<double>& values, double step_s, const Blow& blow,
                        std::size_t first, std::size_t end, std::optional<PolePair> poles = {}) {
  const auto period = static_cast<std::size_t>(std::ceil(blow.period_samples));
  const std::size_t stride = std::max<std::size_t>(period / 16, 1);
  std::size_t best = FindLargeSample(values, blow.middle_v);
  double least = Misfit(values, step_s, blow, best, poles);
  // at least two periods remain for the ring-down
  for (std::size_t n = first; n < end && n + 2 * period < values.size(); n += stride) {
    const double misfit = Misfit(values, step_s, blow, n, poles);
    if (misfit >= least) continue;
    least = misfit;
    best = n;
  }
  return best;
}

// the poles of an oscillation that falls so much within a period of its begin that too little is
// left there to be continued back
std::optional<PolePair> PolesOfFastDecay(const std::vector<double>& amplitudes, double step_s,
                                         const Blow& blow) {
  constexpr double kLeast = 0.04;  // of the amplitude a period later: a quality factor of 1
  constexpr double kMost = 0.5;    // 4.5
  const auto largest = std::ranges::max_element(amplitudes);
  const auto later = static_cast<std::size_t>(largest - amplitudes.begin()) +
                     static_cast<std::size_t>(std::ceil(blow.period_samples));
  if (later >= amplitudes.size()) return std::nullopt;
  const double share = amplitudes[later] / *largest;
  if (share < kLeast || share > kMost) return std::nullopt;
  const double decay_per_s = -std::log(share) / (blow.period_samples * step_s);
  return PolePair{decay_per_s, std::pow(2 * std::numbers::pi * blow.frequency_hz, 2) +
                                   decay_per_s * decay_per_s};
}

// where the amplitude at the resonance has risen to half of its largest, and around there the best
// parting; of a record too short for its amplitude to be followed, the best of all
std::size_t FindBlow(const std::vector<double>& values, double step_s, const Blow& blow) {
  const auto period = static_cast<std::size_t>(std::ceil(blow.period_samples));
  const auto amplitudes = FollowingAmplitude(values, blow.middle_v, blow.period_samples);
  if (6 * period > values.size() || amplitudes.empty()) {
    return BestParting(values, step_s, blow, 0, values.size());
  }
  // where the amplitude over the following period reaches half of its largest
  const double half = *std::ranges::max_element(amplitudes) / 2;
  const auto risen = static_cast<std::size_t>(
      std::ranges::find_if(amplitudes, [half](double a) { return a >= half; }) -
      amplitudes.begin());
  // the amplitude at n is that of the period behind n: a period and a quarter later, only ringing
  const std::size_t known = risen + period + period / 4;
  if (known + 3 * period > values.size()) {
    return BestParting(values, step_s, blow, 0, values.size());
  }
  const std::size_t first = risen > period ? risen - period : 0;
  if (const auto poles = PolesOfFastDecay(amplitudes, step_s, blow)) {
    return BestParting(values, step_s, blow, first, known, poles);
  }
  return PartQuietFromRinging(values, step_s, blow, first, known);
}

Result<Blow> LocateBlow(const ImpulseRecord& record, const std::vector<double>& values) {
  Blow blow;
  blow.middle_v = Median(values);
  // a rough begin, good enough for the frequency of the strongest oscillation
  const auto rough = FindLargeSample(values, blow.middle_v);
  const auto frequency_hz = StrongestFrequency(From(values, rough, blow.middle_v), record.step_s);
  if (!frequency_hz) {
    return Unfit(record, "shows no ring-down",
                 "the readings must jump and then decay for at least 32 samples");
  }
  blow.frequency_hz = *frequency_hz;
  blow.period_samples = 1 / (*frequency_hz * record.step_s);
  blow.sample = FindBlow(values, record.step_s, blow);
  const double periods = static_cast<double>(values.size() - blow.sample) / blow.period_samples;
  if (periods < kLeastPeriods) {
    return Unfit(record,
                 fmt::format("holds only {} periods after the impact; at least {:g} are needed",
                             Below(periods, kLeastPeriods, 1), kLeastPeriods),
                 "record at least three decay times of one free ring-down");
  }
  return blow;
}

// The voltage around an impact of half a sine of force whose middle is at 0, over the ring-down's
// own first value. While it lasts, T long, a speed of 1 is given to an oscillation w,
//
//     v = (cos(w u) - cos(pi u/T)) / (2 cos(w T/2)),   u the time since its begin;
//
// behind it the ring-down cos(w t) - d/w sin(w t) is as if all had come at once in its middle. The
// decay is that of an impact without length, to first order of d T.
double AroundBlow(const PolePair& poles, double contact_s, double time_s) {
  // w^2 = q - d^2, at least q/100 near critical damping
  const double angular =
      std::sqrt(std::max(poles.stiffness_per_s2 - poles.decay_per_s * poles.decay_per_s,
                         0.01 * poles.stiffness_per_s2));
  const double since_s = time_s + contact_s / 2;
  if (since_s <= 0) return 0;
  // free decay in units of the first value: e^(-d t) (cos(w t) - d/w sin(w t)), behind the contact
  const double fall = std::exp(-poles.decay_per_s * std::max(time_s, 0.0));
  const double slowed = poles.decay_per_s / angular * std::sin(angular * std::max(time_s, 0.0));
  if (time_s >= contact_s / 2) return fall * (std::cos(angular * time_s) - slowed);
  const double gained =
      (std::cos(angular * since_s) - std::cos(std::numbers::pi * since_s / contact_s)) /
      (2 * std::cos(angular * contact_s / 2));
  return fall * (gained - slowed);
}

// samples around an impact, with times from its estimate
struct Around {
  std::vector<double> times_s;
  std::vector<double> values_v;  // without offset
};

// residual sum of squares for this contact length; amplitude and time of the impact are free
double LeftByContact(const Around& around, const PolePair& poles, double contact_s,
                     double amplitude_v) {
  // step of the derivative by time: w dt = 1e-4
  const double nudge_s = 1e-4 / std::sqrt(poles.stiffness_per_s2);
  double blow_s = 0;
  double left = 0;
  // amplitude and time by Gauss and Newton's method
  for (int round = 0; round < 5; ++round) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d seen = Eigen::Vector2d::Zero();
    left = 0;
    for (std::size_t n = 0; n < around.times_s.size(); ++n) {
      const double time_s = around.times_s[n] - blow_s;
      const double shape = AroundBlow(poles, contact_s, time_s);
      const double later = AroundBlow(poles, contact_s, time_s - nudge_s);
      const double residual = around.values_v[n] - amplitude_v * shape;
      const Eigen::Vector2d slopes(shape, amplitude_v * (later - shape) / nudge_s);
      normal += slopes * slopes.transpose();
      seen += slopes * residual;
      left += residual * residual;
    }
    if (round == 4) break;
    // keeps the system regular where both columns are parallel
    normal.diagonal() *= 1 + 1e-9;
    const Eigen::Vector2d step = normal.ldlt().solve(seen);
    if (!step.allFinite()) break;
    amplitude_v += step[0];
    // w dt of a step at most 0.05, within the range of the linearisation
    const double most_s = 0.05 / std::sqrt(poles.stiffness_per_s2);
    blow_s += std::clamp(step[1], -most_s, most_s);
  }
  return left;
}

// How long the contact lasts: all lengths up to a third of a period whose sum of squares exceeds
// the least by at most four variances of the noise, widened by 30 % for a force of another shape.
void WriteContact(const ImpulseRecord& record, const std::vector<double>& values,
                  RingStart* start) {
  constexpr std::size_t kMostSamples = 200;
  constexpr int kLengths = 48;
  constexpr double kLeastNoise = 1e-3;  // of the first voltage: decay and friction meanwhile
  constexpr double kShape = 0.3;
  const double period_s = 2 * std::numbers::pi / std::sqrt(start->poles.stiffness_per_s2);
  // 0.3 of a period on either side of the impact, in at most 200 samples
  const double reach = 0.3 * period_s / record.step_s;
  const double middle = (start->impact_s - record.start_s) / record.step_s;
  const auto stride = static_cast<std::size_t>(std::max(2 * reach / kMostSamples, 1.0));
  Around around;
  bool has_all = true;  // none is missing, or clipped
  for (auto n = static_cast<std::size_t>(std::max(std::ceil(middle - reach), 0.0));
       static_cast<double>(n) < middle + reach && n < values.size(); n += stride) {
    if (!std::isfinite(record.voltage_v[n])) {
      has_all = false;
      continue;
    }
    around.times_s.push_back((static_cast<double>(n) - middle) * record.step_s);
    around.values_v.push_back(values[n] - start->offset_v);
  }
  // residuals of 48 lengths from 0 to a third of a period
  std::array<double, kLengths> left{};
  for (std::size_t k = 0; k < left.size(); ++k) {
    const double contact_s = static_cast<double>(k) / (kLengths - 1) * period_s / 3;
    left[k] = LeftByContact(around, start->poles, contact_s, start->impact_voltage_v);
  }
  const double least = *std::ranges::min_element(left);
  // degrees of freedom: samples less amplitude, time and length
  const double degrees = std::max(static_cast<double>(around.times_s.size()) - 3, 1.0);
  const double noise_v = std::max({start->quiet_noise_v, std::sqrt(least / degrees),
                                   kLeastNoise * std::abs(start->impact_voltage_v)});
  // chi^2 above the least by 4: 95 % of one parameter
  const auto holds = [&](double sum) { return sum <= least + 4 * noise_v * noise_v; };
  const auto first = std::ranges::find_if(left, holds) - left.begin();
  const auto last = std::ranges::find_if(left.rbegin(), left.rend(), holds) - left.rbegin();
  const double between_s = period_s / 3 / (kLengths - 1);
  // from one grid step below the first accepted length to one above the last
  start->shortest_contact_s =
      has_all ? (1 - kShape) * between_s * std::max(static_cast<double>(first) - 1, 0.0) : 0;
  start->longest_contact_s = (1 + kShape) * between_s * static_cast<double>(kLengths - last);
  start->contact_may_be_longer = last == 0;
}

// whether the ring-down's energy exceeds the noise and it is sampled densely enough
Result<void> CheckQuality(const ImpulseRecord& record, const Blow& blow, const LinearFit& fit) {
  // rho of ring_start.h: sum of squares of the oscillation over the noise's mean square
  const double energy = fit.energy_v2 / (fit.residual_rms_v * fit.residual_rms_v);
  if (energy < kLeastEnergy) {
    return Unfit(
        record,
        fmt::format("the oscillation at {:.4g} Hz has only {} dB more energy than the noise",
                    blow.frequency_hz,
                    Below(10 * std::log10(energy), 10 * std::log10(kLeastEnergy), 1)),
        fmt::format("record a stronger impact or a smaller range of the converter; at least {:.1f} "
                    "dB are needed",
                    10 * std::log10(kLeastEnergy)));
  }
  if (blow.period_samples < kLeastSamplesPerPeriod) {
    return Unfit(
        record,
        fmt::format("has only {} samples per period; at least {:g} are needed",
                    Below(blow.period_samples, kLeastSamplesPerPeriod, 1), kLeastSamplesPerPeriod),
        "sample faster, at least 10 times the resonance");
  }
  return {};
}

// FindRingStart() of a record whose lasting parts are weak, or taken off
Result<RingStart> StartOf(const ImpulseRecord& record) {
  const auto measured = static_cast<std::size_t>(std::count_if(
      record.voltage_v.begin(), record.voltage_v.end(), [](double v) { return std::isfinite(v); }));
  if (measured < kLeastSamples) {
    return Unfit(record, fmt::format("holds only {} readings", measured),
                 "a ring-down needs at least 32 samples");
  }
  const auto values = Filled(record.voltage_v);
  HAPTOMETER_LET(const auto blow, LocateBlow(record, values));

  // an eighth of a period behind the impact the fit begins; a quarter before it the quiet ends
  RingStart start;
  const auto eighth = static_cast<std::size_t>(std::ceil(blow.period_samples / 8));
  start.first_sample = blow.sample + eighth;
  start.blow_s = record.start_s + static_cast<double>(blow.sample) * record.step_s;
  start.quiet_samples = blow.sample > 2 * eighth ? blow.sample - 2 * eighth : 0;
  if (start.quiet_samples < kLeastQuietSamples) start.quiet_samples = 0;
  if (start.quiet_samples > 0) start.quiet_noise_v = RmsAboutMean(values, start.quiet_samples);

  const auto ringing = From(values, start.first_sample, blow.middle_v);
  const auto poles = EstimatePoles(ringing, record.step_s);
  if (!poles) {
    return Unfit(record, "shows no ring-down",
                 "record at least three decay times after the impact");
  }
  start.poles = IsHeavilyDamped(*poles)
                    ? BestHeavilyDamped(record, start.first_sample, ringing, *poles)
                    : BestOscillating(record, start.first_sample, *poles);
  const LinearFit fit = FitLinear(ringing, record.step_s, start.poles);
  HAPTOMETER_TRY(CheckQuality(record, blow, fit));
  start.offset_v = blow.middle_v + fit.offset_v;
  start.residual_rms_v = fit.residual_rms_v;

  // backwards to the impact, which lies before its first sample
  const double blow_s = static_cast<double>(blow.sample) - (blow.sample > 0 ? 0.5 : 0.0);
  const double near_s = (blow_s - static_cast<double>(start.first_sample)) * record.step_s;
  const double first_s = record.start_s + static_cast<double>(start.first_sample) * record.step_s;
  const Swing swing{fit.even_v, fit.odd_v_per_s};
  const double impact_s = ZeroNear(IntegralOf(swing, start.poles), start.poles, near_s);
  start.impact_s = first_s + impact_s;
  start.impact_voltage_v = swing.At(start.poles, impact_s);
  // the contact is determined only after a stated height and a quiet part of the record
  if (record.drop_height_m && start.quiet_samples > 0 && !IsHeavilyDamped(start.poles) &&
      record.signal == RecordedSignal::kVoltage) {
    WriteContact(record, values, &start);
    // a long contact is over before the fit begins
    const auto over = static_cast<std::size_t>(std::ceil(
        (start.impact_s + 0.5 * start.longest_contact_s - record.start_s) / record.step_s));
    if (start.shortest_contact_s > 0 && over < start.first_sample + 2 * eighth) {
      start.first_sample = std::max(start.first_sample, over);
    }
  }
  // a released current begins at a zero of the voltage, with the slope Km^2 I0/M
  const double release_s = ZeroNear(swing, start.poles, near_s);
  start.release_s = first_s + release_s;
  start.release_slope_v_per_s = SlopeOf(swing, start.poles).At(start.poles, release_s);
  return start;
}

// periods of the ring-down that the record is long
double Periods(const ImpulseRecord& record, const RingStart& start) {
  const double length_s = static_cast<double>(record.voltage_v.size()) * record.step_s;
  return length_s * std::sqrt(start.poles.stiffness_per_s2) / (2 * std::numbers::pi);
}

// mean square of what the quiet part and the ring-down leave of a record
double LeftOver(const ImpulseRecord& record, const RingStart& start) {
  const auto quiet = static_cast<double>(start.quiet_samples);
  const auto ringing = static_cast<double>(record.voltage_v.size() - start.first_sample);
  return (quiet * std::pow(start.quiet_noise_v, 2) + ringing * std::pow(start.residual_rms_v, 2)) /
         (quiet + ringing);
}

}  // namespace

Result<RingStart> FindRingStart(const ImpulseRecord& record) {
  auto start = StartOf(record);
  auto rest_v = WithoutWhatLasts(record.voltage_v, record.step_s);
  if (!rest_v) return start;
  // of the record as it is and without what lasts, what is explained better
  ImpulseRecord rest = record;
  rest.voltage_v = *std::move(rest_v);
  auto other = StartOf(rest);
  if (!other || Periods(rest, *other) < kPeriodsBesideSlow) return start;
  if (!start || LeftOver(rest, *other) < LeftOver(record, *start)) return other;
  return start;
}

}  // namespace haptometer::fit
