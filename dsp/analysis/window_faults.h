#pragma once

#include <cstddef>

#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/faults.h"
#include "dsp/analysis/used_part.h"

/// What a record's faults do to a window, and the steps that it may not hold.
namespace haptometer::dsp {

/// Cuts the steps out of a part as if they were edges: what is left is the longest side of them,
/// away from each by a period of the lower corner more than the filter rings (to 1e-4 of the step).
///
/// A remark says so. Where no side is as long as the shortest window, the part stays whole and the
/// steps' energy is a bound of the RMS. Only listed faults are seen (kMostListed of each kind).
void CutSteps(const FilterDesign& design, double lower_hz, ChosenPart* chosen,
              BandAnalysis* analysis);

/// Rows of a window that are clipped: of `faults.list`, or, where that was cut short, as many as
/// all rows not listed may be at most.
[[nodiscard]] std::size_t ClippedRows(const Faults& faults, std::size_t first_row,
                                      std::size_t rows);

/// Mean square within the band that faults of this kind (a spike or a step) inside a window make.
[[nodiscard]] double FaultPower(const Faults& faults, FaultKind kind, const UsedPart& part,
                                const BandPass& band, double rate_hz);

}  // namespace haptometer::dsp
