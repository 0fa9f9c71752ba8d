#include "tools/fit/actuator_options.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <string_view>

#include "sim/scene/actuator.h"

namespace haptometer::tools {

using fit::ActuatorKnowns;

void DeclareCoilAndMass(cli::Options& options, ActuatorWords& words) {
  ActuatorKnowns& knowns = words.knowns;
  options.Number("--moving-mass", &knowns.moving_mass_kg, Dimension::kMass, "Moving mass Mv");
  options.Number("--resistance", &knowns.resistance_ohm, Dimension::kResistance,
                 "Resistance R of the coil");
  options.Number("--inductance", &knowns.inductance_h, Dimension::kInductance,
                 "Inductance L of the coil");
  options.Text("--actuator", &words.file, "NAME|FILE",
               "Actuator file, or thesis-c10-100, from which masses, R and L are read");
}

void DeclareCase(cli::Options& options, ActuatorWords& words) {
  options.Flag("--held", &words.held, "The case was fixed to a heavy mass");
  options.Flag("--free", &words.is_free, "The case was free");
  options.Number("--case-mass", &words.knowns.case_mass_kg, Dimension::kMass, "Case mass Mc");
  options.Repeated("--require", &words.required, "Kv|Bv|Km",
                   "Status 3 where this constant is not determined; may be repeated");
}

Result<void> Check(const ActuatorWords& words) {
  if (words.held && words.is_free) return Usage("--held", "excludes --free", "give one of them");
  struct Row {
    std::string_view option;
    const std::optional<Quantity>& value;
    std::string_view example;
  };
  const ActuatorKnowns& knowns = words.knowns;
  const std::array rows{Row{"--moving-mass", knowns.moving_mass_kg, "1.4g"},
                        Row{"--case-mass", knowns.case_mass_kg, "0.6g"},
                        Row{"--resistance", knowns.resistance_ohm, "27ohm"}};
  for (const Row& row : rows) {
    if (!row.value || (row.value->value > 0 && std::isfinite(row.value->value))) continue;
    return Usage(std::string(row.option), "must be positive",
                 fmt::format("write it like {}", row.example));
  }
  if (knowns.inductance_h && knowns.inductance_h->value < 0) {
    return Usage("--inductance", "must not be negative", "write it like 130uH");
  }
  for (const std::string& name : words.required) {
    if (name == "Kv" || name == "Bv" || name == "Km") continue;
    return Usage("--require", fmt::format("{} is none of Kv, Bv, Km", name), "write --require Km");
  }
  return {};
}

Result<ActuatorKnowns> KnownsOfFile(const ActuatorWords& words) {
  if (words.file.empty()) return ActuatorKnowns{};
  const auto actuator = sim::FindActuator(words.file);
  if (!actuator) return std::unexpected(actuator.error());
  return ActuatorKnowns{actuator->moving_mass_kg, actuator->case_mass_kg, actuator->resistance_ohm,
                        actuator->inductance_h};
}

Result<ActuatorKnowns> KnownsOf(const ActuatorWords& words) {
  auto knowns = KnownsOfFile(words);
  if (!knowns) return knowns;
  for (const auto member : {&ActuatorKnowns::moving_mass_kg, &ActuatorKnowns::case_mass_kg,
                            &ActuatorKnowns::resistance_ohm, &ActuatorKnowns::inductance_h}) {
    if (words.knowns.*member) (*knowns).*member = words.knowns.*member;
  }
  return knowns;
}

}  // namespace haptometer::tools
