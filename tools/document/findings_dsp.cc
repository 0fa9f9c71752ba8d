#include "tools/document/findings_dsp.h"

#include <algorithm>
#include <array>

#include "base/error.h"

namespace haptometer::document {
namespace {

// a namespace of its own, since other modules have kinds of the same names
namespace dsp_sentences {

struct Row {
  dsp::FindingKind kind;
  Sentence sentence;
};

using enum dsp::FindingKind;

constexpr auto kRows = std::to_array<Row>({
    // readings
    {kExcluded,
     {"readings-excluded", "{excluded} of {readings} readings are excluded ({statuses})"}},
    {kRepeated,
     {"readings-repeated",
      "{repeated} of {readings} readings are repeated: the sensor had no new value"}},
    {kInterpolated,
     {"readings-interpolated",
      "{interpolated} reading{interpolated s} interpolated, which adds {rms_m} RMS at most"}},
    {kClipped,
     {"clipped",
      "clipped in {count} place{count s}, {readings} readings in all, the first at {first_s}; "
      "not corrected"}},
    {kMayBeClipped,
     {"may-be-clipped",
      "{share %} of the window is at its highest or lowest value: clipped, or flattened by "
      "harmonics of the tone, which this sampling rate cannot distinguish"}},
    {kHeld,
     {"held",
      "a held reading in {count} place{count s}, {readings} readings in all, the first at "
      "{first_s} ({size_m}); excluded where they are short"}},
    {kNoReadingCodes,
     {"no-reading-codes",
      "{value_m} is a code for no reading: {readings} reading{readings s} excluded"}},
    {kSpikes,
     {"spikes",
      "{count} spike{count s}, {readings} readings in all, the first at {first_s} ({size_m}); "
      "excluded"}},
    {kSteps, {"steps", "{count} step{count s}, the first at {first_s} ({size_m}); not corrected"}},
    {kStuck,
     {"stuck",
      "all {readings} readings are the same: a stuck sensor, held readings, or steps coarser "
      "than the motion; check its hold, its target and its range, and record again"}},
    {kStuckInWindow,
     {"stuck-in-window",
      "in the {window_s} from {from_s} on only {changes} of {readings} readings differ from the "
      "one before, fewer than vibration at {lower_hz} makes: a stuck sensor, held readings, or "
      "steps coarser than the motion; check its hold, its target and its range, and record again"}},
    {kNoMeasurement, {"no-measurement", "none of its readings is a measurement"}},
    {kFarReadings,
     {"far-readings",
      "readings reach {farthest_m}, farther than any displacement sensor: is the column in mm, "
      "um or V? Name it (--columns time_s,displacement_mm) or state what one printed unit is "
      "(--scale 1mm)"}},
    {kSegments,
     {"segments", "gaps split the record into {segments} segments; the window is in one of them"}},
    {kLongestSegment,
     {"longest-segment", "gaps split the record into {segments} segments; the longest is used"}},
    {kSamplesLimited, {"samples-limited", "only the first {used} of {samples} samples are used"}},
    {kSegmentEnds,
     {"segment-ends",
      "filter transients excluded: the first {first_s} and the last {last_s} of a segment of "
      "{segment_s}"}},
    {kAveragingUnknown,
     {"averaging-unknown",
      "amplitude not verified: sensor averaging unknown; state it in the header of a CSV, as '# "
      "averages = 16' and '# sampling_s = 0.00033' (haptometer trial export FILE -o OUT.csv makes "
      "one of any trial)"}},
    // rate and times
    {kTooFewReadings,
     {"too-few-readings",
      "{new_readings_per_s SI} new readings/s show vibration up to {observable_hz}; {lower_hz} "
      "to {upper_hz} need {needed_per_s SI} readings/s: use a free-running output, or the analog "
      "output and a DAQ"}},
    {kTimesUncertain,
     {"times-uncertain",
      "each reading's time is uncertain by {time_uncertainty_s}; motion at {upper_hz} needs less "
      "than {limit_s}: use a sensor that samples on a clock of its own"}},
    {kFewUnevenTimes,
     {"few-uneven-times", "{rows} rows at non-uniform times are too few: record longer"}},
    {kTimesTooUneven,
     {"times-too-uneven",
      "the times of its readings scatter by {jitter_s} about a grid of {grid_s}, up to "
      "{largest_jitter_s}: dropped readings cannot be distinguished from late ones: record with a "
      "clocked "
      "source"}},
    {kReadingsTooFarApart,
     {"readings-too-far-apart",
      "its readings at non-uniform times are too far apart for motion at {upper_hz}: "
      "{readings_per_s SI} readings/s: "
      "choose a lower band, or record with a clocked source"}},
    {kRegularGrid,
     {"regular-grid",
      "times scatter by {jitter_s} ({largest_jitter_s} at most) about a grid of {readings_per_s "
      "SI} readings/s: {readings} readings assigned to it, {missing} missing, {excluded} excluded; "
      "this adds {error} of a tone at most"}},
    {kSamplingContradicted,
     {"sampling-contradicted",
      "the file states a sampling period of {sampling_s}, {samples_per_s SI} samples/s, and holds "
      "{new_readings_per_s SI} new readings/s: one of the two is wrong, and the sensor's gain is "
      "computed from the first"}},
    {kTimesInOtherUnit,
     {"times-in-other-unit",
      "as {column}, the times would give {readings_per_s SI} readings/s over {duration_s}; if that "
      "is right, name the column: --columns {column},displacement_m"}},
    {kPolledTimes,
     {"polled-times",
      "the age of its readings is unknown, so that no tone of known frequency is fitted either"}},
    {kTimesUnfitForTone,
     {"times-unfit-for-tone",
      "times are uncertain by {time_uncertainty_s}; a fit at {frequency_hz} needs less than "
      "{limit_s}"}},
    // a record too slow for the band, fitted at the known frequency of the drive
    {kKnownTone,
     {"known-tone",
      "if the motion is a tone at {frequency_hz}, its amplitude is {amplitude_m}; no answer for "
      "the band"}},
    {kKnownToneAlias,
     {"known-tone-alias",
      "if the motion is a tone at {frequency_hz}, its amplitude is {amplitude_m}, measured as an "
      "alias together with all other motion there; no answer for the band"}},
    {kKnownTonePauses,
     {"known-tone-pauses",
      "the tone at {frequency_hz} has pauses: it is fitted in its longest part, {from_s} to "
      "{to_s}"}},
    {kKnownToneAtRate,
     {"known-tone-at-rate",
      "a tone at {frequency_hz} cannot be distinguished from the offset at this rate"}},
    // filter
    {kOrderLowered,
     {"order-lowered",
      "filter order lowered from {asked_order} to {order}: at order {asked_order} only {settled_s} "
      "are free of filter transients"}},
    {kTooShort,
     {"too-short",
      "only {settled_s} of it are free of the transients of a filter of order {order}; {needed_s} "
      "are needed[, and a lower order passes too much of the motion below {lower_hz}]: record at "
      "least {record_s} without a gap"}},
    {kBelowBand,
     {"below-band",
      "component below the band: amplitude {amplitude_m} at {frequency_hz}; its leakage into the "
      "band is {leaked_m} RMS"}},
    {kBelowBandModelled,
     {"below-band-modelled",
      "component below the band: amplitude {amplitude_m} at {frequency_hz}; its leakage into the "
      "band, {leaked_m} RMS, is modelled beyond both ends of the record and subtracted"}},
    // how a window was chosen
    {kAllSettled, {"all-settled", "all that is free of filter transients"}},
    {kWindowAsked, {"window-asked", "requested: {from_s} to {to_s}"}},
    {kSteadyDrive, {"steady-drive", "steady part of the drive"}},
    {kSettledOfDrive,
     {"settled-of-drive", "the part of the drive that is free of filter transients"}},
    {kWhereFrequencyMoves,
     {"where-frequency-moves", "where a vibration of changing frequency exceeds the noise"}},
    // the course of the drive
    {kTooShortForParts, {"too-short-for-parts", "too short to be split into parts"}},
    {kNothingStandsOut,
     {"nothing-stands-out", "no part of the {of} exceeds the rest for long enough"}},
    {kOneLevel,
     {"one-level", "the power of the {of} has one level: the drive is on throughout, or never"}},
    {kStandsOut,
     {"stands-out",
      "the RMS of the {of} is {ratio} times that of the rest, [in {parts} parts, the longest ]from "
      "{from_s} to {to_s}"}},
    {kToneNeverPauses, {"tone-never-pauses", "the tone has no pause: the drive is on throughout"}},
    {kOnlyTransients, {"only-transients", "only transients exceed the noise"}},
    {kSweepIsNoDrive,
     {"sweep-is-no-drive",
      "the frequency changes: the part that exceeds the noise is not taken as the drive"}},
    {kDriveOn, {"drive-on", "the drive is on from {from_s} to {to_s}"}},
    {kVibrationStandsOut,
     {"vibration-stands-out",
      "a vibration of {frequency_hz} and about {rms_m} RMS exceeds the noise from {from_s} to "
      "{to_s}"}},
    // what goes with them
    {kTransientsExcluded,
     {"transients-excluded",
      "{parts} part{parts s} of the record excluded as filter transients: no longer than the "
      "filter rings ({ringing_s}), with its rise and fall"}},
    {kLevelChanges,
     {"level-changes",
      "the vibration's level changes, but its tone has no pause: all of it is used"}},
    {kDriveTooShort,
     {"drive-too-short",
      "the drive is on from {from_s} to {to_s}; {settled_s} of it are free of filter transients "
      "and {needed_s} are needed: drive longer, or raise the band's lower corner; --window all "
      "also uses the record outside of it[, --window {window_from_s SI}s:{window_to_s SI}s its "
      "part free of transients]"}},
    {kDriveNotSettled,
     {"drive-not-settled",
      "the drive is on from {from_s} to {to_s}; {settled_s} of it are free of filter transients: "
      "drive longer, record longer before and after it, or choose a lower --order; --window all "
      "also uses the record outside of it[, --window {window_from_s SI}s:{window_to_s SI}s its "
      "part free of transients]"}},
    {kVibrationTooShort,
     {"vibration-too-short",
      "a vibration of {frequency_hz} and about {rms_m} RMS exceeds the noise from {from_s} to "
      "{to_s}; {settled_s} of it are free of filter transients and {needed_s} are needed: drive "
      "longer, or raise the band's lower corner; --window all also uses the record outside of it[, "
      "--window {window_from_s SI}s:{window_to_s SI}s its part free of transients]"}},
    {kVibrationNotSettled,
     {"vibration-not-settled",
      "a vibration of {frequency_hz} and about {rms_m} RMS exceeds the noise from {from_s} to "
      "{to_s}; {settled_s} of it are free of filter transients: drive longer, record longer before "
      "and after it, or choose a lower --order; --window all also uses the record outside of it[, "
      "--window {window_from_s SI}s:{window_to_s SI}s its part free of transients]"}},
    {kWindowMixed,
     {"window-mixed",
      "in {off_s} of the window's {window_s} the drive is off or changes; --window auto uses the "
      "steady part"}},
    {kDriveOffInWindow, {"drive-off-in-window", "the drive is off in the whole window"}},
    {kDriveUnsteady, {"drive-unsteady", "the amplitude changes by {drift %} over the drive"}},
    {kFrequencyMoves,
     {"frequency-moves",
      "the frequency changes from {from_hz} to {to_hz}: this is a sweep, and the RMS is that of "
      "all of it; use --sweep"}},
    // the requested or chosen window
    {kWindowOutside,
     {"window-outside",
      "the window {from_s} to {to_s} lies outside of the record, {record_from_s} to "
      "{record_to_s}"}},
    {kWindowNotSettled,
     {"window-not-settled",
      "only {settled_s} of the window {from_s} to {to_s} are free of filter transients: choose a "
      "wider one, or record longer before and after it"}},
    {kWindowShortened,
     {"window-shortened",
      "filter transients excluded: {excluded_s} of the window {from_s} to {to_s}"}},
    {kWindowClipped,
     {"window-clipped",
      "{share %} of the window is clipped, so that its RMS is a lower limit: move the sensor or "
      "choose a wider range"}},
    // noise floor
    {kNoFloor,
     {"no-floor",
      "noise floor not known, and not subtracted: no drive-off interval of 0.1 s or more outside "
      "the window; give a drive-off trial by --floor FILE"}},
    {kFloorOfOtherRate,
     {"floor-of-other-rate",
      "the floor has {floor_per_s SI} readings/s and this trial {readings_per_s SI}: a sensor's "
      "noise in the band depends on its rate; use a floor of the same settings"}},
    {kFloorHasTone,
     {"floor-has-tone",
      "the floor holds a tone, {amplitude_m} at {frequency_hz}: it is subtracted as noise; was "
      "the drive off?"}},
    {kFloorHasTheTone,
     {"floor-has-the-tone",
      "the floor holds a tone, {amplitude_m} at {frequency_hz}, as this trial does: it is "
      "subtracted as noise; was the drive off?"}},
    {kFloorAboveSignal,
     {"floor-above-signal",
      "the floor of {floor_m} is above the {measured_m} that were measured: record a floor with "
      "the same sensor, settings and rate, drive off"}},
    {kBelowFloor, {"below-floor", "below the noise floor of {floor_m}: at most {at_most_m}"}},
    // the numbers
    {kRmsTooLarge,
     {"rms-too-large",
      "{rms_m} RMS is more than any tactile actuator moves: is the column in another unit than it "
      "states? Name it (--columns time_s,displacement_um) or give --scale 1um"}},
    {kRmsTooSmall,
     {"rms-too-small",
      "{rms_m} RMS is less than any laser distance sensor resolves: is the column in another unit "
      "than it states?"}},
    // gain of the sensor's averaging
    {kGainInBand,
     {"gain-in-band",
      "the sensor's gain in the band is {least} to {greatest}; without a tone it is not corrected "
      "for"}},
    {kGainTooLow,
     {"gain-too-low",
      "the sensor's gain at {frequency_hz} is {gain}, below {least_gain}: set it to {averages} "
      "average{averages s} or fewer"}},
    {kGainCorrected, {"gain-corrected", "the sensor's gain at the tone is {gain}; corrected for"}},
    // voltage and current at the tone
    {kElectricalUnmeasured,
     {"electrical-unmeasured",
      "electrical state not determined: {readings} readings of voltage or current in the window "
      "are not measurements"}},
    {kElectricalNoTone,
     {"electrical-no-tone",
      "electrical state not determined: no voltage or no current exceeds the noise at "
      "{frequency_hz}"}},
    // sweeps
    {kSweepUneven,
     {"sweep-uneven", "the times of its readings are not uniform: a sweep needs a clocked record"}},
    {kSweepPolled,
     {"sweep-polled",
      "its readings are polled and of unknown age: a sweep needs a clocked record"}},
    {kSweepRateLimit,
     {"sweep-rate-limit",
      "not determined above {upper_hz}: {new_readings_per_s SI} new readings/s; record "
      "{needed_per_s SI} or more"}},
    {kSweepSensorLimit,
     {"sweep-sensor-limit",
      "not determined above {upper_hz}: the sensor's gain is below 0.5 there"}},
    {kDriveConstant, {"drive-constant", "the channel {channel} is constant; it is not a drive"}},
    {kDriveGaps, {"drive-gaps", "the channel {channel} has gaps; its longest segment is used"}},
    {kNoDriveChannel,
     {"no-drive-channel",
      "phase, coherence and amplitude per volt are not determined: there is no voltage or "
      "current channel"}},
    {kConstantDriveAssumed,
     {"constant-drive-assumed", "f0 and Q hold for a drive of constant amplitude"}},
    // response over frequency
    {kSweepTooShort,
     {"sweep-too-short",
      "{length_s} do not hold two segments of the response; record longer, or choose a resolution "
      "of {resolution_hz}"}},
    {kNoResponse, {"no-response", "the displacement shows no response to the drive"}},
    {kNoSweep,
     {"no-sweep",
      "no sweep found from {lower_hz} to {upper_hz}: no vibration whose frequency changes by a "
      "tenth, and by less than {resolution_hz} in {block_s}; try another --band, a --resolution "
      "above the root of the sweep's Hz/s, a slower sweep, or record the drive's voltage"}},
    {kFrequenciesExcluded,
     {"frequencies-excluded",
      "{excluded} of {frequencies} frequencies excluded: too little drive or too much noise "
      "there"}},
    // f0 and Q of one resonance
    {kResonanceAbove,
     {"resonance-above",
      "f0 and Q: no resonance with one degree of freedom between {from_hz} and {to_hz}; the "
      "largest amplitude lies at the upper end, {highest_hz}: the resonance may be above it; sweep "
      "further, with a wider --band"}},
    {kResonanceBelow,
     {"resonance-below",
      "f0 and Q: no resonance with one degree of freedom between {from_hz} and {to_hz}; the "
      "largest amplitude lies at the lower end, {highest_hz}: the resonance may be below it; sweep "
      "further, with a wider --band"}},
    {kPeakTooNarrow,
     {"peak-too-narrow",
      "f0 and Q: no resonance with one degree of freedom between {from_hz} and {to_hz}; the peak "
      "at {highest_hz} is no wider than the resolution of {resolution_hz}: sweep more slowly, or "
      "record the drive's voltage, with a smaller --resolution"}},
    {kNoResonance,
     {"no-resonance",
      "f0 and Q: no resonance with one degree of freedom between {from_hz} and {to_hz}; the "
      "largest amplitude lies at {highest_hz}: examine it with --plot or --response"}},
    {kSeveralResonances,
     {"several-resonances",
      "one resonance does not explain {left %} of the response: there may be more than one"}},
});

// one row for each kind
static_assert(kRows.size() == static_cast<std::size_t>(kSeveralResonances) + 1);

}  // namespace dsp_sentences

}  // namespace

Sentence SentenceOf(dsp::FindingKind kind) {
  using dsp_sentences::kRows;
  const auto found = std::ranges::find(kRows, kind, &dsp_sentences::Row::kind);
  HAPTOMETER_CHECK(found != kRows.end(), "finding {}", static_cast<int>(kind));
  return found->sentence;
}

std::string TextOf(const dsp::Finding& finding) {
  const std::string text = Fill(SentenceOf(finding.kind).text, finding.numbers);
  return finding.subject.empty() ? text : finding.subject + ": " + text;
}

std::vector<std::string> RefusalsOf(const dsp::Findings& findings) {
  std::vector<std::string> texts;
  for (const dsp::Finding& finding : findings.list()) {
    if (finding.severity == Severity::kRefusal) texts.push_back(TextOf(finding));
  }
  return texts;
}

std::string RefusalOf(const dsp::Findings& findings) {
  const std::vector<std::string> texts = RefusalsOf(findings);
  return texts.empty() ? std::string() : texts.front();
}

// averaging of the sensor in words: number of averages and sampling period, ms
std::string TextOf(const dsp::SensorAveraging& sensor) {
  const std::string held = sensor.repeats > 1
                               ? fmt::format(", each reading held for {} rows", sensor.repeats)
                               : std::string();
  if (sensor.knowledge == dsp::SensorKnowledge::kUnknown) return "averaging unknown" + held;
  if (sensor.averages == 1) return "no averaging" + held;
  return fmt::format("{} averages at {:g} ms{}", sensor.averages, sensor.sampling_s * 1e3, held);
}

// cause of an uncertainty component, and how it is evaluated (uncertainty.md)
CauseText TextOf(dsp::RmsCause cause) {
  constexpr std::array<CauseText, dsp::kRmsCauseCount> kTexts{{
      {"noise", "residual periodogram after subtraction of the sine fit"},
      {"noise floor", "scatter of the floor that is subtracted"},
      {"motion below the band", "its amplitude times |H|^2, as power and as a beat with the tone"},
      {"quantisation", "step / sqrt(12), white up to half the rate"},
      {"interpolated readings", "expanded error (k = 2) of what is interpolated"},
      {"filter's ends", "what lay beyond the ends, as far as it may still show"},
      {"drive's edges", "what a window shorter by a period at either end would change"},
      {"steps", "their energy within the band"},
  }};
  return kTexts.at(static_cast<std::size_t>(cause));
}

}  // namespace haptometer::document
