#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "dsp/statistics/moments.h"
#include "dsp/statistics/regression.h"
#include "tools/document/provenance.h"
#include "tools/study/study_findings.h"
#include "trial/import/import_options.h"

namespace haptometer::tools {

/// One reading of a drive sweep.
struct DriveReading {
  std::string subject;    ///< may be empty
  std::string condition;  ///< may be empty
  double drive_v = 0;     ///< 0: the drive was off, the reading is the floor
  double rms_m = 0;
};

/// The files of a drive sweep.
struct DriveFiles {
  std::vector<std::string> tables;   ///< with drive_v and without times
  std::vector<std::string> trials;   ///< all others
  std::vector<std::string> ignored;  ///< tables of results that lie in a folder of trials
};

/// The files that `words` name: a folder stands for the recordings in it, as of `study`. Errors: as
/// cli::RecordingsIn.
[[nodiscard]] Result<DriveFiles> FindDriveFiles(const std::vector<std::string>& words);

/// The readings of files, where their data come from, and the errors of the files that gave none.
struct DriveReadings {
  std::vector<DriveReading> readings;
  std::vector<document::DataSource> sources;
  StudyFindings findings;  ///< of files that gave readings, and of those ignored
  std::vector<Error> errors;
};

/// Reads tables with drive_v and rms_m (and subject, condition), and analyses trials that state
/// their drive_amplitude_v, without a correction for noise.
[[nodiscard]] DriveReadings ReadDriveReadings(const DriveFiles& files,
                                              const dsp::BandQuestion& question,
                                              const trial::ImportOptions& import);

/// The line of one subject in one condition.
struct DriveLine {
  std::string subject;
  std::string condition;
  std::vector<double> drive_v;    ///< of the readings above the floor
  std::vector<double> rms_m;      ///< theirs, the floor subtracted in power
  std::size_t below_floor = 0;    ///< readings whose power does not reach the floor's
  std::optional<double> floor_m;  ///< subtracted; nothing: none known
  std::optional<dsp::Line> line;  ///< in m and V; nothing: fewer than 3 readings or levels alike
  double full_scale_m = 0;        ///< the line's value at the highest level
  /// Of the same readings, in m and V; nothing: fewer than 4, or than 3 levels.
  std::optional<dsp::Curvature> curvature;
};

/// The slopes of a condition's subjects, and their curvatures: one value a subject.
struct SlopeOverSubjects {
  std::string condition;
  dsp::OneSample slope_m_per_v;
  std::optional<dsp::OneSample> curvature_m_per_v2;  ///< of those that have one: 2 or more
};

struct LinearityResult {
  std::vector<document::DataSource> sources;  ///< of the readings
  StudyFindings findings{};                   ///< of their files
  std::vector<DriveLine> lines;
  std::vector<SlopeOverSubjects> slopes;  ///< conditions with 2 subjects or more
};

/// Fits rms = intercept + slope drive for each subject and condition, after
///   rms^2 - floor^2
/// where the floor is `floor_m`, or else the RMS of that subject's and condition's readings with
/// the drive off. Whether the readings bend, and over subjects whether they do so alike, is tested
/// by the quadratic term of a parabola.
[[nodiscard]] LinearityResult AnalyzeLinearity(const std::vector<DriveReading>& readings,
                                               const std::optional<double>& floor_m);

}  // namespace haptometer::tools
