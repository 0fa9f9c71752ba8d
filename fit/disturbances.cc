#include "fit/disturbances.h"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/clipping.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kSamplesPerPeriod = 16;
constexpr double kLeastPeriods = 3;
constexpr std::size_t kLeastBlocks = 32;
constexpr double kLeastGain = 30;         // in units of the residual's mean square
constexpr double kLeastBlowShare = 5e-3;  // of the ringing's first amplitude
constexpr double kLeastBackgroundShare = 5e-4;
constexpr int kMostRounds = 8;

// A disturbance that the residual was tried for.
struct Suspect {
  enum class Kind : std::uint8_t { kNone, kDrift, kHum, kBlow, kNonlinear };
  Kind kind = Kind::kNone;
  double value = 0;  // frequency in Hz, or time in s
  double amplitude_v = 0;
  std::size_t first = 0;  // of a blow: the sample behind it
  double gain = 0;        // power taken away, in mean squares of what is left, per column
};

double PeriodOf(const PolePair& poles) {
  return 2 * std::numbers::pi / std::sqrt(poles.stiffness_per_s2);
}

// the residual and what the fitted parameters can take up of any further column
class Remainder {
 public:
  explicit Remainder(const RingFit& fit)
      : rows_(static_cast<Eigen::Index>(fit.jacobian.rows)),
        residual_(-Eigen::Map<const Eigen::VectorXd>(fit.jacobian.residuals.data(), rows_)) {
    const Eigen::Map<const RowMajor> jacobian(fit.jacobian.values.data(), rows_,
                                              static_cast<Eigen::Index>(fit.jacobian.columns));
    taken_ = jacobian.colwise().normalized().householderQr().householderQ() *
             Eigen::MatrixXd::Identity(rows_, jacobian.cols());
    taken_residual_ = taken_.transpose() * residual_;
    square_ = residual_.squaredNorm();
  }

  // Amplitudes of further columns, of which the last rows are given and all others are 0, and the
  // power that they take away per column. What the fit has taken of the columns is subtracted from
  // their products.
  [[nodiscard]] Suspect Try(const Eigen::MatrixXd& columns) const {
    const Eigen::Index rows = columns.rows();
    const Eigen::MatrixXd taken = taken_.bottomRows(rows).transpose().lazyProduct(columns);
    const Eigen::VectorXd seen =
        columns.transpose() * residual_.tail(rows) - taken.transpose() * taken_residual_;
    const Eigen::MatrixXd normal =
        columns.transpose().lazyProduct(columns) - taken.transpose() * taken;
    const Eigen::VectorXd amplitudes = normal.ldlt().solve(seen);
    const double gained = seen.dot(amplitudes);
    const double left = std::max(square_ - gained, 0.0);
    const auto degrees = static_cast<double>(rows_ - taken_.cols() - columns.cols());
    Suspect suspect;
    suspect.amplitude_v = amplitudes.norm();
    suspect.gain = gained / static_cast<double>(columns.cols()) /
                   std::max(left / degrees, std::numeric_limits<double>::min());
    return suspect;
  }

 private:
  Eigen::Index rows_;
  Eigen::VectorXd residual_;
  double square_ = 0;      // of the residual
  Eigen::MatrixXd taken_;  // orthonormal
  Eigen::VectorXd taken_residual_;
};

Suspect TryDrift(const RingSamples& samples, const Remainder& remainder) {
  const auto rows = static_cast<Eigen::Index>(samples.times_s.size());
  Suspect suspect = remainder.Try(Eigen::VectorXd::LinSpaced(rows, -0.5, 0.5));
  suspect.kind = Suspect::Kind::kDrift;
  return suspect;
}

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

// A ringing whose frequency and decay change with its amplitude leaves, in first order, the ringing
// itself times its amplitude squared (a spring that stiffens, damping that grows) or over its
// amplitude (dry friction).
Suspect TryNonlinear(const RingSamples& samples, const PolePair& poles, const Remainder& remainder,
                     double power) {
  const auto rows = static_cast<Eigen::Index>(samples.times_s.size());
  const double angular = std::sqrt(poles.stiffness_per_s2);
  Eigen::MatrixXd columns(rows, 2);
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

// What a blow adds: a ring-down of the same poles with any jump of position and speed. Blows are
// tried half a block before a block's middle, so that one table of the motion serves them all.
class BlowTrial {
 public:
  BlowTrial(const RingSamples& samples, const PolePair& poles)
      : times_(samples.times_s), step_s_(samples.step_s) {
    const double angular = std::sqrt(poles.stiffness_per_s2);
    const std::size_t last = Block(times_.size() - 1);
    motion_.resize(static_cast<Eigen::Index>(last) + 1, 2);
    for (Eigen::Index k = 0; k < motion_.rows(); ++k) {
      const auto pair = sim::DampedFundamentals(poles.decay_per_s, poles.stiffness_per_s2,
                                                (static_cast<double>(k) + 0.5) * step_s_);
      motion_.row(k) << pair.even, angular * pair.odd;
    }
  }

  // the blow just before the `first`-th sample
  [[nodiscard]] Suspect At(std::size_t first, const Remainder& remainder) const {
    Eigen::MatrixXd columns(static_cast<Eigen::Index>(times_.size() - first), 2);
    const std::size_t from = Block(first);
    for (Eigen::Index n = 0; n < columns.rows(); ++n) {
      const std::size_t block = Block(first + static_cast<std::size_t>(n));
      columns.row(n) = motion_.row(static_cast<Eigen::Index>(block - from));
    }
    Suspect suspect = remainder.Try(columns);
    suspect.kind = Suspect::Kind::kBlow;
    suspect.first = first;
    suspect.value = times_[first] - step_s_ / 2;
    return suspect;
  }

 private:
  // holes leave blocks out
  [[nodiscard]] std::size_t Block(std::size_t n) const {
    return static_cast<std::size_t>(std::lround((times_[n] - times_.front()) / step_s_));
  }

  const std::vector<double>& times_;
  double step_s_;
  Eigen::MatrixX2d motion_;
};

bool IsLarge(const Suspect& suspect, double ringing_v) {
  const double least =
      suspect.kind == Suspect::Kind::kBlow ? kLeastBlowShare : kLeastBackgroundShare;
  return suspect.gain > kLeastGain && suspect.amplitude_v > least * ringing_v;
}

// the most telling disturbance that is not yet part of the fit
Suspect Worst(const RingSamples& samples, const RingFit& fit, const RingBackground& background) {
  const Remainder remainder(fit);
  const double ringing_v = fit.Envelope(0);
  Suspect worst;
  const auto consider = [&](const Suspect& suspect) {
    if (IsLarge(suspect, ringing_v) && suspect.gain > worst.gain) worst = suspect;
  };
  if (!background.drifts) consider(TryDrift(samples, remainder));
  for (const double hum_hz : {50.0, 60.0}) {
    const double length_s = samples.times_s.back() - samples.times_s.front();
    const bool is_seen = length_s * hum_hz > 1 && background.hum_hz == 0;
    if (is_seen) consider(TryHum(samples, remainder, hum_hz));
  }
  const BlowTrial blow(samples, fit.poles);
  const auto half = static_cast<std::size_t>(PeriodOf(fit.poles) / (2 * samples.step_s)) + 1;
  const std::size_t end = samples.times_s.size() - std::min(2 * half, samples.times_s.size());
  for (std::size_t first = half; first < end; first += half) consider(blow.At(first, remainder));
  if (worst.kind != Suspect::Kind::kBlow) return worst;
  // and the best time around the best of these
  const std::size_t middle = worst.first;
  for (std::size_t first = middle - half + 1; first < middle + half; ++first)
    consider(blow.At(first, remainder));
  for (const double power : {2.0, -1.0}) {
    consider(TryNonlinear(samples, fit.poles, remainder, power));
  }
  return worst;
}

// sd of the decay rate per unit of noise for a ring-down of amplitude A over a length T, up to a
// factor: facts of the Cramer-Rao bound, I0 / (A^2 (I0 I2 - I1^2)), I_k = integral of t^k e^(-2 s
// t)
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

std::size_t SampleAt(const ImpulseRecord& record, double time_s) {
  const double position = (time_s - record.start_s) / record.step_s;
  return static_cast<std::size_t>(
      std::clamp(std::ceil(position), 0.0, static_cast<double>(record.voltage_v.size())));
}

// cuts the part at the blow and keeps the better side
void CutAt(const ImpulseRecord& record, const RingFit& fit, const Suspect& blow,
           Disturbances* part) {
  const double period_s = PeriodOf(fit.poles);
  const double first_s = record.start_s + static_cast<double>(part->first_sample) * record.step_s;
  const double end_s = record.start_s + static_cast<double>(part->end_sample) * record.step_s;
  const double before_s = blow.value - period_s / 16 - first_s;
  const double after_s = end_s - (blow.value + period_s / 4);
  const double at_blow_v = fit.Envelope(blow.value - first_s);
  const double before = DecayBound(fit.Envelope(0), fit.poles.decay_per_s, before_s);
  const double after =
      DecayBound(std::max(at_blow_v, blow.amplitude_v), fit.poles.decay_per_s, after_s);
  const bool height_holds = record.drop_height_m && !part->follows_a_later_blow;
  const bool keeps_first =
      before_s >= kLeastPeriods * period_s && (height_holds || before <= after);
  part->found.push_back(fmt::format(
      "a blow at {:.4g} s, {:.2g} {} beside a ringing of {:.2g} {}: the part {} it is fitted",
      blow.value, blow.amplitude_v, record.unit, at_blow_v, record.unit,
      keeps_first ? "before" : "behind"));
  if (keeps_first) {
    part->end_sample = SampleAt(record, blow.value - period_s / 16);
  } else {
    part->first_sample = SampleAt(record, blow.value + period_s / 4);
    part->follows_a_later_blow = true;
  }
}

// what lies below the converter's step says nothing but the offset's code
void CutQuantisedTail(const ImpulseRecord& record, const RingFit& fit, double noise_v,
                      Disturbances* part) {
  const double step_v = ConverterStep(record.voltage_v);
  if (step_v == 0 || noise_v > 0.25 * step_v || !(fit.Envelope(0) > step_v)) return;
  const double since_s = std::log(fit.Envelope(0) / step_v) / fit.poles.decay_per_s;
  const std::size_t end = part->first_sample + static_cast<std::size_t>(since_s / record.step_s);
  const double periods =
      static_cast<double>(end - part->first_sample) * record.step_s / PeriodOf(fit.poles);
  if (end >= part->end_sample || periods < kLeastPeriods) return;
  part->end_sample = end;
  part->found.push_back(
      fmt::format("a tail below one step of the converter, {:.3g} {}: left out from {:.4g} s on",
                  step_v, record.unit, record.start_s + static_cast<double>(end) * record.step_s));
}

}  // namespace

Disturbances FindDisturbances(const ImpulseRecord& record, const RingStart& start) {
  Disturbances part;
  part.first_sample = start.first_sample;
  part.end_sample = record.voltage_v.size();
  PolePair poles = start.poles;
  for (int round = 0; round < kMostRounds; ++round) {
    const double wanted = PeriodOf(poles) / (kSamplesPerPeriod * record.step_s);
    const std::size_t length = part.end_sample - part.first_sample;
    const std::size_t block = std::clamp<std::size_t>(static_cast<std::size_t>(wanted), 1,
                                                      std::max<std::size_t>(length / 256, 1));
    const auto samples = BlocksOf(record, part.first_sample, part.end_sample, block);
    if (samples.values_v.size() < kLeastBlocks) break;
    const RingFit fit = FitRing(samples, poles, part.background);
    if (!fit.converged) break;
    poles = fit.poles;
    const Suspect worst = Worst(samples, fit, part.background);
    if (worst.kind == Suspect::Kind::kBlow) {
      CutAt(record, fit, worst, &part);
    } else if (worst.kind == Suspect::Kind::kHum) {
      part.background.hum_hz = worst.value;
      part.found.push_back(fmt::format("hum of {:g} Hz, {:.2g} {}: fitted along", worst.value,
                                       worst.amplitude_v, record.unit));
    } else if (worst.kind == Suspect::Kind::kDrift) {
      part.background.drifts = true;
      part.found.push_back(fmt::format("a drift of {:.2g} {} over the record: fitted along",
                                       worst.amplitude_v, record.unit));
    } else {
      // what changes with the amplitude is for consistency.h to judge
      CutQuantisedTail(record, fit,
                       start.quiet_samples > 0 ? start.quiet_noise_v : start.residual_rms_v, &part);
      break;
    }
  }
  return part;
}

}  // namespace haptometer::fit
