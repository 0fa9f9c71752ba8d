#include "dsp/statistics/moments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

// NIST StRD NumAcc2, 3 and 4: first + pairs of (base + 0.1, base + 0.3), 1001 values
std::vector<double> NumAcc(double first, double low, double high) {
  std::vector<double> values{first};
  for (int k = 0; k < 500; ++k) {
    values.push_back(low);
    values.push_back(high);
  }
  return values;
}

// the same quantities of the stored doubles, in 64-bit mantissas about the first value
double ExactDeviation(const std::vector<double>& values) {
  long double sum = 0;
  long double squares = 0;
  for (const double value : values) {
    const long double x = static_cast<long double>(value) - static_cast<long double>(values[0]);
    sum += x;
    squares += x * x;
  }
  const auto n = static_cast<long double>(values.size());
  return static_cast<double>(std::sqrt((squares - sum * sum / n) / (n - 1)));
}

TEST(StandardDeviation, IsThatOfNistsHardSets) {
  // https://www.itl.nist.gov/div898/strd, univariate: certified 1, 0.1, 0.1, 0.1
  const std::vector<double> numacc1{10000001, 10000003, 10000002};
  EXPECT_REL(StandardDeviation(numacc1), 1.0, 0, "integers: exact");
  EXPECT_REL(Mean(numacc1), 10000002.0, 0, "integers: exact");
  EXPECT_REL(StandardDeviation(NumAcc(1.2, 1.1, 1.3)), 0.1, 5e-16, "15.3 digits");
  EXPECT_REL(StandardDeviation(NumAcc(1000000.2, 1000000.1, 1000000.3)), 0.1, 4e-10,
             "the decimals are not doubles: 9.5 digits");
  EXPECT_REL(StandardDeviation(NumAcc(10000000.2, 10000000.1, 10000000.3)), 0.1, 6e-9,
             "the decimals are not doubles: 8.3 digits");
}

TEST(StandardDeviation, LosesNothingOfTheStoredDoubles) {
  for (const double base : {1.0, 1e6, 1e7}) {
    const std::vector<double> values = NumAcc(base + 0.2, base + 0.1, base + 0.3);
    EXPECT_REL(StandardDeviation(values), ExactDeviation(values), 3e-16, "one rounding");
  }
}

TEST(Mean, IsThatOfNistsHardSets) {
  EXPECT_REL(Mean(NumAcc(1.2, 1.1, 1.3)), 1.2, 3e-16, "one rounding");
  EXPECT_REL(Mean(NumAcc(1000000.2, 1000000.1, 1000000.3)), 1000000.2, 3e-16, "one rounding");
  EXPECT_REL(Mean(NumAcc(10000000.2, 10000000.1, 10000000.3)), 10000000.2, 3e-16, "one rounding");
}

TEST(Rms, OfWholePeriodsIsAmplitudeOverRootTwo) {
  const std::vector<double> sine = Samples(10e3, 1'000'000, 0, {{1e-6, 225, 0.2}});
  EXPECT_REL(Rms(sine), 1e-6 / std::numbers::sqrt2, 1e-13, "phases of 1e5 rad");
  EXPECT_EQ(Rms(std::vector{3.0, 4.0}), std::sqrt(12.5));
  EXPECT_EQ(Rms(std::vector{-2.0}), 2);
}

TEST(Rms, GrowsNoErrorWithTheLength) {
  // 0.1^2 is no double; a plain sum of 1e7 of them is off by 2e-11
  EXPECT_REL(Rms(std::vector<double>(10'000'000, 0.1)), 0.1, 1e-15, "rounding of log2(1e7) sums");
}

// values 1 and 2: s = 1 / sqrt(2), error 1/2, t = 3; one degree of freedom is Cauchy's distribution
TEST(TestMean, OfTwoValuesIsCauchys) {
  const OneSample sample = TestMean(std::vector{1.0, 2.0});
  ASSERT_TRUE(sample.test);
  EXPECT_EQ(sample.n, 2U);
  EXPECT_REL(*sample.standard_deviation, 1 / std::numbers::sqrt2, 1e-15, "rounding");
  EXPECT_REL(sample.test->t, 3, 1e-15, "rounding");
  EXPECT_EQ(sample.test->df, 1);
  EXPECT_REL(sample.test->p, 1 - 2 * std::atan(3.0) / std::numbers::pi, 1e-14, "closed form");
  const double reach = 0.5 * std::tan(0.475 * std::numbers::pi);
  EXPECT_REL(sample.test->mean.lower, 1.5 - reach, 1e-13, "closed form of the quantile");
  EXPECT_REL(sample.test->mean.upper, 1.5 + reach, 1e-13, "closed form of the quantile");
}

TEST(TestMean, OfOneValueAndOfEqualValuesHasNoTest) {
  EXPECT_FALSE(TestMean(std::vector{2.0}).standard_deviation);
  const OneSample equal = TestMean(std::vector{2.0, 2.0});
  EXPECT_EQ(equal.standard_deviation, 0);
  EXPECT_FALSE(equal.test);
}

// every place of the eight sums, of whole blocks and of what is left behind them
TEST(Mean, OfWholeNumbersIsExactAtEveryLength) {
  std::vector<double> values;
  for (int n = 1; n <= 400; ++n) {
    values.push_back(n);
    EXPECT_EQ(Mean(values), 0.5 * (n + 1)) << n;
  }
}

TEST(MomentsDeathTest, NeedOneValueOrTwo) {
  const std::vector<double> none;
  EXPECT_DEATH(static_cast<void>(Mean(none)), "check failed");
  EXPECT_DEATH(static_cast<void>(Rms(none)), "check failed");
  EXPECT_DEATH(static_cast<void>(StandardDeviation(std::vector{1.0})), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
