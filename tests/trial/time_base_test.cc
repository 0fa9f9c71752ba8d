#include "trial/time_base.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/median.h"
#include "tests/residual.h"

namespace haptometer::trial {
namespace {

constexpr std::int64_t kMs = 1'000'000;

// A 10 kHz source whose clock runs at `rate_hz`, behind a USB converter that hands lines out in
// bursts of up to 16 ms, with 5 % of the lines late by up to 100 ms more than that. Lines in `lost`
// never arrive; `stall`: the host sleeps from .. to (seconds) and then gets all that waited.
struct Source {
  double rate_hz = 10'000;
  double duration_s = 3;
  double burst_s = 16e-3;
  std::vector<std::pair<std::size_t, std::size_t>> lost{};  // first line, number of lines
  std::pair<double, double> stall{0, 0};
  unsigned seed = 1;
  bool has_late_lines = true;
};

std::vector<std::int64_t> Arrivals(const Source& source) {
  std::mt19937_64 random(source.seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<std::int64_t> arrivals;
  const auto lines = static_cast<std::size_t>(source.duration_s * source.rate_hz);
  double burst_end_s = 0;
  double latest_s = 0;
  for (std::size_t line = 0; line < lines; ++line) {
    const double sent_s = 0.2 + static_cast<double>(line) / source.rate_hz;
    // a burst lasts up to burst_s and is handed out at its end
    if (sent_s > burst_end_s) burst_end_s = sent_s + source.burst_s * uniform(random);
    double arrived_s = burst_end_s;
    if (source.has_late_lines && uniform(random) < 0.05 / 160) arrived_s += 0.1 * uniform(random);
    if (arrived_s > source.stall.first && arrived_s < source.stall.second) {
      arrived_s = source.stall.second;
    }
    latest_s = std::max(latest_s, arrived_s);
    const bool is_lost = std::ranges::any_of(
        source.lost, [&](const auto& l) { return line >= l.first && line < l.first + l.second; });
    if (!is_lost) arrivals.push_back(std::llround(latest_s * 1e9));
  }
  return arrivals;
}

class BurstyLines : public ::testing::TestWithParam<unsigned> {};

TEST_P(BurstyLines, GiveTheRateOfTheSource) {
  for (const double rate_hz : {10'000.0, 10'003.7, 1'000.0}) {
    const auto arrivals = Arrivals({.rate_hz = rate_hz, .seed = GetParam()});
    for (const std::optional<double> nominal : {std::optional<double>(), {10'000.0}}) {
      const auto stretches = FitArrivalTimes(arrivals, nominal);
      ASSERT_EQ(stretches.size(), 1) << rate_hz;
      EXPECT_EQ(stretches[0].rows, arrivals.size());
      EXPECT_REL(stretches[0].rate_hz, rate_hz, rate_hz > 5000 ? 1e-5 : 2e-4,
                 "least delay in a burst: up to a period, over 3 s");
      EXPECT_ABS(stretches[0].start_s, 0.2, 0.5 / rate_hz, "least delay of a third of the bursts");
      EXPECT_LT(stretches[0].time_uncertainty_s, 1 / rate_hz);
    }
  }
}

TEST_P(BurstyLines, ShowLostLinesAsAGap) {
  for (const std::size_t lost : {1U, 3U, 40U, 5000U}) {
    const auto arrivals =
        Arrivals({.lost = {{14'000, lost}}, .seed = GetParam(), .has_late_lines = false});
    const auto stretches = FitArrivalTimes(arrivals, 10'000);
    ASSERT_EQ(stretches.size(), 2) << lost << " lines lost";
    // within a few bursts of 160 lines around the loss
    EXPECT_NEAR(static_cast<double>(stretches[1].first_row), 14'000, 640);
    const double end_s =
        stretches[0].start_s + static_cast<double>(stretches[0].rows) / stretches[0].rate_hz;
    EXPECT_ABS((stretches[1].start_s - end_s) * 10'000, static_cast<double>(lost), 0.6,
               "the least delays of both sides, in periods");
  }
}

// losses that come more often than the windows the slope is taken over must not become the slope
TEST(ArrivalTimes, ALineLostEveryHalfSecondIsAGapEachTime) {
  for (const double rate_hz : {1'000.0, 10'000.0}) {
    Source source{.rate_hz = rate_hz, .duration_s = 6, .burst_s = 0, .has_late_lines = false};
    for (int loss = 1; loss < 12; ++loss) {
      source.lost.emplace_back(static_cast<std::size_t>(0.5 * loss * rate_hz), 1);
    }
    std::vector<std::int64_t> arrivals = Arrivals(source);
    std::mt19937_64 random(7);
    std::exponential_distribution<double> delay_ns(1 / 20e3);  // as a prompt host's
    for (std::int64_t& time_ns : arrivals) time_ns += std::llround(delay_ns(random));
    const auto stretches = FitArrivalTimes(arrivals, std::nullopt);
    EXPECT_EQ(stretches.size(), 12U) << rate_hz;
    for (const Stretch& stretch : stretches) {
      EXPECT_REL(stretch.rate_hz, rate_hz, 2e-4, "a microsecond of delay over half a second");
    }
  }
}

// One line in 3000 is lost: each is a gap, and the rate is that of the source, not of what arrives.
TEST(ArrivalTimes, OfASourceThatKeepsLosingLinesHaveItsRate) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Source source{.rate_hz = 4000, .duration_s = 8, .burst_s = 5e-4, .seed = seed};
    for (std::size_t line = 2000; line < 32'000; line += 3000) source.lost.emplace_back(line, 1);
    const auto stretches = FitArrivalTimes(Arrivals(source), std::nullopt);
    // a late line beside a loss may look like one more
    EXPECT_NEAR(static_cast<double>(stretches.size()), 11, 1) << seed;
    for (const Stretch& stretch : stretches) {
      EXPECT_REL(stretch.rate_hz, 4000, 1e-5, "a hundredth of a period in each 0.7 s, averaged");
    }
  }
}

TEST_P(BurstyLines, AStallOfTheHostIsNoGap) {
  for (const double length_s : {0.05, 0.2, 0.4}) {
    const auto arrivals = Arrivals({.stall = {1.5, 1.5 + length_s}, .seed = GetParam()});
    const auto stretches = FitArrivalTimes(arrivals, 10'000);
    ASSERT_EQ(stretches.size(), 1) << length_s;
    EXPECT_REL(stretches[0].rate_hz, 10'000, 1e-5, "the line below does not see late lines");
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, BurstyLines, ::testing::Range(1U, 41U));

TEST(ArrivalTimes, TwoLossesAndAStallAreTwoGaps) {
  // a late burst right beside a loss can look like one gap more, so one seed in 20 may differ
  int right = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const auto arrivals = Arrivals(
        {.duration_s = 6, .lost = {{15'000, 2}, {40'000, 7}}, .stall = {2.4, 2.8}, .seed = seed});
    const auto stretches = FitArrivalTimes(arrivals, 10'000);
    if (stretches.size() != 3) continue;
    ++right;
    for (std::size_t i = 1; i < 3; ++i) {
      const Stretch& before = stretches[i - 1];
      const double end_s = before.start_s + static_cast<double>(before.rows) / before.rate_hz;
      EXPECT_ABS((stretches[i].start_s - end_s) * 10'000, i == 1 ? 2 : 7, 0.6,
                 "the least delays of both sides, in periods");
    }
  }
  EXPECT_GE(right, 38);
}

// `rows` times `period_ms` apart; from row `pause_at` on `pause_periods` later
std::vector<std::int64_t> Regular(std::int64_t rows, std::int64_t period_ms,
                                  std::int64_t pause_at = 0, std::int64_t pause_periods = 0) {
  std::vector<std::int64_t> times;
  times.reserve(static_cast<std::size_t>(rows));
  for (std::int64_t i = 0; i < rows; ++i) {
    times.push_back((i + (i >= pause_at ? pause_periods : 0)) * period_ms * kMs);
  }
  return times;
}

TEST(ArrivalTimes, WithoutDelaysAreExact) {
  std::vector<std::int64_t> times = Regular(500, 10);
  for (std::int64_t& t : times) t += 7 * kMs;
  const auto stretches = FitArrivalTimes(times, std::nullopt);
  ASSERT_EQ(stretches.size(), 1);
  EXPECT_REL(stretches[0].rate_hz, 100, 1e-15, "doubles of nanoseconds");
  EXPECT_ABS(stretches[0].start_s, 0.007, 1e-15, "doubles of nanoseconds");
  EXPECT_EQ(stretches[0].time_uncertainty_s, 0);
}

TEST(ArrivalTimes, AShiftInTimeShiftsOnlyTheStart) {
  auto times = Arrivals({});
  const auto before = FitArrivalTimes(times, 10'000);
  for (auto& t : times) t += 1'000'000'000;
  const auto after = FitArrivalTimes(times, 10'000);
  ASSERT_EQ(before.size(), after.size());
  EXPECT_EQ(before[0].rate_hz, after[0].rate_hz);
  EXPECT_ABS(after[0].start_s - before[0].start_s, 1, 1e-15, "one rounding");
}

TEST(ArrivalTimes, KnownBreaksBeginStretchesAndShortOnesTakeTheCommonRate) {
  const auto times = Arrivals({});
  const std::vector<MissingRows> missing{
      {.row = 0}, {.row = 100}, {.row = 100}, {.row = times.size()}};
  const auto stretches = FitArrivalTimes(times, std::nullopt, missing);
  ASSERT_EQ(stretches.size(), 2);
  EXPECT_EQ(stretches[0].rows, 100);
  EXPECT_EQ(stretches[1].first_row, 100);
  EXPECT_REL(stretches[0].rate_hz, stretches[1].rate_hz, 1e-12, "the same line, rounded twice");
}

// --- a host that stalls again and again --------------------------------------------------------

struct Stalls {
  const char* name;
  std::vector<std::pair<double, double>> at_s;  // from .. to: what is due then arrives at the end
};

// 9 s of lines that arrive some 30 us after they were sent, or when a stall is over, at a million
// lines a second. `lost` lines are missing from place `lost_from` on.
struct StalledLines {
  std::vector<std::int64_t> times_ns;
  std::vector<MissingRows> missing;
};

StalledLines Stalled(double rate_hz, const Stalls& stalls, std::size_t lost_from = 0,
                     std::size_t lost = 0) {
  constexpr double kFastS = 1e-6;
  std::mt19937_64 random(3);
  std::exponential_distribution<double> delay_s(1 / 30e-6);
  StalledLines lines;
  double latest_s = 0;
  for (std::size_t place = 0; place < static_cast<std::size_t>(9 * rate_hz); ++place) {
    const double sent_s = static_cast<double>(place) / rate_hz;
    double arrived_s = sent_s + delay_s(random);
    for (const auto& [from_s, to_s] : stalls.at_s) {
      if (arrived_s > from_s && arrived_s < to_s) arrived_s = to_s;
    }
    arrived_s = std::max(arrived_s, latest_s + kFastS);
    if (arrived_s > 9.5) break;
    latest_s = arrived_s;
    if (place >= lost_from && place < lost_from + lost) {
      if (place == lost_from) lines.missing.push_back({lines.times_ns.size(), lost});
      continue;
    }
    lines.times_ns.push_back(std::llround(arrived_s * 1e9));
  }
  return lines;
}

class StalledHost : public ::testing::TestWithParam<Stalls> {};

// the median delay of some thousand lines, over seconds
constexpr double kRateTolerance = 1e-4;

TEST_P(StalledHost, LosesNoLineAndKeepsTheRate) {
  for (const double rate_hz : {700.0, 2900.0, 8300.0}) {
    const StalledLines lines = Stalled(rate_hz, GetParam());
    for (const bool is_numbered : {false, true}) {
      const auto stretches = FitArrivalTimes(lines.times_ns, 10'240, {}, is_numbered);
      ASSERT_EQ(stretches.size(), 1) << rate_hz << ", numbered: " << is_numbered;
      EXPECT_REL(stretches[0].rate_hz, rate_hz, kRateTolerance, "delays of 30 us over seconds");
      EXPECT_ABS(stretches[0].start_s, 0, 2e-4, "the least delay, and the rate's error times 2 s");
      EXPECT_LT(stretches[0].time_uncertainty_s, 1e-4);
    }
  }
}

// the numbers tell how many: the stretches lie on one grid
TEST_P(StalledHost, WithNumberedLinesALossIsExact) {
  for (const double rate_hz : {700.0, 2900.0, 8300.0}) {
    for (const double at_s : {0.2, 3.6, 5.9}) {
      for (const std::size_t lost : {1U, 37U, 650U}) {
        const auto from = static_cast<std::size_t>(at_s * rate_hz);
        const StalledLines lines = Stalled(rate_hz, GetParam(), from, lost);
        const auto stretches = FitArrivalTimes(lines.times_ns, 10'240, lines.missing, true);
        ASSERT_EQ(stretches.size(), 2) << rate_hz << " " << at_s << " " << lost;
        EXPECT_EQ(stretches[1].first_row, from);
        EXPECT_EQ(stretches[1].rate_hz, stretches[0].rate_hz);
        EXPECT_REL(stretches[0].rate_hz, rate_hz, kRateTolerance, "delays of 30 us over seconds");
        EXPECT_ABS((stretches[1].start_s - stretches[0].start_s) * stretches[0].rate_hz,
                   static_cast<double>(from + lost), 1e-6, "one line, rounded");
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Places, StalledHost,
    ::testing::Values(
        Stalls{"None", {}}, Stalls{"One", {{2.5, 7.1}}},
        Stalls{"Three", {{0.9, 2.8}, {3.9, 5.7}, {6.4, 8.5}}}, Stalls{"AtTheBegin", {{0, 2.2}}},
        Stalls{"AtTheEnd", {{6.8, 9.3}}}, Stalls{"AtBothEnds", {{0, 1.7}, {4, 5.5}, {7.6, 9.4}}},
        Stalls{"OneBehindTheOther", {{1, 3}, {3.003, 5}, {5.004, 6.5}}},
        Stalls{"Six", {{0.5, 1.5}, {1.9, 3.1}, {3.5, 4.7}, {5.1, 6.3}, {6.6, 7.6}, {8, 8.8}}}),
    [](const auto& at) { return std::string(at.param.name); });

TEST(ArrivalTimes, ALossBesideAStallIsFoundWithoutNumbers) {
  for (const double rate_hz : {1000.0, 5000.0}) {
    const auto lost = static_cast<std::size_t>(0.05 * rate_hz);
    const StalledLines lines =
        Stalled(rate_hz, {"", {{1, 2.6}, {6, 7.9}}}, static_cast<std::size_t>(4 * rate_hz), lost);
    const auto stretches = FitArrivalTimes(lines.times_ns, 10'240);
    ASSERT_EQ(stretches.size(), 2);
    const double end_s =
        stretches[0].start_s + static_cast<double>(stretches[0].rows) / stretches[0].rate_hz;
    EXPECT_ABS((stretches[1].start_s - end_s) * rate_hz, static_cast<double>(lost), 0.5,
               "both rates' errors over 4 s");
  }
}

// numbers begin again after a turn: a loss of whole turns shows as a pause that nothing makes up
// for
TEST(ArrivalTimes, APauseThatTheNumbersDoNotExplainBeginsAStretch) {
  const auto times = Regular(4000, 1, 2000, 1000);
  const auto stretches = FitArrivalTimes(times, 1000, {}, true);
  ASSERT_EQ(stretches.size(), 2);
  EXPECT_EQ(stretches[1].first_row, 2000);
  EXPECT_EQ(FitArrivalTimes(times, 1000, std::vector<MissingRows>{{2000, 1000}}, true).size(), 2);
}

// --- thresholds, with lines that arrive when they are sent ------------------------------------

// line j arrives j `period_ns` after the first, and `late_ns(j)` later
std::vector<std::int64_t> Lines(std::size_t count, double period_ns, const auto& late_ns) {
  std::vector<std::int64_t> times;
  for (std::size_t j = 0; j < count; ++j) {
    times.push_back(std::llround(static_cast<double>(j) * period_ns + late_ns(j)));
  }
  return times;
}

// all lines from `from` on are late by as much
auto LateFrom(std::size_t from, double late_ns) {
  return [=](std::size_t j) { return j < from ? 0.0 : late_ns; };
}

TEST(ArrivalTimes, APauseIsLongerThanAQuarterOfASecondAndEightPeriods) {
  struct Case {
    double period_ns;
    double late_ns;
    std::size_t stretches;
  };
  for (const Case& at : {Case{1e6, 0.249e9, 1}, Case{1e6, 0.251e9, 2}, Case{50e6, 0.397e9, 1},
                         Case{50e6, 0.403e9, 2}}) {
    const auto times = Lines(2000, at.period_ns, LateFrom(1000, at.late_ns));
    EXPECT_EQ(FitArrivalTimes(times, std::nullopt, {}, true).size(), at.stretches) << at.late_ns;
  }
}

// 1 s late from line 2000 on; then the lines come twice as fast until they are late by `end_ns`
TEST(ArrivalTimes, APauseOfWhichHalfIsMadeUpForIsAStall) {
  for (const double end_ns : {0.495e9, 0.505e9}) {
    const auto times = Lines(8000, 1e6, [=](std::size_t j) {
      return j < 2000 ? 0.0 : std::max(end_ns, 1e9 - 0.5e6 * static_cast<double>(j - 2000));
    });
    EXPECT_EQ(FitArrivalTimes(times, std::nullopt, {}, true).size(), end_ns > 0.5e9 ? 2U : 1U);
  }
}

TEST(ArrivalTimes, ARiseExceedsHalfAPeriod) {
  for (const double late_ns : {0.495e6, 0.505e6}) {
    const auto times = Lines(4096, 1e6, LateFrom(2048, late_ns));
    EXPECT_EQ(FitArrivalTimes(times, std::nullopt).size(), late_ns > 0.5e6 ? 2U : 1U) << late_ns;
  }
}

// 5 ms late for `windows` windows of 128 lines; then the lines catch up within one
TEST(ArrivalTimes, ARiseOutlastsTenWindows) {
  for (const std::size_t windows : {9U, 10U}) {
    const std::size_t end = 2048 + 128 * windows;
    const auto times = Lines(6016, 1e6, [=](std::size_t j) {
      if (j < 2048) return 0.0;
      return j < end ? 5e6 : std::max(0.0, 5e6 - 0.8e6 * static_cast<double>(j - end));
    });
    EXPECT_EQ(FitArrivalTimes(times, std::nullopt).size(), windows < 10 ? 1U : 2U) << windows;
  }
}

TEST(ArrivalTimes, AtTheEndARiseOutlastsTwoWindows) {
  for (const std::size_t windows : {1U, 2U}) {
    const auto times = Lines(4096, 1e6, LateFrom(4096 - 128 * windows, 5e6));
    EXPECT_EQ(FitArrivalTimes(times, std::nullopt).size(), windows) << windows;
  }
}

// 3 ms late in the last window but one, and 6 ms in the last: one rise, where it begins
TEST(ArrivalTimes, ARiseInTwoStepsAtTheEndBeginsWithTheFirst) {
  const auto times = Lines(4096, 1e6, [](std::size_t j) {
    return j < 3840 ? 0.0 : j < 3968 ? 3e6 : 6e6;
  });
  const auto stretches = FitArrivalTimes(times, std::nullopt);
  ASSERT_EQ(stretches.size(), 2);
  EXPECT_EQ(stretches[1].first_row, 3840);
}

// 3 rows are missing before row 500, 40 of which nothing is known before row 1000, 7 before 1500
TEST(ArrivalTimes, KnownLossesDivideThePieceThatTheyLieIn) {
  const std::vector<MissingRows> missing{{500, 3}, {1000, std::nullopt}, {1500, 7}};
  const auto times = Lines(2000, 1e6, [](std::size_t j) {
    return 1e6 * ((j < 500 ? 0 : 3) + (j < 1000 ? 0 : 40) + (j < 1500 ? 0 : 7));
  });
  for (const bool is_numbered : {false, true}) {
    const auto stretches = FitArrivalTimes(times, std::nullopt, missing, is_numbered);
    ASSERT_EQ(stretches.size(), 4);
    const double start_s[]{0, 0.503, 1.043, 1.550};
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(stretches[k].first_row, 500 * k);
      EXPECT_REL(stretches[k].rate_hz, 1000, 1e-12, "exact times");
      EXPECT_ABS(stretches[k].start_s, start_s[k], 1e-11, "exact times");
    }
  }
}

// windows of 128 lines that are in turn on time and 0.2 ms late: their differences have the
// median 0.2 ms, of which the scatter is 1.4826 times as much
TEST(ArrivalTimes, ARiseExceedsThreeTimesTheScatterOfTheMinima) {
  const double least_ns = 3 * kDeviationsPerMedian * 0.2e6;
  for (const double share : {0.99, 1.01}) {
    const auto times = Lines(4096, 1e6, [=](std::size_t j) {
      return (j / 128 % 2 == 1 ? 0.2e6 : 0.0) + (j < 2048 ? 0.0 : share * least_ns);
    });
    EXPECT_EQ(FitArrivalTimes(times, std::nullopt).size(), share > 1 ? 2U : 1U) << share;
  }
}

// Five lines are lost before line 2000. Lines ahead of it are late by up to 6 ms, those behind it
// by up to 9 ms more than the loss; the largest interval, 5 ms, is where the lines are missing.
TEST(ArrivalTimes, AmongLateLinesTheLossIsAtTheLargestInterval) {
  const auto times = Lines(4000, 1e6, [](std::size_t j) {
    const auto place = static_cast<double>(j);
    if (j < 1990) return 0.0;
    if (j < 1996) return 0.7e6 * (place - 1989);
    if (j < 2000) return 6e6;
    if (j < 2003) return 10e6 + 2e6 * (place - 2000);
    return std::max(5e6, 14e6 - 0.8e6 * (place - 2002));
  });
  const auto stretches = FitArrivalTimes(times, std::nullopt);
  ASSERT_EQ(stretches.size(), 2);
  EXPECT_EQ(stretches[1].first_row, 2000);
  EXPECT_REL(stretches[1].rate_hz, 1000, 1e-12, "exact times on both sides");
  EXPECT_ABS(stretches[1].start_s, 2.005, 1e-12, "exact times on both sides");
}

// The levels of the windows are 0, 20 and 40 us in turn: their median is 20 us, as is that of the
// deviations from it, but for the first third, which are the line.
TEST(ArrivalTimes, TheUncertaintyIsTheScatterOfTheMinimaAboutTheLine) {
  const auto times = Lines(std::size_t{128} * 31, 1e6,
                           [](std::size_t j) { return 20e3 * static_cast<double>(j / 128 % 3); });
  const auto stretches = FitArrivalTimes(times, std::nullopt, {}, true);
  ASSERT_EQ(stretches.size(), 1);
  EXPECT_REL(stretches[0].rate_hz, 1000, 1e-12, "the line through the windows on time");
  EXPECT_REL(stretches[0].time_uncertainty_s, 1.482602218505602 * 20e-6, 1e-9, "rounding of 4 s");
}

// 4000 lines at 1 kHz, and behind a break some of a source that is 1 % faster. The first window of
// 128 rows behind the break does not count; ten windows show a rate of their own.
TEST(ArrivalTimes, APieceOfTenWindowsHasItsOwnRateAndAShorterOneTheCommonOne) {
  constexpr double kFastNs = 0.99e6;
  const std::vector<MissingRows> missing{{.row = 4000}};
  for (const std::size_t behind : {1400U, 1416U}) {
    const auto times = Lines(4000 + behind, 1e6, [](std::size_t j) {
      return j < 4000 ? 0.0 : (kFastNs - 1e6) * static_cast<double>(j - 4000);
    });
    const auto stretches = FitArrivalTimes(times, std::nullopt, missing, true);
    ASSERT_EQ(stretches.size(), 2);
    EXPECT_REL(stretches[0].rate_hz, 1000, 1e-12, "exact times");
    // weighted by the cubes of the rows that count
    const double first = std::pow(4000, 3), second = std::pow(1400 - 128, 3);
    const double common_ns = (first * 1e6 + second * kFastNs) / (first + second);
    const double period_ns = behind == 1400 ? common_ns : kFastNs;
    EXPECT_REL(stretches[1].rate_hz, 1e9 / period_ns, 1e-9, "rounding of 4 s");
  }
}

TEST(ArrivalTimes, FewRowsTakeTheNominalRate) {
  EXPECT_TRUE(FitArrivalTimes({}, 10).empty());
  const std::vector<std::int64_t> one{5 * kMs};
  EXPECT_EQ(FitArrivalTimes(one, 10).at(0).rate_hz, 10);
  for (const std::optional<double> none : {std::optional<double>(), {0.0}, {-10.0}}) {
    EXPECT_TRUE(std::isinf(FitArrivalTimes(one, none).at(0).rate_hz));
    EXPECT_TRUE(std::isinf(FitPolledTimes(one, one, none).at(0).rate_hz));
  }
  EXPECT_EQ(FitArrivalTimes(one, std::nullopt).at(0).start_s, 0.005);
  const std::vector<std::int64_t> three{0, 100 * kMs, 200 * kMs};
  EXPECT_REL(FitArrivalTimes(three, std::nullopt).at(0).rate_hz, 10, 1e-15, "exact times");
  const std::vector<std::int64_t> at_once{kMs, kMs, kMs};
  EXPECT_EQ(FitArrivalTimes(at_once, 10).at(0).rate_hz, 10);
}

TEST(ArrivalTimes, APauseInAShortRecordingIsAGap) {
  const auto times = Regular(20, 10, 15, 100);
  const auto stretches = FitArrivalTimes(times, 100);
  ASSERT_EQ(stretches.size(), 2);
  EXPECT_EQ(stretches[1].first_row, 15);
  EXPECT_EQ(stretches[1].start_s, 1.15);
}

TEST(ArrivalTimes, OfASourceThatIsSilentMostOfTheTimeEveryPauseIsAGap) {
  // 0.2 s of lines in each 0.5 s; its rate was taken for the mean one, 2000 in a second
  Source source{.rate_hz = 5000, .duration_s = 5.2, .burst_s = 1e-3, .has_late_lines = false};
  for (std::size_t k = 0; k < 10; ++k) source.lost.emplace_back(1000 + 2500 * k, 1500);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    source.seed = seed;
    const auto stretches = FitArrivalTimes(Arrivals(source), std::nullopt);
    ASSERT_EQ(stretches.size(), 11) << seed;
    for (std::size_t k = 0; k < stretches.size(); ++k) {
      EXPECT_REL(stretches[k].rate_hz, 5000, 2e-3, "bursts of 1 ms in 0.2 s, both ends");
      EXPECT_ABS(stretches[k].start_s, 0.2 + 0.5 * static_cast<double>(k), 1.5e-3, "a burst");
    }
  }
}

TEST(PolledTimes, HaveTheMeanRateAndTheUncertaintyOfTheWait) {
  // a poll each 20 ms whose reply takes 12 ms
  const auto requests = Regular(100, 20);
  auto replies = requests;
  for (std::int64_t& t : replies) t += 12 * kMs;
  const auto stretches = FitPolledTimes(requests, replies, std::nullopt);
  ASSERT_EQ(stretches.size(), 1);
  EXPECT_REL(stretches[0].rate_hz, 50, 1e-15, "exact times");
  EXPECT_ABS(stretches[0].start_s, 0.006, 1e-16, "the middle of request and reply");
  EXPECT_REL(stretches[0].time_uncertainty_s, 0.012 / std::sqrt(12.0), 1e-15,
             "uniform within the wait");
}

// Times of the readings are off the line by 1 ms in the pattern + - - +, whose sums with 1 and with
// the row are 0; the waits are 2 and 10 ms in turn.
TEST(PolledTimes, TheUncertaintyIsOfTheScatterAndOfTheWaits) {
  std::vector<std::int64_t> requests;
  std::vector<std::int64_t> replies;
  for (std::int64_t j = 0; j < 40; ++j) {
    const std::int64_t off = j % 4 == 0 || j % 4 == 3 ? kMs : -kMs;
    const std::int64_t half_wait = j % 2 == 0 ? kMs : 5 * kMs;
    const std::int64_t middle = 1000 * kMs + 20 * kMs * j + off;
    requests.push_back(middle - half_wait);
    replies.push_back(middle + half_wait);
  }
  const auto stretches = FitPolledTimes(requests, replies, std::nullopt);
  ASSERT_EQ(stretches.size(), 1);
  EXPECT_REL(stretches[0].rate_hz, 50, 1e-12, "rounding of 1 s");
  EXPECT_ABS(stretches[0].start_s, 1, 1e-12, "rounding of 1 s");
  // the mean square of the waits is (2^2 + 10^2) / 2 ms^2
  EXPECT_REL(stretches[0].time_uncertainty_s, 1e-3 * std::sqrt(1 + 52.0 / 12), 1e-9, "the same");
}

TEST(PolledTimes, APauseIsLongerThanEightMedianIntervals) {
  for (const std::int64_t pause_ms : {159, 160, 161}) {
    auto times = Regular(100, 20);
    for (std::size_t j = 60; j < 100; ++j) times[j] += (pause_ms - 20) * kMs;
    EXPECT_EQ(FitPolledTimes(times, times, 50).size(), pause_ms > 160 ? 2U : 1U) << pause_ms;
  }
}

TEST(PolledTimes, APauseBehindTheFirstRowOrBeforeTheLastBeginsAStretch) {
  for (const std::size_t row : {1U, 99U}) {
    auto times = Regular(100, 20);
    for (std::size_t j = row; j < 100; ++j) times[j] += 500 * kMs;
    const auto stretches = FitPolledTimes(times, times, 50);
    ASSERT_EQ(stretches.size(), 2) << row;
    EXPECT_EQ(stretches[1].first_row, row);
    EXPECT_ABS(stretches[1].start_s, 0.5 + 0.02 * static_cast<double>(row), 1e-12, "exact times");
  }
}

TEST(PolledTimes, TwoRowsTakeTheCommonRateAndThreeTheirOwn) {
  auto times = Regular(100, 20);
  // the last rows are 30 ms apart, behind a break
  times[98] = times[97] + 30 * kMs;
  times[99] = times[98] + 30 * kMs;
  const std::vector<std::size_t> two{98}, three{97};
  const auto with_two = FitPolledTimes(times, times, 50, two);
  ASSERT_EQ(with_two.size(), 2);
  EXPECT_REL(with_two[1].rate_hz, 50, 1e-12, "the median interval");
  // the line goes through the mean of both
  EXPECT_ABS(with_two[1].start_s, 1.97 + 0.015 - 0.01, 1e-12, "rounding of 2 s");
  const auto with_three = FitPolledTimes(times, times, 50, three);
  ASSERT_EQ(with_three.size(), 2);
  EXPECT_REL(with_three[1].rate_hz, 1 / 0.03, 1e-12, "exact times");
}

TEST(PolledTimes, OneRowTakesTheNominalRate) {
  const std::vector<std::int64_t> request{4 * kMs}, reply{6 * kMs};
  const auto stretch = FitPolledTimes(request, reply, 25).at(0);
  EXPECT_EQ(stretch.rate_hz, 25);
  EXPECT_EQ(stretch.start_s, 0.005);
  // as two at the same time do; three show that they have none
  for (const std::size_t rows : {1U, 2U, 3U}) {
    const std::vector<std::int64_t> at_once(rows, 4 * kMs);
    EXPECT_EQ(FitPolledTimes(at_once, at_once, 25).at(0).rate_hz, rows < 3 ? 25 : 1 / 0.0) << rows;
  }
  EXPECT_TRUE(FitPolledTimes({}, {}, 25).empty());
}

TEST(UniformGrid, ABlockThatDoesNotFollowBeginsAStretch) {
  UniformGrid grid(1000);
  grid.Append(5, 10);
  grid.Append(15, 2);  // follows
  grid.Append(18, 4);  // one is missing
  const auto& stretches = grid.stretches();
  ASSERT_EQ(stretches.size(), 2);
  EXPECT_EQ(stretches[0].first_row, 0);
  EXPECT_EQ(stretches[0].rows, 12);
  EXPECT_EQ(stretches[0].start_s, 0.005);
  EXPECT_EQ(stretches[1].first_row, 12);
  EXPECT_EQ(stretches[1].rows, 4);
  EXPECT_EQ(stretches[1].start_s, 0.018);
  EXPECT_EQ(stretches[1].rate_hz, 1000);
  EXPECT_EQ(stretches[1].time_uncertainty_s, 0);
}

TEST(PolledTimes, APauseBeginsAStretch) {
  const auto times = Regular(100, 20, 60, 50);
  const auto stretches = FitPolledTimes(times, times, 50);
  ASSERT_EQ(stretches.size(), 2);
  EXPECT_EQ(stretches[1].first_row, 60);
  EXPECT_ABS(stretches[1].start_s, 2.2, 1e-15, "exact times");
}

}  // namespace
}  // namespace haptometer::trial
