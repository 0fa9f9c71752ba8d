#include "fit/drop_test/ring_fit.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "fit/drop_test/condensed_record.h"
#include "fit/drop_test/ringing_model.h"
#include "fit/identifiability.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

// position and speed
struct State {
  double u = 0;
  double v = 0;
};

// u'' + 2 d u' + q u = 0
class LinearMotion {
 public:
  explicit LinearMotion(const PolePair& poles)
      : decay_per_s_(poles.decay_per_s),
        stiffness_per_s2_(poles.stiffness_per_s2),
        // w^2 = q - d^2, above 0 beyond critical damping too
        angular_per_s_(std::sqrt(std::max(stiffness_per_s2_ - decay_per_s_ * decay_per_s_,
                                          1e-12 * stiffness_per_s2_))) {}

  // u(t) = u (E + d O) + v O and v(t) = v (E - d O) - q u O, E = e^(-d t) cos, O = e^(-d t) sin/w
  [[nodiscard]] State After(const State& from, double since_s) const {
    const double fall = std::exp(-decay_per_s_ * since_s);
    const double even = fall * std::cos(angular_per_s_ * since_s);
    const double odd = fall * std::sin(angular_per_s_ * since_s) / angular_per_s_;
    return {from.u * (even + decay_per_s_ * odd) + from.v * odd,
            from.v * (even - decay_per_s_ * odd) - stiffness_per_s2_ * from.u * odd};
  }

  // time to the first turn behind `from`, v = 0: tan(w t) = w v/(d v + q u)
  [[nodiscard]] double Turn(const State& from) const {
    const double sine = (decay_per_s_ * from.v + stiffness_per_s2_ * from.u) / angular_per_s_;
    double turn_s = std::atan2(from.v, sine) / angular_per_s_;
    const double half_s = std::numbers::pi / angular_per_s_;
    // a turn at 0 is the present one
    while (turn_s <= 1e-9 * half_s) turn_s += half_s;
    return turn_s;
  }

  [[nodiscard]] double half_period_s() const { return std::numbers::pi / angular_per_s_; }

 private:
  double decay_per_s_;
  double stiffness_per_s2_;
  double angular_per_s_;
};

// the recorded quantity: a voltage is proportional to the speed
double Seen(const State& state, RecordedSignal signal) {
  return signal == RecordedSignal::kVoltage ? state.v : state.u;
}

// state at t = 0 of even E + odd O: the motion of a voltage is its integral that decays to 0
State BeginOf(const FrictionRing& ring) {
  const double d = ring.poles.decay_per_s;
  if (ring.signal != RecordedSignal::kVoltage) {
    return {ring.even_v, ring.odd_v_per_s - d * ring.even_v};
  }
  return {-(ring.odd_v_per_s + d * ring.even_v) / ring.poles.stiffness_per_s2, ring.even_v};
}

// direction of the motion; at a turn, that of the spring's force
double DirectionOf(const State& state) {
  if (state.v != 0) return state.v > 0 ? 1 : -1;
  return state.u > 0 ? -1 : 1;
}

// the zero of `value` that is nearest to `near_s` within a half period before 0, by bisection
template <typename Value>
double ZeroBefore(const Value& value, double near_s, double half_period_s) {
  constexpr int kSteps = 64;
  const double step_s = half_period_s / kSteps;
  double best_s = 0;
  bool found = false;
  // sign changes on a grid backwards from 0, each then bisected
  for (int k = 0; k < kSteps; ++k) {
    double late_s = -k * step_s;
    double early_s = late_s - step_s;
    if ((value(early_s) > 0) == (value(late_s) > 0)) continue;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle_s = 0.5 * (early_s + late_s);
      ((value(middle_s) > 0) == (value(late_s) > 0) ? late_s : early_s) = middle_s;
    }
    // of several zeros the nearest to `near_s`
    if (found && std::abs(late_s - near_s) > std::abs(best_s - near_s)) continue;
    best_s = late_s;
    found = true;
  }
  return best_s;
}

}  // namespace

std::vector<double> MotionWithFriction(const FrictionRing& ring, std::span<const double> times_s) {
  const LinearMotion motion(ring.poles);
  std::vector<double> seen(times_s.size());
  // friction shifts the middle by f against the motion: a linear motion for each half swing
  double begin_s = 0;
  State begin = BeginOf(ring);
  double shift = ring.friction * DirectionOf(begin);  // of u about its middle
  double end_s = motion.Turn({begin.u + shift, begin.v});
  bool is_over = false;
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    // half swings that end before this time
    while (!is_over && times_s[n] >= end_s) {
      const State turn = motion.After({begin.u + shift, begin.v}, end_s - begin_s);
      begin = {turn.u - shift, 0};
      begin_s = end_s;
      shift = ring.friction * DirectionOf(begin);
      // at a turn, a spring's force below the friction ends the motion
      is_over = std::abs(begin.u) <= ring.friction;
      end_s += motion.half_period_s();
    }
    if (is_over) {
      seen[n] = Seen(begin, ring.signal);
      continue;
    }
    State state = motion.After({begin.u + shift, begin.v}, times_s[n] - begin_s);
    state.u -= shift;
    seen[n] = Seen(state, ring.signal);
  }
  return seen;
}

std::vector<double> LinearLessFriction(const FrictionRing& ring, double begin_s, bool release,
                                       std::span<const double> times_s) {
  const LinearMotion motion(ring.poles);
  // continued backwards with the present half swing's friction
  const State now = BeginOf(ring);
  const double shift = ring.friction * DirectionOf(now);
  const auto at = [&](double time_s) {
    State state = motion.After({now.u + shift, now.v}, time_s);
    state.u -= shift;
    return state;
  };
  // an impact begins at u = 0, a release at v = 0
  const auto which = [&](double time_s) { return release ? at(time_s).v : at(time_s).u; };
  const double zero_s = ZeroBefore(which, begin_s, motion.half_period_s());
  State begin = at(zero_s);
  (release ? begin.v : begin.u) = 0;
  // the linear motion from the same begin, less the motion with friction
  std::vector<double> difference = MotionWithFriction(ring, times_s);
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    difference[n] = Seen(motion.After(begin, times_s[n] - zero_s), ring.signal) - difference[n];
  }
  return difference;
}

namespace {

// parameters: ln d, ln q, then the linear ones
constexpr std::size_t kPoleParameters = 2;
constexpr std::size_t kEven = kPoleParameters;
constexpr std::size_t kOdd = kEven + 1;
constexpr std::size_t kOffset = kOdd + 1;

// the linear columns behind the offset: line and hum, which do not depend on the poles
class Background {
 public:
  Background(const RingSamples& samples, const RingBackground& background)
      : first_s_(samples.times_s.front()),
        length_s_(samples.times_s.back() - first_s_),
        hum_hz_(background.hum_hz),
        drifts_(background.drifts) {}

  [[nodiscard]] std::size_t count() const { return (drifts_ ? 1U : 0U) + 2 * hum_hz_.size(); }
  void Write(double time_s, double* columns) const {
    if (drifts_) *columns++ = (time_s - first_s_) / length_s_ - 0.5;
    for (const double hum_hz : hum_hz_) {
      const double hum_rad_per_s = 2 * std::numbers::pi * hum_hz;
      *columns++ = std::cos(hum_rad_per_s * time_s);
      *columns++ = std::sin(hum_rad_per_s * time_s);
    }
  }

 private:
  double first_s_;
  double length_s_;
  std::vector<double> hum_hz_;
  bool drifts_;
};

// row n of the linear columns: even, odd, 1, background
void WriteColumns(const PolePair& poles, const Background& background, double since_s,
                  double time_s, double* columns) {
  const auto pair = sim::DampedFundamentals(poles.decay_per_s, poles.stiffness_per_s2, since_s);
  columns[0] = pair.even;
  columns[1] = pair.odd;
  columns[2] = 1;
  background.Write(time_s, columns + 3);
}

// linear parameters by least squares at the given poles
std::vector<double> StartPoint(const RingSamples& samples, const PolePair& poles,
                               const Background& background) {
  const auto linear = static_cast<Eigen::Index>(3 + background.count());
  const auto rows = static_cast<Eigen::Index>(samples.values_v.size());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> columns(rows, linear);
  for (Eigen::Index n = 0; n < rows; ++n) {
    const double time_s = samples.times_s[static_cast<std::size_t>(n)];
    WriteColumns(poles, background, time_s - samples.times_s.front(), time_s,
                 columns.row(n).data());
  }
  const Eigen::Map<const Eigen::VectorXd> values(samples.values_v.data(), rows);
  const Eigen::VectorXd fitted = columns.colPivHouseholderQr().solve(values);
  std::vector<double> point{std::log(poles.decay_per_s), std::log(poles.stiffness_per_s2)};
  point.insert(point.end(), fitted.begin(), fitted.end());
  return point;
}

// residuals model - sample (V); slopes by ln d, ln q and the linear parameters
bool EvaluateAll(const RingSamples& samples, const Background& background,
                 std::span<const double> point, std::span<double> residuals,
                 std::span<double> jacobian) {
  const double decay = std::exp(point[0]);
  const double stiffness = std::exp(point[1]);
  RingingMoments moments(decay, stiffness, 0, samples.step_s);
  std::vector<double> columns(point.size() - kPoleParameters);
  for (std::size_t n = 0; n < residuals.size(); ++n) {
    const RingingMoment moment = moments.At(samples.times_s[n] - samples.times_s.front());
    columns[0] = moment.even;
    columns[1] = moment.odd;
    columns[2] = 1;
    background.Write(samples.times_s[n], columns.data() + 3);
    residuals[n] = -samples.values_v[n];
    for (std::size_t k = 0; k < columns.size(); ++k) {
      residuals[n] += point[kPoleParameters + k] * columns[k];
    }
    if (!std::isfinite(residuals[n])) return false;
    if (jacobian.empty()) continue;
    const RingingSlopes slopes = moments.SlopesAt(moment);
    double* row = jacobian.data() + n * point.size();
    // chain rule: slope by ln d is d times that by d
    row[0] = decay * (point[kEven] * slopes.even_by_decay + point[kOdd] * slopes.odd_by_decay);
    row[1] = stiffness *
             (point[kEven] * slopes.even_by_stiffness + point[kOdd] * slopes.odd_by_stiffness);
    std::ranges::copy(columns, row + kPoleParameters);
  }
  return true;
}

RingDownSamples AsRecord(const RingSamples& samples, const RingBackground& background) {
  RingDownSamples record;
  record.times_s = samples.times_s;
  record.voltages_v = samples.values_v;
  record.step_s = samples.step_s;
  record.drifts = background.drifts;
  record.hum_hz = background.hum_hz;
  return record;
}

// the same problem condensed to 16 rows (condensed_record.h)
class CondensedFit {
 public:
  CondensedFit(const RingSamples& samples, const RingBackground& background)
      : samples_(AsRecord(samples, background)),
        length_s_(samples.times_s.back() - samples.times_s.front()),
        condenser_(samples_) {}
  CondensedFit(const CondensedFit&) = delete;
  CondensedFit& operator=(const CondensedFit&) = delete;

  [[nodiscard]] static constexpr std::size_t rows() { return kRows; }

  [[nodiscard]] bool Evaluate(std::span<const double> point, std::span<double> residuals,
                              std::span<double> jacobian) {
    const RingingRates rates{.decay_per_s = std::exp(point[0]),
                             .stiffness_per_s2 = std::exp(point[1]),
                             .electrical_rate_per_s = 0,
                             .impact_s = samples_.times_s.front()};
    // a trial outside of the condensation's range is rejected
    if (!CanBeCondensed(samples_, rates)) return false;
    const auto& condensed = condenser_.At(rates);
    for (std::size_t n = 0; n < kRows; ++n) {
      const auto [parts, value_v] = n < condensed.size() ? condensed[n] : CondensedRow{};
      const PartNumbers row = parts;
      const auto part = [&row](Part which) { return row[Index(which)]; };
      // linear columns in the parameters' order
      std::array<double, 4 + 2 * kMostHumLines> linear{part(Part::kEven), part(Part::kOdd),
                                                       part(Part::kConstant)};
      std::size_t next = 3;
      if (samples_.drifts) linear[next++] = part(Part::kDrift) / length_s_;
      for (std::size_t k = 0; k < 2 * samples_.hum_hz.size(); ++k) {
        linear[next++] = row[Index(Part::kHumCosine) + k];
      }
      residuals[n] = -value_v;
      for (std::size_t k = 0; k < next; ++k) residuals[n] += point[kPoleParameters + k] * linear[k];
      if (!std::isfinite(residuals[n])) return false;
      if (jacobian.empty()) continue;
      // E by d is t (d O - E), by q -t O/2; O by d is 2 d D - t O, by q -D, D being kByDiscriminant
      const double d = rates.decay_per_s;
      double* slopes = jacobian.data() + n * point.size();
      slopes[0] = d * (point[kEven] * (d * part(Part::kTimesOdd) - part(Part::kTimesEven)) +
                       point[kOdd] * (2 * d * part(Part::kByDiscriminant) - part(Part::kTimesOdd)));
      slopes[1] = -rates.stiffness_per_s2 * (0.5 * point[kEven] * part(Part::kTimesOdd) +
                                             point[kOdd] * part(Part::kByDiscriminant));
      std::copy_n(linear.begin(), next, slopes + kPoleParameters);
    }
    return true;
  }

 private:
  static constexpr std::size_t kRows = 8 + 2 * kMostHumLines;  // more than there are columns

  RingDownSamples samples_;
  double length_s_;
  Condenser condenser_;
};

// whether all trials near the start can be condensed
bool SwingsLong(const RingSamples& samples, const PolePair& poles) {
  constexpr std::size_t kManySamples = 1000;
  constexpr double kLongAngle = 40;  // of the oscillation in the record
  const double square = poles.stiffness_per_s2 - poles.decay_per_s * poles.decay_per_s;
  const double length_s = samples.times_s.back() - samples.times_s.front();
  return samples.values_v.size() > kManySamples && square > 0 &&
         std::sqrt(square) * length_s > kLongAngle;
}

// residuals with friction: the exact motion; slopes by d, q, even, odd, friction are differences
class FrictionFit {
 public:
  FrictionFit(const RingSamples& samples, const Background& background)
      : samples_(samples), background_(background), since_s_(samples.times_s) {
    for (double& time_s : since_s_) time_s -= samples.times_s.front();
  }

  [[nodiscard]] bool Evaluate(std::span<const double> point, std::span<double> residuals,
                              std::span<double> jacobian) const {
    const std::vector<double> ringing = Ringing(point);
    std::vector<double> columns(background_.count() + 3);
    for (std::size_t n = 0; n < residuals.size(); ++n) {
      residuals[n] = ringing[n] + point[kOffset] - samples_.values_v[n];
      background_.Write(samples_.times_s[n], columns.data());
      for (std::size_t k = 0; k < background_.count(); ++k) {
        residuals[n] += point[kOffset + 1 + k] * columns[k];
      }
      if (!std::isfinite(residuals[n])) return false;
      if (jacobian.empty()) continue;
      double* row = jacobian.data() + n * point.size();
      row[kOffset] = 1;
      std::copy_n(columns.begin(), background_.count(), row + kOffset + 1);
    }
    if (jacobian.empty()) return true;
    for (const std::size_t k : {0UZ, 1UZ, kEven, kOdd, point.size() - 1}) {
      WriteDifference(point, k, jacobian);
    }
    return true;
  }

 private:
  [[nodiscard]] std::vector<double> Ringing(std::span<const double> point) const {
    const FrictionRing ring{.poles = {std::exp(point[0]), std::exp(point[1])},
                            .even_v = point[kEven],
                            .odd_v_per_s = point[kOdd],
                            .friction = point.back(),
                            .signal = samples_.signal};
    return MotionWithFriction(ring, since_s_);
  }

  void WriteDifference(std::span<const double> point, std::size_t k,
                       std::span<double> jacobian) const {
    constexpr double kStep = 1e-6;
    const double angular = std::exp(0.5 * point[1]);
    const double amplitude = std::hypot(point[kEven], point[kOdd] / angular);
    // a step of 1e-6 in the parameter's unit: a logarithm, V, V/s, or the friction's
    double step = kStep;
    if (k >= kPoleParameters) step *= amplitude;
    if (k == kOdd) step *= angular;
    if (k + 1 == point.size()) step /= samples_.signal == RecordedSignal::kVoltage ? angular : 1;
    std::vector<double> moved(point.begin(), point.end());
    moved[k] += step;
    const auto above = Ringing(moved);
    moved[k] -= 2 * step;
    const auto below = Ringing(moved);
    for (std::size_t n = 0; n < above.size(); ++n) {
      jacobian[n * point.size() + k] = (above[n] - below[n]) / (2 * step);
    }
  }

  const RingSamples& samples_;
  const Background& background_;
  std::vector<double> since_s_;
};

// the first `count` samples
RingSamples FirstOf(const RingSamples& samples, std::size_t count) {
  RingSamples first = samples;
  first.times_s.resize(count);
  first.values_v.resize(count);
  return first;
}

// A fit with friction: the linear solution's parameters and the friction, and the squares left.
struct FrictionSolution {
  std::vector<double> point;
  double squares = 0;
  bool converged = false;
};

// Of the first `count` samples, from `point`; the background is fitted to all of them only.
FrictionSolution FitFriction(const RingSamples& samples, const RingBackground& background,
                             std::size_t count, std::vector<double> point) {
  const RingSamples first = FirstOf(samples, count);
  const Background columns(samples, background);
  const FrictionFit rubbing(first, columns);
  const LeastSquares problem{
      count, point.size(),
      [&](std::span<const double> at, std::span<double> residuals, std::span<double> jacobian) {
        return rubbing.Evaluate(at, residuals, jacobian);
      }};
  std::vector<bool> is_free(point.size(), count == samples.values_v.size());
  std::fill_n(is_free.begin(), kOffset + 1, true);
  is_free.back() = true;
  FrictionSolution solution;
  solution.converged = Minimise(problem, is_free, &point).converged;
  std::vector<double> residuals(count);
  (void)rubbing.Evaluate(point, residuals, {});
  for (const double residual : residuals) solution.squares += residual * residual;
  solution.point = std::move(point);
  return solution;
}

// From the linear solution over all samples. A displacement stays where friction ends the motion,
// which a descent takes for a lesser minimum: over a 32nd, a 16th ... and a half of the samples
// first it may end in a better one.
FrictionSolution FitFrictionFromLinear(const RingSamples& samples, const RingBackground& background,
                                       std::vector<double> linear) {
  linear.push_back(0);
  const std::size_t all = samples.values_v.size();
  FrictionSolution at_once = FitFriction(samples, background, all, linear);
  if (samples.signal == RecordedSignal::kVoltage) return at_once;
  std::vector<double> point = std::move(linear);
  for (const std::size_t parts : {32U, 16U, 8U, 4U, 2U}) {
    const std::size_t count = all / parts;
    if (count < 4 * point.size()) continue;
    point = FitFriction(samples, background, count, std::move(point)).point;
  }
  FrictionSolution in_parts = FitFriction(samples, background, all, std::move(point));
  return in_parts.converged && in_parts.squares < at_once.squares ? in_parts : at_once;
}

}  // namespace

RingSamples BlocksOf(const ImpulseRecord& record, std::size_t first, std::size_t end,
                     std::size_t block) {
  RingSamples samples;
  samples.signal = record.signal;
  samples.step_s = static_cast<double>(block) * record.step_s;
  for (std::size_t n = first; n + block <= end; n += block) {
    double sum = 0;
    for (std::size_t k = n; k < n + block; ++k) sum += record.voltage_v[k];
    // a block with a missing sample is excluded; a mean stands at the block's middle
    if (!std::isfinite(sum)) continue;
    const double middle = static_cast<double>(n) + 0.5 * static_cast<double>(block - 1);
    samples.times_s.push_back(record.start_s + middle * record.step_s);
    samples.values_v.push_back(sum / static_cast<double>(block));
  }
  return samples;
}

double RingFit::Envelope(double since_s) const {
  // E = e^(-d t) cos(w t) and O = e^(-d t) sin(w t) / w, w^2 = q - d^2
  const double square = poles.stiffness_per_s2 - poles.decay_per_s * poles.decay_per_s;
  const double quadrature = square > 0 ? odd_v_per_s / std::sqrt(square) : 0;
  return std::hypot(even_v, quadrature) * std::exp(-poles.decay_per_s * since_s);
}

double HumLine::At(double time_s) const {
  const double angle = 2 * std::numbers::pi * frequency_hz * time_s;
  return cosine_v * std::cos(angle) + sine_v * std::sin(angle);
}

double RingFit::HumAmplitude() const {
  double square = 0;
  for (const HumLine& line : hum)
    square += line.cosine_v * line.cosine_v + line.sine_v * line.sine_v;
  return std::sqrt(square);
}

double RingFit::Squares() const {
  double sum = 0;
  for (const double residual : jacobian.residuals) sum += residual * residual;
  return sum;
}

// standard deviation of one parameter at this variance of the residuals
double RingFit::Deviation(std::size_t column, double variance) const {
  const std::vector<bool> all(jacobian.columns, true);
  const std::vector<bool> none(jacobian.columns, false);
  std::vector<double> weights(jacobian.columns, 0.0);
  weights[column] = 1;
  return std::sqrt(variance * Variance(FindIdentifiability(jacobian, all, none), weights));
}

RingFit FitRing(const RingSamples& samples, const PolePair& start,
                const RingBackground& background) {
  HAPTOMETER_CHECK(samples.values_v.size() >= 16, "{} samples", samples.values_v.size());
  const Background columns(samples, background);
  std::vector<double> point = StartPoint(samples, start, columns);
  const LeastSquares whole{
      samples.values_v.size(), point.size(),
      [&](std::span<const double> at, std::span<double> residuals, std::span<double> jacobian) {
        return EvaluateAll(samples, columns, at, residuals, jacobian);
      }};
  RingFit fit;
  const std::vector<bool> all(point.size(), true);
  // a long oscillation is minimised over its condensed rows, at a cost independent of samples
  if (SwingsLong(samples, start)) {
    CondensedFit condensed(samples, background);
    const LeastSquares few{
        CondensedFit::rows(), point.size(),
        [&](std::span<const double> at, std::span<double> residuals, std::span<double> jacobian) {
          return condensed.Evaluate(at, residuals, jacobian);
        }};
    fit.converged = Minimise(few, all, &point).converged;
  } else {
    fit.converged = Minimise(whole, all, &point).converged;
  }
  // residuals and slopes of every sample, condensed or not
  fit.jacobian = Linearise(whole, point);
  if (background.has_friction) {
    FrictionSolution solution = FitFrictionFromLinear(samples, background, point);
    fit.converged = solution.converged;
    point = std::move(solution.point);
    const FrictionFit rubbing(samples, columns);
    fit.jacobian = Linearise(
        {samples.values_v.size(), point.size(),
         [&](std::span<const double> at, std::span<double> residuals, std::span<double> slopes) {
           return rubbing.Evaluate(at, residuals, slopes);
         }},
        point);
    fit.friction = point.back();
  }
  fit.poles = {std::exp(point[0]), std::exp(point[1])};
  fit.even_v = point[kEven];
  fit.odd_v_per_s = point[kOdd];
  fit.offset_v = point[kOffset];
  // background in the order of Background::Write
  std::size_t next = kOffset + 1;
  if (background.drifts) fit.drift_v = point[next++];
  for (const double hum_hz : background.hum_hz) {
    fit.hum.push_back({hum_hz, point[next], point[next + 1]});
    next += 2;
  }
  return fit;
}

}  // namespace haptometer::fit
