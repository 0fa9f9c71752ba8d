#include "tools/fit/fit_impedance.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "fit/impedance/impedance_fit.h"
#include "sim/scene/actuator.h"
#include "tools/cli/json.h"
#include "tools/cli/terminal.h"
#include "tools/fit/fit_figures.h"
#include "tools/fit/fit_lra_document.h"
#include "tools/fit/saved_actuator.h"
#include "tools/plot/gnuplot.h"
#include "tools/study/text_table.h"

namespace haptometer::tools {
namespace {

using fit::ImpedanceFit;
using nlohmann::ordered_json;

constexpr std::string_view kVerb = "fit-lra";
constexpr double kDegrees = 180 / std::numbers::pi;

Result<void> CheckOptions(const FitLraOptions& options) {
  if (!options.files.empty() || !options.open.empty() || !options.loads.empty()) {
    return Usage("--impedance", "excludes drops", "ask for one after the other");
  }
  if (options.held && options.is_free) {
    return Usage("--held", "excludes --free", "give one of them");
  }
  const std::pair<const char*, const std::optional<Quantity>*> kPositive[]{
      {"--moving-mass", &options.moving_mass_kg},
      {"--case-mass", &options.case_mass_kg},
      {"--resistance", &options.resistance_ohm},
      {"--inductance", &options.inductance_h}};
  for (const auto& [name, value] : kPositive) {
    if (*value && !((*value)->value > 0 && std::isfinite((*value)->value))) {
      return Usage(name, "must be positive", "check its sign");
    }
  }
  if (options.drop_height_m) return Usage("--drop-height", "belongs to a drop", "leave it out");
  return {};
}

Result<fit::ActuatorKnowns> KnownsOf(const FitLraOptions& options) {
  fit::ActuatorKnowns knowns{options.moving_mass_kg, options.case_mass_kg, options.resistance_ohm,
                             options.inductance_h};
  if (options.actuator.empty()) return knowns;
  const auto actuator = sim::FindActuator(options.actuator);
  if (!actuator) return std::unexpected(actuator.error());
  const auto fill = [](std::optional<Quantity>* known, const Quantity& stated) {
    if (!*known) *known = stated;
  };
  fill(&knowns.moving_mass_kg, actuator->moving_mass_kg);
  fill(&knowns.case_mass_kg, actuator->case_mass_kg);
  fill(&knowns.resistance_ohm, actuator->resistance_ohm);
  fill(&knowns.inductance_h, actuator->inductance_h);
  return knowns;
}

// the numbers of the column by its name or its other one
Result<std::vector<double>> Column(const TextTable& table, const std::string& name,
                                   const std::string& other) {
  if (table.columns.contains(name)) return NumbersOf(table, name);
  if (table.columns.contains(other)) return NumbersOf(table, other);
  return CannotAnswer(table.name, fmt::format("has no column {}", name),
                      "its header needs frequency_hz,impedance_ohm,phase_deg");
}

Result<std::vector<fit::ImpedancePoint>> ReadSweep(const std::string& path) {
  const auto table = ReadTextTable(path, {});
  if (!table) return std::unexpected(table.error());
  const auto hertz = Column(*table, "frequency_hz", "frequency");
  if (!hertz) return std::unexpected(hertz.error());
  const auto ohm = Column(*table, "impedance_ohm", "ohm");
  if (!ohm) return std::unexpected(ohm.error());
  const auto degrees = Column(*table, "phase_deg", "degrees");
  if (!degrees) return std::unexpected(degrees.error());
  std::vector<fit::ImpedancePoint> points;
  points.reserve(hertz->size());
  for (std::size_t n = 0; n < hertz->size(); ++n) {
    if (!((*hertz)[n] > 0 && (*ohm)[n] > 0)) {
      return CannotAnswer(fmt::format("{}:{}", path, table->lines[n]),
                          "has a frequency or a magnitude that is not positive", "mend that line");
    }
    points.push_back({(*hertz)[n], std::polar((*ohm)[n], (*degrees)[n] / kDegrees)});
  }
  return points;
}

std::string Text(const ImpedanceFit& fit) {
  const bool reduced = fit.mass_symbol != "Mv";
  std::string text = "Result (value +- 95 % interval)\n";
  text += FittedLine("Kv", fit.stiffness) + FittedLine("Bv", fit.damping) +
          FittedLine("Km", fit.force_constant);
  text += FittedLine("f0", fit.natural_frequency) + FittedLine("Q", fit.quality_factor);
  text += FittedLine(reduced ? "Kv/M" : "Kv/Mv", fit.stiffness_over_mass) +
          FittedLine(reduced ? "Bv/M" : "Bv/Mv", fit.damping_over_mass) +
          FittedLine(reduced ? "Km2/M" : "Km2/Mv", fit.coupling_over_mass) +
          FittedLine("R", fit.resistance) + FittedLine("L", fit.inductance);
  if (reduced) text += fmt::format("  M is the reduced mass {}\n", fit.mass_symbol);
  text += SentenceSection("Not determined", fit.undetermined);
  text += SentenceSection("Doubtful", fit.doubts);
  text += fmt::format(
      "Sweep\n  {} points from {:g} to {:g} Hz, {} within the resonance's width\n"
      "  a point's standard uncertainty, by the residuals: {:.2g} % of the magnitude, {:.2g} deg\n",
      fit.points, fit.lowest_hz, fit.highest_hz, fit.points_near_resonance,
      100 * fit.magnitude_noise, kDegrees * fit.phase_noise_rad);
  text += fmt::format("  intervals by Student's t with {:.0f} degrees of freedom\n",
                      fit.degrees_of_freedom);
  std::vector<std::string> given;
  for (const auto& input : fit.influences) {
    const auto& percent = input.percent_per_percent;
    given.push_back(
        fmt::format("{} {:g} {}, standard uncertainty {:g}; +1 % of it: Kv {:+.3f} %, "
                    "Bv {:+.3f} %, Km {:+.3f} %",
                    input.input, input.value, input.unit, input.standard_uncertainty, percent[0],
                    percent[1], percent[2]));
  }
  text += SentenceSection("Given", given) + SentenceSection("Assumed", fit.assumptions);
  return text + fmt::format("{} after {} iterations\n",
                            fit.converged ? "Converged" : "Not converged", fit.iterations);
}

ordered_json CorrelationJson(const ImpedanceFit& fit) {
  ordered_json rows = ordered_json::array();
  for (std::size_t i = 0; i < fit::kImpedanceParameters; ++i) {
    ordered_json row = ordered_json::array();
    for (std::size_t k = 0; k < fit::kImpedanceParameters; ++k) {
      row.push_back(cli::NumberOrNull(fit.correlation[i * fit::kImpedanceParameters + k]));
    }
    rows.push_back(row);
  }
  return {{"of", {"Kv/M", "Bv/M", "Km^2/M", "R", "L"}}, {"matrix", rows}};
}

std::string Json(const ImpedanceFit& fit, const std::string& path) {
  ordered_json document;
  document["file"] = path;
  document["parameters"] = {{"Kv", FittedJson(fit.stiffness)},
                            {"Bv", FittedJson(fit.damping)},
                            {"Km", FittedJson(fit.force_constant)}};
  document["kv_over_mass"] = FittedJson(fit.stiffness_over_mass);
  document["bv_over_mass"] = FittedJson(fit.damping_over_mass);
  document["km_squared_over_mass"] = FittedJson(fit.coupling_over_mass);
  document["mass"] = fit.mass_symbol;
  document["natural_frequency"] = FittedJson(fit.natural_frequency);
  document["quality_factor"] = FittedJson(fit.quality_factor);
  document["resistance"] = FittedJson(fit.resistance);
  document["inductance"] = FittedJson(fit.inductance);
  document["points"] = fit.points;
  document["lowest_hz"] = fit.lowest_hz;
  document["highest_hz"] = fit.highest_hz;
  document["points_near_resonance"] = fit.points_near_resonance;
  document["magnitude_noise"] = fit.magnitude_noise;
  document["phase_noise_rad"] = fit.phase_noise_rad;
  document["degrees_of_freedom"] = fit.degrees_of_freedom;
  document["coverage_factor_95"] = fit.coverage_95;
  document["serial_correlation"] = cli::NumberOrNull(fit.residuals.serial_correlation);
  document["farthest_hz"] = fit.farthest_hz;
  document["farthest_spread"] = cli::NumberOrNull(fit.residuals.farthest_spread);
  document["singular_values"] = fit.singular_values;
  document["correlation"] = CorrelationJson(fit);
  document["relative_covariance_kv_bv_km_r_l"] = fit.relative_covariance;
  document["inputs"] = ordered_json::array();
  for (const auto& input : fit.influences) {
    document["inputs"].push_back(
        {{"input", input.input},
         {"value", cli::NumberOrNull(input.value)},
         {"standard_uncertainty", input.standard_uncertainty},
         {"relative_standard_uncertainty", input.relative_standard_uncertainty},
         {"unit", input.unit},
         {"kv_percent_per_percent", input.percent_per_percent[0]},
         {"bv_percent_per_percent", input.percent_per_percent[1]},
         {"km_percent_per_percent", input.percent_per_percent[2]}});
  }
  document["assumptions"] = fit.assumptions;
  document["not_determined"] = fit.undetermined;
  document["doubts"] = fit.doubts;
  document["converged"] = fit.converged;
  document["iterations"] = fit.iterations;
  return cli::JsonText(document);
}

int StatusOf(const ImpedanceFit& fit, const std::vector<std::string>& required) {
  const std::pair<const char*, const fit::FittedValue*> kConstants[]{
      {"Kv", &fit.stiffness}, {"Bv", &fit.damping}, {"Km", &fit.force_constant}};
  int status = 0;
  for (const auto& [name, value] : kConstants) {
    const bool is_required = std::ranges::find(required, name) != required.end();
    if (value->determined || !is_required) continue;
    status = cli::ReportError(
        kVerb, CannotAnswer("", fmt::format("{} is required and not determined", name),
                            fit.undetermined.empty() ? "see the result" : fit.undetermined.back())
                   .error());
  }
  if (!fit.natural_frequency.determined || !fit.quality_factor.determined) {
    status = cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
  }
  return status;
}

// a sweep that says nothing; the document has the reason too
int Refuse(const Error& error, const std::string& path, bool json) {
  if (json) {
    const auto nothing = [](const char* unit) {
      fit::FittedValue value;
      value.unit = unit;
      return value;
    };
    ImpedanceFit none;
    none.stiffness = nothing("N/m");
    none.damping = nothing("N s/m");
    none.force_constant = nothing("N/A");
    none.stiffness_over_mass = nothing("1/s^2");
    none.damping_over_mass = nothing("1/s");
    none.coupling_over_mass = nothing("N^2/(A^2 kg)");
    none.natural_frequency = nothing("Hz");
    none.resistance = nothing("ohm");
    none.inductance = nothing("H");
    none.mass_symbol = "Mv";
    none.correlation.assign(fit::kImpedanceParameters * fit::kImpedanceParameters,
                            std::numeric_limits<double>::quiet_NaN());
    none.undetermined.push_back(error.Text());
    fmt::print("{}", Json(none, path));
  }
  return cli::ReportError(kVerb, error);
}

}  // namespace

int AnswerImpedance(const ImpedanceFiles& files, const FitLraOptions& options, bool json) {
  if (auto good = CheckOptions(options); !good) return cli::ReportError(kVerb, good.error());
  const auto knowns = KnownsOf(options);
  if (!knowns) return cli::ReportError(kVerb, knowns.error());
  const auto points = ReadSweep(files.sweep);
  if (!points) return Refuse(points.error(), files.sweep, json);
  const auto condition = options.is_free ? fit::CaseCondition::kFree : fit::CaseCondition::kHeld;
  auto fit = fit::FitImpedance(*points, *knowns, condition, files.sweep);
  if (!fit) return Refuse(fit.error(), files.sweep, json);
  if (!options.held && !options.is_free) {
    fit->assumptions.emplace_back(
        "the case was held (neither --held nor --free is given); free, the ringing mass would be "
        "Mv Mc/(Mv+Mc), and Kv, Bv and Km^2 smaller by the factor Mc/(Mv+Mc)");
  }
  cli::Print(json ? Json(*fit, files.sweep) : Text(*fit));
  int status = StatusOf(*fit, options.required);
  if (!files.save.empty()) {
    const auto saved = SaveActuator(files.save, files.overwrite, FittedActuator(*fit, *knowns));
    if (!saved) status = cli::WorseStatus(status, cli::ReportError(kVerb, saved.error()));
  }
  if (!files.plot.empty()) {
    const auto drawn = plot::DrawPanels(files.plot, ImpedancePanels(*fit, *points));
    if (!drawn) status = cli::WorseStatus(status, cli::ReportError(kVerb, drawn.error()));
  }
  return status;
}

}  // namespace haptometer::tools
