#include "fit/drop_test/converter_rounding.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptometer::fit {
namespace {

constexpr double kMostNoise = 0.5;  // steps, beyond which no rounding error is left
constexpr std::size_t kCases = 16;

// 0 ... 15 with its four bits in reverse order
std::size_t Reversed(std::size_t n) {
  return (n & 1) << 3 | (n & 2) << 1 | (n & 4) >> 1 | (n & 8) >> 3;
}

// the middle of the `n`th of so many equal parts of -1/2 to 1/2
double Place(std::size_t n) {
  return (static_cast<double>(n) + 0.5) / static_cast<double>(kCases) - 0.5;
}

}  // namespace

double MeanRoundingError(double x, double noise) {
  const double below = std::floor(x);
  // E(code) = below - 3 + P(code >= below - 2) + ... + P(code >= below + 3): 5 deviations of noise
  double code = below - 3;
  for (int m = -2; m <= 3; ++m) {
    const double above = x - below - m + 0.5;
    code += noise > 0 ? 0.5 * std::erfc(-above / (noise * std::numbers::sqrt2))
                      : (above >= 0 ? 1.0 : 0.0);
  }
  return code - x;
}

std::vector<std::vector<double>> RoundingChanges(const RingDownProblem& problem,
                                                 const RingDownPoint& point,
                                                 const Identifiability& seen, std::size_t record,
                                                 double step_v, double residual_v) {
  if (step_v == 0) return {};
  // the residuals' variance is the noise's and the rounding's, 1/12 of a step squared
  const double noise = std::sqrt(std::max(std::pow(residual_v / step_v, 2) - 1.0 / 12, 0.0));
  if (noise >= kMostNoise) return {};
  const RingDownSamples& samples = problem.records()[record];
  auto motion_v = problem.Voltages(point, record, samples.times_s);
  const double offset_v = point.own[record][Index(Own::kOffset)];
  double peak_v = 0;
  for (double& v : motion_v) {
    v -= offset_v;
    peak_v = std::max(peak_v, std::abs(v));
  }
  std::vector<double> errors(motion_v.size());
  std::vector<std::vector<double>> changes;
  for (std::size_t k = 0; k < kCases; ++k) {
    // offset by part of a step, peak within a step either way
    const double offset = offset_v / step_v + Place(k);
    const double scale = (peak_v / step_v + 2 * Place(Reversed(k))) / peak_v;
    for (std::size_t n = 0; n < motion_v.size(); ++n) {
      const double weight = samples.root_weights.empty() ? 1 : samples.root_weights[n];
      const double error_v = step_v * MeanRoundingError(offset + scale * motion_v[n], noise);
      errors[n] = error_v * weight / (samples.noise_v * std::sqrt(double{kCases}));
    }
    changes.push_back(Response(seen, problem.ProductsOf(point, record, errors)));
  }
  return changes;
}

}  // namespace haptometer::fit
