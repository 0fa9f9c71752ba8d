#include "tools/fit/fit_lra_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tools/cli/json.h"
#include "tools/fit/fit_lra_budget.h"
#include "tools/fit/fitted_value_output.h"

namespace haptometer::tools {
namespace {

using fit::DropTestFit;
using fit::FittedValue;
using nlohmann::ordered_json;

ordered_json PositiveOrNull(double value) {
  return value > 0 ? cli::NumberOrNull(value) : ordered_json(nullptr);
}

// a plain number and its uncertainty beside it
void AddPlain(ordered_json& document, const std::string& key, const FittedValue& value) {
  document[key] = value.determined ? cli::NumberOrNull(value.value) : ordered_json(nullptr);
  document[key + "_standard_uncertainty"] =
      value.determined ? cli::NumberOrNull(value.combined_standard_uncertainty)
                       : ordered_json(nullptr);
}

ordered_json BudgetJson(const DropTestFit& fit) {
  ordered_json rows = ordered_json::array();
  for (const BudgetRow& row : BudgetOf(fit)) {
    rows.push_back({{"cause", row.cause},
                    {"type", cli::TextOrNull(std::string(row.type))},
                    {"kv_percent", cli::NumberOrNull(row.percent[0])},
                    {"bv_percent", cli::NumberOrNull(row.percent[1])},
                    {"km_percent", cli::NumberOrNull(row.percent[2])}});
  }
  return rows;
}

ordered_json CorrelationJson(const DropTestFit& fit) {
  ordered_json rows = ordered_json::array();
  for (const auto& of_one : CorrelationOf(fit)) {
    ordered_json row = ordered_json::array();
    for (const auto& coefficient : of_one) row.push_back(cli::NumberOrNull(coefficient));
    rows.push_back(std::move(row));
  }
  return rows;
}

// standard uncertainties and correlation of decay rate and damped frequency
ordered_json PoleJson(const fit::UncertainPole& pole) {
  const auto& covariance = pole.covariance;
  const auto known = [&pole](double value) {
    return pole.determined ? cli::NumberOrNull(value) : ordered_json(nullptr);
  };
  return {
      {"frequency_hz", known(pole.frequency_hz)},
      {"frequency_standard_uncertainty_hz", known(std::sqrt(covariance[0][0]))},
      {"decay_per_s", known(pole.decay_per_s)},
      {"decay_standard_uncertainty_per_s", known(std::sqrt(covariance[1][1]))},
      {"correlation", known(covariance[0][1] / std::sqrt(covariance[0][0] * covariance[1][1]))}};
}

ordered_json StartJson(const fit::PolePair& start) {
  const double square = start.stiffness_per_s2 - start.decay_per_s * start.decay_per_s;
  return {
      {"frequency_hz", PositiveOrNull(square > 0 ? std::sqrt(square) / (2 * std::numbers::pi) : 0)},
      {"decay_per_s", cli::NumberOrNull(start.decay_per_s)}};
}

// under `key` with its unit's ending; null under the other unit's
void AddSignal(const std::string& key, const ordered_json& value, fit::RecordedSignal signal,
               ordered_json& json) {
  const bool is_voltage = signal == fit::RecordedSignal::kVoltage;
  json[key + "_v"] = is_voltage ? value : ordered_json(nullptr);
  json[key + "_m"] = is_voltage ? ordered_json(nullptr) : value;
}

ordered_json RecordJson(const fit::FittedRecord& record) {
  const bool open = std::isinf(record.load_ohm);
  const bool is_voltage = record.signal == fit::RecordedSignal::kVoltage;
  ordered_json json{{"file", record.name},
                    {"signal", is_voltage ? "voltage" : "displacement"},
                    {"open_circuit", open},
                    {"load_ohm", cli::NumberOrNull(record.load_ohm)},
                    {"impact_s", record.impact_s},
                    {"impact_speed_m_per_s", record.speed_determined
                                                 ? cli::NumberOrNull(record.impact_speed_m_per_s)
                                                 : ordered_json(nullptr)},
                    {"decay_per_s", record.decay_per_s},
                    {"damped_frequency_hz", PositiveOrNull(record.damped_frequency_hz)},
                    {"pole", PoleJson(record.pole)},
                    {"start", StartJson(record.start)},
                    {"first_sample", record.first_sample},
                    {"samples", record.samples},
                    {"residual_density_ratio", record.density.ratio},
                    {"residual_is_coloured", record.density.is_coloured},
                    {"disturbances", record.found}};
  AddSignal("offset", record.offset_v, record.signal, json);
  AddSignal("peak", record.peak_v, record.signal, json);
  AddSignal("residual_rms", record.residual_rms_v, record.signal, json);
  AddSignal("quiet_noise_rms", PositiveOrNull(record.quiet_noise_v), record.signal, json);
  return json;
}

ordered_json InfluenceJson(const fit::InputInfluence& influence) {
  return {{"input", influence.input},
          {"value", cli::NumberOrNull(influence.value)},
          {"standard_uncertainty", influence.standard_uncertainty},
          {"relative_standard_uncertainty", influence.relative_standard_uncertainty},
          {"unit", influence.unit},
          {"kv_percent_per_percent", influence.percent_per_percent[0]},
          {"bv_percent_per_percent", influence.percent_per_percent[1]},
          {"km_percent_per_percent", influence.percent_per_percent[2]}};
}

}  // namespace

fit::DropTestFit NothingDetermined() {
  DropTestFit fit;
  fit.stiffness.unit = "N/m";
  fit.damping.unit = "N s/m";
  fit.force_constant.unit = "N/A";
  fit.moving_mass.unit = "kg";
  fit.stiffness_over_mass.unit = "1/s^2";
  fit.damping_over_mass.unit = "1/s";
  fit.natural_frequency.unit = "Hz";
  fit.mass_symbol = "Mv";
  return fit;
}

std::string FitLraJson(const DropTestFit& fit, const std::vector<std::string>& doubts,
                       const std::vector<std::string>& remarks,
                       const std::vector<Error>& left_out) {
  ordered_json document;
  document["parameters"] = {{"Kv", FittedJson(fit.stiffness)},
                            {"Bv", FittedJson(fit.damping)},
                            {"Km", FittedJson(fit.force_constant)}};
  document["moving_mass_kg"] =
      fit.moving_mass.determined ? FittedJson(fit.moving_mass) : ordered_json(nullptr);
  document["relative_covariance_kv_bv_km"] = fit.relative_covariance;
  document["correlation_kv_bv_km"] = CorrelationJson(fit);
  document["coverage_factor"] = fit::kCoverage95;
  document["budget"] = BudgetJson(fit);
  document["frequency_birge_ratio"] = fit.frequency_birge_ratio;
  document["decay_birge_ratio"] = fit.decay_birge_ratio;
  AddPlain(document, "kv_over_mass", fit.stiffness_over_mass);
  AddPlain(document, "bv_over_mass", fit.damping_over_mass);
  document["mass"] = fit.mass_symbol;
  AddPlain(document, "natural_frequency_hz", fit.natural_frequency);
  AddPlain(document, "quality_factor", fit.quality_factor);
  document["moving_mass_kg"] = FittedJson(fit.moving_mass);
  document["derived"] = {{"kv_over_mass", FittedJson(fit.stiffness_over_mass)},
                         {"bv_over_mass", FittedJson(fit.damping_over_mass)},
                         {"natural_frequency", FittedJson(fit.natural_frequency)},
                         {"quality_factor", FittedJson(fit.quality_factor)}};
  document["converged"] = fit.converged;
  document["termination"] = fit.termination;
  document["iterations"] = fit.iterations;
  document["chi_square_per_degree"] = PositiveOrNull(fit.chi_square_per_degree);
  document["records"] = ordered_json::array();
  for (const auto& record : fit.records) document["records"].push_back(RecordJson(record));
  document["inputs"] = ordered_json::array();
  for (const auto& input : fit.influences) document["inputs"].push_back(InfluenceJson(input));
  document["assumptions"] = fit.assumptions;
  auto undetermined = fit.undetermined;
  // where no record could be fitted, what is wrong with them is why
  if (fit.records.empty()) {
    for (const auto& error : left_out) undetermined.push_back(error.Text());
  }
  document["not_determined"] = undetermined;
  document["doubts"] = doubts;
  document["remarks"] = remarks;
  document["left_out"] = ordered_json::array();
  for (const auto& error : left_out) document["left_out"].push_back(error.Text());
  return cli::JsonText(document);
}

}  // namespace haptometer::tools
