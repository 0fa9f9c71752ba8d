#include "tools/document/findings_fit.h"

namespace haptometer::fit {

document::Sentence SentenceOf(FindingKind kind) {
  using enum FindingKind;
  static constexpr document::KindSentence<FindingKind> kSentences[] = {
      // reading of the file and preparation of the record
      {kHeaderKeyUnknown, "header-key-unknown",
       "header key {key} is not known; did you mean {nearest}?"},
      {kSeveralDrops, "several-drops", "{drops} drops in one record, each fitted separately"},
      {kHeightOfFirstDrop, "height-of-first-drop",
       "the drop height is used for the first drop only"},
      {kTooFewDrops, "too-few-drops",
       "{good} of its {drops} drops could be fitted, too few for a file of drops: not used"},
      // reduced, clipped or interrupted records
      {kThinned, "averaged",
       "{samples} samples, averaged over {block} at a time[; {clipped} at the recorder's limits "
       "are excluded]"},
      {kClipped, "clipped",
       "clipped: {samples} sample{samples s} at the recorder's limits excluded"},
      {kLaterImpact, "later-impact",
       "an impact at {at_s}[, {amplitude_v} against a ringing of {ringing_v}][, {amplitude_m} "
       "against a ringing of {ringing_m}]: the part {kept} it is fitted"},
      {kQuantisedTail, "quantised-tail",
       "a tail below one step of the converter[, {step_v}][, {step_m}]: excluded from {from_s} "
       "on"},
      // effects that are included in the fit, or limit the part that is fitted
      {kDryFriction, "dry-friction",
       "dry friction of {share %} of the spring's force at the first swing: included in the fit"},
      {kHum, "hum", "hum of {frequency_hz}[, {amplitude_v}][, {amplitude_m}]: included in the fit"},
      {kDrift, "drift",
       "a drift[ of {amplitude_v}][ of {amplitude_m}] over the record: included in the fit"},
      {kSlowRest, "slow-rest",
       "slow motion[ of {amplitude_v}][ of {amplitude_m}] that is no straight line remains and may "
       "move the constants by more than their intervals: record without it, or fit less "
       "(--window)"},
      {kOtherMode, "other-mode",
       "a single decaying oscillation does not explain {unexplained_share %} of the power: there "
       "is "
       "another mode or a slow tail"},
      {kHeightWithoutImpact, "height-without-impact",
       "no quiet part before the impact (16 samples and a quarter of a period) shows when it "
       "begins "
       "and how long it lasts: the drop height is not used"},
      {kCurrentWithoutRelease, "current-without-release",
       "no quiet part before it: the released current is not used"},
      {kHeightOfFirstImpact, "height-of-first-impact",
       "the part behind a later impact is fitted, and the drop height is that of the first: not "
       "used"},
      {kHeightOfLongImpact, "height-of-long-impact",
       "the impact may last longer than {longest_s}, the longest that is looked for[ (at least "
       "{shortest_s})], and leaves an unknown share of the speed: the drop height is not used; let "
       "it fall on something harder"},
      {kReleaseBehindSlow, "release-behind-slow",
       "an oscillation begins during a slow change at {at_s}: fitted from {from_s} on"},
      {kDownweighted, "downweighted",
       "{samples} of {of} samples are outlying and have less than half the weight"},
      {kNotQuietBefore, "not-quiet-before",
       "the record before the impact has a larger RMS than the residual: it is not used as noise"},
      // assumptions where the command line states nothing
      {kOpenAssumed, "open-assumed", "open circuit: no load is stated"},
      {kHeldAssumed, "held-assumed",
       "the case was held: neither --held nor --free is given, and records of one kind cannot "
       "show it; with a free case, Kv and Bv would be smaller by the factor Mc/(Mv+Mc)[: "
       "{ratio} times, and a Km from two loads {root_ratio} times]"},
      {kInductanceAssumedZero, "inductance-assumed-zero",
       "coil inductance 0: none is given; a coil of 130 uH and 27 ohm changes Kv by 0.003 %"},
      {kVoltageScaleExact, "voltage-scale-exact",
       "the uncertainty of the recorder's voltage scale is neglected (--voltage-scale states "
       "it): 1 % of it changes Km by 1 %"},
      {kReboundStated, "rebound",
       "impact speed (1 + e) sqrt(2 g h) with g = 9.80665 m/s^2 and rebound e = {rebound}[ +- "
       "{standard_uncertainty}]"},
      {kReboundAssumed, "rebound-assumed",
       "impact speed (1 + e) sqrt(2 g h) with g = 9.80665 m/s^2 and rebound e = {rebound} +- "
       "{standard_uncertainty}: no --rebound is stated, 0 to 0.3 is assumed"},
      // duration of the impact and the correction of Km by the drop height for it
      {kContactUnseen, "contact-unseen",
       "the impact is assumed to be short, because so damped a motion does not show its duration: "
       "a contact of 0.5 ms makes Km by the height {share %} too small"},
      {kContactAtMost, "contact-at-most",
       "the impact may last up to {longest_s}, which makes Km by the height up to {share %} too "
       "small; its interval includes that"},
      {kContactCorrected, "contact-corrected",
       "the impact lasts {shortest_s} to {longest_s}, as a half sine of force; Km by the height "
       "is corrected for it, by {share %}"},
      // which of the two evaluations of Km is used
      {kKmByLoads, "km-by-loads",
       "Km is determined from the loads' damping; from the drop height it would be "
       "{other_n_per_a} +- {half_interval_n_per_a} (95 %)[, |E_n| = {normalized_error}: the two "
       "contradict each "
       "other; check the drop height, the rebound, the loads and the masses]"},
      {kKmByHeight, "km-by-height",
       "Km is determined from the drop height and the loads; from the loads alone it is "
       "{other_n_per_a} +- {half_interval_n_per_a} (95 %)[, |E_n| = {normalized_error}: the two "
       "contradict each "
       "other; check the drop height, the rebound, the loads and the masses]"},
      {kRobustLoss, "robust-loss",
       "robust fit (Huber loss): beyond {bend} times the residuals' scale a sample has a "
       "constant influence"},
      // constants that the records do not determine, and what would
      {kMassMissing, "mass-missing",
       "Kv and Bv, and Km of an impedance sweep, are determined over the mass only: state "
       "--moving-mass 1.4g"},
      {kMassesMissing, "masses-missing",
       "Kv and Bv, and Km of an impedance sweep, are determined over the mass only: state "
       "--moving-mass 1.4g and --case-mass 0.6g"},
      // damping Bv and force constant Km, which share the measured decay
      {kNoDecay, "no-decay",
       "Bv and Q are not determined: the record shows no decay beyond its uncertainty; record "
       "at least three decay times of one free ring-down"},
      {kDampingsTogether, "dampings-together",
       "Bv and Km: only (Bv + Km^2/(R+RL))/M = {sum_per_s} is determined; record an open "
       "circuit too"},
      {kDampingsWithoutResistance, "dampings-without-resistance",
       "Bv and Km: only (Bv + Km^2/(R+RL))/M = {sum_per_s} is determined; record an open "
       "circuit too, or state the coil's --resistance"},
      {kDampingsWithoutHeight, "dampings-without-height",
       "Bv and Km: only (Bv + Km^2/(R+RL))/M = {sum_per_s} is determined; record an open "
       "circuit too, or state the --drop-height and the coil's --resistance"},
      {kKmOfDisplacement, "km-of-displacement",
       "Km: a displacement does not show it; record the voltage, with and without a load"},
      {kKmOfReleaseWithoutMass, "km-of-release-without-mass",
       "Km: a voltage after a released current shows only Km^2/M; state --moving-mass"},
      {kKmTimesSpeedOnly, "km-times-speed-only",
       "Km: an open circuit shows only Km x impact speed = {product_v}; state the drop height "
       "(--drop-height), or record again with 27 to 50 ohm across the terminals"},
      {kKmTimesUnusedSpeed, "km-times-unused-speed",
       "Km: an open circuit shows only Km x impact speed = {product_v}, and the stated drop height "
       "is not used; record again such that it can be, or with 27 to 50 ohm across the terminals"},
      {kKmLostInDamping, "km-lost-in-damping",
       "Km: the change of the damping by these loads is within its uncertainty, or the mass or "
       "the coil's resistance is missing; state those, or record with 27 to 50 ohm across the "
       "terminals"},
      // contradictions between records
      {kSmallerLoadDecaysSlower, "smaller-load-decays-slower",
       "the records contradict each other: those with the smaller load decay more slowly, as no "
       "coil does: are files or loads exchanged? Do not use Bv and Km"},
      {kMotionBeginsBefore, "motion-begins-before",
       "the motion would begin {apart_s} before the signal does: a long contact, or an impact "
       "stated as a released current or the reverse; do not use Km by height or current"},
      {kMotionBeginsAfter, "motion-begins-after",
       "the motion would begin {apart_s} after the signal does: a long contact, or an impact "
       "stated as a released current or the reverse; do not use Km by height or current"},
      {kRecordOfAnother, "record-of-another",
       "its residual in the fit of all records is {ratio} times that of its own fit: its load, "
       "case or mass is not as stated, or it is of another actuator; do not use the constants"},
      {kFrequencyOfAnother, "frequency-of-another",
       "its resonance differs by {share %} from that of the other records, more than 2 %: its case "
       "or mass is not as stated, or it is of another actuator; do not use the constants"},
      {kDecayOfAnother, "decay-of-another",
       "its decay differs by {share %} from that of the other records with its load, more than "
       "20 %: its load or mounting is not as stated, or it is of another actuator; do not use the "
       "constants"},
      // dependence on the amplitude: spring, friction and damping that are not linear
      {kSpringStiffens, "spring-stiffens",
       "one decay time later the resonance differs by {share %} ({deviations} times its "
       "uncertainty): the spring stiffens with travel, and Kv is an average over this ring-down"},
      {kSpringSoftens, "spring-softens",
       "one decay time later the resonance differs by {share %} ({deviations} times its "
       "uncertainty): the spring softens with travel, and Kv is an average over this ring-down"},
      {kFrictionSlows, "friction-slows",
       "one decay time later the decay differs by {share %} ({deviations} times its "
       "uncertainty): dry friction slows small motions more, and Bv is an average over this "
       "ring-down"},
      {kDampingGrows, "damping-grows",
       "one decay time later the decay differs by {share %} ({deviations} times its "
       "uncertainty): the damping grows with travel or speed, and Bv is an average over this "
       "ring-down"},
      // scatter that the noise does not explain
      {kFrequenciesScatter, "frequencies-scatter",
       "the drops' stiffnesses scatter by {scatter %}, their resonances {birge_ratio} times as "
       "much as their noise explains (Birge ratio): the uncertainties of Kv and f0 contain that, "
       "their intervals Student's factor too (degrees of freedom: {degrees_of_freedom})"},
      {kDecaysScatter, "decays-scatter",
       "the drops' dampings scatter by {scatter %}, their decays {birge_ratio} times as much as "
       "their noise explains (Birge ratio): the uncertainties of Bv, Km and Q contain that, their "
       "intervals Student's factor too (degrees of freedom: {degrees_of_freedom})"},
      {kResidualsCorrelated, "residuals-correlated",
       "the residuals are correlated: a second resonance, a spring that is not linear, losses "
       "of the coil that grow with frequency, or another actuator's constants; the intervals "
       "are too narrow then"},
      {kOutlyingPoint, "outlying-point",
       "the point at {frequency_hz} differs from the model by {spread} times the others' "
       "spread: is it an error? It biases all constants"},
      {kFollowsOnePoint, "follows-one-point",
       "the constants follow the point at {frequency_hz} alone: without it Kv is {stiffness_ratio} "
       "times, Bv {damping_ratio} times and Km {force_constant_ratio} times as large: measure it "
       "again, with more points beside it, or leave it out"},
      // values outside the usual range, mostly an error of unit
      {kUnusualFrequency, "unusual-frequency",
       "a resonance of {natural_frequency_hz} is unusual: are the times in ms or us, or the "
       "frequencies in kHz or rad/s?"},
      {kUnusualQuality, "unusual-quality",
       "a quality factor of {quality_factor} is unusual: is it one resonance's ring-down or "
       "impedance?"},
      {kUnusualForceConstant, "unusual-force-constant",
       "a force constant of {force_constant_n_per_a} is unusual: check the units, the mass and "
       "the drop height"},
      {kUnusualMovingMass, "unusual-moving-mass",
       "a moving mass of {moving_mass_kg} is unusual: was it meant in g or mg?"},
      {kUnusualCaseMass, "unusual-case-mass",
       "a case mass of {case_mass_kg} is unusual: was it meant in g or mg?"},
      {kUnusualAdapterMass, "unusual-adapter-mass",
       "a mass of {mass_kg} is unusual for an adapter: was it meant in g or mg?"},
      {kNoDisplacement, "no-displacement",
       "the channel is in {unit} and no displacement: of a sensor's output the constants are the "
       "same, of a coil's voltage they are the actuator's; give a --calibration, or a recording of "
       "the displacement"},
      {kUnusualResistance, "unusual-resistance",
       "a coil of {resistance_ohm} is unusual: is the magnitude in kohm or mohm?"},
      {kUnusualVoltage, "unusual-voltage",
       "a largest voltage of {peak_v} is unusual: is the column in mV or uV?"},
      {kUnusualHeight, "unusual-height",
       "a drop height of {drop_height_m} is unusual: was it meant in mm?"},
      {kUnusualAmplitude, "unusual-amplitude",
       "an amplitude of {amplitude_m} is unusual: is the column in mm or um?"},
      // skin: Ks in N/m and Bs in N s/m
      {kUnusualSkinStiffness, "unusual-skin-stiffness",
       "Ks of {stiffness_n_per_m} is unusual for skin: check the units of displacement and drive"},
      {kUnusualSkinDamping, "unusual-skin-damping",
       "Bs of {damping_n_s_per_m} is unusual for skin: check the units of displacement and drive"},
      {kUnusualDrive, "unusual-drive",
       "a drive of[ {current_a}][ {voltage_v}] is unusual: is the column in mA or mV?"},
      {kUnusualFrequencies, "unusual-frequencies",
       "frequencies from {lowest_hz} to {highest_hz} are unusual for a haptic sweep: are they "
       "in kHz?"},
      // impedance sweep
      {kResistanceAsStated, "resistance-as-stated",
       "the sweep does not determine R: the stated value is used"},
      {kInductanceBelow, "inductance-below",
       "L: it is below {at_most_h} (95 %), which does not affect the constants; points at 1 to "
       "10 kHz would determine it"},
      {kSweepTooCoarse, "sweep-too-coarse",
       "{constants}: the sweep determines them to worse than 25 %; {near} of {points} points "
       "lie within the resonance's width: measure ten there (steps of {step_hz}) and some an "
       "octave away on both sides"},
      {kResonanceOutside, "resonance-outside",
       "the resonance, {natural_frequency_hz}, lies outside of the sweep"},
      {kResistanceDiffers, "resistance-differs",
       "the sweep gives R = {fitted_ohm}, and {stated_ohm} are stated: a series resistor, "
       "leads, or a warm coil (+0.39 %/K)?"},
      {kPolarityTurned, "polarity-turned",
       "the coil's polarity is arbitrary: the phases are changed by 180 degrees"},
      // skin in contact with an actuator: Ks, Bs and m
      {kKsNotDetermined, "ks-not-determined",
       "Ks: damping or mass dominates the motion at these frequencies; sweep lower, and measure "
       "the phase against the current"},
      {kBsNotDetermined, "bs-not-determined",
       "Bs: the sweep does not show the width of a resonance; measure more points around the "
       "largest amplitude, or the phase against the current"},
      {kSkinMassNotDetermined, "skin-mass-not-determined",
       "m: inertia is small compared with stiffness and damping; sweep higher, where w^2 (Mc + "
       "m) exceeds w Bs"},
      {kFarOffModel, "far-off-model",
       "the amplitudes differ from the model by {share %}: is it this actuator, are amplitude "
       "and drive both peak or both RMS, does the contact break?"},
      {kBeyondStated, "beyond-stated-uncertainty",
       "the amplitudes differ from the model by {ratio} times their stated uncertainties"},
      {kNegativeMass, "negative-mass",
       "an effective mass of {mass_kg} is negative: is the case's mass stated too large?"},
      {kSecondSolution, "second-solution",
       "Ks {stiffness_n_per_m}, Bs {damping_n_s_per_m}, m {mass_kg} fit nearly as well: measure "
       "the phase against the drive, or sweep further"},
      // ring-down of an adapter: Ka and Ba
      {kOneSideHeld, "one-side-held",
       "one side is held, and the given mass is all that rings on the spring (about a third of "
       "the spring's own mass counts)"},
      {kTimeBaseExact, "time-base-exact",
       "the uncertainty of the time base is neglected: 100 ppm of it are 200 ppm of Ka"},
      {kKaNotDetermined, "ka-not-determined",
       "Ka: the uncertainty of its frequency exceeds 25 %; a longer record or a stronger tap "
       "would determine it"},
      {kBaBelow, "ba-below",
       "Ba: it is below {at_most_n_s_per_m} (95 %); a longer record or a stronger tap would "
       "show the decay"},
      // later parts of the ring-down against all of it
      {kDampingChangesLater, "damping-changes-later",
       "Ba changes by {share %} when the first {skipped_s} are excluded: a joint rubs, or the "
       "air or the mount takes energy"},
      {kStiffnessChangesLater, "stiffness-changes-later",
       "Ka changes by {share %} when the first {skipped_s} are excluded: a spring that is not "
       "linear at this amplitude; tap more softly"},
      {kManyImpacts, "many-impacts",
       "{impacts} impacts were excluded: several small ones in a row are usually a spring that "
       "is not linear at this amplitude, or a joint that rubs; tap more softly"},
      {kTapsScatter, "taps-scatter",
       "{constant} of the taps scatters {birge_ratio} times as much as their noise explains (Birge "
       "ratio): its weights and its uncertainty contain that scatter, its interval Student's "
       "factor "
       "too (degrees of freedom: {degrees_of_freedom})"},
      {kPointsWrittenTwice, "points-written-twice",
       "{copies} of {points} points repeat another one to all digits, as if they were written "
       "twice: each counts once"},
  };
  return document::SentenceIn(kSentences, kind);
}

}  // namespace haptometer::fit
