#include "sim/tuning/latency_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "sim/effective_scene.h"
#include "sim/tuning/adapter_optimum.h"
#include "sim/tuning/travel_limit.h"
#include "tests/repetitions.h"
#include "tests/residual.h"
#include "tests/sim/tuning/latency_reference.h"

namespace haptometer::sim {
namespace {

TuningProblem ProblemAt(double frequency_hz) {
  TuningProblem problem = ThesisProblem();
  problem.drive.frequency_hz = frequency_hz;
  return problem;
}

// a spring and a skin side to choose, all else held
TuningProblem TwoFree() {
  TuningProblem problem = ThesisProblem();
  problem.fixed_skin = Skin{.stiffness_n_per_m = 600, .damping_n_s_per_m = 0.75};
  problem.bounds.motor_side_mass_kg = {0.25e-3, 0.25e-3};
  problem.bounds.damping_n_s_per_m = {0.01, 0.01};
  return problem;
}

double RmsOf(const TuningProblem& problem, const AdapterPoint& point) {
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  return ValueOf(Objective::kSkinRms, problem, source, {}, point);
}

TEST(LatencyLimit, OfAdaptersIsThatOfNumPy) {
  for (const tests::LatencyCase& known : tests::kLatencyCases) {
    const TuningProblem problem = ProblemAt(known.frequency_hz);
    const auto& [Ma1, Ma2, Ka, Ba, area] = known.place;
    const AdapterPoint point = PointOf(problem.bounds, {Ma1, Ka, Ba, area, Ma2});
    const auto rise = RiseWith(problem, point);
    ASSERT_TRUE(rise) << known.frequency_hz;
    EXPECT_ABS(rise->latency_s, known.latency_s, 1e-10, "the same straight lines, in seconds");
    EXPECT_REL(RmsOf(problem, point), known.rms_m, 1e-9, "ten digits are kept");
  }
}

// what a limit holds beside the latency, which the reference's limits are of
double UncertaintyOf(const TuningProblem& problem, const AdapterPoint& point) {
  return RiseWith(problem, point)->uncertainty_s;
}

std::vector<tests::LatencyCase> SearchedCases() {
  std::vector<tests::LatencyCase> cases;
  std::ranges::copy_if(tests::kLatencyCases, std::back_inserter(cases),
                       [](const tests::LatencyCase& known) { return known.limit_s > 0; });
  return cases;
}

class LatencySearches : public ::testing::TestWithParam<tests::LatencyCase> {};

TEST_P(LatencySearches, LeaveNothingThatADenseSearchFinds) {
  const tests::LatencyCase& known = GetParam();
  const TuningProblem problem = ProblemAt(known.frequency_hz);
  const AdapterPoint free = BestWithinTravel(Objective::kSkinRms, problem, {}).point;
  const double limit_s = known.limit_s + UncertaintyOf(problem, free);
  const PromptBest best = BestWithinLatency(problem, limit_s, free);
  EXPECT_LE(best.rise.LatencyAtMostS(), limit_s);
  EXPECT_EQ(best.rise.latency_s, RiseWith(problem, best.point)->latency_s);
  EXPECT_GT(best.value, known.rms_m * (1 - 1e-5)) << "SciPy's search ends within 4e-4 of ours";
  EXPECT_LT(best.value, RmsOf(problem, free));
  EXPECT_FALSE(best.is_unlimited);
  EXPECT_LT(best.runs, 600U);
}

INSTANTIATE_TEST_SUITE_P(Cases, LatencySearches, ::testing::ValuesIn(SearchedCases()));

TEST(LatencyLimit, ThatIsKeptChangesNothing) {
  const TuningProblem problem = ThesisProblem();
  const AdapterPoint free = BestWithinTravel(Objective::kSkinRms, problem, {}).point;
  const double latency_s = RiseWith(problem, free)->latency_s;
  const PromptBest best =
      BestWithinLatency(problem, RiseWith(problem, free)->LatencyAtMostS(), free);
  EXPECT_EQ(best.runs, 1U);
  EXPECT_TRUE(best.is_unlimited);
  EXPECT_EQ(best.value, RmsOf(problem, free));
  EXPECT_EQ(best.point.adapter.stiffness_n_per_m, free.adapter.stiffness_n_per_m);
  EXPECT_EQ(best.point.adapter.skin_side_mass_kg, free.adapter.skin_side_mass_kg);
  EXPECT_EQ(best.rise.latency_s, latency_s);
}

TEST(LatencyLimit, CostsMoreTheTighterItIs) {
  const TuningProblem problem = TwoFree();
  const AdapterPoint free = BestWithinTravel(Objective::kSkinRms, problem, {}).point;
  double before = RmsOf(problem, free);
  for (const double latency_s : {2.2e-3, 1.2e-3}) {
    const double limit_s = latency_s + UncertaintyOf(problem, free);
    const PromptBest best = BestWithinLatency(problem, limit_s, free);
    EXPECT_GT(best.value, 0) << limit_s;
    EXPECT_LT(best.value, before) << limit_s;
    EXPECT_LE(best.rise.LatencyAtMostS(), limit_s);
    before = best.value;
  }
}

TEST(LatencyLimit, ThatNothingKeepsIsSaid) {
  TuningProblem problem = TwoFree();
  problem.bounds.stiffness_n_per_m = {9000, 9000};
  const AdapterPoint free = BestWithinTravel(Objective::kSkinRms, problem, {}).point;
  const double uncertainty_s = UncertaintyOf(problem, free);
  const PromptBest searched = BestWithinLatency(problem, uncertainty_s + 1e-9, free);
  EXPECT_EQ(searched.value, 0);
  EXPECT_GT(searched.runs, 20U);
  // what is below the uncertainty is not sought
  const PromptBest undecided = BestWithinLatency(problem, uncertainty_s * 0.999, free);
  EXPECT_EQ(undecided.value, 0);
  EXPECT_EQ(undecided.runs, 1U);
  EXPECT_EQ(undecided.least_limit_s, uncertainty_s);
}

// The window of three periods reaches before the drive: a motion that is at once at its full
// amplitude, or swings over it, reads as one that began earlier.
TEST(LatencyLimit, IsNeverOfAMotionBeforeItsDrive) {
  bool reads_below = false;
  for (const double frequency_hz : {5.0, 60.0, 100.0, 225.0}) {
    const TuningProblem problem = ProblemAt(frequency_hz);
    const auto rise = RiseWith(problem, BestWithinTravel(Objective::kSkinRms, problem, {}).point);
    ASSERT_TRUE(rise) << frequency_hz;
    EXPECT_GE(rise->latency_s, 0) << frequency_hz;
    EXPECT_NEAR(rise->uncertainty_s * frequency_hz, 0.147, 0.001) << "0.18 / sqrt(3) of 0.471 x 3";
    EXPECT_EQ(rise->TellsLatency(), frequency_hz == 225) << frequency_hz;
    reads_below = reads_below || rise->latency_s == 0;
  }
  EXPECT_TRUE(reads_below);
}

// every adapter of a grid that is prompt enough, each by its own run
TEST(LatencyLimit, IsBeatenByNoAdapterOfAGrid) {
  const TuningProblem problem = TwoFree();
  const AdapterPoint free = BestWithinTravel(Objective::kSkinRms, problem, {}).point;
  const double limit_s = 2e-3 + UncertaintyOf(problem, free);
  const PromptBest best = BestWithinLatency(problem, limit_s, free);
  const int steps = std::max(16, tests::Repetitions(16));
  int prompt = 0;
  for (int i = 0; i <= steps; ++i) {
    for (int k = 0; k <= steps; ++k) {
      const CubePlace place{0, i / static_cast<double>(steps), 0, 0,
                            k / static_cast<double>(steps)};
      const AdapterPoint point = PointOf(problem.bounds, place);
      const double rms_m = RmsOf(problem, point);
      // no run is needed for what would lose
      if (rms_m < 0.9 * best.value) continue;
      const auto rise = RiseWith(problem, point);
      if (!rise || rise->LatencyAtMostS() > limit_s) continue;
      ++prompt;
      EXPECT_LE(rms_m, best.value * (1 + 1e-6)) << i << ' ' << k;
    }
  }
  EXPECT_GT(prompt, 0);
}

// half a second or 40 periods, in whole milliseconds
TEST(LatencyRun, LastsHalfASecondOrFortyPeriods) {
  EXPECT_EQ(LatencyRunS(ProblemAt(225)), 0.5);
  EXPECT_EQ(LatencyRunS(ProblemAt(80)), 0.5);
  EXPECT_EQ(LatencyRunS(ProblemAt(79)), 0.507) << "506.3 ms";
  EXPECT_EQ(LatencyRunS(ProblemAt(50)), 0.8);
  EXPECT_EQ(LatencyRunS(ProblemAt(30)), 1.334) << "1333.3 ms";
}

// a million looks, of which a slow drive's run of 40 periods has 40 / f times the rate
TEST(LatencyRun, IsTooLongFromAMillionLooksOn) {
  const AdapterPoint point = PointOf(ThesisBounds(), CubePlace::Constant(0.5));
  double longest = 0, shortest = 1e9;
  for (double frequency_hz = 0.1; frequency_hz < 1; frequency_hz *= 1.004) {
    const TuningProblem problem = ProblemAt(frequency_hz);
    Scene scene;
    scene.actuator = problem.actuator;
    scene.adapter = point.adapter;
    scene.skin = SkinOf(problem, point.contact_area_m2);
    scene.drive = {.amplitude_v = 5, .frequency_hz = frequency_hz};
    scene.duration_s = LatencyRunS(problem);
    const double looks = *scene.duration_s * OutputRateHz(scene);
    EXPECT_EQ(RunIsTooLong(problem, point), looks > 1e6) << looks;
    if (looks > 1e6) shortest = std::min(shortest, looks);
    if (looks <= 1e6) longest = std::max(longest, looks);
  }
  EXPECT_GT(longest, 0.99e6) << "both sides are tried closely";
  EXPECT_LT(shortest, 1.01e6);
}

// The least uncertainty among the runs, also that of the answer. Under a tight limit the search
// comes to light skin sides, whose faster bodies are looked at twice as often: their windows are
// finer.
TEST(LatencyLimit, HasTheLeastLimitThatCanBeKept) {
  const TuningProblem problem = TwoFree();
  const AdapterPoint free = BestWithinTravel(Objective::kSkinRms, problem, {}).point;
  const double free_s = UncertaintyOf(problem, free);
  const PromptBest best = BestWithinLatency(problem, 1.2e-3 + free_s, free);
  EXPECT_LE(best.least_limit_s, best.rise.uncertainty_s);
  EXPECT_LT(best.least_limit_s, free_s * (1 - 1e-4));
  EXPECT_GT(best.least_limit_s, 0.9 * free_s) << "windows of three periods are nearly alike";
}

}  // namespace
}  // namespace haptometer::sim
