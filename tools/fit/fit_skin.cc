#include "tools/fit/fit_skin.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "sim/scene/actuator.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/fit/fit_document.h"
#include "tools/study/text_table.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "fit-skin";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Fit the skin's stiffness, damping and mass under a contact to a drive sweep.",
    .examples = {"haptometer fit-skin sweep.csv --actuator actuator.toml",
                 "haptometer fit-skin 1mm2.csv 20mm2.csv 80mm2.csv --actuator actuator.toml"
                 " --plot skin.svg",
                 "haptometer fit-skin sweep.csv --actuator thesis-c10-100 --json"}};

// the sweeps of all tables, and what could not be read
struct Sweeps {
  std::vector<fit::SkinSweep> list;
  std::vector<Error> left_out;
};

Result<Sweeps> ReadAll(const std::vector<std::string>& files) {
  Sweeps sweeps;
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (std::find(files.begin(), files.begin() + static_cast<std::ptrdiff_t>(k), files[k]) !=
        files.begin() + static_cast<std::ptrdiff_t>(k)) {
      return Usage(files[k], "is given twice", "name each table once");
    }
    auto read = ReadSkinSweeps(files[k]);
    if (!read) {
      sweeps.left_out.push_back(read.error());
      continue;
    }
    for (auto& sweep : *read) {
      // one answer is for one kind of drive
      if (!sweeps.list.empty() && sweep.drive != sweeps.list.front().drive) {
        return Usage(files[k], "has voltages and another table has currents",
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

// a column's name and what its numbers are multiplied by
struct Known {
  std::string_view name;
  double factor;
};

// amplitude over RMS of a sine
constexpr double kRms = std::numbers::sqrt2;
constexpr Known kDisplacements[]{
    {"displacement_amplitude_m", 1},      {"displacement_amplitude_mm", 1e-3},
    {"displacement_amplitude_um", 1e-6},  {"displacement_rms_m", kRms},
    {"displacement_rms_mm", kRms * 1e-3}, {"displacement_rms_um", kRms * 1e-6},
    {document::kSkinRms.name, kRms}};  // of sweep
constexpr Known kCurrents[]{{"current_amplitude_a", 1},
                            {"current_amplitude_ma", 1e-3},
                            {document::kCurrentRms.name, kRms},
                            {"current_rms_ma", kRms * 1e-3}};
constexpr Known kVoltages[]{{"voltage_amplitude_v", 1}, {"voltage_rms_v", kRms}};
constexpr Known kUncertainties[]{{"displacement_standard_uncertainty_m", 1},
                                 {"displacement_standard_uncertainty_um", 1e-6}};

// amplitudes over that of the drive, as analyze --sweep --response writes them
constexpr Known kPerCurrent[]{{"amplitude_m_per_a", 1}};
constexpr Known kPerVoltage[]{{"amplitude_m_per_v", 1}};

using Column = std::optional<std::vector<double>>;

// the one of `known` that the table has; nothing where it has none
Result<Column> Find(const TextTable& table, std::span<const Known> known) {
  Column found;
  std::string_view name;
  for (const Known& column : known) {
    if (!table.columns.contains(std::string(column.name))) continue;
    if (found) {
      return CannotAnswer(table.name, fmt::format("has both {} and {}", name, column.name),
                          "leave one out");
    }
    HAPTOMETER_LET(auto numbers, NumbersOf(table, std::string(column.name)));
    for (double& number : numbers) number *= column.factor;
    found = std::move(numbers);
    name = column.name;
  }
  return found;
}

Result<std::vector<double>> Required(const TextTable& table, std::span<const Known> known,
                                     const char* what, const char* remedy) {
  HAPTOMETER_LET(auto column, Find(table, known));
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
  constexpr Known kPhase[]{{document::kPhase.name, 180 / std::numbers::pi}};
  HAPTOMETER_LET(auto per_current, Find(table, kPerCurrent));
  HAPTOMETER_LET(auto per_voltage, Find(table, kPerVoltage));
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
  HAPTOMETER_LET(columns->phases_deg, Find(table, kPhase));
  return true;
}

Result<void> ReadDrive(const TextTable& table, Columns* columns) {
  HAPTOMETER_LET(auto current, Find(table, kCurrents));
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
  constexpr Known kFrequency[]{{document::kFrequency.name, 1}, {"drive.frequency_hz", 1}};
  constexpr Known kPhase[]{{"phase_deg", 1}};
  constexpr Known kArea[]{{"contact_area_mm2", 1}, {"skin.contact_area_m2", 1e6}};
  Columns columns;
  auto frequency =
      Required(table, kFrequency, "frequency", "its header needs the column frequency_hz");
  if (!frequency) return std::unexpected(frequency.error());
  columns.frequencies_hz = std::move(*frequency);
  // a response table has its drive and phase in its own columns
  HAPTOMETER_LET(const auto is_response, ReadResponse(table, &columns));
  if (is_response) return columns;
  HAPTOMETER_LET(columns.displacements_m,
                 Required(table, kDisplacements, "displacement",
                          "its header needs displacement_amplitude_um (or _m, _mm, or "
                          "displacement_rms_um, _m, _mm)"));
  HAPTOMETER_TRY(ReadDrive(table, &columns));
  const std::pair<std::span<const Known>, Column*> kOptional[]{
      {kPhase, &columns.phases_deg},
      {kUncertainties, &columns.uncertainties_m},
      {kArea, &columns.areas_mm2}};
  for (const auto& [known, column] : kOptional) {
    HAPTOMETER_LET(*column, Find(table, known));
  }
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

int RunFitSkin(int argc, const char* const* argv) {
  cli::Options options(kText);
  std::vector<std::string> files;
  std::string actuator_name;
  document::Outputs outputs;
  options.Positionals("tables", &files,
                      "frequency_hz, displacement_amplitude_um, current_amplitude_ma and further "
                      "columns (docs/reference/fit-skin.md)");
  options.Text("--actuator", &actuator_name, "NAME|FILE",
               "The known actuator: a file with Kv, Bv and Km, or thesis-c10-100");
  options.Flag("--all", &outputs.all,
               "Print correlations and given numbers too, and the provenance");
  options.Output("--plot", &outputs.plot, "FILE.svg|png|pdf", "Draw sweeps, fits and the area law");
  options.Output("--report", &outputs.report, "FILE.html",
                 "Write one page with all details and the figures");
  if (const auto status = options.Parse(argc, argv)) return *status;
  outputs.json = options.json();
  if (auto good = CheckOutputs(outputs); !good) return cli::ReportError(kVerb, good.error());
  const auto actuator = Actuator(actuator_name);
  if (!actuator) return cli::ReportError(kVerb, actuator.error());
  auto sweeps = ReadAll(files);
  if (!sweeps) return cli::ReportError(kVerb, sweeps.error());

  const FitSkinAnswer answer = Answer(std::move(*sweeps), *actuator);
  const int status = cli::ReportErrors(kVerb, answer.left_out);
  if (answer.contacts.empty() && !IsShownEmpty(outputs)) return status;
  if (answer.contacts.empty()) outputs.plot.clear();
  return cli::WorseStatus(status, document::Present(FitSkinDocument(answer), outputs, argc, argv));
}

}  // namespace haptometer::tools
