#include "sim/findings.h"
#include "tools/document/document.h"

// Sentences for the findings of sim; [optional parts] need their numbers.
namespace haptometer::document {

Sentence SentenceOf(sim::FindingKind kind) {
  using enum sim::FindingKind;
  switch (kind) {
    // --- why a motion ends before its time ---
    case kEventsWithoutEnd:
      return {"events-without-end",
              "events follow each other without end[ at {at_s}; shorten duration_s][ within "
              "{periods} periods of the drive; give duration_s], or leave out effects that are on"};
    case kTooManyEvents:
      return {"too-many-events",
              "there are too many events[ until {at_s}; shorten duration_s][ within {periods} "
              "periods of the drive; give duration_s], or leave out effects that are on"};
    case kBodiesTooFast:
      return {
          "bodies-too-fast",
          "the bodies or the current are too fast, relative to the drive, for a search of events[ "
          "at {at_s}][ within {periods} periods of the drive]; leave out what decays so fast (with "
          "inductance_h = 0 the current follows without delay), or the effects that are on"};
    case kSolverStopped:
      return {"solver-stopped",
              "the solver stops[ at {at_s}; shorten duration_s][ within {periods} periods of the "
              "drive; give duration_s], or leave out effects that are on"};
    case kTooManySteps:
      return {"too-many-steps",
              "the solver needs too many steps[ at {at_s}; shorten duration_s][ within {periods} "
              "periods of the drive; give duration_s], or leave out effects that are on"};

    // --- why a scene has no answer ---
    case kNothingHolds:
      return {"nothing-holds",
              "nothing holds the bodies where the motion begins; leave out effects that are on"};
    case kBeyondDoubles:
      return {"beyond-doubles",
              "its numbers are beyond the range of a double; leave out effects that are on"};
    case kBeyondPrediction:
      return {"beyond-prediction",
              "small errors grow in this motion until it is beyond prediction: its error is below "
              "{tolerance} until {known_until_s}; give a duration_s of {known_until_s} or less, or "
              "leave out effects that are on"};
    case kErrorUnbounded:
      return {"error-unbounded",
              "the motion under the smooth effects is not known: its error grows without bounds; "
              "shorten duration_s, or leave out effects that are on"};
    case kErrorTooLarge:
      return {"error-too-large",
              "with smooth effects the answer's relative error is {relative_error}, above the "
              "required {tolerance}; give a tolerance of {least_tolerance} or more"};

    // --- why a scene without a duration has none ---
    case kNoPeriodicMotion:
      return {"no-periodic-motion",
              "no motion was found that repeats itself every 1 to {most_periods} periods "
              "({transient_periods} periods of transient[, deviations grow by {growth} "
              "+-{growth_uncertainty} (standard uncertainty) each period][, averages over "
              "{averaged_periods} periods depend on one part of them][, nearest recurrence "
              "{nearest_recurrence} of the motion's size]; {periods} periods and {steps} steps in "
              "all[, of which {most_steps} are the limit]); give duration_s and start = \"rest\", "
              "or leave out effects that are on"};
    case kNotFoundAgain:
      return {"not-found-again",
              "the motion that repeats itself every {drive_periods} periods is not found again "
              "with a tolerance of {tolerance}; {steps} steps in all; give duration_s, or leave "
              "out effects that are on"};
    case kTremorAtResonance:
      return {"tremor-at-resonance",
              "the tremor excites an undamped resonance; give duration_s, or add damping"};
    case kTremorWithLimits:
      return {"tremor-with-limits",
              "tremor and drive have no common period in which a limited motion repeats itself; "
              "give duration_s, or leave out effects that are on"};
    case kTremorWithBentSprings:
      return {"tremor-with-smooth-effects",
              "tremor and drive have no common period in which a motion under smooth effects "
              "repeats itself; give duration_s, or leave out effects that are on"};
    case kChaoticWhileWarming:
      return {"chaotic-while-warming",
              "the motion is chaotic while the coil warms; give duration_s, or leave out effects "
              "that are on"};
    case kNoHeatLeaves:
      return {"no-heat-leaves",
              "no heat leaves the coil: coil_heating has no thermal_resistance_k_per_w; state it, "
              "or give duration_s"};

    // --- what is wrong with the bounds of an adapter ---
    case kBoundsCross:
      return {"bounds-cross", "a lower bound lies above its upper bound"};
    case kBoundNegative:
      return {"bound-negative", "a bound is negative"};
    case kSkinSideMassNotPositive:
      return {"skin-side-mass-not-positive", "the skin side's mass must be above 0"};
    case kStiffnessNotPositive:
      return {"stiffness-not-positive", "the stiffness must be above 0"};
    case kSkinVariationOutside:
      return {"skin-variation-outside", "the skin's variation must be from 0 to below 1"};
    case kTravelNotPositive:
      return {"travel-not-positive", "the mover's travel must be above 0"};
    case kSkinUndamped:
      return {"skin-undamped", "the skin has no damping"};
    case kAreaOutside:
      return {"area-outside", "the area must lie between 1 and 100 mm2"};

    // --- what the numbers of every scene rest on ---
    case kLinearSprings:
      return {"linear",
              "springs and dampers are linear at any travel: compare the mover's travel with its "
              "stops"};
    case kContactKept:
      return {"contact-kept",
              "contact is kept for any force: it is lost where less than {least_force_n} presses "
              "actuator and skin together"};

    // --- the rise of the skin ---
    case kDriveVaries:
      return {"drive-varies",
              "rise and latency are not known: under {drive} no amplitude is steady"};
    case kDriveShort:
      return {"drive-short",
              "rise and latency are not known: the drive is on for less than {least_periods} "
              "periods"};
    case kRunTooLong:
      return {
          "run-too-long",
          "rise and latency are not known: a run of {run_s} has too many outputs to be examined"};
    case kNoRise:
      return {
          "no-rise",
          "rise and latency are not known: in a run of {run_s} the amplitude does not pass from "
          "10 % to 90 %"};
    case kLatencyUnnoticed:
      return {"latency-unnoticed",
              "the latency is below 25 ms, the limit from which on a latency causes errors"};
    case kLatencyCostsErrors:
      return {"latency-costs-errors",
              "the latency is above 25 ms, where it causes errors, and below 50 ms, where it is "
              "perceived"};
    case kLatencyPerceived:
      return {"latency-perceived", "the latency is above 50 ms, where it is perceived"};
    case kLatencyUndecided:
      break;
  }
  return {"latency-undecided",
          "the latency is too uncertain to be compared with 25 ms, where it causes errors, and 50 "
          "ms, where it is perceived"};
}

}  // namespace haptometer::document
