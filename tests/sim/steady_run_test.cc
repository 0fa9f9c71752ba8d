#include "sim/steady_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/scene_run.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

// a run of which the skin's position at the end of each period of the drive is known
SceneRun EndingAt(const std::vector<double>& positions_m) {
  SceneRun run;
  for (const double position_m : positions_m) {
    run.marks.push_back({.positions = Eigen::Vector2d(position_m, 1e-3)});
  }
  return run;
}

TEST(PeriodAtEnd, IsTheNumberOfDrivePeriodsAfterWhichTheMotionRepeatsItself) {
  EXPECT_EQ(PeriodAtEnd(EndingAt({2e-3, 1e-3, 1e-3, 1e-3})), 1);
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 2e-3, 1e-3, 2e-3, 1e-3})), 2);
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 2e-3, 3e-3, 1e-3, 2e-3, 3e-3, 1e-3})), 3);
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 2e-3, 3e-3, 4e-3, 5e-3})), std::nullopt) << "it drifts";
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 1e-3})), std::nullopt) << "too few to say";
}

// within 1e-4 of the largest position
TEST(PeriodAtEnd, HasATolerance) {
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 1e-3, 1.00009e-3})), 1);
  EXPECT_EQ(PeriodAtEnd(EndingAt({1e-3, 1e-3, 1.00011e-3})), std::nullopt);
}

// windows of two periods whose mean squares are 4 and 1 um^2: RMS of 2 and 1 um about 1.5 um
TEST(WindowUncertainty, IsTheRelativeDeviationFromWindowToWindow) {
  SceneRun run = EndingAt({0, 0, 0, 0, 0});
  const double square_m2_s[] = {0, 2e-12, 4e-12, 4.5e-12, 5e-12};
  for (std::size_t k = 0; k < 5; ++k) run.marks[k].skin_square_m2_s = square_m2_s[k];
  EXPECT_REL(*WindowUncertainty(run, 2), std::sqrt(0.5) / 1.5, 1e-14, "rounding");
  EXPECT_EQ(WindowUncertainty(run, 3), std::nullopt) << "one window has no deviation";
}

// marks that repeat themselves every k periods and not sooner
SceneRun RepeatingAfter(std::size_t k, std::size_t marks) {
  std::vector<double> positions_m;
  for (std::size_t i = 0; i < marks; ++i) {
    positions_m.push_back(1e-3 * static_cast<double>(1 + i % k));
  }
  return EndingAt(positions_m);
}

// up to 32, and only where twice as many periods are marked
TEST(PeriodAtEnd, NeedsTwoPeriodsOfTheMotion) {
  for (const std::size_t k : {2U, 7U, 31U, 32U}) {
    EXPECT_EQ(PeriodAtEnd(RepeatingAfter(k, 2 * k + 1)), static_cast<int>(k));
    EXPECT_EQ(PeriodAtEnd(RepeatingAfter(k, 2 * k)), std::nullopt) << k;
  }
  EXPECT_EQ(PeriodAtEnd(RepeatingAfter(33, 129)), std::nullopt);
}

// a position that is 0 throughout, as that of a held case, does not matter
TEST(PeriodAtEnd, OfWhatRestsIsThatOfTheOthers) {
  SceneRun run = RepeatingAfter(3, 9);
  for (PeriodMark& mark : run.marks) mark.positions(1) = 0;
  EXPECT_EQ(PeriodAtEnd(run), 3);
}

// every window counts back from the end: RMS of 3, 2, 1 um deviate by 1 um
TEST(WindowUncertainty, IsOfAllWindowsThatAreMarked) {
  SceneRun run = EndingAt({0, 0, 0, 0});
  const double square_m2_s[] = {0, 9e-12, 13e-12, 14e-12};
  for (std::size_t k = 0; k < 4; ++k) run.marks[k].skin_square_m2_s = square_m2_s[k];
  EXPECT_REL(*WindowUncertainty(run, 1), 0.5, 1e-14, "a deviation of 1 um about 2 um");
  for (PeriodMark& mark : run.marks) mark.skin_square_m2_s = 1;
  EXPECT_EQ(WindowUncertainty(run, 1), 0) << "nothing moves";
  run.marks.pop_back();
  run.marks.pop_back();
  EXPECT_EQ(WindowUncertainty(run, 1), std::nullopt);
}

// What a run of eight periods is wrong by, once for each period that a deviation needs to decay,
// and ten times what the motion's place is.
TEST(SteadyRun, StatesTheErrorOfAMotionWithoutEnd) {
  const Scene scene = tests::AdapterScene();
  EffectiveScene effective{.scene = scene, .piecewise = {}};
  effective.piecewise.stops =
      TravelStops{.gap_up_m = 0.3e-3, .gap_down_m = 0.3e-3, .restitution = 0.5};
  const SteadyRun steady = PlaySteady(effective);
  ASSERT_TRUE(steady.run && steady.periodic);
  ASSERT_EQ(steady.periodic->drive_periods, 1);
  EXPECT_REL(steady.run->end_s, 8.0 / 225, 1e-15, "eight periods");
  effective.window_periods = 8;
  const SceneRun once = RunScene(effective, 8.0 / 225, steady.start);
  const double stays = std::abs(steady.periodic->multipliers(0));
  EXPECT_GT(stays, 0.5) << "a deviation needs some periods to decay";
  EXPECT_REL(steady.run->error_estimate,
             once.error_estimate / (1 - stays) + 10 * steady.periodic->error, 1e-12, "rounding");
  EXPECT_EQ(steady.run->skin_rms_m, once.skin_rms_m);
}

// The run of a chaotic motion is over all periods of its averages, and so are all of its numbers:
// RMS values, power, peak and events. It agrees with the batches that its uncertainties are of.
TEST(SteadyRun, OfAChaoticMotionIsOverThePeriodsOfItsAverages) {
  const EffectiveScene effective{.scene = tests::DirectScene(),
                                 .piecewise = {.contact_loss = ContactLoss{0.07}}};
  const SteadyRun steady = PlaySteady(effective);
  ASSERT_TRUE(steady.run && steady.chaotic);
  const SceneRun& run = *steady.run;
  const PeriodMeans& means = steady.chaotic->means;
  const PeriodMeans& uncertain = steady.chaotic->standard_uncertainties;
  EXPECT_EQ(steady.chaotic->periods, 4096);
  EXPECT_EQ(run.begin_s, 0);
  EXPECT_REL(run.end_s, 4096.0 / 225, 1e-15, "a quotient");
  // energies of the whole run over its length are its mean powers
  constexpr auto kCoil = static_cast<std::size_t>(SceneElement::kCoil);
  EXPECT_REL(run.ledger.input_j / run.end_s, run.power_w, 1e-14, "rounding");
  EXPECT_REL(std::sqrt(run.ledger.dissipated_j[kCoil] / run.end_s / 27), run.current_rms_a, 1e-14,
             "P = R I^2");
  EXPECT_EQ(run.mover_peak_m, run.mover_peak_of_run_m) << "the window is the run";
  // contact breaks about once in two periods
  ASSERT_FALSE(run.events.empty());
  EXPECT_GT(run.events[0].count, 4096U / 3);
  // two averages over as many periods
  constexpr Eigen::Index kCase = LinearModel::kCase;  // on the skin itself
  EXPECT_ABS(run.skin_rms_m * run.skin_rms_m, means.mean_squares(kCase),
             5 * std::sqrt(2.0) * uncertain.mean_squares(kCase), "five standard deviations");
  EXPECT_ABS(run.power_w, means.power_w, 5 * std::sqrt(2.0) * uncertain.power_w, "the same");
  // an RMS is a root, which halves the relative uncertainty of its square
  const double skin_m2 = run.skin_rms_m * run.skin_rms_m;
  const double current_a2 = run.current_rms_a * run.current_rms_a;
  const double largest =
      std::max({uncertain.mean_squares(kCase) / skin_m2 / 2, uncertain.coil_w / 27 / current_a2 / 2,
                uncertain.power_w / run.power_w});
  EXPECT_REL(run.error_estimate, largest, 1e-12, "rounding");
}

}  // namespace
}  // namespace haptometer::sim
