#include "tools/study/study_findings.h"

namespace haptometer::tools {

document::Sentence SentenceOf(StudyFinding kind) {
  using enum StudyFinding;
  static constexpr document::KindSentence<StudyFinding> kSentences[] = {
      // one trial or condition
      {kNoValue, "no-value", "{reason}"},
      {kBelowNoise, "below-noise",
       "the vibration does not exceed the noise, {noise_m} RMS: it is at most {at_most_m}"},
      {kOrderLowered, "order-lowered",
       "filter of order {order}, as the record is too short for the order asked[, {trials} of "
       "{of_trials} trials]"},
      {kFrequencyMoves, "frequency-moves",
       "the drive's frequency moves, so the RMS is that of a sweep[, {trials} of {of_trials} "
       "trials]"},
      {kOtherFrequency, "other-frequency",
       "the tone is at {frequency_hz}, and the median of the condition's trials is {median_hz}: "
       "check the generator"},
      {kDoubtful, "doubtful",
       "the analysis states a doubt ({doubt})[, {trials} of {of_trials} trials]; haptometer "
       "analyze prints it in full"},
      {kNoNoiseCorrection, "no-noise-correction",
       "not corrected for noise: no quiet part, and no drive-off trial (--floor)[, {trials} of "
       "{of_trials} trials]"},
      {kFloorDoubtful, "floor-doubtful", "{doubt}[, {trials} of {of_trials} trials]"},
      {kAveragingUnknown, "averaging-unknown",
       "amplitude not verified, as the sensor's averaging is unknown; state it by acquire "
       "--averaging, in the calibration file, or in the header of "
       "a CSV, as '# averages = 16' and '# sampling_s = 0.00033' (haptometer trial export FILE "
       "-o OUT.csv makes one of any trial)[, {trials} of {of_trials} trials]"},
      {kDataMissing, "data-missing", "{what}[, {trials} of {of_trials} trials]"},
      {kExcluded, "excluded", "excluded and not analysed: {reason}"},
      {kWithoutDrive, "without-drive",
       "no drive found in {trials} of {of_trials} trials, none of which counts as a measurement"},
      {kTableIgnored, "table-ignored", "a table of results, no trial: ignored"},
      // completeness and outliers, which are reported and retained
      {kTrialsMissing, "trials-missing", "{answered} of {expected} trial{expected s} with a value"},
      {kEqualFiles, "equal-files",
       "{files} files of equal content, so that the same data count {files} times: take the copies "
       "out"},
      {kOutlyingTrial, "outlying-trial",
       "possible outlier: {times} times the mean of the other repeats of its cell, studentized "
       "residual {studentized}, p = {p} over the study; retained"},
      {kOutlyingCell, "outlying-cell",
       "possible outlier: {times} times the additive prediction of subject and condition, "
       "studentized residual {studentized}, p = {p} over the study; retained"},
      {kLabelsAlike, "labels-alike",
       "the {label}s {one} and {other} differ by {how}: if they are one, correct a trial by "
       "haptometer trial label"},
      // tests that are not possible
      {kContrastsNotPlanned, "contrasts-not-planned",
       "no contrast is planned, so every condition is compared with the first, {control} "
       "(--contrast TREATMENT:CONTROL selects others)"},
      {kContrastNotYet, "contrast-not-yet",
       "planned, and not possible yet: one of its conditions has no trial that is included"},
      {kConditionWithoutTrial, "condition-without-trial",
       "stands in the conditions of the manifest, and is the condition of no trial"},
      {kSessionLogDamaged, "session-log-damaged",
       "{what}: a decision may be missing, as a rejection; restore log.csv from a copy"},
      {kSessionTrialMissing, "session-trial-missing",
       "its file is not there, and the session's log counts it: restore it from a copy, or record "
       "the cell again by session redo --file"},
      {kAllExcluded, "all-excluded", "all {trials} trial{trials s} are excluded"},
      {kTooFewSubjects, "too-few-subjects",
       "not tested: {subjects} subject{subjects s}, 2 are needed"},
      {kNoSpread, "no-spread", "not tested: no scatter over the {subjects} subjects"},
      {kAnovaNotDetermined, "anova-not-determined",
       "analysis of variance not determined: it needs 2 conditions, and 2 subjects that have "
       "all of them and differ ({subjects} have)"},
      {kRepeatsNotDetermined, "repeats-not-determined",
       "ICC and variation within cells not determined: they need 2 subjects or more, as many "
       "trials "
       "of each, and scatter of these"},
      {kCalibrationExcluded, "calibration-excluded",
       "uncertainties exclude sensor calibration and linearity"},
      {kCalibrationInTrials, "calibration-in-trials",
       "uncertainties of means, differences and ratios exclude sensor calibration and linearity; "
       "those of single trials include it where the trial states it"},
      // matching of settings, power and the line over drive
      {kNoSetting, "no-setting", "no setting"},
      {kOneStart, "one-start", "no setting started {missing}; those of the other start are used"},
      {kPowerByVoltage, "power-by-voltage",
       "power savings assume power proportional to the voltage squared"},
      {kNoFloor, "no-floor",
       "not corrected for noise: neither a reading at 0 V nor a noise floor (--floor)"},
      {kReadingsBelowFloor, "readings-below-floor",
       "{readings} reading{readings s} below the noise floor: excluded"},
      {kTooFewReadings, "too-few-readings",
       "no line: {readings} reading{readings s} above the noise, and 3 at 2 levels are needed"},
      {kCurvatureNotDetermined, "curvature-not-determined",
       "curvature not determined: 4 readings at 3 levels are needed"},
  };
  return document::SentenceIn(kSentences, kind);
}

}  // namespace haptometer::tools
