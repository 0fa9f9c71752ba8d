#pragma once

#include <optional>
#include <string>

#include "base/error.h"
#include "base/quantity.h"
#include "dsp/spectrum/welch.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// The words of `analyze` that are about spectra.
struct SpectrumWords {
  std::string spectrum;
  std::string spectrogram;
  std::optional<Quantity> resolution_hz;
  std::string window = "hann";
  std::optional<Quantity> overlap;
  std::string scaling = "density";
  bool overwrite = false;  ///< also of the table of a sweep's points
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

}  // namespace haptometer::tools
