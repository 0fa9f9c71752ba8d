#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/window_samples.h"
#include "tools/analyze/analyze_question.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {

/// Samples of a window at most that go into a spectrum: 2^24.
inline constexpr std::size_t kMostInSpectrum = std::size_t{1} << 24U;

/// Writes what `question` asks for. A CSV begins with `comment`, lines that begin with "# ", and
/// with `# key = value` lines that state window, noise bandwidth, overlap, segments and degrees of
/// freedom.
/// Errors: a window shorter than a segment (Cause::kCannotAnswer), a place that cannot be written.
[[nodiscard]] Result<void> WriteSpectra(const dsp::WindowSamples& window,
                                        const SpectrumQuestion& question,
                                        const std::string& comment);

/// The density of the window as a drawing, both axes logarithmic. Errors: as WriteSpectra.
[[nodiscard]] Result<plot::Panel> SpectrumPanel(const dsp::WindowSamples& window,
                                                const SpectrumQuestion& question);

}  // namespace haptometer::tools
