#include "dsp/spectrum/sine_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "dsp/statistics/moments.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRateHz = 10e3;

TEST(SineFit, FindsAnExactSineAtAKnownFrequency) {
  // sin(x + 0.3) = cos(x + 0.3 - pi/2); an offset of 30 mm leaves the input 3.5e-18 m of rounding
  const std::vector<double> signal = Samples(kRateHz, 2345, 0.03, {{2e-6, 225, 0.3}});
  const SineFit fit = FitSineAt(signal, {kRateHz, 0}, 225);
  ASSERT_TRUE(fit.converged);
  EXPECT_REL(fit.amplitude, 2e-6, 2e-13, "the input's rounding, 3.5e-18 m over sqrt(2345/2)");
  EXPECT_ABS(fit.phase_rad, 0.3 - kPi / 2, 2e-13, "the same over the amplitude");
  EXPECT_REL(fit.offset, 0.03, 3e-16, "one rounding");
  EXPECT_EQ(fit.frequency_hz, 225);
  EXPECT_EQ(fit.frequency_uncertainty_hz, 0);
  EXPECT_ABS(fit.residual_rms, 0, 4e-18, "the input's rounding at 30 mm");
}

TEST(SineFit, FindsTheFrequencyToo) {
  const std::vector<double> signal = Samples(kRateHz, 20'000, 0, {{2e-6, 225.123, -2}});
  for (const double start_hz : {225.123, 225.0, 225.3}) {
    const SineFit fit = FitSine(signal, {kRateHz, 0}, start_hz);
    ASSERT_TRUE(fit.converged) << start_hz;
    EXPECT_REL(fit.frequency_hz, 225.123, 1e-15, "phase rounding 1e-13 rad over 2 s");
    EXPECT_REL(fit.amplitude, 2e-6, 1e-14, "rounding");
    EXPECT_ABS(std::remainder(fit.phase_rad - (-2 - kPi / 2), 2 * kPi), 0, 1e-12,
               "rounding of phases of 3e3 rad");
  }
}

TEST(SineFit, GoesToHalfTheRate) {
  const double frequency_hz = 0.49 * kRateHz;
  const std::vector<double> signal = Samples(kRateHz, 2345, 0, {{2e-6, frequency_hz, 1}});
  const SineFit fit = FitSine(signal, {kRateHz, 0}, frequency_hz);
  ASSERT_TRUE(fit.converged);
  EXPECT_REL(fit.amplitude, 2e-6, 1e-12, "rounding, of a cosine that is nearly of one sign");
  EXPECT_FALSE(FitSine(signal, {kRateHz, 0}, 0.5 * kRateHz).converged);
}

TEST(SineFit, SaysWhenItHasNotConverged) {
  const std::vector<double> signal = Samples(kRateHz, 20'000, 0, {{2e-6, 225, 0}});
  const SineFit far = FitSine(signal, {kRateHz, 0}, 240);
  EXPECT_FALSE(far.converged);
  EXPECT_TRUE(std::isnan(far.amplitude_uncertainty));
  EXPECT_FALSE(FitSine(std::vector<double>(4, 1.0), {kRateHz, 0}, 225).converged);
  EXPECT_FALSE(FitSineAt(std::vector<double>(20, 1.0), {kRateHz, 0}, 225).converged)
      << "20 samples at 10 kHz hold 0.45 periods";
  EXPECT_FALSE(FitSineAt(signal, {kRateHz, 0}, 5000).converged) << "half the rate";
}

// 400 noisy records: does the scatter agree with what each fit says of itself?
struct Scatter {
  double frequency_ratio = 0;  // standard deviation over stated uncertainty
  double amplitude_ratio = 0;
  double phase_ratio = 0;
};

Scatter ScatterOfFits(std::size_t count, double noise_bandwidth_hz, bool known) {
  constexpr int kRecords = 400;
  std::vector<double> frequencies;
  std::vector<double> amplitudes;
  std::vector<double> phases;
  SineFit fit;
  Noise noise(7);
  for (int r = 0; r < kRecords; ++r) {
    std::vector<double> signal = Samples(kRateHz, count, 0, {{1, 300, 0.5 + kPi / 2}});
    double held = 0;
    for (std::size_t k = 0; k < count; ++k) {
      // holding every value for two samples halves the noise's free samples
      if (noise_bandwidth_hz == 0 || k % 2 == 0) held = 0.3 * noise();
      signal[k] += held;
    }
    fit = known ? FitSineAt(signal, {kRateHz, noise_bandwidth_hz}, 300)
                : FitSine(signal, {kRateHz, noise_bandwidth_hz}, 300);
    EXPECT_TRUE(fit.converged);
    frequencies.push_back(fit.frequency_hz);
    amplitudes.push_back(fit.amplitude);
    phases.push_back(fit.phase_rad);
  }
  return {known ? 1 : StandardDeviation(frequencies) / fit.frequency_uncertainty_hz,
          StandardDeviation(amplitudes) / fit.amplitude_uncertainty,
          StandardDeviation(phases) / fit.phase_uncertainty_rad};
}

TEST(SineFit, StatedUncertaintiesAreTheScatter) {
  constexpr const char* kReason = "a deviation of 400 values is known to 3.5 %, four of these";
  const Scatter white = ScatterOfFits(1000, 0, false);
  EXPECT_ABS(white.frequency_ratio, 1, 0.14, kReason);
  EXPECT_ABS(white.amplitude_ratio, 1, 0.14, kReason);
  EXPECT_ABS(white.phase_ratio, 1, 0.14, kReason);
  const Scatter known = ScatterOfFits(1000, 0, true);
  EXPECT_ABS(known.amplitude_ratio, 1, 0.14, kReason);
  EXPECT_ABS(known.phase_ratio, 1, 0.14, kReason);
  const Scatter held = ScatterOfFits(1000, kRateHz / 4, false);
  EXPECT_ABS(held.frequency_ratio, 1, 0.14, kReason);
  EXPECT_ABS(held.amplitude_ratio, 1, 0.14, kReason);
}

// The Fisher information of A cos(w t + p) + o + s t, t over T about its middle, white noise of
// deviation d, many periods: its blocks for A, (w, p at the middle), o and s do not mix;
// N/2, A^2 N/2 (T^2/12 for w, 1 for p), N, N T^2/12, each over d^2.
TEST(SineFit, UncertaintiesAreCramerAndRaosBound) {
  constexpr std::size_t kCount = 5000;
  std::vector<double> signal = Samples(kRateHz, kCount, 0, {{1, 300, 0}});
  Noise noise(3);
  for (double& x : signal) x += 0.1 * noise();
  for (const int degree : {0, 1}) {
    const SineFit fit = FitSine(signal, {kRateHz, 0, degree}, 300);
    const double s = fit.residual_rms * std::sqrt(kCount / fit.degrees_of_freedom);
    const double duration_s = kCount / kRateHz;
    constexpr const char* kReason = "columns mix by 1/(pi periods) squared, and N - 1 for N";
    EXPECT_EQ(fit.degrees_of_freedom, static_cast<double>(kCount - 4) - degree);
    EXPECT_REL(fit.amplitude_uncertainty, s * std::sqrt(2.0 / kCount), 4e-4, kReason);
    EXPECT_REL(2 * kPi * fit.frequency_uncertainty_hz,
               s / fit.amplitude * std::sqrt(24.0 / kCount) / duration_s, 4e-4, kReason);
    EXPECT_REL(fit.phase_uncertainty_rad, s / fit.amplitude * std::sqrt(8.0 / kCount), 4e-4,
               kReason);
  }
}

TEST(SineFit, DriftIsFittedAlong) {
  // a cubic of 1 mm over the record, Legendre-orthogonal on [-1, 1]: mean by hand
  constexpr std::size_t kCount = 3001;
  std::vector<double> signal = Samples(kRateHz, kCount, 0.03, {{2e-6, 225, 0.3}});
  for (std::size_t k = 0; k < kCount; ++k) {
    const double tau = static_cast<double>(k) / 1500 - 1;
    signal[k] += 1e-3 * (tau + 0.5 * tau * tau - tau * tau * tau);
  }
  const SineFit fit = FitSine(signal, {kRateHz, 0, 3}, 225.5);
  ASSERT_TRUE(fit.converged);
  EXPECT_REL(fit.amplitude, 2e-6, 1e-12, "the input's rounding at 30 mm");
  EXPECT_REL(fit.frequency_hz, 225, 1e-13, "the same");
  EXPECT_REL(fit.offset, 0.03 + 1e-3 / 6, 1e-14, "tau^2 = 1/3 + (2/3) P2");
  const SineFit without = FitSine(signal, {kRateHz, 0, 0}, 225.5);
  EXPECT_GT(std::abs(without.amplitude - 2e-6), 1e-7) << "an offset alone is not enough";
}

TEST(SineFit, UnevenTimesBeyondHalfTheRate) {
  // 48 readings/s of a 225 Hz drive, each taken within its period at a known time
  std::vector<double> times_s(200);
  std::vector<double> values(times_s.size());
  Noise noise(11);
  for (std::size_t k = 0; k < times_s.size(); ++k) {
    times_s[k] = 17.0 + (static_cast<double>(k) + 0.2 * noise()) / 48;
    const double t_s = times_s[k] - 19;
    values[k] = 0.03 + 1e-4 * t_s + 5e-6 * std::cos(2 * kPi * 225 * times_s[k] + 1.2);
  }
  const SineFit fit = FitSineAtTimes(values, times_s, 225, 1);
  ASSERT_TRUE(fit.converged);
  EXPECT_REL(fit.amplitude, 5e-6, 1e-11, "phases of 3e4 rad, rounded to 4e-12, and 30 mm");
  EXPECT_ABS(fit.phase_rad, 1.2, 1e-10, "the same over sqrt(N), at t = 0, 17 s before");
  EXPECT_FALSE(FitSineAtTimes(values, times_s, 225, 1).amplitude_uncertainty > 1e-15);
}

TEST(SineFit, TimesThatSeeOnePhaseAreRefused) {
  std::vector<double> times_s(40);
  for (std::size_t k = 0; k < times_s.size(); ++k) times_s[k] = static_cast<double>(k) / 45;
  const std::vector<double> values(times_s.size(), 1.0);
  EXPECT_FALSE(FitSineAtTimes(values, times_s, 225).converged) << "225 Hz is five times 45 Hz";
  EXPECT_TRUE(FitSineAtTimes(values, times_s, 226).converged);
  EXPECT_FALSE(
      FitSineAtTimes(std::vector<double>(3, 1.0), std::vector<double>{1, 2, 3}, 0.5).converged)
      << "three values for three parameters";
}

// how often the 95 % interval of each quantity holds the truth, of 2000
struct Coverage {
  int amplitude = 0;
  int frequency = 0;
  int phase = 0;
};

void Count(const SineFit& fit, double t, Coverage& held) {
  const double truth_phase = 0.5;
  held.amplitude += std::abs(fit.amplitude - 1) <= t * fit.amplitude_uncertainty ? 1 : 0;
  held.frequency += std::abs(fit.frequency_hz - 1003) <= t * fit.frequency_uncertainty_hz ? 1 : 0;
  held.phase += std::abs(fit.phase_rad - truth_phase) <= t * fit.phase_uncertainty_rad ? 1 : 0;
}

constexpr int kRepetitions = 2000;
// of 2000, 95 % +- 2 %: four deviations of the count
constexpr int kLeast = 1860;
constexpr int kMost = 1940;

void ExpectCoverage(int held, const char* what) {
  EXPECT_GE(held, kLeast) << what;
  EXPECT_LE(held, kMost) << what;
}

TEST(SineFit, IntervalsOfAFitWithDriftHoldTheTruth) {
  constexpr std::size_t kCount = 65;
  constexpr double kT60 = 2.0002978;  // Student's t, 97.5 %, 60 degrees of freedom
  const double middle_s = 0.5 * (kCount - 1) / kRateHz;
  Noise noise(42);
  Coverage held;
  for (int r = 0; r < kRepetitions; ++r) {
    std::vector<double> signal =
        Samples(kRateHz, kCount, 0.2 - 3 * middle_s, {{1, 1003, 0.5 + kPi / 2}});
    for (std::size_t k = 0; k < kCount; ++k) {
      signal[k] += 3 * static_cast<double>(k) / kRateHz + 0.1 * noise();
    }
    Count(FitSine(signal, {kRateHz, 0, 1}, 1000), kT60, held);
  }
  ExpectCoverage(held.amplitude, "amplitude");
  ExpectCoverage(held.frequency, "frequency");
  ExpectCoverage(held.phase, "phase");
}

TEST(SineFit, IntervalsOfAFitAtUnevenTimesHoldTheTruth) {
  constexpr std::size_t kCount = 15;
  constexpr double kT10 = 2.2281389;  // Student's t, 97.5 %, 10 degrees of freedom
  Noise noise(43);
  Coverage held;
  std::vector<double> times_s(kCount);
  std::vector<double> values(kCount);
  for (int r = 0; r < kRepetitions; ++r) {
    for (std::size_t k = 0; k < kCount; ++k) {
      times_s[k] = (static_cast<double>(k) - 7 + 0.3 * noise()) / 480;
    }
    const auto [first, last] = std::minmax_element(times_s.begin(), times_s.end());
    const double middle_s = 0.5 * (*first + *last);
    for (std::size_t k = 0; k < kCount; ++k) {
      values[k] = 0.2 + 3 * (times_s[k] - middle_s) + std::cos(2 * kPi * 1003 * times_s[k] + 0.5) +
                  0.05 * noise();
    }
    Count(FitSineAtTimes(values, times_s, 1003, 1), kT10, held);
  }
  ExpectCoverage(held.amplitude, "amplitude");
  ExpectCoverage(held.phase, "phase");
}

TEST(SineFit, ADecayingToneComesToRest) {
  // a quarter of its duration per decay: the nearest sine is less, and its residual is no noise
  std::vector<double> signal(20'000);
  for (std::size_t k = 0; k < signal.size(); ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    signal[k] = std::exp(-t_s / 0.5) * std::cos(2 * kPi * 439.15 * t_s + 1);
  }
  const SineFit fit = FitSine(signal, {kRateHz, 0}, 439.3);
  ASSERT_TRUE(fit.converged);
  EXPECT_ABS(fit.frequency_hz, 439.15, 1e-3,
             "half a thousandth of 1/duration: the other side lobe");
}

TEST(SineFit, NothingFiniteNothingSaid) {
  std::vector<double> signal = Samples(kRateHz, 2000, 0, {{1, 300, 0}});
  signal[700] = std::nan("");
  EXPECT_FALSE(FitSine(signal, {kRateHz, 0}, 300).converged);
  EXPECT_FALSE(FitSineAt(signal, {kRateHz, 0, 1}, 300).converged);
  const SineFit rest = FitSineAt(std::vector<double>(2000, 0.03), {kRateHz, 0}, 300);
  EXPECT_TRUE(rest.converged);
  EXPECT_EQ(rest.amplitude, 0);
  EXPECT_TRUE(std::isnan(rest.phase_uncertainty_rad));
}

// the tone of 250 Hz, an offset and a tone of whole periods that shares nothing with them: u of the
// amplitude is b / sqrt(degrees of freedom), of a phase at a known frequency that over the
// amplitude
TEST(SineFit, UncertaintiesAtAKnownFrequencyAreTheClosedForm) {
  const std::vector<double> signal = Samples(kRateHz, 1000, 0.03, {{2, 250, 0.3}, {0.1, 700, 1}});
  struct Case {
    double noise_bandwidth_hz;
    double freedom;
  };
  for (const Case& one : {Case{0, 997}, Case{5000, 997}, Case{1250, 247}}) {
    const SineFit fit = FitSineAt(signal, {kRateHz, one.noise_bandwidth_hz}, 250);
    ASSERT_TRUE(fit.converged);
    constexpr const char* kReason = "rounding of sums over whole periods";
    EXPECT_EQ(fit.degrees_of_freedom, one.freedom);
    EXPECT_REL(fit.residual_rms, 0.1 / std::numbers::sqrt2, 1e-12, kReason);
    EXPECT_REL(fit.amplitude_uncertainty, 0.1 / std::sqrt(one.freedom), 1e-11, kReason);
    EXPECT_REL(fit.phase_uncertainty_rad, 0.05 / std::sqrt(one.freedom), 1e-11, kReason);
  }
}

// more independent samples than parameters: 3 + degree at a known frequency, one more at a free one
TEST(SineFit, NeedsMoreSamplesThanParameters) {
  for (const int degree : {0, 1, 2, 3}) {
    const auto least = static_cast<std::size_t>(4 + degree);
    const std::vector<double> signal = Samples(kRateHz, least + 1, 0, {{1, 2250, 0.3}});
    const SineFitOptions options{kRateHz, 0, degree};
    EXPECT_FALSE(FitSineAt(std::span(signal).first(least - 1), options, 2250).converged) << degree;
    EXPECT_TRUE(FitSineAt(std::span(signal).first(least), options, 2250).converged) << degree;
    EXPECT_FALSE(FitSine(std::span(signal).first(least), options, 2250).converged) << degree;
    EXPECT_TRUE(FitSine(signal, options, 2250).converged) << degree;
  }
  // in a band of a quarter of the rate every second sample is independent
  const std::vector<double> signal = Samples(kRateHz, 7, 0, {{1, 2250, 0.3}});
  const SineFitOptions half{kRateHz, kRateHz / 4};
  EXPECT_FALSE(FitSineAt(std::span(signal).first(6), half, 2250).converged);
  EXPECT_TRUE(FitSineAt(signal, half, 2250).converged);
}

TEST(SineFit, NeedsHalfAPeriod) {
  const std::vector<double> signal = Samples(kRateHz, 20, 0, {{1, 250, 0.3}});
  EXPECT_TRUE(FitSineAt(signal, {kRateHz}, 250).converged);
  EXPECT_FALSE(FitSineAt(signal, {kRateHz}, 249).converged);
  std::vector<double> times_s(20);
  for (std::size_t k = 0; k < times_s.size(); ++k) times_s[k] = static_cast<double>(k) / 19;
  EXPECT_TRUE(FitSineAtTimes(signal, times_s, 0.5).converged);
  EXPECT_FALSE(FitSineAtTimes(signal, times_s, 0.499).converged);
}

// the same samples at even times: the same fit, its phase at t = 0
TEST(SineFit, AtEvenTimesIsTheFitOfEvenSamples) {
  const std::vector<double> signal = Samples(kRateHz, 500, 0.03, {{2, 251.3, 0.3}, {0.1, 700, 1}});
  std::vector<double> times_s(signal.size());
  for (std::size_t k = 0; k < times_s.size(); ++k) {
    times_s[k] = 0.01 + static_cast<double>(k) / kRateHz;
  }
  const SineFit even = FitSineAt(signal, {kRateHz, 0, 2}, 251.3);
  const SineFit timed = FitSineAtTimes(signal, times_s, 251.3, 2);
  ASSERT_TRUE(even.converged && timed.converged);
  constexpr const char* kReason = "rounding of times";
  EXPECT_REL(timed.amplitude, even.amplitude, 1e-12, kReason);
  EXPECT_REL(timed.amplitude_uncertainty, even.amplitude_uncertainty, 1e-10, kReason);
  EXPECT_REL(timed.phase_uncertainty_rad, even.phase_uncertainty_rad, 1e-10, kReason);
  EXPECT_REL(timed.residual_rms, even.residual_rms, 1e-10, kReason);
  EXPECT_REL(timed.offset, even.offset, 1e-10, kReason);
  EXPECT_EQ(timed.degrees_of_freedom, even.degrees_of_freedom);
  const double turned = timed.phase_rad - even.phase_rad + 2 * kPi * 251.3 * 0.01;
  EXPECT_ABS(std::remainder(turned, 2 * kPi), 0, 1e-11, "rounding of phases of 80 rad");
}

TEST(PhasorBlocks, AreCosineAndSineOfEveryBlock) {
  const PhasorBlocks phasors(0.37);
  std::vector<double> cosines(PhasorBlocks::kBlock);
  std::vector<double> sines(PhasorBlocks::kBlock);
  for (const double first : {0.0, -300.5, 1e6}) {
    phasors.Fill(first, cosines, sines);
    for (std::size_t k = 0; k < cosines.size(); ++k) {
      const double angle = 0.37 * (first + static_cast<double>(k));
      EXPECT_ABS(cosines[k], std::cos(angle), 1e-10, "rounding of 4e5 rad");
      EXPECT_ABS(sines[k], std::sin(angle), 1e-10, "rounding of 4e5 rad");
    }
  }
}

// from starts up to half a bin, 1 / duration, beside it
TEST(SineFit, OfASineAloneConvergesFromEverySideOfIt) {
  for (std::size_t count = 200; count < 240; ++count) {
    const double bin_hz = kRateHz / static_cast<double>(count);
    const std::vector<double> signal = Samples(kRateHz, count, 0, {{2e-6, 1234.5, 0.3}});
    for (const double bins : {-0.4, -0.1, 0.0, 0.2, 0.5}) {
      const SineFit fit = FitSine(signal, {kRateHz, 0}, 1234.5 + bins * bin_hz);
      ASSERT_TRUE(fit.converged) << count << ' ' << bins;
      EXPECT_REL(fit.frequency_hz, 1234.5, 1e-12, "rounding of phases of 2e2 rad");
    }
  }
}

TEST(SineFitDeathTest, RatesDegreesAndSizesAreChecked) {
  const std::vector<double> signal = Samples(kRateHz, 1000, 0, {{1, 100, 0.3}});
  EXPECT_DEATH(static_cast<void>(FitSineAt(signal, {0, 0}, 100)), "check failed");
  EXPECT_DEATH(static_cast<void>(FitSineAt(signal, {kRateHz, 0, -1}, 100)), "check failed");
  EXPECT_DEATH(static_cast<void>(FitSine(signal, {kRateHz, 0, kHighestDriftDegree + 1}, 100)),
               "check failed");
  EXPECT_DEATH(static_cast<void>(FitSineAtTimes(signal, std::span(signal).first(999), 100)),
               "check failed");
  const PhasorBlocks phasors(0.1);
  std::vector<double> cosines(PhasorBlocks::kBlock + 1);
  std::vector<double> sines(PhasorBlocks::kBlock + 1);
  EXPECT_DEATH(phasors.Fill(0, cosines, sines), "check failed");
  EXPECT_DEATH(phasors.Fill(0, std::span(cosines).first(9), std::span(sines).first(10)),
               "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
