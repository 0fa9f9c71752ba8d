// Pieces, windows and lower lines of arrival times: against closed forms, and the line below all
// points against a search of every pair of them.
#include "trial/time_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "tests/residual.h"

namespace haptometer::trial {
namespace {

// times and places that a TimedRows is a view of
struct Rows {
  std::vector<double> times{};
  std::vector<double> places{};
  [[nodiscard]] TimedRows view() const { return {times, places}; }
};

// `count` rows at their places 0, 1, ..., each at place * period + its delay
Rows Delayed(std::size_t count, double period_ns, const auto& delay_ns) {
  Rows rows;
  for (std::size_t j = 0; j < count; ++j) {
    rows.places.push_back(AsDouble(j));
    rows.times.push_back(AsDouble(j) * period_ns + delay_ns(j));
  }
  return rows;
}

Rows Prompt(std::size_t count, double period_ns) {
  return Delayed(count, period_ns, [](std::size_t /*j*/) { return 0.0; });
}

std::vector<std::pair<std::size_t, std::size_t>> EndsOf(const auto& pieces) {
  std::vector<std::pair<std::size_t, std::size_t>> ends;
  for (const auto& piece : pieces) ends.emplace_back(piece.first, piece.end);
  return ends;
}

using Ends = std::vector<std::pair<std::size_t, std::size_t>>;

TEST(TimeLines, PiecesBeginAtTheStartsInAnyOrder) {
  EXPECT_EQ(EndsOf(PiecesBetween(10, {})), (Ends{{0, 10}}));
  EXPECT_EQ(EndsOf(PiecesBetween(10, {7, 3, 3, 0})), (Ends{{0, 3}, {3, 7}, {7, 10}}));
  // a piece of one row; none begins behind the last row
  EXPECT_EQ(EndsOf(PiecesBetween(10, {9, 10, 11})), (Ends{{0, 9}, {9, 10}}));
  EXPECT_EQ(PiecesBetween(10, {7}).back().rows(), 3U);
}

TEST(TimeLines, TimesCountFromTheFirst) {
  const std::vector<std::int64_t> times{5, 7, -3};
  EXPECT_EQ(SinceFirst(times), (std::vector<double>{0, 2, -8}));
  EXPECT_EQ(Differences(std::vector<double>{1, 4, 2}), (std::vector<double>{3, -2}));
  EXPECT_TRUE(Differences(std::vector<double>{1}).empty());
  EXPECT_EQ(RateOf(2e6), 500);
  EXPECT_EQ(RateOf(0), std::numeric_limits<double>::infinity());
}

TEST(TimeLines, OfAPieceLevelsCountFromItsFirstPlace) {
  const Rows rows{.times = {0, 100, 250, 420}, .places = {0, 1, 2, 4}};
  const TimedRows part = rows.view().Of({1, 4});
  EXPECT_EQ(part.size(), 3U);
  EXPECT_EQ(part.Level(0, 100), 100);
  EXPECT_EQ(part.Level(1, 100), 150);
  EXPECT_EQ(part.Level(2, 100), 120);
}

TEST(Windows, TakeTheRemainingRowsIntoTheLast) {
  const Rows rows = Prompt(11, 100);
  EXPECT_EQ(EndsOf(WindowsOf(rows.view(), 100, 4)), (Ends{{0, 4}, {4, 11}}));
  EXPECT_EQ(EndsOf(WindowsOf(rows.view(), 100, 11)), (Ends{{0, 11}}));
  EXPECT_EQ(EndsOf(WindowsOf(rows.view(), 100, 12)), (Ends{{0, 11}}));
  EXPECT_EQ(RowsIn(WindowsOf(rows.view(), 100, 4)), 11U);
}

TEST(Windows, HaveTheLeastOfTheirLevels) {
  const std::vector<double> delays{5, 3, 4, 8, 9, 9, 9, 2, 6, 1};
  const Rows rows = Delayed(delays.size(), 100, [&](std::size_t j) { return delays[j]; });
  const auto windows = WindowsOf(rows.view(), 100, 4);
  ASSERT_EQ(windows.size(), 2U);
  EXPECT_EQ(windows[0].level_ns, 3);
  EXPECT_EQ(windows[1].level_ns, 1);
}

// Rows 4 to 7 take `took_ns` where they took 3 periods of 100 ns at the source
Rows Hurried(double took_ns) {
  return Delayed(12, 100, [=](std::size_t j) {
    if (j < 4 || j > 7) return 0.0;
    return (3 - AsDouble(j - 4)) * (300 - took_ns) / 3;
  });
}

TEST(Windows, OfRowsThatCatchUpAreLeftOut) {
  EXPECT_EQ(EndsOf(WindowsOf(Hurried(225).view(), 100, 4)), (Ends{{0, 4}, {4, 8}, {8, 12}}));
  EXPECT_EQ(EndsOf(WindowsOf(Hurried(223).view(), 100, 4)), (Ends{{0, 4}, {8, 12}}));
  // none is left out where no other is left
  const Rows fast = Prompt(12, 74);
  EXPECT_EQ(EndsOf(WindowsOf(fast.view(), 100, 4)), (Ends{{0, 4}, {4, 8}, {8, 12}}));
}

// a place that is known to be missing lies between the rows too
TEST(Windows, CountThePlacesBetweenTheirRows) {
  Rows rows = Prompt(8, 100);
  for (std::size_t j = 6; j < 8; ++j) rows.places[j] += 1;
  // rows 4 to 7 took 300 ns where four places were sent: 0.75
  EXPECT_EQ(WindowsOf(rows.view(), 100, 4).size(), 2U);
  for (std::size_t j = 6; j < 8; ++j) rows.places[j] += 1;
  EXPECT_EQ(WindowsOf(rows.view(), 100, 4).size(), 1U);
}

// sum of the distances of all rows from a line; infinite where it is above one of them
double DistancesFrom(const Rows& rows, const TimeLine& line) {
  double sum = 0;
  for (std::size_t j = 0; j < rows.times.size(); ++j) {
    const double distance = rows.times[j] - line.start_ns - rows.places[j] * line.period_ns;
    // a line through two of the rows is rounded
    if (distance < -1e-6) return std::numeric_limits<double>::infinity();
    sum += distance;
  }
  return sum;
}

// the least sum over the lines through two rows each
double LeastDistances(const Rows& rows) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < rows.times.size(); ++i) {
    for (std::size_t j = i + 1; j < rows.times.size(); ++j) {
      const double period_ns = (rows.times[j] - rows.times[i]) / (rows.places[j] - rows.places[i]);
      least = std::min(
          least, DistancesFrom(rows, {rows.times[i] - period_ns * rows.places[i], period_ns}));
    }
  }
  return least;
}

TEST(LowerLine, IsBelowAllRowsWithTheLeastSumOfDistances) {
  std::mt19937_64 random(5);
  std::exponential_distribution<double> delay_ns(1 / 300.0);
  for (int turn = 0; turn < 40; ++turn) {
    Rows rows = Delayed(40, 1000, [&](std::size_t /*j*/) { return delay_ns(random); });
    // in every other turn three places are missing
    for (std::size_t j = 17; turn % 2 == 1 && j < rows.places.size(); ++j) rows.places[j] += 3;
    const auto windows = WindowsOf(rows.view(), 1000, 50);
    // whichever period the levels are of
    for (const double period_ns : {1000.0, 900.0, 0.0}) {
      const TimeLine line = LowerLine(rows.view(), period_ns, windows);
      EXPECT_REL(DistancesFrom(rows, line), LeastDistances(rows), 1e-9, "rounding of 4e4 ns");
    }
  }
}

TEST(LowerLine, IsThatOfTheRowsInTheWindows) {
  // the first four rows came 500 ns late, the others on time
  const Rows rows = Delayed(12, 100, [](std::size_t j) { return j < 4 ? 500.0 : 7.0; });
  const std::vector<LevelWindow> behind{{.first = 4, .end = 12, .level_ns = 7}};
  const TimeLine line = LowerLine(rows.view(), 90, behind);
  EXPECT_REL(line.period_ns, 100, 1e-14, "rounding");
  EXPECT_REL(line.start_ns, 7, 1e-12, "rounding of 1e3 ns");
}

TEST(LowerLine, OfOneRowKeepsThePeriod) {
  const Rows rows{.times = {40}, .places = {0}};
  const TimeLine line = LowerLine(rows.view(), 25, {{.first = 0, .end = 1, .level_ns = 40}});
  EXPECT_EQ(line.start_ns, 40);
  EXPECT_EQ(line.period_ns, 25);
}

// 0.1 s or more, at least 16 rows, at most an eighth of the rows but for these
TEST(SourcePeriod, IsThatOfRegularRowsWithWindowsOfATenthOfASecond) {
  struct Case {
    std::size_t rows;
    double period_ns;
    std::size_t window_rows;
  };
  for (const Case& at : {Case{500, 10e6, 16}, Case{2000, 6.25e6, 16}, Case{2000, 5.5e6, 32},
                         Case{4000, 1e6, 128}, Case{4000, 0.79e6, 128}, Case{4000, 0.76e6, 256},
                         Case{127, 1e6, 16}, Case{128, 1e6, 32}, Case{10, 1e6, 16}}) {
    const SourcePeriod period = PeriodOf(Prompt(at.rows, at.period_ns).view());
    EXPECT_REL(period.ns, at.period_ns, 1e-9, "rounding of differences of 1e10 ns");
    EXPECT_EQ(period.window_rows, at.window_rows) << at.rows << " " << at.period_ns;
  }
}

// 51 windows of 128 rows, each of which is late as a whole: the delays rise by these steps in turn
Rows Stepped(const std::vector<double>& steps_ns) {
  std::vector<double> levels{1e6};
  for (std::size_t k = 0; k < 50; ++k) levels.push_back(levels[k] + steps_ns[k % steps_ns.size()]);
  return Delayed(std::size_t{51} * 128, 1e6, [&](std::size_t j) { return levels[j / 128]; });
}

// What five of these steps sum to is 0, so over the lag of ten windows nothing rises, and most of
// the steps fall by `fall_ns`: with losses that make up for it, these are the source's.
TEST(SourcePeriod, TakesTheStepsForLossesBeyondHalfAPeriodOverTheLag) {
  for (const double fall_ns : {0.0495e6, 0.0505e6}) {
    const SourcePeriod period =
        PeriodOf(Stepped({-fall_ns, -fall_ns, -fall_ns, -fall_ns, 4 * fall_ns}).view());
    ASSERT_EQ(period.window_rows, 128U);
    // ten windows of it are half a period of 1 ms
    const double expected_ns = fall_ns < 0.05e6 ? 1e6 : 1e6 - fall_ns / 128;
    EXPECT_REL(period.ns, expected_ns, 1e-9, "rounding of 7 s");
  }
}

// The median step falls by a times 0.1 ms, and the median deviation from it is 0.1 ms. Of 50 steps
// the median has the standard uncertainty 1.2533 * 1.4826 * 0.1 ms / sqrt(50), five of which are
// 0.1314 ms.
TEST(SourcePeriod, TakesTheStepsForLossesBeyondFiveUncertainties) {
  const double limit = 5 * std::sqrt(std::acos(-1.0) / 2) * 1.482602218505602 / std::sqrt(50);
  for (const double a : {0.6, 0.99 * limit, 1.01 * limit}) {
    const double unit_ns = 0.1e6;
    const SourcePeriod period =
        PeriodOf(Stepped({(-a - 1) * unit_ns, (-a - 1) * unit_ns, -a * unit_ns, (-a + 1) * unit_ns,
                          (4 * a + 1) * unit_ns})
                     .view());
    const double expected_ns = a < limit ? 1e6 : 1e6 - a * unit_ns / 128;
    EXPECT_REL(period.ns, expected_ns, 1e-9, "rounding of 7 s");
  }
}

// lines for 50 ms at 2 kHz, then silence: more than half of the time
TEST(SourcePeriod, OfASourceThatIsSilentMostOfTheTimeIsThatBetweenItsSilences) {
  Rows rows;
  for (int group = 0; group < 10; ++group) {
    for (int line = 0; line < 100; ++line) {
      rows.places.push_back(AsDouble(rows.places.size()));
      rows.times.push_back(group * (49.5e6 + 0.2501e9) + line * 0.5e6);
    }
  }
  EXPECT_REL(PeriodOf(rows.view()).ns, 0.5e6, 1e-9, "rounding");
}

}  // namespace
}  // namespace haptometer::trial
