#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tools/study/trial_files.h"
#include "trial/import/import_options.h"

namespace haptometer::tools {

/// One trial of a study: whose it is, and the one number that is compared.
struct StudyTrial {
  std::string file;
  std::string subject;
  std::string condition;
  std::string repeat;                      ///< numbered by file name where nothing says it
  std::string utc_start;                   ///< empty where unknown
  std::optional<double> drive_v;           ///< amplitude of the drive, where the file says it
  std::optional<Error> error;              ///< it cannot be read, or has no place in the study
  bool answered = false;                   ///< rms_m is there
  std::vector<std::string> reasons;        ///< why not
  std::vector<std::string> deviations;     ///< how its analysis differs from what was asked
  std::optional<double> rms_m;             ///< within the band
  std::optional<double> rms_with_floor_m;  ///< the same before its noise floor is taken off
  std::optional<double> rms_uncertainty_m;
};

/// Reads and analyses one file, as the verb analyze does. Nothing else of the study depends on what
/// an analysis holds.
[[nodiscard]] StudyTrial AnalyzeTrial(const TrialFile& file, const dsp::BandQuestion& question,
                                      const trial::ImportOptions& import);

/// The same of many files, on all processors; the order is that of `files`, whichever is ready
/// first. Memory: one record a processor.
[[nodiscard]] std::vector<StudyTrial> AnalyzeTrials(const std::vector<TrialFile>& files,
                                                    const dsp::BandQuestion& question,
                                                    const trial::ImportOptions& import);

}  // namespace haptometer::tools
