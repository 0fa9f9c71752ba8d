#include "sim/findings.h"
#include "tools/document/document.h"

// Sentences for the findings of sim; [optional parts] need their numbers.
namespace haptometer::document {

Sentence SentenceOf(sim::FindingKind kind) {
  using enum sim::FindingKind;
  static constexpr KindSentence<sim::FindingKind> kSentences[] = {
      // --- why a motion ends before its time ---
      {kEventsWithoutEnd, "events-without-end",
       "events follow each other without end[ at {at_s}; shorten duration_s][ within {periods} "
       "periods of the drive; give duration_s], or leave out effects that are on"},
      {kTooManyEvents, "too-many-events",
       "there are too many events[ until {at_s}; shorten duration_s][ within {periods} periods "
       "of the drive; give duration_s], or leave out effects that are on"},
      {kBodiesTooFast, "bodies-too-fast",
       "the bodies or the current are too fast, relative to the drive, for a search of events[ "
       "at {at_s}][ within {periods} periods of the drive]; leave out what decays so fast (with "
       "inductance_h = 0 the current follows without delay), or the effects that are on"},
      {kSolverStopped, "solver-stopped",
       "the solver stops[ at {at_s}; shorten duration_s][ within {periods} periods of the "
       "drive; give duration_s], or leave out effects that are on"},
      {kTooManySteps, "too-many-steps",
       "the solver needs too many steps[ at {at_s}; shorten duration_s][ within {periods} "
       "periods of the drive; give duration_s], or leave out effects that are on"},
      // --- why a scene has no answer ---
      {kNothingHolds, "nothing-holds",
       "nothing holds the bodies where the motion begins; leave out effects that are on"},
      {kBeyondDoubles, "beyond-doubles",
       "its numbers are beyond the range of a double; leave out effects that are on"},
      {kBeyondPrediction, "beyond-prediction",
       "small errors grow in this motion until it is beyond prediction: its error is below "
       "{tolerance} until {known_until_s}; give a duration_s of {known_until_s} or less, or "
       "leave out effects that are on"},
      {kErrorUnbounded, "error-unbounded",
       "the motion under the smooth effects is not known: its error grows without bounds; "
       "shorten duration_s, or leave out effects that are on"},
      {kErrorTooLarge, "error-too-large",
       "with smooth effects the answer's relative error is {relative_error}, above the required "
       "{tolerance}; give a tolerance of {least_tolerance} or more"},
      // --- why a scene without a duration has none ---
      {kNoPeriodicMotion, "no-periodic-motion",
       "no motion was found that repeats itself every 1 to {most_periods} periods "
       "({transient_periods} periods of transient[, deviations grow by {growth} "
       "+-{growth_uncertainty} (standard uncertainty) each period][, averages over "
       "{averaged_periods} periods depend on one part of them][, nearest recurrence "
       "{nearest_recurrence} of the motion's size]; {periods} periods and {steps} steps in "
       "all[, of which {most_steps} are the limit]); give duration_s and start = \"rest\", or "
       "leave out effects that are on"},
      {kNotFoundAgain, "not-found-again",
       "the motion that repeats itself every {drive_periods} periods is not found again with a "
       "tolerance of {tolerance}; {steps} steps in all; give duration_s, or leave out effects "
       "that are on"},
      {kTremorAtResonance, "tremor-at-resonance",
       "the tremor excites an undamped resonance; give duration_s, or add damping"},
      {kTremorWithLimits, "tremor-with-limits",
       "tremor and drive have no common period in which a limited motion repeats itself; give "
       "duration_s, or leave out effects that are on"},
      {kTremorWithBentSprings, "tremor-with-smooth-effects",
       "tremor and drive have no common period in which a motion under smooth effects repeats "
       "itself; give duration_s, or leave out effects that are on"},
      {kChaoticWhileWarming, "chaotic-while-warming",
       "the motion is chaotic while the coil warms; give duration_s, or leave out effects that "
       "are on"},
      {kNoHeatLeaves, "no-heat-leaves",
       "no heat leaves the coil: coil_heating has no thermal_resistance_k_per_w; state it, or "
       "give duration_s"},
      // --- what is wrong with the bounds of an adapter ---
      {kBoundsCross, "bounds-cross", "a lower bound lies above its upper bound"},
      {kBoundNegative, "bound-negative", "a bound is negative"},
      {kSkinSideMassNotPositive, "skin-side-mass-not-positive",
       "the skin side's mass must be above 0"},
      {kStiffnessNotPositive, "stiffness-not-positive", "the stiffness must be above 0"},
      {kSkinVariationOutside, "skin-variation-outside",
       "the skin's variation must be from 0 to below 1"},
      {kTravelNotPositive, "travel-not-positive", "the mover's travel must be above 0"},
      {kSkinUndamped, "skin-undamped", "the skin has no damping"},
      {kAreaOutside, "area-outside", "the area must lie between 1 and 100 mm2"},
      // --- what a scene states and its answer does not use ---
      {kEffectOff, "effect-off",
       "{constants} is stated and {effect} is off: write {effect} = true in the table effects to "
       "include it"},
      {kStartUnused, "start-unused",
       "the steady motion does not depend on where it begins: give a duration for the motion from "
       "the stated start"},
      // --- a number outside of the usual range ---
      {kUnusualNumber, "unusual-number",
       "{key} = {value} is unusual, usual are {least} to {most}: was another unit meant?"},
      // --- what the numbers of every scene rest on ---
      {kLinearSprings, "linear",
       "springs and dampers are linear at any travel[, as {off} is off]: compare the mover's "
       "travel "
       "with its stops"},
      {kContactKept, "contact-kept",
       "contact is assumed to be kept, as if actuator and skin were glued: a preload of at least "
       "{least_force_n}, weight included, would keep it"},
      // --- the rise of the skin ---
      {kDriveVaries, "drive-varies",
       "rise and latency are not known: under {drive} no amplitude is steady"},
      {kDriveShort, "drive-short",
       "rise and latency are not known: the drive is on for less than {least_periods} periods"},
      {kRunTooLong, "run-too-long",
       "rise and latency are not known: a run of {run_s} has too many outputs to be examined"},
      {kNoRise, "no-rise",
       "rise and latency are not known: in a run of {run_s} the amplitude does not pass from 10 "
       "% to 90 %"},
      {kLatencyUnnoticed, "latency-unnoticed",
       "the latency is below 25 ms, the limit from which on a latency causes errors"},
      {kLatencyCostsErrors, "latency-costs-errors",
       "the latency is above 25 ms, where it causes errors, and below 50 ms, where it is "
       "perceived"},
      {kLatencyPerceived, "latency-perceived", "the latency is above 50 ms, where it is perceived"},
      {kLatencyUndecided, "latency-undecided",
       "the latency is too uncertain to be compared with 25 ms, where it causes errors, and 50 "
       "ms, where it is perceived"},
  };
  return SentenceIn(kSentences, kind);
}

}  // namespace haptometer::document
