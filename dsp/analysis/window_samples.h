#pragma once

#include <cstddef>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "trial/row_source.h"

namespace haptometer::dsp {

/// Unfiltered displacement over the window of an analysis, small holes bridged.
struct WindowSamples {
  double start_s = 0;
  double rate_hz = 0;
  std::vector<double> values_m;
};

/// The samples that `analysis` (which has numbers) was made of `source`, at most `most` from the
/// middle of its window. Errors: as RowSource::Read. Cost: one pass over the record for its holes.
[[nodiscard]] Result<WindowSamples> ReadWindow(const trial::RowSource& source,
                                               const BandAnalysis& analysis, std::size_t most);

}  // namespace haptometer::dsp
