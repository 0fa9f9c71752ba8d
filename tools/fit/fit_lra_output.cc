#include "tools/fit/fit_lra_output.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "tools/fit/fit_lra_budget.h"
#include "tools/fit/fitted_value_output.h"

namespace haptometer::tools {
namespace {

using fit::DropTestFit;

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

}  // namespace haptometer::tools
