// Figures 2.6 and 2.7: receptors reached, and the stimulus.
#include <fmt/core.h>

#include <algorithm>
#include <string>

#include "sim/linear/steady_state.h"
#include "sim/skin/skin.h"
#include "tools/reproduce/rounded_inputs.h"
#include "tools/reproduce/row_groups.h"

namespace haptometer::tools {
namespace {

constexpr double kLeastRadiusM = 1e-3;  // of the contactors (p. 12)
constexpr double kMostRadiusM = 7.5e-3;

sim::ReceptorField Field(sim::ReceptorGrid grid) {
  sim::ReceptorField field;
  field.grid = grid;
  return field;
}

double AdapterStimulus(const ThesisModel& model, const sim::ReceptorField& field, double radius_m) {
  const sim::Scene scene = WithAdapter(model, sim::ContactArea(radius_m));
  return sim::SkinStimulus(field, radius_m, sim::SolveSteadyState(scene).skin_rms_m);
}

struct Largest {
  double radius_m = 0;
  double stimulus_m = 0;
};

// Between its steps the count stands still and the RMS falls as the contact grows, so the largest
// is at a step or at the least radius; 1e-12 beyond the step, where it counts.
Largest LargestStimulus(const ThesisModel& model, sim::ReceptorGrid grid) {
  const sim::ReceptorField field = Field(grid);
  std::vector<double> radii{kLeastRadiusM};
  for (const double step_m : sim::SteppingRadii(field)) {
    const double radius_m = step_m * (1 + 1e-12);
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

std::vector<CandidateCause> StimulusCauses(const ThesisModel& model, const Largest& edge) {
  ThesisModel table = model;
  table.skin_range = sim::SkinRange::kTable;
  const double all = AllReceptors(Field(sim::ReceptorGrid::kCellCentred));
  const auto at_64 = [&](const ThesisModel& of) {
    return all * sim::SolveSteadyState(WithAdapter(of, kIa1AreaM2)).skin_rms_m;
  };
  return {{.text = "the grid edge to edge", .gives = edge.stimulus_m},
          {.text = "all receptors at 64 mm2, Ks up to 2000 N/m", .gives = at_64(model)},
          {.text = "all receptors at 64 mm2, Ks up to 1200 N/m", .gives = at_64(table)}};
}

// 49 times the printed RMS, within its last digit
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

// when no further receptor is reached
double AllFrom(sim::ReceptorGrid grid) { return sim::SteppingRadii(Field(grid)).back(); }

}  // namespace

std::vector<ThesisRow> ReceptorRows(const ThesisModel& model) {
  const sim::ReceptorField field;
  const Largest cell = LargestStimulus(model, sim::ReceptorGrid::kCellCentred);
  const Largest edge = LargestStimulus(model, sim::ReceptorGrid::kEdgeToEdge);
  const double case_radius_m = sim::ContactRadius(kCaseAreaM2);
  const double direct_m = sim::SkinStimulus(
      field, case_radius_m, sim::SolveSteadyState(WithoutAdapter(model, kCaseAreaM2)).skin_rms_m);
  const double printed_ratio =
      ThesisNumberOf("stimulus-adapter").value / ThesisNumberOf("stimulus-direct").value;
  std::vector<ThesisRow> rows{
      {.key = "receptors", .ours = sim::StimulatedReceptors(field, kMostRadiusM)},
      {.key = "all-receptors-cell", .ours = AllFrom(sim::ReceptorGrid::kCellCentred)},
      {.key = "all-receptors-edge", .ours = AllFrom(sim::ReceptorGrid::kEdgeToEdge)},
      {.key = "stimulus-adapter",
       .ours = cell.stimulus_m,
       .candidates = StimulusCauses(model, edge),
       .remark = LargestRemark(cell, edge)},
      {.key = "stimulus-direct", .ours = direct_m, .candidates = {PrintedDirect()}},
      {.key = "stimulus-ratio",
       .ours = cell.stimulus_m / direct_m,
       .candidates = {{.text = "the two printed numbers", .gives = printed_ratio}}}};
  const auto direct = [&](const ThesisModel& m) {
    return sim::SkinStimulus(field, case_radius_m,
                             sim::SolveSteadyState(WithoutAdapter(m, kCaseAreaM2)).skin_rms_m);
  };
  const auto adapter = [](const ThesisModel& m) {
    return LargestStimulus(m, sim::ReceptorGrid::kCellCentred).stimulus_m;
  };
  ExplainByRounding(model, {{"stimulus-direct", direct}, {"stimulus-adapter", adapter}}, &rows);
  return rows;
}

}  // namespace haptometer::tools
