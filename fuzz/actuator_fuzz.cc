// An actuator's file: read or refused, and one that is complete moves a scene that can be solved.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz/memory_path.h"
#include "fuzz/seeds.h"
#include "fuzz/verb_run.h"
#include "sim/linear/steady_state.h"
#include "sim/scene/actuator.h"
#include "sim/skin/skin.h"
#include "tools/verbs.h"

namespace {

constexpr std::array<std::string_view, 2> kSeeds{
    "moving_mass_kg = \"1.40(3)g\"\ncase_mass_kg = 0.6e-3\nresistance_ohm = 27\ninductance_h = "
    "130e-6\nstiffness_n_per_m = \"2800+-60\"\ndamping_n_s_per_m = 0.0322\nforce_constant_n_per_a "
    "= 1.0\n[correlation]\nMv_Kv = 0.9\n",
    "moving_mass_kg = 2e-3\ncase_mass_kg = '0.9 g'\nresistance_ohm = '8 ohm'\ninductance_h = 0\n"};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  return haptometer::fuzz::MutateFromSeeds(kSeeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  using fuzz::Require;
  const fuzz::MemoryPath file({reinterpret_cast<const char*>(data), size});
  const auto stated = sim::FindActuator(file.path());
  if (!stated) {
    Require(!stated.error().Text().empty());
    return 0;
  }
  for (const auto& row : sim::RelativeCovariance(*stated)) {
    for (const double entry : row) Require(std::isfinite(entry));
  }
  if (const auto actuator = sim::Complete(*stated)) {
    sim::Scene scene;
    scene.actuator = *actuator;
    scene.skin = sim::SkinUnderArea(1e-6, sim::SkinRange::kText);
    scene.drive = {.amplitude_v = 5, .frequency_hz = 225};
    const sim::SteadyState steady = sim::SolveSteadyState(scene);
    Require(steady.error_estimate >= 1 || std::isfinite(steady.skin_rms_m));
  }
  fuzz::RunVerb(tools::RunFitLra,
                {"fit-lra", "--plan", "--want", "Km 2%", "--actuator", file.path()});
  return 0;
}
