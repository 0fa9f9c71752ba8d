#include "tools/fitted_value_output.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/cli/json.h"

namespace haptometer::tools {
namespace {

// decimals such that the uncertainty shows two digits
int Decimals(double uncertainty) {
  if (!(uncertainty > 0)) return 6;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(uncertainty))), 0, 12);
}

}  // namespace

std::string FittedLine(std::string_view name, const fit::FittedValue& value) {
  if (!value.determined) {
    const std::string limit =
        value.at_most ? fmt::format(", at most {:.3g} {} (95 %)", *value.at_most, value.unit) : "";
    return fmt::format("  {:<6} not determined{}\n", name, limit);
  }
  const double expanded = value.upper - value.value;
  const int decimals = Decimals(expanded);
  return fmt::format(
      "  {:<6} {:>14.{}f} +- {:.{}f} {}{}(standard uncertainty {:.2g}, of which"
      " statistical {:.2g})\n",
      name, value.value, decimals, expanded, decimals, value.unit, value.unit.empty() ? "" : "  ",
      value.combined_standard_uncertainty, value.standard_uncertainty);
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
