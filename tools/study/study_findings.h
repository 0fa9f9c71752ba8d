#pragma once

#include <cstdint>

#include "base/finding.h"
#include "tools/document/document.h"

namespace haptometer::tools {

/// What `study`, `study matching` and `study linearity` find; the words stand in
/// tools/document/findings_study.cc.
enum class StudyFinding : std::uint8_t {
  // of a trial: why it has no value, or how its analysis differs from what was asked
  kNoValue,            ///< reason
  kBelowNoise,         ///< noise_m, at_most_m
  kOrderLowered,       ///< order
  kFrequencyMoves,     ///< its RMS is that of a sweep
  kOtherFrequency,     ///< frequency_hz, median_hz: of the trials of its condition
  kDoubtful,           ///< doubt: name of a doubt of its analysis
  kNoNoiseCorrection,  ///< neither a floor nor a quiet part
  kFloorDoubtful,      ///< doubt
  kAveragingUnknown,   ///< so the sensor's gain is
  kDataMissing,        ///< what
  kExcluded,           ///< reason: by `trial exclude`; it was not analysed
  // of a study; those of a trial may have trials and of_trials too
  kWithoutDrive,           ///< trials, of_trials
  kTableIgnored,           ///< a table of results among the trials
  kTrialsMissing,          ///< answered, expected
  kEqualFiles,             ///< files: of equal content, each of which counts
  kOutlyingTrial,          ///< times, studentized, p
  kOutlyingCell,           ///< times, studentized, p
  kLabelsAlike,            ///< label, one, other, how
  kContrastsNotPlanned,    ///< control
  kContrastNotYet,         ///< a condition of it has no trial yet
  kConditionWithoutTrial,  ///< the manifest orders a condition that no trial has
  kAllExcluded,            ///< trials
  kSessionLogDamaged,      ///< what: so the session may have forgotten attempts and decisions
  kSessionTrialMissing,    ///< a trial that counts by the session's log is not there
  kTooFewSubjects,         ///< subjects
  kNoSpread,               ///< subjects
  kAnovaNotDetermined,     ///< subjects
  kRepeatsNotDetermined,   ///< of a condition with repeats: ICC and variation within cells
  kCalibrationExcluded,    ///< of all uncertainties
  kCalibrationInTrials,    ///< of all uncertainties but those of trials that state it
  kNoSetting,              ///< of a subject at a level
  kOneStart,               ///< missing: "high" or "low"
  kPowerByVoltage,         ///< what power savings rest on
  kNoFloor,                ///< of drive readings
  kReadingsBelowFloor,     ///< readings
  kTooFewReadings,         ///< readings
  kCurvatureNotDetermined  ///< readings
};

using StudyFindings = Findings<StudyFinding>;

/// The words of a kind.
[[nodiscard]] document::Sentence SentenceOf(StudyFinding kind);

}  // namespace haptometer::tools
