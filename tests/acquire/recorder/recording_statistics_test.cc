// What counts as a gap, and the statistics of intervals, against their definitions.
#include "acquire/recorder/recording_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using trial::Timing;

constexpr MonotonicNs kMs = 1'000'000;

// --- statistics ---

TEST(IntervalStatistics, AgainstTheDefinition) {
  IntervalStatistics statistics;
  const std::vector<MonotonicNs> times_ns{0, 10 * kMs, 22 * kMs, 30 * kMs, 45 * kMs};
  for (const MonotonicNs time_ns : times_ns) statistics.Add(time_ns, 0);
  // intervals 10, 12, 8, 15 ms: mean 11.25, squared deviations 1.5625 + 0.5625 + 10.5625 + 14.0625
  EXPECT_REL(statistics.RateHz().value(), 4 / 0.045, 1e-15, "one division");
  EXPECT_REL(statistics.DeviationSeconds().value(), std::sqrt(26.75 / 3) * 1e-3, 1e-12,
             "four roundings of the recurrence");
}

TEST(IntervalStatistics, APauseThatIsMeantToBeDoesNotCount) {
  IntervalStatistics statistics;
  for (const MonotonicNs time_ns : {0 * kMs, 10 * kMs, 20 * kMs}) statistics.Add(time_ns, 0);
  statistics.Restart();
  for (const MonotonicNs time_ns : {5000 * kMs, 5010 * kMs}) statistics.Add(time_ns, 0);
  EXPECT_REL(statistics.RateHz().value(), 100.0, 1e-15, "one division");
  EXPECT_ABS(statistics.DeviationSeconds().value(), 0.0, 1e-15, "rounding of the running mean");
}

TEST(IntervalStatistics, KnownLossesCountAsIntervals) {
  // bursts of four rows every 4 ms, of which the last row of every fifth burst is lost: 1000 a
  // second, and intervals of 0 and 4 ms whose mean would be 1.05 ms
  IntervalStatistics statistics;
  std::uint64_t missing = 0;
  for (int row = 0; row <= 4000; ++row) {
    if (row % 20 == 19) {
      ++missing;
      continue;
    }
    statistics.Add(MonotonicNs{row} / 4 * 4 * kMs, std::exchange(missing, 0));
  }
  EXPECT_REL(statistics.RateHz().value(), 1000.0, 1e-15, "whole bursts, one division");
  // 300 rows are not what a second of silence held
  EXPECT_TRUE(statistics.Explains(4300 * kMs, 299));
  EXPECT_FALSE(statistics.Explains(5000 * kMs, 299));
  EXPECT_FALSE(statistics.Explains(4001 * kMs, 299)) << "a damaged number";
}

TEST(IntervalStatistics, ALongRecordingKeepsItsDigits) {
  // a million intervals of 100 us, every second one 1 ns longer and the next shorter: sd 1 ns
  IntervalStatistics statistics;
  MonotonicNs time_ns = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    statistics.Add(time_ns, 0);
    time_ns += 100'000 + (i % 2 == 0 ? 1 : -1);
  }
  EXPECT_REL(statistics.DeviationSeconds().value(), 1e-9, 1e-5, "1/n, and 1e-16 of 100 us n times");
}

// --- gaps ---

class Gaps {
 public:
  explicit Gaps(Timing timing) : counter_(timing) {}
  // `rows` more, `period_ns` apart, the first `first_after_ns` behind the last one so far
  void Rows(int rows, MonotonicNs period_ns, MonotonicNs first_after_ns) {
    for (int i = 0; i < rows; ++i) {
      reading_.time_ns += i == 0 ? first_after_ns : period_ns;
      ++reading_.index;
      counter_.Add(reading_);
    }
  }
  void EndAfter(MonotonicNs silence_ns) { counter_.End(reading_.time_ns + silence_ns); }
  void Restart() { counter_.Restart(); }
  void Skip(std::int64_t rows) { reading_.index += rows; }
  [[nodiscard]] std::uint64_t Count() const { return counter_.gaps(); }

 private:
  GapCounter counter_;
  Reading reading_;
};

TEST(GapCounter, AUniformGridHasAGapWhereTheIndexJumps) {
  Gaps gaps(Timing::kUniform);
  gaps.Rows(10, 0, 0);
  EXPECT_EQ(gaps.Count(), 0U);
  gaps.Skip(1);
  gaps.Rows(10, 0, 0);
  EXPECT_EQ(gaps.Count(), 1U);
}

TEST(GapCounter, APolledSensorHasAGapAfterEightUsualIntervals) {
  Gaps gaps(Timing::kPolled);
  gaps.Rows(100, 8 * kMs, 0);
  gaps.Rows(100, 8 * kMs, 60 * kMs);
  EXPECT_EQ(gaps.Count(), 0U);
  for (int i = 0; i < 20; ++i) gaps.Rows(10, 8 * kMs, 1000 * kMs);
  EXPECT_EQ(gaps.Count(), 20U) << "gaps do not become the usual interval";
}

TEST(GapCounter, AStallAfterWhichAllArrivesIsNoGap) {
  Gaps gaps(Timing::kArrival);
  gaps.Rows(20'000, kMs / 10, 0);
  gaps.Rows(3'000, 0, 300 * kMs);  // 300 ms of lines at one instant
  gaps.Rows(20'000, kMs / 10, kMs / 10);
  EXPECT_EQ(gaps.Count(), 0U);
}

TEST(GapCounter, ASilenceThatNothingMakesUpForIsAGap) {
  Gaps gaps(Timing::kArrival);
  for (int i = 0; i < 5; ++i) gaps.Rows(20'000, kMs / 10, 300 * kMs);
  EXPECT_EQ(gaps.Count(), 4U);
}

TEST(GapCounter, BurstsOfUsbAreNoGaps) {
  Gaps gaps(Timing::kArrival);
  for (int burst = 0; burst < 500; ++burst) gaps.Rows(160, 0, 16 * kMs);
  EXPECT_EQ(gaps.Count(), 0U);
}

TEST(GapCounter, TheEndDecidesWhatIsStillOpen) {
  Gaps lost(Timing::kArrival);
  lost.Rows(1000, kMs, 0);
  lost.Rows(50, kMs, 300 * kMs);
  EXPECT_EQ(lost.Count(), 1U);
  Gaps stalled(Timing::kArrival);
  stalled.Rows(1000, kMs, 0);
  stalled.Rows(300, 0, 300 * kMs);
  EXPECT_EQ(stalled.Count(), 0U);
}

TEST(GapCounter, ASilenceUpToTheEndIsAGapToo) {
  for (const Timing timing : {Timing::kArrival, Timing::kPolled}) {
    Gaps gaps(timing);
    gaps.Rows(1000, kMs, 0);
    gaps.EndAfter(40 * kMs);
    EXPECT_EQ(gaps.Count(), 0U) << "as bursts of USB come";
    gaps.EndAfter(60 * kMs);
    EXPECT_EQ(gaps.Count(), 1U);
  }
}

TEST(GapCounter, WhatIsMeantToBeMissingIsNoGap) {
  for (const Timing timing : {Timing::kUniform, Timing::kArrival, Timing::kPolled}) {
    Gaps gaps(timing);
    gaps.Rows(1000, kMs, 0);
    gaps.Restart();
    gaps.Skip(5);
    gaps.Rows(1000, kMs, 5000 * kMs);
    EXPECT_EQ(gaps.Count(), 0U) << Name(timing);
  }
}

}  // namespace
}  // namespace haptometer::acquire
