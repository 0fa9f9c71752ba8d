#include "sim/scene.h"

#include <limits>

namespace haptometer::sim {

std::string_view Name(SensorTarget target) {
  switch (target) {
    case SensorTarget::kSkin:
      return "skin";
    case SensorTarget::kCase:
      return "case";
    case SensorTarget::kMover:
      return "mover";
  }
  return "skin";
}

Sensor IdealSensor() {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  Sensor sensor;
  sensor.head = {
      .name = "ideal", .sampling_s = 1e-4, .range_min_m = -kInfinite, .range_max_m = kInfinite};
  sensor.rate_hz = 1e4;
  return sensor;
}

Start StartOf(const Scene& scene) {
  const bool settles = IsLasting(scene.drive) && !scene.duration_s;
  return scene.start.value_or(settles ? Start::kSteady : Start::kRest);
}

}  // namespace haptometer::sim
