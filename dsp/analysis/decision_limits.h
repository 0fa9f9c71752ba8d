#pragma once

#include <cstddef>

/// Every number of dsp/analysis that decides something: whether a record is answered, which part of
/// it is the drive, what is noise, and what is said. Numbers of mathematics, and sizes of memory or
/// of an estimate whose uncertainty is stated, stand where they are used;
/// tests/architecture/decision_limits_test.py lists them and counts these.
///
/// When a filter's transients have settled stands in dsp/filter/transient.h.
///
/// Each states what it decides, what a wrong decision costs as measured, and the test that measures
/// it. Classes are those of tests/long/drive_classes.py (docs/developer/hard_case_tests.md has the
/// rates of all).
namespace haptometer::dsp {

// ---- One rate of false alarms

/// The normal deviate of false alarms in one of 1000, two-sided: a drift, a change, a bump and a
/// window of hum are no noise beyond so many of their standard uncertainties. A step of 5 % that is
/// neither split nor in the drift: below 1 %. Test:
/// DriveStates.AStepOfFivePercentIsFoundOrADrift
inline constexpr double kFalseAlarmDeviations = 3.29;
/// A line whose frequency was not chosen for it (hum, what a drive leaves in an interval without
/// it, a tone in a block) is there beyond so many uncertainties: exp(-12.5) of white noise.
/// Measured: no hum in 200 records of noise. Test: FindHum.NoiseAloneHasNone
inline constexpr double kClearUncertainties = 5;
/// False alarms of the search in a whole record for a tone below the noise of its blocks, lower
/// because averaged noise is no white one: 1e-3 answers averaged noise. Test:
/// NoPartIsDriven.AndNoneIsSeen
inline constexpr double kFaintFalseAlarm = 1e-6;

// ---- What is the same, noticeable, steady, most

/// Two frequencies, rates or mean values within this part are the same; beyond, a loss at a corner,
/// leakage, another drive or rate, and a drifting frequency are said. Hum that a pause shows alone
/// is known to this part of its power. Test:
/// BandAnalysis.AToneAtACornerHasItsAmplitudeRestored
inline constexpr double kSameWithin = 0.01;
/// A change of an amplitude beyond this part splits a state, or is a doubt with a wider interval;
/// so are steps of a converter that may hide as much. A sensor's gain below it is not divided out,
/// and a rate this far from a whole multiple is none. Test:
/// DriveStates.NeighboursOfOneLevelAreOne
inline constexpr double kNoticeable = 0.02;
/// Half of a 95 % interval beyond which an RMS is a doubt, as a part of it: an error above 5 %
/// without one then takes four standard uncertainties; silently wrong in the classes: none.
/// Test: WideInterval.IsADoubtBeyondTwoAndAHalfPercent
inline constexpr double kWideShare = 0.025;
/// A level that changes by less than this part of itself over a state, scatters by less about its
/// line, and differs by less between halves, is one amplitude. Of the classes ramp-whole (0 to 70 %
/// of the other end) and modulated (5 to 60 %) the steeper ones are refused. Test:
/// NoPartIsDriven.AndNoneIsSeen
inline constexpr double kSteadyWithin = 0.5;
/// More than this part is most of it: phases that continue, a channel that is on, a segment free of
/// transients, a residual that another frequency halves, a level beside its top, a drive beside the
/// strongest one (ToneOfAPause.IsNoDriveWhereItIsWeak), bumps of a window. Test:
/// DriveStates.ASteadyLevelOfLoosePhaseIsNoSteadyState
inline constexpr double kMajority = 0.5;
/// A model that explains this part of a power explains all but noise: the tone of the drive, the
/// phases of a clear one, a resonance. Test: AnalyzeSweep.SaysWhatIsNotDetermined
inline constexpr double kExplained = 0.9;
/// Fewer blocks, bins or points than these have no median, no trend and no resonance. Test:
/// NoiseBeside.WhiteNoiseLiesWithinItsVariances
inline constexpr std::size_t kFewest = 8;

// ---- Band, filter and window

/// The shortest window, noise interval and block of a sweep, in periods of the lower frequency: of
/// drives of 0.17 s and less none is answered, of 0.3 s all. Test:
/// ShortDriveByItsChannel.IsAnsweredWhereAWindowFits
inline constexpr double kLeastWindowPeriods = 2;
/// Noise is measured so many periods of the lower corner away from a drive, whose edges ring in the
/// filter. Class gated holds in 39 of 40. Test:
/// TrueVibrationOfAPause.ADriveOnForTwoOfThreeSecondsKeepsItsRms
inline constexpr double kQuietPeriods = 2.5;
/// The lowest order that is tried where the asked one leaves no window. Test:
/// BandAnalysis.StrongTremorOnAFifthOfASecondIsNotAnswered
inline constexpr int kLowestFallbackOrder = 2;
/// Motion below the band keeps its pace, and can be modelled, for so long; a line of hum too.
/// Test: TremorBelowTheBand.StrongTremorOnOneSecondIsModelledAndTheOrderKept
inline constexpr double kLongestModelledS = 20;
/// A line is sought in a record of this length or more. Test:
/// FindHum.NothingIsSoughtBelowOneSecond
inline constexpr double kLeastLineS = 1;

// ---- Blocks and states of the drive

/// Periods of the tone that a block holds at least: two parameters of amplitude and two of change.
/// Test: DriveBlocks.OfAToneAreItsAmplitudeFrequencyAndPhase
inline constexpr double kBlockPeriods = 4;
/// The shortest block; a segment has three times kFewest before they last a period of the lower
/// corner. Test: UnsettledDrive.IsAnsweredWithItsOwnNumbersOrNotAtAll
inline constexpr double kShortestBlockS = 0.015;
/// So many times longer blocks are tried twice where no drive is seen: they answer 2 of 12 gated
/// beats and tones below the noise of a block. Test: IntervalCoverage.OfAToneInNoise
inline constexpr double kLongerBlocks = 4;
/// Cost to the ridge of a move by a bin, as a part of the largest magnitude, which a jump costs. A
/// tone that drifts by 8 Hz/s stays one. Test: DriveBlocks.AChirpAndARampLeaveNoResidual
inline constexpr double kRidgeBinCost = 0.02;
/// Penalty c of a change of state, 5 c ln n: a constant drive is split in none of 4000 courses, a
/// step of 20 % is found in all but 0.5 %. Test:
/// DriveStates.AConstantDriveInWhiteNoiseIsSplitLessThanOnceInAThousand
inline constexpr double kChangePenalty = 1.5;
/// A state of m blocks is on where its level exceeds the largest bin of white noise by the factor
/// kOnLevel + kOnScatter / sqrt(m). The margin is for noise that is denser at the foot than on
/// average: the bound of white noise alone, at 1e-3, calls 2 and 14 of 60 records of AR(1) 0.67 and
/// 0.9 on. Measured: none of 180 records of noise. Test: DriveStates.NoiseAloneIsOff
inline constexpr double kOnLevel = 1.25;
inline constexpr double kOnScatter = 2;
/// A level is known no better than to this part of the largest ones, whatever the noise. Test:
/// DriveStates.OfAGatedDriveLieWithinABlockOfTheTruth
inline constexpr double kLevelFloor = 2e-3;
/// The band's foot, up to this multiple of the lower corner: tremor and red noise have narrow lines
/// there. Answered without a drive: none of 80 of off-tremor and off-red. Test:
/// DriveAtARate.IsNotSeenWhereThereIsNone
inline constexpr double kFootReach = 2;
/// A drive in the foot scatters by less than this part of its level. Test:
/// DriveStates.NoiseAloneIsOff
inline constexpr double kScatterAtFoot = 0.15;
/// A drive in the foot of fewer than kFewest blocks has this many at least, changes and scatters by
/// less than kNoticeable and explains its blocks: 0.3 to 1 s of 20 to 40 Hz. Test:
/// BurstsAtTheFoot.AreNotAveragedWithTheirPauses
inline constexpr std::size_t kFewestAtFoot = 3;
/// The residual of a bump is above its median by this, in logarithms, at least. Class bumps-gated.
/// Test: QuietInterval.IsCutWhereABumpIs
inline constexpr double kBumpLeast = 0.35;
/// A drive's sidebands lie within so many hertz, or bins, of it and of its harmonics. Test:
/// NoiseBeside.ExcludedTonesChangeNothing
inline constexpr double kDriveReachHz = 8;
inline constexpr double kReachBins = 5;

// ---- Hum of the mains

/// The mains' frequency may be off by this part: hum within it is subtracted, and a tone that no
/// short block shows is not told from hum within it and its own uncertainty. Costs 3 % of the
/// frequencies of such tones. Test: FaintTone.AtAMultipleOfTheMainsIsRefused
inline constexpr double kMainsPart = 1.2e-3;
/// A drive that is stated this near to a multiple of the mains is not told from hum. Test:
/// FindHum.MainsOfWhichTheStatedDriveIsAMultipleAreNotSought
inline constexpr double kMainsWithinHz = 1;
/// Length of the windows, each of which hum must be in, at least this and at least that part of the
/// record: a shorter pause of a drive is not seen; in windows of 0.25 s alone the noise of each
/// hides hum, and 4 of 80 records without a drive are answered. Test:
/// FindHum.BurstsAtTheMainsFrequencyAreNoHum
inline constexpr double kHumWindowS = 0.25;
inline constexpr double kHumWindows = 16;

// ---- Readings, sensor, drive channel, sweep

/// A reading's time is known to this part of a period. Test:
/// SlowRecord.TimesOfATenthOfAPeriodAreRefused
inline constexpr double kTimeUncertaintyPeriods = 0.1;
/// Uncertainty of a tone's amplitude, as a multiple of that of one seen at all phases, beyond which
/// it is not told from the offset. Test: SlowRecord.ATonePerSampleIsNotToldFromTheOffset
inline constexpr double kWorstUncertainty = 100;
/// Share of a window that is clipped above which its RMS is a lower limit only. Classes clipped and
/// clipped-few-a-period: none silently wrong. Test: WindowClipped.IsALowerLimit
inline constexpr double kMostClipped = 1e-3;
/// Below this gain the sensor has taken most of a tone away, and it is not answered. Test:
/// TrueVibration.LiesInTheStatedIntervalAndWithinTwoPercent
inline constexpr double kLeastSensorGain = 0.5;
/// A drive channel's edges belong to those of the displacement within this time, and the onset to
/// as much of either side. Test: FollowChannel.ADelayLiesWithinItsUncertainty
inline constexpr double kLongestDelayS = 1;
/// A drive begins where its channel exceeds so many times its largest value at rest. Test:
/// DriveOnset.ANoisyVoltageTellsNoLatency
inline constexpr double kRestsBelowDrive = 2;
/// A frequency that changes by more than this part is a sweep. Test:
/// AnalyzeSweep.SaysWhatIsNotDetermined
inline constexpr double kSweep = 0.1;

}  // namespace haptometer::dsp
