// What an averaging head leaves of a tone: |sin(pi f n T) / (n sin(pi f T))|, and that the emulated
// head delivers it.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "acquire/emulator/device.h"
#include "tests/residual.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

struct Averaged {
  int averages;
  double sampling_s;
  double tone_hz;
};

double StatedGain(const Averaged& a) {
  const double x = std::numbers::pi * a.tone_hz * a.sampling_s;
  return std::abs(std::sin(a.averages * x) / (a.averages * std::sin(x)));
}

MovingHead HeadOf(const Averaged& a, double amplitude_m) {
  MovingHead head{.head = trial::Il030(), .displacement = [=](double t_s) {
                    return amplitude_m * std::cos(kTwoPi * a.tone_hz * t_s);
                  }};
  head.head.averages = a.averages;
  head.head.sampling_s = a.sampling_s;
  return head;
}

// amplitude of the tone in `samples` readings: least squares of a cosine and a sine, whose two
// columns are not quite orthogonal over a finite record
double DeliveredAmplitude(const MovingHead& head, double tone_hz, int samples) {
  double cc = 0, ss = 0, cs = 0, cy = 0, sy = 0;
  for (int k = 0; k < samples; ++k) {
    const double phase = kTwoPi * tone_hz * k * head.head.sampling_s;
    const double c = std::cos(phase), s = std::sin(phase);
    const double y = head.Reading(k).value_m;
    cc += c * c;
    ss += s * s;
    cs += c * s;
    cy += c * y;
    sy += s * y;
  }
  const double det = cc * ss - cs * cs;
  return std::hypot((ss * cy - cs * sy) / det, (cc * sy - cs * cy) / det);
}

class AveragingGain : public ::testing::TestWithParam<Averaged> {};

TEST_P(AveragingGain, IsExactForANoiselessHeadBeforeItRounds) {
  MovingHead head = HeadOf(GetParam(), 1e-3);
  head.head.noise_rms_m = 0;
  head.head.resolution_m = 0;
  const double gain = DeliveredAmplitude(head, GetParam().tone_hz, 2000) / 1e-3;
  EXPECT_ABS(gain, StatedGain(GetParam()), 1e-11,
             "2000 terms of rounding, of phases up to 1e4 rad: 1e4 x 2^-53 each");
}

TEST_P(AveragingGain, IsDeliveredWithinNoiseAndSteps) {
  constexpr int kSamples = 4000;
  const MovingHead head = HeadOf(GetParam(), 1e-3);
  const double gain = DeliveredAmplitude(head, GetParam().tone_hz, kSamples) / 1e-3;
  // an amplitude fitted to N readings has the deviation sigma sqrt(2 / N); n readings in a row
  // share raw samples, so the noise of a reading, 11 um / sqrt(n), counts n-fold at most; steps of
  // 1 um
  const double sigma_m = std::hypot(11e-6, 1e-6 / std::sqrt(12.0));
  EXPECT_ABS(gain, StatedGain(GetParam()), 5 * sigma_m * std::sqrt(2.0 / kSamples) / 1e-3,
             "five standard deviations of the fitted amplitude");
}

INSTANTIATE_TEST_SUITE_P(Tones, AveragingGain,
                         ::testing::Values(Averaged{1, 1e-3, 175}, Averaged{16, 1e-3, 175},
                                           Averaged{16, 1e-3, 225}, Averaged{4, 0.33e-3, 175},
                                           Averaged{4, 0.33e-3, 225}, Averaged{16, 0.33e-3, 225},
                                           Averaged{128, 1e-3, 3.5}, Averaged{64, 2e-3, 20},
                                           Averaged{16, 1e-3, 50}, Averaged{2, 0.33e-3, 500}));

TEST(AveragingGain, OfTheFactorySettingByHand) {
  // 16 x 1 ms: sin(16 x) / (16 sin x) with x = pi f / 1000; its first null lies at 62.5 Hz
  EXPECT_ABS(StatedGain({16, 1e-3, 20}), 0.844328 / (16 * 0.0627905), 1e-5, "six digits");
  EXPECT_ABS(StatedGain({16, 1e-3, 50}), 0.587785 / (16 * 0.156434), 1e-5, "six digits");
  EXPECT_ABS(StatedGain({16, 1e-3, 62.5}), 0, 1e-15, "a null");
}

}  // namespace
}  // namespace haptometer::acquire::emulator
