#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "base/finding.h"

namespace haptometer::fit {

/// What a fit has found; behind each kind the numbers that it rests on. The subject is a record.
enum class FindingKind : std::uint8_t {
  // what a record holds beside one ring-down, and what is done about it
  kHeaderKeyUnknown,       ///< key, nearest
  kSeveralDrops,           ///< drops
  kHeightOfFirstDrop,      ///< of several: the others have none
  kTooFewDrops,            ///< good, drops: not used
  kThinned,                ///< samples, block, clipped (absent: none)
  kClipped,                ///< samples
  kLaterImpact,            ///< at_s, amplitude_v or _m, ringing_v or _m, kept (before, after)
  kQuantisedTail,          ///< step_v or _m, from_s
  kDryFriction,            ///< share: of the spring's force at the first swing
  kHum,                    ///< frequency_hz, amplitude_v or _m
  kDrift,                  ///< amplitude_v or _m
  kSlowRest,               ///< amplitude_v or _m: what is slow and no line
  kOtherMode,              ///< unexplained_share
  kHeightWithoutImpact,    ///< not used
  kCurrentWithoutRelease,  ///< not used
  kHeightOfFirstImpact,    ///< not used
  kHeightOfLongImpact,     ///< not used: shortest_s, longest_s that was looked for
  kReleaseBehindSlow,      ///< at_s, from_s
  kDownweighted,           ///< samples, of
  kNotQuietBefore,
  // what a fit of drops assumes
  kOpenAssumed,
  kHeldAssumed,  ///< ratio, root_ratio (absent: masses are not known)
  kInductanceAssumedZero,
  kVoltageScaleExact,
  kReboundStated,     ///< rebound, standard_uncertainty (absent: exact)
  kReboundAssumed,    ///< rebound, standard_uncertainty
  kContactUnseen,     ///< share: of 0.5 ms
  kContactAtMost,     ///< longest_s, share
  kContactCorrected,  ///< shortest_s, longest_s, share
  kKmByLoads,   ///< other_n_per_a, half_interval_n_per_a: by the height; normalized_error (above 1)
  kKmByHeight,  ///< other_n_per_a, half_interval_n_per_a: by the loads; normalized_error (above 1)
  kRobustLoss,  ///< bend
  // what is not determined
  kMassMissing,
  kMassesMissing,
  kNoDecay,
  kDampingsTogether,           ///< sum_per_s
  kDampingsWithoutResistance,  ///< sum_per_s
  kDampingsWithoutHeight,      ///< sum_per_s
  kKmOfDisplacement,
  kKmOfReleaseWithoutMass,
  kKmTimesSpeedOnly,    ///< product_v
  kKmTimesUnusedSpeed,  ///< product_v; a height is stated and not used
  kKmLostInDamping,
  // what makes the constants useless
  kSmallerLoadDecaysSlower,
  kMotionBeginsBefore,  ///< apart_s
  kMotionBeginsAfter,   ///< apart_s
  kRecordOfAnother,     ///< ratio
  kFrequencyOfAnother,  ///< share
  kDecayOfAnother,      ///< share
  // what speaks against the model
  kSpringStiffens,      ///< share, deviations
  kSpringSoftens,       ///< share, deviations
  kFrictionSlows,       ///< share, deviations
  kDampingGrows,        ///< share, deviations
  kFrequenciesScatter,  ///< scatter, birge_ratio, degrees_of_freedom
  kDecaysScatter,       ///< scatter, birge_ratio, degrees_of_freedom
  kResidualsCorrelated,
  kOutlyingPoint,    ///< frequency_hz, spread
  kFollowsOnePoint,  ///< frequency_hz; without it stiffness_ratio, damping_ratio,
                     ///< force_constant_ratio times what was fitted
  // what is unlike an actuator, an adapter or skin; usually a unit
  kUnusualFrequency,      ///< natural_frequency_hz
  kUnusualQuality,        ///< quality_factor
  kUnusualForceConstant,  ///< force_constant_n_per_a
  kUnusualMovingMass,     ///< moving_mass_kg
  kUnusualCaseMass,       ///< case_mass_kg
  kUnusualAdapterMass,    ///< mass_kg
  kNoDisplacement,        ///< unit: of a tap
  kUnusualResistance,     ///< resistance_ohm
  kUnusualVoltage,        ///< peak_v
  kUnusualHeight,         ///< drop_height_m
  kUnusualAmplitude,      ///< amplitude_m
  kUnusualSkinStiffness,  ///< stiffness_n_per_m
  kUnusualSkinDamping,    ///< damping_n_s_per_m
  kUnusualDrive,          ///< current_a or voltage_v
  kUnusualFrequencies,    ///< lowest_hz, highest_hz
  // an impedance sweep
  kResistanceAsStated,
  kInductanceBelow,    ///< at_most_h
  kSweepTooCoarse,     ///< constants, near, points, step_hz
  kResonanceOutside,   ///< natural_frequency_hz
  kResistanceDiffers,  ///< fitted_ohm, stated_ohm
  // the skin
  kPolarityTurned,
  kKsNotDetermined,
  kBsNotDetermined,
  kSkinMassNotDetermined,
  kFarOffModel,     ///< share
  kBeyondStated,    ///< ratio
  kNegativeMass,    ///< mass_kg
  kSecondSolution,  ///< stiffness_n_per_m, damping_n_s_per_m, mass_kg
  // an adapter
  kOneSideHeld,
  kTimeBaseExact,
  kKaNotDetermined,
  kBaBelow,                ///< at_most_n_s_per_m
  kDampingChangesLater,    ///< share, skipped_s
  kStiffnessChangesLater,  ///< share, skipped_s
  kManyImpacts,            ///< impacts
  kTapsScatter,            ///< constant, birge_ratio, degrees_of_freedom
  // an impedance sweep's table
  kPointsWrittenTwice,  ///< copies, points: with them
};

using Finding = FindingOf<FindingKind>;
using Findings = haptometer::Findings<FindingKind>;

/// A finding of one record.
[[nodiscard]] inline Finding About(const std::string& subject, Severity severity, FindingKind kind,
                                   std::vector<FindingNumber> numbers = {}) {
  return {.severity = severity, .kind = kind, .numbers = std::move(numbers), .subject = subject};
}

}  // namespace haptometer::fit
