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

// on from 306 to the record's end: its last block counts, too
TEST(SlowRecord, ADriveThatBeginsIsFittedToTheLastReading) {
  trial::Record record = Slow();
  Noise noise(3);
  for (std::size_t k = 0; k < 300; ++k) record.channels[0].values[k] = 0.03 + 2e-7 * noise();
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.known_tone);
  EXPECT_ABS(analysis.known_tone->fit.amplitude, 1e-5,
             3 * analysis.known_tone->fit.amplitude_uncertainty, "noise");
  const Finding pauses = FirstOf(analysis.findings, FindingKind::kKnownTonePauses);
  EXPECT_EQ(NumberOf(pauses, "frequency_hz"), kDriveHz);
  // blocks of 18 readings: 16 holds the begin, 17 is left out beside it
  EXPECT_ABS(NumberOf(pauses, "from_s"), 18 * 18 / 400.0, 1e-12, "rounding");
  EXPECT_ABS(NumberOf(pauses, "to_s"), 1199 / 400.0, 1e-12, "the last reading, in no whole block");
}

// 0.1 / 225 s are 0.4444 ms.
TEST(SlowRecord, TimesAreNeededToATenthOfAPeriod) {
  for (const double uncertainty_s : {0.443e-3, 0.446e-3}) {
    trial::Record record = Slow();
    record.stretches[0].time_uncertainty_s = uncertainty_s;
    const BandAnalysis analysis = Answer(record);
    EXPECT_EQ(analysis.known_tone.has_value(), uncertainty_s < 0.1 / kDriveHz) << uncertainty_s;
    if (analysis.known_tone) continue;
    EXPECT_REL(NumberOf(analysis.findings, FindingKind::kTimesUnfitForTone, "limit_s"),
               0.1 / kDriveHz, 1e-15, "a tenth of a period");
  }
}

// 10 um at `true_hz` in 3 s, of which the drive is said to be at 150 Hz
BandAnalysis Elsewhere(double true_hz, double noise_m) {
  std::vector<double> values = Samples(400, 1200, 0.03, {{1e-5, true_hz, 0.4}});
  Noise noise(2);
  for (double& value : values) value += noise_m * noise();
  trial::Record record = RecordOf(std::move(values), 400);
  record.metadata.drive_frequency_hz = 150;
  return Answer(record);
}

// 2.5 bins of 1 / 3 s away, on the grid of quarters of a bin
TEST(SlowRecord, AToneNearbyThatExplainsMoreIsADoubt) {
  const double bin_hz = 400.0 / 1199;
  const BandAnalysis analysis = Elsewhere(150 + 2.5 * bin_hz, 2e-7);
  ASSERT_TRUE(analysis.known_tone);
  EXPECT_FALSE(analysis.known_tone->aliased);
  const Finding doubt = FirstOf(analysis.findings, FindingKind::kKnownToneElsewhere);
  EXPECT_EQ(doubt.severity, Severity::kDoubt);
  EXPECT_EQ(NumberOf(doubt, "frequency_hz"), 150);
  EXPECT_REL(NumberOf(doubt, "better_hz"), 150 + 2.5 * bin_hz, 1e-12, "rounding");
  EXPECT_REL(NumberOf(doubt, "amplitude_m"), 1e-5, 3e-3, "noise of 8 nm, four times");
  // the interval reaches from one to the other, 3 % more for a tone between the frequencies tried
  const SineFit& fit = analysis.known_tone->fit;
  const double apart_m = 1.03 * NumberOf(doubt, "amplitude_m") - fit.amplitude;
  EXPECT_REL(fit.amplitude_uncertainty, apart_m / 1.96, 0.02, "and the fit's own in squares");
  EXPECT_LT(fit.amplitude, 0.3e-5) << "side lobe of 1 / (2.5 pi), and the line's";
  // ten bins away it is seen, eleven away it is not
  EXPECT_TRUE(Elsewhere(150 + 10 * bin_hz, 2e-7).findings.Has(FindingKind::kKnownToneElsewhere));
  EXPECT_FALSE(Elsewhere(150 + 11 * bin_hz, 2e-7).findings.Has(FindingKind::kKnownToneElsewhere));
  EXPECT_FALSE(Elsewhere(150, 2e-7).findings.Has(FindingKind::kKnownToneElsewhere));
}

// bursts of 39 and of 40 readings with pauses of nine times their length, in which 10 um, 2.5 bins
// of a burst from the stated 150 Hz, gain 25 turns on that
TEST(SlowRecord, AToneIsNotSoughtInAFewReadings) {
  for (const std::size_t burst : {std::size_t{39}, std::size_t{40}}) {
    const double bin_hz = 400 / static_cast<double>(burst - 1);
    trial::Record record = RecordOf(std::vector<double>(30 * burst), 400);
    record.metadata.drive_frequency_hz = 150;
    record.stretches.clear();
    for (std::size_t k = 0; k < 30; ++k) {
      record.stretches.push_back({k * burst, burst, static_cast<double>(k) * 10 / bin_hz, 400, 0});
    }
    for (std::size_t k = 0; k < record.rows; ++k) {
      const double turns = (150 + 2.5 * bin_hz) * trial::TimeOf(record, k);
      record.channels[0].values[k] = 0.03 + 1e-5 * std::sin(2 * std::numbers::pi * turns);
    }
    const BandAnalysis analysis = Answer(record);
    ASSERT_TRUE(analysis.known_tone) << burst;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kKnownToneElsewhere), burst == 40) << burst;
  }
}

// Above half the rate of new readings, 200 Hz.
TEST(SlowRecord, ATonesAliasIsSaidAboveHalfTheRate) {
  for (const double frequency_hz : {199.0, 201.0}) {
    trial::Record record = RecordOf(Samples(400, 1200, 0.03, {{1e-5, frequency_hz, 0.4}}), 400);
    record.metadata.drive_frequency_hz = frequency_hz;
    const BandAnalysis analysis = Answer(record);
    ASSERT_TRUE(analysis.known_tone) << frequency_hz;
    EXPECT_EQ(analysis.known_tone->aliased, frequency_hz > 200);
    EXPECT_EQ(analysis.findings.Has(FindingKind::kKnownToneAlias), frequency_hz > 200);
    EXPECT_EQ(analysis.findings.Has(FindingKind::kKnownTone), frequency_hz < 200);
  }
}

// 20 000 readings in parts, with pauses of minutes behind each, in which a tone of 10 um that is
// `beside_hz` from the stated 150 Hz gains 60 turns on that
BandAnalysis WithPauses(const std::vector<std::size_t>& parts, double beside_hz) {
  trial::Record record = RecordOf(std::vector<double>(20'000), 400);
  record.metadata.drive_frequency_hz = 150;
  record.stretches.clear();
  std::size_t first = 0;
  double pauses_s = 0;
  for (const std::size_t rows : parts) {
    record.stretches.push_back({first, rows, static_cast<double>(first) / 400 + pauses_s, 400, 0});
    first += rows;
    pauses_s += 60 / beside_hz;
  }
  for (std::size_t k = 0; k < record.rows; ++k) {
    const double turns = (150 + beside_hz) * trial::TimeOf(record, k);
    record.channels[0].values[k] = 0.03 + 1e-5 * std::sin(2 * std::numbers::pi * turns);
  }
  return Answer(record);
}

// bins are those of the most readings without a pause, 16 384 at most, wherever these are
TEST(SlowRecord, ATonesBinsAreThoseOfTheReadingsThatAreFitted) {
  struct Case {
    std::vector<std::size_t> parts;
    int fitted;
  };
  for (const Case& one : {Case{{16'384, 3616}, 16'384}, Case{{2000, 18'000}, 16'384},
                          Case{{2000, 8800, 9200}, 9200}, Case{{2000, 9200, 8800}, 9200}}) {
    const double beside_hz = 2.5 * 400 / (one.fitted - 1);
    const std::size_t before = one.parts[1];
    const BandAnalysis analysis = WithPauses(one.parts, beside_hz);
    ASSERT_TRUE(analysis.known_tone);
    ASSERT_FALSE(analysis.findings.Has(FindingKind::kKnownTonePauses));
    ASSERT_TRUE(analysis.findings.Has(FindingKind::kKnownToneElsewhere)) << before;
    const Finding doubt = FirstOf(analysis.findings, FindingKind::kKnownToneElsewhere);
    EXPECT_REL(NumberOf(doubt, "better_hz"), 150 + beside_hz, 1e-12, "rounding");
    EXPECT_REL(NumberOf(doubt, "amplitude_m"), 1e-5, 1e-6, "no noise; 1e6 rad in double");
  }
}

}  // namespace
}  // namespace haptometer::dsp
