// PiecewiseMotion::NextUnwatched: many outputs at once are those asked for one by one.
#include <gtest/gtest.h>

#include <memory>

#include "sim/linear_model.h"
#include "sim/piecewise_scene.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

// as many outputs at once as there are, of seven at first
Eigen::MatrixXd InBlocks(PiecewiseMotion& motion, Eigen::Index count) {
  Eigen::MatrixXd samples(motion.x().size(), count);
  Eigen::Index done = 0;
  while (done < count) {
    double voltage_v = 0;
    const Eigen::Index taken = motion.NextUnwatched(
        done < 7 ? 7 - done : count - done, [&](Eigen::Index i, const auto& x, double now_v) {
          samples.col(done + i) = x;
          voltage_v = now_v;
        });
    if (taken == 0) {
      motion.Next();
      samples.col(done++) = motion.Positions();
      continue;
    }
    done += taken;
    EXPECT_EQ(motion.Positions(), samples.col(done - 1));
    EXPECT_EQ(motion.Inputs()(kVoltage), voltage_v);
  }
  return samples;
}

Eigen::MatrixXd OneByOne(PiecewiseMotion& motion, Eigen::Index count) {
  Eigen::MatrixXd samples(motion.x().size(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    motion.Next();
    samples.col(i) = motion.Positions();
  }
  return samples;
}

std::unique_ptr<PiecewiseMotion> MotionOf(double inductance_h, const PiecewiseEffects& effects,
                                          double origin_s) {
  Scene scene = tests::AdapterScene();
  scene.actuator.inductance_h = inductance_h;
  scene.start = Start::kRest;
  const OutputGrid grid{.rate_hz = 1e4, .origin_s = origin_s};
  return std::make_unique<PiecewiseMotion>(AssemblePiecewise(scene, effects), scene.drive,
                                           PiecewiseStartOf(scene), grid);
}

// across a renewal of the state, and after a start between two outputs
TEST(UnwatchedOutputs, AreThoseOfOneByOne) {
  for (const double inductance_h : {130e-6, 0.0}) {
    for (const double origin_s : {0.0, -0.3e-4}) {
      const auto single = MotionOf(inductance_h, {}, origin_s);
      const auto many = MotionOf(inductance_h, {}, origin_s);
      EXPECT_EQ(InBlocks(*many, 20000), OneByOne(*single, 20000));
      EXPECT_EQ(many->index(), 20000U);
    }
  }
}

TEST(UnwatchedOutputs, AreNoneWhereThereAreGuards) {
  const PiecewiseEffects stops{
      .stops = TravelStops{.gap_up_m = 0.5e-3, .gap_down_m = 0.5e-3, .restitution = 0.5}};
  const auto motion = MotionOf(130e-6, stops, 0);
  const auto fail = [](Eigen::Index, const auto&, double) { FAIL() << "an output unwatched"; };
  EXPECT_EQ(motion->NextUnwatched(10, fail), 0);
  EXPECT_EQ(motion->index(), 0U);
}

}  // namespace
}  // namespace haptometer::sim
