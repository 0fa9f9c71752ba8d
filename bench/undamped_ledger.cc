// Energy over many undamped cycles, as a program of its own because the long run takes seconds:
//
//   undamped_ledger CYCLES     prints the ledger's imbalance after that many cycles of 225 Hz, with
//                              an output every 0.1 ms, and after as many perfect bounces
#include <fmt/core.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "sim/linear/linear_model.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/piecewise/piecewise_scene.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kHertz = 225;

// the adapter scene without dampers and without current, deflected
Scene Undamped() {
  Scene scene = tests::AdapterScene();
  scene.actuator.damping_n_s_per_m = 0;
  scene.actuator.force_constant_n_per_a = 0;
  scene.adapter->damping_n_s_per_m = 0;
  scene.skin.damping_n_s_per_m = 0;
  scene.drive.amplitude_v = 0;
  return scene;
}

double ImbalanceAfter(double cycles, const PiecewiseEffects& effects) {
  const Scene scene = Undamped();
  Eigen::VectorXd initial = Eigen::VectorXd::Zero(7);
  initial(LinearModel::kMover) = 1e-3;
  initial(5) = 0.2;  // vs
  PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive, {.x = initial}, 1e4, true);
  const auto outputs = static_cast<std::uint64_t>(cycles / kHertz * 1e4);
  double worst = 0;
  while (motion.index() < outputs && !motion.stalled_at_s()) {
    motion.Next();
    if (motion.index() % 1000 == 0) worst = std::max(worst, motion.Ledger().Imbalance());
  }
  fmt::print("{} outputs, {} events: worst imbalance {:.2g}\n", motion.index(),
             motion.events().size(), worst);
  return worst;
}

}  // namespace
}  // namespace haptometer::sim

int main(int argc, char** argv) {
  const double cycles = argc > 1 ? std::atof(argv[1]) : 1000;
  using haptometer::sim::TravelStops;
  const TravelStops elastic{.gap_up_m = 0.8e-3, .gap_down_m = 0.8e-3, .restitution = 1};
  const double worst = std::max(haptometer::sim::ImbalanceAfter(cycles, {}),
                                haptometer::sim::ImbalanceAfter(cycles / 100, {.stops = elastic}));
  return worst < 1e-9 ? 0 : 1;
}
