#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "sim/linear/steady_state.h"
#include "sim/skin/skin.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/adapter_optimum.h"
#include "sim/tuning/travel_limit.h"
#include "tools/reproduce/thesis_model.h"

// Table 2.4: the adapter of the grid search, the true optimum, and the largest power.

namespace haptometer::tools {
namespace {

constexpr std::size_t kValuesPerAxis = 20;  // "20 values within its search range" (p. 11)
constexpr std::size_t kRidgePoints = 40;

// the five numbers of a point, under the keys of the grid's rows or the optimum's
std::vector<ThesisRow> PointRows(bool grid, const sim::AdapterPoint& point) {
  const auto row = [grid](std::string_view of_grid, std::string_view of_optimum, double ours) {
    return ThesisRow{.key = grid ? of_grid : of_optimum, .ours = ours};
  };
  const sim::Adapter& adapter = point.adapter;
  return {row("grid-motor-side-mass", "optimum-motor-side-mass", adapter.motor_side_mass_kg),
          row("grid-skin-side-mass", "optimum-skin-side-mass", adapter.skin_side_mass_kg),
          row("grid-stiffness", "optimum-stiffness", adapter.stiffness_n_per_m),
          row("grid-damping", "optimum-damping", adapter.damping_n_s_per_m),
          row("grid-contact-area", "optimum-contact-area", point.contact_area_m2)};
}

// RMS along the ridge: at each Ma1 the best of all other numbers
std::string RidgeRemark(const sim::TuningProblem& problem) {
  const auto ridge = sim::RidgeOf(sim::Objective::kSkinRms, problem, {}, kRidgePoints);
  const auto [least, most] = std::ranges::minmax_element(ridge, {}, &sim::RidgePoint::value);
  return fmt::format(
      "a flat ridge: the best at each Ma1 from {:g} to {:g} g lies between {:.5f} and {:.5f} mm",
      1e3 * problem.bounds.motor_side_mass_kg.lower, 1e3 * problem.bounds.motor_side_mass_kg.upper,
      1e3 * least->value, 1e3 * most->value);
}

// the two values of the grid around a printed number; empty where it is outside of the grid
std::string StepsRemark(std::string_view key, const sim::Range& range) {
  const auto values = sim::EqualSteps(range, kValuesPerAxis);
  const ThesisNumber& number = ThesisNumberOf(key);
  const auto above = std::ranges::lower_bound(values, SiValue(number));
  if (above == values.begin() || above == values.end()) return {};
  return fmt::format(
      "the printed one is not a point of {} equal steps: {:.6g} and {:.6g} {} are next",
      kValuesPerAxis, *(above - 1) / number.unit.si, *above / number.unit.si, number.unit.name);
}

// best of the thesis's grid, 20 values per axis
std::vector<ThesisRow> GridRows(const sim::TuningProblem& problem, double printed_rms_m) {
  const sim::GridBest best = sim::BestOnGrid(problem, kValuesPerAxis);
  std::vector<ThesisRow> rows = PointRows(true, best.point);
  rows[0].remark = RidgeRemark(problem);
  rows[1].remark = StepsRemark("grid-skin-side-mass", problem.bounds.skin_side_mass_kg);
  rows[2].remark = StepsRemark("grid-stiffness", problem.bounds.stiffness_n_per_m);
  rows.push_back({.key = "grid-rms",
                  .ours = best.skin_rms_m,
                  .remark = fmt::format("of {} points; the printed point gives {:.5f} mm, {:.2f} % "
                                        "less",
                                        best.points, 1e3 * printed_rms_m,
                                        100 * (1 - printed_rms_m / best.skin_rms_m))});
  return rows;
}

// resonance in Hz of the adapter's spring and skin-side mass alone
double AloneHz(double stiffness_n_per_m, double mass_kg) {
  return std::sqrt(stiffness_n_per_m / mass_kg) / (2 * std::numbers::pi);
}

std::string AloneRemark(const sim::Adapter& ours) {
  return fmt::format("along the ridge: sqrt(Ka/Ma2)/2 pi is {:.2f} Hz here, {:.2f} Hz as printed",
                     AloneHz(ours.stiffness_n_per_m, ours.skin_side_mass_kg),
                     AloneHz(SiValue(ThesisNumberOf("optimum-stiffness")),
                             SiValue(ThesisNumberOf("optimum-skin-side-mass"))));
}

// maximum over the same ranges without steps, with a proved upper bound
std::vector<ThesisRow> ContinuousRows(const sim::TuningProblem& problem, double printed_rms_m) {
  const sim::AdapterOptimum best =
      sim::FindAdapterOptimum(sim::Objective::kSkinRms, problem, sim::ReceptorField{});
  std::vector<ThesisRow> rows = PointRows(false, best.point);
  rows[1].remark = rows[2].remark = AloneRemark(best.point.adapter);
  rows.push_back(
      {.key = "optimum-rms",
       .ours = best.value,
       .remark = fmt::format("the printed point gives {:.5f} mm, {:.2f} % less",
                             1e3 * printed_rms_m, 100 * (1 - printed_rms_m / best.value))});
  rows.push_back(
      {.key = "optimum-upper-bound",
       .ours = best.upper_bound,
       .remark = fmt::format("proved by interval branch and bound, {} boxes", best.boxes)});
  return rows;
}

// most power into the skin (4.1), and most RMS per watt of input
std::vector<ThesisRow> FurtherRows(const sim::TuningProblem& problem) {
  const sim::AdapterPoint power =
      sim::BestWithinTravel(sim::Objective::kSkinPower, problem, {}).point;
  const sim::AdapterPoint per_watt =
      sim::BestWithinTravel(sim::Objective::kRmsPerWatt, problem, {}).point;
  const sim::MotorSource source = sim::SourceOf(problem.actuator, problem.drive);
  // v = w abs(Xs), peak, m/s
  const double w = source.omega_rad_per_s;
  const auto amplitude_m = [&](const sim::AdapterPoint& point) {
    return std::abs(
        sim::MotionOf(source, point.adapter, sim::SkinOf(problem, point.contact_area_m2)).skin_m);
  };
  const double velocity_m_per_s = w * amplitude_m(power);
  const sim::Skin skin = sim::SkinOf(problem, power.contact_area_m2);
  // P = Bs v^2 / 2, v peak
  return {{.key = "most-skin-power",
           .ours = skin.damping_n_s_per_m * velocity_m_per_s * velocity_m_per_s / 2,
           .remark = fmt::format(
               "Ma2 {:.3f} g, Ka {:.0f} N/m, A {:.2f} mm2: another adapter than the one that moves "
               "the skin most",
               1e3 * power.adapter.skin_side_mass_kg, power.adapter.stiffness_n_per_m,
               1e6 * power.contact_area_m2)},
          {.key = "most-rms-per-watt",
           // RMS in m at the optimum of RMS per watt
           .ours = amplitude_m(per_watt) / std::sqrt(2.0),
           .remark =
               fmt::format("Ma2 {:.3f} g, Ka {:.0f} N/m", 1e3 * per_watt.adapter.skin_side_mass_kg,
                           per_watt.adapter.stiffness_n_per_m)}};
}

}  // namespace

std::vector<ThesisRow> OptimumRows(const ThesisModel& model) {
  const sim::TuningProblem problem = SearchOf(model);
  const double printed_rms_m =
      sim::SolveSteadyState(WithAdapter(model, problem.bounds.contact_area_m2.lower)).skin_rms_m;
  return Joined({GridRows(problem, printed_rms_m), ContinuousRows(problem, printed_rms_m),
                 FurtherRows(problem)});
}

// Figures 2.6 and 2.7: receptors reached, and the stimulus.
namespace {

constexpr double kLeastRadiusM = 1e-3;  // of the contactors (p. 12)
constexpr double kMostRadiusM = 7.5e-3;

// S = Nr x RMS in m (thesis, equation 2.7)
double AdapterStimulus(const ThesisModel& model, const sim::ReceptorField& field, double radius_m) {
  const sim::Scene scene = WithAdapter(model, sim::ContactArea(radius_m));
  return sim::SkinStimulus(field, radius_m, sim::SolveSteadyState(scene).skin_rms_m);
}

// largest stimulus over the contact's radius
struct Largest {
  double radius_m = 0;
  double stimulus_m = 0;
};

// Between two steps of the count Nr the RMS decreases as the contact grows, so the maximum is at a
// step or at the least radius; 1e-12 beyond the step, where the next receptors are counted.
Largest LargestStimulus(const ThesisModel& model, sim::ReceptorGrid grid) {
  const sim::ReceptorField field{.grid = grid};
  std::vector<double> radii{kLeastRadiusM};
  for (const double step_m : sim::SteppingRadii(field)) {
    const double radius_m = step_m * (1 + 1e-12);
    // the skin's law ends at 100 mm2
    if (radius_m > kLeastRadiusM && sim::ContactArea(radius_m) <= sim::kSkinAreaMaxM2) {
      radii.push_back(radius_m);
    }
  }
  Largest largest;
  for (const double radius_m : radii) {
    const double stimulus_m = AdapterStimulus(model, field, radius_m);
    if (stimulus_m > largest.stimulus_m) largest = {radius_m, stimulus_m};
  }
  return largest;
}

double AllReceptors(const sim::ReceptorField& field) {
  return static_cast<double>(sim::ReceptorPositions(field).size());
}

std::string LargestRemark(const Largest& cell, const Largest& edge) {
  return fmt::format(
      "cell-centred grid, contact radius {:.2f} mm; grid edge to edge {:.3f} mm x Nr at {:.2f} mm",
      1e3 * cell.radius_m, 1e3 * edge.stimulus_m, 1e3 * edge.radius_m);
}

// other readings of the text: the second grid, and all receptors at IA#1's area
std::vector<CandidateCause> StimulusCauses(const ThesisModel& model, const Largest& edge) {
  ThesisModel table = model;
  table.skin_range = sim::SkinRange::kTable;
  const double all = AllReceptors(sim::ReceptorField{.grid = sim::ReceptorGrid::kCellCentred});
  const auto at_64 = [&](const ThesisModel& of) {
    return all * sim::SolveSteadyState(WithAdapter(of, kIa1AreaM2)).skin_rms_m;
  };
  return {{.text = "the grid edge to edge", .gives = edge.stimulus_m},
          {.text = "all receptors at 64 mm2, Ks up to 2000 N/m", .gives = at_64(model)},
          {.text = "all receptors at 64 mm2, Ks up to 1200 N/m", .gives = at_64(table)}};
}

// Nr of the whole pad times the printed RMS, with the interval of its last digit
CandidateCause PrintedDirect() {
  const ThesisNumber& rms = ThesisNumberOf("rms-direct");
  const double all = AllReceptors({});
  const auto stimulus = [&](double steps) {
    return all * (rms.value + steps * rms.half_step) * rms.unit.si;
  };
  return {.text = "all receptors with the printed RMS of Table 2.3",
          .gives = stimulus(0),
          .from_rounded = dsp::Interval{stimulus(-1), stimulus(1)}};
}

// contact radius in m from which all receptors are reached
double AllFrom(sim::ReceptorGrid grid) {
  return sim::SteppingRadii(sim::ReceptorField{.grid = grid}).back();
}

}  // namespace

std::vector<ThesisRow> ReceptorRows(const ThesisModel& model) {
  const sim::ReceptorField field;
  const Largest cell = LargestStimulus(model, sim::ReceptorGrid::kCellCentred);
  const Largest edge = LargestStimulus(model, sim::ReceptorGrid::kEdgeToEdge);
  const double case_radius_m = sim::ContactRadius(kCaseAreaM2);
  const auto direct = [=](const ThesisModel& m) {
    return sim::SkinStimulus(field, case_radius_m,
                             sim::SolveSteadyState(WithoutAdapter(m, kCaseAreaM2)).skin_rms_m);
  };
  const auto adapter = [](const ThesisModel& m) {
    return LargestStimulus(m, sim::ReceptorGrid::kCellCentred).stimulus_m;
  };
  const double printed_ratio =
      ThesisNumberOf("stimulus-adapter").value / ThesisNumberOf("stimulus-direct").value;
  std::vector<ThesisRow> rows{
      // receptors under the largest contactor of the thesis
      {.key = "receptors", .ours = sim::StimulatedReceptors(field, kMostRadiusM)},
      {.key = "all-receptors-cell", .ours = AllFrom(sim::ReceptorGrid::kCellCentred)},
      {.key = "all-receptors-edge", .ours = AllFrom(sim::ReceptorGrid::kEdgeToEdge)},
      {.key = "stimulus-adapter",
       .candidates = StimulusCauses(model, edge),
       .remark = LargestRemark(cell, edge),
       .measure = adapter},
      {.key = "stimulus-direct", .candidates = {PrintedDirect()}, .measure = direct},
      {.key = "stimulus-ratio",
       .ours = cell.stimulus_m / direct(model),
       .candidates = {{.text = "the two printed numbers", .gives = printed_ratio}}}};
  Measure(model, &rows);
  ExplainByRounding(model, &rows);
  return rows;
}

}  // namespace haptometer::tools
