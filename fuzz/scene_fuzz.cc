// A scene's text: whatever it says, it is answered or refused, and an accepted scene can be solved.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "sim/linear/excitation.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "sim/scene/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  // files of its own would take the fuzzer out of its process
  if (text.find("file") != std::string_view::npos) return 0;
  const auto scene = sim::ReadSceneText(text, "scene.toml");
  if (!scene) {
    if (scene.error().Text().empty()) std::abort();
    return 0;
  }
  if (scene->drive.kind != sim::DriveKind::kSine) {
    const sim::Excitation excitation(scene->drive, scene->finger.tones);
    if (excitation.size() == 0 || excitation.Piece(excitation.size() - 1).terms.empty()) {
      std::abort();
    }
    if (scene->drive.kind == sim::DriveKind::kTones) {
      static_cast<void>(sim::SolveSteadyTones(*scene));
    }
    return 0;
  }
  const sim::SteadyState steady = sim::SolveSteadyState(*scene);
  if (steady.error_estimate < 1 && !std::isfinite(steady.skin_rms_m)) std::abort();
  const sim::LinearModel model = sim::AssembleModel(*scene);
  const sim::TimeResponse response(model, scene->drive, sim::Start::kRest);
  static_cast<void>(response.StateAt(scene->duration_s.value_or(1e-3)));
  return 0;
}
