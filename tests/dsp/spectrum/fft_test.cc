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

}  // namespace
}  // namespace haptometer::dsp
