#pragma once

#include <cstdint>

#include "base/finding.h"

namespace haptometer::dsp {

/// What an analysis finds of a record, without words; behind each kind the names of its numbers.
/// A channel, a column and the like are texts.
enum class FindingKind : std::uint8_t {
  // readings
  kExcluded,            ///< excluded, readings, statuses
  kRepeated,            ///< repeated, readings: handed out a second time
  kInterpolated,        ///< interpolated, rms_m: of what it adds at most
  kClipped,             ///< count, readings, first_s; the next three size_m as well
  kMayBeClipped,        ///< share: at an extreme, by clipping or by harmonics
  kLimited,             ///< share: at a limit below noise; lowest_m, highest_m: of those that there
                        ///< are; beyond_m: that the tone would go beyond it, on average
  kHeld,                ///< the same reading again and again, then a jump
  kNoReadingCodes,      ///< value_m, readings: that hold it
  kSpikes,              ///< readings far from their neighbours: excluded
  kSteps,               ///< the level jumps and stays
  kStuck,               ///< readings: all are the same
  kStuckInWindow,       ///< window_s, from_s, changes, readings, lower_hz
  kNoMeasurement,       ///< none of the readings is one
  kFarReadings,         ///< farthest_m: farther than any displacement sensor
  kBeyondCalibrated,    ///< samples, readings, beyond_m, least_m, most_m of the calibrated range;
                        ///< widths: from 100 on, as in another unit
  kSegments,            ///< segments: gaps split the record
  kLongestSegment,      ///< segments: the longest is used
  kSamplesLimited,      ///< samples, used
  kSegmentEnds,         ///< first_s, last_s, segment_s: what has not settled of one
  kAveragingUnknown,    ///< of the sensor: amplitudes are not verified
  kOtherDisplacements,  ///< channel, others: of the record; the first is analysed
  // rate and times
  kSourceIsSlower,       ///< share: of the readings that repeat the one before, new_readings_per_s,
                         ///< frequency_hz, loss: of the tone's amplitude
  kStraightLines,        ///< new_readings_per_s: that they join, frequency_hz, loss
  kTooFewReadings,       ///< new_readings_per_s, observable_hz, lower_hz, upper_hz, needed_per_s
  kTimesUncertain,       ///< time_uncertainty_s, upper_hz, limit_s
  kFewUnevenTimes,       ///< rows: too few for a regular grid
  kTimesTooUneven,       ///< jitter_s, grid_s, largest_jitter_s: no regular grid
  kReadingsTooFarApart,  ///< upper_hz, readings_per_s, at uneven times
  kRegularGrid,          ///< jitter_s, largest_jitter_s, readings_per_s, readings, missing,
                         ///< excluded, error: of a tone, at most
  kClockDrift,           ///< drift_s, readings_per_s: of times from an even grid
  kSamplingContradicted,  ///< sampling_s, samples_per_s, new_readings_per_s
  kTimesInOtherUnit,      ///< column, readings_per_s, duration_s
  kPolledTimes,           ///< readings of unknown age: no tone is fitted
  kTimesUnfitForTone,     ///< time_uncertainty_s, frequency_hz, limit_s
  kKnownTone,             ///< frequency_hz, amplitude_m
  kKnownToneAlias,        ///< the same, seen as an alias
  kKnownTonePauses,       ///< frequency_hz, from_s, to_s: where it is on longest
  kKnownToneElsewhere,    ///< frequency_hz, better_hz, amplitude_m: what fits better nearby
  kKnownToneAtRate,       ///< frequency_hz: not told apart from the offset
  // filter
  kOrderLowered,       ///< asked_order, order, settled_s
  kTooShort,           ///< settled_s, order, needed_s, record_s; lower_hz where a lower order leaks
  kBelowBand,          ///< amplitude_m, frequency_hz, leaked_m
  kBelowBandModelled,  ///< the same, subtracted
  kToneBelowBand,      ///< amplitude_m, frequency_hz: stronger than all that is in the band
  kAboveBand,          ///< the same, of a tone above it
  // drive and window; the first four say how a window was chosen (UsedPart::why)
  kAllSettled,
  kWindowAsked,  ///< from_s, to_s
  kSteadyDrive,  ///< the longest steady state that is on
  kOneState,     ///< the drive is on throughout
  // what speaks against a window, or goes with it
  kNoDrive,         ///< noise_m, at_most_m: no state is on
  kNothingSteady,   ///< on_s: none of what is on is steady for long enough
  kOtherVibration,  ///< other_s, rms_m: vibration outside of the window that is twice as strong, or
                    ///< a longer steady one of less than half of its level
  kWindowMixed,     ///< off_s, window_s
  kDriveOffInWindow,
  kDriveUnsteady,      ///< drift
  kFrequencyMoves,     ///< from_hz, to_hz
  kFrequencyDrifts,    ///< the same, less than a sweep
  kToneVaries,         ///< level_m, amplitude_m
  kDriveContradicted,  ///< off_s, from_s, to_s: the drive channel is off there; its subject
  kDriveDelayed,       ///< delay_s, uncertainty_s: of the vibration after the drive channel
  kBumpsExcluded,      ///< count, excluded_s, from_s
  kOtherDrive,         ///< frequency_hz, expected_hz: the header's drive frequency
  kWindowOutside,      ///< from_s, to_s, record_from_s, record_to_s
  kWindowNotSettled,   ///< from_s, to_s, settled_s
  kWindowShortened,    ///< excluded_s, from_s, to_s
  kWindowClipped,      ///< share
  kCornerLoss,         ///< frequency_hz, gain, rms_m: as it would be without the filter
  // hum of the mains
  kHumSubtracted,   ///< frequency_hz, amplitude_m, lines
  kHumAtDrive,      ///< frequency_hz, mains_hz, amplitude_m: a multiple too near to the drive
  kMainsFrequency,  ///< frequency_hz, amplitude_m: of a tone that never pauses
  // noise floor; its file is the subject
  kNoFloor,           ///< noise_m: that the RMS holds at most, where that is less than all
  kQuietHasDrive,     ///< amplitude_m, frequency_hz: what the tone leaves where it is off
  kFloorOfOtherRate,  ///< floor_per_s, readings_per_s
  kFloorHasTone,      ///< amplitude_m, frequency_hz
  kFloorHasTheTone,   ///< the same: the trial's own
  kFloorAboveSignal,  ///< floor_m, measured_m
  kBelowFloor,        ///< floor_m, at_most_m
  // the numbers
  kRmsTooLarge,           ///< rms_m
  kRmsTooSmall,           ///< rms_m
  kWideInterval,          ///< share: half of the 95 % interval, of the RMS; noise_share or another:
                          ///< of the largest cause (RmsCause) in the variance, to a hundredth
  kQuantised,             ///< share, step_m: of the RMS that steps without noise may hide
  kGainInBand,            ///< least, greatest
  kGainTooLow,            ///< gain, frequency_hz, least_gain, averages: that leave it
  kGainCorrected,         ///< gain
  kCalibrationIncluded,   ///< share: relative standard uncertainty of the sensor's gain
  kCalibrationReplaced,   ///< share: of the record's calibration, which another one replaces
  kElectricalUnmeasured,  ///< readings
  kElectricalNoTone,      ///< frequency_hz
  // sweeps
  kSweepUneven,
  kSweepPolled,
  kSweepRateLimit,    ///< upper_hz, new_readings_per_s, needed_per_s
  kSweepSensorLimit,  ///< upper_hz
  kDriveConstant,     ///< channel
  kDriveGaps,         ///< channel
  kNoDriveChannel,
  kConstantDriveAssumed,
  kSweepTooShort,  ///< length_s, resolution_hz: that it holds
  kNoResponse,
  kNoSweep,              ///< lower_hz, upper_hz, resolution_hz, block_s
  kFrequenciesExcluded,  ///< excluded, frequencies
  kResonanceAbove,       ///< from_hz, to_hz, highest_hz: of the largest amplitude
  kResonanceBelow,       ///< the same
  kPeakTooNarrow,        ///< the same, resolution_hz
  kNoResonance,          ///< the same
  kSweepTooFast,         ///< rate_hz_per_s, most_hz_per_s, frequency_hz: of the apparent resonance
  kSeveralResonances,    ///< left: share of the response
};

using Finding = FindingOf<FindingKind>;
using Findings = haptometer::Findings<FindingKind>;

}  // namespace haptometer::dsp
