#include "tools/fit/actuator.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/fit/fit_document.h"

namespace haptometer::tools {

using fit::ActuatorKnowns;
using fit::FittedValue;
using sim::StatedActuator;

cli::Option& Statement::Declare(cli::Options& options, std::optional<Quantity>* value) const {
  return options.Number(option, value, dimension, bounds, help);
}

std::optional<Quantity> Statement::Read(TomlTable& table) const {
  if (!table.Has(key)) return std::nullopt;
  const Quantity quantity = table.RequireQuantity(key, dimension);
  // the range and the words of the option
  cli::Option as_option;
  as_option.name = key;
  as_option.dimension = dimension;
  as_option.bounds = bounds;
  const auto good =
      cli::CheckBounds(as_option, quantity.value, fmt::format("{:g}", quantity.value));
  if (!good) table.Refuse(key, good.error().what, good.error().remedy);
  return quantity;
}

namespace {

// places in sim::kActuatorSymbols; the three constants stand between
constexpr std::size_t kFirstConstant = 2, kResistance = 5, kInductance = 6;

// far beyond any actuator, and near enough for numbers that stay finite
constexpr cli::Bounds kMasses = cli::Within(1e-9, 1e3);

constexpr std::array<KnownNumber, 4> kKnownNumbers{
    {{{"moving_mass_kg", "--moving-mass", Dimension::kMass, kMasses, "Moving mass Mv"},
      "moving mass",
      0,
      &ActuatorKnowns::moving_mass_kg,
      &StatedActuator::moving_mass_kg},
     {{"case_mass_kg", "--case-mass", Dimension::kMass, kMasses, "Case mass Mc"},
      "case mass",
      1,
      &ActuatorKnowns::case_mass_kg,
      &StatedActuator::case_mass_kg},
     {{"resistance_ohm", "--resistance", Dimension::kResistance, cli::Within(1e-3, 1e6),
       "Resistance R of the coil"},
      "coil resistance",
      kResistance,
      &ActuatorKnowns::resistance_ohm,
      &StatedActuator::resistance_ohm},
     {{"inductance_h", "--inductance", Dimension::kInductance, cli::Within(0, 1),
       "Inductance L of the coil"},
      "coil inductance",
      kInductance,
      &ActuatorKnowns::inductance_h,
      &StatedActuator::inductance_h}}};

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

}  // namespace

std::span<const KnownNumber> KnownNumbers() { return kKnownNumbers; }

void DeclareActuator(cli::Options& options, ActuatorWords& words, bool has_case) {
  for (const KnownNumber& number : kKnownNumbers) {
    if (!has_case && number.known == &ActuatorKnowns::case_mass_kg) continue;
    number.Declare(options, &(words.knowns.*number.known));
  }
  options
      .Text("--actuator", &words.file, "NAME|FILE.toml",
            "Actuator file, or thesis-c10-100, from which masses, R and L are read")
      .Known({"thesis-c10-100"});
  if (!has_case) return;
  options.Flag("--held", &words.held, "The case was fixed to a heavy mass");
  options.Flag("--free", &words.is_free, "The case was free");
  options.Exclude("--held", {"--free"}, "a case is one of the two");
  options.Repeated("--require", &words.required, "Kv|Bv|Km",
                   "Status 3 where this constant is not determined; may be repeated");
}

Result<void> Check(const ActuatorWords& words) {
  // only constants that the fits determine can be required
  for (const std::string& name : words.required) {
    if (name == "Kv" || name == "Bv" || name == "Km") continue;
    return Usage("--require", fmt::format("{} is none of Kv, Bv, Km", name), "write --require Km");
  }
  return {};
}

Result<ActuatorKnowns> KnownsOfFile(const ActuatorWords& words) {
  ActuatorKnowns knowns;
  if (words.file.empty()) return knowns;
  HAPTOMETER_LET(const auto actuator, sim::FindActuator(words.file));
  for (const KnownNumber& number : kKnownNumbers) knowns.*number.known = actuator.*number.stated;
  return knowns;
}

Result<ActuatorKnowns> KnownsOf(const ActuatorWords& words) {
  HAPTOMETER_LET(auto knowns, KnownsOfFile(words));
  // an option replaces the file's value
  for (const KnownNumber& number : kKnownNumbers) {
    if (words.knowns.*number.known) knowns.*number.known = words.knowns.*number.known;
  }
  return knowns;
}

namespace {

Quantity Of(const FittedValue& value) { return {value.value, value.combined_standard_uncertainty}; }

// masses and coil as given, and the constants that the fit determines
Result<StatedActuator> Begin(const ActuatorKnowns& knowns,
                             const std::array<const FittedValue*, 3>& constants) {
  StatedActuator stated{};
  for (const KnownNumber& number : kKnownNumbers) {
    const auto& known = knowns.*number.known;
    if (!known) {
      return Usage("--save", fmt::format("a scene needs {} too", number.key),
                   fmt::format("state it with {}", number.option));
    }
    stated.*number.stated = *known;
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

// of a given number with each constant: cov = (d ln constant / d ln given) u(ln given)^2; nothing
// where the fit did not take it
template <typename Covariance>
void CorrelateGiven(const KnownNumber& given, const std::vector<fit::InputInfluence>& influences,
                    const Covariance& covariance, StatedActuator& stated) {
  const auto found = std::ranges::find(influences, given.input, &fit::InputInfluence::input);
  if (found == influences.end()) return;
  const double square = std::pow(found->relative_standard_uncertainty, 2);
  for (std::size_t k = 0; k < kIdentified.size(); ++k) {
    Correlate(given.place, kFirstConstant + k, found->percent_per_percent[k] * square, square,
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
  for (const KnownNumber& number : kKnownNumbers) {
    text += Line(number.key, stated.*number.stated, SiUnit(number.dimension));
  }
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
  for (const KnownNumber& given : kKnownNumbers) {
    CorrelateGiven(given, fit.influences, fit.relative_covariance, stated);
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
  // a sweep names R and L otherwise, so that of what was given only the masses are found
  for (const KnownNumber& given : kKnownNumbers) {
    CorrelateGiven(given, fit.influences, covariance, stated);
  }
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
  DeclareOutputs(options, files.outputs,
                 {.all = "Print all details and the provenance", .plot = figures});
  options.Output(
      "--save", &files.save, "FILE.toml",
      "Write the actuator with uncertainties and correlations, for scenes and --actuator");
  options.Flag("--overwrite", &files.overwrite,
               "Replace an actuator file that --save wrote earlier");
}

Result<void> CheckFiles(const FitFiles& files) {
  if (files.save.empty()) return {};
  return cli::CheckOutput(files.save, cli::kActuatorOutput, files.overwrite);
}

Result<StatedActuator> UnlessRefused(const document::Document& answer, const FitFiles& files,
                                     Result<StatedActuator> actuator) {
  if (!IsRefused(answer)) return actuator;
  return CannotAnswer(files.save, "is not written, as these constants are not to be used",
                      "correct what is not answered, and save then");
}

int SaveActuator(const FitFiles& files, const Result<StatedActuator>& actuator,
                 std::string_view verb, int argc, const char* const* argv) {
  if (files.save.empty()) return 0;
  if (!actuator) return cli::ReportError(verb, actuator.error());
  const auto saved = cli::WriteOutput(files.save, cli::kActuatorOutput, files.overwrite,
                                      TextOf(*actuator, document::ProvenanceOf(verb, argc, argv)));
  return saved ? 0 : cli::ReportError(verb, saved.error());
}

}  // namespace haptometer::tools
