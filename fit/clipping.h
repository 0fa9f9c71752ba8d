#pragma once

#include <cstddef>
#include <vector>

namespace haptometer::fit {

/// Makes samples that stand at a rail of the converter NaN, and returns how many there were.
///
/// A rail is an extreme value that several samples in a row share, in at least two half periods, or
/// in one for longer than a peak rounded to the record's own step s can last: the top of a swing of
/// amplitude A stays within half a step for 2 acos(1 - s/2A) of a radian. What lies at such a value
/// says no more than "at least this".
///
/// @param values_v NaN where there is no measurement; the record's median is its rest
/// @param period_samples of the oscillation
[[nodiscard]] std::size_t MaskRails(std::vector<double>& values_v, double period_samples);

/// The converter's step: the smallest distance between values that occur, when all are whole steps
/// apart and there are at most 4096 of them; 0 for a record that shows none.
[[nodiscard]] double ConverterStep(const std::vector<double>& values_v);

}  // namespace haptometer::fit
