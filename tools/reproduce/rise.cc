#include "tools/reproduce/rise.h"

#include <cmath>

#include "sim/sensor_model.h"

namespace haptometer::tools {

std::optional<double> TimeToReach(sim::Scene scene, double level_m) {
  constexpr double kLongestS = 1;
  constexpr double kStepsPerPeriod = 100;
  scene.start = sim::Start::kRest;
  const trial::Displacement motion = sim::MotionOf(scene, sim::SensorTarget::kSkin);
  const double rate_hz = kStepsPerPeriod * scene.drive.frequency_hz;
  for (int step = 1; step <= kLongestS * rate_hz; ++step) {
    double after_s = step / rate_hz;
    if (std::abs(motion(after_s)) < level_m) continue;
    double before_s = (step - 1) / rate_hz;
    for (double middle_s = (before_s + after_s) / 2; middle_s > before_s && middle_s < after_s;
         middle_s = (before_s + after_s) / 2) {
      (std::abs(motion(middle_s)) < level_m ? before_s : after_s) = middle_s;
    }
    return after_s;
  }
  return std::nullopt;
}

}  // namespace haptometer::tools
