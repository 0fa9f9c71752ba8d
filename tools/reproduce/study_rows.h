#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "base/error.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/reproduce/thesis_numbers.h"
#include "tools/study/linearity.h"
#include "tools/study/matching.h"
#include "tools/study/study_table.h"
#include "tools/study/text_table.h"
#include "trial/byte_io.h"

namespace haptometer::tools {

/// The experiments of chapter 3, run by the study code on data that this program makes; the
/// thesis's own were never published.
struct GeneratedStudy {
  StudyResult trials;         ///< 8 subjects x 4 conditions x 3 trials, Figure 3.3
  MatchingResult matching;    ///< Figure 3.4
  LinearityResult linearity;  ///< Figure 3.5
};

/// Makes and analyses all three. Truths: the controls move as the model has them, the prototypes by
/// the thesis's factors more; matched voltages are equal at 1 V, and lower from 2 V on, so that
/// their mean over the levels is the thesis's. Trials go through files in a temporary folder.
/// Errors: no room there; as the study's parts.
[[nodiscard]] Result<GeneratedStudy> RunGeneratedStudy(const ThesisModel& model);

/// The rows that it answers.
[[nodiscard]] std::vector<ThesisRow> StudyRows(const GeneratedStudy& study);

/// A condition of a generated matching test: matched over reference voltage at each level, the
/// geometric mean over the subjects.
struct GeneratedMatch {
  std::string condition;
  std::map<double, double> ratio_at_v;
};

/// The settings of eight subjects, at each level one started high and one low, as the table that
/// `study matching` reads. The logarithm of a setting's ratio is the truth's plus the subject's own
/// at that level (standard deviation 0.10, centred), ln 1.05 more or less by its start, and the
/// setting's (0.03).
[[nodiscard]] TextTable GenerateSettings(const std::vector<GeneratedMatch>& matches,
                                         std::uint64_t seed);

/// Readings of a drive sweep from 0 V to 5 V in steps of half a volt, from 1 V on, on the prototype
/// IA#1 (Figure 3.5): each is a simulated second under a 10 kHz sensor, analysed in the band. Two
/// subjects, whose skins are a fifth softer and stiffer than the model's.
/// Errors: as dsp::AnalyzeBand; Cause::kCannotAnswer where it does not answer.
[[nodiscard]] Result<std::vector<DriveReading>> GenerateSweep(const ThesisModel& model);

/// A condition of a generated study, and the truth that its trials are made with.
struct GeneratedCondition {
  std::string name;
  double rms_m = 0;  ///< geometric mean over the subjects of the RMS in the band
};

/// Eight subjects, three trials a condition, as in the thesis (3.1.1, p. 24).
inline constexpr int kGeneratedSubjects = 8;
inline constexpr int kGeneratedRepeats = 3;

/// Normal deviates whose mean is exactly 0: the truth is then that of these very subjects.
[[nodiscard]] std::vector<double> CentredDeviates(std::mt19937_64& random, int count,
                                                  double standard_deviation);

/// Writes a trial.bin for each subject, condition and repeat into `folder`, labelled. A trial is
/// 1.2 s at 2 kHz of a tone at `frequency_hz` with tremor (8-11 Hz, 20-40 um), 1-3 mm of distance
/// with drift, and a sensor head's noise (0.5 um) and steps (0.1 um).
///
/// The logarithm of a trial's RMS is that of its condition plus a subject's share (standard
/// deviation 0.25), the subject's own in that condition (0.12), both centred, and the trial's
/// (0.05). Errors: as WriteSimulatedTrialIn.
[[nodiscard]] Result<void> GenerateTrials(const std::vector<GeneratedCondition>& conditions,
                                          double frequency_hz, std::uint64_t seed,
                                          const std::filesystem::path& folder);

/// A new file at `path` that is not worth waiting for the disk: Sync() hands the bytes to the
/// system only. For trials that go with the run that made them; a hundred syncs cost seconds.
[[nodiscard]] std::unique_ptr<trial::ByteSink> MakePassingFile(const std::string& path);

/// A folder of its own below the system's for temporary files, which goes with all it holds.
class TemporaryFolder {
 public:
  /// Errors (Cause::kFailed): it cannot be made.
  [[nodiscard]] static Result<TemporaryFolder> Make();

  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path);

  std::filesystem::path path_;  // empty: handed on
};

}  // namespace haptometer::tools
