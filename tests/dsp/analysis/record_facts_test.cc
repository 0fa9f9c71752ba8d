#include "dsp/analysis/record_facts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 5000;
constexpr std::size_t kRows = 10'000;

BandAnalysis Answer(const trial::Record& record) { return AnalyzeBand(record, {}).value(); }

// 20 um at 225 Hz, 30 mm away, all times `scale`
trial::Record Tone(double scale) {
  return RecordOf(Samples(kRateHz, kRows, 0.03 * scale, {{20e-6 * scale, 225}}), kRateHz);
}

TEST(RecordDoubts, AFewOtherReadingsDoNotMakeAStuckSensorVibrate) {
  std::vector<double> values(kRows, 0.03);
  values[4000] = 0.0301;
  values[6000] = values[6001] = 0.0299;
  const BandAnalysis analysis = Answer(RecordOf(values, kRateHz));
  EXPECT_FALSE(analysis.answered);
  EXPECT_FALSE(analysis.numbers);
  EXPECT_TRUE(analysis.findings.Has(FindingKind::kStuckInWindow));
}

TEST(RecordDoubts, OtherDisplacementsAreNamed) {
  trial::Record record = Tone(1);
  EXPECT_FALSE(Answer(record).findings.Has(FindingKind::kOtherDisplacements));
  trial::Channel second = record.channels[0];
  second.name = "reference";
  record.channels.push_back(second);
  second.name = "drive";
  second.role = trial::ChannelRole::kVoltage;
  record.channels.push_back(second);
  const BandAnalysis analysis = Answer(record);
  EXPECT_EQ(
      tests::NumberOf<std::string>(analysis.findings, FindingKind::kOtherDisplacements, "others"),
      "reference");
}

TEST(RecordDoubts, AShortBurstOnCoarseStepsIsNoStuckSensor) {
  std::vector<double> values(kRows, 6000 * 5e-6);
  const auto burst = Samples(kRateHz, 2000, 0.03, {{20e-6, 225}});
  for (std::size_t k = 0; k < burst.size(); ++k) {
    values[4000 + k] = std::round(burst[k] / 5e-6) * 5e-6;  // steps of 5 um
  }
  const BandAnalysis analysis = Answer(RecordOf(values, kRateHz));
  EXPECT_TRUE(analysis.answered);
}

// A converter three and four times as fast as the sensor: what its held readings cost is stated, by
// the closed form of a hold; 1250 new readings a second are too few for 500 Hz.
TEST(RecordDoubts, ASourceSlowerThanTheRecordIsTold) {
  for (const std::size_t times : {1U, 3U, 4U}) {
    std::vector<double> fresh =
        Samples(kRateHz / static_cast<double>(times), 3 * kRows, 0, {{20e-6, 300.3}});
    Noise noise(1);
    for (double& x : fresh) x += 2e-8 * noise();
    std::vector<double> values(3 * kRows);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = fresh[k / times];
    const BandAnalysis analysis = Answer(RecordOf(values, kRateHz));
    EXPECT_EQ(analysis.answered, times < 4) << times;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kSourceIsSlower), times > 1);
    EXPECT_EQ(analysis.findings.Has(FindingKind::kTooFewReadings), times == 4);
    EXPECT_REL(analysis.record.fresh_rate_hz, kRateHz / static_cast<double>(times), 1e-3,
               "the ends of the window");
    if (times != 3) continue;
    EXPECT_REL(NumberOf(analysis.findings, FindingKind::kSourceIsSlower, "loss"),
               1 - analysis.numbers->tone->fit.amplitude / 20e-6, 1e-3, "noise");
  }
}

TEST(RecordDoubts, SamplesBeyondTheCalibratedRangeAreCounted) {
  // 0 to 10 mm in 10 000 rows, calibrated from 1 to 9 mm: beyond by 1 mm, 1 % of the width allowed
  std::vector<double> values = Samples(kRateHz, kRows, 0, {{20e-6, 225}});
  for (std::size_t k = 0; k < kRows; ++k) values[k] += 1e-6 * static_cast<double>(k);
  trial::Record record = RecordOf(values, kRateHz);
  auto& fields = record.metadata.fields;
  fields["calibration.displacement.calibrated_least"] = "0.001";
  fields["calibration.displacement.calibrated_most"] = "0.009";
  const Findings found = Answer(record).findings;
  EXPECT_ABS(NumberOf(found, FindingKind::kBeyondCalibrated, "samples"), 1840, 60,
             "the tone at both ends");
  EXPECT_ABS(NumberOf(found, FindingKind::kBeyondCalibrated, "beyond_m"), 1e-3, 21e-6, "the tone");
  // within 1 % of the width beyond, or without a range, there is nothing to say
  fields["calibration.displacement.calibrated_least"] = "0.00005";
  fields["calibration.displacement.calibrated_most"] = "0.00995";
  EXPECT_FALSE(Answer(record).findings.Has(FindingKind::kBeyondCalibrated));
  EXPECT_FALSE(Answer(RecordOf(values, kRateHz)).findings.Has(FindingKind::kBeyondCalibrated));
}

TEST(RecordDoubts, LengthsOffByAThousandAreDoubted) {
  using enum FindingKind;
  const Findings plain = Answer(Tone(1)).findings;
  for (const FindingKind kind : {kFarReadings, kRmsTooLarge, kRmsTooSmall}) {
    EXPECT_FALSE(plain.Has(kind)) << static_cast<int>(kind);
  }
  EXPECT_REL(NumberOf(Answer(Tone(1e3)).findings, kFarReadings, "farthest_m"), 30.0, 1e-2,
             "30.02 m: 30 m and the tone");
  trial::Record tared = RecordOf(Samples(kRateHz, kRows, 0, {{20e-3, 225}}), kRateHz);
  EXPECT_REL(NumberOf(Answer(tared).findings, kRmsTooLarge, "rms_m"), 14.14e-3, 1e-3, "the filter");
  EXPECT_REL(NumberOf(Answer(Tone(1e-6)).findings, kRmsTooSmall, "rms_m"), 14.14e-12, 1e-3,
             "the filter");
}

TEST(RecordDoubts, MoreReadingsThanTheSamplingPeriodAllowsAreNamed) {
  trial::Record record = Tone(1);
  record.metadata.averages = 4;
  record.metadata.sampling_s = 1 / kRateHz;
  EXPECT_FALSE(Answer(record).findings.Has(FindingKind::kSamplingContradicted));
  record.metadata.sampling_s = 1e-3;
  const Finding doubt = FirstOf(Answer(record).findings, FindingKind::kSamplingContradicted);
  EXPECT_EQ(NumberOf(doubt, "sampling_s"), 1e-3);
  EXPECT_EQ(NumberOf(doubt, "new_readings_per_s"), kRateHz);
}

TEST(RecordDoubts, MillisecondsReadAsSecondsAreGuessed) {
  trial::Record record = Tone(1);
  record.metadata.source = "imported";
  EXPECT_FALSE(Answer(record).findings.Has(FindingKind::kTimesInOtherUnit));
  record.stretches.front().rate_hz = kRateHz / 1000;
  const BandAnalysis analysis = Answer(record);
  EXPECT_FALSE(analysis.answered);
  const Finding guess = FirstOf(analysis.findings, FindingKind::kTimesInOtherUnit);
  EXPECT_EQ(TextOf(guess, "column"), "time_ms");
  EXPECT_REL(NumberOf(guess, "readings_per_s"), kRateHz, 1e-12, "rounding");
  record.metadata.nominal_rate_hz = kRateHz / 1000;  // somebody said so
  EXPECT_FALSE(Answer(record).findings.Has(FindingKind::kTimesInOtherUnit));
  record.metadata.nominal_rate_hz.reset();
  record.metadata.sensor = "keyence-il";  // that is a slow one
  EXPECT_FALSE(Answer(record).findings.Has(FindingKind::kTimesInOtherUnit));
}

}  // namespace
}  // namespace haptometer::dsp
