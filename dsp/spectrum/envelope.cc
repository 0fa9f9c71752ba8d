#include "dsp/spectrum/envelope.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "base/error.h"
#include "dsp/spectrum/fft.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr std::size_t kStepsAWindow = 32;
constexpr Eigen::Index kLeastWindow = 8;

// Rows that give the tone's two parts from the samples of a window about its middle.
using Kernel = Eigen::Matrix<double, 2, Eigen::Dynamic>;

// (X' W X)^-1 X' W, the rows of cosine and sine; X: cosine, sine, 1, tau, tau^2
Kernel FitKernel(Eigen::Index size, double rad_per_sample) {
  const double half = 0.5 * static_cast<double>(size - 1);
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(size, -half, half);
  const Eigen::ArrayXd tau = t / half;
  Eigen::MatrixXd columns(size, 5);
  columns << (rad_per_sample * t).cos(), (rad_per_sample * t).sin(), Eigen::ArrayXd::Ones(size),
      tau, tau.square();
  // Hann, not yet zero at the outermost samples
  const Eigen::ArrayXd weights = 0.5 + 0.5 * (kTwoPi * t / static_cast<double>(size + 1)).cos();
  const Eigen::MatrixXd weighted = weights.matrix().asDiagonal() * columns;
  return (columns.transpose() * weighted).ldlt().solve(weighted.transpose()).topRows<2>();
}

// steps from where the envelope of a tone that begins in the middle is 10 % to where it is 90 %
double OwnRise(const Kernel& kernel, double rad_per_sample) {
  const double half = 0.5 * static_cast<double>(kernel.cols() - 1);
  // the tone's own part of what each sample adds, the mean over the tone's phases
  double sum = 0;
  double tenth = 0;
  for (Eigen::Index k = 0; k < kernel.cols(); ++k) {
    const double phase = rad_per_sample * (static_cast<double>(k) - half);
    const double weight = 0.5 * (kernel(0, k) * std::cos(phase) + kernel(1, k) * std::sin(phase));
    if (sum < 0.1 && sum + weight >= 0.1) tenth = static_cast<double>(k) + (0.1 - sum) / weight;
    sum += weight;
  }
  // the kernel is symmetric, so 90 % lies as far from the other end
  return static_cast<double>(kernel.cols()) - 2 * tenth;
}

double AmplitudeAt(std::span<const double> window, const Kernel& kernel) {
  const Eigen::Map<const Eigen::VectorXd> samples(window.data(), kernel.cols());
  // about the first sample: the parabola takes an offset out, but not its rounding
  const Eigen::VectorXd rest = samples.array() - window.front();
  return (kernel * rest).norm();
}

}  // namespace

Envelope DemodulateTone(std::span<const double> signal, const Demodulation& how) {
  HAPTOMETER_CHECK(how.rate_hz > 0 && how.tone_hz > 0 && how.periods >= 1,
                   "rate_hz = {}, tone_hz = {}, periods = {}", how.rate_hz, how.tone_hz,
                   how.periods);
  const double samples = std::round(how.periods * how.rate_hz / how.tone_hz);
  const auto most = static_cast<double>(signal.size());
  if (how.tone_hz >= 0.5 * how.rate_hz || samples > most || samples < kLeastWindow) return {};
  const auto size = static_cast<std::size_t>(samples);
  const double rad_per_sample = kTwoPi * how.tone_hz / how.rate_hz;
  const Kernel kernel = FitKernel(static_cast<Eigen::Index>(size), rad_per_sample);

  Envelope envelope;
  const std::size_t step = std::max<std::size_t>(1, size / kStepsAWindow);
  envelope.start_s = 0.5 * (samples - 1) / how.rate_hz;
  envelope.step_s = static_cast<double>(step) / how.rate_hz;
  envelope.support_s = samples / how.rate_hz;
  envelope.own_rise_s = OwnRise(kernel, rad_per_sample) / how.rate_hz;
  envelope.amplitude.reserve((signal.size() - size) / step + 1);
  for (std::size_t begin = 0; begin + size <= signal.size(); begin += step) {
    envelope.amplitude.push_back(AmplitudeAt(signal.subspan(begin, size), kernel));
  }
  return envelope;
}

std::vector<std::complex<double>> AnalyticSignal(std::span<const double> signal) {
  RealFft fft(signal.size());
  std::vector<std::complex<double>> bins(fft.bins());
  fft.Forward(signal, bins);
  // a quarter of a turn back; a constant and half the rate have no such partner
  for (std::complex<double>& bin : bins) bin = {bin.imag(), -bin.real()};
  bins.front() = 0;
  if (signal.size() % 2 == 0) bins.back() = 0;
  std::vector<double> turned(signal.size());
  fft.Inverse(bins, turned);
  std::vector<std::complex<double>> analytic(signal.size());
  for (std::size_t k = 0; k < signal.size(); ++k) analytic[k] = {signal[k], turned[k]};
  return analytic;
}

}  // namespace haptometer::dsp
