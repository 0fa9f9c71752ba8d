// A tone of known frequency in records too slow for the band, through AnalyzeBand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kDriveHz = 225;

// 3 s of 10 um at 225 Hz, a slope and 0.2 um of noise, at 400/s
trial::Record Slow() {
  std::vector<double> values = Samples(400, 1200, 0.03, {{1e-5, kDriveHz, 0.4}});
  Noise noise(2);
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] += 2e-7 * noise() + 1e-8 * static_cast<double>(k);
  }
  trial::Record record = RecordOf(values, 400);
  record.timing = trial::Timing::kArrival;
  record.stretches[0].time_uncertainty_s = 5e-5;
  record.metadata.drive_frequency_hz = kDriveHz;
  return record;
}

TEST(SlowRecord, AFreeRunningOneHasItsDrivesTone) {
  const BandAnalysis analysis = Answer(Slow());
  EXPECT_FALSE(analysis.answered) << "no answer for the band";
  EXPECT_EQ(NumberOf(analysis.findings, FindingKind::kTooFewReadings, "new_readings_per_s"), 400);
  ASSERT_TRUE(analysis.known_tone);
  EXPECT_TRUE(analysis.known_tone->aliased) << "225 Hz are seen as 175 Hz";
  const SineFit& fit = analysis.known_tone->fit;
  EXPECT_EQ(fit.frequency_hz, kDriveHz);
  EXPECT_REL(fit.amplitude_uncertainty, 2e-7 * std::sqrt(2.0 / 1200), 0.1, "1200 values of noise");
  EXPECT_ABS(fit.amplitude, 1e-5, 3 * fit.amplitude_uncertainty, "noise");
  EXPECT_EQ(analysis.findings.list().back().kind, FindingKind::kKnownToneAlias);
  EXPECT_EQ(NumberOf(analysis.findings.list().back(), "amplitude_m"), fit.amplitude);
}

TEST(SlowRecord, AGatedDriveIsFittedWhereItIsOn) {
  trial::Record record = Slow();
  Noise noise(3);
  for (std::size_t k = 0; k < record.rows; ++k) {
    if (k < 300 || k >= 900) record.channels[0].values[k] = 0.03 + 2e-7 * noise();
  }
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.known_tone);
  const SineFit& fit = analysis.known_tone->fit;
  EXPECT_ABS(fit.amplitude, 1e-5, 3 * fit.amplitude_uncertainty, "noise; 5 um over all of it");
  const Finding pauses = FirstOf(analysis.findings, FindingKind::kKnownTonePauses);
  // readings 306 to 899 lie in blocks of 18 that are on; their first and last are left out
  EXPECT_ABS(NumberOf(pauses, "from_s"), 18 * 18 / 400.0, 1e-12, "rounding");
  EXPECT_ABS(NumberOf(pauses, "to_s"), (49 * 18 - 1) / 400.0, 1e-12, "rounding");
}

// on from the record's begin: nothing is left out there
TEST(SlowRecord, ADriveThatEndsIsFittedFromTheFirstReadingOn) {
  trial::Record record = Slow();
  Noise noise(3);
  for (std::size_t k = 900; k < record.rows; ++k) {
    record.channels[0].values[k] = 0.03 + 2e-7 * noise();
  }
  const BandAnalysis analysis = Answer(record);
  const Finding pauses = FirstOf(analysis.findings, FindingKind::kKnownTonePauses);
  EXPECT_EQ(NumberOf(pauses, "from_s"), 0);
  EXPECT_ABS(NumberOf(pauses, "to_s"), (49 * 18 - 1) / 400.0, 1e-12, "rounding");
  // a first block that is off is a pause, too
  for (std::size_t k = 0; k < 18; ++k) record.channels[0].values[k] = 0.03 + 2e-7 * noise();
  const BandAnalysis later = Answer(record);
  EXPECT_ABS(NumberOf(FirstOf(later.findings, FindingKind::kKnownTonePauses), "from_s"),
             2 * 18 / 400.0, 1e-12, "rounding");
}

TEST(SlowRecord, TheQuestionsDriveComesBeforeTheFiles) {
  BandQuestion question;
  question.drive_frequency_hz = 40;
  const BandAnalysis analysis = Answer(Slow(), question);
  ASSERT_TRUE(analysis.known_tone);
  EXPECT_FALSE(analysis.known_tone->aliased);
  EXPECT_LT(analysis.known_tone->fit.amplitude, 1e-6) << "nothing moves there";
}

TEST(SlowRecord, APolledOneIsRefused) {
  trial::Record record = Slow();
  record.timing = trial::Timing::kPolled;
  const BandAnalysis analysis = Answer(record);
  EXPECT_FALSE(analysis.known_tone);
  EXPECT_TRUE(analysis.findings.Has(FindingKind::kPolledTimes));
}

TEST(SlowRecord, TimesOfATenthOfAPeriodAreRefused) {
  trial::Record record = Slow();
  record.stretches[0].time_uncertainty_s = 5e-4;
  const BandAnalysis analysis = Answer(record);
  EXPECT_FALSE(analysis.known_tone);
  const Finding unfit = FirstOf(analysis.findings, FindingKind::kTimesUnfitForTone);
  EXPECT_EQ(NumberOf(unfit, "time_uncertainty_s"), 5e-4);
  EXPECT_EQ(NumberOf(unfit, "frequency_hz"), kDriveHz);
}

TEST(SlowRecord, KnownTimesThatLieOnNoGridAreFittedAsTheyAre) {
  trial::Record record = Slow();
  record.timing = trial::Timing::kPolled;
  record.times_are_known = true;
  Noise noise(4);
  for (std::size_t k = 0; k < record.rows; ++k) {
    const double t_s = (static_cast<double>(k) + 0.3 * noise()) / 400;
    record.raw_times_s.push_back(t_s);
    record.channels[0].values[k] = 0.03 + 1e-5 * std::sin(2 * std::numbers::pi * kDriveHz * t_s);
  }
  const BandAnalysis analysis = Answer(record);
  EXPECT_FALSE(analysis.answered);
  ASSERT_TRUE(analysis.known_tone);
  EXPECT_REL(analysis.known_tone->fit.amplitude, 1e-5, 1e-9, "no noise");
}

TEST(SlowRecord, ATonePerSampleIsNotToldFromTheOffset) {
  BandQuestion question;
  question.drive_frequency_hz = 400;
  const BandAnalysis analysis = Answer(Slow(), question);
  EXPECT_FALSE(analysis.known_tone);
  EXPECT_EQ(analysis.findings.list().back().kind, FindingKind::kKnownToneAtRate);
}

}  // namespace
}  // namespace haptometer::dsp
