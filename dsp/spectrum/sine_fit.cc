#include "dsp/spectrum/sine_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "base/error.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {

PhasorBlocks::PhasorBlocks(double rad_per_sample) : rad_per_sample_(rad_per_sample) {
  // the table of turns: cos(k w) and sin(k w) within one block
  for (std::size_t k = 0; k < kBlock; ++k) {
    cosines_[k] = std::cos(rad_per_sample * static_cast<double>(k));
    sines_[k] = std::sin(rad_per_sample * static_cast<double>(k));
  }
}

void PhasorBlocks::Fill(double first, std::span<double> cosines, std::span<double> sines) const {
  HAPTOMETER_CHECK(cosines.size() == sines.size() && sines.size() <= kBlock, "{} and {} values",
                   cosines.size(), sines.size());
  // cos(a + b) and sin(a + b) from the block's begin and the table
  const double c = std::cos(rad_per_sample_ * first);
  const double s = std::sin(rad_per_sample_ * first);
  for (std::size_t k = 0; k < cosines.size(); ++k) {
    cosines[k] = c * cosines_[k] - s * sines_[k];
    sines[k] = s * cosines_[k] + c * sines_[k];
  }
}

void SubtractSine(double rad_per_sample, double cosine, double sine, double first,
                  std::span<double> samples) {
  const PhasorBlocks phasors(rad_per_sample);
  std::array<double, PhasorBlocks::kBlock> cosines;
  std::array<double, PhasorBlocks::kBlock> sines;
  for (std::size_t begin = 0; begin < samples.size(); begin += PhasorBlocks::kBlock) {
    const std::size_t count = std::min(PhasorBlocks::kBlock, samples.size() - begin);
    phasors.Fill(first + static_cast<double>(begin), std::span(cosines).first(count),
                 std::span(sines).first(count));
    for (std::size_t k = 0; k < count; ++k) {
      samples[begin + k] -= cosine * cosines[k] + sine * sines[k];
    }
  }
}

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kBlock = PhasorBlocks::kBlock;
// a, b, w half and the drift's 1 + degree coefficients
constexpr int kMostColumns = 4 + kHighestDriftDegree;
// limits of Newton's steps and of halvings of one step; beyond them the fit is not converged
constexpr int kMostIterations = 30;
constexpr int kMostHalvings = 12;
constexpr double kAtRestRad = 1e-10;   // last change of the phase at the signal's ends
constexpr double kAtRestShare = 1e-3;  // the same, of its uncertainty
// reciprocal condition below which columns cannot be separated
constexpr double kLeastCondition = 1e-10;

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostColumns, kMostColumns>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostColumns, 1>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kBlock, kMostColumns>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kBlock, 1>;

// Samples and their times, counted from the middle in units of one sample (or, with non-uniform
// times, in seconds); tau runs from -1 to 1 over them.
struct Signal {
  std::vector<double> values;  // without their mean
  std::vector<double> times;   // empty: evenly spaced, one unit apart
  double mean = 0;
  double half = 0;          // from the middle to an end
  double to_reference = 0;  // from the middle to where the phase is stated
  double units_per_s = 0;
};

// x = a cos(w t) + b sin(w t) + sum of drift_k P_k(tau): w per unit, then a, b, drift in one vector
struct Coefficients {
  double rad_per_unit = 0;
  Vector linear;
};

// the columns of one block of rows; the last, for w * half, where the frequency is free
struct Block {
  std::size_t begin = 0;
  std::size_t size = 0;
  Columns columns;
  Rows tau;
};

// Legendre's P_0 .. P_3 in columns 2 to 5: 1, tau, (3 tau^2 - 1) / 2, (5 tau^3 - 3 tau) / 2
void FillDrift(int degree, Block& block) {
  const auto& tau = block.tau.array();
  block.columns.col(2).setOnes();
  if (degree >= 1) block.columns.col(3) = block.tau;
  if (degree >= 2) block.columns.col(4) = 1.5 * tau.square() - 0.5;
  if (degree >= 3) block.columns.col(5) = (2.5 * tau.square() - 1.5) * tau;
}

// cosine and sine at non-uniform times
void FillAtTimes(const Signal& signal, double rad_per_unit, Block& block) {
  for (std::size_t k = 0; k < block.size; ++k) {
    const double t = signal.times[block.begin + k];
    const auto row = static_cast<Eigen::Index>(k);
    block.tau[row] = t / signal.half;
    block.columns(row, 0) = std::cos(rad_per_unit * t);
    block.columns(row, 1) = std::sin(rad_per_unit * t);
  }
}

// cosine and sine at uniform times
void FillEvenly(const Signal& signal, const PhasorBlocks& phasors, Block& block) {
  // time of the block's first sample, from the signal's middle
  const double first = static_cast<double>(block.begin) - signal.half;
  phasors.Fill(first, {block.columns.col(0).data(), block.size},
               {block.columns.col(1).data(), block.size});
  for (std::size_t k = 0; k < block.size; ++k) {
    block.tau[static_cast<Eigen::Index>(k)] = (first + static_cast<double>(k)) / signal.half;
  }
}

// normal equations of one least-squares step about some coefficients
struct Normal {
  Matrix matrix;
  Vector right;
  Vector bend;            // how the residual bends the last row: Newton's matrix is matrix + bend
  double square_sum = 0;  // of the residuals
};

// adds - residual times the model's second derivatives by w half and a, b, w half
void AddBend(const Block& block, const Coefficients& at, const Rows& residual, Vector& bend) {
  const Rows turned = residual.cwiseProduct(block.tau);
  const auto cosines = block.columns.col(0);
  const auto sines = block.columns.col(1);
  bend[0] += turned.dot(sines);
  bend[1] -= turned.dot(cosines);
  bend[bend.size() - 1] +=
      turned.cwiseProduct(block.tau).dot(at.linear[0] * cosines + at.linear[1] * sines);
}

// adds a block's rows: product by product of columns, which for so few is several times as fast as
// Eigen's products of matrices
void AddRows(const Block& block, const Rows& residual, Normal& total) {
  for (Eigen::Index k = 0; k < total.right.size(); ++k) {
    const auto column = block.columns.col(k);
    for (Eigen::Index other = 0; other <= k; ++other) {
      total.matrix(k, other) += column.dot(block.columns.col(other));
    }
    total.right[k] += column.dot(residual);
  }
  total.square_sum += residual.squaredNorm();
}

// Linearises about `at`, blockwise so that rounding grows with the block and the blocks only. With
// `free_frequency` the last parameter is w * half.
Normal Linearise(const Signal& signal, const Coefficients& at, bool free_frequency) {
  const Eigen::Index linear = at.linear.size();
  const Eigen::Index all = linear + (free_frequency ? 1 : 0);
  const PhasorBlocks phasors(at.rad_per_unit);
  Normal total{Matrix::Zero(all, all), Vector::Zero(all), Vector::Zero(all), 0};
  Block block;
  for (block.begin = 0; block.begin < signal.values.size(); block.begin += kBlock) {
    block.size = std::min(kBlock, signal.values.size() - block.begin);
    const auto rows = static_cast<Eigen::Index>(block.size);
    block.columns.resize(rows, all);
    block.tau.resize(rows);
    if (signal.times.empty()) {
      FillEvenly(signal, phasors, block);
    } else {
      FillAtTimes(signal, at.rad_per_unit, block);
    }
    FillDrift(static_cast<int>(linear) - 3, block);
    // d/d(w half) of a cos(w t) + b sin(w t) is tau (b cos(w t) - a sin(w t)), tau = t / half
    if (free_frequency) {
      block.columns.col(linear) = block.tau.cwiseProduct(at.linear[1] * block.columns.col(0) -
                                                         at.linear[0] * block.columns.col(1));
    }
    const Eigen::Map<const Eigen::VectorXd> values(signal.values.data() + block.begin, rows);
    // residual of the model at `at`: the step that is solved for is a correction to it
    Rows residual = values;
    for (Eigen::Index k = 0; k < linear; ++k) residual -= at.linear[k] * block.columns.col(k);
    AddRows(block, residual, total);
    if (free_frequency) AddBend(block, at, residual, total.bend);
  }
  // only the lower triangle was summed
  total.matrix.triangularView<Eigen::StrictlyUpper>() = total.matrix.transpose();
  return total;
}

// solution of `matrix` d = `right`, nothing where the columns, scaled to one length, are dependent
std::optional<Vector> Step(const Matrix& matrix, const Vector& right) {
  // scaling makes the condition independent of the units of amplitude and frequency
  const Vector scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const Matrix scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  const Eigen::LDLT<Matrix> solver(scaled);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  if (!(solver.rcond() > kLeastCondition)) return std::nullopt;
  Vector change = scale.cwiseProduct(solver.solve(scale.cwiseProduct(right)));
  if (!change.allFinite()) return std::nullopt;
  return change;
}

// Newton's step where it leads downhill, else Gauss and Newton's, which always does
std::optional<Vector> NewtonStep(const Normal& normal) {
  const Eigen::Index last = normal.right.size() - 1;
  Matrix matrix = normal.matrix;
  // second derivatives exist only in the row and column of w half
  matrix.row(last) += normal.bend.transpose();
  matrix.col(last).head(last) += normal.bend.head(last);
  const auto newton = Step(matrix, normal.right);
  return newton ? newton : Step(normal.matrix, normal.right);
}

// one step to the linear coefficients at a fixed frequency
bool StepLinear(const Signal& signal, Coefficients& c) {
  const Normal normal = Linearise(signal, c, false);
  const auto change = Step(normal.matrix, normal.right);
  if (!change) return false;
  c.linear += *change;
  return true;
}

// independent values: noise confined to a bandwidth B leaves 2 B / rate of them
double IndependentSamples(const Signal& signal, const SineFitOptions& options) {
  const auto n = static_cast<double>(signal.values.size());
  return options.noise_bandwidth_hz > 0 ? n * 2 * options.noise_bandwidth_hz / options.rate_hz : n;
}

// the fit's public form, with covariances from the residual
SineFit Describe(const Signal& signal, const SineFitOptions& options, const Coefficients& c,
                 bool free_frequency) {
  const auto n = static_cast<double>(signal.values.size());
  const Normal normal = Linearise(signal, c, free_frequency);
  const Eigen::Index all = normal.right.size();
  const double a = c.linear[0];
  const double b = c.linear[1];

  SineFit fit;
  fit.frequency_hz = c.rad_per_unit * signal.units_per_s / kTwoPi;
  fit.amplitude = std::hypot(a, b);
  // a cos + b sin = A cos(w t - atan2(b, a))
  fit.phase_rad =
      std::remainder(std::fma(c.rad_per_unit, signal.to_reference, -std::atan2(b, a)), kTwoPi);
  fit.offset = c.linear[2] + signal.mean;
  fit.residual_rms = std::sqrt(normal.square_sum / n);

  // covariance of (a, b, drift[, w half]) from the residual variance
  const double independent = IndependentSamples(signal, options);
  fit.degrees_of_freedom = independent - static_cast<double>(all);
  const double variance = normal.square_sum / fit.degrees_of_freedom;
  const Matrix covariance = normal.matrix.ldlt().solve(Matrix::Identity(all, all)) * variance;
  // u(amplitude): the covariance along the unit vector (a, b) / amplitude
  const Eigen::Vector2d along = fit.amplitude > 0
                                    ? Eigen::Vector2d(a / fit.amplitude, b / fit.amplitude)
                                    : Eigen::Vector2d::UnitX();
  fit.amplitude_uncertainty = std::sqrt(along.dot(covariance.topLeftCorner<2, 2>() * along));
  // phase -atan2(b, a) + w to_reference: derivatives b / A^2, -a / A^2 and to_reference / half
  Vector across = Vector::Zero(all);
  across[0] = b / (fit.amplitude * fit.amplitude);
  across[1] = -a / (fit.amplitude * fit.amplitude);
  if (free_frequency) {
    across[all - 1] = signal.to_reference / signal.half;
    const double half_s = signal.half / signal.units_per_s;
    fit.frequency_uncertainty_hz = std::sqrt(covariance(all - 1, all - 1)) / half_s / kTwoPi;
  }
  fit.phase_uncertainty_rad = std::sqrt(across.dot(covariance * across));
  fit.converged = true;
  return fit;
}

// the state of a fit without a result: the start's frequency, uncertainties NaN
SineFit NotConverged(double frequency_hz) {
  SineFit fit;
  fit.frequency_hz = frequency_hz;
  fit.frequency_uncertainty_hz = kNotANumber;
  fit.amplitude_uncertainty = kNotANumber;
  fit.phase_uncertainty_rad = kNotANumber;
  return fit;
}

// time in samples from the middle; the phase is stated at the first sample
Signal EvenSignal(std::span<const double> values, const SineFitOptions& options) {
  Signal signal;
  signal.mean = Mean(values);
  signal.values.assign(values.begin(), values.end());
  for (double& x : signal.values) x -= signal.mean;
  signal.half = 0.5 * static_cast<double>(values.size() - 1);
  signal.to_reference = -signal.half;
  signal.units_per_s = options.rate_hz;
  return signal;
}

// time in seconds from the middle of all times; the phase is stated at t = 0
Signal TimedSignal(std::span<const double> values, std::span<const double> times_s) {
  Signal signal = EvenSignal(values, {.rate_hz = 1});
  const auto [first, last] = std::ranges::minmax(times_s);
  const double middle = first + 0.5 * (last - first);
  signal.times.assign(times_s.begin(), times_s.end());
  for (double& t : signal.times) t -= middle;
  signal.half = 0.5 * (last - first);
  signal.to_reference = -middle;
  return signal;
}

void CheckOptions(const SineFitOptions& options) {
  HAPTOMETER_CHECK(options.rate_hz > 0 && options.drift_degree >= 0 &&
                       options.drift_degree <= kHighestDriftDegree,
                   "rate_hz = {}, drift_degree = {}", options.rate_hz, options.drift_degree);
}

// whether that many samples and periods determine `parameters`: half a period at least
bool Enough(const SineFitOptions& options, std::size_t samples, double frequency_hz,
            int parameters) {
  if (samples < 2 || !(frequency_hz > 0 && frequency_hz < options.rate_hz / 2)) return false;
  const auto n = static_cast<double>(samples);
  const double share =
      options.noise_bandwidth_hz > 0 ? 2 * options.noise_bandwidth_hz / options.rate_hz : 1;
  return n / options.rate_hz * frequency_hz >= 0.5 && n * share > parameters;
}

Coefficients StartAt(double rad_per_unit, int drift_degree) {
  return {rad_per_unit, Vector::Zero(3 + drift_degree)};
}

SineFit FitLinear(const Signal& signal, const SineFitOptions& options, double frequency_hz) {
  Coefficients c = StartAt(kTwoPi * frequency_hz / signal.units_per_s, options.drift_degree);
  // the second step removes the first one's rounding
  for (int step = 0; step < 2; ++step) {
    if (!StepLinear(signal, c)) return NotConverged(frequency_hz);
  }
  SineFit fit = Describe(signal, options, c, false);
  fit.frequency_hz = frequency_hz;
  return fit;
}

// coefficients after `share` of the step `change`; its last entry is w half
Coefficients Moved(const Coefficients& c, const Vector& change, double share, double half) {
  const Eigen::Index linear = c.linear.size();
  return {c.rad_per_unit + share * change[linear] / half, c.linear + share * change.head(linear)};
}

// One step, halved until the residual does not grow; its normal equations go to `normal`. Gives the
// change of w half in rad. Nothing: no step reduces the residual, or none is defined.
std::optional<double> Improve(const Signal& signal, Coefficients& c, Normal& normal) {
  const auto change = NewtonStep(normal);
  if (!change) return std::nullopt;
  double share = 1;
  for (int halving = 0; halving < kMostHalvings; ++halving, share /= 2) {
    const Coefficients moved = Moved(c, *change, share, signal.half);
    Normal next = Linearise(signal, moved, true);
    // 1e-9 of the square sum is rounding; the last halving counts in any case
    if (!(next.square_sum <= normal.square_sum * (1 + 1e-9)) && halving + 1 < kMostHalvings) {
      continue;
    }
    c = moved;
    normal = next;
    return share * (*change)[change->size() - 1];
  }
  return std::nullopt;
}

// whether a change of w half (the phase at the ends, rad) is negligible beside its uncertainty
bool AtRest(const Normal& normal, double change, double degrees_of_freedom) {
  const Eigen::Index last = normal.right.size() - 1;
  // the diagonal element of A^-1 for w half
  const Vector unit = Vector::Unit(last + 1, last);
  const double variance = normal.matrix.ldlt().solve(unit)[last] * normal.square_sum;
  const double uncertainty = std::sqrt(std::max(0.0, variance / degrees_of_freedom));
  return std::abs(change) <= std::max(kAtRestRad, kAtRestShare * uncertainty);
}

}  // namespace

SineFit FitSineAt(std::span<const double> signal, const SineFitOptions& options,
                  double frequency_hz) {
  CheckOptions(options);
  if (!Enough(options, signal.size(), frequency_hz, 3 + options.drift_degree)) {
    return NotConverged(frequency_hz);
  }
  return FitLinear(EvenSignal(signal, options), options, frequency_hz);
}

SineFit FitSineAtTimes(std::span<const double> values, std::span<const double> times_s,
                       double frequency_hz, int drift_degree) {
  // with a rate of 1 Hz, seconds take the place of samples
  const SineFitOptions options{.rate_hz = 1, .drift_degree = drift_degree};
  CheckOptions(options);
  HAPTOMETER_CHECK(values.size() == times_s.size(), "{} values, {} times", values.size(),
                   times_s.size());
  if (values.size() < 4 + static_cast<std::size_t>(drift_degree)) return NotConverged(frequency_hz);
  const Signal signal = TimedSignal(values, times_s);
  // less than half a period does not determine amplitude and offset separately
  if (!(2 * signal.half * frequency_hz >= 0.5)) return NotConverged(frequency_hz);
  return FitLinear(signal, options, frequency_hz);
}

SineFit FitSine(std::span<const double> signal, const SineFitOptions& options, double start_hz) {
  CheckOptions(options);
  const int parameters = 4 + options.drift_degree;
  if (!Enough(options, signal.size(), start_hz, parameters)) return NotConverged(start_hz);
  const Signal even = EvenSignal(signal, options);
  const double start = kTwoPi * start_hz / options.rate_hz;
  Coefficients c = StartAt(start, options.drift_degree);
  // start values of the linear coefficients at the start frequency
  if (!StepLinear(even, c)) return NotConverged(start_hz);

  // until the frequency converges; every pass through the loop is one step of Newton's method
  const double freedom = IndependentSamples(even, options) - parameters;
  Normal normal = Linearise(even, c, true);
  for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
    const auto change = Improve(even, c, normal);
    // |w - start| <= 2 pi / half in rad per sample, that is 2 / T in Hz with T = 2 half samples
    if (!change || !(std::abs(c.rad_per_unit - start) <= kTwoPi / even.half)) break;
    if (AtRest(normal, *change, freedom) && StepLinear(even, c)) {
      return Describe(even, options, c, true);
    }
  }
  return NotConverged(start_hz);
}

}  // namespace haptometer::dsp
