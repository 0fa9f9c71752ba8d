#pragma once

#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/plot/gnuplot.h"
#include "trial/row_source.h"

namespace haptometer::tools {

/// Distance over time, the filtered signal, and ten periods of it; grey is what no number is of.
/// `analysis` was made of `rows` with keep_filtered. Memory: about 40 B a row.
/// Errors: as RowSource::Read.
[[nodiscard]] Result<std::vector<plot::Panel>> AnalysisPanels(const trial::RowSource& rows,
                                                              const dsp::BandAnalysis& analysis);

}  // namespace haptometer::tools
