#include "dsp/readings/segments.h"

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

std::vector<RowRange> HolesOf(const trial::Record& record) {
  std::vector<RowRange> holes;
  for (std::size_t row = 0; row < record.rows; ++row) {
    const trial::Channel& channel = record.channels[0];
    if (IsMeasured(channel.values[row], channel.statuses[row])) continue;
    if (holes.empty() || holes.back().end < row) holes.push_back({row, row});
    holes.back().end = row + 1;
  }
  return holes;
}

Segments Split(const trial::Record& record) {
  auto segments = SplitAtHoles(trial::RecordRows(record), 0, HolesOf(record));
  EXPECT_TRUE(segments) << (segments ? "" : segments.error().Text());
  return segments ? std::move(*segments) : Segments{};
}

std::vector<double> Values(const trial::Record& record, const Segment& segment) {
  std::vector<double> values(segment.size);
  const trial::RecordRows rows(record);
  EXPECT_TRUE(SegmentSamples(rows, 0, segment).Read(0, values));
  return values;
}

// of the errors that are stated, k = 2
double ExpandedSquares(const Segment& part) {
  double sum = 0;
  for (const Bridge& bridge : part.bridges) sum += 4 * bridge.error_square;
  return sum;
}

TEST(Segments, AWholeRecordIsOnePart) {
  const trial::Record record = RecordOf(Samples(kRateHz, 100, 0.03, {{1e-6, 100}}), kRateHz);
  const Segments segments = Split(record);
  ASSERT_EQ(segments.parts.size(), 1U);
  EXPECT_EQ(Values(record, segments.parts[0]), record.channels[0].values);
  EXPECT_EQ(segments.bridged, 0U);
  EXPECT_TRUE(segments.parts[0].bridges.empty());
}

// a tone of 20 um over tremor with noise of 0.2 um: the stated error holds the true one
TEST(Segments, HolesAreInterpolatedWithinTheStatedError) {
  for (const double rate_hz : {5e3, 10e3, 20e3}) {
    for (const double seconds : {1e-4, 2e-3, 10e-3}) {
      const auto size = static_cast<std::size_t>(std::max(1.0, seconds * rate_hz));
      std::vector<double> truth = Samples(rate_hz, 8000, 0.03, {{20e-6, 225}, {3e-4, 8.3}});
      Noise noise(9);
      for (double& x : truth) x += 2e-7 * noise();
      trial::Record record = RecordOf(truth, rate_hz);
      std::size_t holes = 0;
      for (std::size_t row = 700; row + size + 700 < truth.size(); row += 1300, ++holes) {
        Spoil(record, row, size);
      }
      const Segments segments = Split(record);
      ASSERT_EQ(segments.parts.size(), 1U);
      const Segment& part = segments.parts[0];
      EXPECT_EQ(part.bridges.size(), holes * size);
      double square_sum = 0;
      for (const Bridge& bridge : part.bridges) {
        square_sum += std::pow(bridge.value - truth[bridge.sample], 2);
      }
      // expanded by 2: of 5 holes of one row the true square is above it in one of 1000 seeds
      EXPECT_LT(square_sum, ExpandedSquares(part)) << rate_hz << " " << size;
      // no more than half of the tone's amplitude is ever stated for 10 ms
      EXPECT_LT(std::sqrt(ExpandedSquares(part) / static_cast<double>(holes * size)), 1e-5);
    }
  }
}

TEST(Segments, RandomHolesAreInterpolated) {
  std::vector<double> truth = Samples(kRateHz, 20'000, 0.03, {{20e-6, 225}});
  Noise noise(5);
  for (double& x : truth) x += 2e-7 * noise();
  trial::Record record = RecordOf(truth, kRateHz);
  Noise chance(6);
  // a normal number above 1.645: one row in twenty, many of them next to each other
  for (std::size_t row = 1; row + 1 < truth.size(); ++row) {
    if (chance() > 1.645) Spoil(record, row, 1);
  }
  const Segments segments = Split(record);
  ASSERT_EQ(segments.parts.size(), 1U);
  const Segment& part = segments.parts[0];
  EXPECT_GT(part.bridges.size(), 900U);
  double square_sum = 0;
  for (const Bridge& bridge : part.bridges) {
    square_sum += std::pow(bridge.value - truth[bridge.sample], 2);
  }
  // 1000 samples: the expected error is the noise's, and twice that is stated
  EXPECT_LT(square_sum, ExpandedSquares(part));
  EXPECT_GT(square_sum, ExpandedSquares(part) / 8);
}

// One row of N lost throughout a record whose drive is on for two thirds of it: no interpolated row
// feeds another, so that an error at the drive's edge does not grow with the holes behind it.
TEST(Segments, ARowLostAgainAndAgainIsInterpolated) {
  for (const std::size_t every : {5U, 8U, 10U, 11U, 20U}) {
    for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
      std::vector<double> truth = Samples(5e3, 30000, 0.03, {{20e-6, 170}});
      Noise noise(seed);
      for (std::size_t k = 0; k < truth.size(); ++k) {
        if (k < 5000 || k >= 25000) truth[k] = 0.03;
        truth[k] += 1e-7 * noise();
      }
      trial::Record record = RecordOf(truth, 5e3);
      for (std::size_t row = 43; row < truth.size() - 1; row += every) Spoil(record, row, 1);
      const Segments segments = Split(record);
      ASSERT_EQ(segments.parts.size(), 1U) << every;
      double worst = 0;
      for (const Bridge& bridge : segments.parts[0].bridges) {
        worst = std::max(worst, std::abs(bridge.value - truth[bridge.sample]));
      }
      // at the edges a row is that of the drive or of the pause: its amplitude
      EXPECT_LT(worst, 20e-6) << every << " " << seed;
    }
  }
}

TEST(Segments, TwoHolesBesideEachOtherAreInterpolated) {
  trial::Record beside = RecordOf(Samples(kRateHz, 400, 0.03, {{1e-6, 100}}), kRateHz);
  Spoil(beside, 50, 1);
  Spoil(beside, 52, 1);
  EXPECT_EQ(Split(beside).parts.size(), 1U);
}

TEST(Segments, LongerHolesSplit) {
  EXPECT_EQ(LongestHole(5e3), 100U);
  EXPECT_EQ(LongestHole(100e3), 256U);
  EXPECT_EQ(LongestHole(20), 1U);
  trial::Record record = RecordOf(Samples(kRateHz, 2000, 0.03, {{1e-6, 100}}), kRateHz);
  Spoil(record, 800, 201, SampleStatus::kOver);
  const Segments segments = Split(record);
  ASSERT_EQ(segments.parts.size(), 2U);
  EXPECT_EQ(segments.parts[0].size, 800U);
  EXPECT_EQ(segments.parts[1].first_row, 1001U);
  EXPECT_EQ(segments.parts[1].start_s, 1001 / kRateHz);
  EXPECT_EQ(segments.bridged, 0U);
}

TEST(Segments, HolesAtTheEndsAreCutOff) {
  trial::Record record = RecordOf(Samples(kRateHz, 200, 0.03, {{1e-6, 100}}), kRateHz);
  Spoil(record, 0, 2);
  Spoil(record, 198, 2);
  const Segments segments = Split(record);
  ASSERT_EQ(segments.parts.size(), 1U);
  EXPECT_EQ(segments.parts[0].first_row, 2U);
  EXPECT_EQ(segments.parts[0].size, 196U);
}

TEST(Segments, StretchesAreNeverJoined) {
  trial::Record record = RecordOf(std::vector<double>(100, 0.03), kRateHz);
  record.stretches = {{0, 60, 0, kRateHz, 0}, {60, 40, 1, 2 * kRateHz, 1e-5}};
  Spoil(record, 58, 4);  // two rows of each: at an end of both, bridged in neither
  const Segments segments = Split(record);
  ASSERT_EQ(segments.parts.size(), 2U);
  EXPECT_EQ(segments.parts[0].size, 58U);
  EXPECT_EQ(segments.parts[1].first_row, 62U);
  EXPECT_EQ(segments.parts[1].start_s, 1 + 2 / (2 * kRateHz));
  EXPECT_EQ(segments.parts[1].rate_hz, 2 * kRateHz);
  EXPECT_EQ(segments.parts[1].time_uncertainty_s, 1e-5);
}

// 20 ms at 10 kHz, and the longest of 256 rows at higher rates
TEST(Segments, TheLongestHoleIsInterpolated) {
  EXPECT_EQ(LongestHole(12'799), 255U);
  EXPECT_EQ(LongestHole(12'800), 256U);
  EXPECT_EQ(LongestHole(12'900), 256U);
  EXPECT_EQ(LongestHole(149), 2U);
  for (const std::size_t rows : {200U, 201U}) {
    trial::Record record = RecordOf(Samples(kRateHz, 2000, 0.03, {{1e-6, 100}}), kRateHz);
    Spoil(record, 800, rows);
    const Segments segments = Split(record);
    EXPECT_EQ(segments.parts.size(), rows == 200 ? 1U : 2U);
    EXPECT_EQ(segments.bridged, rows == 200 ? 200U : 0U);
  }
}

// a row on either side is enough; a hole that ends with the record or begins with it is cut off
TEST(Segments, AHoleHasAMeasurementOnEitherSide) {
  trial::Record record = RecordOf(Samples(kRateHz, 600, 0.03, {{1e-6, 100}}), kRateHz);
  Spoil(record, 1, 3);
  Spoil(record, 596, 3);
  const Segments within = Split(record);
  ASSERT_EQ(within.parts.size(), 1U);
  EXPECT_EQ(within.parts[0].size, 600U);
  EXPECT_EQ(within.bridged, 6U);
  Spoil(record, 0, 1);
  Spoil(record, 599, 1);
  const Segments cut = Split(record);
  ASSERT_EQ(cut.parts.size(), 1U);
  EXPECT_EQ(cut.parts[0].first_row, 4U);
  EXPECT_EQ(cut.parts[0].first_row + cut.parts[0].size, 596U);
  EXPECT_EQ(cut.bridged, 0U);
}

// any range of a segment has the samples that the whole has, and NaN where they are interpolated
TEST(Segments, AnyRangeHoldsTheSamplesOfTheWhole) {
  trial::Record record = RecordOf(Samples(kRateHz, 600, 0.03, {{1e-6, 100}}), kRateHz);
  Spoil(record, 300, 3);
  const Segments segments = Split(record);
  ASSERT_EQ(segments.parts.size(), 1U);
  const std::vector<double> whole = Values(record, segments.parts[0]);
  const trial::RecordRows rows(record);
  const SegmentSamples samples(rows, 0, segments.parts[0]);
  for (const std::size_t first : {298U, 299U, 300U, 301U, 302U, 303U}) {
    for (const std::size_t size : {1U, 2U, 5U}) {
      std::vector<double> part(size);
      ASSERT_TRUE(samples.Read(first, part));
      std::vector<double> measured(size);
      ASSERT_TRUE(samples.ReadMeasured(first, measured));
      for (std::size_t k = 0; k < size; ++k) {
        const bool is_bridged = first + k >= 300 && first + k < 303;
        EXPECT_EQ(part[k], whole[first + k]);
        EXPECT_EQ(std::isnan(measured[k]), is_bridged) << first << ' ' << k;
      }
    }
  }
}

}  // namespace
}  // namespace haptometer::dsp
