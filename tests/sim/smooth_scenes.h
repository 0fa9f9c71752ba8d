#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "sim/linear/linear_model.h"
#include "sim/smooth/smooth_motion.h"
#include "tests/sim/thesis_scenes.h"

/// Scenes and motions that tests of SmoothMotion share.
namespace haptometer::tests {

inline sim::Scene FromRest(sim::Scene scene) {
  scene.start = sim::Start::kRest;
  return scene;
}

inline sim::TravelStops Rigid(double gap_m, double restitution) {
  return {.gap_up_m = gap_m, .gap_down_m = gap_m, .restitution = restitution};
}

inline void RunTo(sim::SmoothMotion& motion, std::uint64_t index) {
  while (motion.index() < index && !motion.stalled_at_s()) motion.Next();
}

// mover and case alone in space, without the coil's pull or damping: d = xv - xa swings by itself
inline sim::Scene Alone() {
  sim::Scene scene = ConeScene();
  scene.actuator.damping_n_s_per_m = 0;
  scene.actuator.force_constant_n_per_a = 0;
  scene.skin = {};
  scene.drive.amplitude_v = 0;
  return scene;
}

inline double ReducedMass(const sim::Scene& scene) {
  return 1 / (1 / scene.actuator.moving_mass_kg + 1 / scene.actuator.case_mass_kg);
}

// drawn apart by d, the centre of mass at rest
inline sim::PiecewiseStart DrawnApart(const sim::Scene& scene, double d_m) {
  const double Mv = scene.actuator.moving_mass_kg, Mc = scene.actuator.case_mass_kg;
  sim::PiecewiseStart start{.x = Eigen::VectorXd::Zero(5)};
  start.x(sim::LinearModel::kMover) = d_m * Mc / (Mv + Mc);
  start.x(sim::LinearModel::kCase) = -d_m * Mv / (Mv + Mc);
  return start;
}

inline double Travel(const sim::SmoothMotion& motion) {
  const Eigen::VectorXd x = motion.Positions();
  return x(sim::LinearModel::kMover) - x(sim::LinearModel::kCase);
}

}  // namespace haptometer::tests
