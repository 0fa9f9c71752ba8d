#include "bench/fir.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "dsp/filter/zero_phase.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

// of symmetric taps, without their delay
double Gain(const std::vector<double>& taps, double frequency_hz, double rate_hz) {
  const std::size_t reach = taps.size() / 2;
  double sum = taps[reach];
  for (std::size_t k = 1; k <= reach; ++k) {
    sum += 2 * taps[reach + k] *
           std::cos(2 * std::numbers::pi * frequency_hz / rate_hz * static_cast<double>(k));
  }
  return sum;
}

TEST(Fir, HoldsItsAttenuationInBothStopBandsAndItsRippleBetween) {
  for (const double attenuation_db : {40.0, 60.0, 100.0, 140.0}) {
    const auto taps = DesignFirBandPass({20, 500, 10, attenuation_db}, 1e4).value();
    const double ripple = std::pow(10, -attenuation_db / 20);
    for (int n = 0; n <= 400; ++n) {
      const double f_hz = 12.5 * n;
      const double gain = Gain(taps, f_hz, 1e4);
      const bool stops = f_hz <= 15 || f_hz >= 505;
      if (!stops && (f_hz < 25 || f_hz > 495)) continue;
      EXPECT_ABS(gain, stops ? 0 : 1, 1.7 * ripple, "Kaiser's fit, and the tails of two edges");
    }
    EXPECT_ABS(Gain(taps, 20, 1e4), 0.5, 1.7 * ripple, "half way by symmetry");
  }
}

TEST(Fir, HasTheTapsOfThePublishedTable) {
  // 60 dB and 10 Hz at 10 kHz: 3 627 by Kaiser's formula, rounded up to odd
  EXPECT_NEAR(static_cast<double>(DesignFirBandPass({20, 500, 10, 60}, 1e4)->size()), 3627, 2);
}

TEST(Fir, ImpossibleDesignsAreRefused) {
  EXPECT_FALSE(DesignFirBandPass({4, 500, 10, 60}, 1e4));
  EXPECT_FALSE(DesignFirBandPass({20, 500, 10, 60}, 1e3));
  EXPECT_FALSE(DesignFirBandPass({20, 500, 10, 10}, 1e4));
  EXPECT_FALSE(DesignFirBandPass({20, 500, 1e-6, 60}, 1e4));
  EXPECT_FALSE(DesignFirBandPass({20, 500, 10, 60}, 0));
}

TEST(OverlapSave, IsTheDirectConvolution) {
  const std::vector<double> signal = Samples(1e4, 1000, 1, {{1, 100}, {0.5, 1300, 1}});
  for (const std::size_t size : {1UZ, 3UZ, 101UZ, 2001UZ}) {
    std::vector<double> taps(size);
    Noise noise(size);
    for (double& tap : taps) tap = noise();
    const std::vector<double> out = FilterByOverlapSave(taps, signal);
    double worst = 0;
    for (std::size_t n = 0; n < signal.size(); ++n) {
      double sum = 0;
      for (std::size_t k = 0; k < size; ++k) {
        const std::size_t at = n + size / 2 - k;  // wraps below 0
        if (at < signal.size()) sum += taps[k] * signal[at];
      }
      worst = std::max(worst, std::abs(out[n] - sum));
    }
    EXPECT_ABS(worst / std::sqrt(static_cast<double>(size)), 0, 1e-14, "the FFT's rounding");
  }
}

TEST(OverlapSave, TheFftIsTheZeroPhaseFilter) {
  for (const int order : {2, 5, 6}) {
    const FilterDesign design = Designed({order, 20, 500}, 1e4);
    const std::vector<double> signal = Samples(1e4, 9000, 0, {{1e-6, 100}, {1e-5, 8.3, 1}});
    const std::vector<double> passes = FilterZeroPhase(design, signal);
    const std::vector<double> fft = FilterByFft(design, signal);
    double worst = 0;
    for (std::size_t k = 0; k < signal.size(); ++k) {
      worst = std::max(worst, std::abs(fft[k] - passes[k]));
    }
    EXPECT_ABS(worst / 1e-6, 0, 1e-8,
               "what 1e-12 of ringing leaves of the seam, times order's growth");
  }
  EXPECT_TRUE(FilterByFft(Designed({2, 20, 500}, 1e4), {}).empty());
}

}  // namespace
}  // namespace haptometer::dsp
