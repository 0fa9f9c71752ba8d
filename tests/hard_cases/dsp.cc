#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "dsp/filter/cascade.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"
#include "dsp/statistics/regression.h"
#include "tests/hard_cases/hard_case.h"

namespace haptometer::hard_cases {
namespace {

// Bars of 1e-11 are the accuracy that dsp/statistics/distributions.h states.

TEST(HardCasesDsp, MeanOfAMillionEqualValues) {
  const std::vector<double> values(1'000'000, 0.1);
  float sum = 0;
  for (const double value : values) sum += static_cast<float>(value);
  // pairwise sums of 1e6 values round some 20 times: 20 * 1.1e-16
  Check({"dsp", "mean of 1e6 equal values", "rounding adds up in one direction", "plain float sum",
         3e-15},
        {0.1L, dsp::Mean(values), static_cast<double>(sum) / 1e6});
}

TEST(HardCasesDsp, DeviationBesideALargeOffset) {
  std::vector<double> values = {1e9};
  for (int i = 0; i < 500; ++i) {
    values.push_back(1e9 - 0.125);
    values.push_back(1e9 + 0.125);
  }
  double sum = 0;
  double squares = 0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  const double n = static_cast<double>(values.size());
  // all values are exact doubles: 1000 squares of 1/8 over n - 1 = 1000
  Check({"dsp", "standard deviation of 1/8 beside 1e9", "the offset is 8e9 deviations",
         "one-pass variance E[x^2] - E[x]^2", 1e-14},
        {0.125L, dsp::StandardDeviation(values),
         std::sqrt((squares / n - (sum / n) * (sum / n)) * n / (n - 1))});
}

TEST(HardCasesDsp, FarTailOfStudentsTWithTwoDegrees) {
  const double t = 1e8;
  const long double root = std::sqrt(2.0L + 1e16L);
  Check({"dsp", "P(|T| >= 1e8), 2 degrees of freedom", "1 - P(|T| < t) cancels",
         "1 - t/sqrt(2 + t^2)", 1e-11},
        {2 / (root * (root + 1e8L)), dsp::StudentTwoSidedP(t, 2), 1 - t / std::sqrt(2 + t * t)});
}

TEST(HardCasesDsp, FarTailOfStudentsTWithOneDegree) {
  const double t = 1e12;
  const long double pi = std::numbers::pi_v<long double>;
  Check({"dsp", "P(|T| >= 1e12), 1 degree of freedom", "1 - P(|T| < t) cancels", "1 - 2 atan(t)/pi",
         1e-11},
        {2 / pi * std::atan(1e-12L), dsp::StudentTwoSidedP(t, 1),
         1 - 2 / std::numbers::pi * std::atan(t)});
}

TEST(HardCasesDsp, CriticalTOfTwoDegrees) {
  Check({"dsp", "critical t, 2 degrees of freedom", "three values are far from normal",
         "normal quantile 1.959964", 1e-11},
        {0.95L * std::sqrt(2 / (4 * 0.975L * 0.025L)), dsp::StudentCritical(2), 1.959964});
}

TEST(HardCasesDsp, FarTailOfFishersF) {
  const double lower_p = 1 - std::pow(11.0, -20.0);
  Check({"dsp", "P(F >= 200), 2 and 40 degrees of freedom", "1 - P(F < f) cancels",
         "1 - (1 - 11^-20)", 1e-11},
        {std::pow(11.0L, -20.0L), dsp::FisherUpperP(200, 2, 40), 1 - lower_p});
}

TEST(HardCasesDsp, LowestQuantileOfChiSquare) {
  const double p = 1e-12;
  Check({"dsp", "chi-square quantile of 1e-12, 2 degrees", "1 - p rounds", "-2 log(1 - p)", 1e-11},
        {-2 * std::log1p(-static_cast<long double>(p)), dsp::ChiSquareQuantile(p, 2),
         -2 * std::log(1 - p)});
}

/// |H| from the direct form's coefficients, by Horner's rule at z^-1.
double DirectForm(const dsp::FilterDesign& design, double frequency_hz) {
  const std::complex<double> back =
      std::polar(1.0, -2 * std::numbers::pi * frequency_hz / design.rate_hz);
  std::vector<double> denominator = {1};
  std::complex<double> numerator = 1;
  for (const dsp::DeltaSection& section : design.sections) {
    // the product of all denominators is one polynomial
    const double a1 = section.e + section.f - 2;
    const double a2 = 1 - section.f;
    std::vector<double> product(denominator.size() + 2, 0.0);
    for (std::size_t i = 0; i < denominator.size(); ++i) {
      product[i] += denominator[i];
      product[i + 1] += a1 * denominator[i];
      product[i + 2] += a2 * denominator[i];
    }
    denominator = product;
    const bool high = section.kind == dsp::SectionKind::kHighPass;
    const bool low = section.kind == dsp::SectionKind::kLowPass;
    numerator *= section.b * (low ? 1.0 + back : 1.0 - back) * (high ? 1.0 - back : 1.0 + back);
  }
  std::complex<double> value = 0;
  for (std::size_t i = denominator.size(); i-- > 0;) value = value * back + denominator[i];
  return std::abs(numerator / value);
}

void CheckMagnitude(const char* name, double rate_hz, double frequency_hz) {
  const dsp::BandPass band = {.corners = dsp::Corners::kEach};
  const auto design = dsp::DesignBandPass(band, rate_hz);
  ASSERT_TRUE(design.has_value());
  const auto warped = [&](double hz) {
    return std::tan(std::numbers::pi_v<long double> * static_cast<long double>(hz) /
                    static_cast<long double>(rate_hz));
  };
  const long double lower = warped(band.lower_hz);
  const long double upper = warped(band.upper_hz);
  const long double t = warped(frequency_hz);
  const long double ratio = (lower * upper - t * t) / ((upper - lower) * t);
  // the bar is what dsp/filter/butterworth.h states
  Check({"dsp", name, "the poles lie close to z = 1", "transfer function, one polynomial", 6e-15},
        {1 / std::sqrt(1 + std::pow(ratio, 2.0L * band.order)),
         dsp::Magnitude(*design, frequency_hz), DirectForm(*design, frequency_hz)});
}

TEST(HardCasesDsp, ResponseAt5KiloHertz) {
  CheckMagnitude("response of 20-500 Hz at 100 Hz, rate 5 kHz", 5e3, 100);
}

TEST(HardCasesDsp, ResponseAt100KiloHertz) {
  CheckMagnitude("response of 20-500 Hz at 100 Hz, rate 100 kHz", 1e5, 100);
}

TEST(HardCasesDsp, ResponseAt10MegaHertz) {
  CheckMagnitude("response of 20-500 Hz at 100 Hz, rate 10 MHz", 1e7, 100);
}

TEST(HardCasesDsp, ResponseFarBelowTheBand) {
  CheckMagnitude("response of 20-500 Hz at 2 Hz, rate 10 kHz", 1e4, 2);
}

// cos(2 pi f t + phase) + offset, 1 kHz
std::vector<double> Sine(double frequency_hz, double phase_rad, double offset, int samples) {
  std::vector<double> values;
  for (int k = 0; k < samples; ++k) {
    values.push_back(std::cos(2 * std::numbers::pi * frequency_hz * k / 1000 + phase_rad) + offset);
  }
  return values;
}

// sum of x e^(-j w t) over the samples
std::complex<double> Correlation(const std::vector<double>& values, double frequency_hz) {
  std::complex<double> sum = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    sum += values[k] *
           std::polar(1.0, -2 * std::numbers::pi * frequency_hz * static_cast<double>(k) / 1000);
  }
  return sum * 2.0 / static_cast<double>(values.size());
}

// bars: rounding of the arguments, 1e-13 over 1000 samples, and of the offset where there is one
TEST(HardCasesDsp, AmplitudeBetweenTwoLinesOfTheSpectrum) {
  const auto values = Sine(50.5, 0.3, 0, 1000);
  Check({"dsp", "amplitude of 50.5 Hz in 1 s", "it lies between two lines of the spectrum",
         "the largest line", 1e-13},
        {1, dsp::FitSineAt(values, {.rate_hz = 1000}, 50.5).amplitude,
         std::abs(Correlation(values, 50))});
}

TEST(HardCasesDsp, AmplitudeBesideALargeOffset) {
  const auto values = Sine(50.25, 0.3, 1e6, 990);
  Check({"dsp", "amplitude of 50.25 Hz beside an offset of 1e6", "0.99 s are no whole periods",
         "correlation with cosine and sine", 1e-9},
        {1, dsp::FitSineAt(values, {.rate_hz = 1000}, 50.25).amplitude,
         std::abs(Correlation(values, 50.25))});
}

TEST(HardCasesDsp, PhaseOfAFractionOfAPeriod) {
  const auto values = Sine(3.7, 0.3, 0, 200);
  Check({"dsp", "phase of 3.7 Hz in 0.2 s", "three quarters of a period",
         "angle of the correlation with cosine and sine", 1e-12},
        {0.3L, dsp::FitSineAt(values, {.rate_hz = 1000}, 3.7).phase_rad,
         std::arg(Correlation(values, 3.7))});
}

TEST(HardCasesDsp, SlopeBesideALargeOffset) {
  std::vector<double> x, y;
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int k = 0; k < 1000; ++k) {
    x.push_back(1e9 + k / 8.0);
    y.push_back(3 - x.back());
    sx += x.back();
    sy += y.back();
    sxx += x.back() * x.back();
    sxy += x.back() * y.back();
  }
  const auto line = dsp::FitLine(x, y);
  ASSERT_TRUE(line.has_value());
  Check({"dsp", "slope of y = 3 - x, x beside 1e9", "the spread of x is 1e-6 of it",
         "normal equations of raw sums", 1e-12},
        {-1, line->slope, (1000 * sxy - sx * sy) / (1000 * sxx - sx * sx)});
}

TEST(HardCasesDsp, CurvatureBesideASteepLine) {
  std::vector<double> x, y;
  for (int k = 0; k < 11; ++k) {
    x.push_back(1e6 + k);
    y.push_back(x.back() * x.back() - 3 * x.back() + 7);
  }
  const auto curve = dsp::FitCurvature(x, y);
  ASSERT_TRUE(curve.has_value());
  // rows 1, x, x^2
  Eigen::MatrixXd rows(11, 3);
  for (int k = 0; k < 11; ++k) {
    const double at = x[static_cast<std::size_t>(k)];
    rows.row(k) << 1, at, at * at;
  }
  const Eigen::VectorXd right = rows.transpose() * Eigen::Map<const Eigen::VectorXd>(y.data(), 11);
  const Eigen::VectorXd naive = (rows.transpose() * rows).ldlt().solve(right);
  // the bar: y holds 1e12 to 1.2e-4, of which the bend over ten steps is 25
  Check({"dsp", "curvature of x^2 - 3 x + 7 beside 1e6", "the line holds all but 1e-11 of y",
         "normal equations of the parabola", 5e-6},
        {1, curve->quadratic, naive(2)});
}

TEST(HardCasesDsp, PhasorOfAMillionSamples) {
  const double w = 0.125;
  std::vector<double> cosines(1), sines(1);
  dsp::PhasorBlocks(w).Fill(1e6, cosines, sines);
  std::complex<float> turned = 1;
  const std::complex<float> step = std::polar(1.0F, 0.125F);
  for (int k = 0; k < 1'000'000; ++k) turned *= step;
  Check({"dsp", "cos(w n) of sample 1e6", "turning from sample to sample adds up rounding",
         "recurrence from sample to sample in float", 1e-15},
        {std::cos(125'000.0L), cosines[0], static_cast<double>(turned.real())});
}

TEST(HardCasesDsp, ConstantLeavesTheFilterAsZero) {
  const auto design = dsp::DesignBandPass({}, 1e6);
  ASSERT_TRUE(design.has_value());
  dsp::Cascade cascade(*design);
  std::vector<double> values(1000, 1e6);
  cascade.StartFrom(1e6);
  cascade.Process(values, values);

  // forward difference y = a y + (x - x') at the lower corner, begun at rest
  double naive = 1e6;
  for (int i = 0; i < 1000; ++i) naive *= 1 - 2 * std::numbers::pi * 20 / 1e6;
  double largest = 0;
  for (const double value : values) largest = std::fmax(largest, std::fabs(value));
  Check({"dsp", "a constant of 1e6 through 20-500 Hz at 1 MHz", "the offset is far above the band",
         "one-pole high-pass begun at rest, after 1 ms", 0},
        {0, largest, naive});
}

}  // namespace
}  // namespace haptometer::hard_cases
