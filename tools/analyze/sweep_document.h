#pragma once

#include <string>

#include "dsp/analysis/sweep_analysis.h"
#include "tools/document/document.h"

namespace haptometer::tools {

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
