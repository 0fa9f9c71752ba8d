#include "dsp/analysis/record_facts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_filtering.h"
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

// Readings that an export joined by lines, three and four rows for each: what lines cost a tone is
// the square of what holding costs it; 1250 readings a second are too few for 500 Hz.
TEST(RecordDoubts, StraightLinesBetweenReadingsAreTold) {
  for (const double rows : {3.0, 41.0 / 13, 4.0}) {
    std::vector<double> fresh = Samples(kRateHz / rows, 3 * kRows, 0, {{20e-6, 300.3}});
    Noise noise(1);
    for (double& x : fresh) x += 2e-8 * noise();
    std::vector<double> values(3 * kRows);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double place = static_cast<double>(k) / rows;
      const auto at = static_cast<std::size_t>(place);
      values[k] = std::lerp(fresh[at], fresh[at + 1], place - static_cast<double>(at));
    }
    const BandAnalysis analysis = Answer(RecordOf(values, kRateHz));
    EXPECT_EQ(analysis.answered, rows < 4);
    EXPECT_REL(NumberOf(analysis.findings, FindingKind::kStraightLines, "new_readings_per_s"),
               kRateHz / rows, 1e-5, "a sine fit");
    EXPECT_REL(NumberOf(analysis.findings, FindingKind::kStraightLines, "loss"),
               1 - analysis.numbers->tone->fit.amplitude / 20e-6, 1e-3, "noise");
  }
}

// An amplifier's limit that the converter's noise covers; the RMS is 18 % too low.
TEST(RecordDoubts, ALimitBelowNoiseIsTold) {
  std::vector<double> values = Samples(kRateHz, 2 * kRows, 0, {{20e-6, 175.3}});
  Noise noise(1);
  for (double& x : values) x = std::clamp(x, -14e-6, 14e-6) + 2e-7 * noise();
  const BandAnalysis analysis = Answer(RecordOf(values, kRateHz));
  EXPECT_TRUE(analysis.answered);
  EXPECT_ABS(NumberOf(analysis.findings, FindingKind::kLimited, "highest_m"), 14e-6, 2e-7,
             "the noise");
  EXPECT_ABS(NumberOf(analysis.findings, FindingKind::kLimited, "lowest_m"), -14e-6, 2e-7,
             "the noise");
  // of a sine of amplitude a beyond the limit c: mean of a sin - c = a sin(p) / p - c, p =
  // acos(c/a)
  const double beyond_m = 20e-6 * std::sqrt(1 - 0.49) / std::acos(0.7) - 14e-6;
  EXPECT_REL(NumberOf(analysis.findings, FindingKind::kLimited, "beyond_m"), beyond_m, 0.1,
             "flanks within the noise of the limit");
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

// ---- The steps before any filter, by their own functions.

// 2 s at `rate_hz` that are polled, of times known to `uncertainty_s`
Findings ObservableIn(double rate_hz, double uncertainty_s, const BandPass& band) {
  trial::Record record = RecordOf(std::vector<double>(100, 0.03), rate_hz);
  record.timing = trial::Timing::kPolled;
  Segments segments;
  segments.parts.resize(2);
  segments.parts[1].time_uncertainty_s = uncertainty_s;
  BandAnalysis analysis;
  analysis.record.fresh_rate_hz = rate_hz;
  CheckObservable(record, segments, band, &analysis);
  return analysis.findings;
}

TEST(CheckObservable, NeedsTwoAndAHalfReadingsAPeriodAndTimesToATenth) {
  const BandPass band{.lower_hz = 10, .upper_hz = 100};
  EXPECT_TRUE(ObservableIn(256, 0.999e-3, band).list().empty());
  const Findings slow = ObservableIn(255.9, 0, band);
  ASSERT_EQ(slow.list().size(), 1U);
  EXPECT_EQ(slow.list()[0].kind, FindingKind::kTooFewReadings);
  EXPECT_EQ(slow.list()[0].severity, Severity::kRefusal);
  EXPECT_EQ(NumberOf(slow.list()[0], "needed_per_s"), 256);
  EXPECT_EQ(NumberOf(slow.list()[0], "new_readings_per_s"), 255.9);
  const Findings late = ObservableIn(256, 1.001e-3, band);
  ASSERT_EQ(late.list().size(), 1U);
  EXPECT_EQ(late.list()[0].kind, FindingKind::kTimesUncertain);
  EXPECT_EQ(NumberOf(late.list()[0], "limit_s"), 1e-3);
  EXPECT_EQ(NumberOf(late.list()[0], "upper_hz"), 100);
}

// Times of six decimals give 1280 readings a second as 1279.99993599; a clock is right to 1e-4.
TEST(CheckObservable, ARateWithinItsClocksUncertaintySuffices) {
  const BandPass band{.lower_hz = 20, .upper_hz = 500};
  EXPECT_TRUE(ObservableIn(1279.99993599, 0, band).list().empty());
  EXPECT_TRUE(ObservableIn(1280 * (1 - 0.99e-4), 0, band).list().empty());
  EXPECT_TRUE(ObservableIn(1280 * (1 - 1.01e-4), 0, band).Has(FindingKind::kTooFewReadings));
}

TEST(AnalyzedChannel, WithoutADisplacementNamesWhatIsThere) {
  trial::Record record = RecordOf(std::vector<double>(10, 0.03), 1000);
  record.channels[0].name = "Laser (in)";
  record.channels[0].role = trial::ChannelRole::kOther;
  record.channels[0].unit = "";
  record.channels.push_back(record.channels[0]);
  record.channels[1].name = "sensor";
  record.channels[1].role = trial::ChannelRole::kVoltage;
  record.channels[1].unit = "V";
  const auto channel = AnalyzedChannel(record);
  ASSERT_FALSE(channel);
  EXPECT_EQ(channel.error().cause, Cause::kCannotAnswer);
  EXPECT_EQ(channel.error().what,
            "holds no displacement channel, but 'Laser (in)' (unit not known), 'sensor' (V)");
  EXPECT_TRUE(channel.error().remedy.contains("by the unit of its numbers"));
  EXPECT_TRUE(channel.error().remedy.contains("a calibration gives the displacement"));
}

// A fourth of 100 rows are handed out again, five are late, three have no number; the second
// stretch lasts longer.
TEST(DescribeRecord, CountsRowsAndNewReadings) {
  trial::Record record = RecordOf(std::vector<double>(100, 0.03), 1000);
  record.stretches = {{0, 40, 0, 1000, 0}, {40, 60, 1, 800, 0}};
  Segments segments;
  segments.parts.resize(3);
  segments.measured = 92;
  segments.bridged = 4;
  segments.by_status[static_cast<std::size_t>(trial::SampleStatus::kOk)] = 72;
  segments.by_status[static_cast<std::size_t>(trial::SampleStatus::kRepeated)] = 23;
  segments.by_status[static_cast<std::size_t>(trial::SampleStatus::kLate)] = 5;
  RawSummary summary;
  summary.measured = 92;
  summary.mean = 0.03;
  summary.least = 0.01;
  summary.most = 0.05;
  BandAnalysis analysis;
  DescribeRecord(record, segments, summary, &analysis);
  const RecordFacts& facts = analysis.record;
  EXPECT_EQ(facts.rows, 100U);
  EXPECT_EQ(facts.measured, 92U);
  EXPECT_EQ(facts.bridged, 4U);
  EXPECT_EQ(facts.segments, 3U);
  EXPECT_EQ(facts.rate_hz, 800) << "of the stretch with more rows";
  EXPECT_REL(facts.duration_s, 0.04 + 0.075, 1e-15, "both stretches");
  EXPECT_REL(facts.fresh_rate_hz, 600.0, 1e-15, "23 of 92 were there before");
  EXPECT_REL(facts.observable_upper_hz, 600 / 2.56, 1e-15, "readings a period");
  EXPECT_EQ(facts.offset_m, 0.03);
  EXPECT_REL(facts.peak_to_peak_m, 0.04, 1e-15, "most less least");
  const Finding excluded = FirstOf(analysis.findings, FindingKind::kExcluded);
  EXPECT_EQ(NumberOf(excluded, "excluded"), 8);
  EXPECT_EQ(TextOf(excluded, "statuses"), "late 5, without a value 3");
  EXPECT_EQ(NumberOf(analysis.findings, FindingKind::kRepeated, "repeated"), 23);
  EXPECT_EQ(NumberOf(analysis.findings, FindingKind::kRepeated, "readings"), 92);
}

// what is said of a spike from row 300 on and steps from row 700 on, of 1 kHz
TEST(RemarkArtifacts, CountsEachKindAndTimesTheFirst) {
  trial::Record record = RecordOf(std::vector<double>(1000, 0.03), 1000);
  record.stretches[0].start_s = 2;
  record.channels[0].statuses[100] = record.channels[0].statuses[101] =
      trial::SampleStatus::kClipped;
  const trial::RecordRows rows(record);
  const CleanChannel clean = Clean(rows, 0).value();
  BandAnalysis analysis;
  analysis.faults.list = {{FaultKind::kClipped, 100, 2, 0},
                          {FaultKind::kSpike, 300, 1, -4e-3},
                          {FaultKind::kStep, 700, 1, -2e-3},
                          {FaultKind::kStep, 800, 1, 3e-3}};
  analysis.faults.count = {1, 0, 1, 2};
  analysis.faults.rows = {2, 0, 1, 2};
  RemarkArtifacts(clean, &analysis);
  EXPECT_FALSE(analysis.findings.Has(FindingKind::kHeld));
  const Finding clipped = FirstOf(analysis.findings, FindingKind::kClipped);
  EXPECT_EQ(clipped.severity, Severity::kDoubt);
  EXPECT_EQ(NumberOf(clipped, "count"), 1);
  EXPECT_EQ(NumberOf(clipped, "readings"), 2);
  EXPECT_REL(NumberOf(clipped, "first_s"), 2.1, 1e-15, "row 100");
  const Finding spike = FirstOf(analysis.findings, FindingKind::kSpikes);
  EXPECT_EQ(spike.severity, Severity::kNote) << "it was corrected";
  EXPECT_EQ(NumberOf(spike, "size_m"), 4e-3);
  const Finding step = FirstOf(analysis.findings, FindingKind::kSteps);
  EXPECT_EQ(step.severity, Severity::kDoubt);
  EXPECT_EQ(NumberOf(step, "count"), 2);
  EXPECT_EQ(NumberOf(step, "size_m"), 2e-3);
  EXPECT_REL(NumberOf(step, "first_s"), 2.7, 1e-15, "row 700");
}

TEST(RemarkArtifacts, EachCodeHasItsOwnReadings) {
  trial::Record record = Tone(1);
  for (std::size_t k = 0; k < 43; ++k) {
    record.channels[0].values[100 + 200 * k] = k < 40 ? -9.999 : 9.9999;
  }
  std::vector<double> readings;
  for (const Finding& found : Answer(record).findings.list()) {
    if (found.kind != FindingKind::kNoReadingCodes) continue;
    readings.push_back(NumberOf(found, "readings"));
  }
  EXPECT_EQ(readings, (std::vector<double>{40, 3}));
}

// ---- A part of 1 s at 1 kHz, from sample 500 of the record's second segment on, that changes
// `changes` times; two a period of 20 Hz are 40.

std::optional<Finding> WhyStuckAfter(std::size_t changes, std::size_t runs_of_record) {
  trial::Record record = RecordOf(std::vector<double>(4000, 0.03), 1000);
  std::vector<double>& values = record.channels[0].values;
  // many changes before the part and behind it
  for (std::size_t k = 0; k < 1500; ++k) values[k] += k % 2 == 0 ? 1e-6 : 0;
  for (std::size_t k = 2500; k < 4000; ++k) values[k] += k % 2 == 0 ? 1e-6 : 0;
  values[1499] = 0.03 + 5e-6;
  values[1500] = 0.03;
  for (std::size_t change = 1; change <= changes; ++change) {
    for (std::size_t k = 1500 + 10 * change; k < 2500; ++k) {
      values[k] = 0.03 + 1e-6 * static_cast<double>(change);
    }
  }
  // a value that is no measurement, and one beside a hole, are no changes
  values[1505] = 1;
  record.channels[0].statuses[1505] = trial::SampleStatus::kOver;
  const trial::RecordRows rows(record);
  Segment segment;
  segment.first_row = 1000;
  segment.size = 3000;
  segment.start_s = 1;
  segment.rate_hz = 1000;
  const BandSignal signal =
      BandSignal::Filter({rows, 0, segment}, Designed({.upper_hz = 300}, 1000), 1).value();
  BandAnalysis analysis;
  analysis.record.duration_s = 4;
  analysis.faults.runs = runs_of_record;
  analysis.band.lower_hz = 20;
  return WhyStuck(Displacement{rows, 0}, {&signal, 500, 1500}, analysis).value();
}

TEST(WhyStuck, OfAPartCountsItsOwnChanges) {
  const auto stuck = WhyStuckAfter(39, 100);
  ASSERT_TRUE(stuck);
  EXPECT_EQ(stuck->severity, Severity::kRefusal);
  EXPECT_EQ(NumberOf(*stuck, "changes"), 39);
  EXPECT_EQ(NumberOf(*stuck, "readings"), 1000);
  EXPECT_EQ(NumberOf(*stuck, "window_s"), 1);
  EXPECT_EQ(NumberOf(*stuck, "from_s"), 1.5);
  EXPECT_EQ(NumberOf(*stuck, "lower_hz"), 20);
  EXPECT_FALSE(WhyStuckAfter(40, 100));
  // 160 changes in the record's 4 s are enough for it not to be read again
  EXPECT_TRUE(WhyStuckAfter(39, 159));
  EXPECT_FALSE(WhyStuckAfter(39, 160));
}

}  // namespace
}  // namespace haptometer::dsp
