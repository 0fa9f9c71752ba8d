#include "tools/fit/fit_lra_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "base/clock.h"
#include "tools/cli/json.h"

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

namespace {

std::string CorrelationLine(const DropTestFit& fit) {
  const auto correlation = CorrelationOf(fit);
  const auto constants = ConstantsOf(fit);
  std::string pairs;
  for (std::size_t i = 0; i < constants.size(); ++i) {
    for (std::size_t j = i + 1; j < constants.size(); ++j) {
      if (!correlation[i][j]) continue;
      pairs += fmt::format("{}{} with {} {:+.2f}", pairs.empty() ? "" : ", ", constants[i].first,
                           constants[j].first, *correlation[i][j]);
    }
  }
  return pairs.empty() ? pairs : fmt::format("  correlation of {}\n", pairs);
}

std::string BudgetLines(const DropTestFit& fit) {
  const std::vector<BudgetRow> rows = BudgetOf(fit);
  if (rows.empty()) return {};
  std::string lines =
      fmt::format("  {:<34}{:>4}{:>10}{:>10}{:>10}\n", "", "type", "Kv", "Bv", "Km");
  for (const BudgetRow& row : rows) {
    lines += fmt::format("  {:<34}{:>4}{:>10}{:>10}{:>10}\n", row.cause, row.type,
                         PercentText(row.percent[0]), PercentText(row.percent[1]),
                         PercentText(row.percent[2]));
  }
  return lines + CorrelationLine(fit);
}

// what 1 % of a given number does to the constants
std::string Effects(const fit::InputInfluence& influence, const DropTestFit& fit) {
  constexpr double kLeastPercent = 5e-4;
  std::string effects;
  const auto constants = ConstantsOf(fit);
  for (std::size_t k = 0; k < constants.size(); ++k) {
    const double percent = influence.percent_per_percent[k];
    if (!constants[k].second->determined || std::abs(percent) < kLeastPercent) continue;
    effects +=
        fmt::format("{}{} {:+.3f} %", effects.empty() ? "" : ", ", constants[k].first, percent);
  }
  return effects;
}

// each record's lines under its name
std::string RecordsText(const DropTestFit& fit) {
  std::string text;
  for (const fit::FittedRecord& record : fit.records) {
    const std::vector<std::string> lines = RecordLines(record);
    text += fmt::format("  {}: {}\n", record.name, lines.front());
    for (std::size_t k = 1; k < lines.size(); ++k) text += fmt::format("    {}\n", lines[k]);
  }
  return text;
}

std::string Section(std::string_view title, const std::string& lines) {
  return lines.empty() ? std::string() : fmt::format("{}\n{}", title, lines);
}

}  // namespace

std::string LoadText(double load_ohm) {
  return std::isinf(load_ohm) ? "open" : fmt::format("{:g} ohm", load_ohm);
}

std::string AmountText(fit::RecordedSignal signal, double value) {
  return signal == fit::RecordedSignal::kVoltage ? fmt::format("{:.3g} mV", value * 1e3)
                                                 : fmt::format("{:.3g} um", value * 1e6);
}

std::vector<std::string> RecordLines(const fit::FittedRecord& record) {
  std::string ringing =
      fmt::format("{}, {:.3f} Hz, decay {:.4f} 1/s, impact at {:.3f} ms", LoadText(record.load_ohm),
                  record.damped_frequency_hz, record.decay_per_s, record.impact_s * 1e3);
  if (record.speed_determined) {
    ringing += fmt::format(" with {:.4f} m/s", record.impact_speed_m_per_s);
  }
  std::string residual = fmt::format("residual {} RMS over {} samples ({:.2g} % of the peak)",
                                     AmountText(record.signal, record.residual_rms_v),
                                     record.samples, 100 * record.residual_rms_v / record.peak_v);
  if (record.quiet_noise_v > 0) {
    residual += fmt::format(", noise before the impact {}",
                            AmountText(record.signal, record.quiet_noise_v));
  }
  std::vector<std::string> lines{std::move(ringing), std::move(residual)};
  if (record.density.is_coloured) {
    lines.push_back(
        fmt::format("the residual is {:.3g} times as dense at the resonance as on average",
                    record.density.ratio));
  }
  lines.insert(lines.end(), record.found.begin(), record.found.end());
  return lines;
}

std::vector<GivenLine> GivenLines(const DropTestFit& fit) {
  std::vector<GivenLine> lines;
  for (const fit::InputInfluence& influence : fit.influences) {
    const std::string effects = Effects(influence, fit);
    if (effects.empty()) continue;
    const std::string exactness =
        influence.standard_uncertainty > 0
            ? "standard uncertainty " + InSpokenUnit(influence.standard_uncertainty, influence.unit)
            : "taken as exact";
    const std::string of = influence.input.starts_with("rebound") ? "1 + e" : "it";
    lines.push_back(
        {fmt::format("{} {}", influence.input, InSpokenUnit(influence.value, influence.unit)),
         fmt::format("{}; +1 % of {}: {}", exactness, of, effects)});
  }
  return lines;
}

std::vector<NamedValue> ValuesOf(const DropTestFit& fit) {
  const bool reduced = fit.mass_symbol != "Mv";
  std::vector<NamedValue> values{{"Kv", fit.stiffness},
                                 {"Bv", fit.damping},
                                 {"Km", fit.force_constant},
                                 {"f0", fit.natural_frequency},
                                 {"Q", fit.quality_factor},
                                 {reduced ? "Kv/M" : "Kv/Mv", fit.stiffness_over_mass},
                                 {reduced ? "Bv/M" : "Bv/Mv", fit.damping_over_mass}};
  if (fit.moving_mass.determined) values.push_back({"Mv", InGrams(fit.moving_mass)});
  return values;
}

std::string FitLraText(const DropTestFit& fit, const std::vector<std::string>& doubts) {
  std::string text = fmt::format(
      "Result (95 % interval: {} standard uncertainties where it is even)\n", fit::kCoverage95);
  for (const auto& [name, value] : ValuesOf(fit)) text += FittedLine(name, value);
  if (fit.mass_symbol != "Mv") text += fmt::format("  M is the reduced mass {}\n", fit.mass_symbol);
  text += Section("Standard uncertainty in %", BudgetLines(fit));
  text += SentenceSection("Not determined", fit.undetermined);
  text += SentenceSection("Doubtful", doubts);

  text += Section("Records", RecordsText(fit));
  std::string given;
  for (const auto& [what, line] : GivenLines(fit)) given += fmt::format("  {}, {}\n", what, line);
  text += Section("Given", given);
  text += SentenceSection("Assumed", fit.assumptions);
  text += fmt::format("{} after {} iterations\n", fit.converged ? "Converged" : "Not converged",
                      fit.iterations);
  return text;
}

namespace {

using report::HtmlPage;
using Rows = std::vector<std::vector<std::string>>;

// one record by its name, several by their number
std::string Title(const DropTestFit& fit) {
  return fit.records.size() == 1
             ? fmt::format("Constants of an actuator from {}", fit.records[0].name)
             : fmt::format("Constants of an actuator from {} drops", fit.records.size());
}

void AddConstants(const DropTestFit& fit, HtmlPage& page) {
  Rows rows;
  for (const auto& [name, value] : ValuesOf(fit)) {
    auto [number, interval] = CellsOf(value);
    rows.push_back({std::string(name), std::move(number), std::move(interval), value.unit});
  }
  page.Section("Constants");
  page.Table({"", "value", "95 % interval", "unit"}, rows);
  page.Paragraph(fmt::format(
      "{} standard uncertainties where the interval is even; noise and given numbers together.{}",
      fit::kCoverage95,
      fit.mass_symbol == "Mv" ? "" : fmt::format(" M is the reduced mass {}.", fit.mass_symbol)));
}

void AddBudget(const DropTestFit& fit, HtmlPage& page) {
  Rows rows;
  for (const BudgetRow& row : BudgetOf(fit)) {
    rows.push_back({row.cause, std::string(row.type), PercentText(row.percent[0]),
                    PercentText(row.percent[1]), PercentText(row.percent[2])});
  }
  if (rows.empty()) return;
  page.Section("Uncertainty budget");
  page.Paragraph(
      "Standard uncertainties in percent; type A: from the records' own noise, type B: from "
      "numbers "
      "that were given (JCGM 100:2008).");
  page.Table({"cause", "type", "Kv", "Bv", "Km"}, rows);
}

void AddCorrelation(const DropTestFit& fit, HtmlPage& page) {
  const auto correlation = CorrelationOf(fit);
  const auto constants = ConstantsOf(fit);
  Rows rows;
  for (std::size_t i = 0; i < constants.size(); ++i) {
    std::vector<std::string> row{std::string(constants[i].first)};
    for (const auto& coefficient : correlation[i]) {
      row.push_back(coefficient ? fmt::format("{:+.4f}", *coefficient) : "-");
    }
    rows.push_back(std::move(row));
  }
  page.Subsection("Correlation, all causes together");
  page.Table({"", "Kv", "Bv", "Km"}, rows);
}

void AddRecords(const DropTestFit& fit, HtmlPage& page) {
  page.Section("Records");
  for (const fit::FittedRecord& record : fit.records) {
    page.Subsection(record.name);
    page.List(RecordLines(record));
  }
}

void AddGiven(const DropTestFit& fit, HtmlPage& page) {
  Rows rows;
  for (auto& [what, text] : GivenLines(fit)) rows.push_back({what, text});
  if (rows.empty()) return;
  page.Section("Given, and what it does");
  page.Table({}, rows);
}

void AddSentences(const std::string& heading, const std::vector<std::string>& sentences,
                  HtmlPage& page) {
  if (sentences.empty()) return;
  page.Section(heading);
  page.List(sentences);
}

void AddSettings(const DropTestFit& fit, HtmlPage& page) {
  const std::string chi = fit.chi_square_per_degree > 0
                              ? fmt::format("{:.3g}", fit.chi_square_per_degree)
                              : "not known: nothing was recorded before an impact";
  page.Section("Settings and search");
  page.Table(
      {}, {{"model", "drop test with the coil's circuit, all records together"},
           {"search",
            fmt::format("{} after {} iterations: {}", fit.converged ? "converged" : "not converged",
                        fit.iterations, fit.termination)},
           {"chi^2 a degree", chi},
           {"scatter of drops", fmt::format("Birge ratio {:.3g} of frequencies, {:.3g} of decays",
                                            fit.frequency_birge_ratio, fit.decay_birge_ratio)},
           {"coverage", fmt::format("95 %, factor {}", fit::kCoverage95)}});
}

}  // namespace

Result<HtmlPage> FitLraReport(const ReportedFit& reported) {
  const DropTestFit& fit = reported.fit;
  HtmlPage page(Title(fit), fmt::format("haptometer {}, {}: {}", HAPTOMETER_VERSION, UtcNow(),
                                        reported.command));
  for (const Error& error : reported.left_out) page.Warning("left out: " + error.Text());
  for (const auto& sentence : fit.undetermined) page.Warning("not determined: " + sentence);
  for (const auto& sentence : reported.doubts) page.Warning("doubtful: " + sentence);
  AddConstants(fit, page);
  AddBudget(fit, page);
  AddCorrelation(fit, page);
  page.Section("Figures");
  for (const FitFigure& figure : reported.figures) {
    if (auto drawn = page.Figure(figure.caption, figure.panels); !drawn) {
      return std::unexpected(drawn.error());
    }
  }
  AddRecords(fit, page);
  AddGiven(fit, page);
  AddSentences("Assumed", fit.assumptions, page);
  AddSentences("Remarks", reported.remarks, page);
  AddSettings(fit, page);
  return page;
}

namespace {

constexpr double kLeastPercent = 1e-6;

// a row whose shares are those of `percent_of`, in percent of each determined constant
template <typename F>
void AddRow(const DropTestFit& fit, std::string cause, std::string_view type, const F& percent_of,
            std::vector<BudgetRow>& rows) {
  BudgetRow row{std::move(cause), type, {}};
  bool says_something = false;
  for (std::size_t k = 0; k < row.percent.size(); ++k) {
    const FittedValue& value = *ConstantsOf(fit)[k].second;
    if (!value.determined) continue;
    row.percent[k] = percent_of(k, value);
    says_something = says_something || *row.percent[k] > kLeastPercent;
  }
  if (says_something) rows.push_back(std::move(row));
}

// the last influence on what is seen of what stays unseen
double UnseenPercent(const DropTestFit& fit, std::size_t k, const FittedValue& value) {
  const double whole = std::pow(value.combined_standard_uncertainty / value.value, 2);
  double square = whole - std::pow(value.standard_uncertainty / value.value, 2);
  for (const fit::InputInfluence& influence : fit.influences) {
    square -=
        std::pow(influence.relative_standard_uncertainty * influence.percent_per_percent[k], 2);
  }
  constexpr double kRounding = 1e-9;
  return square > kRounding * whole ? 100 * std::sqrt(square) : 0;
}

}  // namespace

std::array<std::pair<std::string_view, const FittedValue*>, 3> ConstantsOf(const DropTestFit& fit) {
  return {{{"Kv", &fit.stiffness}, {"Bv", &fit.damping}, {"Km", &fit.force_constant}}};
}

std::vector<BudgetRow> BudgetOf(const DropTestFit& fit) {
  std::vector<BudgetRow> rows;
  AddRow(
      fit, "noise of the records", "A",
      [](std::size_t, const FittedValue& value) {
        return 100 * value.standard_uncertainty / value.value;
      },
      rows);
  for (const fit::InputInfluence& influence : fit.influences) {
    if (influence.standard_uncertainty == 0) continue;
    AddRow(
        fit,
        fmt::format("{} {} +- {}", influence.input, InSpokenUnit(influence.value, influence.unit),
                    InSpokenUnit(influence.standard_uncertainty, influence.unit)),
        "B",
        [&influence](std::size_t k, const FittedValue&) {
          return 100 * influence.relative_standard_uncertainty *
                 std::abs(influence.percent_per_percent[k]);
        },
        rows);
  }
  AddRow(
      fit, "what is not determined", "B",
      [&fit](std::size_t k, const FittedValue& value) { return UnseenPercent(fit, k, value); },
      rows);
  AddRow(
      fit, "combined", "",
      [](std::size_t, const FittedValue& value) {
        return 100 * value.combined_standard_uncertainty / value.value;
      },
      rows);
  return rows;
}

std::array<std::array<std::optional<double>, 3>, 3> CorrelationOf(const DropTestFit& fit) {
  std::array<std::array<std::optional<double>, 3>, 3> correlation;
  const auto& covariance = fit.relative_covariance;
  for (std::size_t i = 0; i < correlation.size(); ++i) {
    for (std::size_t j = 0; j < correlation.size(); ++j) {
      const double product = covariance[i][i] * covariance[j][j];
      if (!(product > 0)) continue;
      correlation[i][j] = std::clamp(covariance[i][j] / std::sqrt(product), -1.0, 1.0);
    }
  }
  return correlation;
}

std::string PercentText(const std::optional<double>& percent) {
  return percent && *percent > kLeastPercent ? fmt::format("{:.2g}", *percent) : "-";
}

std::string InSpokenUnit(double value, const std::string& unit) {
  if (unit == "kg") return fmt::format("{:g} g", value * 1e3);
  if (unit == "m") return fmt::format("{:g} mm", value * 1e3);
  if (unit == "H") return fmt::format("{:g} uH", value * 1e6);
  return fmt::format("{:g}{}{}", value, unit.empty() ? "" : " ", unit);
}

namespace {

// beyond this share an interval's halves differ enough to be told apart
constexpr double kLopsided = 0.1;

// A number to `decimals`, or to a digit's place before the point, as an uncertainty of two digits
// wants it; at most 6 digits where that leaves fewer than the whole part has.
std::string Rounded(double value, double uncertainty, int decimals) {
  constexpr int kMostWhole = 6;
  if (std::abs(value) < 1e6 || std::abs(uncertainty) < 100) {
    if (std::abs(value) < 1e15) return fmt::format("{:.{}f}", value, decimals);
  }
  const double places = std::floor(std::log10(std::abs(value) / uncertainty));
  const int digits = std::clamp(static_cast<int>(places) + 2, 2, kMostWhole);
  return fmt::format("{:.{}g}", value, digits);
}

// decimals such that the uncertainty shows two digits
int Decimals(double uncertainty) {
  if (!(uncertainty > 0)) return 6;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(uncertainty))), 0, 12);
}

}  // namespace

fit::FittedValue InGrams(fit::FittedValue kilograms) {
  for (double* number :
       {&kilograms.value, &kilograms.standard_uncertainty, &kilograms.combined_standard_uncertainty,
        &kilograms.lower, &kilograms.upper}) {
    *number *= 1e3;
  }
  if (kilograms.at_most) *kilograms.at_most *= 1e3;
  kilograms.unit = "g";
  return kilograms;
}

FittedCells CellsOf(const fit::FittedValue& value) {
  if (!value.determined) {
    return {"not determined", value.at_most
                                  ? fmt::format("at most {:.2g} {} (95 % interval from 0)",
                                                *value.at_most, value.unit)
                                  : ""};
  }
  const double half = (value.upper - value.lower) / 2;
  const int decimals = Decimals(half);
  const bool is_lopsided =
      std::abs(value.upper + value.lower - 2 * value.value) > 2 * kLopsided * half;
  const double spread = fit::kCoverage95 * value.combined_standard_uncertainty;
  const auto rounded = [&](double number) { return Rounded(number, half, decimals); };
  const std::string interval =
      half >= 1e6 ? fmt::format("+- {:.2g}", spread) : fmt::format("+- {:.{}f}", spread, decimals);
  return {
      rounded(value.value),
      is_lopsided ? fmt::format("{} to {}", rounded(value.lower), rounded(value.upper)) : interval};
}

std::string FittedLine(std::string_view name, const fit::FittedValue& value) {
  const auto [number, interval] = CellsOf(value);
  if (!value.determined) {
    return value.at_most ? fmt::format("  {:<6} {}; {}\n", name, interval, number)
                         : fmt::format("  {:<6} {}\n", name, number);
  }
  return fmt::format("  {:<6} {:>14}{} {}{}{}\n", name, number,
                     interval.starts_with('+') ? "" : ",", interval, value.unit.empty() ? "" : " ",
                     value.unit);
}

nlohmann::ordered_json FittedJson(const fit::FittedValue& value) {
  const auto field = [&value](double number) {
    return value.determined ? cli::NumberOrNull(number) : nlohmann::ordered_json(nullptr);
  };
  return {{"value", field(value.value)},
          {"standard_uncertainty", field(value.standard_uncertainty)},
          {"combined_standard_uncertainty", field(value.combined_standard_uncertainty)},
          {"lower_95", field(value.lower)},
          {"upper_95", field(value.upper)},
          {"at_most_95",
           value.determined ? nlohmann::ordered_json(nullptr) : cli::NumberOrNull(value.at_most)},
          {"unit", value.unit},
          {"determined", value.determined}};
}

std::string SentenceSection(std::string_view title, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return {};
  std::string text = fmt::format("{}\n", title);
  for (const auto& sentence : sentences) text += fmt::format("  {}\n", sentence);
  return text;
}

}  // namespace haptometer::tools
