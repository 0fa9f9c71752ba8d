#include "fit/impedance_findings.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

namespace haptometer::fit {
namespace {

void ExplainMass(const ActuatorKnowns& knowns, CaseCondition condition, ImpedanceFit* fit) {
  const bool held = condition == CaseCondition::kHeld;
  fit->mass_symbol = held ? "Mv" : "Mv Mc/(Mv+Mc)";
  const bool known = knowns.moving_mass_kg && (held || knowns.case_mass_kg);
  if (known) return;
  fit->undetermined.push_back(fmt::format(
      "Kv, Bv, Km: a sweep holds Kv/M, Bv/M and Km^2/M only; give {}",
      held ? "--moving-mass 1.4g" : "both masses: --moving-mass 1.4g --case-mass 0.6g"));
}

void ExplainSweep(const ImpedanceFit& fit, std::vector<std::string>* undetermined) {
  const std::pair<const char*, const FittedValue*> kValues[]{{"f0", &fit.natural_frequency},
                                                             {"Bv/M", &fit.damping_over_mass},
                                                             {"Km^2/M", &fit.coupling_over_mass},
                                                             {"R", &fit.resistance}};
  std::string names;
  for (const auto& [name, value] : kValues) {
    if (!value->determined) names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  }
  if (names.empty()) return;
  undetermined->push_back(fmt::format(
      "{}: the sweep tells them to worse than 25 %; {} of {} points lie within the resonance's "
      "width, measure ten there (steps of {:.2g} Hz) and some an octave away on both sides",
      names, fit.points_near_resonance, fit.points,
      fit.natural_frequency.value / fit.quality_factor.value / 5));
}

void AddDoubts(const ActuatorKnowns& knowns, bool fits_resistance, ImpedanceFit* fit) {
  const auto doubt = [fit](bool is_doubtful, std::string sentence) {
    if (is_doubtful) fit->doubts.push_back(std::move(sentence));
  };
  const auto usual = [&](const FittedValue& value, double least, double most, const char* name,
                         const char* mistake) {
    doubt(value.determined && (value.value < least || value.value > most),
          fmt::format("{} of {:.4g} {} is unlike an actuator's: {}", name, value.value, value.unit,
                      mistake));
  };
  usual(fit->natural_frequency, 20, 2000, "a resonance", "is the frequency in kHz or rad/s?");
  usual(fit->quality_factor, 0.5, 300, "a quality factor", "is it the impedance of an LRA?");
  usual(fit->resistance, 0.1, 1e4, "a coil", "is the magnitude in kohm or mohm?");
  usual(fit->force_constant, 1e-3, 100, "a force constant", "check mass and magnitudes");
  const auto mass = [&](const std::optional<Quantity>& given, double most, const char* name) {
    doubt(given && (given->value < 1e-5 || given->value > most),
          fmt::format("{} of {:.4g} kg is unlike an actuator's: was it meant in g or mg?", name,
                      given ? given->value : 0));
  };
  mass(knowns.moving_mass_kg, 0.1, "a moving mass");
  mass(knowns.case_mass_kg, 1, "a case mass");
  const double f0 = fit->natural_frequency.value;
  doubt(f0 < fit->lowest_hz || f0 > fit->highest_hz,
        fmt::format("the resonance, {:.4g} Hz, lies outside of the sweep", f0));
  std::ranges::move(
      DoubtResiduals(
          fit->residuals, fit->magnitude_noise, fit->farthest_hz,
          "a second resonance, a spring that bends with the level, or losses of the coil "
          "that grow with frequency"),
      std::back_inserter(fit->doubts));
  if (!knowns.resistance_ohm || !fits_resistance) return;
  const double apart = fit->resistance.value - knowns.resistance_ohm->value;
  const double uncertainty = std::hypot(fit->resistance.combined_standard_uncertainty,
                                        knowns.resistance_ohm->standard_uncertainty);
  doubt(std::abs(apart) > 3 * uncertainty && std::abs(apart) > 0.02 * knowns.resistance_ohm->value,
        fmt::format("the sweep gives R = {:.4g} ohm and {:.4g} ohm are stated: a series resistor, "
                    "leads, or a warm coil (+0.39 %/K)?",
                    fit->resistance.value, knowns.resistance_ohm->value));
}

}  // namespace

void AddImpedanceFindings(const ActuatorKnowns& knowns, CaseCondition condition,
                          bool fits_resistance, ImpedanceFit* fit) {
  ExplainMass(knowns, condition, fit);
  ExplainSweep(*fit, &fit->undetermined);
  AddDoubts(knowns, fits_resistance, fit);
}

}  // namespace haptometer::fit
