// What each finding of sim says, word for word.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "sim/findings.h"
#include "tools/document/document.h"

namespace haptometer::document {
namespace {

using enum sim::FindingKind;

struct Said {
  sim::FindingKind kind;
  std::vector<FindingNumber> numbers;
  std::string kind_name;
  std::string text;
};

std::vector<Said> Sentences() {
  return {
      {kEventsWithoutEnd,
       {{"at_s", 0.0125}},
       "events-without-end",
       "events follow each other without end at 12.5 ms; shorten duration_s, or leave out effects "
       "that are on"},
      {kTooManyEvents,
       {{"periods", 64}},
       "too-many-events",
       "there are too many events within 64 periods of the drive; give duration_s, or leave out "
       "effects that are on"},
      {kBodiesTooFast,
       {{"at_s", 0.0}},
       "bodies-too-fast",
       "the bodies or the current are too fast, relative to the drive, for a search of events at 0 "
       "ms; leave out what decays so fast (with inductance_h = 0 the current follows without "
       "delay), or the effects that are on"},
      {kSolverStopped,
       {{"at_s", 2.0}},
       "solver-stopped",
       "the solver stops at 2 s; shorten duration_s, or leave out effects that are on"},
      {kTooManySteps,
       {{"periods", 8}},
       "too-many-steps",
       "the solver needs too many steps within 8 periods of the drive; give duration_s, or leave "
       "out effects that are on"},
      {kNothingHolds,
       {},
       "nothing-holds",
       "nothing holds the bodies where the motion begins; leave out effects that are on"},
      {kBeyondDoubles,
       {},
       "beyond-doubles",
       "its numbers are beyond the range of a double; leave out effects that are on"},
      {kBeyondPrediction,
       {{"tolerance", 1e-10}, {"known_until_s", 0.0712}},
       "beyond-prediction",
       "small errors grow in this motion until it is beyond prediction: its error is below 1e-10 "
       "until 71.2 ms; give a duration_s of 71.2 ms or less, or leave out effects that are on"},
      {kErrorUnbounded,
       {},
       "error-unbounded",
       "the motion under the smooth effects is not known: its error grows without bounds; shorten "
       "duration_s, or leave out effects that are on"},
      {kErrorTooLarge,
       {{"relative_error", 2e-9}, {"tolerance", 1e-10}, {"least_tolerance", 4e-9}},
       "error-too-large",
       "with smooth effects the answer's relative error is 2e-09, above the required 1e-10; give a "
       "tolerance of 4e-09 or more"},
      {kNoPeriodicMotion,
       {{"most_periods", 32}, {"transient_periods", 8}, {"periods", 1032}, {"steps", 5160}},
       "no-periodic-motion",
       "no motion was found that repeats itself every 1 to 32 periods (8 periods of transient; "
       "1032 periods and 5160 steps in all); give duration_s and start = \"rest\", or leave out "
       "effects that are on"},
      {kNoPeriodicMotion,
       {{"most_periods", 32},
        {"transient_periods", 4096},
        {"periods", 9216},
        {"steps", 10'000'001},
        {"growth", 0.0125},
        {"growth_uncertainty", 0.002},
        {"averaged_periods", 4096},
        {"nearest_recurrence", 0.0512},
        {"most_steps", 10'000'000}},
       "no-periodic-motion",
       "no motion was found that repeats itself every 1 to 32 periods (4096 periods of transient, "
       "deviations grow by 0.0125 +-0.002 (standard uncertainty) each period, averages over 4096 "
       "periods depend on one part of them, nearest recurrence 0.0512 of the motion's size; 9216 "
       "periods and 10000001 steps in all, of which 10000000 are the limit); give duration_s and "
       "start = \"rest\", or leave out effects that are on"},
      {kNotFoundAgain,
       {{"drive_periods", 2}, {"tolerance", 1e-10}, {"steps", 12'000}},
       "not-found-again",
       "the motion that repeats itself every 2 periods is not found again with a tolerance of "
       "1e-10; 12000 steps in all; give duration_s, or leave out effects that are on"},
      {kTremorAtResonance,
       {},
       "tremor-at-resonance",
       "the tremor excites an undamped resonance; give duration_s, or add damping"},
      {kTremorWithLimits,
       {},
       "tremor-with-limits",
       "tremor and drive have no common period in which a limited motion repeats itself; give "
       "duration_s, or leave out effects that are on"},
      {kTremorWithBentSprings,
       {},
       "tremor-with-smooth-effects",
       "tremor and drive have no common period in which a motion under smooth effects repeats "
       "itself; give duration_s, or leave out effects that are on"},
      {kChaoticWhileWarming,
       {},
       "chaotic-while-warming",
       "the motion is chaotic while the coil warms; give duration_s, or leave out effects that are "
       "on"},
      {kNoHeatLeaves,
       {},
       "no-heat-leaves",
       "no heat leaves the coil: coil_heating has no thermal_resistance_k_per_w; state it, or give "
       "duration_s"},
      {kBoundsCross, {}, "bounds-cross", "a lower bound lies above its upper bound"},
      {kBoundNegative, {}, "bound-negative", "a bound is negative"},
      {kSkinSideMassNotPositive,
       {},
       "skin-side-mass-not-positive",
       "the skin side's mass must be above 0"},
      {kStiffnessNotPositive, {}, "stiffness-not-positive", "the stiffness must be above 0"},
      {kSkinVariationOutside,
       {},
       "skin-variation-outside",
       "the skin's variation must be from 0 to below 1"},
      {kTravelNotPositive, {}, "travel-not-positive", "the mover's travel must be above 0"},
      {kSkinUndamped, {}, "skin-undamped", "the skin has no damping"},
      {kAreaOutside, {}, "area-outside", "the area must lie between 1 and 100 mm2"},
      {kUnusualNumber,
       {{"key", std::string("adapter.skin_side_mass_kg")},
        {"value", 4.35},
        {"least", 1e-5},
        {"most", 0.1}},
       "unusual-number",
       "adapter.skin_side_mass_kg = 4.35 is unusual, usual are 1e-05 to 0.1: was another unit "
       "meant?"},
      {kLinearSprings,
       {},
       "linear",
       "springs and dampers are linear at any travel: compare the mover's travel with its stops"},
      {kLinearSprings,
       {{"off", std::string("stiffening")}},
       "linear",
       "springs and dampers are linear at any travel, as stiffening is off: compare the mover's "
       "travel with its stops"},
      {kEffectOff,
       {{"constants", std::string("tremor")}, {"effect", std::string("tremor")}},
       "effect-off",
       "tremor is stated and tremor is off: write tremor = true in the table effects to include "
       "it"},
      {kStartUnused,
       {},
       "start-unused",
       "the steady motion does not depend on where it begins: give a duration for the motion from "
       "the stated start"},
      {kContactKept,
       {{"least_force_n", 0.34489}},
       "contact-kept",
       "contact is assumed to be kept, as if actuator and skin were glued: a preload of at least "
       "0.3449 N, weight included, would keep it"},
      {kDriveVaries,
       {{"drive", std::string("a chirp")}},
       "drive-varies",
       "rise and latency are not known: under a chirp no amplitude is steady"},
      {kDriveShort,
       {{"least_periods", 20.0}},
       "drive-short",
       "rise and latency are not known: the drive is on for less than 20 periods"},
      {kRunTooLong,
       {{"run_s", 400.0}},
       "run-too-long",
       "rise and latency are not known: a run of 400 s has too many outputs to be examined"},
      {kNoRise,
       {{"run_s", 0.5}},
       "no-rise",
       "rise and latency are not known: in a run of 500 ms the amplitude does not pass from 10 % "
       "to "
       "90 %"},
      {kLatencyUnnoticed,
       {},
       "latency-unnoticed",
       "the latency is below 25 ms, the limit from which on a latency causes errors"},
      {kLatencyCostsErrors,
       {},
       "latency-costs-errors",
       "the latency is above 25 ms, where it causes errors, and below 50 ms, where it is "
       "perceived"},
      {kLatencyPerceived,
       {},
       "latency-perceived",
       "the latency is above 50 ms, where it is perceived"},
      {kLatencyUndecided,
       {},
       "latency-undecided",
       "the latency is too uncertain to be compared with 25 ms, where it causes errors, and 50 ms, "
       "where it is perceived"},
  };
}

TEST(FindingsOfSim, SayEachNumber) {
  std::set<sim::FindingKind> kinds;
  std::set<std::string> names;
  for (const Said& said : Sentences()) {
    EXPECT_EQ(SentenceOf(said.kind).kind, said.kind_name);
    EXPECT_EQ(WordsOf(sim::Finding{Severity::kNote, said.kind, said.numbers}), said.text);
    kinds.insert(said.kind);
    names.insert(said.kind_name);
  }
  EXPECT_EQ(names.size(), kinds.size()) << "a name a kind";
  EXPECT_EQ(kinds.size(), static_cast<std::size_t>(kLatencyUndecided) + 1) << "all kinds";
}

}  // namespace
}  // namespace haptometer::document
