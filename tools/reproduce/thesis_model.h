#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/scene/actuator.h"
#include "sim/scene/scene.h"
#include "sim/skin/skin.h"
#include "sim/tuning/tuning_problem.h"
#include "tools/reproduce/thesis_numbers.h"

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

// The rows of the thesis, computed anew from the model by each call, a function in the file of its
// name.

/// Table 2.3, and the ratio of 2.2.2.
[[nodiscard]] std::vector<ThesisRow> DisplacementRows(const ThesisModel& model);
/// Current, power, phase, and what the adapter saves (2.2.1, 2.2.2).
[[nodiscard]] std::vector<ThesisRow> ElectricalRows(const ThesisModel& model);
/// Table 2.4 by the grid and without steps; 4.1's power transfer.
[[nodiscard]] std::vector<ThesisRow> OptimumRows(const ThesisModel& model);
/// Resonance, Figures 2.4 and 2.5.
[[nodiscard]] std::vector<ThesisRow> FrequencyRows(const ThesisModel& model);
/// Figure 2.3.
[[nodiscard]] std::vector<ThesisRow> RiseRows(const ThesisModel& model);
/// Figures 2.6 and 2.7.
[[nodiscard]] std::vector<ThesisRow> ReceptorRows(const ThesisModel& model);
/// Weight and sag, prototypes as built, the gain at 175 Hz, power, travel, contact: what the model
/// says of chapter 3.
[[nodiscard]] std::vector<ThesisRow> PrototypeRows(const ThesisModel& model);

/// All rows, those of each part behind the ones before.
[[nodiscard]] std::vector<ThesisRow> Joined(std::vector<std::vector<ThesisRow>> parts);

/// What each row's `measure` gives of the model, as its number.
void Measure(const ThesisModel& model, std::vector<ThesisRow>* rows);

/// What becomes of rows when the printed inputs of the simulation are not their printed values but
/// numbers that round to them: one set of inputs for all the rows, sought so that each comes to
/// what is printed.
///
/// Inputs: Mv, Mc, Kv, Bv, Km, R, L (Table 2.1), Ma1, Ma2, Ka, Ba (Table 2.4), the ends of Ks and
/// Bs (2.1.1), each within half a unit of its last printed digit, stiffnesses within 50 N/m. Drive
/// and contact areas are settings and stay.
///
/// The search is that of Gauss and Newton within these bounds, from the printed values and then
/// from seven places spread over them, on the rows' distances from their printed intervals;
/// derivatives are differences over a thousandth of a bound. It is deterministic, and what it finds
/// is evaluated by the model itself. That it finds nothing is no proof that there is nothing. Cost:
/// at most 8 searches of 12 steps of 25 evaluations of each row.
///
/// @param rows each with a measure
/// @return one cause a row, in the order of `rows`, of kind kRounding, which names the inputs
[[nodiscard]] std::vector<CandidateCause> FromRoundedInputs(const ThesisModel& model,
                                                            std::span<const ThesisRow> rows);

/// Adds to each of `rows` that has a measure, and that is not reproduced, the cause that is found
/// for it alone.
void ExplainByRounding(const ThesisModel& model, std::vector<ThesisRow>* rows);

/// Where `function` is largest between `low` and `high`: the best of 1000 even places, then golden
/// section between its neighbours, to 1e-9 of the range.
[[nodiscard]] double LargestAt(const std::function<double(double)>& function, double low,
                               double high);

/// The last place before `high` where `function` passes through 0, sought in 1000 even steps from
/// `high` down and halved to the last digit; nothing where it keeps its sign.
[[nodiscard]] std::optional<double> CrossingOf(const std::function<double(double)>& function,
                                               double low, double high);

/// When the skin is first `level_m` > 0 away from rest, to either side, after the drive began at
/// rest: sought in steps of a hundredth of a period, then halved. Nothing within 1 s: nothing.
[[nodiscard]] std::optional<double> TimeToReach(sim::Scene scene, double level_m);

}  // namespace haptometer::tools
