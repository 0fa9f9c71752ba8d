// Doubts on either side of each limit; what an analysis makes of them is in
// tests/dsp/analysis/record_facts_test.cc.
#include "dsp/readings/plausibility.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 5000;

RawSummary Between(double least, double most, std::size_t measured = 1000) {
  RawSummary summary;
  summary.measured = measured;
  summary.least = least;
  summary.most = most;
  return summary;
}

// what is said of a clocked record of 10 s with these extremes
Findings Remarks(const RawSummary& summary, const trial::Metadata& metadata = {},
                 const ReadingRate& rate = {kRateHz, kRateHz, 10, 1600}) {
  trial::Record head = RecordOf({}, kRateHz);
  head.metadata = metadata;
  Findings findings;
  RemarkPlausibility(head, summary, rate, &findings);
  return findings;
}

TEST(Plausibility, ReadingsBeyondAMetreAreFar) {
  using enum FindingKind;
  EXPECT_FALSE(Remarks(Between(0.5, 0.999)).Has(kFarReadings));
  EXPECT_FALSE(Remarks(Between(-0.999, -0.5)).Has(kFarReadings));
  EXPECT_FALSE(Remarks(Between(-0.499, 0.5)).Has(kFarReadings));
  EXPECT_EQ(NumberOf(Remarks(Between(0.5, 1.001)), kFarReadings, "farthest_m"), 1.001);
  EXPECT_EQ(NumberOf(Remarks(Between(-1.001, -0.5)), kFarReadings, "farthest_m"), 1.001);
  EXPECT_REL(NumberOf(Remarks(Between(-0.501, 0.5)), kFarReadings, "farthest_m"), 1.001, 1e-15,
             "from end to end");
}

TEST(Plausibility, NewReadingsMayBeFivePercentFasterThanTheSensor) {
  using enum FindingKind;
  trial::Metadata metadata;
  EXPECT_FALSE(Remarks(Between(0, 0.1), metadata).Has(kSamplingContradicted));
  metadata.sampling_s = 1.049 / kRateHz;
  EXPECT_FALSE(Remarks(Between(0, 0.1), metadata).Has(kSamplingContradicted));
  metadata.sampling_s = 1.051 / kRateHz;
  const Findings found = Remarks(Between(0, 0.1), metadata);
  EXPECT_EQ(NumberOf(found, kSamplingContradicted, "sampling_s"), 1.051 / kRateHz);
  EXPECT_REL(NumberOf(found, kSamplingContradicted, "samples_per_s"), kRateHz / 1.051, 1e-15,
             "rounding");
  EXPECT_EQ(NumberOf(found, kSamplingContradicted, "new_readings_per_s"), kRateHz);
  // readings that are handed out again are none
  const ReadingRate repeated{kRateHz, 0.9 * kRateHz, 10, 1600};
  EXPECT_FALSE(Remarks(Between(0, 0.1), metadata, repeated).Has(kSamplingContradicted));
}

// the column of an imported table of that rate and duration; empty where there is no doubt
std::string OtherColumn(double rate_hz, double duration_s, double stated_hz = 0) {
  trial::Metadata metadata;
  metadata.source = "imported";
  if (stated_hz > 0) metadata.nominal_rate_hz = stated_hz;
  const Findings found = Remarks(Between(0, 0.1), metadata, {rate_hz, rate_hz, duration_s, 1600});
  if (!found.Has(FindingKind::kTimesInOtherUnit)) return "";
  return TextOf(FirstOf(found, FindingKind::kTimesInOtherUnit), "column");
}

TEST(Plausibility, TimesAreInAnotherUnitWhereThatMakesTheRateUsable) {
  EXPECT_EQ(OtherColumn(1600, 10), "") << "as many as are needed";
  EXPECT_EQ(OtherColumn(1e6, 10), "") << "the fastest table";
  EXPECT_EQ(OtherColumn(1.601, 1e4), "time_ms");
  EXPECT_EQ(OtherColumn(999, 1e4), "time_ms");
  EXPECT_EQ(OtherColumn(1.599, 1e6), "") << "too slow in milliseconds, too fast in microseconds";
  EXPECT_EQ(OtherColumn(0.999, 1e6), "time_us");
  EXPECT_EQ(OtherColumn(0.001599, 1e9), "") << "in microseconds, too";
  EXPECT_EQ(OtherColumn(1.601e6, 0.01), "time_s");
  EXPECT_EQ(OtherColumn(1.599e6, 0.01), "");
  EXPECT_EQ(OtherColumn(1.001e9, 0.01), "") << "too fast in seconds, too";
  // of 0.1 s at least
  EXPECT_EQ(OtherColumn(2, 100.1), "time_ms");
  EXPECT_EQ(OtherColumn(2, 99.9), "");
  EXPECT_EQ(OtherColumn(2, 1e4, 2.0199), "") << "stated to 1 %";
  EXPECT_EQ(OtherColumn(2, 1e4, 2.0203), "time_ms");
}

TEST(Plausibility, TheNumbersAreThoseInTheOtherUnit) {
  trial::Metadata metadata;
  metadata.source = "imported";
  const Findings found = Remarks(Between(0, 0.1), metadata, {5, 5, 2000, 1600});
  const Finding guess = FirstOf(found, FindingKind::kTimesInOtherUnit);
  EXPECT_REL(NumberOf(guess, "readings_per_s"), 5000, 1e-14, "rounding");
  EXPECT_REL(NumberOf(guess, "duration_s"), 2, 1e-14, "rounding");
}

// readings from 0 to 10 mm in steps of 0.1 mm, calibrated up to `most_m`
Findings BeyondCalibrated(double least_m, double most_m) {
  std::vector<double> values;
  for (int k = 0; k <= 100; ++k) values.push_back(1e-4 * k);
  trial::Record record = RecordOf(values, kRateHz);
  record.channels[0].statuses[100] = trial::SampleStatus::kOver;
  auto& fields = record.metadata.fields;
  fields["calibration.displacement.calibrated_least"] = std::to_string(least_m);
  fields["calibration.displacement.calibrated_most"] = std::to_string(most_m);
  Findings findings;
  const RawSummary summary = Between(0, 9.9e-3, 100);
  EXPECT_TRUE(CheckCalibratedRange(trial::RecordRows(record), 0, summary, &findings));
  return findings;
}

TEST(Plausibility, ReadingsBeyondTheCalibratedRangeAreCounted) {
  using enum FindingKind;
  // of 9.802 mm 1 % is 0.098 mm: 9.9 mm lies 0.098 mm beyond
  EXPECT_FALSE(BeyondCalibrated(0, 9.803e-3).Has(kBeyondCalibrated));
  EXPECT_TRUE(BeyondCalibrated(0, 9.8e-3).Has(kBeyondCalibrated));
  const Findings upper = BeyondCalibrated(0, 8e-3);
  // 8.1 to 9.9 mm; 10 mm is no measurement
  EXPECT_EQ(NumberOf(upper, kBeyondCalibrated, "samples"), 19);
  EXPECT_EQ(NumberOf(upper, kBeyondCalibrated, "readings"), 100);
  EXPECT_REL(NumberOf(upper, kBeyondCalibrated, "beyond_m"), 1.9e-3, 1e-12, "rounding");
  EXPECT_EQ(NumberOf(upper, kBeyondCalibrated, "least_m"), 0);
  EXPECT_EQ(NumberOf(upper, kBeyondCalibrated, "most_m"), 8e-3);
  const Findings lower = BeyondCalibrated(2.05e-3, 10e-3);
  EXPECT_EQ(NumberOf(lower, kBeyondCalibrated, "samples"), 20) << "0 to 1.9 mm";
  EXPECT_REL(NumberOf(lower, kBeyondCalibrated, "beyond_m"), 2.05e-3, 1e-12, "rounding");
}

// a hundred times the width is another unit: 98 um and 99 um of 9.9 mm
TEST(Plausibility, AHundredWidthsBeyondAreNamed) {
  const auto widths = [](double most_m) {
    const Finding found = FirstOf(BeyondCalibrated(0, most_m), FindingKind::kBeyondCalibrated);
    return found.numbers.back().name == "widths" ? NumberOf(found, "widths") : 0;
  };
  EXPECT_EQ(widths(99e-6), 0) << "99 widths";
  EXPECT_EQ(widths(97e-6), 101);
}

TEST(Plausibility, AnRmsHasLimits) {
  const auto kinds = [](double rms_m, double farthest_m) {
    Findings findings;
    RemarkImplausibleRms(rms_m, farthest_m, &findings);
    std::vector<FindingKind> all;
    for (const Finding& finding : findings.list()) all.push_back(finding.kind);
    return all;
  };
  using Kinds = std::vector<FindingKind>;
  EXPECT_EQ(kinds(0.00999, 0.5), Kinds{});
  EXPECT_EQ(kinds(0.01001, 1), Kinds{FindingKind::kRmsTooLarge});
  EXPECT_EQ(kinds(0.01001, 1.001), Kinds{}) << "the readings are doubted already";
  EXPECT_EQ(kinds(1.001e-10, 0.5), Kinds{});
  EXPECT_EQ(kinds(0.999e-10, 0.5), Kinds{FindingKind::kRmsTooSmall});
  EXPECT_EQ(kinds(0, 0.5), Kinds{});
}

TEST(Plausibility, SixteenEqualReadingsAreAStuckSensor) {
  EXPECT_FALSE(WhyStuck(Between(0.03, 0.03, 15)));
  const auto stuck = WhyStuck(Between(0.03, 0.03, 16));
  ASSERT_TRUE(stuck);
  EXPECT_EQ(stuck->severity, Severity::kRefusal);
  EXPECT_EQ(NumberOf(*stuck, "readings"), 16);
  EXPECT_FALSE(WhyStuck(Between(0.03, 0.0300001, 1000)));
}

}  // namespace
}  // namespace haptometer::dsp
