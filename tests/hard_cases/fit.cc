#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "fit/calibration/straight_line.h"
#include "fit/poles.h"
#include "tests/hard_cases/hard_case.h"

namespace haptometer::hard_cases {
namespace {

// sums of squares and products about the means
struct Moments {
  long double xx = 0, yy = 0, xy = 0;
};

Moments MomentsOf(const std::vector<fit::LinePoint>& points) {
  long double mean_x = 0, mean_y = 0;
  const auto n = static_cast<long double>(points.size());
  for (const fit::LinePoint& p : points) {
    mean_x += static_cast<long double>(p.x) / n;
    mean_y += static_cast<long double>(p.y) / n;
  }
  Moments m;
  for (const fit::LinePoint& p : points) {
    const long double x = static_cast<long double>(p.x) - mean_x;
    const long double y = static_cast<long double>(p.y) - mean_y;
    m.xx += x * x;
    m.yy += y * y;
    m.xy += x * y;
  }
  return m;
}

// a line of slope 2 whose points lie beside it to either side, at `offset`
std::vector<fit::LinePoint> Scattered(double u_x, double u_y, double offset) {
  constexpr std::array kAside{0.5, -0.75, 0.25, 0.75, -0.5, -0.25};
  std::vector<fit::LinePoint> points;
  double x = 0;
  for (const double aside : kAside) {
    points.push_back({offset + x + aside, 2 * x - aside, u_x, u_y});
    x += 1;
  }
  return points;
}

double OrdinarySlope(const std::vector<fit::LinePoint>& points) {
  const Moments m = MomentsOf(points);
  return static_cast<double>(m.xy / m.xx);
}

TEST(HardCasesFit, LineWithEqualUncertaintyOfBothCoordinates) {
  const auto points = Scattered(0.1, 0.1, 0);
  const Moments m = MomentsOf(points);
  const long double d = m.yy - m.xx;
  const auto line = fit::FitStraightLine(points, fit::Scatter::kFromResiduals);
  ASSERT_TRUE(line.has_value());
  // Deming's closed form; the bar is that of an iteration that ends at 1e-15 of the slope's change
  Check(
      {"fit", "line, x as uncertain as y", "errors of x reduce the slope", "ordinary least squares",
       1e-12},
      {(d + std::sqrt(d * d + 4 * m.xy * m.xy)) / (2 * m.xy), line->slope, OrdinarySlope(points)});
}

TEST(HardCasesFit, LineWithExactY) {
  const auto points = Scattered(0.1, 0, 0);
  const Moments m = MomentsOf(points);
  const auto line = fit::FitStraightLine(points, fit::Scatter::kFromResiduals);
  ASSERT_TRUE(line.has_value());
  Check(
      {"fit", "line, y exact", "all of the scatter is that of x", "ordinary least squares", 1e-12},
      {m.yy / m.xy, line->slope, OrdinarySlope(points)});
}

TEST(HardCasesFit, LineBesideALargeOffset) {
  const auto points = Scattered(0, 0.1, 1e9);
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const fit::LinePoint& p : points) {
    x += p.x;
    y += p.y;
    xx += p.x * p.x;
    xy += p.x * p.y;
  }
  const double n = static_cast<double>(points.size());
  const Moments m = MomentsOf(points);
  const auto line = fit::FitStraightLine(points, fit::Scatter::kFromResiduals);
  ASSERT_TRUE(line.has_value());
  Check({"fit", "line, x beside 1e9", "the spread of x is 1e-9 of it",
         "normal equations of raw sums", 1e-12},
        {m.xy / m.xx, line->slope, (n * xy - x * y) / (n * xx - x * x)});
}

// e^(-decay t) cos(w t) at `rate_hz`
std::vector<double> RingDown(double decay_per_s, double frequency_hz, double rate_hz,
                             std::size_t samples) {
  std::vector<double> values;
  for (std::size_t k = 0; k < samples; ++k) {
    const double t_s = static_cast<double>(k) / rate_hz;
    values.push_back(std::exp(-decay_per_s * t_s) *
                     std::cos(2 * std::numbers::pi * frequency_hz * t_s));
  }
  return values;
}

// decay from the largest samples of each period
double DecayFromPeaks(const std::vector<double>& values, double rate_hz) {
  double first = 0, last = 0, first_s = 0, last_s = 0;
  for (std::size_t k = 1; k + 1 < values.size(); ++k) {
    if (!(values[k] > values[k - 1] && values[k] >= values[k + 1] && values[k] > 0)) continue;
    if (first == 0) {
      first = values[k];
      first_s = static_cast<double>(k) / rate_hz;
    }
    last = values[k];
    last_s = static_cast<double>(k) / rate_hz;
  }
  return std::log(first / last) / (last_s - first_s);
}

void CheckDecay(const char* name, double decay_per_s, double frequency_hz, double rate_hz,
                std::size_t samples, double bar) {
  const auto values = RingDown(decay_per_s, frequency_hz, rate_hz, samples);
  const auto poles = fit::EstimatePoles(values, 1 / rate_hz);
  ASSERT_TRUE(poles.has_value());
  Check(
      {"fit", name, "no sample lies on a peak", "logarithmic decrement of sampled peaks", bar},
      {static_cast<long double>(decay_per_s), poles->decay_per_s, DecayFromPeaks(values, rate_hz)});
}

// bars: without noise a pencil of a rank-two matrix leaves rounding times its condition
TEST(HardCasesFit, DecayOfFewSamplesAPeriod) {
  CheckDecay("decay of 225 Hz at 1 kHz", 11.5, 225.3, 1e3, 200, 1e-9);
}

TEST(HardCasesFit, DecayOfAStronglyDampedMode) {
  CheckDecay("decay of Q 3", 220, 210.7, 1e4, 400, 1e-6);
}

TEST(HardCasesFit, FrequencyByZeroCrossings) {
  constexpr double kDecay = 220, kFrequency = 210.7, kRate = 1e4;
  const auto values = RingDown(kDecay, kFrequency, kRate, 400);
  const auto poles = fit::EstimatePoles(values, 1 / kRate);
  ASSERT_TRUE(poles.has_value());
  const long double w = 2 * std::numbers::pi_v<long double> * 210.7L;
  // first two falling crossings, to a sample
  std::vector<double> crossings_s;
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (values[k - 1] > 0 && values[k] <= 0) crossings_s.push_back(static_cast<double>(k) / kRate);
  }
  const double naive = 2 * std::numbers::pi / (crossings_s[1] - crossings_s[0]);
  Check({"fit", "natural frequency squared of Q 3", "the period is that of the damped motion",
         "2 pi over the time between two zero crossings, squared", 1e-6},
        {w * w + 220.0L * 220.0L, poles->stiffness_per_s2, naive * naive});
}

}  // namespace
}  // namespace haptometer::hard_cases
