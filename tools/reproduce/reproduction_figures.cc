#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/mapped.h"
#include "sim/linear/motor_source.h"
#include "sim/linear/steady_state.h"
#include "sim/sensor_model.h"
#include "sim/skin/skin.h"
#include "tools/reproduce/reproduce.h"
#include "tools/study/study_document.h"

// Figures 2.2 to 2.7.

namespace haptometer::tools {
namespace {

constexpr double kMm = 1e-3;

// `steps` + 1 uniform places from `low` to `high`
std::vector<double> Even(double low, double high, int steps) {
  std::vector<double> places;
  places.reserve(static_cast<std::size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) places.push_back(low + (high - low) * i / steps);
  return places;
}

// a line through function(x) at the places x
template <typename Function>
plot::Series Curve(std::string title, plot::Colour colour, const std::vector<double>& x,
                   const Function& function) {
  return {std::move(title), plot::Lines(colour), x, Mapped(x, function)};
}

// a closed circle in mm; a point without value interrupts the line to the next one
void AppendCircle(const sim::ReceptorPosition& centre, double radius_m, plot::Series& series) {
  constexpr int kCorners = 60;
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    series.x.push_back((centre.x_m + radius_m * std::cos(angle)) / kMm);
    series.y.push_back((centre.y_m + radius_m * std::sin(angle)) / kMm);
  }
  series.x.push_back(series.x.back());
  series.y.push_back(std::numeric_limits<double>::quiet_NaN());
}

// receptive fields of the pad, those that the contactor touches in another colour
plot::Panel FieldsPanel(sim::ReceptorGrid grid, std::string_view name) {
  constexpr double kContactorM = 2e-3;
  const sim::ReceptorField field{.grid = grid};
  plot::Series reached{"reached", plot::Lines(plot::kOrange)};
  plot::Series others{"not reached", plot::Lines(plot::kGrey)};
  plot::Series contactor{"contactor, radius 2 mm", plot::Lines(plot::kBlue, 2)};
  for (const sim::ReceptorPosition& receptor : sim::ReceptorPositions(field)) {
    const double distance_m = std::hypot(receptor.x_m, receptor.y_m);
    // touched: distance of the centres at most the sum of the radii
    const bool touched = distance_m <= kContactorM + field.field_radius_m;
    AppendCircle(receptor, field.field_radius_m, touched ? reached : others);
  }
  AppendCircle({}, kContactorM, contactor);
  plot::Panel panel{fmt::format("receptive fields on a pad of 15 mm, {}: {} reached", name,
                                sim::StimulatedReceptors(field, kContactorM)),
                    "x / mm",
                    "y / mm",
                    {others, reached, contactor}};
  panel.equal_axes = true;
  return panel;
}

ThesisFigure FieldsFigure() {
  return {"figure-2.2",
          "(2.2) Receptive fields that a contactor of radius 2 mm touches, in both readings of the "
          "grid",
          {FieldsPanel(sim::ReceptorGrid::kCellCentred, "cell-centred grid"),
           FieldsPanel(sim::ReceptorGrid::kEdgeToEdge, "grid edge to edge")}};
}

// displacement of the skin in mm over the first 0.1 s from rest
plot::Series Motion(std::string title, plot::Colour colour, sim::Scene scene) {
  constexpr double kDurationS = 0.1;
  scene.start = sim::Start::kRest;
  const trial::Displacement motion = sim::MotionOf(scene, sim::SensorTarget::kSkin);
  return Curve(std::move(title), colour, Even(0, kDurationS, 2000),
               [&](double t_s) { return motion(t_s) / kMm; });
}

ThesisFigure RiseFigure(const ThesisModel& model) {
  return {"figure-2.3",
          "(2.3) Skin displacement over time from rest",
          {{"displacement of the skin",
            "time / s",
            "displacement / mm",
            {Motion("adapter, 1 mm2", plot::kBlue, WithAdapter(model, kIa2AreaM2)),
             Motion("cone, 1 mm2", plot::kGreen, WithoutAdapter(model, kSimulatedConeAreaM2)),
             Motion("direct, 78.5 mm2", plot::kOrange, WithoutAdapter(model, kCaseAreaM2))}}}};
}

ThesisFigure ImpedanceFigure(const ThesisModel& model) {
  const sim::Scene scene = WithAdapter(model, kIa2AreaM2);
  // 50 to 500 Hz in steps of 0.25 Hz
  const std::vector<double> hertz = Even(50, 500, 1800);
  return {"figure-2.4",
          "(2.4) Impedance of the skin, and of LRA with adapter at the skin",
          {{"mechanical impedance, magnitude",
            "frequency / Hz",
            "impedance / (N s/m)",
            {Curve("skin, 1 mm2", plot::kOrange, hertz,
                   [&](double f) { return std::abs(sim::SkinImpedance(scene.skin, f)); }),
             Curve("LRA with adapter", plot::kBlue, hertz,
                   [&](double f) { return std::abs(sim::DriverImpedance(scene, f)); })},
            plot::LogAxes::kY}}};
}

ThesisFigure SensitivityFigure(const ThesisModel& model) {
  constexpr std::array<plot::Colour, 6> kColours{plot::kGreen,  plot::kBlue,  plot::kOrange,
                                                 plot::kPurple, plot::kBlack, plot::kYellow};
  const sim::Scene scene = WithAdapter(model, kIa2AreaM2);
  plot::Panel panel{
      "RMS over that of the adapter of Table 2.4", "change of one number / %", "relative RMS", {}};
  for (std::size_t i = 0; i < kColours.size(); ++i) {
    const sim::SceneNumber number = sim::kSceneNumbers[i];
    panel.series.push_back(Curve(
        // relative RMS with one number changed by -50 % to +50 %
        std::string(sim::Symbol(number)), kColours[i], Even(-50, 50, 100),
        [&](double percent) { return sim::RelativeSkinRms(scene, number, 1 + percent / 100); }));
  }
  return {"figure-2.5", "(2.5) Sensitivity of the RMS displacement to adapter and skin", {panel}};
}

plot::Series Count(std::string title, plot::Colour colour, sim::ReceptorGrid grid) {
  const sim::ReceptorField field{.grid = grid};
  plot::Series series{std::move(title), plot::Lines(colour)};
  // radii of the thesis's contactors, in steps of 5 um
  for (const double radius_m : Even(1e-3, 7.5e-3, 1300)) {
    series.x.push_back(sim::ContactArea(radius_m) / (kMm * kMm));
    series.y.push_back(sim::StimulatedReceptors(field, radius_m));
  }
  return series;
}

ThesisFigure ReceptorsFigure() {
  return {"figure-2.6",
          "(2.6) Receptors stimulated against contact area, contact radii from 1 to 7.5 mm",
          {{"receptors stimulated",
            "contact area / mm2",
            "receptors Nr",
            {Count("cell-centred grid", plot::kBlue, sim::ReceptorGrid::kCellCentred),
             Count("grid edge to edge", plot::kOrange, sim::ReceptorGrid::kEdgeToEdge)}}}};
}

ThesisFigure StimulusFigure(const ThesisModel& model) {
  // up to the radius at which the skin's law ends, less rounding
  const std::vector<double> radii_mm =
      Even(1, sim::ContactRadius(sim::kSkinAreaMaxM2) / kMm * (1 - 1e-12), 1000);
  const auto stimulus = [&](const auto& scene_of, sim::ReceptorGrid grid, double radius_mm) {
    const double radius_m = radius_mm * kMm;
    const sim::Scene scene = scene_of(model, sim::ContactArea(radius_m));
    return sim::SkinStimulus(sim::ReceptorField{.grid = grid}, radius_m,
                             sim::SolveSteadyState(scene).skin_rms_m) /
           kMm;
  };
  const auto curve = [&](std::string title, plot::Colour colour, const auto& scene_of,
                         sim::ReceptorGrid grid) {
    return Curve(std::move(title), colour, radii_mm,
                 [&, grid](double radius_mm) { return stimulus(scene_of, grid, radius_mm); });
  };
  return {"figure-2.7",
          "(2.7) Skin stimulus against contact radius, as far as the skin's law reaches",
          {{"skin stimulus",
            "contact radius / mm",
            "stimulus / (mm x Nr)",
            {curve("adapter, cell-centred grid", plot::kBlue, WithAdapter,
                   sim::ReceptorGrid::kCellCentred),
             curve("adapter, grid edge to edge", plot::kOrange, WithAdapter,
                   sim::ReceptorGrid::kEdgeToEdge),
             curve("without adapter, cell-centred", plot::kGreen, WithoutAdapter,
                   sim::ReceptorGrid::kCellCentred)}}}};
}

}  // namespace

std::vector<ThesisFigure> ModelFigures(const ThesisModel& model) {
  return {FieldsFigure(),           RiseFigure(model), ImpedanceFigure(model),
          SensitivityFigure(model), ReceptorsFigure(), StimulusFigure(model)};
}

namespace {

// every panel of generated data states that it is not measured
std::vector<plot::Panel> Generated(std::vector<plot::Panel> panels) {
  for (plot::Panel& panel : panels) {
    panel.title = "generated, not measured" + (panel.title.empty() ? "" : ": " + panel.title);
  }
  return panels;
}

}  // namespace

std::vector<ThesisFigure> FiguresOf(const Reproduction& reproduction) {
  std::vector<ThesisFigure> figures = ModelFigures(reproduction.model);
  const GeneratedStudy& study = reproduction.study;
  figures.push_back({"figure-3.3",
                     "(3.3) RMS displacement, IA#1 beside the stock LRA and IA#2 beside the small "
                     "contact; generated trials",
                     Generated(StudyPanels(study.trials))});
  figures.push_back({"figure-3.4",
                     "(3.4) Voltages matched by perception, in each condition; generated settings",
                     Generated(MatchingPanels(study.matching))});
  figures.push_back({"figure-3.5",
                     "(3.5) RMS displacement of IA#1 against the drive; simulated and analysed",
                     Generated(LinearityPanels(study.linearity))});
  return figures;
}

}  // namespace haptometer::tools
