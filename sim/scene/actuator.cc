#include "sim/scene/actuator.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "base/toml.h"

namespace haptometer::sim {
namespace {

constexpr std::string_view kThesisC10100 = "thesis-c10-100";

// one of the three constants that a file may omit
std::optional<Quantity> Optional(TomlTable& table, std::string_view key, Dimension dimension) {
  if (!table.Has(key)) return std::nullopt;
  return table.RequireQuantity(key, dimension);
}

void RefuseUnlessPositive(TomlTable& table, std::string_view key,
                          const std::optional<Quantity>& quantity) {
  if (quantity && !(quantity->value > 0))
    table.Refuse(key, "must be greater than 0", "check its sign");
}

// key of a correlation in the file: both symbols, joined by _
std::string PairOf(std::size_t first, std::size_t second) {
  return fmt::format("{}_{}", kActuatorSymbols[first], kActuatorSymbols[second]);
}

void ReadCorrelations(TomlTable& table, StatedActuator& stated) {
  TomlTable* correlation = table.Table("correlation");
  if (correlation == nullptr) return;
  for (std::size_t i = 0; i < kActuatorSymbols.size(); ++i) {
    for (std::size_t j = i + 1; j < kActuatorSymbols.size(); ++j) {
      const std::string pair = PairOf(i, j);
      const auto value = correlation->Number(pair, Dimension::kNone);
      if (!value) continue;
      if (!(std::abs(*value) <= 1)) correlation->Refuse(pair, "lies from -1 to 1", "check it");
      stated.correlations[pair] = *value;
    }
  }
}

}  // namespace

Actuator Scaled(Actuator actuator, std::size_t place, double factor) {
  actuator.*kActuatorNumbers[place] *= factor;
  return actuator;
}

// relative covariance r_ij u_i u_j, u in units of each value; 0 where no uncertainty is stated
ActuatorCovariance RelativeCovariance(const StatedActuator& stated) {
  const auto relative = [](const std::optional<Quantity>& quantity) {
    const bool varies = quantity && quantity->value != 0;
    return varies ? quantity->standard_uncertainty / quantity->value : 0.0;
  };
  const std::array uncertainties{relative(stated.moving_mass_kg),
                                 relative(stated.case_mass_kg),
                                 relative(stated.stiffness_n_per_m),
                                 relative(stated.damping_n_s_per_m),
                                 relative(stated.force_constant_n_per_a),
                                 relative(stated.resistance_ohm),
                                 relative(stated.inductance_h)};
  ActuatorCovariance covariance{};
  for (std::size_t i = 0; i < uncertainties.size(); ++i) {
    covariance[i][i] = uncertainties[i] * uncertainties[i];
    for (std::size_t j = i + 1; j < uncertainties.size(); ++j) {
      const auto found = stated.correlations.find(PairOf(i, j));
      if (found == stated.correlations.end()) continue;
      covariance[i][j] = covariance[j][i] = found->second * uncertainties[i] * uncertainties[j];
    }
  }
  return covariance;
}

Actuator ThesisC10100() {
  return {.moving_mass_kg = 1.4e-3,
          .case_mass_kg = 0.6e-3,
          .stiffness_n_per_m = 2800,
          .damping_n_s_per_m = 0.0322,
          .force_constant_n_per_a = 1.0,
          .resistance_ohm = 27,
          .inductance_h = 130e-6};
}

StatedActuator ReadActuator(TomlTable& table) {
  StatedActuator stated;
  stated.name = table.where();
  stated.moving_mass_kg = table.RequireQuantity("moving_mass_kg", Dimension::kMass);
  stated.case_mass_kg = table.RequireQuantity("case_mass_kg", Dimension::kMass);
  stated.resistance_ohm = table.RequireQuantity("resistance_ohm", Dimension::kResistance);
  stated.inductance_h = table.RequireQuantity("inductance_h", Dimension::kInductance);
  stated.stiffness_n_per_m = Optional(table, "stiffness_n_per_m", Dimension::kStiffness);
  stated.damping_n_s_per_m = Optional(table, "damping_n_s_per_m", Dimension::kDamping);
  stated.force_constant_n_per_a =
      Optional(table, "force_constant_n_per_a", Dimension::kForceConstant);

  ReadCorrelations(table, stated);

  // the first error of a key is retained: a missing key is not also reported as not positive
  RefuseUnlessPositive(table, "moving_mass_kg", stated.moving_mass_kg);
  RefuseUnlessPositive(table, "case_mass_kg", stated.case_mass_kg);
  RefuseUnlessPositive(table, "resistance_ohm", stated.resistance_ohm);
  RefuseUnlessPositive(table, "stiffness_n_per_m", stated.stiffness_n_per_m);
  RefuseUnlessPositive(table, "force_constant_n_per_a", stated.force_constant_n_per_a);
  if (stated.inductance_h.value < 0) {
    table.Refuse("inductance_h", "must not be negative", "check its sign");
  }
  if (stated.damping_n_s_per_m && stated.damping_n_s_per_m->value < 0) {
    table.Refuse("damping_n_s_per_m", "must not be negative", "check its sign");
  }
  return stated;
}

Result<StatedActuator> FindActuator(const std::string& name_or_path) {
  if (name_or_path == kThesisC10100) {
    const Actuator actuator = ThesisC10100();
    return StatedActuator{.name = name_or_path,
                          .moving_mass_kg = {actuator.moving_mass_kg},
                          .case_mass_kg = {actuator.case_mass_kg},
                          .resistance_ohm = {actuator.resistance_ohm},
                          .inductance_h = {actuator.inductance_h},
                          .stiffness_n_per_m = Quantity{actuator.stiffness_n_per_m},
                          .damping_n_s_per_m = Quantity{actuator.damping_n_s_per_m},
                          .force_constant_n_per_a = Quantity{actuator.force_constant_n_per_a}};
  }
  auto table = TomlTable::ParseFile(name_or_path);
  if (!table) {
    Error error = table.error();
    if (error.what == "no such file") {
      error.remedy = fmt::format("give an actuator file, or the built-in {}", kThesisC10100);
    }
    return std::unexpected(error);
  }
  StatedActuator stated = ReadActuator(*table);
  HAPTOMETER_TRY(table->Finish());
  return stated;
}

Result<Actuator> Complete(const StatedActuator& stated) {
  const auto missing = [&](std::string_view key) {
    return CannotAnswer(stated.name, fmt::format("{} is missing", key),
                        "add it, from a data sheet or by haptometer fit-lra");
  };
  if (!stated.stiffness_n_per_m) return missing("stiffness_n_per_m");
  if (!stated.damping_n_s_per_m) return missing("damping_n_s_per_m");
  if (!stated.force_constant_n_per_a) return missing("force_constant_n_per_a");
  return Actuator{.moving_mass_kg = stated.moving_mass_kg.value,
                  .case_mass_kg = stated.case_mass_kg.value,
                  .stiffness_n_per_m = stated.stiffness_n_per_m->value,
                  .damping_n_s_per_m = stated.damping_n_s_per_m->value,
                  .force_constant_n_per_a = stated.force_constant_n_per_a->value,
                  .resistance_ohm = stated.resistance_ohm.value,
                  .inductance_h = stated.inductance_h.value};
}

}  // namespace haptometer::sim
