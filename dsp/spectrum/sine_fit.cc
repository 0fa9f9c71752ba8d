#include "dsp/spectrum/sine_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "base/check.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kBlock = 256;
constexpr int kMostIterations = 30;
constexpr double kAtRestRad = 1e-10;  // last change of the phase at the signal's ends

// Calls visit(x, tau, cos(w t), sin(w t)) for every sample, t counted from the middle of the signal
// and tau = t / (T/2) from -1 to 1. Sine and cosine are exact at each block's start and turned from
// there by a table.
template <typename Visit>
void ForEachSample(std::span<const double> signal, double rad_per_sample, const Visit& visit) {
  std::array<double, kBlock> cosines{};
  std::array<double, kBlock> sines{};
  for (std::size_t k = 0; k < kBlock; ++k) {
    cosines[k] = std::cos(rad_per_sample * static_cast<double>(k));
    sines[k] = std::sin(rad_per_sample * static_cast<double>(k));
  }
  const double middle = 0.5 * static_cast<double>(signal.size() - 1);
  for (std::size_t begin = 0; begin < signal.size(); begin += kBlock) {
    const double angle = rad_per_sample * (static_cast<double>(begin) - middle);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const std::size_t size = std::min(kBlock, signal.size() - begin);
    for (std::size_t k = 0; k < size; ++k) {
      visit(signal[begin + k], (static_cast<double>(begin + k) - middle) / middle,
            c * cosines[k] - s * sines[k], s * cosines[k] + c * sines[k]);
    }
  }
}

// x = a cos(w t) + b sin(w t) + offset, t from the middle
struct Coefficients {
  double rad_per_sample = 0;
  double a = 0;
  double b = 0;
  double offset = 0;
};

// normal equations of one least-squares step, for parameters a, b, offset and w * (T/2)
struct Normal {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double square_sum = 0;  // of the residuals
};

// Linearises about `at`, blockwise so that rounding grows with the block and the blocks only.
Normal Linearise(std::span<const double> signal, const Coefficients& at) {
  Normal total;
  Normal block;
  std::size_t in_block = 0;
  const auto flush = [&] {
    total.matrix += block.matrix;
    total.right += block.right;
    total.square_sum += block.square_sum;
    block = {};
    in_block = 0;
  };
  ForEachSample(signal, at.rad_per_sample, [&](double x, double tau, double c, double s) {
    const double residual = x - (at.a * c + at.b * s + at.offset);
    const Eigen::Vector4d row(c, s, 1, tau * (at.b * c - at.a * s));
    block.matrix.noalias() += row * row.transpose();
    block.right += row * residual;
    block.square_sum += residual * residual;
    if (++in_block == kBlock) flush();
  });
  flush();
  return total;
}

// a, b and offset at a fixed frequency: one step solves it, a second removes its rounding
bool SolveLinear(std::span<const double> signal, Coefficients& c) {
  for (int step = 0; step < 2; ++step) {
    const Normal normal = Linearise(signal, c);
    const Eigen::LDLT<Eigen::Matrix3d> solver(normal.matrix.topLeftCorner<3, 3>());
    if (solver.info() != Eigen::Success) return false;
    const Eigen::Vector3d change = solver.solve(normal.right.head<3>());
    if (!change.allFinite()) return false;
    c.a += change[0];
    c.b += change[1];
    c.offset += change[2];
  }
  return true;
}

// the fit's public form, with covariances from the residual; `free` is 3 or 4 parameters
SineFit Describe(std::span<const double> signal, const SineFitOptions& options,
                 const Coefficients& c, double mean, int free) {
  const auto n = static_cast<double>(signal.size());
  const double middle = 0.5 * (n - 1);
  const Normal normal = Linearise(signal, c);

  SineFit fit;
  fit.frequency_hz = c.rad_per_sample * options.rate_hz / kTwoPi;
  fit.amplitude = std::hypot(c.a, c.b);
  // a cos + b sin = A cos(w t - atan2(b, a)); the first sample is at t = -middle
  fit.phase_rad = std::remainder(-std::atan2(c.b, c.a) - c.rad_per_sample * middle, kTwoPi);
  fit.offset = c.offset + mean;
  fit.residual_rms = std::sqrt(normal.square_sum / n);

  // covariance of (a, b, offset[, w T/2]); noise confined to a band leaves fewer free samples
  const double bandwidth_hz =
      options.noise_bandwidth_hz > 0 ? options.noise_bandwidth_hz : options.rate_hz / 2;
  const double variance = normal.square_sum / (n - free) * options.rate_hz / (2 * bandwidth_hz);
  const Eigen::MatrixXd covariance =
      normal.matrix.topLeftCorner(free, free).ldlt().solve(Eigen::MatrixXd::Identity(free, free)) *
      variance;
  const Eigen::Vector2d along(c.a / fit.amplitude, c.b / fit.amplitude);
  fit.amplitude_uncertainty = std::sqrt(along.dot(covariance.topLeftCorner<2, 2>() * along));
  // phase at the first sample: across (a, b), and the frequency's share over half the signal
  Eigen::VectorXd across = Eigen::VectorXd::Zero(free);
  across[0] = c.b / (fit.amplitude * fit.amplitude);
  across[1] = -c.a / (fit.amplitude * fit.amplitude);
  if (free == 4) {
    across[3] = -1;
    fit.frequency_uncertainty_hz = std::sqrt(covariance(3, 3)) / middle * options.rate_hz / kTwoPi;
  }
  fit.phase_uncertainty_rad = std::sqrt(across.dot(covariance * across));
  return fit;
}

SineFit NotConverged(double frequency_hz, int iterations) {
  SineFit fit;
  fit.frequency_hz = frequency_hz;
  fit.frequency_uncertainty_hz = kNotANumber;
  fit.amplitude_uncertainty = kNotANumber;
  fit.phase_uncertainty_rad = kNotANumber;
  fit.iterations = iterations;
  return fit;
}

bool Enough(std::span<const double> signal, const SineFitOptions& options, double frequency_hz,
            std::size_t least_samples) {
  const double periods = static_cast<double>(signal.size()) / options.rate_hz * frequency_hz;
  return signal.size() >= least_samples && periods >= 0.5 && frequency_hz < options.rate_hz / 2;
}

std::vector<double> WithoutMean(std::span<const double> signal, double mean) {
  std::vector<double> rest(signal.begin(), signal.end());
  for (double& x : rest) x -= mean;
  return rest;
}

}  // namespace

SineFit FitSineAt(std::span<const double> signal, const SineFitOptions& options,
                  double frequency_hz) {
  HAPTOMETER_CHECK(options.rate_hz > 0, "rate_hz = {}", options.rate_hz);
  if (!Enough(signal, options, frequency_hz, 4)) return NotConverged(frequency_hz, 0);
  const double mean = Mean(signal);
  const std::vector<double> rest = WithoutMean(signal, mean);
  Coefficients c;
  c.rad_per_sample = kTwoPi * frequency_hz / options.rate_hz;
  if (!SolveLinear(rest, c)) return NotConverged(frequency_hz, 1);
  SineFit fit = Describe(rest, options, c, mean, 3);
  fit.frequency_hz = frequency_hz;
  fit.iterations = 1;
  fit.converged = true;
  return fit;
}

SineFit FitSine(std::span<const double> signal, const SineFitOptions& options, double start_hz) {
  HAPTOMETER_CHECK(options.rate_hz > 0, "rate_hz = {}", options.rate_hz);
  if (!Enough(signal, options, start_hz, 5)) return NotConverged(start_hz, 0);
  const double mean = Mean(signal);
  const std::vector<double> rest = WithoutMean(signal, mean);
  const double half_samples = 0.5 * static_cast<double>(signal.size() - 1);
  const double start = kTwoPi * start_hz / options.rate_hz;
  Coefficients c;
  c.rad_per_sample = start;
  if (!SolveLinear(rest, c)) return NotConverged(start_hz, 1);

  // Gauss-Newton, until the phase at the ends rests
  for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
    const Normal normal = Linearise(rest, c);
    const Eigen::LDLT<Eigen::Matrix4d> solver(normal.matrix);
    const Eigen::Vector4d change = solver.solve(normal.right);
    if (solver.info() != Eigen::Success || !change.allFinite()) break;
    c.a += change[0];
    c.b += change[1];
    c.offset += change[2];
    c.rad_per_sample += change[3] / half_samples;
    // 2/T in rad per sample, twice half_samples being T
    if (!(std::abs(c.rad_per_sample - start) <= kTwoPi / half_samples)) break;
    if (std::abs(change[3]) <= kAtRestRad && SolveLinear(rest, c)) {
      SineFit fit = Describe(rest, options, c, mean, 4);
      fit.iterations = iteration;
      fit.converged = true;
      return fit;
    }
  }
  return NotConverged(start_hz, kMostIterations);
}

}  // namespace haptometer::dsp
