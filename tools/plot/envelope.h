#pragma once

#include <vector>

namespace haptometer::plot {

/// A curve of fewer points that covers the same ink: of each of `slices` equal runs of rows its
/// least and its greatest value, so that no peak is lost however long the curve is.
///
/// A NaN breaks the line, and still does so where it falls among measured values: the slice's two
/// points are followed by one NaN. `y` shorter than twice `slices` comes back as it is.
/// Appends to `out_x`, `out_y` at most three points a slice. Cost: one pass.
void AppendEnvelope(const std::vector<double>& x, const std::vector<double>& y, std::size_t slices,
                    std::vector<double>* out_x, std::vector<double>* out_y);

}  // namespace haptometer::plot
