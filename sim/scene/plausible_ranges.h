#pragma once

#include "sim/findings.h"
#include "sim/scene/scene.h"

/// Ranges outside of which a number of a haptic actuator, its adapter, its drive or skin mostly has
/// another unit. They are wide: such actuators ring at 50 to 500 Hz, weigh grams and take some
/// volts; a fingerpad under a contact of 1 mm2 to 1 cm2 has hundreds to thousands of N/m. The fits
/// and the scenes are doubted by the same.
namespace haptometer::sim {

struct PlausibleRange {
  double least = 0;
  double most = 0;
  [[nodiscard]] constexpr bool Holds(double value) const { return value >= least && value <= most; }
};

inline constexpr PlausibleRange kPlausibleMovingMassKg{1e-5, 0.1};
inline constexpr PlausibleRange kPlausibleCaseMassKg{1e-5, 1};
inline constexpr PlausibleRange kPlausibleAdapterMassKg{1e-5, 0.1};
inline constexpr PlausibleRange kPlausibleResonanceHz{20, 2000};
inline constexpr PlausibleRange kPlausibleForceConstantNPerA{1e-3, 100};
inline constexpr PlausibleRange kPlausibleResistanceOhm{0.1, 1e4};
inline constexpr PlausibleRange kPlausibleSkinStiffnessNPerM{30, 3e4};
inline constexpr PlausibleRange kPlausibleSkinDampingNSPerM{0.02, 50};
inline constexpr PlausibleRange kPlausibleDriveHz{10, 5000};
inline constexpr PlausibleRange kPlausibleDriveV{0, 50};

/// Adds a doubt kUnusualNumber for each number of the scene outside of its range, of which none has
/// one of the same key yet. What is 0 is left out, not mistaken: a massless side, no skin, no
/// drive.
void DoubtUnusual(const Scene& scene, Findings& findings);

}  // namespace haptometer::sim
