#include "tools/played_scene.h"

#include "sim/linear/steady_state.h"
#include "sim/scene/scene_file.h"

namespace haptometer::tools {

Result<sim::Scene> ReadPlayedScene(const std::string& path) {
  auto scene = sim::ReadSceneFile(path);
  if (!scene) return scene;
  if (sim::StartOf(*scene) != sim::Start::kSteady) return scene;
  const double error = scene->drive.kind == sim::DriveKind::kTones
                           ? sim::SolveSteadyTones(*scene).error_estimate
                           : sim::SolveSteadyState(*scene).error_estimate;
  if (!(error < 1)) {
    return CannotAnswer(path, "has no steady state: the drive excites an undamped resonance",
                        "add damping, or start = \"rest\" to [run]");
  }
  return scene;
}

}  // namespace haptometer::tools
