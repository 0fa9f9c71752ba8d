#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_question.h"
#include "tools/document/document.h"
#include "trial/import/import_options.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {

/// The noise floor that a drive-off trial gives in the band of `question`: all that has settled of
/// it, filtered as the trials are. `threads` changes no number.
/// Errors: as trial::OpenRows and dsp::AnalyzeBand; Cause::kCannotAnswer where it tells no floor,
/// being too slow or too short for the band.
[[nodiscard]] Result<dsp::NoiseFloor> ReadFloor(const std::string& path,
                                                const dsp::BandQuestion& question,
                                                const trial::ImportOptions& import, int threads);

/// One file's answer, or the error that stands in its place.
struct AnalyzedFile {
  std::string path;
  std::optional<dsp::BandAnalysis> analysis;
  std::optional<Error> error;              ///< with an analysis: of a table or a drawing of it
  std::string source;                      ///< metadata.source; empty: the file does not say
  std::vector<trial::DataSource> sources;  ///< of its data
  double step_m = 0;                       ///< of the displacement's source; 0: not known
  trial::Findings findings;                ///< what is lost of it and what was assumed in reading it
  std::vector<document::Figure> figures;
};

}  // namespace haptometer::tools
