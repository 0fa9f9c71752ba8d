// What somebody else's program needs of the installed library: one include, one call.
#include <cstdio>

#include "sim/linear/steady_state.h"
#include "sim/scene/scene_file.h"

int main(int, char** argv) {
  const auto scene = haptometer::sim::ReadSceneFile(argv[1]);
  if (!scene) return std::puts(scene.error().Text().c_str()), 1;
  std::printf("%.6f mm\n", haptometer::sim::SolveSteadyState(*scene).skin_rms_m * 1e3);
}
