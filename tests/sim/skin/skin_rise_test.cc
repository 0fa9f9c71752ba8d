#include "sim/skin/skin_rise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <vector>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

SkinRise RiseWith(double latency_s, double uncertainty_s) {
  SkinRise rise;
  rise.latency_s = latency_s;
  rise.uncertainty_s = uncertainty_s;
  return rise;
}

FindingKind VerdictOn(double latency_s, double uncertainty_s) {
  return VerdictOf(RiseWith(latency_s, uncertainty_s));
}

// from 25 ms on a latency causes errors, from 50 ms on it is perceived
TEST(VerdictOfARise, ChangesAt25And50Milliseconds) {
  EXPECT_EQ(VerdictOn(0.0249, 0), FindingKind::kLatencyUnnoticed);
  EXPECT_EQ(VerdictOn(0.025, 0), FindingKind::kLatencyCostsErrors);
  EXPECT_EQ(VerdictOn(0.0499, 0), FindingKind::kLatencyCostsErrors);
  EXPECT_EQ(VerdictOn(0.050, 0), FindingKind::kLatencyPerceived);
}

TEST(VerdictOfARise, IsGivenWhereBothEndsOfTheUncertaintyHaveIt) {
  EXPECT_EQ(VerdictOn(0.024, 0.0009), FindingKind::kLatencyUnnoticed);
  EXPECT_EQ(VerdictOn(0.024, 0.0011), FindingKind::kLatencyUndecided);
  EXPECT_EQ(VerdictOn(0.026, 0.0009), FindingKind::kLatencyCostsErrors);
  EXPECT_EQ(VerdictOn(0.026, 0.0011), FindingKind::kLatencyUndecided);
  EXPECT_EQ(VerdictOn(0.049, 0.0011), FindingKind::kLatencyUndecided);
  EXPECT_EQ(VerdictOn(0.051, 0.0009), FindingKind::kLatencyPerceived);
  EXPECT_EQ(VerdictOn(0.051, 0.0011), FindingKind::kLatencyUndecided);
}

TEST(SkinRise, StandsOutOfItsUncertaintyOrNot) {
  EXPECT_REL(RiseWith(3e-3, 2.9e-3).LatencyAtMostS(), 5.9e-3, 1e-15, "the sum");
  EXPECT_TRUE(RiseWith(3e-3, 2.99e-3).TellsLatency());
  EXPECT_FALSE(RiseWith(3e-3, 3.01e-3).TellsLatency());
}

TEST(LastsForARise, AsksForTwentyPeriods) {
  EXPECT_LT((0.6 - 0.4) * 100, 20) << "by rounding";
  EXPECT_TRUE(LastsForARise({.begin_s = 0.4, .end_s = 0.6}, 100)) << "a rounding less than 20";
  EXPECT_TRUE(LastsForARise({.begin_s = 0, .end_s = 0.2 * (1 - 0.995e-9)}, 100));
  EXPECT_FALSE(LastsForARise({.begin_s = 0, .end_s = 0.2 * (1 - 1.005e-9)}, 100));
  EXPECT_TRUE(LastsForARise({.begin_s = 0.3, .end_s = 0.5001}, 100));
  EXPECT_FALSE(LastsForARise({.begin_s = 0.3, .end_s = 0.4999}, 100));
  EXPECT_FALSE(LastsForARise({.drive_s = 0.1, .begin_s = 0.3, .end_s = 0.4999}, 100));
}

constexpr double kRateHz = 20000, kToneHz = 200, kEndS = 0.5;

// a tone whose amplitude is a function of time
std::vector<double> ToneOf(const std::function<double(double)>& amplitude) {
  std::vector<double> skin(static_cast<std::size_t>(kEndS * kRateHz) + 1);
  for (std::size_t k = 0; k < skin.size(); ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    skin[k] = amplitude(t_s) * std::sin(2 * std::numbers::pi * kToneHz * t_s + 0.4);
  }
  return skin;
}

// 0 up to begin_s, then straight to 1 within length_s
double Ramp(double t_s, double begin_s, double length_s) {
  return std::clamp((t_s - begin_s) / length_s, 0.0, 1.0);
}

// A window of three periods has 0.48 of its length, 7.2 ms, as its own rise; of any rise the time
// is wrong by 0.18 of that at most and the length by 0.12 (dsp/spectrum/envelope.h).
constexpr double kOwnRiseS = 0.48 * 3 / kToneHz;

TEST(RiseOf, AStraightRampIsEightTenthsOfItAndBeginsATenthLate) {
  for (const double begin_s : {0.0, 0.1}) {
    const std::vector<double> skin = ToneOf([&](double t_s) { return Ramp(t_s, begin_s, 0.06); });
    const auto rise = RiseOf(skin, kRateHz, kToneHz,
                             {.drive_s = begin_s, .begin_s = begin_s + 0.06, .end_s = kEndS});
    ASSERT_TRUE(rise);
    ASSERT_TRUE(rise->rise_s);
    EXPECT_ABS(*rise->rise_s, 0.8 * 0.06, 0.12 * kOwnRiseS, "the window's");
    EXPECT_ABS(rise->latency_s, 0.1 * 0.06, 0.18 * kOwnRiseS, "the window's");
    EXPECT_FALSE(rise->rise_at_most_s);
    // a rectangular distribution of that half width; 0.15 periods as the header states
    EXPECT_ABS(rise->uncertainty_s, 0.18 * kOwnRiseS / std::numbers::sqrt3, 1e-4,
               "the window alone; its own rise to two digits");
    EXPECT_ABS(rise->uncertainty_s * kToneHz, 0.15, 0.01, "two digits");
  }
}

TEST(RiseOf, ALatencyCountsFromTheDrivesBeginAndIsNeverBelowZero) {
  const std::vector<double> skin = ToneOf([](double t_s) { return Ramp(t_s, 0.1, 0.06); });
  const auto latency_s = [&](double drive_s) {
    const auto rise =
        RiseOf(skin, kRateHz, kToneHz, {.drive_s = drive_s, .begin_s = 0.2, .end_s = kEndS});
    EXPECT_TRUE(rise);
    return rise ? rise->latency_s : -1;
  };
  EXPECT_ABS(latency_s(0.06), latency_s(0.1) + 0.04, 1e-9, "the quiet part is silent in both");
  EXPECT_GT(latency_s(0.104), 0);
  EXPECT_EQ(latency_s(0.1079), 0) << "2 ms after a tenth was there";
}

TEST(RiseOf, ASuddenToneHasAnUpperBoundOnly) {
  const std::vector<double> skin = ToneOf([](double t_s) { return t_s < 0.1 ? 0.0 : 1.0; });
  const auto rise =
      RiseOf(skin, kRateHz, kToneHz, {.drive_s = 0.1, .begin_s = 0.1, .end_s = kEndS});
  ASSERT_TRUE(rise);
  EXPECT_FALSE(rise->rise_s);
  ASSERT_TRUE(rise->rise_at_most_s);
  EXPECT_REL(*rise->rise_at_most_s, 2 * kOwnRiseS / 3, 0.03, "0.48 is of two digits");
  EXPECT_LT(rise->latency_s, 0.18 * kOwnRiseS);
}

// ten periods of windows that end within the steady part: thirteen periods of the motion
TEST(RiseOf, LevelsAreOfTheLastTenPeriods) {
  constexpr double kPeriodS = 1 / kToneHz;
  const SteadyPart part{.drive_s = 0.05, .begin_s = 0.15, .end_s = 0.45};
  const auto with_bump = [&](double until_s) {
    return RiseOf(ToneOf([&](double t_s) {
                    const bool in_bump = t_s > 0.25 && t_s < until_s;
                    return Ramp(t_s, 0.05, 0.06) * (in_bump ? 1.4 : 1);
                  }),
                  kRateHz, kToneHz, part);
  };
  const auto plain = with_bump(0), early = with_bump(part.end_s - 13.2 * kPeriodS),
             late = with_bump(part.end_s - 12.5 * kPeriodS);
  ASSERT_TRUE(plain && early && late);
  EXPECT_EQ(early->latency_s, plain->latency_s);
  EXPECT_EQ(early->rise_s, plain->rise_s);
  EXPECT_NE(late->latency_s, plain->latency_s);
  // and none behind the steady part
  const auto behind =
      RiseOf(ToneOf([&](double t_s) { return Ramp(t_s, 0.05, 0.06) * (t_s > part.end_s ? 3 : 1); }),
             kRateHz, kToneHz, part);
  ASSERT_TRUE(behind);
  EXPECT_EQ(behind->latency_s, plain->latency_s);
}

TEST(RiseOf, IsNothingOfASkinThatDoesNotMove) {
  const std::vector<double> still = ToneOf([](double) { return 0.0; });
  EXPECT_FALSE(RiseOf(still, kRateHz, kToneHz, {.begin_s = 0, .end_s = kEndS}));
  EXPECT_DEATH(static_cast<void>(RiseOf(still, kRateHz, kToneHz, {.begin_s = 0.41, .end_s = 0.5})),
               "check failed");
}

}  // namespace
}  // namespace haptometer::sim
