#include "dsp/analysis/segments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kRateHz = 10e3;

void Spoil(trial::Record& record, std::size_t row, std::size_t count,
           SampleStatus status = SampleStatus::kLate) {
  for (std::size_t k = row; k < row + count; ++k) {
    record.channels[0].statuses[k] = status;
    record.channels[0].values[k] = std::numeric_limits<double>::quiet_NaN();
  }
}

Segments Split(const trial::Record& record, double upper_hz) {
  auto segments = SplitIntoSegments(trial::RecordRows(record), 0, upper_hz);
  EXPECT_TRUE(segments) << (segments ? "" : segments.error().Text());
  return segments ? std::move(*segments) : Segments{};
}

std::vector<double> Values(const trial::Record& record, const Segment& segment) {
  std::vector<double> values(segment.size);
  const trial::RecordRows rows(record);
  EXPECT_TRUE(SegmentSamples(rows, 0, segment).Read(0, values));
  return values;
}

TEST(Segments, AWholeRecordIsOnePart) {
  const trial::Record record = RecordOf(Samples(kRateHz, 100, 0.03, {{1e-6, 100}}), kRateHz);
  const Segments segments = Split(record, 500);
  ASSERT_EQ(segments.parts.size(), 1U);
  EXPECT_EQ(Values(record, segments.parts[0]), record.channels[0].values);
  EXPECT_EQ(segments.measured, 100U);
  EXPECT_EQ(segments.bridged, 0U);
  EXPECT_EQ(segments.parts[0].bridged_error_square_sum, 0);
}

TEST(Segments, HolesOfAtMostThreeAreBridged) {
  const std::vector<double> truth = Samples(kRateHz, 200, 0.03, {{1e-6, 100}, {5e-4, 8.3}});
  for (std::size_t size = 1; size <= 3; ++size) {
    trial::Record record = RecordOf(truth, kRateHz);
    Spoil(record, 100, size);
    const Segments segments = Split(record, 500);
    ASSERT_EQ(segments.parts.size(), 1U);
    const Segment& part = segments.parts[0];
    EXPECT_EQ(part.bridges.size(), size);
    EXPECT_EQ(segments.measured, 200 - size);
    EXPECT_EQ(segments.by_status[static_cast<std::size_t>(SampleStatus::kLate)], size);
    // |x''''| (x+2)(x+1)(x-n)(x-n-1)/24 <= 1e-6 (2 pi 100/rate)^4 (2.25^2 3^2)/24 at n = 3
    const std::vector<double> values = Values(record, part);
    double square_sum = 0;
    for (std::size_t k = 100; k < 100 + size; ++k) {
      EXPECT_ABS(values[k], truth[k], 2.5e-11, "the cubic's remainder");
      square_sum += (values[k] - truth[k]) * (values[k] - truth[k]);
    }
    EXPECT_GT(part.bridged_error_square_sum, square_sum);
    EXPECT_LT(part.bridged_error_square_sum, static_cast<double>(size) * 2.5e-11 * 2.5e-11);
  }
}

TEST(Segments, ACubicIsBridgedExactly) {
  const std::vector<double> cubes{-8, -1, 0, 1, 8, 27, 64, 125, 216, 343, 512, 729};
  trial::Record record = RecordOf(cubes, kRateHz);
  Spoil(record, 5, 1);
  const Segments segments = Split(record, 500);
  ASSERT_EQ(segments.parts.size(), 1U);
  EXPECT_REL(Values(record, segments.parts[0])[5], 27, 1e-15, "rounding of the weights");
  EXPECT_ABS(segments.parts[0].bridged_error_square_sum, 0, 1e-26, "rounding of the weights");
}

TEST(Segments, AHoleWhoseBridgeCannotBeTriedSplits) {
  // three rows want seven known ones on a side; there are five and four
  trial::Record record = RecordOf(std::vector<double>(12, 0.03), kRateHz);
  Spoil(record, 5, 3);
  EXPECT_EQ(Split(record, 500).parts.size(), 2U);
  // a hole right beside another leaves only one row between them
  trial::Record beside = RecordOf(std::vector<double>(100, 0.03), kRateHz);
  Spoil(beside, 50, 1);
  Spoil(beside, 52, 1);
  const Segments segments = Split(beside, 500);
  ASSERT_EQ(segments.parts.size(), 3U);
  EXPECT_EQ(segments.parts[1].size, 1U);
}

TEST(Segments, LargerHolesSplit) {
  trial::Record record = RecordOf(Samples(kRateHz, 200, 0.03, {{1e-6, 100}}), kRateHz);
  Spoil(record, 80, 4, SampleStatus::kOver);
  const Segments segments = Split(record, 500);
  ASSERT_EQ(segments.parts.size(), 2U);
  EXPECT_EQ(segments.parts[0].size, 80U);
  EXPECT_EQ(segments.parts[1].first_row, 84U);
  EXPECT_EQ(segments.parts[1].start_s, 84 / kRateHz);
  EXPECT_EQ(segments.bridged, 0U);
}

TEST(Segments, SlowRecordsAreNotBridged) {
  trial::Record record = RecordOf(Samples(2499, 200, 0.03, {{1e-6, 100}}), 2499);
  Spoil(record, 80, 1);
  EXPECT_EQ(Split(record, 500).parts.size(), 2U);
  EXPECT_EQ(Split(record, 499).parts.size(), 1U);
}

TEST(Segments, HolesAtTheEndsAreCutOff) {
  trial::Record record = RecordOf(Samples(kRateHz, 200, 0.03, {{1e-6, 100}}), kRateHz);
  Spoil(record, 0, 2);
  Spoil(record, 198, 2);
  const Segments segments = Split(record, 500);
  ASSERT_EQ(segments.parts.size(), 1U);
  EXPECT_EQ(segments.parts[0].first_row, 2U);
  EXPECT_EQ(segments.parts[0].size, 196U);
}

TEST(Segments, ANumberUnderABadStatusAndANaNUnderAGoodOneAreHoles) {
  trial::Record record = RecordOf(std::vector<double>(100, 0.03), kRateHz);
  record.channels[0].statuses[50] = SampleStatus::kClipped;
  record.channels[0].values[60] = std::numeric_limits<double>::infinity();
  record.channels[0].statuses[70] = SampleStatus::kRepeated;
  const Segments segments = Split(record, 500);
  EXPECT_EQ(segments.measured, 98U);
  EXPECT_EQ(segments.bridged, 2U);
}

TEST(Segments, StretchesAreNeverJoined) {
  trial::Record record = RecordOf(std::vector<double>(100, 0.03), kRateHz);
  record.stretches = {{0, 60, 0, kRateHz, 0}, {60, 40, 1, 2 * kRateHz, 1e-5}};
  Spoil(record, 58, 4);  // two rows of each: at an end of both, bridged in neither
  const Segments segments = Split(record, 500);
  ASSERT_EQ(segments.parts.size(), 2U);
  EXPECT_EQ(segments.parts[0].size, 58U);
  EXPECT_EQ(segments.parts[1].first_row, 62U);
  EXPECT_EQ(segments.parts[1].start_s, 1 + 2 / (2 * kRateHz));
  EXPECT_EQ(segments.parts[1].rate_hz, 2 * kRateHz);
  EXPECT_EQ(segments.parts[1].time_uncertainty_s, 1e-5);
}

}  // namespace
}  // namespace haptometer::dsp
