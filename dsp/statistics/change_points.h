#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace haptometer::dsp {

/// What values [first, end) cost as one segment: for normal values twice the negative logarithm of
/// their likelihood, whatever is the same in all partitions left out.
using SegmentCost = std::function<double(std::size_t first, std::size_t end)>;

/// Borders of the partition of `count` values into segments whose costs, with `penalty` for each
/// border, are least together: 0, the first value of each further segment, `count`.
///
/// Optimal partitioning (Jackson et al., IEEE Signal Processing Letters 12(2), 2005, p. 105) with
/// the pruning of Killick et al. (JASA 107, 2012, p. 1590). More than 2048 values are split in
/// pieces, whose borders stay only where they lower the cost: a deviation from the optimum. Cost:
/// linear in the values for segments of bounded length, 2048 count / 2 costs at most.
[[nodiscard]] std::vector<std::size_t> CheapestPartition(std::size_t count, double penalty,
                                                         const SegmentCost& cost_of);

}  // namespace haptometer::dsp
