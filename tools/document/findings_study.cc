#include <algorithm>
#include <array>

#include "base/error.h"
#include "tools/study/study_findings.h"

namespace haptometer::tools {
namespace {

// a kind and its sentence; [optional part] is omitted where its numbers are absent
struct Row {
  StudyFinding kind;
  document::Sentence sentence;
};

constexpr std::array kTable{
    // one trial or condition
    Row{StudyFinding::kNoValue, {"no-value", "{reason}"}},
    Row{StudyFinding::kBelowNoise,
        {"below-noise",
         "the vibration does not exceed the noise, {noise_m} RMS: it is at most {at_most_m}"}},
    Row{StudyFinding::kOrderLowered,
        {"order-lowered",
         "filter of order {order}, as the record is too short for the order asked[, {trials} of "
         "{of_trials} trials]"}},
    Row{StudyFinding::kFrequencyMoves,
        {"frequency-moves",
         "the drive's frequency moves, so the RMS is that of a sweep[, {trials} of {of_trials} "
         "trials]"}},
    Row{StudyFinding::kOtherFrequency,
        {"other-frequency",
         "the tone is at {frequency_hz}, and that of the other trials of the condition at "
         "{median_hz}: check the generator"}},
    Row{StudyFinding::kDoubtful,
        {"doubtful",
         "the analysis states a doubt ({doubt})[, {trials} of {of_trials} trials]; haptometer "
         "analyze prints it in full"}},
    Row{StudyFinding::kNoNoiseCorrection,
        {"no-noise-correction",
         "not corrected for noise: no quiet part, and no drive-off trial (--floor)[, {trials} of "
         "{of_trials} trials]"}},
    Row{StudyFinding::kFloorDoubtful,
        {"floor-doubtful", "{doubt}[, {trials} of {of_trials} trials]"}},
    Row{StudyFinding::kAveragingUnknown,
        {"averaging-unknown",
         "amplitude not verified, as the sensor's averaging is unknown; state it in the header of "
         "a "
         "CSV, as '# averages = 16' and '# sampling_s = 0.00033' (haptometer trial export FILE -o "
         "OUT.csv makes one of any trial)[, {trials} of {of_trials} trials]"}},
    Row{StudyFinding::kDataMissing, {"data-missing", "{what}[, {trials} of {of_trials} trials]"}},
    Row{StudyFinding::kWithoutDrive,
        {"without-drive",
         "no drive found in {trials} of {of_trials} trials, none of which counts as a "
         "measurement"}},
    Row{StudyFinding::kTableIgnored, {"table-ignored", "a table of results, no trial: ignored"}},
    // completeness and outliers, which are reported and retained
    Row{StudyFinding::kTrialsMissing,
        {"trials-missing", "{answered} of {expected} trial{expected s} with a value"}},
    Row{StudyFinding::kOutlyingTrial,
        {"outlying-trial",
         "possible outlier: {times} times the median of its cell, robust z = {robust_z}; "
         "retained"}},
    Row{StudyFinding::kOutlyingCell,
        {"outlying-cell",
         "possible outlier: {times} times the additive prediction of subject and condition, robust "
         "z = {robust_z}; retained"}},
    // tests that are not possible
    Row{StudyFinding::kContrastsNotPlanned,
        {"contrasts-not-planned",
         "no contrast is planned, so every condition is compared with the first, {control} "
         "(--contrast TREATMENT:CONTROL selects others)"}},
    Row{StudyFinding::kTooFewSubjects,
        {"too-few-subjects", "not tested: {subjects} subject{subjects s}, 2 are needed"}},
    Row{StudyFinding::kNoSpread,
        {"no-spread", "not tested: the values of all {subjects} subjects are equal"}},
    Row{StudyFinding::kAnovaNotDetermined,
        {"anova-not-determined",
         "analysis of variance not determined: it needs 2 conditions, and 2 subjects that have all "
         "of them and differ ({subjects} have)"}},
    Row{StudyFinding::kCalibrationExcluded,
        {"calibration-excluded", "uncertainties exclude sensor calibration and linearity"}},
    // matching of settings, power and the line over drive
    Row{StudyFinding::kNoSetting, {"no-setting", "no setting"}},
    Row{StudyFinding::kOneStart,
        {"one-start", "no setting started {missing}; those of the other start are used"}},
    Row{StudyFinding::kPowerByVoltage,
        {"power-by-voltage", "power savings assume power proportional to the voltage squared"}},
    Row{StudyFinding::kNoFloor,
        {"no-floor",
         "not corrected for noise: neither a reading at 0 V nor a noise floor (--floor)"}},
    Row{StudyFinding::kReadingsBelowFloor,
        {"readings-below-floor", "{readings} reading{readings s} below the noise floor: excluded"}},
    Row{StudyFinding::kTooFewReadings,
        {"too-few-readings",
         "no line: {readings} reading{readings s} above the noise, 3 of different drive are "
         "needed"}},
    Row{StudyFinding::kCurvatureNotDetermined,
        {"curvature-not-determined",
         "curvature not determined: 4 readings at 3 levels are needed"}}};

}  // namespace

// a kind without a row is an error of the program
document::Sentence SentenceOf(StudyFinding kind) {
  const auto* row = std::ranges::find(kTable, kind, &Row::kind);
  HAPTOMETER_CHECK(row != kTable.end(), "a kind without words: {}", static_cast<int>(kind));
  return row->sentence;
}

}  // namespace haptometer::tools
