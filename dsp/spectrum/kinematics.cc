#include "dsp/spectrum/kinematics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr int kMostTaps = 64;
// bound of the method's relative error up to the upper frequency
constexpr double kRelativeError = 1e-8;

// 4^M / binomial(2 M, M) sin(theta/2)^(2 M)
double ErrorBound(int taps, double theta) {
  double bound = 1;
  const double square = std::sin(0.5 * theta) * std::sin(0.5 * theta);
  // 2 m / (2 m - 1) over m = 1 .. M is 4^M / binomial(2 M, M)
  for (int m = 1; m <= taps; ++m) bound *= square * 2 * m / (2 * m - 1);
  return bound;
}

// c_k = (-1)^(k+1) M!^2 / (k (M - k)! (M + k)!), k = 1 .. M
std::vector<double> TapsOf(int count) {
  std::vector<double> taps(static_cast<std::size_t>(count));
  double ratio = 1;  // M!^2 / ((M - k)! (M + k)!)
  for (int k = 1; k <= count; ++k) {
    ratio *= static_cast<double>(count - k + 1) / (count + k);
    taps[static_cast<std::size_t>(k - 1)] = (k % 2 == 1 ? ratio : -ratio) / k;
  }
  return taps;
}

// the derivative at every sample that has all its neighbours: shorter by taps.size() at both ends
std::vector<double> Derivative(std::span<const double> signal, const std::vector<double>& taps,
                               double rate_hz) {
  const std::size_t reach = taps.size();
  std::vector<double> out(signal.size() - 2 * reach);
  for (std::size_t n = 0; n < out.size(); ++n) {
    double sum = 0;
    // the smallest terms first
    for (std::size_t k = reach; k > 0; --k) {
      sum += taps[k - 1] * (signal[n + reach + k] - signal[n + reach - k]);
    }
    out[n] = rate_hz * sum;
  }
  return out;
}

double Peak(std::span<const double> values) {
  const auto [least, most] = std::ranges::minmax(values);
  return std::max(-least, most);
}

}  // namespace

std::optional<Differentiator> DesignDifferentiator(double rate_hz, double upper_hz) {
  HAPTOMETER_CHECK(rate_hz > 0 && upper_hz > 0, "rate_hz = {}, upper_hz = {}", rate_hz, upper_hz);
  if (upper_hz >= 0.5 * rate_hz) return std::nullopt;
  const double theta = 2 * std::numbers::pi * upper_hz / rate_hz;
  // fewest taps first: each costs time and samples at the ends
  for (int taps = 1; taps <= kMostTaps; ++taps) {
    const double bound = ErrorBound(taps, theta);
    if (bound <= kRelativeError) return Differentiator{TapsOf(taps), bound};
  }
  return std::nullopt;
}

std::optional<Kinematics> DescribeKinematics(std::span<const double> signal, double rate_hz,
                                             double upper_hz, std::size_t begin, std::size_t end) {
  HAPTOMETER_CHECK(begin <= end && end <= signal.size(), "{} to {} of {} samples", begin, end,
                   signal.size());
  const auto differentiator = DesignDifferentiator(rate_hz, upper_hz);
  if (!differentiator) return std::nullopt;
  // differentiating twice needs 2 M samples on either side
  const std::size_t reach = 2 * differentiator->taps.size();
  if (signal.size() <= 2 * reach) return std::nullopt;
  Kinematics motion;
  motion.begin = std::max(begin, reach);
  motion.end = std::min(end, signal.size() - reach);
  motion.relative_error = differentiator->relative_error;
  if (motion.begin >= motion.end) return std::nullopt;

  // the window and what the two differentiators need beside it
  const auto around = signal.subspan(motion.begin - reach, motion.end - motion.begin + 2 * reach);
  const std::vector<double> velocity = Derivative(around, differentiator->taps, rate_hz);
  const std::vector<double> acceleration = Derivative(velocity, differentiator->taps, rate_hz);
  const auto within = std::span(velocity).subspan(reach / 2, acceleration.size());
  motion.velocity_rms = Rms(within);
  motion.velocity_peak = Peak(within);
  motion.acceleration_rms = Rms(acceleration);
  motion.acceleration_peak = Peak(acceleration);
  return motion;
}

}  // namespace haptometer::dsp
