#include "dsp/analysis/quantisation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace haptometer::dsp {
namespace {

constexpr double kMultiple = 0.01;  // of a step, that a change may lie off a multiple of it
constexpr int kMostTerms = 200;
constexpr int kMostHarmonics = 20;
constexpr double kNegligible = 1e-6;

}  // namespace

double StepOf(std::span<const double> samples) {
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const double change = std::abs(samples[k] - samples[k - 1]);
    if (change > 0) step = std::min(step, change);
  }
  if (!std::isfinite(step)) return 0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const double steps = std::abs(samples[k] - samples[k - 1]) / step;
    if (std::abs(steps - std::round(steps)) > kMultiple * std::max(1.0, steps)) return 0;
  }
  return step;
}

double QuantisationBound(double step, double amplitude, double noise_rms, int harmonics) {
  if (!(step > 0) || !(amplitude > 0)) return 0;
  const double noise = noise_rms / step;
  double first = 0;
  double square = 0;
  for (int n = 1; n <= std::clamp(harmonics, 1, kMostHarmonics); ++n) {
    double error = 0;
    for (int k = 1; k <= kMostTerms; ++k) {
      const double left = std::exp(-2 * std::pow(std::numbers::pi * k * noise, 2)) / k;
      if (left < kNegligible) break;
      const double argument = 2 * std::numbers::pi * k * amplitude / step;
      error += left * std::abs(std::cyl_bessel_j(static_cast<double>(n), argument));
    }
    // |J_n(x)| <= sqrt(2 / (pi x)) beyond the terms: a sum of k^-1.5, ended by noise
    const double tail = std::exp(-2 * std::pow(std::numbers::pi * kMostTerms * noise, 2));
    error += tail * 2 / (std::numbers::pi * std::sqrt(kMostTerms * amplitude / step));
    error *= 2 * step / std::numbers::pi;
    if (n == 1) first = error;
    if (n > 1) square += 0.5 * error * error;
  }
  const double rms = amplitude / std::numbers::sqrt2;
  return first / std::numbers::sqrt2 + std::min(std::sqrt(square), square / (2 * rms));
}

}  // namespace haptometer::dsp
