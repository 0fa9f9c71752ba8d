#include "bench/sim_cost_effects.h"

#include <array>
#include <bitset>
#include <limits>
#include <string>
#include <utility>

#include "bench/sim_cost_ours.h"
#include "bench/sim_cost_rung.h"
#include "sim/effective_scene.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/smooth/smooth_motion.h"

namespace haptometer::sim {
namespace {

// in the order in which they are added
enum : std::size_t { kInductance, kGravity, kStops, kContact, kStiffening, kHeating, kCount };
constexpr std::array<const char*, kCount> kNames{"inductance",        "gravity",
                                                 "travel stops",      "breaking contact",
                                                 "stiffening spring", "coil heating"};
using Choice = std::bitset<kCount>;

constexpr double kPressN = 0.05;
constexpr double kGapM = 0.5e-3;
constexpr double kCubicNPerM3 = 1e9;

struct Chosen {
  Scene scene;
  PiecewiseEffects piecewise;
  SmoothEffects smooth;
};

Chosen Choose(const Choice& on) {
  Chosen chosen{.scene = SceneOf({}), .piecewise{}, .smooth{}};
  Scene& scene = chosen.scene;
  if (!on[kInductance]) scene.actuator.inductance_h = 0;
  double sag_m = 0, weight_n = 0;
  if (on[kGravity]) {
    sag_m = SagUnder(scene.actuator.moving_mass_kg * scene.effects.gravity_m_per_s2,
                     scene.actuator.stiffness_n_per_m, on[kStiffening] ? kCubicNPerM3 : 0);
    weight_n = Weight(scene);
  }
  if (on[kStops]) {
    chosen.piecewise.stops =
        TravelStops{.gap_up_m = kGapM - sag_m, .gap_down_m = kGapM + sag_m, .restitution = 0.5};
  }
  if (on[kContact]) chosen.piecewise.contact_loss = ContactLoss{kPressN + weight_n};
  if (on[kStiffening]) {
    chosen.smooth.spring = StiffeningSpring{.cubic_n_per_m3 = kCubicNPerM3, .sag_m = sag_m};
  }
  if (on[kHeating]) {
    chosen.smooth.heating =
        CoilHeating{.heat_capacity_j_per_k = 1e-3, .thermal_resistance_k_per_w = 100};
  }
  return chosen;
}

// bodies, then the current
template <typename Motion>
Answer Play(Motion& motion, std::size_t outputs) {
  Answer answer = EmptyAnswer({}, outputs);
  for (std::size_t i = 1; i <= outputs; ++i) {
    motion.Next();
    const auto output = static_cast<Eigen::Index>(i);
    answer.samples.col(output).head(6) = motion.Positions().head(6);
    answer.samples(kCurrent, output) = motion.CurrentA();
  }
  for (const Event& event : motion.events()) answer.events_s.push_back(event.time_s);
  if (motion.stalled_at_s()) answer.failure = "stalled";
  return answer;
}

Answer Run(const Choice& on, std::size_t outputs, double tolerance) {
  const Chosen chosen = Choose(on);
  const Question question;
  const Scene& scene = chosen.scene;
  if (!on[kStiffening] && !on[kHeating]) {
    PiecewiseMotion motion(AssemblePiecewise(scene, chosen.piecewise), scene.drive,
                           PiecewiseStartOf(scene), question.rate_hz);
    return Play(motion, outputs);
  }
  SmoothMotion motion(AssembleSmooth(scene, chosen.piecewise, chosen.smooth), scene.drive,
                      PiecewiseStartOf(scene), question.rate_hz, {.tolerance = tolerance});
  return Play(motion, outputs);
}

}  // namespace

void MeasureEffects(std::size_t outputs, int runs) {
  Choice all;
  all.set();
  const Answer everything = Run(all, outputs, 1e-11);
  const Truth truth{.samples = everything.samples,
                    .largest = everything.samples.cwiseAbs().rowwise().maxCoeff(),
                    .events_s = everything.events_s};
  const auto measure = [&](const char* what, const std::string& name, const Choice& on) {
    Measure({.scene = "effects",
             .method = what,
             .setting = name,
             .run = [&](std::size_t count) { return Run(on, count, 1e-8); },
             .runs = runs,
             .lost_above = std::numeric_limits<double>::infinity()},
            truth);
  };
  Choice on;
  measure("added", "bodies alone", on);
  for (std::size_t k = 0; k < kCount; ++k) measure("added", kNames[k], on.set(k));
  for (std::size_t k = 0; k < kCount; ++k) measure("left out", kNames[k], Choice(all).reset(k));
}

}  // namespace haptometer::sim
