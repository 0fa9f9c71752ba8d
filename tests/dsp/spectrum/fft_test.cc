#include "dsp/spectrum/fft.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <thread>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using Complex = std::complex<double>;

std::vector<double> NoiseOf(std::size_t count, std::uint64_t seed) {
  Noise noise(seed);
  std::vector<double> values(count);
  for (double& x : values) x = noise();
  return values;
}

// the definition, in long double
std::vector<Complex> ByDefinition(const std::vector<double>& x) {
  std::vector<Complex> bins(x.size() / 2 + 1);
  for (std::size_t k = 0; k < bins.size(); ++k) {
    std::complex<long double> sum = 0;
    for (std::size_t n = 0; n < x.size(); ++n) {
      const long double turns = static_cast<long double>(k * n % x.size()) / x.size();
      const long double angle = -2 * std::numbers::pi_v<long double> * turns;
      sum += static_cast<long double>(x[n]) * std::polar(1.0L, angle);
    }
    bins[k] = Complex(static_cast<double>(sum.real()), static_cast<double>(sum.imag()));
  }
  return bins;
}

class EverySize : public testing::TestWithParam<std::size_t> {};

TEST_P(EverySize, IsTheDefinitionAndComesBack) {
  const std::vector<double> x = NoiseOf(GetParam(), 5);
  RealFft fft(x.size());
  std::vector<Complex> bins(fft.bins());
  fft.Forward(x, bins);
  const std::vector<Complex> expected = ByDefinition(x);
  double worst = 0;
  for (std::size_t k = 0; k < bins.size(); ++k) {
    worst = std::max(worst, std::abs(bins[k] - expected[k]));
  }
  const double scale = std::sqrt(static_cast<double>(x.size()));
  EXPECT_ABS(worst / scale, 0, 3e-15, "rounding; the primes take two transforms more");

  const std::vector<Complex> once = RealSpectrum(x);
  ASSERT_EQ(once.size(), bins.size());
  worst = 0;
  for (std::size_t k = 0; k < once.size(); ++k) {
    worst = std::max(worst, std::abs(once[k] - expected[k]));
  }
  EXPECT_ABS(worst / scale, 0, 3e-15, "the same, even sizes as half as many complex numbers");

  std::vector<double> back(x.size());
  fft.Inverse(bins, back);
  double change = 0;
  for (std::size_t k = 0; k < x.size(); ++k) change = std::max(change, std::abs(back[k] - x[k]));
  EXPECT_ABS(change, 0, 6e-15, "the same, twice");
}

INSTANTIATE_TEST_SUITE_P(Fft, EverySize, testing::Values(1, 2, 3, 6, 7, 64, 97, 360, 1009));

TEST(Fft, IsBitForBitTheSameAgainAndOnTwoThreads) {
  const std::vector<double> x = NoiseOf(5000, 1);
  const std::vector<Complex> once = RealSpectrum(x);
  std::vector<Complex> a;
  std::vector<Complex> b;
  std::thread first([&] { a = RealSpectrum(x); });
  std::thread second([&] { b = RealSpectrum(x); });
  first.join();
  second.join();
  EXPECT_TRUE(std::ranges::equal(once, a));
  EXPECT_TRUE(std::ranges::equal(once, b));
}

TEST(FastTransformSize, IsAnEvenProductOfSmallPrimesNearby) {
  for (std::size_t size = 1; size <= 20'000; ++size) {
    const std::size_t fast = FastTransformSize(size);
    ASSERT_LE(fast, size);
    ASSERT_GE(static_cast<double>(fast), 0.93 * static_cast<double>(size)) << size;
    if (size <= 256) {
      ASSERT_EQ(fast, size);
      continue;
    }
    std::size_t rest = fast;
    for (const std::size_t factor : {2U, 3U, 5U, 7U}) {
      while (rest % factor == 0) rest /= factor;
    }
    ASSERT_EQ(rest, 1U) << size;
    ASSERT_EQ(fast % 2, 0U) << size;
  }
}

// A constant and a tone of whole periods have two bins. The longest size that is transformed as
// complex numbers, and an odd and an even one beyond it.
TEST(Fft, OfAToneIsTheClosedFormAtLargeSizes) {
  for (const std::size_t size : {65'536UZ, 65'537UZ, 65'538UZ}) {
    const auto n = static_cast<double>(size);
    constexpr std::size_t kBin = 12'345;
    std::vector<double> x(size);
    for (std::size_t k = 0; k < size; ++k) {
      const double turns = static_cast<double>(kBin * k % size) / n;
      x[k] = 0.5 + std::cos(2 * std::numbers::pi * turns + 0.7);
    }
    const std::vector<Complex> bins = RealSpectrum(x);
    ASSERT_EQ(bins.size(), size / 2 + 1);
    double worst = 0;
    for (std::size_t k = 0; k < bins.size(); ++k) {
      const Complex expected = k == 0 ? 0.5 * n : k == kBin ? std::polar(0.5 * n, 0.7) : 0;
      worst = std::max(worst, std::abs(bins[k] - expected));
    }
    EXPECT_ABS(worst / n, 0, 2e-15, "rounding of the samples and of a transform");
    RealFft fft(size);
    std::vector<double> back(size);
    fft.Inverse(bins, back);
    double change = 0;
    for (std::size_t k = 0; k < size; ++k) change = std::max(change, std::abs(back[k] - x[k]));
    EXPECT_ABS(change, 0, 5e-14,
               "rounding of two transforms, each of 17 stages and of a prime two");
  }
}

// the oracle looks at every even size downwards
TEST(FastTransformSize, IsTheLargestSuchSize) {
  const auto is_fast = [](std::size_t size) {
    for (const std::size_t factor : {2U, 3U, 5U, 7U}) {
      while (size % factor == 0) size /= factor;
    }
    return size == 1;
  };
  std::size_t largest = 256;
  for (std::size_t size = 257; size <= 5000; ++size) {
    if (size % 2 == 0 && is_fast(size)) largest = size;
    EXPECT_EQ(FastTransformSize(size), largest) << size;
  }
}

TEST(FftDeathTest, SizesAreChecked) {
  EXPECT_DEATH(RealFft(0), "check failed");
  RealFft fft(8);
  std::vector<double> samples(9);
  std::vector<Complex> bins(6);
  const std::span<double> all(samples);
  const std::span<Complex> every(bins);
  EXPECT_DEATH(fft.Forward(all, every.first(5)), "check failed");
  EXPECT_DEATH(fft.Forward(all.first(8), every), "check failed");
  EXPECT_DEATH(fft.Inverse(every, all.first(8)), "check failed");
  EXPECT_DEATH(fft.Inverse(every.first(5), all), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
