#include "tools/fit/fit_lra_save.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace haptometer::tools {
namespace {

using fit::DropTestFit;
using fit::FittedValue;

// a given number: its key, unit, symbol and what the fit calls it
struct Given {
  std::string_view key;
  std::string_view unit;
  std::string_view symbol;
  std::string_view input;
  std::string_view option;
  std::optional<Quantity> fit::ActuatorKnowns::* member;
};

constexpr std::array<Given, 4> kGiven{{
    {"moving_mass_kg", "kg", "Mv", "moving mass", "--moving-mass",
     &fit::ActuatorKnowns::moving_mass_kg},
    {"case_mass_kg", "kg", "Mc", "case mass", "--case-mass", &fit::ActuatorKnowns::case_mass_kg},
    {"resistance_ohm", "ohm", "R", "coil resistance", "--resistance",
     &fit::ActuatorKnowns::resistance_ohm},
    {"inductance_h", "H", "L", "coil inductance", "--inductance",
     &fit::ActuatorKnowns::inductance_h},
}};

// a constant of the fit, by its place in relative_covariance
struct Constant {
  std::string_view key;
  std::string_view symbol;
  const FittedValue* value;
};

std::array<Constant, 3> ConstantsOf(const DropTestFit& fit) {
  return {{{"stiffness_n_per_m", "Kv", &fit.stiffness},
           {"damping_n_s_per_m", "Bv", &fit.damping},
           {"force_constant_n_per_a", "Km", &fit.force_constant}}};
}

std::string Line(std::string_view key, double value, double uncertainty, std::string_view unit) {
  if (!(uncertainty > 0)) return fmt::format("{} = \"{:.12g} {}\"\n", key, value, unit);
  return fmt::format("{} = \"{:.12g} {} +- {:.4g} {}\"\n", key, value, unit, uncertainty, unit);
}

// the correlation coefficient from a covariance of logarithms, and a line of it where there is one
std::string Correlation(std::string_view first, std::string_view second, double covariance,
                        double first_square, double second_square) {
  const double product = first_square * second_square;
  const double coefficient = product > 0 ? covariance / std::sqrt(product) : 0;
  if (std::abs(coefficient) < 1e-9) return {};
  return fmt::format("{}_{} = {:.9f}\n", first, second, std::clamp(coefficient, -1.0, 1.0));
}

// of a given number with each constant: cov = (d ln constant / d ln given) u(ln given)^2. Pairs are
// named in the order of sim::kActuatorSymbols: masses, constants, coil
std::string CorrelationsWith(const Given& given, const DropTestFit& fit) {
  const auto input = std::ranges::find(fit.influences, given.input, &fit::InputInfluence::input);
  if (input == fit.influences.end()) return {};
  const double square = std::pow(input->relative_standard_uncertainty, 2);
  const auto constants = ConstantsOf(fit);
  std::string lines;
  for (std::size_t k = 0; k < constants.size(); ++k) {
    const bool is_mass = given.unit == "kg";
    lines += Correlation(
        is_mass ? given.symbol : constants[k].symbol, is_mass ? constants[k].symbol : given.symbol,
        input->percent_per_percent[k] * square, square, fit.relative_covariance[k][k]);
  }
  return lines;
}

}  // namespace

Result<std::string> ActuatorText(const DropTestFit& fit, const fit::ActuatorKnowns& knowns) {
  std::string text = "# written by haptometer fit-lra; value +- standard uncertainty\n";
  for (const Given& given : kGiven) {
    const auto& quantity = knowns.*given.member;
    if (!quantity) {
      return Usage("--save", fmt::format("a scene needs {} too", given.key),
                   fmt::format("state it with {}", given.option));
    }
    text += Line(given.key, quantity->value, quantity->standard_uncertainty, given.unit);
  }
  const auto constants = ConstantsOf(fit);
  for (const Constant& constant : constants) {
    const FittedValue& value = *constant.value;
    if (!value.determined) continue;
    text += Line(constant.key, value.value, value.combined_standard_uncertainty, value.unit);
  }
  std::string correlations;
  for (const Given& given : kGiven) correlations += CorrelationsWith(given, fit);
  const auto& covariance = fit.relative_covariance;
  for (std::size_t i = 0; i < constants.size(); ++i) {
    for (std::size_t j = i + 1; j < constants.size(); ++j) {
      correlations += Correlation(constants[i].symbol, constants[j].symbol, covariance[i][j],
                                  covariance[i][i], covariance[j][j]);
    }
  }
  return correlations.empty() ? text : text + "\n[correlation]\n" + correlations;
}

}  // namespace haptometer::tools
