#include "fit/drop_test/suspects.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sim/ring_down.h"

namespace haptometer::fit {

double PeriodOf(const PolePair& poles) {
  return 2 * std::numbers::pi / std::sqrt(poles.stiffness_per_s2);
}

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// white noise exceeds 30 once in 1e5 records (identification.md, "The fit")
constexpr double kLeastGain = 30;         // in units of the residual's mean square
constexpr double kLeastBlowShare = 5e-3;  // of the ringing's first amplitude
constexpr double kLeastBackgroundShare = 5e-4;

// the residual, and the span of the fitted columns, which is projected out of any further column
class Remainder {
 public:
  explicit Remainder(const RingFit& fit)
      : rows_(static_cast<Eigen::Index>(fit.jacobian.rows)),
        residual_(-Eigen::Map<const Eigen::VectorXd>(fit.jacobian.residuals.data(), rows_)) {
    // orthonormal basis Q of the fitted columns; unit lengths first, because their units differ
    const Eigen::Map<const RowMajor> jacobian(fit.jacobian.values.data(), rows_,
                                              static_cast<Eigen::Index>(fit.jacobian.columns));
    taken_ = jacobian.colwise().normalized().householderQr().householderQ() *
             Eigen::MatrixXd::Identity(rows_, jacobian.cols());
    taken_residual_ = taken_.transpose() * residual_;
    square_ = residual_.squaredNorm();
  }

  // Fits further columns C to the residual. Only their last rows are given, all others are 0. The
  // share Q Q'C that the fitted columns already contain is projected out.
  [[nodiscard]] Suspect Try(const Eigen::MatrixXd& columns) const {
    const Eigen::Index rows = columns.rows();
    const Eigen::MatrixXd taken = taken_.bottomRows(rows).transpose().lazyProduct(columns);
    return FromProducts(columns.transpose().lazyProduct(columns), taken,
                        columns.transpose() * residual_.tail(rows));
  }

  // The same of the columns' products: with each other, with Q, with the residual.
  [[nodiscard]] Suspect FromProducts(const Eigen::MatrixXd& squares, const Eigen::MatrixXd& taken,
                                     const Eigen::VectorXd& products) const {
    // normal equations of the projected columns: C'(1 - Q Q')C a = C'(1 - Q Q') r
    const Eigen::VectorXd seen = products - taken.transpose() * taken_residual_;
    const Eigen::MatrixXd normal = squares - taken.transpose() * taken;
    const Eigen::VectorXd amplitudes = normal.ldlt().solve(seen);
    // decrease of the residual's square sum, then an F ratio: per column, over the mean square left
    const double gained = seen.dot(amplitudes);
    const double left = std::max(square_ - gained, 0.0);
    const auto degrees = static_cast<double>(rows_ - taken_.cols() - amplitudes.size());
    Suspect suspect;
    suspect.amplitude_v = amplitudes.norm();
    suspect.is_positive = amplitudes[0] > 0;
    suspect.gain = gained / static_cast<double>(amplitudes.size()) /
                   std::max(left / degrees, std::numeric_limits<double>::min());
    return suspect;
  }

  // orthonormal: what the fitted parameters take up; then the residual
  [[nodiscard]] const Eigen::MatrixXd& taken() const { return taken_; }
  [[nodiscard]] const Eigen::VectorXd& residual() const { return residual_; }

 private:
  Eigen::Index rows_;
  Eigen::VectorXd residual_;
  double square_ = 0;      // of the residual
  Eigen::MatrixXd taken_;  // orthonormal
  Eigen::VectorXd taken_residual_;
};

// a line from -1/2 to 1/2 over the part: its amplitude is the drift from end to end, V
Suspect TryDrift(const RingSamples& samples, const Remainder& remainder) {
  const auto rows = static_cast<Eigen::Index>(samples.times_s.size());
  Suspect suspect = remainder.Try(Eigen::VectorXd::LinSpaced(rows, -0.5, 0.5));
  suspect.kind = Suspect::Kind::kDrift;
  return suspect;
}

// cosine and sine of `hum_hz` in the record's own time
Suspect TryHum(const RingSamples& samples, const Remainder& remainder, double hum_hz) {
  const Eigen::Map<const Eigen::ArrayXd> times(samples.times_s.data(),
                                               static_cast<Eigen::Index>(samples.times_s.size()));
  Eigen::MatrixXd columns(times.size(), 2);
  columns << (2 * std::numbers::pi * hum_hz * times).cos(),
      (2 * std::numbers::pi * hum_hz * times).sin();
  Suspect suspect = remainder.Try(columns);
  suspect.kind = Suspect::Kind::kHum;
  suspect.value = hum_hz;
  return suspect;
}

// The lines of hum that may come next, of which the samples show a period and no alias: the mains'
// fundamental, then its 2nd to 5th harmonic until there are as many as a fit takes.
std::vector<double> FurtherLines(const RingSamples& samples, const RingBackground& background) {
  constexpr double kMostOfRate = 0.4;
  const auto& known_hz = background.hum_hz;
  std::vector<double> lines_hz{50, 60};
  if (!known_hz.empty()) {
    lines_hz.clear();
    for (const double multiple : {2.0, 3.0, 4.0, 5.0}) {
      lines_hz.push_back(multiple * known_hz.front());
    }
  }
  const double length_s = samples.times_s.back() - samples.times_s.front();
  std::erase_if(lines_hz, [&](double hum_hz) {
    return known_hz.size() == kMostHumLines || std::ranges::count(known_hz, hum_hz) > 0 ||
           length_s * hum_hz <= 1 || hum_hz * samples.step_s > kMostOfRate;
  });
  return lines_hz;
}

// A ringing whose frequency and decay change with its amplitude leaves, in first order, the ringing
// itself times its amplitude squared (a spring that stiffens, damping that grows) or over its
// amplitude (dry friction).
Suspect TryNonlinear(const RingSamples& samples, const PolePair& poles, const Remainder& remainder,
                     double power) {
  const auto rows = static_cast<Eigen::Index>(samples.times_s.size());
  const double angular = std::sqrt(poles.stiffness_per_s2);
  Eigen::MatrixXd columns(rows, 2);
  // shapes E and w O times e^(-power d t), the envelope to that power: 2 or -1
  for (Eigen::Index n = 0; n < rows; ++n) {
    const double since_s = samples.times_s[static_cast<std::size_t>(n)] - samples.times_s.front();
    const auto pair = sim::DampedFundamentals(poles.decay_per_s, poles.stiffness_per_s2, since_s);
    columns.row(n) << pair.even, angular * pair.odd;
    columns.row(n) *= std::exp(-power * poles.decay_per_s * since_s);
  }
  Suspect suspect = remainder.Try(columns);
  suspect.kind = Suspect::Kind::kNonlinear;
  return suspect;
}

// What dry friction adds, in first order: the derivative of the motion by it.
Suspect TryFriction(const RingSamples& samples, const RingFit& fit, const Remainder& remainder) {
  // share of the motion's first amplitude: the step of the difference quotient
  constexpr double kLittle = 1e-4;
  std::vector<double> since_s = samples.times_s;
  for (double& time_s : since_s) time_s -= samples.times_s.front();
  FrictionRing ring{.poles = fit.poles,
                    .even_v = fit.even_v,
                    .odd_v_per_s = fit.odd_v_per_s,
                    .friction = 0,
                    .signal = samples.signal};
  const auto without = MotionWithFriction(ring, since_s);
  // a voltage is proportional to the speed: over w it becomes a motion
  const double per_motion =
      samples.signal == RecordedSignal::kVoltage ? std::sqrt(fit.poles.stiffness_per_s2) : 1;
  ring.friction = kLittle * fit.Envelope(0) / per_motion;
  const auto with = MotionWithFriction(ring, since_s);
  Eigen::MatrixXd column(static_cast<Eigen::Index>(with.size()), 1);
  for (std::size_t n = 0; n < with.size(); ++n) {
    column(static_cast<Eigen::Index>(n), 0) = (with[n] - without[n]) / ring.friction;
  }
  Suspect suspect = remainder.Try(column);
  suspect.kind = Suspect::Kind::kFriction;
  return suspect;
}

// What an impact adds: a ring-down of the same poles with any jump of position and speed, half a
// block before a block's middle. For all blocks at once: with r(t) = [E(t), w O(t)],
// r(t + s) = r(t) M(s) by the addition theorems, so that the products of an impact's columns with
// anything follow from those of the next block's impact.
class BlowTrials {
 public:
  BlowTrials(const RingSamples& samples, const PolePair& poles, const Remainder& remainder)
      : samples_(samples),
        poles_(poles),
        angular_per_s_(std::sqrt(poles.stiffness_per_s2)),
        gains_(samples.times_s.size()) {
    const Eigen::Index taken_count = remainder.taken().cols();
    const auto rows = static_cast<Eigen::Index>(samples.times_s.size());
    const auto begin = RowAt(samples.step_s / 2);
    // M of the uniform step once; a gap in the samples has its own
    const Eigen::Matrix2d step = Moves(samples.step_s);
    Eigen::Matrix2d squares = begin.transpose() * begin;
    Eigen::Matrix2Xd products = Eigen::Matrix2Xd::Zero(2, taken_count + 1);
    Eigen::RowVectorXd here(taken_count + 1);
    // backwards in time: the products of an impact before sample n follow from those before n + 1
    for (Eigen::Index n = rows - 1; n >= 0; --n) {
      const auto at = static_cast<std::size_t>(n);
      if (n + 1 < rows) {
        const double gap_s = samples.times_s[at + 1] - samples.times_s[at];
        const bool is_step = std::abs(gap_s - samples.step_s) < 1e-6 * samples.step_s;
        const Eigen::Matrix2d moves = is_step ? step : Moves(gap_s);
        squares = (moves.transpose() * squares * moves + begin.transpose() * begin).eval();
        products = (moves.transpose() * products).eval();
      }
      here << remainder.taken().row(n), remainder.residual()[n];
      products.noalias() += begin.transpose() * here;
      // two columns need more rows than these
      if (rows - n < 4) continue;
      const Suspect suspect = remainder.FromProducts(
          squares, products.leftCols(taken_count).transpose(), products.col(taken_count));
      gains_[at] = {suspect.gain, suspect.amplitude_v};
    }
  }

  // the impact just before the `first`-th sample
  [[nodiscard]] Suspect At(std::size_t first) const {
    Suspect suspect;
    suspect.kind = Suspect::Kind::kBlow;
    suspect.first = first;
    suspect.value = samples_.times_s[first] - samples_.step_s / 2;
    suspect.gain = gains_[first].gain;
    suspect.amplitude_v = gains_[first].amplitude_v;
    return suspect;
  }

 private:
  struct Gain {
    double gain = 0;
    double amplitude_v = 0;
  };

  // r(t) = [E(t), w O(t)], w = sqrt(q)
  [[nodiscard]] Eigen::RowVector2d RowAt(double time_s) const {
    const auto pair = sim::DampedFundamentals(poles_.decay_per_s, poles_.stiffness_per_s2, time_s);
    return {pair.even, angular_per_s_ * pair.odd};
  }

  // M(s) by E(t + s) = E E + (d^2 - q) O O and O(t + s) = E O + O E
  [[nodiscard]] Eigen::Matrix2d Moves(double by_s) const {
    const auto pair = sim::DampedFundamentals(poles_.decay_per_s, poles_.stiffness_per_s2, by_s);
    const double discriminant = poles_.decay_per_s * poles_.decay_per_s - poles_.stiffness_per_s2;
    Eigen::Matrix2d moves;
    moves << pair.even, angular_per_s_ * pair.odd, discriminant * pair.odd / angular_per_s_,
        pair.even;
    return moves;
  }

  const RingSamples& samples_;
  PolePair poles_;
  double angular_per_s_;
  std::vector<Gain> gains_;
};

// whether a trial exceeds chance and a least amplitude; friction has a known sign
bool IsLarge(const Suspect& suspect, double ringing_v) {
  if (suspect.kind == Suspect::Kind::kFriction) {
    return suspect.is_positive && suspect.gain > kLeastFrictionGain;
  }
  const double least =
      suspect.kind == Suspect::Kind::kBlow ? kLeastBlowShare : kLeastBackgroundShare;
  return suspect.gain > kLeastGain && suspect.amplitude_v > least * ringing_v;
}

// The line of hum with the largest gain. A harmonic within the resonance's width resembles what a
// ringing leaves that changes with its own amplitude: it is none where that explains more.
Suspect BestLine(const RingSamples& samples, const RingFit& fit, const RingBackground& background,
                 const Remainder& remainder) {
  Suspect best;
  for (const double hum_hz : FurtherLines(samples, background)) {
    const Suspect line = TryHum(samples, remainder, hum_hz);
    if (IsLarge(line, fit.Envelope(0)) && line.gain > best.gain) best = line;
  }
  const bool is_harmonic = best.kind == Suspect::Kind::kHum && !background.hum_hz.empty();
  for (const double power : {2.0, -1.0}) {
    if (is_harmonic && TryNonlinear(samples, fit.poles, remainder, power).gain > best.gain) {
      return {};
    }
  }
  return best;
}

}  // namespace

Suspect WorstSuspect(const RingSamples& samples, const RingFit& fit,
                     const RingBackground& background, bool may_have_friction,
                     bool may_have_blows) {
  const Remainder remainder(fit);
  const double ringing_v = fit.Envelope(0);
  Suspect worst;
  const auto consider = [&](const Suspect& suspect) {
    if (IsLarge(suspect, ringing_v) && suspect.gain > worst.gain) worst = suspect;
  };
  if (!background.drifts) consider(TryDrift(samples, remainder));
  consider(BestLine(samples, fit, background, remainder));
  // friction before impacts: a motion that friction stops resembles an impact there
  if (may_have_friction && !background.has_friction) {
    const Suspect friction = TryFriction(samples, fit, remainder);
    if (IsLarge(friction, ringing_v) && friction.gain > worst.gain) return friction;
  }
  if (!may_have_blows) return worst;
  const BlowTrials blow(samples, fit.poles, remainder);
  // trial times half a period apart, not within the first half period or the last period
  const auto half = static_cast<std::size_t>(PeriodOf(fit.poles) / (2 * samples.step_s)) + 1;
  const std::size_t end = samples.times_s.size() - std::min(2 * half, samples.times_s.size());
  for (std::size_t first = half; first < end; first += half) consider(blow.At(first));
  if (worst.kind != Suspect::Kind::kBlow) return worst;
  // and the best time around the best of these
  const std::size_t middle = worst.first;
  for (std::size_t first = middle - half + 1; first < middle + half; ++first)
    consider(blow.At(first));
  // a ringing that changes with its own amplitude resembles an impact: the larger gain decides
  for (const double power : {2.0, -1.0}) {
    consider(TryNonlinear(samples, fit.poles, remainder, power));
  }
  return worst;
}

}  // namespace haptometer::fit
