#pragma once

#include <optional>
#include <span>
#include <vector>

#include "trial/record.h"

namespace haptometer::trial {

/// The clocked stretches behind printed times, or nothing where the times' resolution does not
/// explain how they differ from grids.
///
/// A new stretch begins where an interval is more than half a period longer than the median one.
/// Within a stretch of n rows the period is (last - first) / (n - 1); short stretches take the
/// longest one's period where it fits them. A time may differ from its grid by its own
/// resolution and the end points', plus a millionth of a period for clocks that were summed up.
///
/// Times that repeat, because their digits are coarser than the period, are one stretch on the
/// least-squares line, each time weighted by its resolution, if that gives every time back within
/// twice that; rows that are missing cannot be seen there.
///
/// `times_s`: at least two, not falling; `resolutions_s`: how far each may lie from what was
/// meant (PrintedTimes). Cost: O(rows).
[[nodiscard]] std::optional<std::vector<Stretch>> PrintedGrid(
    std::span<const double> times_s, std::span<const double> resolutions_s);

}  // namespace haptometer::trial
