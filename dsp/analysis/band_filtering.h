#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/readings/segments.h"
#include "dsp/spectrum/sine_fit.h"
#include "trial/row_source.h"

/// The filtering step of AnalyzeBand.
namespace haptometer::dsp {

/// A record's displacement, and how many threads may filter it.
struct Displacement {
  const trial::RowSource& source;
  std::size_t channel = 0;
  int threads = 1;
};

/// Filters every segment that is fast enough and holds a shortest window, with the asked order, or
/// with the highest lower one that leaves enough settled; motion below the band is modelled where
/// that helps.
///
/// Says in `analysis` (band, remarks, reasons) which order, or why none does; then nothing is
/// returned. The signals refer to `segments`. Errors: as RowSource::Read.
[[nodiscard]] Result<std::vector<BandSignal>> FilterSettledEnough(const Displacement& displacement,
                                                                  const Segments& segments,
                                                                  const BandQuestion& question,
                                                                  BandAnalysis* analysis);

/// The signal with most seconds settled; `all` is not empty.
[[nodiscard]] const BandSignal& LongestSettled(const std::vector<BandSignal>& all);

/// Seconds that have settled.
[[nodiscard]] double SettledSeconds(const BandSignal& signal);

/// The strongest tone below the band, of at most 2^21 samples in the middle, and what two passes
/// leave of it. Nothing where it lies within half a bin (1 / duration) of the lower corner: it is
/// in the band as well.
[[nodiscard]] Result<std::optional<BelowBand>> FindBelowBand(const BandSignal& signal,
                                                             double lower_hz);

/// The strongest tone from the band to `most_hz`, of at most 2^21 samples in the middle, as it was
/// before the filter.
[[nodiscard]] Result<std::optional<SineFit>> FindAboveBand(const BandSignal& signal,
                                                           double upper_hz, double most_hz);

}  // namespace haptometer::dsp
