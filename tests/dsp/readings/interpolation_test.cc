// Missing samples of processes whose interpolation has a closed form: an autoregressive process of
// coefficient a and innovations of variance s^2 determines a single missing sample, its neighbours
// known, to s^2 / (1 + a^2).
#include "dsp/readings/interpolation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kCount = 1025;
constexpr std::size_t kMiddle = 512;

void Spoil(std::vector<double>& samples, std::size_t first, std::size_t count) {
  for (std::size_t k = first; k < first + count; ++k) samples[k] = kNaN;
}

// x[n] = a x[n-1] + e[n]
std::vector<double> Process(double a, Noise& noise) {
  std::vector<double> samples(kCount);
  double x = noise() / std::sqrt(1 - a * a);
  for (double& sample : samples) sample = x = a * x + noise();
  return samples;
}

// means over 100 records of the stated square of the error and of the true one
struct Squares {
  double stated = 0;
  double found = 0;
};

Squares SquaresOf(double a, std::uint64_t seed, std::size_t missing) {
  constexpr int kRecords = 100;
  Noise noise(seed);
  Squares squares;
  for (int r = 0; r < kRecords; ++r) {
    std::vector<double> samples = Process(a, noise);
    const double truth = samples[missing];
    Spoil(samples, missing, 1);
    const auto found = Interpolate(samples, missing, missing + 1);
    EXPECT_TRUE(found && found->size() == 1);
    if (!found || found->size() != 1) return squares;
    squares.stated += (*found)[0].error_square / kRecords;
    squares.found += std::pow((*found)[0].value - truth, 2) / kRecords;
  }
  return squares;
}

TEST(Interpolate, StatesTheErrorOfAnAutoregressiveProcess) {
  for (const double a : {0.0, 0.6, -0.9}) {
    const Squares squares = SquaresOf(a, 3, kMiddle);
    // the squares of 64 coefficients that scatter by 1 / 900 each add 7 % to those of the model;
    // where the innovations beside the hole are larger, these count
    EXPECT_REL(squares.stated, 1 / (1 + a * a), 0.15, "what 64 coefficients cost");
    EXPECT_REL(squares.found, 1 / (1 + a * a), 0.45, "three deviations of 100: sqrt(2 / 100)");
  }
}

TEST(Interpolate, OfAToneIsTheTone) {
  for (const std::size_t missing : {1U, 5U, 30U}) {
    std::vector<double> samples = Samples(10e3, kCount, 0.03, {{20e-6, 225, 0.3}});
    const std::vector<double> truth = samples;
    Spoil(samples, 400, missing);
    const auto found = Interpolate(samples, 400, 400 + missing);
    ASSERT_TRUE(found);
    ASSERT_EQ(found->size(), missing);
    for (std::size_t k = 0; k < missing; ++k) {
      const double error = (*found)[k].value - truth[400 + k];
      EXPECT_ABS(error, 0, 1.4e-10, "1e-5 of the RMS, the least error that is stated");
      EXPECT_LE(std::abs(error), 3 * std::sqrt((*found)[k].error_square));
    }
  }
}

// samples are multiples of 2^-20 and offsets powers of two: nothing of them is rounded
TEST(Interpolate, AnOffsetChangesNothingButTheValues) {
  Noise noise(5);
  std::vector<double> samples(600);
  for (double& x : samples) x = std::round(0x1p16 * noise()) * 0x1p-20;
  Spoil(samples, 200, 4);
  const auto plain = Interpolate(samples, 200, 204);
  ASSERT_TRUE(plain);
  for (const double offset : {-0x1p10, 0x1p14}) {
    std::vector<double> moved = samples;
    for (double& x : moved) x += offset;
    const auto found = Interpolate(moved, 200, 204);
    ASSERT_TRUE(found);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_ABS((*found)[k].value - offset, (*plain)[k].value, 1e-11, "rounding of 2^14");
      EXPECT_REL((*found)[k].error_square, (*plain)[k].error_square, 1e-12, "the same numbers");
    }
  }
}

// a power of two rounds nothing: values scale with it, squares with its square
TEST(Interpolate, ScalesWithTheSamples) {
  Noise noise(6);
  std::vector<double> samples = Process(0.8, noise);
  Spoil(samples, kMiddle, 3);
  std::vector<double> scaled = samples;
  for (double& x : scaled) x *= 0x1p-17;
  const auto plain = Interpolate(samples, kMiddle, kMiddle + 3);
  const auto small = Interpolate(scaled, kMiddle, kMiddle + 3);
  ASSERT_TRUE(plain && small);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ((*small)[k].value, (*plain)[k].value * 0x1p-17);
    EXPECT_EQ((*small)[k].error_square, (*plain)[k].error_square * 0x1p-34);
  }
}

// two coefficients take three samples each, and two samples before the first of these
TEST(Interpolate, NeedsEightSamplesInARow) {
  Noise noise(7);
  std::vector<double> samples(10);
  for (double& x : samples) x = noise();
  Spoil(samples, 8, 1);
  EXPECT_TRUE(Interpolate(samples, 8, 9));
  EXPECT_FALSE(Interpolate(std::span(samples).subspan(1), 7, 8));
  EXPECT_FALSE(Interpolate(std::vector<double>(40, kNaN), 0, 40)) << "nothing is measured";
}

// what is missing beside the range is no obstacle, and is not told
TEST(Interpolate, TellsOfItsRangeOnly) {
  Noise noise(8);
  std::vector<double> samples = Process(0.5, noise);
  Spoil(samples, 500, 2);
  Spoil(samples, 510, 3);
  const auto found = Interpolate(samples, 500, 502);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->size(), 2U);
  const auto both = Interpolate(samples, 500, 513);
  ASSERT_TRUE(both);
  EXPECT_EQ(both->size(), 5U);
}

// The last sample has no neighbour behind it: it is predicted, and the error is the innovation.
TEST(Interpolate, StatesTheErrorOfAPrediction) {
  for (const double a : {0.0, 0.6, -0.9}) {
    const Squares squares = SquaresOf(a, 4, kCount - 1);
    EXPECT_REL(squares.stated, 1.0, 0.03, "sqrt(2 / 900) of each of 100 records, six times");
    EXPECT_REL(squares.found, 1.0, 0.5, "64 coefficients: 7 %; three deviations of 100");
  }
}

// Errors of white noise are independent; those of a slow process in a hole have one sign, and their
// sum the variance that the covariances add up to.
TEST(Interpolate, StatesTheCovariancesOfErrors) {
  constexpr std::size_t kMissing = 10;
  constexpr int kRecords = 200;
  for (const double a : {0.0, 0.95}) {
    Noise noise(9);
    double squares = 0;
    double covariances = 0;
    double square_of_sum = 0;
    for (int r = 0; r < kRecords; ++r) {
      std::vector<double> samples = Process(a, noise);
      const std::vector<double> truth = samples;
      Spoil(samples, kMiddle, kMissing);
      const auto found = Interpolate(samples, kMiddle, kMiddle + kMissing);
      ASSERT_TRUE(found);
      double sum = 0;
      for (std::size_t k = 0; k < kMissing; ++k) {
        squares += (*found)[k].error_square / kRecords;
        covariances += (*found)[k].covariance_sum / kRecords;
        sum += (*found)[k].value - truth[kMiddle + k];
      }
      square_of_sum += sum * sum / kRecords;
    }
    // coefficients scatter by 1 / sqrt(900): nine covariances of 0.03 beside each square
    // ten of one sign give up to ten times their squares
    const double factor = covariances / squares;
    EXPECT_TRUE(a == 0 ? factor < 1.4 : factor > 4) << factor;
    EXPECT_GT(covariances, 0.7 * square_of_sum) << "three deviations of 200: sqrt(2 / 200)";
  }
}

// Of two samples in the same white noise, whose deviation is `deviation` about the first one: the
// quotient of the stated squares, that of the first by that of the second.
double QuotientOfSquares(double deviation, std::uint64_t seed) {
  constexpr std::size_t kOther = 800;
  Noise noise(seed);
  std::vector<double> samples(kCount);
  for (std::size_t k = 0; k < kCount; ++k) {
    // all samples that the innovations about the first one read
    const bool is_near = k + 65 > kMiddle && k < kMiddle + 65;
    samples[k] = (is_near ? deviation : 1) * noise();
  }
  Spoil(samples, kMiddle, 1);
  Spoil(samples, kOther, 1);
  const auto first = Interpolate(samples, kMiddle, kMiddle + 1);
  const auto second = Interpolate(samples, kOther, kOther + 1);
  EXPECT_TRUE(first && second);
  return first && second ? (*first)[0].error_square / (*second)[0].error_square : 0;
}

// The larger counts of the model's innovations and of those beside the hole. Where these are
// smaller, the model's count, as about the other sample, but for the scatter of 64 innovations.
TEST(Interpolate, QuietNeighboursReduceNoError) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const double quotient = QuotientOfSquares(0.1, seed);
    EXPECT_LE(quotient, 1 + 1e-9);
    EXPECT_GT(quotient, 0.5) << "the model's are 0.87, three deviations of sqrt(2 / 64) above 1";
  }
}

TEST(Interpolate, LoudNeighboursIncreaseTheError) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    EXPECT_GT(QuotientOfSquares(10, seed), 2) << "100 beside a model of 13 to 14";
  }
}

}  // namespace
}  // namespace haptometer::dsp
