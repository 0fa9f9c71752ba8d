#include "tools/fit/fitted_value_output.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/cli/json.h"

namespace haptometer::tools {
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
