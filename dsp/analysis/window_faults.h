#pragma once

#include <cstddef>

#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/faults.h"

/// What a record's faults do to a window.
namespace haptometer::dsp {

/// Rows of a window that are clipped. Those beyond the list's end (kMostListed) are not known by
/// place: they count as if all of them were in the window.
[[nodiscard]] std::size_t ClippedRows(const Faults& faults, std::size_t first_row,
                                      std::size_t rows);

/// Mean square within the band that listed faults of this kind (kSpike or kStep) in `part` make: a
/// spike's spectrum is flat over the band, a step's falls as 1 / (2 pi f).
[[nodiscard]] double FaultPower(const Faults& faults, FaultKind kind, const UsedPart& part,
                                const BandPass& band, double rate_hz);

}  // namespace haptometer::dsp
