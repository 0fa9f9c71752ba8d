#include "fit/drop_test/first_look.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <random>
#include <vector>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Filled, BridgesHolesByLinesAndContinuesTheEnds) {
  EXPECT_EQ(Filled({kNan, kNan, 1, kNan, kNan, 7, 2, kNan, 4, kNan}),
            (std::vector<double>{1, 1, 1, 3, 5, 7, 2, 3, 4, 4}));
  EXPECT_EQ(Filled({1, 2, 3}), (std::vector<double>{1, 2, 3}));
}

TEST(FollowingAmplitude, IsHalfAPeriodsSamplesTimesTheAmplitude) {
  // 3 V about 0.7 V with 20 samples a period, silent up to the 100th
  std::vector<double> values(400, 0.7);
  for (std::size_t n = 100; n < values.size(); ++n) {
    values[n] += 3 * std::sin(2 * M_PI * static_cast<double>(n) / 20 + 0.3);
  }
  const auto amplitudes = FollowingAmplitude(values, 0.7, 20);
  ASSERT_EQ(amplitudes.size(), 381U) << "a sum over 20 samples from each of the first ones";
  for (const std::size_t n : {0U, 40U, 80U}) EXPECT_ABS(amplitudes[n], 0.0, 1e-12, "silence");
  for (const std::size_t n : {100U, 237U, 380U}) {
    EXPECT_ABS(amplitudes[n], 3 * 10.0, 1e-11, "the sum of 20 squares of a sine");
  }
  EXPECT_GT(amplitudes[90], 10) << "half of the period";
}

TEST(FollowingAmplitude, IsTheSumOverAPeriodsSamplesOfAnyLength) {
  // 20 samples of a period of 19.3
  std::vector<double> values;
  for (int n = 0; n < 200; ++n) values.push_back(2 + std::sin(0.1 * n * n));
  const auto amplitudes = FollowingAmplitude(values, 0.7, 19.3);
  ASSERT_EQ(amplitudes.size(), 181U);
  for (std::size_t n = 0; n < amplitudes.size(); n += 20) {
    std::complex<double> sum = 0;
    for (std::size_t k = n; k < n + 20; ++k) {
      sum += (values[k] - 0.7) * std::polar(1.0, -2 * M_PI * static_cast<double>(k) / 19.3);
    }
    EXPECT_REL(amplitudes[n], std::abs(sum), 1e-12, "rounding");
  }
}

TEST(NoiseOfSamples, IsTheMedianOfThirdDifferences) {
  // 1.4826/sqrt(20) of 1, of 6 (n^3), of the middle one of 1, 8 - 3 = 5 and 4 - 24 + 3 = -17
  const double share = 1.482602218505602 / std::sqrt(20.0);
  EXPECT_REL(NoiseOfSamples({0, 0, 0, 1}), share, 1e-12, "rounding");
  EXPECT_REL(NoiseOfSamples({0, 1, 8, 27, 64, 125}), 6 * share, 1e-12, "rounding");
  EXPECT_REL(NoiseOfSamples({0, 0, 0, 1, 8, 4}), 5 * share, 1e-12, "rounding");
}

std::vector<double> Noise(std::size_t count, double deviation) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> noise(0, deviation);
  std::vector<double> values(count);
  for (double& value : values) value = noise(engine);
  return values;
}

TEST(NoiseOfSamples, IsThatOfWhiteNoiseUnderSlowOscillations) {
  std::vector<double> values = Noise(4000, 0.1);
  for (std::size_t n = 0; n < values.size(); ++n) {
    values[n] += 7 + 2 * std::sin(2 * M_PI * static_cast<double>(n) / 40);
  }
  // the median's own uncertainty of correlated differences is some 2 %; the oscillation leaves
  // 2 (2 sin(pi/40))^3/sqrt(20)/sqrt(2) = 1.2 mV
  EXPECT_REL(NoiseOfSamples(values), 0.1, 0.06, "3 sigma");
  EXPECT_EQ(NoiseOfSamples({3, 3, 3, 3, 3}), 0);
}

constexpr double kStep_s = 1e-3;
constexpr std::size_t kCount = 1000;

// f(time) at samples a millisecond apart, for a second
template <typename Function>
std::vector<double> Sampled(const Function& function) {
  std::vector<double> values(kCount);
  for (std::size_t n = 0; n < kCount; ++n) values[n] = function(static_cast<double>(n) * kStep_s);
  return values;
}

// a ringing of 1 at 180 Hz from 0.1 s on, with d = 12/s
double Ringing(double t) {
  return t < 0.1 ? 0 : std::exp(-12 * (t - 0.1)) * std::sin(2 * M_PI * 180 * (t - 0.1));
}

TEST(WithoutWhatLasts, LeavesTheRingingOfASlowCourseAndHum) {
  const auto lasting = [](double t) {
    return 3 - 8 * t + 5 * t * t + 0.5 * std::sin(2 * M_PI * 50 * t + 0.4) +
           0.8 * std::cos(2 * M_PI * 60 * t);
  };
  const auto rest =
      WithoutWhatLasts(Sampled([&](double t) { return Ringing(t) + lasting(t); }), kStep_s);
  ASSERT_TRUE(rest);
  ASSERT_EQ(rest->size(), kCount);
  const double mean = 3 - 8 * 0.4995 + 5 * 0.33283;  // of the course's thousand samples
  for (std::size_t n = 0; n < kCount; n += 7) {
    // the ringing's share in 9 functions: some 2/(dw T) = 2/(2 pi 120) of each of two, less of
    // others
    EXPECT_ABS((*rest)[n], mean + Ringing(static_cast<double>(n) * kStep_s), 0.015,
               "2/(dw T) of two sines, and of the polynomials at the ends");
  }
}

TEST(WithoutWhatLasts, OfACourseOfFourthOrderAndHumTheMeanStays) {
  const auto values = Sampled([](double t) {
    return 3 - 8 * t + 5 * std::pow(t, 4) + std::sin(2 * M_PI * 50 * t + 0.4) +
           0.8 * std::cos(2 * M_PI * 60 * t);
  });
  const auto rest = WithoutWhatLasts(values, kStep_s);
  ASSERT_TRUE(rest);
  double mean = 0;
  for (const double value : values) mean += value / kCount;
  for (std::size_t n = 0; n < kCount; ++n) EXPECT_ABS((*rest)[n], mean, 1e-12, "rounding");
}

TEST(WithoutWhatLasts, OfSixtyFourSamplesALineIsTakenOff) {
  std::vector<double> line;
  for (int n = 0; n < 63; ++n) line.push_back(n);
  EXPECT_FALSE(WithoutWhatLasts(line, kStep_s));
  line.push_back(63);
  EXPECT_TRUE(WithoutWhatLasts(line, kStep_s));
}

TEST(WithoutWhatLasts, HolesStay) {
  auto values = Sampled([](double t) { return Ringing(t) + 20 * t; });
  values[0] = values[500] = values.back() = kNan;
  const auto rest = WithoutWhatLasts(values, kStep_s);
  ASSERT_TRUE(rest);
  for (const std::size_t n : {0UZ, 500UZ, kCount - 1}) EXPECT_TRUE(std::isnan((*rest)[n]));
  EXPECT_ABS((*rest)[499], (*rest)[501], 0.02, "no drift is left, and no ringing");
}

TEST(WithoutWhatLasts, TakesNothingOffARingingAloneOrNoise) {
  EXPECT_FALSE(WithoutWhatLasts(Sampled(Ringing), kStep_s));
  EXPECT_FALSE(WithoutWhatLasts(Noise(kCount, 1), kStep_s));
  auto about_seven = Noise(kCount, 1);
  for (double& value : about_seven) value += 7;
  EXPECT_FALSE(WithoutWhatLasts(about_seven, kStep_s)) << "an offset is no course";
  EXPECT_FALSE(WithoutWhatLasts(std::vector<double>(kCount, kNan), kStep_s));
  EXPECT_FALSE(WithoutWhatLasts({}, 0));
  // one that dies away at the mains' own frequency
  EXPECT_FALSE(WithoutWhatLasts(
      Sampled([](double t) { return std::exp(-4 * t) * std::sin(2 * M_PI * 50 * t); }), kStep_s));
  // a decay without oscillation, over within a tenth of the record
  EXPECT_FALSE(WithoutWhatLasts(Sampled([](double t) { return std::exp(-40 * t); }), kStep_s));
}

TEST(WithoutWhatLasts, HumIsTakenOffFromATenthOfASecondOn) {
  const auto hum = [](std::size_t count) {
    std::vector<double> values = Noise(count, 0.01);
    for (std::size_t n = 0; n < count; ++n) {
      values[n] += std::sin(2 * M_PI * 50 * static_cast<double>(n) * 2e-4);
    }
    return WithoutWhatLasts(values, 2e-4).has_value();
  };
  EXPECT_TRUE(hum(501));
  EXPECT_FALSE(hum(499));
}

TEST(WithoutWhatLasts, ALineIsTakenOffThatHasMoreThanAFifthOfTheTypicalPower) {
  // samples of +-1 and a line: in the k-th sixteenth of the record it has about b^2 x^2 more than
  // their 1, x from -1 to 1; of 16 x^2 the middle ones lie 3.5 and 4.5 sixteenths of 2 from 0
  const auto taken = [](double slope) {
    std::vector<double> values(1024);
    for (std::size_t n = 0; n < values.size(); ++n) {
      const double x = (2 * static_cast<double>(n) + 1) / 1024 - 1;
      values[n] = (n % 2 == 0 ? 1 : -1) + slope * x;
    }
    return WithoutWhatLasts(values, kStep_s).has_value();
  };
  // mean of x^2 over a sixteenth: its middle's square and (2/16)^2/12; the median of 16 is the
  // mean of the 8th and the 9th
  const double spread = 1. / 64 / 12;
  const double eighth = 7. / 16 * 7. / 16 + spread;
  const double ninth = 9. / 16 * 9. / 16 + spread;
  const double edge = std::sqrt((1 / 0.8 - 1) / ((eighth + ninth) / 2));
  EXPECT_FALSE(taken(0.995 * edge));
  EXPECT_TRUE(taken(1.005 * edge));
}

}  // namespace
}  // namespace haptometer::fit
