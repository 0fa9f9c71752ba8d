#include "tests/sim/random_scenes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/effective_scene.h"
#include "sim/linear/steady_state.h"
#include "sim/scene_run.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::tests {

namespace {

using sim::Scene;

double Real(double value) { return std::clamp(value, 1e-9, 1e9); }

std::string Bodies(const Scene& scene) {
  const sim::Actuator& motor = scene.actuator;
  std::string text = fmt::format(
      "[actuator]\nmoving_mass_kg = {}\ncase_mass_kg = {}\nstiffness_n_per_m = {}\n"
      "damping_n_s_per_m = {}\nforce_constant_n_per_a = {}\nresistance_ohm = {}\n"
      "inductance_h = {}\n",
      motor.moving_mass_kg, motor.case_mass_kg, motor.stiffness_n_per_m, motor.damping_n_s_per_m,
      motor.force_constant_n_per_a, motor.resistance_ohm, motor.inductance_h);
  if (const auto& adapter = scene.adapter) {
    text += fmt::format(
        "[adapter]\nmotor_side_mass_kg = {}\nskin_side_mass_kg = {}\nstiffness_n_per_m = {}\n"
        "damping_n_s_per_m = {}\n",
        adapter->motor_side_mass_kg, adapter->skin_side_mass_kg, adapter->stiffness_n_per_m,
        adapter->damping_n_s_per_m);
  }
  if (scene.grip.stiffness_n_per_m > 0 || scene.grip.damping_n_s_per_m > 0) {
    text += fmt::format(
        "[mounting]\nkind = \"grip\"\nstiffness_n_per_m = {}\n"
        "damping_n_s_per_m = {}\n",
        scene.grip.stiffness_n_per_m, scene.grip.damping_n_s_per_m);
  }
  return text + fmt::format(
                    "[drive]\nkind = \"sine\"\namplitude_v = {}\nfrequency_hz = {}\n"
                    "source_resistance_ohm = {}\n",
                    scene.drive.amplitude_v, scene.drive.frequency_hz,
                    scene.drive.source_resistance_ohm);
}

}  // namespace

double RandomScenes::Between(double low, double high) {
  return low * std::pow(high / low, std::ldexp(static_cast<double>(engine_() >> 11U), -53));
}

void RandomScenes::DrawBodies(Scene& scene) {
  scene = OneOf(2) ? AdapterScene() : DirectScene();
  sim::Actuator& motor = scene.actuator;
  motor.moving_mass_kg = Between(1e-4, 1e-2);
  motor.case_mass_kg = Between(1e-4, 1e-2);
  motor.stiffness_n_per_m = Between(500, 2e4);
  motor.damping_n_s_per_m = Between(1e-2, 0.5);
  motor.force_constant_n_per_a = Between(0.1, 10);
  motor.resistance_ohm = Between(5, 100);
  motor.inductance_h = Between(1e-6, 2e-3);
  scene.skin = {.stiffness_n_per_m = Between(100, 5000), .damping_n_s_per_m = Between(0.1, 5)};
}

void RandomScenes::DrawWildBodies(Scene& scene) {
  scene.actuator = {.moving_mass_kg = Whole(),
                    .case_mass_kg = Whole(),
                    .stiffness_n_per_m = Whole(),
                    .damping_n_s_per_m = WholeOrNone(),
                    .force_constant_n_per_a = Whole(),
                    .resistance_ohm = Whole(),
                    .inductance_h = WholeOrNone()};
  if (OneOf(2)) {
    scene.adapter = sim::Adapter{.motor_side_mass_kg = WholeOrNone(),
                                 .skin_side_mass_kg = Whole(),
                                 .stiffness_n_per_m = Whole(),
                                 .damping_n_s_per_m = WholeOrNone()};
  }
  scene.skin = {.stiffness_n_per_m = WholeOrNone(), .damping_n_s_per_m = WholeOrNone()};
  if (OneOf(4)) scene.grip = {.stiffness_n_per_m = Whole(), .damping_n_s_per_m = WholeOrNone()};
  if (OneOf(4)) scene.drive.source_resistance_ohm = Whole();
}

// any size and any pace, but of one piece: everything within a few decades of the mover's own
void RandomScenes::DrawRelatedBodies(Scene& scene) {
  const double Mv = Whole(), Kv = Whole(), R = Whole();
  const double w = std::sqrt(Kv / Mv);
  const double wide = OneOf(10) ? 1e4 : 1e2;
  const auto around = [&](double value) { return Real(value * Between(1 / wide, wide)); };
  const auto damping = [&] { return OneOf(6) ? 0 : Real(Kv / w * Between(1e-6, 10)); };
  scene.actuator = {.moving_mass_kg = Mv,
                    .case_mass_kg = around(Mv),
                    .stiffness_n_per_m = Kv,
                    .damping_n_s_per_m = damping(),
                    .force_constant_n_per_a = Real(std::sqrt(R * Kv / w * Between(1e-6, 10))),
                    .resistance_ohm = R,
                    .inductance_h = OneOf(6) ? 0 : Real(R / w * Between(1e-3, 10))};
  if (OneOf(2)) {
    scene.adapter = sim::Adapter{.motor_side_mass_kg = OneOf(6) ? 0 : around(Mv),
                                 .skin_side_mass_kg = around(Mv),
                                 .stiffness_n_per_m = around(Kv),
                                 .damping_n_s_per_m = damping()};
  }
  scene.skin = {.stiffness_n_per_m = OneOf(6) ? 0 : around(Kv),
                .damping_n_s_per_m = OneOf(6) ? 0 : around(Kv / w)};
  if (OneOf(4)) {
    scene.grip = {.stiffness_n_per_m = around(Kv), .damping_n_s_per_m = damping()};
  }
  if (OneOf(4)) scene.drive.source_resistance_ohm = around(R);
}

// false: no motion to speak of, or one without bound
bool RandomScenes::DrawDrive(Scene& scene) {
  const double own_hz =
      std::sqrt(scene.actuator.stiffness_n_per_m / scene.actuator.moving_mass_kg) /
      (2 * std::numbers::pi);
  scene.drive.frequency_hz = Real(own_hz * Between(0.1, 10));
  scene.drive.amplitude_v = 1;
  const sim::SteadyState unit = sim::SolveSteadyState(scene);
  if (!(unit.error_estimate < 1e-3 && unit.mover_peak_m > 0)) return false;
  scene.drive.amplitude_v = Real(Between(1e-9, 1) / unit.mover_peak_m);
  scene.duration_s = std::min(Real(Between(2, 12) / scene.drive.frequency_hz), sim::kLongestRunS);
  scene.start = sim::Start::kRest;
  if (sim::StepsOfRun(scene, *scene.duration_s) > sim::MostSteps(scene)) return false;
  const sim::SceneRun run =
      sim::RunScene(sim::WithEffects(scene, sim::EffectSet(1)), *scene.duration_s);
  if (!run.IsFinite() || !(run.mover_peak_of_run_m > 0)) return false;
  const double part = scene.drive.amplitude_v;
  const double steady_m = part * unit.skin_rms_m * std::numbers::sqrt2;
  travel_m_ = run.mover_peak_of_run_m;
  skin_m_ = run.skin_m.cwiseAbs().maxCoeff();
  skin_force_n_ = part * unit.skin_force_peak_n * (steady_m > 0 ? skin_m_ / steady_m : 1);
  heat_j_ = run.ledger.dissipated_j[0];
  return true;
}

std::string RandomScenes::Wish(const std::string& name) {
  wishes_ += fmt::format("{} = {}\n", name, OneOf(10) ? "true" : "\"auto\"");
  return "[" + name + "]\n";
}

std::string RandomScenes::Stops(double travel_m) {
  std::string text = Wish("travel_stops");
  if (!OneOf(4)) text += fmt::format("gap_up_m = {}\n", Real(NearOrFar(travel_m)));
  if (!OneOf(4) || text.find("gap") == std::string::npos) {
    text += fmt::format("gap_down_m = {}\n", Real(NearOrFar(travel_m)));
  }
  if (OneOf(2)) {
    return text + fmt::format("stiffness_n_per_m = {}\ndamping_n_s_per_m = {}\n", Between(1, 1e11),
                              WholeOrNone());
  }
  const double part = std::ldexp(static_cast<double>(engine_() >> 11U), -53);
  return text + fmt::format("restitution = {}\n", OneOf(8) ? std::round(part) : part);
}

// mostly so that the mover keeps room
std::string RandomScenes::Gravity(const Scene& scene) {
  const double sag_m = 0.4 * travel_m_ * Bend();
  double g = sag_m * scene.actuator.stiffness_n_per_m / scene.actuator.moving_mass_kg;
  if (OneOf(8)) g = Whole();
  return Wish("gravity") +
         fmt::format("acceleration_m_per_s2 = {}\n", (OneOf(3) ? -1 : 1) * Real(g));
}

std::string RandomScenes::EffectTables(const Scene& scene) {
  std::string text;
  if (OneOf(2)) text += Stops(travel_m_);
  if (OneOf(2)) text += Gravity(scene);
  if (OneOf(8)) {
    const double cubic = Bend() * scene.actuator.stiffness_n_per_m / (travel_m_ * travel_m_);
    text += Wish("stiffening") + fmt::format("cubic_n_per_m3 = {}\n", std::clamp(cubic, 1., 1e15));
  }
  if (OneOf(8)) {
    const double per_k = OneOf(8) ? 0 : Between(1e-9, 1);
    const double rise_k = Bend() / (per_k > 0 ? per_k : 1);
    text +=
        Wish("coil_heating") + fmt::format("heat_capacity_j_per_k = {}\nresistance_per_k = {}\n",
                                           Real(heat_j_ / rise_k), per_k);
    if (!OneOf(4)) text += fmt::format("thermal_resistance_k_per_w = {}\n", Whole());
  }
  if (OneOf(4)) {
    text += Wish("tremor") + fmt::format("amplitude_m = {}\nfrequency_hz = {}\nphase_rad = {}\n",
                                         Real(skin_m_ * Bend()),
                                         Real(scene.drive.frequency_hz * Between(1e-3, 1)),
                                         Between(1e-2, 6));
  }
  return text;
}

std::string RandomScenes::RunTable(const Scene& scene) {
  std::string text =
      fmt::format("[run]\ntolerance = {}\nquantity = \"{}\"\n", Between(1e-11, 0.99),
                  sim::kAskedQuantityNames[engine_() % sim::kAskedQuantityNames.size()]);
  if (!OneOf(16)) text += fmt::format("duration_s = {}\n", *scene.duration_s);
  if (OneOf(16)) text += "start = \"steady\"\n";
  return text;
}

std::string RandomScenes::Next() {
  Scene scene;
  do {
    scene = {};
    if (OneOf(2)) {
      DrawBodies(scene);
    } else if (OneOf(8)) {
      DrawWildBodies(scene);
    } else {
      DrawRelatedBodies(scene);
    }
  } while (!DrawDrive(scene));
  wishes_ = fmt::format("[effects]\ninductance = {}\n", OneOf(4) ? "true" : "\"auto\"");
  const std::string tables = EffectTables(scene);
  std::string skin = fmt::format("[skin]\nstiffness_n_per_m = {}\ndamping_n_s_per_m = {}\n",
                                 scene.skin.stiffness_n_per_m, scene.skin.damping_n_s_per_m);
  if (OneOf(2)) {
    wishes_ += fmt::format("contact_loss = {}\n", OneOf(10) ? "true" : "\"auto\"");
    skin += fmt::format("preload_n = {}\n", Real(NearOrFar(skin_force_n_)));
  }
  return Bodies(scene) + skin + RunTable(scene) + tables + wishes_;
}

}  // namespace haptometer::tests
