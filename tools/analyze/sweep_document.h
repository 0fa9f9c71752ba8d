#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/sweep_analysis.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {

/// Prints what people write down on stdout: f0, Q, the largest amplitude, what is not determined.
void PrintSweep(const std::string& path, const dsp::SweepAnswer& answer);

/// The object of `analyze --sweep --json` (docs/reference/analyze.md): one trial. Unknown values
/// are null.
[[nodiscard]] nlohmann::ordered_json SweepJson(const std::string& path,
                                               const dsp::SweepAnswer& answer);

/// `frequency_hz,amplitude_m_per_v,phase_rad,coherence` (or `_m_per_a`, `_m`) below `# key = value`
/// lines; what is not determined is empty.
[[nodiscard]] std::string SweepCsv(const dsp::SweepAnswer& answer);

/// Amplitude over frequency with the fitted curve, and with a drive channel phase and coherence;
/// none where there are no points.
[[nodiscard]] std::vector<plot::Panel> SweepPanels(const dsp::SweepAnswer& answer);

}  // namespace haptometer::tools
