#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/quantity.h"

namespace haptometer {
class TomlTable;
}

namespace haptometer::sim {

/// A linear resonant actuator as numbers: a moving mass on a spring and damper inside a case,
/// driven by a coil. The symbols are those of J. Lindsay, "A Mechanical Amplifier for Haptic
/// Feedback", University of Washington, 2013, equations 2.1-2.4.
struct Actuator {
  double moving_mass_kg = 0;          ///< Mv > 0
  double case_mass_kg = 0;            ///< Mc > 0
  double stiffness_n_per_m = 0;       ///< Kv > 0, between moving mass and case
  double damping_n_s_per_m = 0;       ///< Bv >= 0, between moving mass and case
  double force_constant_n_per_a = 0;  ///< Km > 0; the same number in V s/m is the back EMF
  double resistance_ohm = 0;          ///< R > 0
  double inductance_h = 0;            ///< L >= 0; 0: the coil has none
};

/// An actuator as somebody states it: with standard uncertainties ("1.40(3)g"), and possibly
/// without the three constants that only an identification gives. Values are SI.
struct StatedActuator {
  std::string name;  ///< of the built-in, or the file's path
  Quantity moving_mass_kg;
  Quantity case_mass_kg;
  Quantity resistance_ohm;
  Quantity inductance_h;
  std::optional<Quantity> stiffness_n_per_m;
  std::optional<Quantity> damping_n_s_per_m;
  std::optional<Quantity> force_constant_n_per_a;
  std::map<std::string, double> correlations{};  ///< of two symbols, as "Mv_Kv"; absent: 0
};

/// The symbols of an actuator's seven numbers, in the order of their covariance.
inline constexpr std::array<std::string_view, 7> kActuatorSymbols{"Mv", "Mc", "Kv", "Bv",
                                                                  "Km", "R",  "L"};
/// Those numbers, and their keys in files, in that order.
inline constexpr std::array kActuatorNumbers{
    &Actuator::moving_mass_kg,    &Actuator::case_mass_kg,           &Actuator::stiffness_n_per_m,
    &Actuator::damping_n_s_per_m, &Actuator::force_constant_n_per_a, &Actuator::resistance_ohm,
    &Actuator::inductance_h};
inline constexpr std::array<std::string_view, 7> kActuatorKeys{
    "moving_mass_kg",         "case_mass_kg",   "stiffness_n_per_m", "damping_n_s_per_m",
    "force_constant_n_per_a", "resistance_ohm", "inductance_h"};
/// Relative covariance of the seven: that of their logarithms.
using ActuatorCovariance = std::array<std::array<double, 7>, 7>;

/// What the stated uncertainties and correlations say; 0 for what is exact, absent or 0.
[[nodiscard]] ActuatorCovariance RelativeCovariance(const StatedActuator& stated);

/// The actuator with one of its seven numbers, by the place of its symbol, `factor` times as large.
[[nodiscard]] Actuator Scaled(Actuator actuator, std::size_t place, double factor);

/// Precision Microdrives C10-100, one specimen, as in Lindsay 2013, Table 2.1: Mv 1.4 g, Mc 0.6 g,
/// R 27 ohm, L 130 uH, and from its drop test Kv 2800 N/m, Bv 0.0322 N s/m, Km 1.0 N/A.
[[nodiscard]] Actuator ThesisC10100();

/// The actuator called `name_or_path`: the built-in "thesis-c10-100", or a TOML file with the keys
///
///   moving_mass_kg, case_mass_kg, resistance_ohm, inductance_h                     (required)
///   stiffness_n_per_m, damping_n_s_per_m, force_constant_n_per_a                   (optional)
///   [correlation] Mv_Kv and any other pair of kActuatorSymbols in that order       (optional)
///
/// Errors: the file's (base/input_file.h), an unknown or unreadable key, a value that is not
/// positive (damping, inductance: negative), a correlation beyond -1 to 1.
[[nodiscard]] Result<StatedActuator> FindActuator(const std::string& name_or_path);

/// The keys above out of a table that is already open; the table's Finish() tells the errors.
[[nodiscard]] StatedActuator ReadActuator(TomlTable& table);

/// The numbers alone. Error (Cause::kCannotAnswer): one of the three optional constants is not
/// stated; the message names it.
[[nodiscard]] Result<Actuator> Complete(const StatedActuator& stated);

}  // namespace haptometer::sim
