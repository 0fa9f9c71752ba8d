// What averaging leaves of a tone, and what a head makes of a displacement.
#include "trial/sensor_head.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "tests/residual.h"

namespace haptometer::trial {
namespace {

TEST(SensorHead, AveragingLeavesOfAToneWhatItsPhasorsSumTo) {
  // 16 averages at 0.33 ms: 0.15 at 225 Hz, 0.08 at 175 Hz; single readings 1
  EXPECT_ABS(AveragingGain(225, 0.33e-3, 16), 0.15, 5e-3, "the figure's digits");
  EXPECT_ABS(AveragingGain(175, 0.33e-3, 16), 0.08, 5e-3, "the figure's digits");
  EXPECT_EQ(AveragingGain(225, 0.33e-3, 1), 1);
  EXPECT_EQ(AveragingGain(1000, 1e-3, 16), 1) << "an alias of 0 Hz";
  EXPECT_ABS(AveragingGain(1000.0 / 16, 1e-3, 16), 0, 1e-15, "one whole period is averaged");
  // the mean of the samples of a phasor, summed
  double re = 0;
  double im = 0;
  for (int k = 0; k < 7; ++k) {
    re += std::cos(2 * std::numbers::pi * 90 * 1e-3 * k) / 7;
    im += std::sin(2 * std::numbers::pi * 90 * 1e-3 * k) / 7;
  }
  EXPECT_REL(AveragingGain(90, 1e-3, 7), std::hypot(re, im), 1e-14, "rounding");
}

// a head without noise or rounding, with a range of +-1 mm
SensorHead Ideal(int averages) {
  SensorHead head;
  head.sampling_s = 1e-3;
  head.averages = averages;
  head.range_min_m = -1e-3;
  head.range_max_m = 1e-3;
  return head;
}

// a head whose samples have noise of 1 m
SensorHead Noisy() {
  SensorHead head;
  head.sampling_s = 1;
  head.noise_rms_m = 1;
  head.range_min_m = -100;
  head.range_max_m = 100;
  return head;
}

// the mean of a straight line is its value in the middle of the samples
TEST(SensorHead, AReadingIsTheMeanOfTheLastSamples) {
  const auto line = [](double t_s) { return 2e-3 * t_s; };
  for (const int averages : {1, 2, 5, 16}) {
    for (const std::int64_t k : {0, 7, 100}) {
      const double middle_s = 1e-3 * (static_cast<double>(k) - 0.5 * (averages - 1));
      const HeadReading reading = ReadingAt(Ideal(averages), line, k, 1);
      EXPECT_ABS(reading.value_m, 2e-3 * middle_s, 1e-18, "rounding of 1e-4 m");
      EXPECT_EQ(reading.status, SampleStatus::kOk);
    }
  }
}

TEST(SensorHead, AReadingBeyondTheRangeIsItsEnd) {
  const auto at = [](double value_m) {
    return ReadingAt(Ideal(1), [=](double /*t_s*/) { return value_m; }, 0, 1);
  };
  for (const double value_m : {1e-3, -1e-3, 0.999e-3}) {
    EXPECT_EQ(at(value_m).status, SampleStatus::kOk) << value_m;
    EXPECT_EQ(at(value_m).value_m, value_m);
  }
  EXPECT_EQ(at(1.001e-3).status, SampleStatus::kOver);
  EXPECT_EQ(at(1.001e-3).value_m, 1e-3);
  EXPECT_EQ(at(-1.001e-3).status, SampleStatus::kUnder);
  EXPECT_EQ(at(-1.001e-3).value_m, -1e-3);
}

TEST(SensorHead, AReadingIsRoundedToTheNearestStep) {
  SensorHead head = Ideal(1);
  head.resolution_m = 0x1p-12;  // whole steps are exact
  const auto steps = [&](double of) {
    const auto displacement = [=](double /*t_s*/) { return of * 0x1p-12; };
    return ReadingAt(head, displacement, 0, 1).value_m / 0x1p-12;
  };
  EXPECT_EQ(steps(3), 3);
  EXPECT_EQ(steps(2.49), 2);
  EXPECT_EQ(steps(2.51), 3);
  EXPECT_EQ(steps(-2.51), -3);
}

// Of n readings of noise of 1 m the mean has a standard error of 1/sqrt(n), the variance one of
// sqrt(2/n), a share p one of sqrt(p (1 - p) / n); five of each are allowed.
TEST(SensorHead, NoiseIsNormalAndWhite) {
  const SensorHead head = Noisy();
  const auto still = [](double /*t_s*/) { return 0.0; };
  constexpr int kReadings = 40'000;
  double sum = 0, squares = 0, products = 0, last = 0;
  int within = 0;
  for (int k = 0; k < kReadings; ++k) {
    const double value = ReadingAt(head, still, k, 7).value_m;
    sum += value / kReadings;
    squares += value * value / kReadings;
    products += value * last / kReadings;
    within += std::abs(value) < 1 ? 1 : 0;
    last = value;
  }
  const double error = 1 / std::sqrt(kReadings);
  EXPECT_ABS(sum, 0, 5 * error, "mean");
  EXPECT_ABS(squares, 1, 5 * std::numbers::sqrt2 * error, "variance");
  EXPECT_ABS(products, 0, 5 * error, "one sample is nothing to the next");
  EXPECT_ABS(static_cast<double>(within) / kReadings, std::erf(1 / std::numbers::sqrt2),
             5 * std::sqrt(0.683 * 0.317) * error, "within one standard deviation");
}

TEST(SensorHead, NoiseDependsOnSeedAndSampleAlone) {
  SensorHead head = Noisy();
  const auto still = [](double /*t_s*/) { return 0.0; };
  const auto at = [&](std::int64_t k, std::uint64_t seed) {
    return ReadingAt(head, still, k, seed).value_m;
  };
  const double third = at(3, 1), fourth = at(4, 1);
  EXPECT_EQ(at(3, 1), third);
  EXPECT_NE(at(3, 2), third);
  EXPECT_NE(fourth, third);
  // the mean of two samples is that of their own noise
  head.averages = 2;
  EXPECT_ABS(at(4, 1), 0.5 * (third + fourth), 1e-15, "rounding");
}

// the data sheet: 1 um at 128 averages
TEST(SensorHead, TheIl030IsThatOfItsDataSheet) {
  const SensorHead head = Il030();
  EXPECT_EQ(head.sampling_s, 1e-3);
  EXPECT_EQ(head.averages, 16);
  EXPECT_EQ(head.resolution_m, 1e-6);
  EXPECT_EQ(head.range_min_m, -15e-3) << "45 mm away, of 30 mm";
  EXPECT_EQ(head.range_max_m, 10e-3) << "20 mm away";
  EXPECT_ABS(head.noise_rms_m / std::sqrt(128), 1e-6, 0.05e-6, "a digit of the data sheet");
  const SensorHead stream = Stream10kHz();
  EXPECT_EQ(stream.sampling_s, 1e-4);
  EXPECT_EQ(stream.averages, 1);
  EXPECT_EQ(stream.resolution_m, 1e-7);
  EXPECT_EQ(stream.noise_rms_m, 0.5e-6);
  EXPECT_EQ(stream.range_min_m, -10e-3);
  EXPECT_EQ(stream.range_max_m, 10e-3);
}

}  // namespace
}  // namespace haptometer::trial
