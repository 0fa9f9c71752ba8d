// How often the stated 95 % intervals of tone and RMS hold the truth, through AnalyzeBand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;
constexpr double kToneHz = 150.37;
constexpr double kNoiseM = 1e-6;

bool Holds(double lower, double value, double upper) { return lower <= value && value <= upper; }

TEST(IntervalCoverage, OfAToneInNoise) {
  const FilterDesign design = Designed({}, kRateHz);
  const int repetitions = Repetitions(tests::kIsSanitized ? 15 : 40);
  for (const double amplitude_m : {0.5e-6, 4e-6}) {
    const double passed = amplitude_m * std::norm(Response(design, kToneHz));
    const double rms_m = passed / std::numbers::sqrt2;
    int answered = 0;
    int amplitudes = 0;
    int frequencies = 0;
    int sizes = 0;
    for (int seed = 1; seed <= repetitions; ++seed) {
      Noise noise(static_cast<std::uint64_t>(seed));
      std::vector<double> values =
          Samples(kRateHz, 3000, 0.03, {{amplitude_m, kToneHz, 0.37 * seed}});
      for (double& value : values) value += kNoiseM * noise();
      BandQuestion question;
      question.keep_filtered = false;
      const auto analysis = AnalyzeBand(RecordOf(values, kRateHz), question);
      if (!analysis || !analysis->answered || !analysis->numbers->tone) continue;
      ++answered;
      const ToneNumbers& tone = *analysis->numbers->tone;
      const RmsEstimate& rms = analysis->numbers->rms;
      amplitudes += Holds(tone.amplitude_lower_m, amplitude_m, tone.amplitude_upper_m) ? 1 : 0;
      frequencies += Holds(tone.frequency_lower_hz, kToneHz, tone.frequency_upper_hz) ? 1 : 0;
      sizes += Holds(rms.lower_m, rms_m, rms.upper_m) ? 1 : 0;
    }
    // of the weak ones, 0.3 of the noise in the band, 2 of 1000 are refused
    EXPECT_GE(answered, 0.95 * repetitions);
    ExpectCoverage("amplitude", amplitudes, answered);
    ExpectCoverage("frequency", frequencies, answered);
    ExpectCoverage("band RMS", sizes, answered);
  }
}

// Noise of 0.3 steps leaves a sixth of what rounding does to a sine: up to 0.9 % of 2 steps. Its
// estimate from one part of the band scattered by 18 %, and 1 interval of 5 missed.
TEST(IntervalCoverage, OfAFewStepsInLessNoiseThanSmoothsThem) {
  constexpr double kStep = 1e-6;
  constexpr double kRateOfSteps = 10e3;
  const FilterDesign design = Designed({}, kRateOfSteps);
  const int repetitions = Repetitions(tests::kIsSanitized ? 15 : 40);
  for (const double steps : {2.0, 3.0}) {
    int answered = 0;
    int sizes = 0;
    for (int seed = 1; seed <= repetitions; ++seed) {
      Noise noise(static_cast<std::uint64_t>(seed));
      // frequencies from 85 to 300 Hz, and any place between two steps
      const double tone_hz = 85 + std::fmod(37.31 * seed, 215);
      const double offset_m = std::fmod(0.618 * seed, 1) * kStep;
      std::vector<double> values =
          Samples(kRateOfSteps, 20'000, offset_m, {{steps * kStep, tone_hz, 0.37 * seed}});
      for (double& value : values) value = std::round(value / kStep + 0.3 * noise()) * kStep;
      const auto analysis = AnalyzeBand(RecordOf(values, kRateOfSteps), {});
      if (!analysis || !analysis->answered) continue;
      ++answered;
      const double rms_m =
          steps * kStep * std::norm(Response(design, tone_hz)) / std::numbers::sqrt2;
      const RmsEstimate& rms = analysis->numbers->rms;
      sizes += Holds(rms.lower_m, rms_m, rms.upper_m) ? 1 : 0;
    }
    EXPECT_GE(answered, 0.9 * repetitions) << steps;
    std::printf("[coverage] band RMS of %g steps: %d of %d\n", steps, sizes, answered);
    // 1.96 standard deviations of a rectangle hold its whole half width, so a bound holds always
    // but where the noise in it is misjudged: 1 of 40. By one part of the band 37 and 38 held.
    EXPECT_GE(sizes, 0.975 * answered) << steps;
  }
}

// A sensor whose gain is off by a normal error of 2 %, several times what noise adds here.
// Ten periods are left of 0.645 s: the ranges about the drive and its harmonics, 41 Hz to either
// side, cover the whole band. The noise was taken for nothing then, and one interval of eight
// missed by up to 300 standard uncertainties. Found by search_hard_cases.
TEST(IntervalCoverage, OfAWindowThatTheDrivesRangesCover) {
  constexpr double kShortHz = 82.97;
  constexpr double kRateOfShortHz = 7456;
  const FilterDesign design = Designed({.order = 5}, kRateOfShortHz);
  const int repetitions = Repetitions(tests::kIsSanitized ? 15 : 60);
  const double rms_m = 1e-8 * std::norm(Response(design, kShortHz)) / std::numbers::sqrt2;
  int answered = 0;
  int sizes = 0;
  double least_m = 1;  // standard uncertainty
  for (int seed = 1; seed <= repetitions; ++seed) {
    Noise noise(static_cast<std::uint64_t>(seed));
    std::vector<double> values =
        Samples(kRateOfShortHz, 4808, 1e-6, {{1e-8, kShortHz, 0.37 * seed}});
    for (double& value : values) value += 0.72e-8 * noise();
    const auto analysis = AnalyzeBand(RecordOf(values, kRateOfShortHz), {});
    if (!analysis || !analysis->answered) continue;
    ++answered;
    const RmsEstimate& rms = analysis->numbers->rms;
    sizes += Holds(rms.lower_m, rms_m, rms.upper_m) ? 1 : 0;
    least_m = std::min(least_m, rms.standard_uncertainty_m);
  }
  EXPECT_GE(answered, 0.9 * repetitions);
  ExpectCoverage("band RMS of a short window", sizes, answered);
  // noise of density S beside a sine: u(rms) = sqrt(S / (2 T)), of 0.12 s; half of it for its
  // scatter
  const double density = 0.72e-8 * 0.72e-8 / (kRateOfShortHz / 2);
  EXPECT_GT(least_m, 0.5 * std::sqrt(density / (2 * 0.12)));
}

TEST(IntervalCoverage, OfAToneByASensorWithAnUncertainGain) {
  constexpr double kGain = 0.02;
  constexpr double kAmplitudeM = 20e-6;
  const double rms_m =
      kAmplitudeM * std::norm(Response(Designed({}, kRateHz), kToneHz)) / std::numbers::sqrt2;
  const int repetitions = Repetitions(tests::kIsSanitized ? 15 : 60);
  BandQuestion question;
  question.keep_filtered = false;
  question.gain_uncertainty = kGain;
  int amplitudes = 0;
  int sizes = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    Noise noise(static_cast<std::uint64_t>(seed));
    const double gain = 1 + kGain * noise();
    std::vector<double> values =
        Samples(kRateHz, 3000, 0.03, {{kAmplitudeM, kToneHz, 0.37 * seed}});
    for (double& value : values) value = gain * (value + kNoiseM * noise());
    const auto analysis = AnalyzeBand(RecordOf(values, kRateHz), question);
    ASSERT_TRUE(analysis && analysis->answered && analysis->numbers->tone);
    const ToneNumbers& tone = *analysis->numbers->tone;
    const RmsEstimate& rms = analysis->numbers->rms;
    amplitudes += Holds(tone.amplitude_lower_m, kAmplitudeM, tone.amplitude_upper_m) ? 1 : 0;
    sizes += Holds(rms.lower_m, rms_m, rms.upper_m) ? 1 : 0;
    EXPECT_GT(rms.standard_uncertainty_m, kGain * rms.rms_m);
    // a wide gain is not a weak drive: no doubt of the drive by it
    EXPECT_FALSE(analysis->findings.Has(FindingKind::kWideInterval));
  }
  ExpectCoverage("amplitude, gain of 2 %", amplitudes, repetitions);
  ExpectCoverage("band RMS, gain of 2 %", sizes, repetitions);
}

// The record's own calibration counts where nothing is asked; what is asked replaces it.
TEST(IntervalCoverage, TheGainIsThatOfTheRecordUnlessAsked) {
  trial::Record record = RecordOf(Samples(kRateHz, 3000, 0.03, {{20e-6, kToneHz, 0.4}}), kRateHz);
  const BandAnalysis plain = Answer(record);
  EXPECT_FALSE(plain.gain_uncertainty);
  record.metadata.fields["calibration.displacement.relative_standard_uncertainty"] = "0.002";
  const BandAnalysis stated = Answer(record);
  EXPECT_EQ(stated.gain_uncertainty, 0.002);
  EXPECT_TRUE(stated.findings.Has(FindingKind::kCalibrationIncluded));
  EXPECT_FALSE(stated.findings.Has(FindingKind::kCalibrationReplaced));
  BandQuestion question;
  question.gain_uncertainty = 0.01;
  const BandAnalysis asked = Answer(record, question);
  EXPECT_EQ(asked.gain_uncertainty, 0.01);
  EXPECT_TRUE(asked.findings.Has(FindingKind::kCalibrationReplaced));
  for (const auto& [analysis, relative] : {std::pair(&stated, 0.002), std::pair(&asked, 0.01)}) {
    const double rms_m = plain.numbers->rms.rms_m;
    EXPECT_NEAR(analysis->numbers->rms.standard_uncertainty_m,
                std::hypot(plain.numbers->rms.standard_uncertainty_m, relative * rms_m),
                1e-12 * rms_m);
  }
  record.metadata.fields["calibration.displacement.relative_standard_uncertainty"] = "small";
  EXPECT_FALSE(AnalyzeBand(record, {}));
}

}  // namespace
}  // namespace haptometer::dsp
