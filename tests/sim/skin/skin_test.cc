#include "sim/skin/skin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/linear/motor_source.h"
#include "sim/tuning/tuning_problem.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr const char* kEnds = "ends of the law, rounding";

TEST(SkinUnderArea, RunsFromEndToEnd) {
  for (const SkinRange range : {SkinRange::kText, SkinRange::kTable}) {
    EXPECT_EQ(SkinUnderArea(1e-6, range).stiffness_n_per_m, 600);
    EXPECT_EQ(SkinUnderArea(1e-6, range).damping_n_s_per_m, 0.75);
    EXPECT_REL(SkinUnderArea(100e-6, range).damping_n_s_per_m, 2.38, 3e-16, kEnds);
  }
  EXPECT_REL(SkinUnderArea(100e-6, SkinRange::kText).stiffness_n_per_m, 2000, 3e-16, kEnds);
  EXPECT_REL(SkinUnderArea(100e-6, SkinRange::kTable).stiffness_n_per_m, 1200, 3e-16, kEnds);
}

TEST(SkinUnderArea, RunsWithTheCubeRoot) {
  // 27 mm2: cube roots 1, 3, 100^(1/3)
  const double part = (3.0 - 1) / (4.641588833612779 - 1);
  const Skin skin = SkinUnderArea(27e-6, SkinRange::kTable);
  EXPECT_REL(skin.stiffness_n_per_m, 600 + 600 * part, 1e-15, "rounding");
  EXPECT_REL(skin.damping_n_s_per_m, 0.75 + 1.63 * part, 1e-15, "rounding");
}

TEST(SkinUnderArea, OfTheBareCaseIsTheWorkedNumber) {
  const Skin text = SkinUnderArea(78.5e-6, SkinRange::kText);
  EXPECT_ABS(text.stiffness_n_per_m, 1861.7, 0.05, "sim/skin/skin.h, one decimal");
  EXPECT_ABS(text.damping_n_s_per_m, 2.2189, 5e-5, "sim/skin/skin.h, four decimals");
  EXPECT_ABS(SkinUnderArea(78.5e-6, SkinRange::kTable).stiffness_n_per_m, 1140.7, 0.05,
             "600 + 600 x 0.90119");
}

TEST(SkinUnderAreaDeath, CoversOnlyItsAreas) {
  EXPECT_DEATH(static_cast<void>(SkinUnderArea(0.9e-6, SkinRange::kText)), "check failed");
  EXPECT_DEATH(static_cast<void>(SkinUnderArea(101e-6, SkinRange::kText)), "check failed");
  EXPECT_DEATH(static_cast<void>(SkinUnderArea(0.999e-6, SkinRange::kText)), "check failed");
  EXPECT_DEATH(static_cast<void>(SkinUnderArea(100.1e-6, SkinRange::kText)), "check failed");
  EXPECT_GT(SkinUnderArea(1.001e-6, SkinRange::kText).stiffness_n_per_m, 600);
  EXPECT_LT(SkinUnderArea(99.9e-6, SkinRange::kText).stiffness_n_per_m, 2000);
}

constexpr ReceptorField kCells{};
constexpr ReceptorField kEdges{.grid = ReceptorGrid::kEdgeToEdge};

TEST(Receptors, AreFortyNineAsTheThesissDensityMakesThem) {
  EXPECT_EQ(ReceptorsPerSide(kCells), 7U);
  EXPECT_EQ(ReceptorPositions(kCells).size(), 49U);
  EXPECT_REL(ReceptorPositions(kCells).back().x_m, 3 * 15e-3 / 7, 1e-15,
             "half a cell off the edge");
  EXPECT_EQ(ReceptorPositions(kEdges).front().y_m, -7.5e-3);
}

// side times the root of the density, to the nearest whole number, 1 at least
TEST(Receptors, AreAsManyASideAsTheDensityMakesThem) {
  const auto per_side = [](double side) {
    return ReceptorsPerSide({.pad_side_m = 1e-3 * side, .density_per_m2 = 1e6});
  };
  EXPECT_EQ(per_side(7.49), 7U);
  EXPECT_EQ(per_side(7.51), 8U);
  EXPECT_EQ(per_side(0.01), 1U);
  // one receptor lies in the middle, on either grid
  const ReceptorField one{
      .pad_side_m = 1e-3, .density_per_m2 = 1e6, .grid = ReceptorGrid::kEdgeToEdge};
  ASSERT_EQ(ReceptorPositions(one).size(), 1U);
  EXPECT_EQ(ReceptorPositions(one)[0].x_m, 0);
  // two a side lie on the edges, or in the middles of two cells; y runs slower than x
  ReceptorField two{.pad_side_m = 2e-3, .density_per_m2 = 1e6, .grid = ReceptorGrid::kEdgeToEdge};
  ASSERT_EQ(ReceptorPositions(two).size(), 4U);
  EXPECT_EQ(ReceptorPositions(two)[1].x_m, 1e-3);
  EXPECT_EQ(ReceptorPositions(two)[1].y_m, -1e-3);
  two.grid = ReceptorField{}.grid;
  EXPECT_EQ(ReceptorPositions(two)[1].x_m, 0.5e-3);
}

// a field's radius away from a receptor: reached by a point, which is no step
TEST(Receptors, ThatAPointReachesAreNoStep) {
  const ReceptorField two{.pad_side_m = 2e-3,
                          .density_per_m2 = 1e6,
                          .field_radius_m = 1e-3 * std::numbers::sqrt2,
                          .grid = ReceptorGrid::kEdgeToEdge};
  EXPECT_EQ(StimulatedReceptors(two, 0), 4);
  EXPECT_TRUE(SteppingRadii(two).empty());
}

// counted in Python (tests/sim/tuning/adapter_reference.py counts them the same way)
TEST(Receptors, ThatAContactorReachesAreCounted) {
  EXPECT_EQ(StimulatedReceptors(kCells, 1e-3), 29);
  EXPECT_EQ(StimulatedReceptors(kCells, 2e-3), 37);
  EXPECT_EQ(StimulatedReceptors(kCells, 3e-3), 45);
  EXPECT_EQ(StimulatedReceptors(kEdges, 1e-3), 21);
  EXPECT_EQ(StimulatedReceptors(kEdges, 2e-3), 29);
  EXPECT_EQ(StimulatedReceptors(kEdges, 3e-3), 37);
  EXPECT_EQ(StimulatedReceptors(kCells, ContactRadius(1e-6)), 25);
}

// figure 2.6 grows to all 49 within 7.5 mm, whichever way the grid lies
TEST(Receptors, AreAllReachedFromTheCornersDistanceOn) {
  const double cell_corner_m = 3 * 15e-3 / 7 * std::numbers::sqrt2 - 5.7e-3;
  const double edge_corner_m = 7.5e-3 * std::numbers::sqrt2 - 5.7e-3;
  EXPECT_REL(SteppingRadii(kCells).back(), cell_corner_m, 1e-14, "rounding");
  EXPECT_REL(SteppingRadii(kEdges).back(), edge_corner_m, 1e-14, "rounding");
  for (const auto& [field, corner_m] :
       {std::pair{kCells, cell_corner_m}, std::pair{kEdges, edge_corner_m}}) {
    EXPECT_EQ(StimulatedReceptors(field, corner_m), 49);
    EXPECT_EQ(StimulatedReceptors(field, corner_m - 1e-9), 45);
    EXPECT_EQ(StimulatedReceptors(field, 7.5e-3), 49);
  }
}

TEST(Receptors, StepUpAtTheRadiiThatAreListed) {
  for (const ReceptorField& field : {kCells, kEdges}) {
    double before = StimulatedReceptors(field, 0);
    for (const double radius_m : SteppingRadii(field)) {
      EXPECT_EQ(StimulatedReceptors(field, radius_m * (1 - 1e-9)), before);
      EXPECT_GT(StimulatedReceptors(field, radius_m), before);
      before = StimulatedReceptors(field, radius_m);
    }
    EXPECT_EQ(before, 49);
  }
}

TEST(Receptors, OfADensePadFillTheDiscTheyAreReachedFrom) {
  const ReceptorField dense{.pad_side_m = 30e-3, .density_per_m2 = 100e6};
  const double radius_m = 4e-3;
  const double disc_m2 = ContactArea(radius_m + dense.field_radius_m);
  EXPECT_REL(StimulatedReceptors(dense, radius_m), disc_m2 * dense.density_per_m2, 3e-3,
             "lattice points in a circle: 97 spacings of radius");
}

TEST(Receptors, WithSoftEdgesComeInGradually) {
  ReceptorField soft = kCells;
  soft.edge_width_m = 0.5e-3;
  double before = 0;
  for (int step = 0; step <= 40; ++step) {
    const double count = StimulatedReceptors(soft, step * 1e-4);
    EXPECT_GT(count, before);
    before = count;
  }
  EXPECT_LT(before, 49);
  EXPECT_ABS(StimulatedReceptors(soft, 7.5e-3), 49, 1e-12, "eight widths beyond the last");
  soft.edge_width_m = 1e-9;
  EXPECT_ABS(StimulatedReceptors(soft, 2e-3), 37, 1e-12, "no receptor within 1000 widths");
}

TEST(Receptors, OnASoftFieldsEdgeCountAHalf) {
  const ReceptorField one{
      .pad_side_m = 1e-3, .density_per_m2 = 1e6, .field_radius_m = 0, .edge_width_m = 1e-4};
  EXPECT_EQ(ReceptorsPerSide(one), 1U);
  EXPECT_EQ(StimulatedReceptors(one, 0), 0.5);
  EXPECT_REL(StimulatedReceptors(one, 1e-4), 0.841344746068543, 1e-14, "the normal distribution");
}

// S of the thesis's adapter under every contactor from 1 mm to the skin law's end
double LargestStimulus(const ReceptorField& field, SkinRange range) {
  const Scene scene = tests::AdapterScene();
  const MotorSource source = SourceOf(scene.actuator, scene.drive);
  double largest = 0;
  for (const double radius_m : SteppingRadii(field)) {
    const double area_m2 = ContactArea(std::max(radius_m, 1e-3));
    if (area_m2 > kSkinAreaMaxM2) break;
    const Skin skin = SkinUnderArea(area_m2, range);
    const double rms_m =
        std::abs(MotionOf(source, *scene.adapter, skin).skin_m) / std::numbers::sqrt2;
    largest = std::max(largest, SkinStimulus(field, std::max(radius_m, 1e-3), rms_m));
  }
  return largest;
}

// Lindsay 2013, figure 2.7 and section 2.2.3
TEST(SkinStimulus, HasTheFiguresOfTheThesis) {
  EXPECT_ABS(SkinStimulus(kCells, 5e-3, 0.0438e-3), 2.146e-3, 0.0005e-3,
             "49 x 0.0438, printed 2.15");
  EXPECT_ABS(LargestStimulus(kCells, SkinRange::kText), 6.24e-3, 0.005e-3, "its printed digits");
  EXPECT_ABS(LargestStimulus(kEdges, SkinRange::kText), 4.97e-3, 0.005e-3, "its printed digits");

  // the nearest to the printed 4.90: all 49 under 64 mm2 with the table's skin
  const Scene scene = tests::AdapterScene();
  const double rms_m = std::abs(MotionOf(SourceOf(scene.actuator, scene.drive), *scene.adapter,
                                         SkinUnderArea(64e-6, SkinRange::kTable))
                                    .skin_m) /
                       std::numbers::sqrt2;
  EXPECT_ABS(SkinStimulus(kCells, ContactRadius(64e-6), rms_m), 4.875e-3, 0.003e-3,
             "49 times a factor of three digits");
}

TEST(ContactAreas, AreThoseOfDiscs) {
  EXPECT_REL(ContactRadius(78.5e-6), 5e-3, 4e-4, "the thesis's 78.5 mm2 is a disc of 10 mm");
  EXPECT_REL(ContactRadius(ContactArea(3e-3)), 3e-3, 1e-15, "rounding");
}

}  // namespace
}  // namespace haptometer::sim
