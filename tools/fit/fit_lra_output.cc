#include "tools/fit/fit_lra_output.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/cli/json.h"
#include "tools/fit/fitted_value_output.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {
namespace {

using fit::DropTestFit;
using fit::FittedValue;
using nlohmann::ordered_json;

using Constants = std::array<std::pair<const char*, const FittedValue*>, 3>;

Constants ConstantsOf(const DropTestFit& fit) {
  return {{{"Kv", &fit.stiffness}, {"Bv", &fit.damping}, {"Km", &fit.force_constant}}};
}

// a number of the budget, in percent of its constant
std::string Percent(const FittedValue& value, double percent) {
  return value.determined && percent > 1e-6 ? fmt::format("{:>10.2g}", percent)
                                            : fmt::format("{:>10}", "-");
}

std::string BudgetLine(std::string_view name, std::string_view type,
                       const std::array<std::string, 3>& percents) {
  return fmt::format("  {:<34}{:>4}{}{}{}\n", name, type, percents[0], percents[1], percents[2]);
}

std::string CorrelationLine(const DropTestFit& fit) {
  const Constants constants = ConstantsOf(fit);
  const auto& covariance = fit.relative_covariance;
  std::string pairs;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i + 1; j < 3; ++j) {
      const double product = covariance[i][i] * covariance[j][j];
      if (!(product > 0)) continue;
      pairs += fmt::format("{}{} with {} {:+.2f}", pairs.empty() ? "" : ", ", constants[i].first,
                           constants[j].first, covariance[i][j] / std::sqrt(product));
    }
  }
  return pairs.empty() ? pairs : fmt::format("  correlation of {}\n", pairs);
}

std::string LoadText(double load_ohm) {
  return std::isinf(load_ohm) ? "open" : fmt::format("{:g} ohm", load_ohm);
}

std::string RecordLine(const fit::FittedRecord& record) {
  std::string text = fmt::format("  {}: {}, {:.3f} Hz, decay {:.4f} 1/s, impact at {:.3f} ms",
                                 record.name, LoadText(record.load_ohm), record.damped_frequency_hz,
                                 record.decay_per_s, record.impact_s * 1e3);
  if (record.speed_determined) {
    text += fmt::format(" with {:.4f} m/s", record.impact_speed_m_per_s);
  }
  text += fmt::format("\n    residual {:.3g} mV RMS over {} samples ({:.2g} % of the peak)",
                      record.residual_rms_v * 1e3, record.samples,
                      100 * record.residual_rms_v / record.peak_v);
  if (record.quiet_noise_v > 0) {
    text += fmt::format(", noise before the impact {:.3g} mV", record.quiet_noise_v * 1e3);
  }
  text += '\n';
  if (record.density.is_coloured) {
    text +=
        fmt::format("    the residual is {:.3g} times as dense at the resonance as on average\n",
                    record.density.ratio);
  }
  for (const auto& sentence : record.found) text += fmt::format("    {}\n", sentence);
  return text;
}

// in the unit that people say
std::string InSpokenUnit(double value, const std::string& unit) {
  if (unit == "kg") return fmt::format("{:g} g", value * 1e3);
  if (unit == "m") return fmt::format("{:g} mm", value * 1e3);
  if (unit == "H") return fmt::format("{:g} uH", value * 1e6);
  return fmt::format("{:g}{}{}", value, unit.empty() ? "" : " ", unit);
}

std::string InfluenceLine(const fit::InputInfluence& influence, const DropTestFit& fit) {
  std::string effects;
  const Constants constants = ConstantsOf(fit);
  for (std::size_t k = 0; k < 3; ++k) {
    const double percent = influence.percent_per_percent[k];
    if (!constants[k].second->determined || std::abs(percent) < 5e-4) continue;
    effects +=
        fmt::format("{}{} {:+.3f} %", effects.empty() ? "" : ", ", constants[k].first, percent);
  }
  if (effects.empty()) return {};
  const std::string exactness =
      influence.standard_uncertainty > 0
          ? "standard uncertainty " + InSpokenUnit(influence.standard_uncertainty, influence.unit)
          : "taken as exact";
  const std::string of = influence.input.starts_with("rebound") ? "1 + e" : "it";
  return fmt::format("  {} {}, {}; +1 % of {}: {}\n", influence.input,
                     InSpokenUnit(influence.value, influence.unit), exactness, of, effects);
}

// standard uncertainties in percent: what the records' noise makes (type A), what each given number
// makes (type B, JCGM 100:2008), all together
std::string BudgetLines(const DropTestFit& fit) {
  const Constants constants = ConstantsOf(fit);
  const auto row = [&](const std::string& name, std::string_view type, const auto& percent_of) {
    std::array<std::string, 3> percents;
    for (std::size_t k = 0; k < 3; ++k) {
      percents[k] = Percent(*constants[k].second, percent_of(k, *constants[k].second));
    }
    const bool says_nothing = std::ranges::all_of(
        percents, [](const std::string& percent) { return percent.ends_with('-'); });
    return says_nothing ? std::string() : BudgetLine(name, type, percents);
  };
  if (std::ranges::none_of(constants, [](const auto& c) { return c.second->determined; }))
    return {};
  std::string lines =
      fmt::format("  {:<34}{:>4}{:>10}{:>10}{:>10}\n", "", "type", "Kv", "Bv", "Km");
  lines += row("noise of the records", "A", [](std::size_t, const FittedValue& value) {
    return 100 * value.standard_uncertainty / value.value;
  });
  for (const fit::InputInfluence& influence : fit.influences) {
    if (influence.standard_uncertainty == 0) continue;
    const std::string name =
        fmt::format("{} {} +- {}", influence.input, InSpokenUnit(influence.value, influence.unit),
                    InSpokenUnit(influence.standard_uncertainty, influence.unit));
    lines += row(name, "B", [&influence](std::size_t k, const FittedValue&) {
      return 100 * influence.relative_standard_uncertainty *
             std::abs(influence.percent_per_percent[k]);
    });
  }
  // of what stays unseen, the last influence on what is seen
  lines += row("what is not determined", "B", [&](std::size_t k, const FittedValue& value) {
    double square = std::pow(value.combined_standard_uncertainty / value.value, 2) -
                    std::pow(value.standard_uncertainty / value.value, 2);
    for (const fit::InputInfluence& influence : fit.influences) {
      square -=
          std::pow(influence.relative_standard_uncertainty * influence.percent_per_percent[k], 2);
    }
    const double rounding = 1e-9 * std::pow(value.combined_standard_uncertainty / value.value, 2);
    return square > rounding ? 100 * std::sqrt(square) : 0.0;
  });
  lines += row("combined", "", [](std::size_t, const FittedValue& value) {
    return 100 * value.combined_standard_uncertainty / value.value;
  });
  return lines + CorrelationLine(fit);
}

std::string Section(std::string_view title, const std::string& lines) {
  return lines.empty() ? std::string() : fmt::format("{}\n{}", title, lines);
}

// a plain number and its uncertainty beside it
void AddPlain(ordered_json& document, const std::string& key, const FittedValue& value) {
  document[key] = value.determined ? cli::NumberOrNull(value.value) : ordered_json(nullptr);
  document[key + "_standard_uncertainty"] =
      value.determined ? cli::NumberOrNull(value.combined_standard_uncertainty)
                       : ordered_json(nullptr);
}

ordered_json RecordJson(const fit::FittedRecord& record) {
  const bool open = std::isinf(record.load_ohm);
  return {{"file", record.name},
          {"open_circuit", open},
          {"load_ohm", cli::NumberOrNull(record.load_ohm)},
          {"impact_s", record.impact_s},
          {"impact_speed_m_per_s", record.speed_determined
                                       ? cli::NumberOrNull(record.impact_speed_m_per_s)
                                       : ordered_json(nullptr)},
          {"offset_v", record.offset_v},
          {"decay_per_s", record.decay_per_s},
          {"damped_frequency_hz", record.damped_frequency_hz > 0
                                      ? cli::NumberOrNull(record.damped_frequency_hz)
                                      : ordered_json(nullptr)},
          {"residual_rms_v", record.residual_rms_v},
          {"quiet_noise_rms_v", record.quiet_noise_v > 0 ? cli::NumberOrNull(record.quiet_noise_v)
                                                         : ordered_json(nullptr)},
          {"samples", record.samples},
          {"residual_density_ratio", record.density.ratio},
          {"disturbances", record.found}};
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

std::string FitLraText(const DropTestFit& fit, const std::vector<std::string>& doubts) {
  const bool reduced = fit.mass_symbol != "Mv";
  std::string text = fmt::format(
      "Result (95 % interval: {} standard uncertainties where it is even)\n", fit::kCoverage95);
  text += FittedLine("Kv", fit.stiffness) + FittedLine("Bv", fit.damping) +
          FittedLine("Km", fit.force_constant);
  text += FittedLine("f0", fit.natural_frequency) + FittedLine("Q", fit.quality_factor);
  text += FittedLine(reduced ? "Kv/M" : "Kv/Mv", fit.stiffness_over_mass);
  text += FittedLine(reduced ? "Bv/M" : "Bv/Mv", fit.damping_over_mass);
  if (reduced) text += fmt::format("  M is the reduced mass {}\n", fit.mass_symbol);
  text += Section("Standard uncertainty in %", BudgetLines(fit));
  text += SentenceSection("Not determined", fit.undetermined);
  text += SentenceSection("Doubtful", doubts);

  std::string records;
  for (const auto& record : fit.records) records += RecordLine(record);
  text += Section("Records", records);
  std::string influences;
  for (const auto& influence : fit.influences) influences += InfluenceLine(influence, fit);
  text += Section("Given", influences);
  text += SentenceSection("Assumed", fit.assumptions);
  text += fmt::format("{} after {} iterations\n", fit.converged ? "Converged" : "Not converged",
                      fit.iterations);
  return text;
}

std::string FitLraJson(const DropTestFit& fit, const std::vector<std::string>& doubts,
                       const std::vector<std::string>& remarks,
                       const std::vector<Error>& left_out) {
  ordered_json document;
  document["parameters"] = {{"Kv", FittedJson(fit.stiffness)},
                            {"Bv", FittedJson(fit.damping)},
                            {"Km", FittedJson(fit.force_constant)}};
  document["relative_covariance_kv_bv_km"] = fit.relative_covariance;
  document["coverage_factor"] = fit::kCoverage95;
  document["frequency_birge_ratio"] = fit.frequency_birge_ratio;
  document["decay_birge_ratio"] = fit.decay_birge_ratio;
  AddPlain(document, "kv_over_mass", fit.stiffness_over_mass);
  AddPlain(document, "bv_over_mass", fit.damping_over_mass);
  document["mass"] = fit.mass_symbol;
  AddPlain(document, "natural_frequency_hz", fit.natural_frequency);
  AddPlain(document, "quality_factor", fit.quality_factor);
  document["converged"] = fit.converged;
  document["termination"] = fit.termination;
  document["iterations"] = fit.iterations;
  document["chi_square_per_degree"] = fit.chi_square_per_degree > 0
                                          ? cli::NumberOrNull(fit.chi_square_per_degree)
                                          : ordered_json(nullptr);
  document["records"] = ordered_json::array();
  for (const auto& record : fit.records) document["records"].push_back(RecordJson(record));
  document["inputs"] = ordered_json::array();
  for (const auto& input : fit.influences) document["inputs"].push_back(InfluenceJson(input));
  document["assumptions"] = fit.assumptions;
  document["not_determined"] = fit.undetermined;
  document["doubts"] = doubts;
  document["remarks"] = remarks;
  document["left_out"] = ordered_json::array();
  for (const auto& error : left_out) document["left_out"].push_back(error.Text());
  return cli::JsonText(document);
}

Result<void> PlotFitLra(const std::string& path, const DropTestFit& fit,
                        const std::vector<fit::ImpulseRecord>& records) {
  std::vector<plot::Panel> panels;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const auto& record = records[r];
    const auto& fitted = fit.records[r];
    // all samples; the model and the residual from the fit's first sample on
    std::vector<double> times_ms;
    times_ms.reserve(record.voltage_v.size());
    for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
      times_ms.push_back((record.start_s + static_cast<double>(n) * record.step_s) * 1e3);
    }
    std::vector<double> model_v(times_ms.size(), std::nan(""));  // outside of the fitted part
    std::ranges::copy(fitted.model_v,
                      model_v.begin() + static_cast<std::ptrdiff_t>(fitted.first_sample));
    std::vector<double> residual_mv(times_ms.size());
    for (std::size_t n = 0; n < residual_mv.size(); ++n) {
      residual_mv[n] = (record.voltage_v[n] - model_v[n]) * 1e3;
    }
    const std::string title = fmt::format("{} ({})", record.name, LoadText(fitted.load_ohm));
    panels.push_back(
        {.title = title,
         .x_label = "time / ms",
         .y_label = "voltage / V",
         .series = {{.title = "record",
                     .style = fmt::format("points pt 7 ps 0.2 lc rgb '{}'", plot::kGrey),
                     .x = times_ms,
                     .y = record.voltage_v},
                    {.title = "fit",
                     .style = fmt::format("lines lc rgb '{}'", plot::kBlue),
                     .x = times_ms,
                     .y = model_v}}});
    panels.push_back(
        {.title = "",
         .x_label = "time / ms",
         .y_label = "residual / mV",
         .series = {{.title = "",
                     .style = fmt::format("points pt 7 ps 0.2 lc rgb '{}'", plot::kOrange),
                     .x = times_ms,
                     .y = residual_mv}}});
  }
  return plot::DrawPanels(path, panels);
}

}  // namespace haptometer::tools
