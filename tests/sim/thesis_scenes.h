#pragma once

#include "sim/scene/scene.h"

namespace haptometer::tests {

/// The three scenes of the references: 5 V at 225 Hz, Lindsay 2013, Tables 2.1 and 2.4.
inline sim::Scene DirectScene() {
  sim::Scene scene;
  scene.actuator = sim::ThesisC10100();
  scene.skin = {.stiffness_n_per_m = 1861.2, .damping_n_s_per_m = 2.2185};
  scene.drive = {.amplitude_v = 5, .frequency_hz = 225};
  return scene;
}

inline sim::Scene ConeScene() {
  sim::Scene scene = DirectScene();
  scene.skin = {.stiffness_n_per_m = 600, .damping_n_s_per_m = 0.75};
  return scene;
}

inline sim::Scene AdapterScene() {
  sim::Scene scene = ConeScene();
  scene.adapter = sim::Adapter{.motor_side_mass_kg = 0.25e-3,
                               .skin_side_mass_kg = 4.35e-3,
                               .stiffness_n_per_m = 8200,
                               .damping_n_s_per_m = 0.01};
  return scene;
}

}  // namespace haptometer::tests
