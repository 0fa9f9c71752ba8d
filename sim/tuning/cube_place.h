#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/tuning/adapter_bounds.h"

namespace haptometer::sim {

/// Ma1, Ka, Ba, the area by AreaAt() and Ma2, each as its part of the way between its bounds; Ka
/// and Ba by their logarithms where their bounds are wide.
inline constexpr int kCubeAxes = 5;
using CubePlace = Eigen::Matrix<double, kCubeAxes, 1>;

/// The part of the way from the range's lower end to its upper at which `value` lies; 0 where they
/// are equal.
[[nodiscard]] double PartOf(const Range& range, double value);

/// Whether a range is told by its logarithm: its lower end above 0 and its upper more than 20 times
/// that. What serves best is narrow in proportion to itself: of 100 N/m to 10 MN/m a lattice even
/// over the stiffness sees one decade of five, and a step of the range's millionth is 10 N/m.
[[nodiscard]] bool IsWide(const Range& range);

/// Ka or Ba at a part of its range, and back: by the logarithm where the range is wide.
[[nodiscard]] double ScaledAt(const Range& range, double part);
[[nodiscard]] double ScaledPartOf(const Range& range, double value);

/// The adapter at a place, and the place of an adapter.
[[nodiscard]] AdapterPoint PointOf(const AdapterBounds& bounds, const CubePlace& place);
[[nodiscard]] CubePlace PlaceOf(const AdapterBounds& bounds, const AdapterPoint& point);

/// The cube's upper end: 1, and 0 where the bounds hold an axis or the skin has no area.
[[nodiscard]] CubePlace UpperEndOf(const TuningProblem& problem);

/// Every combination of the parts that are given for Ma1, Ka, Ba and the area, as far as they lie
/// below `upper`; Ma2's is 0. The area changes first.
[[nodiscard]] std::vector<CubePlace> Lattice(const CubePlace& upper,
                                             const std::array<std::vector<double>, 4>& parts);

}  // namespace haptometer::sim
