#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/mapped.h"
#include "tools/document/findings_fit.h"
#include "tools/document/keys.h"
#include "tools/fit/fit_document.h"
#include "tools/fit/fit_figures.h"
#include "tools/fit/fit_skin.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Item;
using document::Section;
using fit::AreaDependence;
using fit::SkinFit;

constexpr double kLeastMassKg = 1e-9;  // no scale of the trade shows less

// --- a contact ---

Section ParametersOf(const SkinFit& contact) {
  Section parameters{.name = document::kParameters.name};
  AddFitted(parameters, {"Ks", "stiffness Ks", document::kNewtonPerMetre, Form::kEstimate},
            contact.stiffness);
  AddFitted(parameters, {"Bs", "damping Bs", document::kNewtonSecondPerMetre, Form::kEstimate},
            contact.damping);
  AddFitted(parameters, {"m", "moving mass m", document::kKilogram, Form::kEstimate}, contact.mass)
      .resolution = kLeastMassKg;
  return parameters;
}

// the response to 1 % of each given number
Section InputsOf(const SkinFit& contact) {
  Section table{.name = document::kInputs.name,
                .heading = "given, and the change by 1 % of it",
                .shape = Section::Shape::kTable,
                .detail = Detail::kAll};
  for (const fit::SkinInfluence& input : contact.influences) {
    Section& row = table.sections.emplace_back();
    row.Add(document::kInput, input.input);
    ShowDigits(
        row.Add({document::kRelativeUncertainty.name, "standard uncertainty", document::kShare},
                input.relative_standard_uncertainty),
        2);
    AddRatio(row, {"ks_percent_per_percent", "Ks", kPercent}, input.stiffness_percent_per_percent);
    AddRatio(row, {"bs_percent_per_percent", "Bs", kPercent}, input.damping_percent_per_percent);
    row.Add({"m_kg_per_percent", "m", document::kKilogram}, input.mass_kg_per_percent).resolution =
        kLeastMassKg;
  }
  return table;
}

Section SearchOf(const SkinFit& contact) {
  Section section{.detail = Detail::kAll};
  section.Add(document::kPoints, contact.points);
  section.Add({"uncertainties_stated"}, contact.uncertainties_stated);
  AddPointNoise(section, contact.magnitude_noise, contact.phase_noise_rad,
                contact.uncertainties_stated);
  AddSweepSearch(section, contact);
  // elements of the 3 x 3 matrix over Ks, Bs, m
  AddRatio(section, {"", "correlation of Ks and Bs"}, contact.correlation[1]);
  AddRatio(section, {"", "correlation of Ks and m"}, contact.correlation[2]);
  AddRatio(section, {"", "correlation of Bs and m"}, contact.correlation[5]);
  const std::vector<double> matrix(contact.correlation.begin(), contact.correlation.end());
  section.Add(document::kCorrelation, RowsOf(matrix, fit::kContactParameters));
  return section;
}

Section ContactSection(const SkinFit& contact) {
  Section section{.heading = contact.name, .sources = {document::DataSource::kImported}};
  section.Add(document::kName, contact.name);
  section.Add(document::kContactArea, contact.area_m2);
  section.sections = {ParametersOf(contact), SearchOf(contact), InputsOf(contact)};
  document::AddFindings(section, contact.findings);
  for (document::Finding& finding : section.findings) finding.subject = contact.name;
  return section;
}

// --- over the area ---

// whether the exponent of a formula lies in the interval
std::string InsideText(const AreaDependence& dependence, double exponent) {
  return fit::Holds(dependence, exponent) ? "inside the interval" : "outside of the interval";
}

Section LawSection(const char* name, const std::optional<AreaDependence>& known) {
  const AreaDependence dependence = known.value_or(AreaDependence{});
  const fit::AreaLaw& law = dependence.law;
  Section section{
      .name = name, .heading = fmt::format("{} ~ area^p", name), .is_known = known.has_value()};
  const auto exponent = [&](const document::Key& key, std::optional<double> value) {
    Item& item = section.Add(key, value);
    item.resolution = 1e-3;
    if (value) item.note = InsideText(dependence, *value);
  };
  Item& item = section.Add({"exponent", "exponent p"}, law.exponent);
  item.standard_uncertainty = law.combined_standard_uncertainty;
  item.interval = {.lower = dependence.lower_95, .upper = dependence.upper_95};
  exponent({"", "a cube root's"}, 1.0 / 3);
  exponent({"thesis_exponent_600_2000", "mean of the thesis's formula, 600 to 2000 N/m"},
           dependence.thesis_text);
  exponent({"thesis_exponent_600_1200", "mean of the thesis's formula, 600 to 1200 N/m"},
           dependence.thesis_table);
  section.Add(document::kStandardUncertainty, law.standard_uncertainty);
  section.Add(document::kCombinedUncertainty, law.combined_standard_uncertainty);
  section.Add(document::kInterval95,
              document::Range{.lower = dependence.lower_95, .upper = dependence.upper_95});
  section.Add({"at_1_mm2", "at 1 mm2"}, law.at_one_mm2);
  section.Add({"one_third_inside"}, dependence.holds_one_third);
  section.Add(document::kBirgeRatio,
              law.birge_ratio > 0 ? std::optional(law.birge_ratio) : std::nullopt);
  section.Add({"scatters"}, law.scatters);
  return section;
}

// --- findings ---

enum class SkinAnswerFinding : std::uint8_t { kLinearSkin, kTwoAreas, kAreasScatter };

document::Sentence SentenceOf(SkinAnswerFinding kind) {
  using enum SkinAnswerFinding;
  static constexpr document::KindSentence<SkinAnswerFinding> kSentences[] = {
      {kLinearSkin, "linear-skin",
       "the case lies on the skin, which is a spring, a damper and a mass to ground; its "
       "constants and those of the actuator ({actuator}) do not depend on the amplitude"},
      {kTwoAreas, "two-areas",
       "{constant}: two areas do not show whether it follows a power law at all"},
      {kAreasScatter, "areas-scatter",
       "{constant}: the contacts scatter {birge_ratio} times as much as their sweeps explain; "
       "the interval is widened by that, with Student's t"},
  };
  return document::SentenceIn(kSentences, kind);
}

Findings<SkinAnswerFinding> FindingsOf(const FitSkinAnswer& answer) {
  using enum SkinAnswerFinding;
  Findings<SkinAnswerFinding> findings;
  const std::array<std::pair<const char*, const std::optional<AreaDependence>*>, 2> laws{
      {{"Ks", &answer.areas.stiffness}, {"Bs", &answer.areas.damping}}};
  for (const auto& [name, dependence] : laws) {
    if (!*dependence) continue;
    const fit::AreaLaw& law = (*dependence)->law;
    const FindingNumber constant{"constant", std::string(name)};
    if (law.birge_ratio == 0) findings.Note(kTwoAreas, {constant});
    if (law.scatters) findings.Doubt(kAreasScatter, {constant, {"birge_ratio", law.birge_ratio}});
  }
  findings.Note(kLinearSkin, {{"actuator", answer.actuator}});
  return findings;
}

// --- figures ---

// the amplitudes with the fit, and what it leaves of them
std::vector<plot::Panel> ContactPanels(const SkinFit& contact) {
  FrequencyCurve measured{contact.frequencies_hz, {}};
  FrequencyCurve model{contact.frequencies_hz, {}};
  SweepResiduals left;
  for (std::size_t n = 0; n < contact.measured_m.size(); ++n) {
    // um; residuals 100 ln(measured/model) in %
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
      .style = {.mark = plot::Mark::kErrorBars, .colour = plot::kOrange, .size = 0.6}};
  plot::Series line{.title = fmt::format("area^{:.3f}", dependence.law.exponent),
                    .style = plot::Lines(plot::kBlue)};
  for (const auto& contact : contacts) {
    // error bars of 95 %; line: value at 1 mm2 times (area/1 mm2)^p
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

std::vector<document::Figure> FiguresOf(const FitSkinAnswer& answer) {
  auto figures = Mapped<document::Figure>(answer.contacts, [](const SkinFit& contact) {
    return document::Figure{.caption = contact.name + ": amplitudes, fit and residual",
                            .panels = ContactPanels(contact)};
  });
  if (answer.areas.stiffness) {
    figures.push_back({.caption = "Ks over the contact's area",
                       .panels = {AreaPanel(answer.contacts, *answer.areas.stiffness)}});
  }
  return figures;
}

}  // namespace

document::Document FitSkinDocument(const FitSkinAnswer& answer) {
  document::Document document{.verb = "fit-skin",
                              .title = fmt::format("Skin under the actuator {}", answer.actuator)};
  Section& root = document.root;
  root.Add({"actuator"}, answer.actuator);
  Section law{.name = "area_law"};
  law.sections = {LawSection("Ks", answer.areas.stiffness), LawSection("Bs", answer.areas.damping)};
  root.sections = {ListOf({.name = "contacts", .shape = Section::Shape::kArray}, answer.contacts,
                          ContactSection),
                   std::move(law)};
  root.figures = FiguresOf(answer);
  AddLeftOut(root, answer.left_out);
  document::AddFindings(root, FindingsOf(answer));
  return document;
}

}  // namespace haptometer::tools
