// Table 2.4: the adapter of the grid search, the true optimum, and the power that could be had.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "sim/linear/steady_state.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/adapter_optimum.h"
#include "tools/reproduce/row_groups.h"

namespace haptometer::tools {
namespace {

constexpr std::size_t kValuesPerAxis = 20;  // "20 values within its search range" (p. 11)
constexpr std::size_t kRidgePoints = 40;

// the five numbers of a point, under the keys "grid-..." or "optimum-..."
std::vector<ThesisRow> PointRows(bool grid, const sim::AdapterPoint& point) {
  return {
      {.key = grid ? "grid-motor-side-mass" : "optimum-motor-side-mass",
       .ours = point.adapter.motor_side_mass_kg},
      {.key = grid ? "grid-skin-side-mass" : "optimum-skin-side-mass",
       .ours = point.adapter.skin_side_mass_kg},
      {.key = grid ? "grid-stiffness" : "optimum-stiffness",
       .ours = point.adapter.stiffness_n_per_m},
      {.key = grid ? "grid-damping" : "optimum-damping", .ours = point.adapter.damping_n_s_per_m},
      {.key = grid ? "grid-contact-area" : "optimum-contact-area", .ours = point.contact_area_m2}};
}

// how little is lost along Ma1, the others chosen anew
std::string RidgeRemark(const sim::TuningProblem& problem) {
  const auto ridge = sim::RidgeOf(sim::Objective::kSkinRms, problem, {}, kRidgePoints);
  const auto [least, most] = std::ranges::minmax_element(ridge, {}, &sim::RidgePoint::value);
  return fmt::format(
      "a flat ridge: the best at each Ma1 from {:g} to {:g} g lies between {:.5f} and {:.5f} mm",
      1e3 * problem.bounds.motor_side_mass_kg.lower, 1e3 * problem.bounds.motor_side_mass_kg.upper,
      1e3 * least->value, 1e3 * most->value);
}

// the neighbours of a printed number among equal steps
std::string StepsRemark(std::string_view key, const sim::Range& range) {
  const auto values = sim::EqualSteps(range, kValuesPerAxis);
  const ThesisNumber& number = ThesisNumberOf(key);
  const auto above = std::ranges::lower_bound(values, SiValue(number));
  if (above == values.begin() || above == values.end()) return {};
  return fmt::format("the printed one is no point of {} equal steps: {:.6g} and {:.6g} {} are next",
                     kValuesPerAxis, *(above - 1) / number.unit.si, *above / number.unit.si,
                     number.unit.name);
}

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

double AloneHz(double stiffness_n_per_m, double mass_kg) {
  return std::sqrt(stiffness_n_per_m / mass_kg) / (2 * std::numbers::pi);
}

std::string AloneRemark(const sim::Adapter& ours) {
  return fmt::format("along the ridge: sqrt(Ka/Ma2)/2 pi is {:.2f} Hz here, {:.2f} Hz as printed",
                     AloneHz(ours.stiffness_n_per_m, ours.skin_side_mass_kg),
                     AloneHz(SiValue(ThesisNumberOf("optimum-stiffness")),
                             SiValue(ThesisNumberOf("optimum-skin-side-mass"))));
}

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

// the objective that 4.1 names, and the one beside it
std::vector<ThesisRow> FurtherRows(const sim::TuningProblem& problem) {
  const sim::AdapterPoint power =
      sim::BestAdapter(sim::Objective::kSkinPower, problem, sim::ReceptorField{});
  const sim::AdapterPoint per_watt =
      sim::BestAdapter(sim::Objective::kRmsPerWatt, problem, sim::ReceptorField{});
  const sim::MotorSource source = sim::SourceOf(problem.actuator, problem.drive);
  const double w = source.omega_rad_per_s;
  const auto amplitude_m = [&](const sim::AdapterPoint& point) {
    return std::abs(
        sim::MotionOf(source, point.adapter, sim::SkinOf(problem, point.contact_area_m2)).skin_m);
  };
  const double velocity_m_per_s = w * amplitude_m(power);
  const sim::Skin skin = sim::SkinOf(problem, power.contact_area_m2);
  return {{.key = "most-skin-power",
           .ours = skin.damping_n_s_per_m * velocity_m_per_s * velocity_m_per_s / 2,
           .remark = fmt::format(
               "Ma2 {:.3f} g, Ka {:.0f} N/m, A {:.2f} mm2: another adapter than the one that moves "
               "the skin most",
               1e3 * power.adapter.skin_side_mass_kg, power.adapter.stiffness_n_per_m,
               1e6 * power.contact_area_m2)},
          {.key = "most-rms-per-watt",
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
  std::vector<ThesisRow> rows = GridRows(problem, printed_rms_m);
  for (const auto& more : {ContinuousRows(problem, printed_rms_m), FurtherRows(problem)}) {
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

}  // namespace haptometer::tools
