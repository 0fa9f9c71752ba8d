#pragma once

#include <cstddef>
#include <vector>

namespace haptometer::fit {

/// Makes samples that stand at a rail of the converter NaN, and returns how many there were.
///
/// A rail is the largest or the smallest value of the record when it occurs more often than a whole
/// peak can explain. The top of a swing of amplitude A, rounded to the converter's step s, is flat
/// for 2 acos(1 - s/A) of a radian: more samples than that and 2 within half a period are a rail.
/// Values that are not rounded do not repeat at all: 3 equal extremes are a rail there. What lies
/// at a rail says no more than "at least this".
///
/// @param values_v NaN where there is no measurement
/// @param period_samples of the oscillation
[[nodiscard]] std::size_t MaskRails(std::vector<double>& values_v, double period_samples);

/// The converter's step: the smallest distance between values that occur, when all are whole steps
/// apart and there are at most 4096 of them; 0 for a record that shows none.
[[nodiscard]] double ConverterStep(const std::vector<double>& values_v);

}  // namespace haptometer::fit
