#include "tools/document/findings_dsp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace haptometer::document {
namespace {

using namespace std::string_literals;
using enum dsp::FindingKind;

// what a kind says with all of its numbers
struct Case {
  dsp::FindingKind kind;
  std::vector<FindingNumber> numbers;
  std::string name;
  std::string text;
};

const std::vector<Case> kCases{
    {kExcluded,
     {{"excluded", 130}, {"readings", 4000}, {"statuses", "over 30, late 100"s}},
     "readings-excluded",
     "130 of 4000 readings are missing or no measurement (over 30, late 100)"},
    {kRepeated,
     {{"repeated", 20}, {"readings", 4000}},
     "readings-repeated",
     "20 of 4000 readings are repeated: the sensor had no new value"},
    {kInterpolated,
     {{"interpolated", 1}, {"rms_m", 2.5e-09}},
     "readings-interpolated",
     "1 reading interpolated, with an error of 0.0025 um RMS in the window at most"},
    {kClipped,
     {{"count", 2}, {"readings", 4000}, {"first_s", 1.25}},
     "clipped",
     "clipped in 2 places, 4000 readings in all, the first at 1.25 s; not corrected"},
    {kMayBeClipped,
     {{"share", 0.25}},
     "may-be-clipped",
     "25 % of the window is at its highest or lowest value: clipped, or a motion that rests or "
     "is flat there, which these samples do not distinguish"},
    {kSourceIsSlower,
     {{"share", 0.6667}, {"new_readings_per_s", 1666.7}, {"frequency_hz", 440.3}, {"loss", 0.0995}},
     "source-is-slower",
     "66.67 % of the readings repeat the one before: the source gives 1666.7 new readings/s, fewer "
     "than the record's rate, and holds them, which reduces a tone at 440.3 Hz by 9.95 %; not "
     "corrected: record at the source's own rate"},
    {kLimited,
     {{"share", 0.25}, {"highest_m", 3.012e-3}, {"beyond_m", 3.1e-6}},
     "limited",
     "25 % of the window lies at a limit, 3.012 mm at its high end, with noise on it, and the tone "
     "would exceed it by 3.1 um on average: an amplifier or an analog output saturates, and the "
     "RMS is too low, or the motion is held by a stop; check their ranges"},
    {kStraightLines,
     {{"new_readings_per_s", 1500.0}, {"frequency_hz", 400.0}, {"loss", 0.2137}},
     "straight-lines",
     "the readings lie on straight lines between 1500 new readings/s, as an export at a higher "
     "rate draws them, which reduces a tone at 400 Hz by 21.37 %; not corrected: export at the "
     "source's own rate"},
    {kHeld,
     {{"count", 2}, {"readings", 4000}, {"first_s", 1.25}, {"size_m", 1.2e-05}},
     "held",
     "a held reading in 2 places, 4000 readings in all, the first at 1.25 s (12 um); excluded "
     "where they are short"},
    {kNoReadingCodes,
     {{"value_m", -0.099998}, {"readings", 5}},
     "no-reading-codes",
     "-99.998 mm is a code for no reading: 5 readings excluded"},
    {kSpikes,
     {{"count", 2}, {"readings", 4000}, {"first_s", 1.25}, {"size_m", 1.2e-05}},
     "spikes",
     "2 spikes, 4000 readings in all, the first at 1.25 s (12 um); excluded"},
    {kSteps,
     {{"count", 1}, {"first_s", 1.25}, {"size_m", 1.2e-05}},
     "steps",
     "1 step, the first at 1.25 s (12 um); not corrected"},
    {kStuck,
     {{"readings", 4000}},
     "stuck",
     "all 4000 readings are the same: a stuck sensor, held readings, or steps coarser than the "
     "motion; check its hold, its target and its range, and record again"},
    {kStuckInWindow,
     {{"window_s", 0.4}, {"from_s", 1.5}, {"changes", 3}, {"readings", 4000}, {"lower_hz", 20.0}},
     "stuck-in-window",
     "in the 400 ms from 1.5 s on only 3 of 4000 readings differ from the one before, fewer than "
     "vibration at 20 Hz makes: a stuck sensor, held readings, or steps coarser than the motion; "
     "check its hold, its target and its range, and record again"},
    {kNoMeasurement, {}, "no-measurement", "none of its readings is a measurement"},
    {kFarReadings,
     {{"farthest_m", 30.0}},
     "far-readings",
     "read as it is named, the column reaches 30 m, farther than any displacement sensor: is it in "
     "mm, um or V? Name the unit that it is in (--columns), or state the length of one printed "
     "unit (--scale)"},
    {kBeyondCalibrated,
     {{"samples", 12},
      {"readings", 400},
      {"beyond_m", 0.5e-3},
      {"least_m", -4e-3},
      {"most_m", 4e-3}},
     "beyond-calibrated",
     "12 of 400 samples lie beyond the calibrated range, -4 mm to 4 mm, by 500 um at most, where "
     "the line was not measured: calibrate a wider range, or move the sensor"},
    {kSegments,
     {{"segments", 3}},
     "segments",
     "gaps split the record into 3 segments; the window is in one of them"},
    {kLongestSegment,
     {{"segments", 3}},
     "longest-segment",
     "gaps split the record into 3 segments; the longest is used"},
    {kSamplesLimited,
     {{"samples", 20000000}, {"used", 16777216}},
     "samples-limited",
     "only the first 16777216 of 20000000 samples are used"},
    {kSegmentEnds,
     {{"first_s", 1.25}, {"last_s", 0.2}, {"segment_s", 3.0}},
     "segment-ends",
     "filter transients excluded: the first 1.25 s and the last 200 ms of a segment of 3 s"},
    {kOtherDisplacements,
     {{"channel", "laser"}, {"others", "laser_2, laser_3"}},
     "other-displacements",
     "the displacement laser is analysed, laser_2, laser_3 not: --columns chooses, with - for the "
     "others"},
    {kAveragingUnknown,
     {},
     "averaging-unknown",
     "amplitude not verified: sensor averaging unknown; state it by acquire --averaging 16 "
     "--sampling 0.33ms, in the calibration file, or in the header of a CSV, as '# "
     "averages = 16' and '# sampling_s = 0.00033' (haptometer trial export FILE -o OUT.csv makes "
     "one of any trial)"},
    {kTooFewReadings,
     {{"new_readings_per_s", 48.0},
      {"observable_hz", 18.75},
      {"lower_hz", 20.0},
      {"upper_hz", 500.0},
      {"needed_per_s", 1280.0}},
     "too-few-readings",
     "48 new readings/s show vibration up to 18.75 Hz; 20 Hz to 500 Hz need 1280 readings/s: use a "
     "free-running output, or the analog output and a DAQ"},
    {kTimesUncertain,
     {{"time_uncertainty_s", 0.008}, {"upper_hz", 500.0}, {"limit_s", 0.0002}},
     "times-uncertain",
     "each reading's time is uncertain by 8 ms; motion at 500 Hz needs less than 0.2 ms: use a "
     "sensor that samples on a clock of its own"},
    {kFewUnevenTimes,
     {{"rows", 3}},
     "few-uneven-times",
     "3 rows at non-uniform times are too few: record longer"},
    {kTimesTooUneven,
     {{"jitter_s", 2.5e-05}, {"grid_s", 0.0001}, {"largest_jitter_s", 9e-05}},
     "times-too-uneven",
     "the times of its readings scatter by 0.025 ms about a grid of 0.1 ms, up to 0.09 ms: dropped "
     "readings cannot be distinguished from late ones: record with a clocked source"},
    {kReadingsTooFarApart,
     {{"upper_hz", 4500.0}, {"readings_per_s", 10000.0}},
     "readings-too-far-apart",
     "its readings at non-uniform times are too far apart for motion at 4500 Hz: 10000 readings/s: "
     "choose "
     "a lower band, or record with a clocked source"},
    {kClockDrift,
     {{"drift_s", 0.0012}, {"readings_per_s", 10000.0}},
     "clock-drift",
     "the clock of its times drifts: they go away by up to 1.2 ms from uniform ones of 10000 "
     "readings/s; values are interpolated to the true times"},
    {kRegularGrid,
     {{"jitter_s", 5e-07},
      {"largest_jitter_s", 2e-06},
      {"readings_per_s", 10000.0},
      {"readings", 4000},
      {"missing", 3},
      {"excluded", 0},
      {"error", 0.02}},
     "regular-grid",
     "times scatter by 0.0005 ms (0.002 ms at most) about a grid of 10000 readings/s: 4000 "
     "readings assigned to it, 3 missing, 0 excluded; this adds 0.02 of a tone at most"},
    {kSamplingContradicted,
     {{"sampling_s", 0.001}, {"samples_per_s", 1000.0}, {"new_readings_per_s", 48.0}},
     "sampling-contradicted",
     "the file states a sampling period of 1 ms, 1000 samples/s, and holds 48 new readings/s: one "
     "of the two is wrong, and the sensor's gain is computed from the first"},
    {kTimesInOtherUnit,
     {{"column", "time_ms"s}, {"readings_per_s", 10000.0}, {"duration_s", 2.0}},
     "times-in-other-unit",
     "as time_ms, the times would give 10000 readings/s over 2 s; if that is right, name the "
     "column of the times time_ms (--columns), and the others as they are named now"},
    {kPolledTimes,
     {},
     "polled-times",
     "the age of its readings is unknown, so that no tone of known frequency is fitted either"},
    {kTimesUnfitForTone,
     {{"time_uncertainty_s", 0.008}, {"frequency_hz", 225.0}, {"limit_s", 0.0002}},
     "times-unfit-for-tone",
     "times are uncertain by 8 ms; a fit at 225 Hz needs less than 0.2 ms"},
    {kKnownTone,
     {{"frequency_hz", 225.0}, {"amplitude_m", 1e-05}},
     "known-tone",
     "if the motion is a tone at 225 Hz, its amplitude is 10 um; no answer for the band"},
    {kKnownToneAlias,
     {{"frequency_hz", 225.0}, {"amplitude_m", 1e-05}},
     "known-tone-alias",
     "if the motion is a tone at 225 Hz, its amplitude is 10 um, measured as an alias together "
     "with all other motion there; no answer for the band"},
    {kKnownTonePauses,
     {{"frequency_hz", 225.0}, {"from_s", 1.5}, {"to_s", 2.25}},
     "known-tone-pauses",
     "the tone at 225 Hz has pauses: it is fitted in its longest part, 1.5 s to 2.25 s"},
    {kKnownToneElsewhere,
     {{"frequency_hz", 175.1}, {"better_hz", 175.0}, {"amplitude_m", 28.3e-6}},
     "known-tone-elsewhere",
     "a tone of 28.3 um at 175 Hz fits the readings better than the stated 175.1 Hz: state the "
     "drive's frequency to a part of 1 / duration (--drive-frequency)"},
    {kKnownToneAtRate,
     {{"frequency_hz", 225.0}},
     "known-tone-at-rate",
     "a tone at 225 Hz cannot be distinguished from the offset at this rate"},
    {kOrderLowered,
     {{"asked_order", 6}, {"order", 4}, {"settled_s", 0.1}},
     "order-lowered",
     "filter order lowered from 6 to 4: at order 6 only 100 ms are free of filter transients"},
    {kTooShort,
     {{"settled_s", 0.1}, {"order", 4}, {"needed_s", 0.125}, {"lower_hz", 20.0}, {"record_s", 2.0}},
     "too-short",
     "only 100 ms of it are free of the transients of a filter of order 4; 125 ms are needed, and "
     "a lower order passes too much of the motion below 20 Hz: record at least 2 s without a gap"},
    {kBelowBand,
     {{"amplitude_m", 1e-05}, {"frequency_hz", 225.0}, {"leaked_m", 1.5e-08}},
     "below-band",
     "component below the band: amplitude 10 um at 225 Hz; its leakage into the band is 0.015 um "
     "RMS"},
    {kBelowBandModelled,
     {{"amplitude_m", 1e-05}, {"frequency_hz", 225.0}, {"leaked_m", 1.5e-08}},
     "below-band-modelled",
     "component below the band: amplitude 10 um at 225 Hz; its leakage into the band, 0.015 um "
     "RMS, is modelled beyond both ends of the record and subtracted"},
    {kAllSettled, {}, "all-settled", "all that is free of filter transients"},
    {kWindowAsked, {{"from_s", 1.5}, {"to_s", 2.25}}, "window-asked", "requested: 1.5 s to 2.25 s"},
    {kSteadyDrive, {}, "steady-drive", "the longest steady interval of the drive"},
    {kOneState, {}, "one-state", "the drive is on throughout"},
    {kNoDrive,
     {{"noise_m", 1.5e-08}, {"at_most_m", 2.5e-08}},
     "no-drive",
     "no drive found: no tone exceeds the noise for long enough; the noise in the band is 0.015 um "
     "RMS, and a steady vibration is at most 0.025 um RMS (95 %); --window all gives the RMS of "
     "all that is there"},
    {kNothingSteady,
     {{"on_s", 0.25}},
     "nothing-steady",
     "the drive is on for 250 ms, but no interval of it is steady and free of filter transients "
     "for long enough: drive longer at a constant amplitude, choose an interval with --window "
     "FROM:TO, or use --window all for the RMS of the whole record"},
    {kOtherVibration,
     {{"other_s", 1.5}, {"rms_m", 2.5e-07}},
     "other-vibration",
     "outside of the window 1.5 s of the record have another RMS, 0.25 um; --window measures them"},
    {kWindowMixed,
     {{"off_s", 0.25}, {"window_s", 1.0}},
     "window-mixed",
     "in 250 ms of the window's 1 s the drive is off or changes; --window auto uses the longest "
     "steady interval"},
    {kDriveOffInWindow, {}, "drive-off-in-window", "the drive is off in the whole window"},
    {kDriveUnsteady,
     {{"drift", 0.061}},
     "drive-unsteady",
     "the amplitude changes by 6.1 % over the window"},
    {kFrequencyMoves,
     {{"from_hz", 60.0}, {"to_hz", 450.0}},
     "frequency-moves",
     "the frequency changes from 60 Hz to 450 Hz: this is a sweep, and the RMS is that of all of "
     "it; use --sweep"},
    {kFrequencyDrifts,
     {{"from_hz", 225.0}, {"to_hz", 229.0}},
     "frequency-drifts",
     "the frequency drifts from 225 Hz to 229 Hz; the RMS includes all of it"},
    {kToneVaries,
     {{"level_m", 38.5e-6}, {"amplitude_m", 15.8e-6}},
     "tone-varies",
     "the vibration has an amplitude of 38.5 um over a few periods, but one sine through the "
     "window 15.8 um: its frequency varies, or there are two tones close to each other; "
     "amplitude and frequency of the tone are not the vibration's, the RMS includes all of it"},
    {kDriveContradicted,
     {{"off_s", 0.5}, {"from_s", 1.5}, {"to_s", 2.25}},
     "drive-contradicted",
     "the drive channel is off for 500 ms from 1.5 s to 2.25 s, where the displacement vibrates: "
     "check the channel and its connection"},
    {kDriveDelayed,
     {{"delay_s", 0.012}, {"uncertainty_s", 0.001}},
     "drive-delayed",
     "the vibration follows the drive channel by 12.0(10) ms; corrected for in the choice of the "
     "window"},
    {kBumpsExcluded,
     {{"count", 2}, {"excluded_s", 0.25}, {"from_s", 1.5}},
     "bumps-excluded",
     "2 bumps excluded together with the filter's response, 250 ms of the window in all, the first "
     "at 1.5 s"},
    {kOtherDrive,
     {{"frequency_hz", 230.0}, {"expected_hz", 225.0}},
     "other-drive",
     "the tone is at 230 Hz, and a drive of 225 Hz is stated: check the generator, or correct what "
     "states it (the file's header, --drive-frequency)"},
    {kToneBelowBand,
     {{"amplitude_m", 20e-6}, {"frequency_hz", 60.0}},
     "tone-below-band",
     "a tone of 20 um at 60 Hz, below the band, is stronger than all that is in it: where it is "
     "the drive, give a --band that holds it"},
    {kAboveBand,
     {{"amplitude_m", 20e-6}, {"frequency_hz", 600.0}},
     "above-band",
     "a tone of 20 um at 600 Hz, above the band, is stronger than all that is in it: where it is "
     "the drive, give a --band that holds it"},
    {kCornerLoss,
     {{"frequency_hz", 490.0}, {"gain", 0.76}, {"rms_m", 9e-06}},
     "corner-loss",
     "the tone at 490 Hz is near a corner of the band, where the filter passes 76 % of its "
     "amplitude: without the filter the RMS is 9 um; a wider --band avoids this"},
    {kHumSubtracted,
     {{"frequency_hz", 50.0}, {"amplitude_m", 2.5e-07}, {"lines", 3}},
     "hum-subtracted",
     "hum of the mains subtracted: 3 lines, the strongest 0.25 um at 50 Hz; --hum keep counts it "
     "as "
     "vibration"},
    {kHumAtDrive,
     {{"frequency_hz", 250.0}, {"mains_hz", 50.0}, {"amplitude_m", 2.5e-07}},
     "hum-at-drive",
     "hum at 250 Hz cannot be distinguished from the drive, and the RMS includes it; at 50 Hz hum "
     "has 0.25 um; drive at another frequency"},
    {kMainsFrequency,
     {{"frequency_hz", 150.0}, {"amplitude_m", 2.5e-07}},
     "mains-frequency",
     "the only tone is at 150 Hz, 0.25 um, a multiple of the mains' frequency, and never off: it "
     "may be hum; record an interval with the drive off, drive at another frequency, or count it "
     "as vibration by --hum keep"},
    {kQuietHasDrive,
     {{"amplitude_m", 2.5e-07}, {"frequency_hz", 225.0}},
     "quiet-has-drive",
     "where the drive is off, a tone of 0.25 um at 225 Hz remains: it is excluded from the noise"},
    {kWideInterval,
     {{"share", 0.08412}, {"noise_share", 0.97}},
     "wide-interval",
     "the RMS is known to 8.4 % only (half of its 95 % interval); 97 % of the variance is due to "
     "noise: drive harder, record longer, or reduce the noise"},
    {kQuantised,
     {{"share", 0.031}, {"step_m", 1e-06}},
     "quantised",
     "steps of 1 um without noise to smooth them may change the RMS by 3.1 %: use a finer "
     "resolution, or a smaller range"},
    {kWindowOutside,
     {{"from_s", 1.5}, {"to_s", 2.25}, {"record_from_s", 0.0}, {"record_to_s", 3.0}},
     "window-outside",
     "the window 1.5 s to 2.25 s lies outside of the record, 0 ms to 3 s"},
    {kWindowNotSettled,
     {{"from_s", 1.5}, {"to_s", 2.25}, {"settled_s", 0.1}},
     "window-not-settled",
     "only 100 ms of the window 1.5 s to 2.25 s are free of filter transients: choose a wider one, "
     "or record longer before and after it"},
    {kWindowShortened,
     {{"excluded_s", 0.1}, {"from_s", 1.5}, {"to_s", 2.25}},
     "window-shortened",
     "filter transients excluded: 100 ms of the window 1.5 s to 2.25 s"},
    {kWindowClipped,
     {{"share", 0.02}},
     "window-clipped",
     "2 % of the window is clipped, so that its RMS is a lower limit: move the sensor or choose a "
     "wider range"},
    {kNoFloor,
     {{"noise_m", 2.5e-07}},
     "no-floor",
     "the noise is not known and not subtracted: the RMS includes it, about 0.25 um at most; give "
     "a drive-off trial by --floor FILE, or record 0.1 s or more with the drive off"},
    {kFloorOfOtherRate,
     {{"floor_per_s", 2000.0}, {"readings_per_s", 10000.0}},
     "floor-of-other-rate",
     "the floor has 2000 readings/s and this trial 10000: a sensor's noise in the band depends on "
     "its rate; use a floor of the same settings"},
    {kFloorHasTone,
     {{"amplitude_m", 1e-05}, {"frequency_hz", 225.0}},
     "floor-has-tone",
     "the floor holds a tone, 10 um at 225 Hz: it is subtracted as noise; was the drive off?"},
    {kFloorHasTheTone,
     {{"amplitude_m", 1e-05}, {"frequency_hz", 225.0}},
     "floor-has-the-tone",
     "the floor holds a tone, 10 um at 225 Hz, as this trial does: it is subtracted as noise; was "
     "the drive off?"},
    {kFloorAboveSignal,
     {{"floor_m", 2e-06}, {"measured_m", 1e-06}},
     "floor-above-signal",
     "the 1 um that were measured do not exceed the floor of 2 um: record a floor with the same "
     "sensor, settings and rate, drive off"},
    {kBelowFloor,
     {{"floor_m", 2e-06}, {"at_most_m", 3e-06}},
     "below-floor",
     "below the noise floor of 2 um: at most 3 um"},
    {kRmsTooLarge,
     {{"rms_m", 0.014}},
     "rms-too-large",
     "read as it is named, the column gives 14 mm RMS, more than any tactile actuator moves: is it "
     "in another unit? Name the unit that it is in (--columns), or state the length of one printed "
     "unit (--scale)"},
    {kRmsTooSmall,
     {{"rms_m", 1.4e-11}},
     "rms-too-small",
     "1.4e-05 um RMS is less than any laser distance sensor resolves: is the column in another "
     "unit than it states?"},
    {kGainInBand,
     {{"least", 0.9}, {"greatest", 0.99}},
     "gain-in-band",
     "the sensor's gain in the band is 0.9 to 0.99; without a tone it is not corrected for"},
    {kGainTooLow,
     {{"gain", 0.47}, {"frequency_hz", 225.0}, {"least_gain", 0.5}, {"averages", 6}},
     "gain-too-low",
     "the sensor's gain at 225 Hz is 0.47, below 0.5: set it to 6 averages or fewer"},
    {kCalibrationIncluded,
     {{"share", 0.005}},
     "calibration-included",
     "uncertainties include a relative standard uncertainty of the sensor's gain of 0.5 %"},
    {kCalibrationReplaced,
     {{"share", 0.002}},
     "calibration-replaced",
     "--calibration-uncertainty is used in place of the 0.2 % that the file's calibration states"},
    {kGainCorrected,
     {{"gain", 0.47}},
     "gain-corrected",
     "the sensor's gain at the tone is 0.47; corrected for"},
    {kElectricalUnmeasured,
     {{"readings", 2}},
     "electrical-unmeasured",
     "electrical state not determined: 2 readings of voltage or current in the window are not "
     "measurements"},
    {kElectricalNoTone,
     {{"frequency_hz", 225.0}},
     "electrical-no-tone",
     "electrical state not determined: no voltage or no current exceeds the noise at 225 Hz"},
    {kSweepUneven,
     {},
     "sweep-uneven",
     "the times of its readings are not uniform: a sweep needs a clocked record"},
    {kSweepPolled,
     {},
     "sweep-polled",
     "its readings are polled and of unknown age: a sweep needs a clocked record"},
    {kSweepRateLimit,
     {{"upper_hz", 500.0}, {"new_readings_per_s", 48.0}, {"needed_per_s", 1280.0}},
     "sweep-rate-limit",
     "not determined above 500 Hz: 48 new readings/s; record 1280 or more"},
    {kSweepSensorLimit,
     {{"upper_hz", 500.0}},
     "sweep-sensor-limit",
     "not determined above 500 Hz: the sensor's gain is below 0.5 there"},
    {kDriveConstant,
     {{"channel", "coil"s}},
     "drive-constant",
     "the channel coil is constant; it is not a drive"},
    {kDriveGaps,
     {{"channel", "coil"s}},
     "drive-gaps",
     "the channel coil has gaps; its longest segment is used"},
    {kNoDriveChannel,
     {},
     "no-drive-channel",
     "phase, coherence and amplitude per volt are not determined: there is no voltage or current "
     "channel"},
    {kConstantDriveAssumed,
     {},
     "constant-drive-assumed",
     "f0 and Q hold for a drive of constant amplitude"},
    {kSweepTooShort,
     {{"length_s", 4.0}, {"resolution_hz", 0.5}},
     "sweep-too-short",
     "4 s do not hold two segments of the response; record longer, or choose a resolution of 0.5 "
     "Hz"},
    {kNoResponse, {}, "no-response", "the displacement shows no response to the drive"},
    {kNoSweep,
     {{"lower_hz", 20.0}, {"upper_hz", 500.0}, {"resolution_hz", 0.5}, {"block_s", 2.0}},
     "no-sweep",
     "no sweep found from 20 Hz to 500 Hz: no vibration whose frequency changes by a tenth, and by "
     "less than 0.5 Hz in 2 s; try another --band, a --resolution above the root of the sweep's "
     "Hz/s, a slower sweep, or record the drive's voltage"},
    {kFrequenciesExcluded,
     {{"excluded", 12}, {"frequencies", 400}},
     "frequencies-excluded",
     "12 of 400 frequencies excluded: too little drive or too much noise there"},
    {kResonanceAbove,
     {{"from_hz", 60.0}, {"to_hz", 450.0}, {"highest_hz", 449.5}},
     "resonance-above",
     "f0 and Q: no resonance with one degree of freedom between 60 Hz and 450 Hz; the largest "
     "amplitude lies at the upper end, 449.5 Hz: the resonance may be above it; sweep further, "
     "with a wider --band"},
    {kResonanceBelow,
     {{"from_hz", 60.0}, {"to_hz", 450.0}, {"highest_hz", 449.5}},
     "resonance-below",
     "f0 and Q: no resonance with one degree of freedom between 60 Hz and 450 Hz; the largest "
     "amplitude lies at the lower end, 449.5 Hz: the resonance may be below it; sweep further, "
     "with a wider --band"},
    {kPeakTooNarrow,
     {{"from_hz", 60.0}, {"to_hz", 450.0}, {"highest_hz", 449.5}, {"resolution_hz", 0.5}},
     "peak-too-narrow",
     "f0 and Q: no resonance with one degree of freedom between 60 Hz and 450 Hz; the peak at "
     "449.5 Hz is no wider than the resolution of 0.5 Hz: sweep more slowly, or record the drive's "
     "voltage, with a smaller --resolution"},
    {kNoResonance,
     {{"from_hz", 60.0}, {"to_hz", 450.0}, {"highest_hz", 449.5}},
     "no-resonance",
     "f0 and Q: no resonance with one degree of freedom between 60 Hz and 450 Hz; the largest "
     "amplitude lies at 449.5 Hz: examine it with --plot or --response"},
    {kSweepTooFast,
     {{"rate_hz_per_s", 29.0}, {"most_hz_per_s", 2.5}, {"frequency_hz", 150.0}},
     "sweep-too-fast",
     "f0 and Q: the sweep passes the resonance near 150 Hz faster than the motion follows, at 29 "
     "Hz/s: "
     "sweep at 2.5 Hz/s or more slowly, or record the drive's voltage"},
    {kSeveralResonances,
     {{"left", 0.25}},
     "several-resonances",
     "one resonance does not explain 25 % of the response: there may be more than one"},
};

TEST(FindingsOfDsp, SayTheirSentences) {
  for (const Case& one : kCases) {
    EXPECT_EQ(SentenceOf(one.kind).kind, one.name);
    EXPECT_EQ(TextOf(dsp::Finding{.kind = one.kind, .numbers = one.numbers}), one.text);
  }
}

TEST(FindingsOfDsp, AreEachTestedUnderANameOfTheirOwn) {
  std::set<dsp::FindingKind> kinds;
  std::set<std::string> names;
  for (const Case& one : kCases) {
    kinds.insert(one.kind);
    names.insert(one.name);
  }
  EXPECT_EQ(kinds.size(), static_cast<std::size_t>(kSeveralResonances) + 1);
  EXPECT_EQ(names.size(), kCases.size());
}

TEST(FindingsOfDsp, LeaveOutWhatIsNotThere) {
  const auto text = [](dsp::FindingKind kind, std::vector<FindingNumber> numbers) {
    return TextOf(dsp::Finding{.kind = kind, .numbers = std::move(numbers)});
  };
  EXPECT_THAT(
      text(kTooShort, {{"settled_s", 0.0}, {"order", 6}, {"needed_s", 0.1}, {"record_s", 2.0}}),
      ::testing::EndsWith("100 ms are needed: record at least 2 s without a gap"));
  EXPECT_EQ(text(kNoDrive, {}),
            "no drive found: no tone exceeds the noise for long enough; --window all gives the RMS "
            "of all that is there");
  EXPECT_EQ(text(kWindowAsked, {}), "requested");
  EXPECT_THAT(text(kNothingSteady, {}), ::testing::StartsWith("the drive is on, but no interval"));
}

// each cause of an interval's width has a remedy of its own, and it alone is in the text
TEST(FindingsOfDsp, SayWhatMakesAnIntervalWideAndWhatWouldHelp) {
  const std::vector<std::pair<std::string_view, std::string>> remedies{
      {"noise_share", "noise: drive harder, record longer, or reduce the noise"},
      {"noise_floor_share",
       "the scatter of the noise floor: drive harder, or record the floor longer"},
      {"below_band_share",
       "motion below the band: choose a --band that holds it, or one that begins farther above it"},
      {"quantisation_share",
       "the steps of the readings: use a finer resolution, or a smaller range"},
      {"bridged_share",
       "interpolated readings: record without missing readings and spikes, at uniform times"},
      {"filter_ends_share", "what lay beyond the ends: record longer before and after the window"},
      {"beat_share", "the beat of two tones: record longer, or remove one of them"},
      {"drive_edges_share",
       "how much the RMS changes with the ends of the window and with bumps: drive longer at a "
       "constant amplitude, or choose an interval with --window FROM:TO"},
      {"noise_kept_share",
       "noise that is not known and not subtracted: give a drive-off trial by --floor FILE, or "
       "record an interval with the drive off"},
      {"steps_share", "steps of the level: choose an interval without them with --window FROM:TO"},
      {"foot_share",
       "motion at the lower corner: choose a --band that begins higher, or record an interval with "
       "the drive off"},
      {"hum_share", "hum of the mains: record an interval with the drive off, or reduce the hum"},
      {"drift_share",
       "the change of the amplitude: drive at a constant amplitude, or choose a shorter interval "
       "with --window FROM:TO"},
      {"calibration_share", "the calibration: calibrate the sensor more accurately"},
  };
  ASSERT_EQ(remedies.size(), dsp::kRmsCauseCount);
  const std::string known = "the RMS is known to 4 % only (half of its 95 % interval)";
  EXPECT_EQ(TextOf(dsp::Finding{.kind = kWideInterval, .numbers = {{"share", 0.04}}}), known);
  for (const auto& [name, remedy] : remedies) {
    EXPECT_EQ(
        TextOf(dsp::Finding{.kind = kWideInterval, .numbers = {{"share", 0.04}, {name, 0.62}}}),
        known + "; 62 % of the variance is due to " + remedy);
  }
}

TEST(FindingsOfDsp, RefusalsStandForTheReasons) {
  dsp::Findings findings;
  EXPECT_EQ(RefusalOf(findings), "");
  findings.Note(kNoFloor);
  findings.Refuse(kNoMeasurement);
  findings.Add({.severity = Severity::kRefusal, .kind = kNoResponse, .subject = "a.bin"});
  EXPECT_THAT(RefusalsOf(findings),
              ::testing::ElementsAre("none of its readings is a measurement",
                                     "a.bin: the displacement shows no response to the drive"));
  EXPECT_EQ(RefusalOf(findings), "none of its readings is a measurement");
}

TEST(FindingsOfDsp, SayWhereANoiseLevelIsFrom) {
  dsp::NoiseFloor floor;
  floor.file = "off.bin";
  EXPECT_EQ(SourceOf(floor), "off.bin");
  floor.from = dsp::NoiseSource::kQuiet;
  floor.quiet = {{0, 0.375}, {2.1, 3}};
  EXPECT_EQ(SourceOf(floor), "0.000 s to 0.375 s, 2.100 s to 3.000 s of the record");
  floor.from = dsp::NoiseSource::kBeside;
  EXPECT_EQ(SourceOf(floor), "the spectrum beside the drive");
}

TEST(FindingsOfDsp, SayASensorsAveraging) {
  using enum dsp::SensorKnowledge;
  EXPECT_EQ(
      TextOf(dsp::SensorAveraging{.knowledge = kKnown, .sampling_s = 0.33e-3, .averages = 16}),
      "16 averages at 0.33 ms");
  EXPECT_EQ(TextOf(dsp::SensorAveraging{}), "averaging unknown");
  EXPECT_EQ(TextOf(dsp::SensorAveraging{.knowledge = kNone}), "no averaging");
  EXPECT_EQ(TextOf(dsp::SensorAveraging{.knowledge = kNone, .repeats = 5}),
            "no averaging, each reading held for 5 rows");
}

TEST(FindingsOfDsp, NameEachCauseOfAnUncertainty) {
  EXPECT_EQ(TextOf(dsp::RmsCause::kNoise).name, "noise");
  EXPECT_EQ(TextOf(dsp::RmsCause::kSteps).name, "steps");
  EXPECT_EQ(TextOf(dsp::RmsCause::kDrift).name, "change of the amplitude");
}

}  // namespace
}  // namespace haptometer::document
