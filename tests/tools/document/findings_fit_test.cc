// What each finding of a fit says.
#include "tools/document/findings_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace haptometer::fit {
namespace {

using enum FindingKind;
using ::testing::HasSubstr;
using ::testing::Not;

struct Case {
  FindingKind kind;
  std::string_view name;
  std::vector<FindingNumber> numbers;
  std::string said;
};

const std::vector<Case> kCases{
    {kHeaderKeyUnknown, "header-key-unknown", {{"key", std::string("moving_mas_kg")}, {"nearest", std::string("moving_mass_kg")}}, "is not known; did you mean"},
    {kSeveralDrops, "several-drops", {{"drops", 3}}, "drops in one record, each taken by itself"},
    {kHeightOfFirstDrop, "height-of-first-drop", {}, "the drop height is taken for the first drop alone"},
    {kTooFewDrops, "too-few-drops", {{"good", 3}, {"drops", 3}}, "drops could be fitted, too few for a file of drops: not used"},
    {kThinned, "averaged", {{"samples", 3}, {"block", 3}, {"clipped", 3}}, "at the recorder's limits are left out"},
    {kClipped, "clipped", {{"samples", 3}}, "at the recorder's limits left out"},
    {kLaterImpact, "later-impact", {{"at_s", 0.25}, {"amplitude_v", 0.25}, {"ringing_v", 0.25}, {"amplitude_m", 0.25}, {"ringing_m", 0.25}, {"kept", std::string("before")}}, "beside a ringing of"},
    {kQuantisedTail, "quantised-tail", {{"step_v", 0.25}, {"step_m", 0.25}, {"from_s", 0.25}}, "a tail below one step of the converter"},
    {kDryFriction, "dry-friction", {{"share", 0.25}}, "of the spring's force at the first swing: fitted along"},
    {kHum, "hum", {{"frequency_hz", 0.25}, {"amplitude_v", 0.25}, {"amplitude_m", 0.25}}, ": fitted along"},
    {kDrift, "drift", {{"amplitude_v", 0.25}, {"amplitude_m", 0.25}}, "over the record: fitted along"},
    {kOtherMode, "other-mode", {{"misfit_share", 0.25}}, "of its power is explained by no single decaying"},
    {kHeightWithoutImpact, "height-without-impact", {}, "nothing quiet before it: the drop height is not used"},
    {kCurrentWithoutRelease, "current-without-release", {}, "nothing quiet before it: the released current is not used"},
    {kHeightOfFirstImpact, "height-of-first-impact", {}, "the drop height is that of the first impact: not used"},
    {kReleaseBehindSlow, "release-behind-slow", {{"at_s", 0.25}, {"from_s", 0.25}}, "an oscillation sets in behind something slow at"},
    {kDownweighted, "downweighted", {{"samples", 3}, {"of", 3}}, "samples lie far off and weigh less than half"},
    {kNotQuietBefore, "not-quiet-before", {}, "what precedes the impact has a larger RMS than the"},
    {kOpenAssumed, "open-assumed", {}, "open circuit: no load is stated"},
    {kHeldAssumed, "held-assumed", {{"ratio", 0.25}, {"root_ratio", 0.25}}, "the case was held: neither --held nor --free is given, and"},
    {kInductanceAssumedZero, "inductance-assumed-zero", {}, "coil inductance 0: none is given; a coil of 130 uH and 27"},
    {kVoltageScaleExact, "voltage-scale-exact", {}, "the recorder's voltage scale is taken as exact"},
    {kReboundStated, "rebound", {{"rebound", 0.25}, {"standard_uncertainty", 0.25}}, "impact speed (1 + e) sqrt(2 g h) with g = 9.80665 m/s^2 and"},
    {kReboundAssumed, "rebound-assumed", {{"rebound", 0.25}, {"standard_uncertainty", 0.25}}, "impact speed (1 + e) sqrt(2 g h) with g = 9.80665 m/s^2 and"},
    {kContactUnseen, "contact-unseen", {{"share", 0.25}}, "the impact is taken as short, since nothing quiet before it"},
    {kContactAtMost, "contact-at-most", {{"longest_s", 0.25}, {"share", 0.25}}, ", which makes Km by the height up to"},
    {kContactCorrected, "contact-corrected", {{"shortest_s", 0.25}, {"longest_s", 0.25}, {"share", 0.25}}, ", as a half sine of force; Km by the height is corrected"},
    {kKmByLoads, "km-by-loads", {{"other_n_per_a", 0.25}, {"half_interval_n_per_a", 0.25}}, "Km rests on the loads' damping; with the drop height it"},
    {kKmByHeight, "km-by-height", {{"other_n_per_a", 0.25}, {"half_interval_n_per_a", 0.25}}, "Km rests on the drop height and the loads; by the loads"},
    {kRobustLoss, "robust-loss", {{"bend", 0.25}}, "of the residuals' scale a sample has a constant influence"},
    {kMassMissing, "mass-missing", {}, "Kv and Bv, and Km of an impedance sweep, are determined"},
    {kMassesMissing, "masses-missing", {}, "Kv and Bv, and Km of an impedance sweep, are determined"},
    {kNoDecay, "no-decay", {}, "Bv and Q are not determined: the record shows no decay"},
    {kDampingsTogether, "dampings-together", {{"sum_per_s", 0.25}}, "is determined; record an open circuit too"},
    {kDampingsWithoutResistance, "dampings-without-resistance", {{"sum_per_s", 0.25}}, "is determined; record an open circuit too, or state the"},
    {kDampingsWithoutHeight, "dampings-without-height", {{"sum_per_s", 0.25}}, "is determined; record an open circuit too, or state the"},
    {kKmOfDisplacement, "km-of-displacement", {}, "Km: a displacement does not show it; record the voltage,"},
    {kKmOfReleaseWithoutMass, "km-of-release-without-mass", {}, "Km: a voltage after a released current shows only Km^2/M;"},
    {kKmTimesSpeedOnly, "km-times-speed-only", {{"product_v", 0.25}}, "; state the drop height (--drop-height), or record again"},
    {kKmLostInDamping, "km-lost-in-damping", {}, "Km: what these loads change in the damping is within its"},
    {kSmallerLoadDecaysSlower, "smaller-load-decays-slower", {}, "the records contradict each other: those with the smaller"},
    {kMotionBeginsBefore, "motion-begins-before", {{"apart_s", 0.25}}, "before the signal does: a long contact, or a blow for a"},
    {kMotionBeginsAfter, "motion-begins-after", {{"apart_s", 0.25}}, "after the signal does: a long contact, or a blow for a"},
    {kRecordOfAnother, "record-of-another", {{"ratio", 0.25}}, "times what its own ring-down leaves: its load, case or mass"},
    {kSpringStiffens, "spring-stiffens", {{"share", 0.25}, {"deviations", 3}}, "times its uncertainty): the spring stiffens with travel,"},
    {kSpringSoftens, "spring-softens", {{"share", 0.25}, {"deviations", 3}}, "times its uncertainty): the spring softens with travel, and"},
    {kFrictionSlows, "friction-slows", {{"share", 0.25}, {"deviations", 3}}, "times its uncertainty): dry friction slows small motions"},
    {kDampingGrows, "damping-grows", {{"share", 0.25}, {"deviations", 3}}, "times its uncertainty): the damping grows with travel or"},
    {kFrequenciesScatter, "frequencies-scatter", {{"birge_ratio", 0.25}}, "times as much as their noise explains (Birge ratio): the"},
    {kDecaysScatter, "decays-scatter", {{"birge_ratio", 0.25}}, "times as much as their noise explains (Birge ratio): the"},
    {kResidualsCorrelated, "residuals-correlated", {}, "the residuals follow each other: a second resonance, a"},
    {kOutlyingPoint, "outlying-point", {{"frequency_hz", 0.25}, {"spread", 0.25}}, "times the others' spread off the model: is it a slip? All"},
    {kUnusualFrequency, "unusual-frequency", {{"natural_frequency_hz", 0.25}}, "is unusual: are the times in ms or us, or the frequencies"},
    {kUnusualQuality, "unusual-quality", {{"quality_factor", 0.25}}, "is unusual: is it one resonance's ring-down or impedance?"},
    {kUnusualForceConstant, "unusual-force-constant", {{"force_constant_n_per_a", 0.25}}, "is unusual: check the units, the mass and the drop height"},
    {kUnusualMovingMass, "unusual-moving-mass", {{"moving_mass_kg", 0.25}}, "is unusual: was it meant in g or mg?"},
    {kUnusualCaseMass, "unusual-case-mass", {{"case_mass_kg", 0.25}}, "is unusual: was it meant in g or mg?"},
    {kUnusualAdapterMass, "unusual-adapter-mass", {{"mass_kg", 0.25}}, "is unlike an adapter's: was it meant in g or mg?"},
    {kUnusualResistance, "unusual-resistance", {{"resistance_ohm", 0.25}}, "is unusual: is the magnitude in kohm or mohm?"},
    {kUnusualVoltage, "unusual-voltage", {{"peak_v", 0.25}}, "is unusual: is the column in mV or uV?"},
    {kUnusualHeight, "unusual-height", {{"drop_height_m", 0.25}}, "is unusual: was it meant in mm?"},
    {kUnusualAmplitude, "unusual-amplitude", {{"amplitude_m", 0.25}}, "is unusual: is the column in mm or um?"},
    {kUnusualSkinStiffness, "unusual-skin-stiffness", {{"stiffness_n_per_m", 0.25}}, "is unlike skin's: check the units of displacement and drive"},
    {kUnusualSkinDamping, "unusual-skin-damping", {{"damping_n_s_per_m", 0.25}}, "is unlike skin's: check the units of displacement and drive"},
    {kUnusualDrive, "unusual-drive", {{"current_a", 0.25}, {"voltage_v", 0.25}}, "is unusual: is the column in mA or mV?"},
    {kUnusualFrequencies, "unusual-frequencies", {{"lowest_hz", 0.25}, {"highest_hz", 0.25}}, "are unlike a haptic sweep's: are they in kHz?"},
    {kResistanceAsStated, "resistance-as-stated", {}, "the sweep does not determine R: it is taken as stated"},
    {kInductanceBelow, "inductance-below", {{"at_most_h", 0.25}}, "(95 %), which does not affect the constants; points at 1 to"},
    {kSweepTooCoarse, "sweep-too-coarse", {{"constants", std::string("f0, R")}, {"near", 3}, {"points", 3}, {"step_hz", 0.25}}, "points lie within the resonance's width, measure ten there"},
    {kResonanceOutside, "resonance-outside", {{"natural_frequency_hz", 0.25}}, ", lies outside of the sweep"},
    {kResistanceDiffers, "resistance-differs", {{"fitted_ohm", 0.25}, {"stated_ohm", 0.25}}, "are stated: a series resistor, leads, or a warm coil (+0.39"},
    {kPolarityTurned, "polarity-turned", {}, "the coil's polarity is free: the phases are turned by 180"},
    {kKsNotDetermined, "ks-not-determined", {}, "Ks: damping or mass dominates the motion at these"},
    {kBsNotDetermined, "bs-not-determined", {}, "Bs: the sweep shows no width of a resonance; more points"},
    {kSkinMassNotDetermined, "skin-mass-not-determined", {}, "m: inertia is small beside stiffness and damping; sweep"},
    {kFarOffModel, "far-off-model", {{"share", 0.25}}, "off the model: is it this actuator, are amplitude and drive"},
    {kBeyondStated, "beyond-stated-uncertainty", {{"ratio", 0.25}}, "times their stated uncertainties off the model"},
    {kNegativeMass, "negative-mass", {{"mass_kg", 0.25}}, "is negative: is the case's mass stated too large?"},
    {kSecondSolution, "second-solution", {{"stiffness_n_per_m", 0.25}, {"damping_n_s_per_m", 0.25}, {"mass_kg", 0.25}}, "fit nearly as well: measure the phase against the drive, or"},
    {kOneSideHeld, "one-side-held", {}, "one side is held, and the given mass is all that rings on"},
    {kTimeBaseExact, "time-base-exact", {}, "the time base is taken as exact: 100 ppm of it are 200 ppm"},
    {kBaBelow, "ba-below", {{"at_most_n_s_per_m", 0.25}}, "(95 %); a longer record or a stronger tap would show the"},
    {kDampingChangesLater, "damping-changes-later", {{"share", 0.25}, {"skipped_s", 0.25}}, "are left out: a joint rubs, or the air or the mount takes"},
    {kStiffnessChangesLater, "stiffness-changes-later", {{"share", 0.25}, {"skipped_s", 0.25}}, "are left out: a spring that is not linear at this"},
    {kManyImpacts, "many-impacts", {{"impacts", 3}}, "impacts were cut off: several small ones in a row are"},
};

std::string Said(const Case& found) {
  return document::Fill(SentenceOf(found.kind).text, found.numbers);
}

TEST(FitFindings, EachKindHasItsNameAndItsSentence) {
  std::set<std::string_view> names;
  for (const Case& found : kCases) {
    EXPECT_EQ(SentenceOf(found.kind).kind, found.name);
    EXPECT_TRUE(names.insert(found.name).second) << found.name << " stands twice";
    EXPECT_THAT(Said(found), HasSubstr(found.said));
    EXPECT_THAT(Said(found), Not(HasSubstr("(not known)"))) << "a number is missing";
    EXPECT_THAT(Said(found), Not(::testing::EndsWith("."))) << found.name;
  }
  EXPECT_EQ(kCases.size(), static_cast<std::size_t>(kManyImpacts) + 1) << "all kinds";
}

TEST(FitFindings, NumbersStandInTheUnitsThatPeopleSay) {
  EXPECT_THAT(Said({kKmTimesSpeedOnly, "", {{"product_v", 0.442}}, ""}),
              HasSubstr("Km x impact speed = 442 mV"));
  EXPECT_THAT(Said({kUnusualMovingMass, "", {{"moving_mass_kg", 1.4}}, ""}),
              HasSubstr("a moving mass of 1400 g"));
  EXPECT_THAT(Said({kDryFriction, "", {{"share", 0.0016}}, ""}), HasSubstr("friction of 0.16 %"));
}

// of a voltage and of a displacement, and of a channel without a unit
TEST(FitFindings, AnAmplitudeStandsInItsUnitOrNotAtAll) {
  EXPECT_EQ(Said({kHum, "", {{"frequency_hz", 50.0}, {"amplitude_v", 1e-3}}, ""}),
            "hum of 50 Hz, 1 mV: fitted along");
  EXPECT_EQ(Said({kHum, "", {{"frequency_hz", 50.0}, {"amplitude_m", 2e-6}}, ""}),
            "hum of 50 Hz, 2 um: fitted along");
  EXPECT_EQ(Said({kHum, "", {{"frequency_hz", 50.0}, {"amplitude", 2e-6}}, ""}),
            "hum of 50 Hz: fitted along");
}

}  // namespace
}  // namespace haptometer::fit
