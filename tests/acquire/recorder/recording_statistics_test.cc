// What counts as a gap, and the statistics of intervals, against their definitions.
#include "acquire/recorder/recording_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
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

// 1000 a second that come 500 at a time, the first block in part: nothing tells how long it and the
// last one took; the pause of a restart counts neither
TEST(IntervalStatistics, RowsInBlocksHaveTheTimeUpToTheNextBlock) {
  for (const int first : {50, 500, 2000}) {
    IntervalStatistics statistics;
    for (int row = 0; row < first; ++row) statistics.Add(0, 0);
    for (int row = 0; row < 8000; ++row) statistics.Add(500 * kMs * (1 + row / 500), 0);
    EXPECT_REL(statistics.RateHz().value(), 1000.0, 1e-15, "one division") << first;
    statistics.Restart();
    for (int row = 0; row < 2000; ++row) statistics.Add(60'000 * kMs + 500 * kMs * (row / 500), 0);
    EXPECT_REL(statistics.RateHz().value(), 1000.0, 1e-15, "one division") << first;
  }
  // two blocks show no more than their own time
  IntervalStatistics two;
  for (int row = 0; row < 1000; ++row) two.Add(500 * kMs * (row / 500), 0);
  EXPECT_REL(two.RateHz().value(), 999 / 0.5, 1e-15, "one division");
}

// rows, a pause of 5 s, and rows: those behind it are no block, however few are ahead
TEST(IntervalStatistics, RowsBehindAPauseAreNoBlock) {
  for (const int ahead : {1, 10, 4000}) {
    IntervalStatistics statistics;
    MonotonicNs time_ns = 0;
    for (int row = 0; row < ahead; ++row) statistics.Add(time_ns += kMs, 0);
    time_ns += 5000 * kMs;
    for (int row = 0; row < 4000; ++row) statistics.Add(time_ns += kMs, 0);
    EXPECT_REL(statistics.RateHz().value(), (ahead + 3999) / (5 + (ahead + 3999) * 1e-3), 1e-3,
               "a row ahead of the pause");
  }
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

TEST(IntervalStatistics, LostRowsExplainAQuarterOfASecondMoreAndATwentiethLess) {
  IntervalStatistics statistics;
  EXPECT_TRUE(statistics.Explains(0, 5)) << "nothing came before";
  statistics.Add(0, 0);
  EXPECT_FALSE(statistics.Explains(10 * kMs, 5)) << "no interval is known";
  EXPECT_TRUE(statistics.Explains(10'000 * kMs, 0)) << "nothing is said to be lost";
  statistics.Add(10 * kMs, 0);
  // nine rows and the next: 100 ms
  EXPECT_TRUE(statistics.Explains(10 * kMs + 349 * kMs, 9));
  EXPECT_FALSE(statistics.Explains(10 * kMs + 351 * kMs, 9));
  EXPECT_TRUE(statistics.Explains(10 * kMs + 51 * kMs, 9));
  EXPECT_FALSE(statistics.Explains(10 * kMs + 49 * kMs, 9));
}

TEST(IntervalStatistics, BothEndsOfWhatIsExplainedBelongToIt) {
  // rows every 250 ms, one of which is lost: 500 ms, from 450 to 750 ms; none of these is rounded
  // away
  IntervalStatistics statistics;
  statistics.Add(0, 0);
  statistics.Add(250 * kMs, 0);
  EXPECT_TRUE(statistics.Explains(1000 * kMs, 1));
  EXPECT_FALSE(statistics.Explains(1000 * kMs + 1, 1));
  EXPECT_TRUE(statistics.Explains(700 * kMs, 1));
  EXPECT_FALSE(statistics.Explains(700 * kMs - 1, 1));
}

TEST(IntervalStatistics, AnIntervalOverLossesHasNoDeviation) {
  // 10, 12 and 14 ms, and 23 ms over a lost row: mean 12, squares 8, of three; five places in 59 ms
  IntervalStatistics statistics;
  statistics.Add(0, 0);
  statistics.Add(10 * kMs, 0);
  statistics.Add(22 * kMs, 0);
  statistics.Add(45 * kMs, 1);
  statistics.Add(59 * kMs, 0);
  EXPECT_REL(statistics.RateHz().value(), 5 / 0.059, 1e-15, "one division");
  EXPECT_REL(statistics.DeviationSeconds().value(), 2e-3, 1e-12, "roundings of the recurrence");
}

TEST(IntervalStatistics, NeedTwoIntervalsForADeviation) {
  IntervalStatistics statistics;
  EXPECT_EQ(statistics.RateHz(), std::nullopt);
  statistics.Add(0, 0);
  EXPECT_EQ(statistics.RateHz(), std::nullopt);
  statistics.Add(10 * kMs, 0);
  EXPECT_REL(statistics.RateHz().value(), 100, 1e-15, "one division");
  EXPECT_EQ(statistics.DeviationSeconds(), std::nullopt);
  statistics.Add(30 * kMs, 0);
  // 10 and 20 ms: 5 sqrt(2)
  EXPECT_REL(statistics.DeviationSeconds().value(), std::sqrt(50) * 1e-3, 1e-12, "roundings");
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

// gaps of rows `usual_ns` apart with one interval of `long_ns` among them
std::uint64_t GapsWith(Timing timing, MonotonicNs usual_ns, MonotonicNs long_ns) {
  Gaps gaps(timing);
  gaps.Rows(1000, usual_ns, 0);
  gaps.Rows(1000, usual_ns, long_ns);
  return gaps.Count();
}

TEST(GapCounter, AGapIsLongerThanEightUsualIntervals) {
  // a 79 ms silence of a free-running sensor brings too few rows as well, but is no silence yet
  for (const Timing timing : {Timing::kPolled, Timing::kArrival}) {
    EXPECT_EQ(GapsWith(timing, 10 * kMs, 79'500'000), 0U) << Name(timing);
    EXPECT_EQ(GapsWith(timing, 10 * kMs, 80'500'000), 1U) << Name(timing);
  }
}

TEST(GapCounter, ASilenceIsLongerThan50Ms) {
  EXPECT_EQ(GapsWith(Timing::kArrival, kMs, 49'700'000), 0U);
  EXPECT_EQ(GapsWith(Timing::kArrival, kMs, 50'300'000), 1U);
  // a polled sensor has no bursts
  EXPECT_EQ(GapsWith(Timing::kPolled, kMs, 7'950'000), 0U);
  EXPECT_EQ(GapsWith(Timing::kPolled, kMs, 8'050'000), 1U);
}

TEST(GapCounter, SeveralLongIntervalsInARowAreOneGap) {
  Gaps gaps(Timing::kPolled);
  gaps.Rows(100, 8 * kMs, 0);
  gaps.Rows(5, 500 * kMs, 500 * kMs);
  EXPECT_EQ(gaps.Count(), 1U);
  gaps.Rows(2, 8 * kMs, 8 * kMs);
  gaps.Rows(1, 0, 500 * kMs);
  EXPECT_EQ(gaps.Count(), 2U) << "a usual interval lay between them";
}

// 400 ms of silence at a row a ms; `late` rows then come at once, after `before` usual ones
std::uint64_t GapsAfterASilence(int late, int before) {
  Gaps gaps(Timing::kArrival);
  gaps.Rows(1000, kMs, 0);
  gaps.Rows(1 + before, kMs, 400 * kMs);
  if (late > 0) gaps.Rows(late, 0, 0);
  gaps.Rows(1000, kMs, kMs);
  return gaps.Count();
}

TEST(GapCounter, HalfOfTheRowsMakeUpForASilence) {
  // 399 rows are missing; of 400 at least half
  EXPECT_EQ(GapsAfterASilence(199, 0), 1U);
  EXPECT_EQ(GapsAfterASilence(200, 0), 0U);
}

TEST(GapCounter, HalfASecondLaterItIsTooLateToMakeUp) {
  EXPECT_EQ(GapsAfterASilence(399, 499), 0U);
  EXPECT_EQ(GapsAfterASilence(399, 500), 1U);
}

TEST(GapCounter, ASilenceAtTheEndIsMeasuredLikeAnother) {
  const auto gaps_at_end = [](Timing timing, MonotonicNs usual_ns, MonotonicNs silence_ns) {
    Gaps gaps(timing);
    gaps.Rows(1000, usual_ns, 0);
    gaps.EndAfter(silence_ns);
    return gaps.Count();
  };
  EXPECT_EQ(gaps_at_end(Timing::kArrival, kMs, 49'700'000), 0U);
  EXPECT_EQ(gaps_at_end(Timing::kArrival, kMs, 50'300'000), 1U);
  EXPECT_EQ(gaps_at_end(Timing::kPolled, 10 * kMs, 79'500'000), 0U);
  EXPECT_EQ(gaps_at_end(Timing::kPolled, 10 * kMs, 80'500'000), 1U);
  EXPECT_EQ(gaps_at_end(Timing::kUniform, 10 * kMs, 5000 * kMs), 0U) << "rows have no arrival";
}

TEST(GapCounter, NumberedLinesHaveNoSilence) {
  GapCounter counter(Timing::kArrival, true);
  Reading reading;
  for (int row = 0; row < 2000; ++row) {
    reading.time_ns = (row + (row >= 1000 ? 300 : 0)) * kMs;
    counter.Add(reading);
  }
  EXPECT_EQ(counter.gaps(), 0U);
}

}  // namespace
}  // namespace haptometer::acquire
