#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "tools/study/study_findings.h"

namespace haptometer::tools {
namespace {

struct Case {
  StudyFinding kind;
  std::vector<FindingNumber> numbers;
  std::string name;
  std::string text;
};

// one of each kind, with the numbers that study gives it
std::vector<Case> Cases() {
  using enum StudyFinding;
  return {
      {kNoValue, {{"reason", std::string("too short")}}, "no-value", "too short"},
      {kBelowNoise,
       {{"noise_m", 0.5e-6}, {"at_most_m", 0.3e-6}},
       "below-noise",
       "the vibration does not exceed the noise, 0.5 um RMS: it is at most 0.3 um"},
      {kOrderLowered,
       {{"order", 4}, {"trials", 2}, {"of_trials", 9}},
       "order-lowered",
       "filter of order 4, as the record is too short for the order asked, 2 of 9 trials"},
      {kFrequencyMoves,
       {},
       "frequency-moves",
       "the drive's frequency moves, so the RMS is that of a sweep"},
      {kOtherFrequency,
       {{"frequency_hz", 230.0}, {"median_hz", 225.0}},
       "other-frequency",
       "the tone is at 230 Hz, and the median of the condition's trials is 225 Hz: check the "
       "generator"},
      {kDoubtful,
       {{"doubt", std::string("drive-unsteady")}, {"trials", 2}, {"of_trials", 9}},
       "doubtful",
       "the analysis states a doubt (drive-unsteady), 2 of 9 trials; haptometer analyze prints it "
       "in full"},
      {kNoNoiseCorrection,
       {},
       "no-noise-correction",
       "not corrected for noise: no quiet part, and no drive-off trial (--floor)"},
      {kFloorDoubtful,
       {{"doubt", std::string("it holds a tone")}},
       "floor-doubtful",
       "it holds a tone"},
      {kAveragingUnknown,
       {{"trials", 3}, {"of_trials", 3}},
       "averaging-unknown",
       "amplitude not verified, as the sensor's averaging is unknown; state it by acquire "
       "--averaging, in the calibration file, or in the header of a CSV, as '# averages = 16' and "
       "'# sampling_s = 0.00033' (haptometer trial export FILE -o "
       "OUT.csv makes one of any trial), 3 of 3 trials"},
      {kDataMissing, {{"what", std::string("cut short")}}, "data-missing", "cut short"},
      {kExcluded,
       {{"reason", std::string("finger slipped")}},
       "excluded",
       "excluded and not analysed: finger slipped"},
      {kWithoutDrive,
       {{"trials", 2}, {"of_trials", 9}},
       "without-drive",
       "no drive found in 2 of 9 trials, none of which counts as a measurement"},
      {kTableIgnored, {}, "table-ignored", "a table of results, no trial: ignored"},
      {kTrialsMissing,
       {{"answered", 2}, {"expected", 3}},
       "trials-missing",
       "2 of 3 trials with a value"},
      {kEqualFiles,
       {{"files", 3}},
       "equal-files",
       "3 files of equal content, so that the same data count 3 times: take the copies out"},
      {kOutlyingTrial,
       {{"times", 1.1234}, {"studentized", 5.04}, {"p", 0.00123}},
       "outlying-trial",
       "possible outlier: 1.123 times the mean of the other repeats of its cell, studentized "
       "residual 5.04, p = 0.00123 over the study; retained"},
      {kOutlyingCell,
       {{"times", 5.0}, {"studentized", 12.0}, {"p", 0.001}},
       "outlying-cell",
       "possible outlier: 5 times the additive prediction of subject and condition, studentized "
       "residual 12, p = 0.001 over the study; retained"},
      {kLabelsAlike,
       {{"label", std::string("condition")},
        {"one", std::string("cone")},
        {"other", std::string("cones")},
        {"how", std::string("one letter")}},
       "labels-alike",
       "the conditions cone and cones differ by one letter: if they are one, correct a trial by "
       "haptometer trial label"},
      {kContrastsNotPlanned,
       {{"control", std::string("stock")}},
       "contrasts-not-planned",
       "no contrast is planned, so every condition is compared with the first, stock (--contrast "
       "TREATMENT:CONTROL selects others)"},
      {kContrastNotYet,
       {},
       "contrast-not-yet",
       "planned, and not possible yet: one of its conditions has no trial that is included"},
      {kConditionWithoutTrial,
       {},
       "condition-without-trial",
       "stands in the conditions of the manifest, and is the condition of no trial"},
      {kSessionLogDamaged,
       {{"what", std::string("2 lines of log.csv cannot be read")}},
       "session-log-damaged",
       "2 lines of log.csv cannot be read: a decision may be missing, as a rejection; restore "
       "log.csv from a copy"},
      {kSessionTrialMissing,
       {},
       "session-trial-missing",
       "its file is not there, and the session's log counts it: restore it from a copy, or record "
       "the cell again by session redo --file"},
      {kAllExcluded, {{"trials", 3}}, "all-excluded", "all 3 trials are excluded"},
      {kTooFewSubjects,
       {{"subjects", 1}},
       "too-few-subjects",
       "not tested: 1 subject, 2 are needed"},
      {kNoSpread, {{"subjects", 8}}, "no-spread", "not tested: no scatter over the 8 subjects"},
      {kAnovaNotDetermined,
       {{"subjects", 1}},
       "anova-not-determined",
       "analysis of variance not determined: it needs 2 conditions, and 2 subjects that have all "
       "of "
       "them and differ (1 have)"},
      {kRepeatsNotDetermined,
       {},
       "repeats-not-determined",
       "ICC and variation within cells not determined: they need 2 subjects or more, as many "
       "trials "
       "of each, and scatter of these"},
      {kCalibrationExcluded,
       {},
       "calibration-excluded",
       "uncertainties exclude sensor calibration and linearity"},
      {kCalibrationInTrials,
       {},
       "calibration-in-trials",
       "uncertainties of means, differences and ratios exclude sensor calibration and linearity; "
       "those of single trials include it where the trial states it"},
      {kNoSetting, {{"reference_v", 2.0}}, "no-setting", "no setting"},
      {kOneStart,
       {{"missing", std::string("low")}},
       "one-start",
       "no setting started low; those of the other start are used"},
      {kPowerByVoltage,
       {},
       "power-by-voltage",
       "power savings assume power proportional to the voltage squared"},
      {kNoFloor,
       {},
       "no-floor",
       "not corrected for noise: neither a reading at 0 V nor a noise floor (--floor)"},
      {kReadingsBelowFloor,
       {{"readings", 1}},
       "readings-below-floor",
       "1 reading below the noise floor: excluded"},
      {kTooFewReadings,
       {{"readings", 2}},
       "too-few-readings",
       "no line: 2 readings above the noise, and 3 at 2 levels are needed"},
      {kCurvatureNotDetermined,
       {{"readings", 3}},
       "curvature-not-determined",
       "curvature not determined: 4 readings at 3 levels are needed"},
  };
}

TEST(StudyFindings, EachKindIsASentence) {
  std::set<std::string> names;
  for (const Case& one : Cases()) {
    const document::Sentence sentence = SentenceOf(one.kind);
    EXPECT_EQ(sentence.kind, one.name);
    EXPECT_EQ(document::Fill(sentence.text, one.numbers), one.text);
    EXPECT_TRUE(names.insert(one.name).second) << one.name;
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(StudyFinding::kCurvatureNotDetermined) + 1)
      << "the last kind";
}

}  // namespace
}  // namespace haptometer::tools
