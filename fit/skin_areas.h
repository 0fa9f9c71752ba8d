#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fit/area_law.h"
#include "fit/skin_fit.h"

namespace haptometer::fit {

/// One of the skin's constants over the area of the contact.
struct AreaDependence {
  AreaLaw law;
  double lower_95 = 0;  ///< of the exponent
  double upper_95 = 0;
  bool holds_one_third = false;  ///< whether 1/3 lies in the interval
  /// Mean exponents over these areas of Lindsay's own formula (sim/skin/skin.h), which runs in a
  /// line with the cube root of the area and is no pure power law: for Ks with 600-2000 and with
  /// 600-1200 N/m, for Bs one number twice. Absent where an area lies outside of 1-100 mm2.
  std::optional<double> thesis_text;
  std::optional<double> thesis_table;
};

/// Whether an exponent lies in the 95 % interval.
[[nodiscard]] bool Holds(const AreaDependence& dependence, double exponent);

struct SkinAreas {
  std::optional<AreaDependence> stiffness;
  std::optional<AreaDependence> damping;
};

/// Fits Ks and Bs of those contacts that have an area and a determined value (area_law.h). The
/// actuator's constants are common to all contacts, and move the exponent by what they move the
/// contacts differently; those of the first contact count.
[[nodiscard]] SkinAreas FitSkinAreas(const std::vector<SkinFit>& contacts);

}  // namespace haptometer::fit
