#include "dsp/spectrum/envelope.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "base/error.h"
#include "dsp/spectrum/fft.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
// steps of the moving window in its length
constexpr std::size_t kStepsAWindow = 32;
// samples: five coefficients are fitted to them
constexpr Eigen::Index kLeastWindow = 8;

// The two rows that give the tone's cosine and sine part from a window, time from its middle.
using Kernel = Eigen::Matrix<double, 2, Eigen::Dynamic>;

// (X' W X)^-1 X' W, the rows of cosine and sine; X: cosine, sine, 1, tau, tau^2
// weighted least squares: weights W, model a cos(w t) + b sin(w t) + c + d tau + e tau^2
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
  // rise of the envelope per sample of the tone, averaged over the tone's phase
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

// sqrt(a^2 + b^2) of one window
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
  // a whole number of samples next to the stated length
  const double samples = std::round(how.periods * how.rate_hz / how.tone_hz);
  const auto most = static_cast<double>(signal.size());
  if (how.tone_hz >= 0.5 * how.rate_hz || samples > most || samples < kLeastWindow) return {};
  const auto size = static_cast<std::size_t>(samples);
  const double rad_per_sample = kTwoPi * how.tone_hz / how.rate_hz;
  const Kernel kernel = FitKernel(static_cast<Eigen::Index>(size), rad_per_sample);

  Envelope envelope;
  const std::size_t step = std::max<std::size_t>(1, size / kStepsAWindow);
  // times are those of the windows' middles
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
  // the Hilbert transform: -j X; a constant and half the rate have no part in quadrature
  for (std::complex<double>& bin : bins) bin = {bin.imag(), -bin.real()};
  bins.front() = 0;
  if (signal.size() % 2 == 0) bins.back() = 0;
  std::vector<double> turned(signal.size());
  fft.Inverse(bins, turned);
  std::vector<std::complex<double>> analytic(signal.size());
  for (std::size_t k = 0; k < signal.size(); ++k) analytic[k] = {signal[k], turned[k]};
  return analytic;
}

namespace {

constexpr double kSqrt2 = std::numbers::sqrt2;
constexpr double kLow = 0.1;
// reach of a slope to either side of a crossing, as a part of the window
constexpr double kSlopeReach = 0.125;
constexpr double kTopSlopeReach = 0.5;
constexpr double kHalf = 0.5;
constexpr double kHigh = 0.9;
constexpr double kNoisesBelowLow = 3;
constexpr double kLeastResolvedRise = 2.0 / 3;  // of the window's own
// largest deviations of closed forms, as parts of the window's own rise; rectangular distribution:
// standard deviation = half width / sqrt(3)
constexpr double kTimeBias = 0.18 / std::numbers::sqrt3;
constexpr double kRiseBias = 0.12 / std::numbers::sqrt3;

// the envelope's values between two times; empty where they reach beyond the envelope
std::span<const double> Between(const Envelope& envelope, double begin_s, double end_s) {
  const double first = std::ceil((begin_s - envelope.start_s) / envelope.step_s);
  const double last = std::floor((end_s - envelope.start_s) / envelope.step_s);
  const auto size = static_cast<double>(envelope.amplitude.size());
  if (!(first >= 0 && last >= first && last < size)) return {};
  return std::span(envelope.amplitude)
      .subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(last - first) + 1);
}

// The root of the envelope's power above that of the quiet part, over the steady amplitude.
class Levels {
 public:
  Levels(std::span<const double> amplitude, double quiet, double steady)
      : amplitude_(amplitude), quiet_square_(quiet * quiet), steady_(steady) {}

  [[nodiscard]] std::size_t size() const { return amplitude_.size(); }
  [[nodiscard]] double operator[](std::size_t k) const {
    const double square = amplitude_[k] * amplitude_[k] - quiet_square_;
    return std::sqrt(std::max(0.0, square)) / steady_;
  }
  // where between k and k + 1 the straight line passes `level`
  [[nodiscard]] double Crossing(std::size_t k, double level) const {
    const double below = (*this)[k];
    return static_cast<double>(k) + (level - below) / ((*this)[k + 1] - below);
  }

 private:
  std::span<const double> amplitude_;
  double quiet_square_;
  double steady_;
};

// first k >= begin with levels[k] < level <= levels[k + 1]
std::optional<double> FirstRise(const Levels& levels, std::size_t begin, double level) {
  for (std::size_t k = begin; k + 1 < levels.size(); ++k) {
    if (levels[k] < level && levels[k + 1] >= level) return levels.Crossing(k, level);
  }
  return std::nullopt;
}

// the last such k <= end
std::optional<double> LastRise(const Levels& levels, std::size_t end, double level) {
  for (std::size_t k = end + 1; k-- > 0;) {
    if (k + 1 < levels.size() && levels[k] < level && levels[k + 1] >= level) {
      return levels.Crossing(k, level);
    }
  }
  return std::nullopt;
}

// indices at which the low, half and high level are passed, with fractions
struct Crossings {
  double low = 0;
  double half = 0;
  double high = 0;
};

// from the half level the last crossing of the low level before it and the first of the high after
std::optional<Crossings> FindCrossings(const Levels& levels, std::size_t begin, double low_level) {
  const auto half = FirstRise(levels, begin, kHalf);
  if (!half) return std::nullopt;
  const auto at_half = static_cast<std::size_t>(*half);
  const auto low = LastRise(levels, at_half, low_level);
  const auto high = FirstRise(levels, at_half, kHigh);
  if (!low || !high) return std::nullopt;
  return Crossings{*low, *half, *high};
}

// change of the level per step about `at`, over `reach` steps on either side
double SlopeAt(const Levels& levels, double at, double reach) {
  const auto last = static_cast<double>(levels.size() - 1);
  const auto before = static_cast<std::size_t>(std::max(0.0, std::floor(at - reach)));
  const auto after = static_cast<std::size_t>(std::min(last, std::ceil(at + reach)));
  return (levels[after] - levels[before]) / static_cast<double>(after - before);
}

// an interval within a rise of `measured_s`, less the window's own: sqrt(1 - (own / measured)^2)
double WithoutOwnRise(double interval_s, double measured_s, double own_rise_s) {
  if (!(measured_s > own_rise_s)) return 0;
  const double own = own_rise_s / measured_s;
  return interval_s * std::sqrt(1 - own * own);
}

// standard uncertainty of a crossing in s: noise / slope, the slope over a part of the window on
// either side; the window's length where there is no slope
double NoiseOfCrossing(const Levels& levels, double at, double noise, double part,
                       const Envelope& envelope) {
  const double slope =
      SlopeAt(levels, at, std::max(1.0, part * envelope.support_s / envelope.step_s));
  return slope > 0 ? noise / slope * envelope.step_s : envelope.support_s;
}

// rise_s, or its upper bound; the rise from low to high is measured^2 - own^2 in squares
void DescribeRise(double measured_s, double noise_s, double own_rise_s, Edge& edge) {
  const double square = measured_s * measured_s - own_rise_s * own_rise_s;
  const double rise_s = std::sqrt(std::max(0.0, square));
  // with a raised low level the time from 10 % to 90 % is not measured
  if (edge.low_level > kLow) return;
  // below two thirds of the window's own rise only a bound is possible
  if (rise_s < kLeastResolvedRise * own_rise_s) {
    edge.rise_at_most_s = kLeastResolvedRise * own_rise_s + 2 * noise_s;
    return;
  }
  edge.rise_s = rise_s;
  edge.rise_uncertainty_s = std::hypot(noise_s * measured_s / rise_s, kRiseBias * own_rise_s);
}

}  // namespace

std::optional<Edge> FindOnset(const Envelope& envelope, const EdgeSearch& search) {
  HAPTOMETER_CHECK(envelope.amplitude.empty() || envelope.step_s > 0, "step_s = {}",
                   envelope.step_s);
  if (envelope.amplitude.empty()) return std::nullopt;
  const auto quiet = Between(envelope, search.quiet_begin_s, search.quiet_end_s);
  const auto steady = Between(envelope, search.steady_begin_s, search.steady_end_s);
  if (quiet.empty() || steady.empty()) return std::nullopt;

  Edge edge;
  // the noise's power is subtracted from that of the steady part
  edge.quiet_amplitude = Rms(quiet);
  const double power = Rms(steady) * Rms(steady) - edge.quiet_amplitude * edge.quiet_amplitude;
  if (!(power > 0)) return std::nullopt;
  edge.steady_amplitude = std::sqrt(power);
  // the level of the onset: 10 %, or three times the noise
  edge.low_level = std::max(kLow, kNoisesBelowLow * edge.quiet_amplitude / edge.steady_amplitude);
  if (!(edge.low_level < kHalf)) return std::nullopt;

  const Levels levels(envelope.amplitude, edge.quiet_amplitude, edge.steady_amplitude);
  const auto begin = static_cast<std::size_t>(quiet.data() - envelope.amplitude.data());
  const auto found = FindCrossings(levels, begin, edge.low_level);
  if (!found) return std::nullopt;

  // noise along the tone is one of the two parts of the quiet amplitude: 1 / sqrt(2) of it
  const double noise = edge.quiet_amplitude / edge.steady_amplitude / kSqrt2;
  const double noise_s = NoiseOfCrossing(levels, found->low, noise, kSlopeReach, envelope);
  // most rises are flatter at the top, where noise shows in the slope
  const double noise_of_two_s =
      std::hypot(noise_s, NoiseOfCrossing(levels, found->high, noise, kTopSlopeReach, envelope));
  const double measured_s = (found->high - found->low) * envelope.step_s;
  const double half_s = envelope.start_s + found->half * envelope.step_s;
  const double low_s = (found->half - found->low) * envelope.step_s;  // before the half level
  edge.time_s = half_s - WithoutOwnRise(low_s, measured_s, envelope.own_rise_s);
  // the correction itself depends on the rise: its uncertainty from a longer and a shorter one
  const double early_s =
      WithoutOwnRise(low_s + noise_s, measured_s + noise_of_two_s, envelope.own_rise_s);
  const double late_s =
      WithoutOwnRise(low_s - noise_s, measured_s - noise_of_two_s, envelope.own_rise_s);
  edge.time_uncertainty_s =
      std::hypot(noise_s, 0.5 * (early_s - late_s), kTimeBias * envelope.own_rise_s);
  DescribeRise(measured_s, noise_of_two_s, envelope.own_rise_s, edge);
  return edge;
}

}  // namespace haptometer::dsp
