#include "tools/document/findings_dsp.h"

#include <array>
#include <iterator>

namespace haptometer::document {

Sentence SentenceOf(dsp::FindingKind kind) {
  using enum dsp::FindingKind;
  static constexpr KindSentence<dsp::FindingKind> kSentences[] = {
      // readings
      {kExcluded, "readings-excluded",
       "{excluded} of {readings} readings are missing or no measurement ({statuses})"},
      {kRepeated, "readings-repeated",
       "{repeated} of {readings} readings are repeated: the sensor had no new value"},
      {kInterpolated, "readings-interpolated",
       "{interpolated} reading{interpolated s} interpolated[, with an error of {rms_m} RMS in the "
       "window at most]"},
      {kClipped, "clipped",
       "clipped in {count} place{count s}, {readings} readings in all, the first at {first_s}; not "
       "corrected"},
      {kMayBeClipped, "may-be-clipped",
       "{share %} of the window is at its highest or lowest value: clipped, or a motion that rests "
       "or is flat there, which these samples do not distinguish"},
      {kLimited, "limited",
       "{share %} of the window lies at a limit[, {lowest_m 6} at its low end][, {highest_m 6} at "
       "its high end], with noise on it, and the tone would exceed it by {beyond_m} on average: an "
       "amplifier or an analog output saturates, and the RMS is too low, or the motion is held by "
       "a stop; check their ranges"},
      {kHeld, "held",
       "a held reading in {count} place{count s}, {readings} readings in all, the first at "
       "{first_s} ({size_m}); excluded where they are short"},
      {kNoReadingCodes, "no-reading-codes",
       "{value_m 6} is a code for no reading: {readings} reading{readings s} excluded"},
      {kSpikes, "spikes",
       "{count} spike{count s}, {readings} readings in all, the first at {first_s} ({size_m}); "
       "excluded"},
      {kSteps, "steps", "{count} step{count s}, the first at {first_s} ({size_m}); not corrected"},
      {kStuck, "stuck",
       "all {readings} readings are the same: a stuck sensor, held readings, or steps coarser than "
       "the motion; check its hold, its target and its range, and record again"},
      {kStuckInWindow, "stuck-in-window",
       "in the {window_s} from {from_s} on only {changes} of {readings} readings differ from the "
       "one before, fewer than vibration at {lower_hz} makes: a stuck sensor, held readings, or "
       "steps coarser than the motion; check its hold, its target and its range, and record again"},
      {kNoMeasurement, "no-measurement", "none of its readings is a measurement"},
      {kFarReadings, "far-readings",
       "read as it is named, the column reaches {farthest_m}, farther than any displacement "
       "sensor: is it in mm, um or V? Name the unit that it is in (--columns), or state the length "
       "of one printed unit (--scale)"},
      {kBeyondCalibrated, "beyond-calibrated",
       "{samples} of {readings} samples lie beyond the calibrated range, {least_m} to {most_m}, by "
       "{beyond_m} at most[, {widths} times its width: is the input in mV?], where the line was "
       "not "
       "measured: calibrate a wider range, or move the sensor"},
      {kSegments, "segments",
       "gaps split the record into {segments} segments; the window is in one of them"},
      {kLongestSegment, "longest-segment",
       "gaps split the record into {segments} segments; the longest is used"},
      {kSamplesLimited, "samples-limited", "only the first {used} of {samples} samples are used"},
      {kSegmentEnds, "segment-ends",
       "filter transients excluded: the first {first_s} and the last {last_s} of a segment of "
       "{segment_s}"},
      {kAveragingUnknown, "averaging-unknown",
       "amplitude not verified: sensor averaging unknown; state it by acquire --averaging 16 "
       "--sampling 0.33ms, in the calibration file, or in the header of a CSV, as '# averages = "
       "16' "
       "and '# sampling_s = 0.00033' (haptometer trial export FILE -o OUT.csv makes one of any "
       "trial)"},
      {kOtherDisplacements, "other-displacements",
       "the displacement {channel} is analysed, {others} not: --columns chooses, with - for the "
       "others"},
      // rate and times
      {kSourceIsSlower, "source-is-slower",
       "{share %} of the readings repeat the one before: the source gives {new_readings_per_s SI} "
       "new readings/s, fewer than the record's rate, and holds them, which reduces a tone at "
       "{frequency_hz} by {loss %}; not corrected: record at the source's own rate"},
      {kStraightLines, "straight-lines",
       "the readings lie on straight lines between {new_readings_per_s SI} new readings/s, as an "
       "export at a higher rate draws them, which reduces a tone at {frequency_hz} by {loss %}; "
       "not corrected: export at the source's own rate"},
      {kTooFewReadings, "too-few-readings",
       "{new_readings_per_s SI} new readings/s show vibration up to {observable_hz}; {lower_hz} to "
       "{upper_hz} need {needed_per_s SI} readings/s: use a free-running output, or the analog "
       "output and a DAQ"},
      {kTimesUncertain, "times-uncertain",
       "each reading's time is uncertain by {time_uncertainty_s}; motion at {upper_hz} needs less "
       "than {limit_s}: use a sensor that samples on a clock of its own"},
      {kFewUnevenTimes, "few-uneven-times",
       "{rows} rows at non-uniform times are too few: record longer"},
      {kTimesTooUneven, "times-too-uneven",
       "the times of its readings scatter by {jitter_s} about a grid of {grid_s}, up to "
       "{largest_jitter_s}: dropped readings cannot be distinguished from late ones: record with a "
       "clocked source"},
      {kReadingsTooFarApart, "readings-too-far-apart",
       "its readings at non-uniform times are too far apart for motion at {upper_hz}: "
       "{readings_per_s SI} readings/s: choose a lower band, or record with a clocked source"},
      {kRegularGrid, "regular-grid",
       "times scatter by {jitter_s} ({largest_jitter_s} at most) about a grid of {readings_per_s "
       "SI} readings/s: {readings} readings assigned to it, {missing} missing, {excluded} "
       "excluded; this adds {error} of a tone at most"},
      {kClockDrift, "clock-drift",
       "the clock of its times drifts: they go away by up to {drift_s} from uniform ones "
       "of {readings_per_s SI} readings/s; values are interpolated to the true times"},
      {kSamplingContradicted, "sampling-contradicted",
       "the file states a sampling period of {sampling_s}, {samples_per_s SI} samples/s, and holds "
       "{new_readings_per_s SI} new readings/s: one of the two is wrong, and the sensor's gain is "
       "computed from the first"},
      {kTimesInOtherUnit, "times-in-other-unit",
       "as {column}, the times would give {readings_per_s SI} readings/s over {duration_s}; if "
       "that is right, name the column of the times {column} (--columns), and the others as they "
       "are named now"},
      {kPolledTimes, "polled-times",
       "the age of its readings is unknown, so that no tone of known frequency is fitted either"},
      {kTimesUnfitForTone, "times-unfit-for-tone",
       "times are uncertain by {time_uncertainty_s}; a fit at {frequency_hz} needs less than "
       "{limit_s}"},
      // a record too slow for the band, fitted at the known frequency of the drive
      {kKnownTone, "known-tone",
       "if the motion is a tone at {frequency_hz}, its amplitude is {amplitude_m}; no answer for "
       "the band"},
      {kKnownToneAlias, "known-tone-alias",
       "if the motion is a tone at {frequency_hz}, its amplitude is {amplitude_m}, measured as an "
       "alias together with all other motion there; no answer for the band"},
      {kKnownTonePauses, "known-tone-pauses",
       "the tone at {frequency_hz} has pauses: it is fitted in its longest part, {from_s} to "
       "{to_s}"},
      {kKnownToneElsewhere, "known-tone-elsewhere",
       "a tone of {amplitude_m} at {better_hz} fits the readings better than the stated "
       "{frequency_hz}: state the drive's frequency to a part of 1 / duration (--drive-frequency)"},
      {kKnownToneAtRate, "known-tone-at-rate",
       "a tone at {frequency_hz} cannot be distinguished from the offset at this rate"},
      // filter
      {kOrderLowered, "order-lowered",
       "filter order lowered from {asked_order} to {order}: at order {asked_order} only "
       "{settled_s} are free of filter transients"},
      {kTooShort, "too-short",
       "only {settled_s} of it are free of the transients of a filter of order {order}; {needed_s} "
       "are needed[, and a lower order passes too much of the motion below {lower_hz}]: record at "
       "least {record_s} without a gap"},
      {kBelowBand, "below-band",
       "component below the band: amplitude {amplitude_m} at {frequency_hz}; its leakage into the "
       "band is {leaked_m} RMS"},
      {kBelowBandModelled, "below-band-modelled",
       "component below the band: amplitude {amplitude_m} at {frequency_hz}; its leakage into the "
       "band, {leaked_m} RMS, is modelled beyond both ends of the record and subtracted"},
      // how a window was chosen
      {kAllSettled, "all-settled", "all that is free of filter transients"},
      {kWindowAsked, "window-asked", "requested[: {from_s} to {to_s}]"},
      {kSteadyDrive, "steady-drive", "the longest steady interval of the drive"},
      {kOneState, "one-state", "the drive is on throughout"},
      // the states of the drive
      {kNoDrive, "no-drive",
       "no drive found: no tone exceeds the noise for long enough[; the noise in the band is "
       "{noise_m} RMS][, and a steady vibration is at most {at_most_m} RMS (95 %)]; --window all "
       "gives the RMS of all that is there"},
      {kNothingSteady, "nothing-steady",
       "the drive is on[ for {on_s}], but no interval of it is steady and free of filter "
       "transients for long enough: drive longer at a constant amplitude, choose an interval with "
       "--window FROM:TO, or use --window all for the RMS of the whole record"},
      {kOtherVibration, "other-vibration",
       "outside of the window {other_s} of the record have another RMS, {rms_m}; --window measures "
       "them"},
      {kWindowMixed, "window-mixed",
       "in {off_s} of the window's {window_s} the drive is off or changes; --window auto uses the "
       "longest steady interval"},
      {kDriveOffInWindow, "drive-off-in-window", "the drive is off in the whole window"},
      {kDriveUnsteady, "drive-unsteady", "the amplitude changes by {drift %} over the window"},
      {kFrequencyMoves, "frequency-moves",
       "the frequency changes from {from_hz} to {to_hz}: this is a sweep, and the RMS is that of "
       "all of it; use --sweep"},
      {kFrequencyDrifts, "frequency-drifts",
       "the frequency drifts from {from_hz} to {to_hz}; the RMS includes all of it"},
      {kToneVaries, "tone-varies",
       "the vibration has an amplitude of {level_m} over a few periods, but one sine through the "
       "window {amplitude_m}: its frequency varies, or there are two tones close to each other; "
       "amplitude and frequency of the tone are not the vibration's, the RMS includes all of it"},
      {kDriveContradicted, "drive-contradicted",
       "the drive channel is off for {off_s} from {from_s} to {to_s}, where the displacement "
       "vibrates: check the channel and its connection"},
      {kDriveDelayed, "drive-delayed",
       "the vibration follows the drive channel by {delay_s +-uncertainty_s}; corrected for in the "
       "choice of the window"},
      {kBumpsExcluded, "bumps-excluded",
       "{count} bump{count s} excluded together with the filter's response, {excluded_s} of the "
       "window in all, the first at {from_s}"},
      {kOtherDrive, "other-drive",
       "the tone is at {frequency_hz}, and a drive of {expected_hz} is stated: check the "
       "generator, or correct what states it (the file's header, --drive-frequency)"},
      // the requested or chosen window
      {kWindowOutside, "window-outside",
       "the window {from_s} to {to_s} lies outside of the record, {record_from_s} to "
       "{record_to_s}"},
      {kWindowNotSettled, "window-not-settled",
       "only {settled_s} of the window {from_s} to {to_s} are free of filter transients: choose a "
       "wider one, or record longer before and after it"},
      {kWindowShortened, "window-shortened",
       "filter transients excluded: {excluded_s} of the window {from_s} to {to_s}"},
      {kWindowClipped, "window-clipped",
       "{share %} of the window is clipped, so that its RMS is a lower limit: move the sensor or "
       "choose a wider range"},
      {kCornerLoss, "corner-loss",
       "the tone at {frequency_hz} is near a corner of the band, where the filter passes {gain %} "
       "of its amplitude: without the filter the RMS is {rms_m}; a wider --band avoids this"},
      {kToneBelowBand, "tone-below-band",
       "a tone of {amplitude_m} at {frequency_hz}, below the band, is stronger than all that is in "
       "it: where it is the drive, give a --band that holds it"},
      {kAboveBand, "above-band",
       "a tone of {amplitude_m} at {frequency_hz}, above the band, is stronger than all that is in "
       "it: where it is the drive, give a --band that holds it"},
      // hum of the mains
      {kHumSubtracted, "hum-subtracted",
       "hum of the mains subtracted: {lines} line{lines s}, the strongest {amplitude_m} at "
       "{frequency_hz}; --hum keep counts it as vibration"},
      {kHumAtDrive, "hum-at-drive",
       "hum at {frequency_hz} cannot be distinguished from the drive, and the RMS includes it; at "
       "{mains_hz} hum has {amplitude_m}; drive at another frequency"},
      {kMainsFrequency, "mains-frequency",
       "the only tone is at {frequency_hz}[, {amplitude_m},] a multiple of the mains' frequency, "
       "and never off: it may be hum; record an interval with the drive off, drive at another "
       "frequency, or count it as vibration by --hum keep"},
      // noise floor
      {kNoFloor, "no-floor",
       "the noise is not known and not subtracted: the RMS includes it[, about {noise_m} at most]; "
       "give a drive-off trial by --floor FILE, or record 0.1 s or more with the drive off"},
      {kQuietHasDrive, "quiet-has-drive",
       "where the drive is off, a tone of {amplitude_m} at {frequency_hz} remains: it is excluded "
       "from the noise"},
      {kFloorOfOtherRate, "floor-of-other-rate",
       "the floor has {floor_per_s SI} readings/s and this trial {readings_per_s SI}: a sensor's "
       "noise in the band depends on its rate; use a floor of the same settings"},
      {kFloorHasTone, "floor-has-tone",
       "the floor holds a tone, {amplitude_m} at {frequency_hz}: it is subtracted as noise; was "
       "the drive off?"},
      {kFloorHasTheTone, "floor-has-the-tone",
       "the floor holds a tone, {amplitude_m} at {frequency_hz}, as this trial does: it is "
       "subtracted as noise; was the drive off?"},
      {kFloorAboveSignal, "floor-above-signal",
       "the {measured_m} that were measured do not exceed the floor of {floor_m}: record a floor "
       "with the same sensor, settings and rate, drive off"},
      {kBelowFloor, "below-floor", "below the noise floor of {floor_m}: at most {at_most_m}"},
      // the numbers
      {kRmsTooLarge, "rms-too-large",
       "read as it is named, the column gives {rms_m} RMS, more than any tactile actuator moves: "
       "is it in another unit? Name the unit that it is in (--columns), or state the length of one "
       "printed unit (--scale)"},
      {kRmsTooSmall, "rms-too-small",
       "{rms_m} RMS is less than any laser distance sensor resolves: is the column in another unit "
       "than it states?"},
      {kWideInterval, "wide-interval",
       "the RMS is known to {share 2%} only (half of its 95 % interval)"
       "[; {noise_share %} of the variance is due to noise: drive harder, record longer, or "
       "reduce the noise]"
       "[; {noise_floor_share %} of the variance is due to the scatter of the noise floor: drive "
       "harder, or record the floor longer]"
       "[; {noise_kept_share %} of the variance is due to noise that is not known and not "
       "subtracted: give a drive-off trial by --floor FILE, or record an interval with the drive "
       "off]"
       "[; {below_band_share %} of the variance is due to motion below the band: choose a --band "
       "that holds it, or one that begins farther above it]"
       "[; {quantisation_share %} of the variance is due to the steps of the readings: use a "
       "finer resolution, or a smaller range]"
       "[; {bridged_share %} of the variance is due to interpolated readings: record without "
       "missing readings and spikes, at uniform times]"
       "[; {filter_ends_share %} of the variance is due to what lay beyond the ends: record "
       "longer before and after the window]"
       "[; {beat_share %} of the variance is due to the beat of two tones: record longer, or "
       "remove one of them]"
       "[; {drive_edges_share %} of the variance is due to how much the RMS changes with the ends "
       "of the window and with bumps: drive longer at a constant amplitude, or choose an interval "
       "with --window FROM:TO]"
       "[; {steps_share %} of the variance is due to steps of the level: choose an interval "
       "without them with --window FROM:TO]"
       "[; {foot_share %} of the variance is due to motion at the lower corner: choose a --band "
       "that begins higher, or record an interval with the drive off]"
       "[; {hum_share %} of the variance is due to hum of the mains: record an interval with the "
       "drive off, or reduce the hum]"
       "[; {drift_share %} of the variance is due to the change of the amplitude: drive at a "
       "constant amplitude, or choose a shorter interval with --window FROM:TO]"
       "[; {calibration_share %} of the variance is due to the calibration: calibrate the sensor "
       "more accurately]"},
      {kQuantised, "quantised",
       "steps of {step_m} without noise to smooth them may change the RMS by {share %}: use a "
       "finer resolution, or a smaller range"},
      // gain of the sensor's averaging
      {kGainInBand, "gain-in-band",
       "the sensor's gain in the band is {least} to {greatest}; without a tone it is not corrected "
       "for"},
      {kGainTooLow, "gain-too-low",
       "the sensor's gain at {frequency_hz} is {gain}, below {least_gain}: set it to {averages} "
       "average{averages s} or fewer"},
      {kGainCorrected, "gain-corrected", "the sensor's gain at the tone is {gain}; corrected for"},
      {kCalibrationIncluded, "calibration-included",
       "uncertainties include a relative standard uncertainty of the sensor's gain of {share %}"},
      {kCalibrationReplaced, "calibration-replaced",
       "--calibration-uncertainty is used in place of the {share %} that the file's calibration "
       "states"},
      // voltage and current at the tone
      {kElectricalUnmeasured, "electrical-unmeasured",
       "electrical state not determined: {readings} readings of voltage or current in the window "
       "are not measurements"},
      {kElectricalNoTone, "electrical-no-tone",
       "electrical state not determined: no voltage or no current exceeds the noise at "
       "{frequency_hz}"},
      // sweeps
      {kSweepUneven, "sweep-uneven",
       "the times of its readings are not uniform: a sweep needs a clocked record"},
      {kSweepPolled, "sweep-polled",
       "its readings are polled and of unknown age: a sweep needs a clocked record"},
      {kSweepRateLimit, "sweep-rate-limit",
       "not determined above {upper_hz}: {new_readings_per_s SI} new readings/s; record "
       "{needed_per_s SI} or more"},
      {kSweepSensorLimit, "sweep-sensor-limit",
       "not determined above {upper_hz}: the sensor's gain is below 0.5 there"},
      {kDriveConstant, "drive-constant", "the channel {channel} is constant; it is not a drive"},
      {kDriveGaps, "drive-gaps", "the channel {channel} has gaps; its longest segment is used"},
      {kNoDriveChannel, "no-drive-channel",
       "phase, coherence and amplitude per volt are not determined: there is no voltage or current "
       "channel"},
      {kConstantDriveAssumed, "constant-drive-assumed",
       "f0 and Q hold for a drive of constant amplitude"},
      // response over frequency
      {kSweepTooShort, "sweep-too-short",
       "{length_s} do not hold two segments of the response; record longer, or choose a resolution "
       "of {resolution_hz}"},
      {kNoResponse, "no-response", "the displacement shows no response to the drive"},
      {kNoSweep, "no-sweep",
       "no sweep found from {lower_hz} to {upper_hz}: no vibration whose frequency changes by a "
       "tenth, and by less than {resolution_hz} in {block_s}; try another --band, a --resolution "
       "above the root of the sweep's Hz/s, a slower sweep, or record the drive's voltage"},
      {kFrequenciesExcluded, "frequencies-excluded",
       "{excluded} of {frequencies} frequencies excluded: too little drive or too much noise "
       "there"},
      // f0 and Q of one resonance
      {kResonanceAbove, "resonance-above",
       "f0 and Q: no resonance with one degree of freedom between {from_hz} and {to_hz}; the "
       "largest amplitude lies at the upper end, {highest_hz}: the resonance may be above it; "
       "sweep further, with a wider --band"},
      {kResonanceBelow, "resonance-below",
       "f0 and Q: no resonance with one degree of freedom between {from_hz} and {to_hz}; the "
       "largest amplitude lies at the lower end, {highest_hz}: the resonance may be below it; "
       "sweep further, with a wider --band"},
      {kPeakTooNarrow, "peak-too-narrow",
       "f0 and Q: no resonance with one degree of freedom between {from_hz} and {to_hz}; the peak "
       "at {highest_hz} is no wider than the resolution of {resolution_hz}: sweep more slowly, or "
       "record the drive's voltage, with a smaller --resolution"},
      {kNoResonance, "no-resonance",
       "f0 and Q: no resonance with one degree of freedom between {from_hz} and {to_hz}; the "
       "largest amplitude lies at {highest_hz}: examine it with --plot or --response"},
      {kSweepTooFast, "sweep-too-fast",
       "f0 and Q: the sweep passes the resonance near {frequency_hz} faster than the motion "
       "follows, at {rate_hz_per_s SI} Hz/s: sweep at {most_hz_per_s SI} Hz/s or more slowly, or "
       "record the drive's voltage"},
      {kSeveralResonances, "several-resonances",
       "one resonance does not explain {left %} of the response: there may be more than one"},
  };
  // one row for each kind
  static_assert(std::size(kSentences) == static_cast<std::size_t>(kSeveralResonances) + 1);
  return SentenceIn(kSentences, kind);
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

// "0.000 s to 0.375 s, 2.100 s to 3.000 s of the record", a file, or the drive's surroundings
std::string SourceOf(const dsp::NoiseFloor& floor) {
  if (floor.from == dsp::NoiseSource::kFile) return floor.file;
  if (floor.from == dsp::NoiseSource::kBeside) return "the spectrum beside the drive";
  std::string windows;
  for (const dsp::TimeWindow& quiet : floor.quiet) {
    windows += fmt::format("{}{:.3f} s to {:.3f} s", windows.empty() ? "" : ", ", quiet.begin_s,
                           quiet.end_s);
  }
  return windows + " of the record";
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
      {"noise that is not subtracted",
       "all that may be noise in the RMS, which is too large by it"},
      {"motion below the band", "its amplitude times |H|^2, as power and as a beat with the tone"},
      {"quantisation", "step / sqrt(12), white up to half the rate"},
      {"interpolated readings",
       "power in the band of the errors of interpolation, and their product with the signal"},
      {"filter's ends", "what lay beyond the ends, as far as it may still show"},
      {"beat", "of the tone with the next one: the window ends within a period of it"},
      {"drive's edges",
       "what a window shorter by a period at either end, or without all that may be bumps, "
       "changes"},
      {"steps", "their energy within the band"},
      {"motion below the band in it",
       "half of its power that was subtracted, and power just above the lower corner"},
      {"hum", "half of its power, as no pause shows it alone"},
      {"change of the amplitude", "half of it over the window"},
      {"calibration", "RMS times the relative standard uncertainty of the sensor's gain"},
  }};
  return kTexts.at(static_cast<std::size_t>(cause));
}

}  // namespace haptometer::document
