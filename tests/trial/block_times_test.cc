#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/residual.h"
#include "trial/time_base.h"

// Lines that a converter collects and hands on in blocks: all at one instant, or drawn out.
namespace haptometer::trial {
namespace {

struct Collected {
  double rate_hz = 1000;
  double block_s = 0.4;
  double jitter = 0;     // share of a block by which its length scatters
  double delay_s = 0;    // up to which a block is late
  double drawn_out = 0;  // share of a block in which it is handed on
  double stop_s = 0;     // for which the source stops in the middle
  double duration_s = 12;
  unsigned seed = 1;
};

struct Lines {
  std::vector<double> sent_s;
  std::vector<std::int64_t> times_ns;
};

Lines LinesOf(const Collected& at) {
  std::mt19937_64 random(at.seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Lines lines;
  double block_end_s = 0;
  double length_s = 0;
  double late_s = 0;
  const auto count = static_cast<std::size_t>(at.duration_s * at.rate_hz);
  const double half_s = 0.5 * at.duration_s + 0.3 * at.block_s;
  for (std::size_t line = 0; line < count; ++line) {
    double sent_s = (static_cast<double>(line) + 0.37) / at.rate_hz;
    if (sent_s > half_s) sent_s += at.stop_s;
    while (sent_s > block_end_s) {
      length_s = at.block_s * (1 + at.jitter * (2 * uniform(random) - 1));
      block_end_s += length_s;
      late_s = at.delay_s * uniform(random);
    }
    lines.sent_s.push_back(sent_s);
    // a line at the share x of its block is handed on at the share x of what that is drawn out to
    const double share = 1 - (block_end_s - sent_s) / length_s;
    const double arrived_s = block_end_s + late_s + at.drawn_out * length_s * share;
    lines.times_ns.push_back(std::llround(arrived_s * 1e9));
  }
  for (std::size_t j = 1; j < lines.times_ns.size(); ++j) {
    lines.times_ns[j] = std::max(lines.times_ns[j], lines.times_ns[j - 1]);
  }
  return lines;
}

// the largest error of a fitted time in units of its uncertainty, for which at least `least_s` is
// taken, and the constant delay is left out: the median error
double WorstError(const Lines& lines, const std::vector<Stretch>& stretches, double least_s) {
  std::vector<double> errors, sizes;
  for (const Stretch& of : stretches) {
    for (std::size_t j = 0; j < of.rows; ++j) {
      errors.push_back(of.start_s + static_cast<double>(j) / of.rate_hz -
                       lines.sent_s[of.first_row + j]);
      sizes.push_back(std::max(of.time_uncertainty_s, least_s));
    }
  }
  std::vector<double> sorted = errors;
  std::ranges::nth_element(sorted, sorted.begin() + std::ssize(sorted) / 2);
  const double delay_s = sorted[sorted.size() / 2];
  double worst = 0;
  for (std::size_t j = 0; j < errors.size(); ++j) {
    worst = std::max(worst, std::abs(errors[j] - delay_s) / sizes[j]);
  }
  return worst;
}

constexpr double kRates[] = {100, 2000};
constexpr double kBlocks[] = {0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 1};
constexpr double kJitters[] = {0, 0.3};
// handed on at once, and by a network in some chunks
constexpr double kAtOnce[] = {0, 0.02};

// every combination of them
std::vector<Collected> All(double delay, double stop_s) {
  std::vector<Collected> all;
  for (const double rate_hz : kRates) {
    for (const double block_s : kBlocks) {
      for (const double jitter : kJitters) {
        for (const double drawn_out : kAtOnce) {
          all.push_back({.rate_hz = rate_hz,
                         .block_s = block_s,
                         .jitter = jitter,
                         .delay_s = delay * block_s,
                         .drawn_out = drawn_out,
                         .stop_s = stop_s});
        }
      }
    }
  }
  return all;
}

std::string Words(const Collected& at) {
  return fmt::format("{}/s, block {} +-{}, late {}, drawn out {}, stop {}", at.rate_hz, at.block_s,
                     at.jitter, at.delay_s, at.drawn_out, at.stop_s);
}

TEST(BlockTimes, HaveNoGapsAndTheRateOfAllLines) {
  for (const Collected& at : All(0, 0)) {
    SCOPED_TRACE(Words(at));
    const auto stretches = FitArrivalTimes(LinesOf(at).times_ns, std::nullopt);
    ASSERT_EQ(stretches.size(), 1);
    // a block ends within a period of its line, and as much later as its length scatters
    const double late_s = 1 / at.rate_hz + at.drawn_out * at.jitter * at.block_s;
    EXPECT_REL(stretches[0].rate_hz, at.rate_hz, 2 * late_s / (0.5 * at.duration_s),
               "at both ends of half of the time");
    // behind a silence of more than 0.25 s the source may have paused
    if (at.block_s <= 0.2) {
      EXPECT_LE(stretches[0].time_uncertainty_s, late_s);
    }
    if (at.block_s >= 0.3) {
      EXPECT_ABS(stretches[0].time_uncertainty_s, at.block_s, (at.jitter + 0.03) * at.block_s,
                 "the usual block is one of them");
    }
  }
}

TEST(BlockTimes, ThatAreLateAreNotMoreCertainThanTheyAre) {
  for (const Collected& at : All(0.1, 0)) {
    SCOPED_TRACE(Words(at));
    const Lines lines = LinesOf(at);
    const auto stretches = FitArrivalTimes(lines.times_ns, std::nullopt);
    EXPECT_EQ(stretches.size(), 1);
    EXPECT_LT(WorstError(lines, stretches, 2 / at.rate_hz), 3);
  }
}

// the rows of a block that the pause divides may be a stretch of their own
TEST(BlockTimes, WithAPauseOfTheSourceHaveAGap) {
  for (const auto& [stop_s, delay] : {std::pair(0.5, 0.1), {1.7, 0.0}}) {
    for (const Collected& at : All(delay, stop_s)) {
      SCOPED_TRACE(Words(at));
      const Lines lines = LinesOf(at);
      const auto stretches = FitArrivalTimes(lines.times_ns, std::nullopt);
      // a block as long as the pause hides it
      if (at.block_s < stop_s) {
        EXPECT_GE(stretches.size(), 2);
      }
      EXPECT_LE(stretches.size(), 4);
      EXPECT_LT(WorstError(lines, stretches, 2 / at.rate_hz), 3);
    }
  }
}

// 0.3 of a block's time on the wire: lines of a source that pauses regularly would come alike
TEST(BlockTimes, ThatAreDrawnOutAreUncertain) {
  for (Collected at : All(0, 0)) {
    at.drawn_out = 0.3;
    SCOPED_TRACE(Words(at));
    const Lines lines = LinesOf(at);
    EXPECT_LT(WorstError(lines, FitArrivalTimes(lines.times_ns, std::nullopt), 2 / at.rate_hz), 3);
  }
}

TEST(BlockTimes, OfOneOrTwoBlocksAreUncertain) {
  for (const double duration_s : {2, 3}) {
    const Lines lines = LinesOf({.rate_hz = 3000, .block_s = 1, .duration_s = duration_s});
    const auto stretches = FitArrivalTimes(lines.times_ns, std::nullopt);
    ASSERT_EQ(stretches.size(), 1);
    EXPECT_ABS(stretches[0].time_uncertainty_s, 1, 1e-12, "the block");
    EXPECT_REL(stretches[0].rate_hz, 3000, 1e-6, "exact blocks");
  }
}

// lines in time for 0.1 to 0.4 s, then none for 0.3 to 1.2 s: no one rate makes up for the pauses
TEST(BlockTimes, AreNotThoseOfASourceThatPausesAsItPleases) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<std::int64_t> times_ns;
  std::int64_t begin_ms = 0;
  for (int k = 0; k < 20; ++k) {
    const auto lines = static_cast<std::int64_t>(100 + 300 * uniform(random));
    for (std::int64_t j = 0; j < lines; ++j) times_ns.push_back((begin_ms + j) * 1'000'000);
    begin_ms += lines + static_cast<std::int64_t>(300 + 900 * uniform(random));
  }
  const auto stretches = FitArrivalTimes(times_ns, std::nullopt);
  ASSERT_EQ(stretches.size(), 20);
  for (const Stretch& of : stretches) {
    EXPECT_REL(of.rate_hz, 1000, 1e-12, "exact times");
    EXPECT_EQ(of.time_uncertainty_s, 0);
  }
}

}  // namespace
}  // namespace haptometer::trial
