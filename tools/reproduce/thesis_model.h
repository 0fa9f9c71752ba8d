#pragma once

#include "sim/scene/actuator.h"
#include "sim/scene/scene.h"
#include "sim/skin/skin.h"
#include "sim/tuning/tuning_problem.h"

namespace haptometer::tools {

// Contact areas: the case of the LRA and the cone of the simulation (Table 2.3, p. 12), the control
// with a small contact (3.1.1, p. 24), the prototypes IA#1 and IA#2 (chapter 3, p. 22).
inline constexpr double kCaseAreaM2 = 78.5e-6;
inline constexpr double kSimulatedConeAreaM2 = 1e-6;
inline constexpr double kSmallControlAreaM2 = 1.1e-6;
inline constexpr double kIa1AreaM2 = 64e-6;
inline constexpr double kIa2AreaM2 = 1e-6;
/// Base of a prototype with its dowel pins (chapter 3, p. 22); IA#1 and IA#2 weigh the same.
inline constexpr double kBuiltBaseMassKg = 4.6e-3;
/// LRA and impedance adapter together (3.1.1, p. 24).
inline constexpr double kPrototypeMassKg = 7.5e-3;
/// Drive of the matching test (3.2.1, p. 26).
inline constexpr double kMatchingFrequencyHz = 175;

/// What the thesis simulated: Table 2.1, the drive of 2.1.1 (p. 9), the adapter of Table 2.4.
struct ThesisModel {
  sim::Actuator actuator = sim::ThesisC10100();
  sim::Drive drive{.amplitude_v = 5, .frequency_hz = 225};
  sim::Adapter adapter{.motor_side_mass_kg = 0.25e-3,
                       .skin_side_mass_kg = 4.35e-3,
                       .stiffness_n_per_m = 8200,
                       .damping_n_s_per_m = 0.01};
  /// The thesis prints two and does not say which it used.
  sim::SkinRange skin_range = sim::SkinRange::kText;
  /// What the ends of the skin's law differ by from the printed ones, at the least and the largest
  /// contact area.
  sim::Skin least_skin{};
  sim::Skin largest_skin{};
};

/// The skin under a contact of that area.
[[nodiscard]] sim::Skin SkinOf(const ThesisModel& model, double contact_area_m2);

/// The LRA on a contact of that area: its case, or a rigid massless cone.
[[nodiscard]] sim::Scene WithoutAdapter(const ThesisModel& model, double contact_area_m2);

/// The LRA with the model's adapter.
[[nodiscard]] sim::Scene WithAdapter(const ThesisModel& model, double contact_area_m2);

/// The same with the base as it was built.
[[nodiscard]] sim::Scene Prototype(const ThesisModel& model, double contact_area_m2);

/// The search of Table 2.2 (p. 11) with the model's actuator, drive and skin.
[[nodiscard]] sim::TuningProblem SearchOf(const ThesisModel& model);

}  // namespace haptometer::tools
