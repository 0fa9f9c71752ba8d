#pragma once

#include <cstdint>

#include "base/finding.h"

namespace haptometer::sim {

/// What this room finds of a scene, without words: what each number is stands behind its kind, what
/// each kind says in tools/document/findings_sim.cc.
enum class FindingKind : std::uint8_t {
  // why a motion ends before its time: at_s of a run, or within `periods` of a transient
  kEventsWithoutEnd,  ///< a hundred events in no time
  kTooManyEvents,     ///< bodies that rattle far faster than the drive
  kBodiesTooFast,     ///< too many intervals in which events have to be looked for
  kSolverStopped,
  kTooManySteps,  ///< of the solver

  // why a scene has no answer
  kNothingHolds,      ///< no spring holds the bodies where the motion begins
  kBeyondDoubles,     ///< a number is not finite
  kBeyondPrediction,  ///< tolerance, known_until_s: errors grow in an exact motion
  kErrorUnbounded,    ///< of smooth effects
  kErrorTooLarge,     ///< relative_error, tolerance, least_tolerance: of smooth effects

  // why a scene without a duration has none
  /// most_periods, transient_periods, periods, steps; growth and growth_uncertainty of deviations
  /// (logarithm, each period) where they were measured; averaged_periods where averages depend on
  /// one part of them; nearest_recurrence; most_steps where these were spent
  kNoPeriodicMotion,
  kNotFoundAgain,          ///< drive_periods, tolerance, steps: with less tolerance
  kTremorAtResonance,      ///< an undamped one
  kTremorWithLimits,       ///< stops or lost contact: no common period
  kTremorWithBentSprings,  ///< or another smooth effect
  kChaoticWhileWarming,
  kNoHeatLeaves,  ///< the coil

  // what is wrong with the bounds of an adapter
  kBoundsCross,
  kBoundNegative,
  kSkinSideMassNotPositive,
  kStiffnessNotPositive,
  kSkinVariationOutside,
  kTravelNotPositive,
  kSkinUndamped,
  kAreaOutside,

  // what a scene states and its answer does not use
  kEffectOff,    ///< constants, effect: the effect is off
  kStartUnused,  ///< of a steady motion

  kUnusualNumber,  ///< key, value, least, most: of a scene, mostly an error of unit

  // what the numbers of every scene rest on
  kLinearSprings,  ///< springs and dampers, at any travel; off: an effect that is stated and off
  kContactKept,    ///< least_force_n

  // the rise of the skin
  kDriveVaries,  ///< drive (its kind): no amplitude is steady
  kDriveShort,   ///< least_periods
  kRunTooLong,   ///< run_s
  kNoRise,       ///< run_s: the amplitude does not pass both limits
  kLatencyUnnoticed,
  kLatencyCostsErrors,
  kLatencyPerceived,
  kLatencyUndecided,
};

using Finding = FindingOf<FindingKind>;
using Findings = haptometer::Findings<FindingKind>;

}  // namespace haptometer::sim
