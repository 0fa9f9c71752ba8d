#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/band.h"
#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "dsp/spectrum/welch.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/document/present.h"
#include "tools/results/trial_results.h"

namespace haptometer::tools {

/// The words of `analyze` that are about spectra.
struct SpectrumWords {
  std::string spectrum;
  std::string spectrogram;
  std::optional<double> resolution_hz;
  std::string window = "hann";
  std::optional<double> overlap;
  std::string scaling = "density";
  bool overwrite = false;  ///< also of the tables of trials and of a sweep's points
};

/// What is asked of a spectrum.
struct SpectrumQuestion {
  std::string spectrum;     ///< path; empty: none
  std::string spectrogram;  ///< path; empty: none
  std::optional<double> resolution_hz;
  dsp::WindowShape window = dsp::WindowShape::kHann;
  double overlap = 0.5;
  bool amplitude = false;  ///< amplitudes in m instead of a density in m^2/Hz
  bool overwrite = false;  ///< older tables are replaced
};

void DeclareSpectrum(cli::Options* options, SpectrumWords* words);

/// Errors (Cause::kUsage): a resolution or overlap that is none, a place that cannot be written.
[[nodiscard]] Result<SpectrumQuestion> SpectrumQuestionOf(const SpectrumWords& words);

/// "hann", as on the command line.
[[nodiscard]] std::string_view NameOf(dsp::WindowShape window);

/// The command line of `analyze`, as it was typed.
struct AnalyzeWords {
  std::vector<std::string> files;
  cli::BandWords band{.band = std::string(kDefaultBand), .order = {}, .corner = "whole"};
  std::string window = "auto";
  std::string floor;
  std::string hum = "subtract";
  std::string calibration_uncertainty;  ///< empty: what the file's calibration states
  std::string expect;
  std::string table;  ///< of all trials; empty: none
  std::optional<double> drive_frequency_hz;
  bool sweep = false;
  std::string response;
  document::Outputs outputs;
  std::optional<std::int64_t> threads;
  SpectrumWords spectrum;
  cli::ImportWords import;
  ResultsWords results{};
};

void DeclareAnalyze(cli::Options* options, AnalyzeWords* words);

inline constexpr std::int64_t kMostThreads = 64;

/// What is asked of each record; its floor is not read yet. Errors (Cause::kUsage): a band or
/// window that is none, a picture that cannot be drawn at its place.
[[nodiscard]] Result<dsp::BandQuestion> QuestionOf(const AnalyzeWords& words);

}  // namespace haptometer::tools
