#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "dsp/statistics/moments.h"
#include "dsp/statistics/paired_tests.h"
#include "dsp/statistics/repeated_measures.h"
#include "tools/compare/measured.h"
#include "tools/document/provenance.h"
#include "tools/results/trial_results.h"
#include "tools/study/manifest.h"
#include "tools/study/study_findings.h"
#include "trial/import/import_options.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {

/// What names are sorted by, s2 before s10: a name without the digits at its end, their number (-1
/// without any), and the name.
[[nodiscard]] std::tuple<std::string_view, double, std::string_view> NaturalKey(
    const std::string& name);

/// One trial of a study: whose it is, and the one number that is compared.
struct StudyTrial {
  std::string file;
  std::string subject;
  std::string condition;
  std::string repeat;             ///< numbered by file name where nothing says it
  std::string utc_start;          ///< empty where unknown
  std::string sensor;             ///< with its head; empty where unknown
  std::optional<double> drive_v;  ///< amplitude of the drive, where the file says it
  std::vector<document::DataSource> sources;
  std::shared_ptr<const dsp::NoiseFloor> floor;  ///< of the session, that was subtracted
  std::optional<std::string> excluded;  ///< why it is in no number; it is not analysed then
  std::optional<Error> error;           ///< it cannot be read, or has no place in the study
  bool answered = false;                ///< rms_m is there
  std::vector<std::string> reasons;     ///< why the analysis does not answer
  StudyFindings
      findings;  ///< why there is no value, or how its analysis differs from what was asked
  std::optional<double> rms_m;             ///< within the band
  std::optional<double> rms_with_floor_m;  ///< the same without the correction for noise
  std::optional<double> rms_uncertainty_m;
  std::optional<double> gain_uncertainty;  ///< relative, of the calibration: in rms_uncertainty_m
  std::optional<double> tone_hz;
  OfCompared<dsp::Estimate> numbers{};  ///< what a scene is compared with
  bool is_of_drive = false;             ///< its window lies in a state in which the drive is on
  bool has_no_drive = false;            ///< no drive found: never a measurement
  bool is_doubtful = false;             ///< its analysis or its file gives rise to a doubt
  bool below_band_removed = false;      ///< motion below the band was modelled and subtracted
  bool gain_corrected = false;          ///< the sensor's gain at the tone was divided out
  std::optional<dsp::NoiseSource> noise_from;  ///< of the noise that was subtracted
};

/// Reads and analyses one file, as the verb analyze does. Nothing else of the study depends on what
/// an analysis holds.
[[nodiscard]] StudyTrial AnalyzeTrial(const TrialFile& file, const dsp::BandQuestion& question,
                                      const trial::ImportOptions& import);

/// The same, as it was kept in an earlier run, or analysed and kept now. Errors: as
/// TrialResults::Answer.
[[nodiscard]] Result<StudyTrial> AnalyzeTrial(const TrialFile& file,
                                              const dsp::BandQuestion& question,
                                              const trial::ImportOptions& import,
                                              TrialResults& results);

/// The same of many files, on `threads` threads; the order is that of `files`, whichever is ready
/// first. Of a shard its own trials alone. Memory: one record a thread. Errors: as
/// TrialResults::Answer; the first in the order of the files.
[[nodiscard]] Result<std::vector<StudyTrial>> AnalyzeTrials(const std::vector<TrialFile>& files,
                                                            const dsp::BandQuestion& question,
                                                            const trial::ImportOptions& import,
                                                            TrialResults& results, int threads);
/// On all processors, without results of earlier runs.
[[nodiscard]] std::vector<StudyTrial> AnalyzeTrials(const std::vector<TrialFile>& files,
                                                    const dsp::BandQuestion& question,
                                                    const trial::ImportOptions& import);

inline constexpr std::int64_t kMostStudyThreads = 64;

/// The repeats of one subject in one condition.
struct Cell {
  std::vector<std::size_t> trials;  ///< rows of StudyTable::trials that are answered
  std::vector<double> rms_m;        ///< theirs
  std::size_t not_answered = 0;     ///< trials of this cell without a number

  /// Arithmetic mean and mean of ln(RMS); nothing where no trial is answered.
  [[nodiscard]] std::optional<double> mean_m() const;
  [[nodiscard]] std::optional<double> mean_log() const;
};

/// Trials x subjects x conditions. The unit of analysis is the subject: a cell counts as one value.
struct StudyTable {
  std::vector<StudyTrial> trials;
  std::vector<std::string> subjects;     ///< 2 before 10
  std::vector<std::string> conditions;   ///< as asked, then the others, 2 before 10
  std::vector<std::vector<Cell>> cells;  ///< [subject][condition]
  std::size_t repeats = 0;               ///< most answered trials of any cell

  /// Place of a condition; nothing where no trial has it.
  [[nodiscard]] std::optional<std::size_t> Condition(const std::string& name) const;
  /// The logarithms of all answered trials of a cell.
  [[nodiscard]] std::vector<double> Logs(std::size_t subject, std::size_t condition) const;
  /// Cell means, `mean` of each, of the subjects that have all conditions; `whole` tells which
  /// they are.
  [[nodiscard]] dsp::CompleteTable Complete(std::optional<double> (Cell::*mean)() const,
                                            std::vector<std::size_t>* whole) const;
};

/// Sorts trials into cells. Trials without subject or condition get an error, those with a repeat
/// that their cell already has as well; both stay in `trials`, as do excluded ones, which make no
/// subject, condition or repeat. `first` are the conditions in the order in which they are to be
/// shown.
[[nodiscard]] StudyTable MakeStudyTable(std::vector<StudyTrial> trials,
                                        const std::vector<std::string>& first);

/// A cell with fewer answered trials than the fullest one.
struct MissingTrials {
  std::string subject;
  std::string condition;
  std::size_t answered = 0;
  std::size_t expected = 0;  ///< answered trials of the fullest cell
};

/// A trial, or a whole cell, that stands apart. It is named and counts all the same.
struct Outlying {
  std::string subject;
  std::string condition;
  std::string file;  ///< empty: the whole cell
  double times = 0;  ///< RMS over what the others let expect of its place
  double t = 0;      ///< externally studentized residual of ln(RMS)
  double p = 0;      ///< after Bonferroni's correction over the study
};

/// The chance that a study without outliers has any named, at most: of its trials, and of its
/// cells' means. Of a study without repeats, whose cells are its trials, the sum of both.
inline constexpr double kFalseAlarmsOfTrials = 0.04;
inline constexpr double kFalseAlarmsOfCells = 0.01;
/// The least standard deviation of ln(RMS) that a trial or cell is judged by: where repeats agree
/// to less, a difference of a few percent is no news to anybody.
inline constexpr double kLeastScatter = 0.01;

/// What several answered trials have in common: how their analysis differs from what was asked.
struct Deviation {
  FindingOf<StudyFinding> finding;
  std::vector<std::string> files;  ///< in the table's order
};

/// Each deviation of answered trials once, in the order of its first trial.
[[nodiscard]] std::vector<Deviation> FindDeviations(const std::vector<StudyTrial>& trials);

[[nodiscard]] std::vector<MissingTrials> FindMissing(const StudyTable& table);

/// Outlying trials and cells, by logarithms of the RMS (dsp/statistics/outliers.h):
/// - a trial against the other repeats of its cell, in cells of 2 trials or more; of two it is not
///   known which one it is, and both are named;
/// - a cell's mean, without trials that are named, against the effects of subject and condition, of
///   3 subjects or more that have all conditions.
/// No standard deviation counts below kLeastScatter, nor below the relative standard uncertainty
/// that the trial states (a cell: the median of its trials').
[[nodiscard]] std::vector<Outlying> FindOutlying(const StudyTable& table);

/// Trials whose tone is farther from the median of their condition than kOtherFrequencyShare, in
/// conditions of three trials or more most of which agree.
inline constexpr double kOtherFrequencyShare = 0.01;
[[nodiscard]] StudyFindings FindOtherFrequencies(const std::vector<StudyTrial>& trials);

/// One condition against another, subject by subject.
struct Contrast {
  PlannedContrast planned;
  std::vector<std::string> left_out;  ///< subjects that lack one of the two
  dsp::OneSample difference;          ///< of the subjects' means, in m; n = 0: nobody has both
  std::optional<double> p_holm;       ///< of difference.test->p, over all contrasts
  std::optional<dsp::GeometricRatio> ratio;  ///< of the subjects' geometric means
  std::optional<dsp::EffectSize> effect;
  std::optional<double> sign_flip_p;
  std::optional<dsp::RatioOfMeans> ratio_of_means;
};

/// The contrasts, in their order, with Holm's correction over those that can be tested.
/// Errors: as CheckContrasts.
[[nodiscard]] Result<std::vector<Contrast>> CompareConditions(
    const StudyTable& table, const std::vector<PlannedContrast>& planned);

/// One condition by itself.
struct ConditionSummary {
  std::string name;
  std::size_t trials = 0;                   ///< answered
  dsp::OneSample subjects;                  ///< of the subjects' means, in m; n = 0: none
  std::optional<double> geometric_m;        ///< exp of the mean over subjects of their mean log
  std::optional<double> morey_m;            ///< half the within-subject error bar
  std::optional<dsp::Reliability> repeats;  ///< of ln(RMS)
};

/// How the RMS changes from a subject's first trial to its last.
struct OrderTrend {
  bool by_start = false;     ///< by the recordings' UTC start; else by the number of the repeat
  dsp::OneSample per_trial;  ///< over subjects: slope of ln(RMS) about its cell's mean, per trial
};

/// What --all adds.
struct FurtherStatistics {
  std::vector<ConditionSummary> conditions;
  std::size_t whole_subjects = 0;  ///< that have all conditions: what anova and Morey bars use
  std::optional<dsp::RepeatedMeasuresAnova> anova;      ///< of the subjects' means
  std::optional<dsp::RepeatedMeasuresAnova> log_anova;  ///< of the subjects' mean logarithms
  std::optional<OrderTrend> trend;
};

[[nodiscard]] FurtherStatistics DescribeFurther(const StudyTable& table);

/// Everything that a study answers.
struct StudyResult {
  std::string source;  ///< folder or manifest
  dsp::BandQuestion question;
  StudyTable table;
  std::vector<Error> changed{};                ///< TrialResults::ChangeErrors()
  std::vector<std::string> ignored;            ///< tables of results that lie among the trials
  StudyFindings equal_files{};                 ///< of trials with a value
  std::vector<std::string> without_trial{};    ///< conditions of the manifest that no trial has
  std::string session_damage{};                ///< what of a session's log is damaged, in words
  std::vector<std::string> session_missing{};  ///< trials that its log counts, and are not there
  std::string scene{};                         ///< that the session's source plays; empty: none
  bool planned = false;                        ///< the contrasts were asked for
  std::vector<PlannedContrast> not_yet;        ///< of a condition of the plan that has no trial yet
  std::vector<Contrast> contrasts;
  std::vector<MissingTrials> missing;
  std::vector<Outlying> outlying;
  FurtherStatistics further;

  /// Works out all that follows from the table; without a planned contrast every condition is
  /// compared with the first. Of a session `expected` are the conditions of its plan: a contrast of
  /// one that has no trial yet is in not_yet. Errors: as CompareConditions.
  [[nodiscard]] Result<void> Compare(std::vector<PlannedContrast> wanted,
                                     const std::vector<std::string>& expected = {});

  /// Of trials that cannot be read, have no place, or changed while size, time and inode stayed.
  [[nodiscard]] std::vector<Error> Errors() const;

  /// How many answered trials `is_so` holds of.
  template <typename Predicate>
  [[nodiscard]] std::size_t CountAnswered(const Predicate& is_so) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        table.trials,
        [&](const StudyTrial& trial) { return trial.answered && std::invoke(is_so, trial); }));
  }
};

}  // namespace haptometer::tools
