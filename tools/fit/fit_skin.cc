#include "tools/fit/fit_skin.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "base/mapped.h"
#include "base/text.h"
#include "fit/skin/skin_areas.h"
#include "sim/scene/actuator.h"
#include "tools/cli/options.h"
#include "tools/document/findings_fit.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/fit/drop_records.h"
#include "tools/fit/fit_document.h"
#include "tools/fit/fit_figures.h"
#include "tools/study/text_table.h"
#include "tools/sweep/sweep.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Item;
using document::Section;
using fit::AreaDependence;
using fit::SkinFit;

constexpr std::string_view kVerb = "fit-skin";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Fit the skin's stiffness, damping and mass under a contact to a drive sweep.",
    .examples = {"haptometer fit-skin sweep.csv --actuator actuator.toml",
                 "haptometer fit-skin 1mm2.csv 20mm2.csv 80mm2.csv --actuator actuator.toml"
                 " --plot skin.svg",
                 "haptometer fit-skin sweep.csv --actuator thesis-c10-100 --json"}};

// --- reading ---

// amplitude over RMS of a sine
constexpr double kRms = std::numbers::sqrt2;
constexpr KnownColumn kDisplacements[]{
    {"displacement_amplitude_m", 1},      {"displacement_amplitude_mm", 1e-3},
    {"displacement_amplitude_um", 1e-6},  {"displacement_rms_m", kRms},
    {"displacement_rms_mm", kRms * 1e-3}, {"displacement_rms_um", kRms * 1e-6},
    {document::kSkinRms.name, kRms}};  // of sweep
constexpr KnownColumn kCurrents[]{{"current_amplitude_a", 1},
                                  {"current_amplitude_ma", 1e-3},
                                  {document::kCurrentRms.name, kRms},
                                  {"current_rms_ma", kRms * 1e-3}};
constexpr KnownColumn kVoltages[]{{"voltage_amplitude_v", 1}, {"voltage_rms_v", kRms}};
constexpr KnownColumn kUncertainties[]{{"displacement_standard_uncertainty_m", 1},
                                       {"displacement_standard_uncertainty_um", 1e-6}};

// amplitudes over that of the drive, as analyze --sweep --response writes them
constexpr KnownColumn kPerCurrent[]{{"amplitude_m_per_a", 1}};
constexpr KnownColumn kPerVoltage[]{{"amplitude_m_per_v", 1}};

using Column = std::optional<std::vector<double>>;

Result<std::vector<double>> Required(const TextTable& table, std::span<const KnownColumn> known,
                                     const char* what, const char* remedy) {
  HAPTOMETER_LET(auto column, FindColumn(table, known));
  if (column) return std::move(*column);
  return CannotAnswer(table.name, fmt::format("has no {} with its unit", what), remedy);
}

// the columns of a table
struct Columns {
  std::vector<double> frequencies_hz;
  std::vector<double> displacements_m;
  std::vector<double> drives;
  fit::DriveQuantity drive = fit::DriveQuantity::kCurrent;
  Column phases_deg;
  Column uncertainties_m;
  Column areas_mm2;
};

// displacements over the drive's amplitude, with the phase between the two; false where the table
// has none
Result<bool> ReadResponse(const TextTable& table, Columns* columns) {
  // analyze writes the phase in rad
  constexpr KnownColumn kPhase[]{{document::kPhase.name, 180 / std::numbers::pi}};
  HAPTOMETER_LET(auto per_current, FindColumn(table, kPerCurrent));
  HAPTOMETER_LET(auto per_voltage, FindColumn(table, kPerVoltage));
  if (!per_current && !per_voltage) {
    const bool is_response = table.columns.contains(std::string(document::kAmplitude.name)) ||
                             table.columns.contains("amplitude_m_per_unit");
    if (!is_response) return false;
    return CannotAnswer(
        table.name, "is the response of a sweep whose drive was not recorded in A or V",
        "record the coil's current or voltage as a channel beside the displacement");
  }
  columns->drive = per_current ? fit::DriveQuantity::kCurrent : fit::DriveQuantity::kVoltage;
  columns->displacements_m = std::move(per_current ? *per_current : *per_voltage);
  // per unit of drive: the drive is 1 A or 1 V
  columns->drives.assign(columns->displacements_m.size(), 1);
  HAPTOMETER_LET(columns->phases_deg, FindColumn(table, kPhase));
  return true;
}

Result<void> ReadDrive(const TextTable& table, Columns* columns) {
  HAPTOMETER_LET(auto current, FindColumn(table, kCurrents));
  if (current) {
    columns->drives = std::move(*current);
    return {};
  }
  HAPTOMETER_LET(columns->drives,
                 Required(table, kVoltages, "drive",
                          "its header needs current_amplitude_a (or _ma, current_rms_a, _ma), or "
                          "voltage_amplitude_v"));
  columns->drive = fit::DriveQuantity::kVoltage;
  return {};
}

Result<Columns> ReadColumns(const TextTable& table) {
  constexpr KnownColumn kFrequency[]{{document::kFrequency.name, 1}, {"drive.frequency_hz", 1}};
  constexpr KnownColumn kPhase[]{{"phase_deg", 1}};
  constexpr KnownColumn kArea[]{
      {"contact_area_mm2", 1}, {"contact_area_m2", 1e6}, {"skin.contact_area_m2", 1e6}};
  Columns columns;
  HAPTOMETER_LET(auto frequency, Required(table, kFrequency, "frequency",
                                          "its header needs the column frequency_hz"));
  columns.frequencies_hz = std::move(frequency);
  HAPTOMETER_LET(columns.areas_mm2, FindColumn(table, kArea));
  // all rows would be one contact where their areas are not read
  const auto area = std::ranges::find_if(
      table.columns, [](const auto& column) { return column.first.contains("area"); });
  if (!columns.areas_mm2 && area != table.columns.end()) {
    return CannotAnswer(table.name,
                        fmt::format("has a column {}, whose unit is not known", area->first),
                        "name it contact_area_mm2 or contact_area_m2");
  }
  // a response table has its drive and phase in its own columns
  HAPTOMETER_LET(const auto is_response, ReadResponse(table, &columns));
  if (is_response) return columns;
  HAPTOMETER_LET(columns.displacements_m,
                 Required(table, kDisplacements, "displacement",
                          "its header needs displacement_amplitude_um (or _m, _mm, or "
                          "displacement_rms_um, _m, _mm)"));
  HAPTOMETER_TRY(ReadDrive(table, &columns));
  HAPTOMETER_LET(columns.phases_deg, FindColumn(table, kPhase));
  HAPTOMETER_LET(columns.uncertainties_m, FindColumn(table, kUncertainties));
  return columns;
}

// of a table of sweep: what it varies besides the frequency and the area is no sweep of one contact
Result<void> CheckVariedKeys(const TextTable& table) {
  if (!table.columns.contains("drive.frequency_hz")) return {};
  for (const auto& [name, cells] : table.columns) {
    const bool is_key = name.contains('.');
    if (!is_key || name == "drive.frequency_hz" || name == "skin.contact_area_m2") continue;
    return CannotAnswer(table.name, fmt::format("varies {} besides the frequency", name),
                        "give a table of one contact, or of several skin.contact_area_m2");
  }
  return {};
}

// whether sweep has written it: as it names itself above the columns
bool IsOfSweep(const TextTable& table) {
  return std::ranges::any_of(table.comments,
                             [](const std::string& line) { return line.starts_with(kTableTitle); });
}

fit::SkinPoint PointAt(const Columns& columns, std::size_t row, double uncertainty_factor) {
  fit::SkinPoint point{.frequency_hz = columns.frequencies_hz[row],
                       .displacement_m = columns.displacements_m[row],
                       .drive = columns.drives[row]};
  if (columns.phases_deg) point.phase_rad = (*columns.phases_deg)[row] * std::numbers::pi / 180;
  if (columns.uncertainties_m) {
    point.displacement_standard_uncertainty_m =
        (*columns.uncertainties_m)[row] * uncertainty_factor;
  }
  return point;
}

}  // namespace

Result<std::vector<fit::SkinSweep>> ReadSkinSweeps(const std::string& path) {
  HAPTOMETER_LET(const auto table, ReadTextTable(path, {}));
  HAPTOMETER_TRY(CheckVariedKeys(table));
  HAPTOMETER_LET(const auto columns, ReadColumns(table));
  // an uncertainty is that of the displacement as its column states it: of an RMS, times sqrt(2)
  bool is_rms = false;
  for (const auto& [name, cells] : table.columns) {
    is_rms = is_rms || name.starts_with("displacement_rms");
  }

  // in the order of areas; one sweep where none is stated
  std::map<double, fit::SkinSweep> sweeps;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double area_mm2 = columns.areas_mm2 ? (*columns.areas_mm2)[row] : 0;
    if (columns.areas_mm2 && !(area_mm2 > 0)) {
      return CannotAnswer(fmt::format("{}:{}", path, table.lines[row]),
                          "has a contact area that is not positive", "correct that cell");
    }
    fit::SkinSweep& sweep = sweeps[area_mm2];
    sweep.drive = columns.drive;
    sweep.is_simulated = IsOfSweep(table);
    sweep.name = columns.areas_mm2 ? fmt::format("{} ({:g} mm2)", Printable(path), area_mm2)
                                   : Printable(path);
    if (columns.areas_mm2) sweep.area_m2 = 1e-6 * area_mm2;
    sweep.points.push_back(PointAt(columns, row, is_rms ? kRms : 1));
  }
  std::vector<fit::SkinSweep> list;
  list.reserve(sweeps.size());
  for (auto& [area, sweep] : sweeps) list.push_back(std::move(sweep));
  return list;
}

namespace {

// the sweeps of all tables, and what could not be read
struct Sweeps {
  std::vector<fit::SkinSweep> list;
  std::vector<Error> left_out;
};

Result<Sweeps> ReadAll(const std::vector<std::string>& files) {
  HAPTOMETER_TRY(CheckDistinct(files));
  Sweeps sweeps;
  for (const std::string& file : files) {
    auto read = ReadSkinSweeps(file);
    if (!read) {
      sweeps.left_out.push_back(read.error());
      continue;
    }
    for (auto& sweep : *read) {
      // one answer is for one kind of drive
      if (!sweeps.list.empty() && sweep.drive != sweeps.list.front().drive) {
        return Usage(file, "has voltages and another table has currents",
                     "ask for them one after the other");
      }
      sweeps.list.push_back(std::move(sweep));
    }
  }
  return sweeps;
}

Result<sim::StatedActuator> Actuator(const std::string& name) {
  if (name.empty()) {
    return Usage("--actuator",
                 "is missing: the skin is determined from its load on a known actuator",
                 "add --actuator actuator.toml (with Kv, Bv, Km) or thesis-c10-100");
  }
  auto stated = sim::FindActuator(name);
  if (!stated) return std::unexpected(stated.error());
  HAPTOMETER_TRY(sim::Complete(*stated));
  return stated;
}

// everything that fit-skin answers
struct FitSkinAnswer {
  std::string actuator;  // its name
  std::vector<fit::SkinFit> contacts{};
  fit::SkinAreas areas{};
  std::vector<Error> left_out{};  // tables and contacts that cannot be fitted
};

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
  Section section{.heading = contact.name,
                  .sources = {contact.is_simulated ? document::DataSource::kSimulated
                                                   : document::DataSource::kImported}};
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

void AddSkinFindings(const FitSkinAnswer& answer, Section& root) {
  const std::pair<const char*, const std::optional<AreaDependence>&> laws[]{
      {"Ks", answer.areas.stiffness}, {"Bs", answer.areas.damping}};
  for (const auto& [name, dependence] : laws) {
    if (!dependence) continue;
    const fit::AreaLaw& law = dependence->law;
    const FindingNumber constant{"constant", std::string(name)};
    if (law.birge_ratio == 0) {
      root.Find(Severity::kNote, "two-areas",
                "{constant}: two areas do not show whether it follows a power law at all",
                {constant});
    }
    if (law.scatters) {
      root.Find(Severity::kDoubt, "areas-scatter",
                "{constant}: the contacts scatter {birge_ratio} times as much as their sweeps "
                "explain; the interval is widened by that, with Student's t",
                {constant, {"birge_ratio", law.birge_ratio}});
    }
  }
  root.Find(Severity::kNote, "linear-skin",
            "the case lies on the skin, which is a spring, a damper and a mass to ground; its "
            "constants and those of the actuator ({actuator}) do not depend on the amplitude",
            {{"actuator", answer.actuator}});
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
    points.y_error.push_back(contact.stiffness.upper - contact.stiffness.value);
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

// the skin under each contact, and over the area
document::Document FitSkinDocument(const FitSkinAnswer& answer) {
  document::Document document{.verb = std::string(kVerb),
                              .title = fmt::format("Skin under the actuator {}", answer.actuator)};
  Section& root = document.root;
  root.Add({"actuator"}, answer.actuator);
  Section law{.name = "area_law"};
  law.sections = {LawSection("Ks", answer.areas.stiffness), LawSection("Bs", answer.areas.damping)};
  root.sections = {ListOf({.name = "contacts", .shape = Section::Shape::kArray}, answer.contacts,
                          ContactSection),
                   std::move(law)};
  root.figures = FiguresOf(answer);
  AddSkinFindings(answer, root);
  return document;
}

// --- the verb ---

// what cannot be used is excluded, the rest is answered
FitSkinAnswer Answer(Sweeps sweeps, const sim::StatedActuator& actuator) {
  FitSkinAnswer answer{.actuator = actuator.name, .left_out = std::move(sweeps.left_out)};
  for (const fit::SkinSweep& sweep : sweeps.list) {
    auto contact = fit::FitSkin(sweep, actuator);
    if (contact) {
      answer.contacts.push_back(std::move(*contact));
    } else {
      answer.left_out.push_back(contact.error());
    }
  }
  if (!answer.contacts.empty()) answer.areas = fit::FitSkinAreas(answer.contacts);
  return answer;
}

}  // namespace

int RunFitSkin(int argc, const char* const* argv) {
  cli::Options options(kText);
  std::vector<std::string> files;
  std::string actuator_name;
  document::Outputs outputs;
  options.Positionals("tables", &files,
                      "CSV with frequency_hz, displacement_amplitude_um, current_amplitude_ma and "
                      "further columns (docs/reference/fit-skin.md)");
  options
      .Text("--actuator", &actuator_name, "NAME|FILE.toml",
            "The known actuator: a file with Kv, Bv and Km, or thesis-c10-100")
      .Known({"thesis-c10-100"});
  document::DeclareOutputs(options, outputs,
                           {.all = "Print correlations and given numbers too, and the provenance",
                            .plot = "Draw sweeps, fits and the area law"});
  return document::RunVerb(kVerb, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_LET(const auto actuator, Actuator(actuator_name));
    HAPTOMETER_LET(auto sweeps, ReadAll(files));
    const FitSkinAnswer answer = Answer(std::move(sweeps), actuator);
    return PresentWithout(answer.left_out, FitSkinDocument(answer), !answer.contacts.empty(),
                          outputs, argc, argv);
  });
}

}  // namespace haptometer::tools
