#include "tools/fit/actuator.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "tools/cli/output_file.h"

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
  // only constants that the fits determine can be required
  for (const std::string& name : words.required) {
    if (name == "Kv" || name == "Bv" || name == "Km") continue;
    return Usage("--require", fmt::format("{} is none of Kv, Bv, Km", name), "write --require Km");
  }
  return {};
}

Result<ActuatorKnowns> KnownsOfFile(const ActuatorWords& words) {
  if (words.file.empty()) return ActuatorKnowns{};
  HAPTOMETER_LET(const auto actuator, sim::FindActuator(words.file));
  return ActuatorKnowns{actuator.moving_mass_kg, actuator.case_mass_kg, actuator.resistance_ohm,
                        actuator.inductance_h};
}

Result<ActuatorKnowns> KnownsOf(const ActuatorWords& words) {
  HAPTOMETER_LET(auto knowns, KnownsOfFile(words));
  // an option replaces the file's value
  for (const auto member : {&ActuatorKnowns::moving_mass_kg, &ActuatorKnowns::case_mass_kg,
                            &ActuatorKnowns::resistance_ohm, &ActuatorKnowns::inductance_h}) {
    if (words.knowns.*member) knowns.*member = words.knowns.*member;
  }
  return knowns;
}

namespace {

using fit::FittedValue;
using sim::StatedActuator;

// one of the numbers that a scene cannot do without
struct Needed {
  std::string_view key;
  std::string_view unit;
  std::string_view option;
  std::optional<Quantity> ActuatorKnowns::* known;
  Quantity StatedActuator::* stated;
};

constexpr std::array<Needed, 4> kNeeded{{
    {"moving_mass_kg", "kg", "--moving-mass", &ActuatorKnowns::moving_mass_kg,
     &StatedActuator::moving_mass_kg},
    {"case_mass_kg", "kg", "--case-mass", &ActuatorKnowns::case_mass_kg,
     &StatedActuator::case_mass_kg},
    {"resistance_ohm", "ohm", "--resistance", &ActuatorKnowns::resistance_ohm,
     &StatedActuator::resistance_ohm},
    {"inductance_h", "H", "--inductance", &ActuatorKnowns::inductance_h,
     &StatedActuator::inductance_h},
}};

// of a fit's constants
struct Identified {
  std::string_view key;
  std::string_view unit;
  std::optional<Quantity> StatedActuator::* stated;
};

constexpr std::array<Identified, 3> kIdentified{{
    {"stiffness_n_per_m", "N/m", &StatedActuator::stiffness_n_per_m},
    {"damping_n_s_per_m", "N s/m", &StatedActuator::damping_n_s_per_m},
    {"force_constant_n_per_a", "N/A", &StatedActuator::force_constant_n_per_a},
}};

// places in sim::kActuatorSymbols
constexpr std::size_t kMovingMass = 0;
constexpr std::size_t kCaseMass = 1;
constexpr std::size_t kFirstConstant = 2;
constexpr std::size_t kResistance = 5;
constexpr std::size_t kInductance = 6;

Quantity Of(const FittedValue& value) { return {value.value, value.combined_standard_uncertainty}; }

// masses and coil as given, and the constants that the fit determines
Result<StatedActuator> Begin(const ActuatorKnowns& knowns,
                             const std::array<const FittedValue*, 3>& constants) {
  StatedActuator stated{};
  for (const Needed& needed : kNeeded) {
    const auto& known = knowns.*needed.known;
    if (!known) {
      return Usage("--save", fmt::format("a scene needs {} too", needed.key),
                   fmt::format("state it with {}", needed.option));
    }
    stated.*needed.stated = *known;
  }
  for (std::size_t k = 0; k < constants.size(); ++k) {
    if (constants[k]->determined) stated.*kIdentified[k].stated = Of(*constants[k]);
  }
  return stated;
}

// the correlation coefficient of two of the seven, from relative covariances
void Correlate(std::size_t one, std::size_t other, double covariance, double one_square,
               double other_square, StatedActuator& stated) {
  const double product = one_square * other_square;
  const double coefficient = product > 0 ? covariance / std::sqrt(product) : 0;
  if (std::abs(coefficient) < 1e-9) return;
  const auto [first, second] = std::minmax(one, other);
  stated.correlations[fmt::format("{}_{}", sim::kActuatorSymbols[first],
                                  sim::kActuatorSymbols[second])] =
      std::clamp(coefficient, -1.0, 1.0);
}

// of a given number with each constant: cov = (d ln constant / d ln given) u(ln given)^2
template <typename Covariance>
void CorrelateGiven(std::size_t place, std::string_view input,
                    const std::vector<fit::InputInfluence>& influences,
                    const Covariance& covariance, StatedActuator& stated) {
  const auto found = std::ranges::find(influences, input, &fit::InputInfluence::input);
  if (found == influences.end()) return;
  const double square = std::pow(found->relative_standard_uncertainty, 2);
  for (std::size_t k = 0; k < kIdentified.size(); ++k) {
    Correlate(place, kFirstConstant + k, found->percent_per_percent[k] * square, square,
              covariance[k][k], stated);
  }
}

// of the constants with each other
template <typename Covariance>
void CorrelateConstants(const Covariance& covariance, StatedActuator& stated) {
  for (std::size_t i = 0; i < kIdentified.size(); ++i) {
    for (std::size_t j = i + 1; j < kIdentified.size(); ++j) {
      Correlate(kFirstConstant + i, kFirstConstant + j, covariance[i][j], covariance[i][i],
                covariance[j][j], stated);
    }
  }
}

std::string Line(std::string_view key, const Quantity& quantity, std::string_view unit) {
  if (quantity.exact()) return fmt::format("{} = \"{:.12g} {}\"\n", key, quantity.value, unit);
  return fmt::format("{} = \"{:.12g} {} +- {:.4g} {}\"\n", key, quantity.value, unit,
                     quantity.standard_uncertainty, unit);
}

std::string TextOf(const StatedActuator& stated, const document::Provenance& provenance) {
  // --overwrite recognises such files by the first line
  std::string text = "# written by haptometer fit-lra; value +- standard uncertainty\n" +
                     document::CommentOf(provenance, "# ");
  for (const Needed& needed : kNeeded) text += Line(needed.key, stated.*needed.stated, needed.unit);
  for (const Identified& identified : kIdentified) {
    const auto& value = stated.*identified.stated;
    if (value) text += Line(identified.key, *value, identified.unit);
  }
  if (!stated.correlations.empty()) text += "\n[correlation]\n";
  for (const auto& [pair, coefficient] : stated.correlations) {
    text += fmt::format("{} = {:.9f}\n", pair, coefficient);
  }
  return text;
}

// whether the sweep's fit took a stated number, and so moves with it
bool IsTaken(const fit::ImpedanceFit& fit, std::string_view input) {
  return std::ranges::find(fit.influences, input, &fit::InputInfluence::input) !=
         fit.influences.end();
}

}  // namespace

Result<StatedActuator> FittedActuator(const fit::DropTestFit& fit, const ActuatorKnowns& knowns) {
  HAPTOMETER_LET(auto stated, Begin(knowns, {&fit.stiffness, &fit.damping, &fit.force_constant}));
  constexpr std::array<std::pair<std::size_t, std::string_view>, 4> kInputs{
      {{kMovingMass, "moving mass"},
       {kCaseMass, "case mass"},
       {kResistance, "coil resistance"},
       {kInductance, "coil inductance"}}};
  for (const auto& [place, input] : kInputs) {
    CorrelateGiven(place, input, fit.influences, fit.relative_covariance, stated);
  }
  CorrelateConstants(fit.relative_covariance, stated);
  return stated;
}

Result<StatedActuator> FittedActuator(const fit::ImpedanceFit& fit, const ActuatorKnowns& knowns) {
  // a sweep determines R and L too, which a stated value overrides
  ActuatorKnowns all = knowns;
  if (!all.resistance_ohm && fit.resistance.determined) all.resistance_ohm = Of(fit.resistance);
  if (!all.inductance_h && fit.inductance.determined) all.inductance_h = Of(fit.inductance);
  HAPTOMETER_LET(auto stated, Begin(all, {&fit.stiffness, &fit.damping, &fit.force_constant}));
  const auto& covariance = fit.relative_covariance;
  CorrelateGiven(kMovingMass, "moving mass", fit.influences, covariance, stated);
  CorrelateGiven(kCaseMass, "case mass", fit.influences, covariance, stated);
  CorrelateConstants(covariance, stated);
  // behind the three constants come R and L, unless an ohmmeter's R stands in the place of the
  // fit's
  const bool has_resistance = !knowns.resistance_ohm || IsTaken(fit, "resistance");
  const auto correlate = [&](std::size_t row, std::size_t place, std::size_t columns) {
    for (std::size_t k = 0; k < columns; ++k) {
      if (k == 3 && !has_resistance) continue;
      Correlate(kFirstConstant + k, place, covariance[k][row], covariance[k][k],
                covariance[row][row], stated);
    }
  };
  if (has_resistance) correlate(3, kResistance, 3);
  correlate(4, kInductance, 4);
  return stated;
}

void DeclareFiles(cli::Options& options, FitFiles& files, std::string_view figures) {
  options.Flag("--all", &files.outputs.all, "Print all details and the provenance");
  options.Output("--plot", &files.outputs.plot, "FILE.svg|png|pdf", figures);
  options.Output("--report", &files.outputs.report, "FILE.html",
                 "Write one page with all details and the figures");
  options.Output(
      "--save", &files.save, "FILE.toml",
      "Write the actuator with uncertainties and correlations, for scenes and --actuator");
  options.Flag("--overwrite", &files.overwrite,
               "Replace an actuator file that --save wrote earlier");
}

Result<void> CheckFiles(const FitFiles& files) {
  if (!files.save.empty()) {
    HAPTOMETER_TRY(cli::CheckOutput(files.save, cli::kActuatorOutput, files.overwrite));
  }
  return document::CheckOutputs(files.outputs);
}

Result<void> SaveActuator(const FitFiles& files, const Result<StatedActuator>& actuator,
                          std::string_view verb, int argc, const char* const* argv) {
  if (files.save.empty()) return {};
  if (!actuator) return std::unexpected(actuator.error());
  return cli::WriteOutput(files.save, cli::kActuatorOutput, files.overwrite,
                          TextOf(*actuator, document::ProvenanceOf(verb, argc, argv)));
}

}  // namespace haptometer::tools
