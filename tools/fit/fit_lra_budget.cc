#include "tools/fit/fit_lra_budget.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace haptometer::tools {
namespace {

using fit::DropTestFit;
using fit::FittedValue;

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

}  // namespace haptometer::tools
