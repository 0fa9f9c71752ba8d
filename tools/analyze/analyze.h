#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_question.h"
#include "dsp/analysis/sweep_analysis.h"
#include "tools/analyze/analyze_question.h"
#include "tools/analyze/expectation.h"
#include "tools/document/document.h"
#include "tools/plot/gnuplot.h"
#include "trial/import/import_options.h"
#include "trial/row_source.h"
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
  trial::Metadata metadata;                ///< of the file
  std::vector<trial::DataSource> sources;  ///< of its data
  double step_m = 0;                       ///< of the displacement's source; 0: not known
  trial::Findings findings;        ///< what is lost of it and what was assumed in reading it
  ExpectationFindings deviations;  ///< from what is expected
  std::vector<document::Figure> figures;
};

/// The file as `analyze` answers it without options. Errors: those of its options, of which none
/// is given; what is wrong with the file is in the answer.
[[nodiscard]] Result<AnalyzedFile> AnalyzeByDefault(const std::string& path);

/// The document of `count` trials before any is analysed; the first of them is `first`.
[[nodiscard]] document::Document AnalysisDocument(const std::string& first, std::size_t count);

/// What is known of one trial (docs/reference/analyze.md). Where the question is not answered, RMS
/// and amplitude are not known, and what was worked out all the same stands under
/// `band_rms_estimate_m` and `tone_amplitude_estimate_m`. `is_alone`: the document has no other.
[[nodiscard]] document::Section TrialSection(const AnalyzedFile& file, bool is_alone);

/// A row of --table: the answer, the window, the tone, and the kinds of all findings.
[[nodiscard]] document::Section TableRow(const AnalyzedFile& file);

/// What is shown of one trial.
struct ShownTrial {
  document::Section section;   ///< TrialSection
  document::Section row;       ///< TableRow
  std::optional<Error> error;  ///< of the file
  bool deviates = false;       ///< from what is expected
  bool has_numbers = false;
  bool excludes_calibration = false;  ///< its numbers have no uncertainty of the calibration
};

/// What is in no uncertainty, where that holds of a trial; it is shown where one of them has
/// numbers
/// (`is_shown`).
[[nodiscard]] document::Section ClosingSection(bool excludes_calibration, bool is_shown);

/// Distance over time with its artifacts, the states of the drive, the filtered signal, and ten
/// periods of it; window, noise, filter transients and bumps are shaded. `analysis` was made of
/// `source` with keep_filtered.
/// Memory: about 40 B a row. Errors: as RowSource::Read.
[[nodiscard]] Result<std::vector<plot::Panel>> AnalysisPanels(const trial::RowSource& source,
                                                              const dsp::BandAnalysis& analysis);

/// Samples of a window at most that go into a spectrum: 2^24.
inline constexpr std::size_t kMostInSpectrum = std::size_t{1} << 24U;

/// Writes what `question` asks for. A CSV begins with `comment`, lines that begin with "# ", and
/// with `# key = value` lines that state window, noise bandwidth, overlap, segments and degrees of
/// freedom.
/// Errors: a window shorter than a segment (Cause::kCannotAnswer), a place that cannot be written.
[[nodiscard]] Result<void> WriteSpectra(const dsp::WindowSamples& window,
                                        const SpectrumQuestion& question,
                                        const std::string& comment);

/// The density of the window as a drawing, both axes logarithmic, with the corners of the band, the
/// tones of the drive and of hum, and the noise of `analysis`. Errors: as WriteSpectra.
[[nodiscard]] Result<plot::Panel> SpectrumPanel(const dsp::WindowSamples& window,
                                                const SpectrumQuestion& question,
                                                const dsp::BandAnalysis& analysis);

/// What is known of one trial of `analyze --sweep` (docs/reference/analyze.md). Its figure is
/// amplitude over frequency with the fitted curve, and with a drive channel phase and coherence;
/// none where there are no points. `is_alone`: the document has no other trial.
[[nodiscard]] document::Section SweepSection(const std::string& path,
                                             const dsp::SweepAnswer& answer, bool is_alone);

/// The points as a table of frequency_hz, amplitude_m_per_v (or _m_per_a, _m), phase_rad and
/// coherence, below the provenance and `# key = value` lines.
[[nodiscard]] std::string SweepCsv(const dsp::SweepAnswer& answer,
                                   const document::Provenance& provenance);

}  // namespace haptometer::tools
