#include "fit/plausibility.h"

#include <fmt/core.h>

#include <optional>

namespace haptometer::fit {
namespace {

// the usual values of one quantity, and what is usually wrong outside of them
struct Usual {
  std::string_view name;
  double least = 0;
  double most = 0;
  std::string_view unit;
  std::string_view mistake;
};

void Doubt(const Usual& usual, double value, const std::string& where,
           std::vector<std::string>& doubts) {
  if (value >= usual.least && value <= usual.most) return;
  doubts.push_back(fmt::format("{}{} of {:.4g} {} is unlike an actuator's: {}", where, usual.name,
                               value, usual.unit, usual.mistake));
}

void Doubt(const Usual& usual, const std::optional<Quantity>& value,
           std::vector<std::string>& doubts) {
  if (value) Doubt(usual, value->value, "", doubts);
}

void Doubt(const Usual& usual, const FittedValue& value, std::vector<std::string>& doubts) {
  if (value.determined) Doubt(usual, value.value, "", doubts);
}

}  // namespace

std::vector<std::string> FindDoubts(const DropTestFit& fit,
                                    const std::vector<ImpulseRecord>& records,
                                    const ActuatorKnowns& knowns) {
  constexpr Usual kResonance{"a resonance", 20, 2000, "Hz", "are the times in ms or us?"};
  constexpr Usual kQuality{"a quality factor", 0.05, 1000, "", "is it a ring-down?"};
  constexpr Usual kVoltage{"a largest voltage", 1e-5, 100, "V", "is the column in mV or uV?"};
  constexpr Usual kMovingMass{"a moving mass", 1e-5, 0.1, "kg", "was it meant in g or mg?"};
  constexpr Usual kCaseMass{"a case mass", 1e-5, 1, "kg", "was it meant in g or mg?"};
  constexpr Usual kResistance{"a coil", 0.1, 1e4, "ohm", "was it meant in ohm?"};
  constexpr Usual kHeight{"a drop height", 1e-4, 1, "m", "was it meant in mm?"};
  constexpr Usual kForce{"a force constant", 1e-3, 100, "N/A",
                         "check the voltage's unit and the drop height"};
  std::vector<std::string> doubts = fit.contradictions;
  doubts.insert(doubts.end(), fit.doubts.begin(), fit.doubts.end());
  Doubt(kResonance, fit.natural_frequency, doubts);
  Doubt(kQuality, fit.quality_factor, doubts);
  Doubt(kForce, fit.force_constant, doubts);
  Doubt(kMovingMass, knowns.moving_mass_kg, doubts);
  Doubt(kCaseMass, knowns.case_mass_kg, doubts);
  Doubt(kResistance, knowns.resistance_ohm, doubts);
  for (const auto& record : fit.records) {
    Doubt(kVoltage, record.peak_v, record.name + ": ", doubts);
  }
  for (const auto& record : records) {
    if (!record.drop_height_m) continue;
    Doubt(kHeight, record.drop_height_m->value, record.name + ": ", doubts);
  }
  return doubts;
}

}  // namespace haptometer::fit
