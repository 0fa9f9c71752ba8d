#include "tools/fit/fit_skin_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "tools/cli/json.h"
#include "tools/fit/fit_figures.h"
#include "tools/fit/fit_lra_document.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {
namespace {

using fit::AreaDependence;
using fit::SkinFit;
using nlohmann::ordered_json;

std::string NoiseLine(const SkinFit& contact) {
  std::string text =
      contact.uncertainties_stated
          ? fmt::format("  scatter {:.2g} times the stated uncertainties", contact.magnitude_noise)
          : fmt::format("  a point's standard uncertainty, by the residuals: {:.2g} %",
                        100 * contact.magnitude_noise);
  if (contact.phase_noise_rad) {
    text += fmt::format(", {:.2g} deg", *contact.phase_noise_rad * 180 / std::numbers::pi);
  }
  return text + fmt::format("; {} points, {:.0f} degrees of freedom\n", contact.points,
                            contact.degrees_of_freedom);
}

std::string InfluenceLine(const fit::SkinInfluence& influence) {
  const std::string exactness = influence.relative_standard_uncertainty > 0
                                    ? fmt::format("standard uncertainty {:.2g} %",
                                                  100 * influence.relative_standard_uncertainty)
                                    : "taken as exact";
  return fmt::format("{}, {}; +1 % of it: Ks {:+.2f} %, Bs {:+.2f} %, m {:+.2g} g", influence.input,
                     exactness, influence.stiffness_percent_per_percent,
                     influence.damping_percent_per_percent, 1e3 * influence.mass_kg_per_percent);
}

std::string ContactText(const SkinFit& contact) {
  std::string text = fmt::format("{} (value +- 95 % interval)\n", contact.name);
  text += FittedLine("Ks", contact.stiffness) + FittedLine("Bs", contact.damping) +
          FittedLine("m", InGrams(contact.mass));
  text += fmt::format("  correlation Ks-Bs {:+.2f}, Ks-m {:+.2f}, Bs-m {:+.2f}\n",
                      contact.correlation[1], contact.correlation[2], contact.correlation[5]);
  text += NoiseLine(contact);
  text += SentenceSection("Not determined", contact.undetermined);
  text += SentenceSection("Doubtful", contact.doubts);
  std::vector<std::string> given;
  given.reserve(contact.influences.size());
  for (const auto& influence : contact.influences) {
    // R and L play no part beside a current
    const bool plays_a_part = influence.stiffness_percent_per_percent != 0 ||
                              influence.damping_percent_per_percent != 0 ||
                              influence.mass_kg_per_percent != 0;
    if (plays_a_part) given.push_back(InfluenceLine(influence));
  }
  return text + SentenceSection("Given", given) + SentenceSection("Assumed", contact.assumptions);
}

std::string Inside(const AreaDependence& dependence, double exponent) {
  return fit::Holds(dependence, exponent) ? "inside" : "outside";
}

std::string LawText(const char* name, const AreaDependence& dependence) {
  const auto& law = dependence.law;
  std::string text = fmt::format(
      "  {} ~ area^{:.3f}, 95 % interval {:.3f} to {:.3f}: 1/3 lies {}\n", name, law.exponent,
      dependence.lower_95, dependence.upper_95, Inside(dependence, 1.0 / 3));
  if (dependence.thesis_text && dependence.thesis_table) {
    text += fmt::format(
        "    the thesis's formula is a line over the cube root, with a mean exponent of {:.3f} "
        "over "
        "these areas ({})",
        *dependence.thesis_text, Inside(dependence, *dependence.thesis_text));
    const bool differs = *dependence.thesis_text != *dependence.thesis_table;
    text += differs ? fmt::format(" for 600-2000 N/m, {:.3f} ({}) for 600-1200 N/m\n",
                                  *dependence.thesis_table,
                                  Inside(dependence, *dependence.thesis_table))
                    : "\n";
  }
  if (law.birge_ratio == 0) {
    text += "    two areas: whether it is a power law at all is not seen\n";
  } else if (law.scatters) {
    text += fmt::format(
        "    the contacts scatter {:.2g} times as much as their sweeps explain: the interval is "
        "widened by that, with Student's t\n",
        law.birge_ratio);
  }
  return text;
}

std::string AreasText(const fit::SkinAreas& areas) {
  if (!areas.stiffness && !areas.damping) return {};
  std::string text = "Over the contact area\n";
  if (areas.stiffness) text += LawText("Ks", *areas.stiffness);
  if (areas.damping) text += LawText("Bs", *areas.damping);
  return text;
}

ordered_json ContactJson(const SkinFit& contact) {
  ordered_json correlation = ordered_json::array();
  for (std::size_t i = 0; i < fit::kContactParameters; ++i) {
    ordered_json row = ordered_json::array();
    for (std::size_t k = 0; k < fit::kContactParameters; ++k) {
      row.push_back(cli::NumberOrNull(contact.correlation[i * fit::kContactParameters + k]));
    }
    correlation.push_back(row);
  }
  ordered_json inputs = ordered_json::array();
  for (const auto& influence : contact.influences) {
    inputs.push_back({{"input", influence.input},
                      {"relative_standard_uncertainty", influence.relative_standard_uncertainty},
                      {"ks_percent_per_percent", influence.stiffness_percent_per_percent},
                      {"bs_percent_per_percent", influence.damping_percent_per_percent},
                      {"m_kg_per_percent", influence.mass_kg_per_percent}});
  }
  return {{"name", contact.name},
          {"contact_area_m2", cli::NumberOrNull(contact.area_m2)},
          {"parameters",
           {{"Ks", FittedJson(contact.stiffness)},
            {"Bs", FittedJson(contact.damping)},
            {"m", FittedJson(contact.mass)}}},
          {"correlation", correlation},
          {"singular_values", contact.singular_values},
          {"points", contact.points},
          {"uncertainties_stated", contact.uncertainties_stated},
          {"magnitude_noise", contact.magnitude_noise},
          {"phase_noise_rad", cli::NumberOrNull(contact.phase_noise_rad)},
          {"degrees_of_freedom", contact.degrees_of_freedom},
          {"coverage_factor_95", contact.coverage_95},
          {"serial_correlation", cli::NumberOrNull(contact.residuals.serial_correlation)},
          {"farthest_spread", cli::NumberOrNull(contact.residuals.farthest_spread)},
          {"inputs", inputs},
          {"assumptions", contact.assumptions},
          {"not_determined", contact.undetermined},
          {"doubts", contact.doubts},
          {"converged", contact.converged},
          {"iterations", contact.iterations}};
}

ordered_json LawJson(const std::optional<AreaDependence>& dependence) {
  if (!dependence) return nullptr;
  const auto& law = dependence->law;
  return {{"exponent", law.exponent},
          {"standard_uncertainty", law.standard_uncertainty},
          {"combined_standard_uncertainty", law.combined_standard_uncertainty},
          {"interval_95", {dependence->lower_95, dependence->upper_95}},
          {"at_1_mm2", law.at_one_mm2},
          {"one_third_inside", dependence->holds_one_third},
          {"birge_ratio",
           law.birge_ratio > 0 ? cli::NumberOrNull(law.birge_ratio) : ordered_json(nullptr)},
          {"scatters", law.scatters},
          {"thesis_exponent_600_2000", cli::NumberOrNull(dependence->thesis_text)},
          {"thesis_exponent_600_1200", cli::NumberOrNull(dependence->thesis_table)}};
}

// the amplitudes with the fit, and what it leaves of them
std::vector<plot::Panel> ContactPanels(const SkinFit& contact) {
  FrequencyCurve measured{contact.frequencies_hz, {}};
  FrequencyCurve model{contact.frequencies_hz, {}};
  SweepResiduals left;
  for (std::size_t n = 0; n < contact.measured_m.size(); ++n) {
    measured.values.push_back(1e6 * contact.measured_m[n]);
    model.values.push_back(1e6 * contact.model_m[n]);
    left.values.push_back(100 * std::log(contact.measured_m[n] / contact.model_m[n]));
  }
  return {
      SweepPanel(contact.name, "amplitude / um", measured, model, plot::LogAxes::kBoth),
      SweepResidualPanel("", "residual / %", contact.frequencies_hz, {left}, plot::LogAxes::kX)};
}

plot::Panel AreaPanel(std::vector<SkinFit> contacts, const AreaDependence& dependence) {
  std::erase_if(contacts, [](const SkinFit& c) { return !c.area_m2 || !c.stiffness.determined; });
  std::ranges::sort(contacts, {}, [](const SkinFit& c) { return *c.area_m2; });
  plot::Series points{
      .title = "contacts (95 %)",
      .style = {.mark = plot::Mark::kErrorBars, .colour = plot::kOrange, .size = 0.6},
      .x = {},
      .y = {},
      .y_error = {}};
  plot::Series line{.title = fmt::format("area^{:.3f}", dependence.law.exponent),
                    .style = plot::Lines(plot::kBlue),
                    .x = {},
                    .y = {},
                    .y_error = {}};
  for (const auto& contact : contacts) {
    const double mm2 = 1e6 * *contact.area_m2;
    points.x.push_back(mm2);
    points.y.push_back(contact.stiffness.value);
    points.y_error.push_back(contact.coverage_95 * contact.stiffness.combined_standard_uncertainty);
    line.x.push_back(mm2);
    line.y.push_back(dependence.law.at_one_mm2 * std::pow(mm2, dependence.law.exponent));
  }
  return {.title = "",
          .x_label = "contact area / mm^2",
          .y_label = "Ks / N/m",
          .series = {std::move(points), std::move(line)},
          .log_axes = plot::LogAxes::kBoth};
}

// of all contacts
std::string CommonAssumption(const std::string& actuator) {
  return fmt::format(
      "the case lies on the skin, which is a spring, a damper and a mass to ground; its constants "
      "and those of the actuator ({}) do not depend on the amplitude",
      actuator);
}

}  // namespace

std::string FitSkinText(const std::vector<SkinFit>& contacts, const fit::SkinAreas& areas,
                        const std::string& actuator) {
  std::string text;
  for (const auto& contact : contacts) text += ContactText(contact);
  text += AreasText(areas);
  return text + SentenceSection("Assumed", {CommonAssumption(actuator)});
}

std::string FitSkinJson(const std::vector<SkinFit>& contacts, const fit::SkinAreas& areas,
                        const std::string& actuator, const std::vector<Error>& left_out) {
  ordered_json document;
  document["actuator"] = actuator;
  document["contacts"] = ordered_json::array();
  for (const auto& contact : contacts) document["contacts"].push_back(ContactJson(contact));
  document["area_law"] = {{"Ks", LawJson(areas.stiffness)}, {"Bs", LawJson(areas.damping)}};
  document["assumptions"] = {CommonAssumption(actuator)};
  document["left_out"] = ordered_json::array();
  for (const auto& error : left_out) document["left_out"].push_back(error.Text());
  return cli::JsonText(document);
}

Result<void> PlotFitSkin(const std::string& path, const std::vector<SkinFit>& contacts,
                         const fit::SkinAreas& areas) {
  std::vector<plot::Panel> panels;
  panels.reserve(2 * contacts.size() + 1);
  for (const auto& contact : contacts) {
    for (auto& panel : ContactPanels(contact)) panels.push_back(std::move(panel));
  }
  if (areas.stiffness) panels.push_back(AreaPanel(contacts, *areas.stiffness));
  return plot::DrawPanels(path, panels);
}

}  // namespace haptometer::tools
