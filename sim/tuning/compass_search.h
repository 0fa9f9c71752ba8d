#pragma once

#include <functional>
#include <vector>

namespace haptometer::sim {

/// A point of the unit cube and the function's value there.
struct CubePoint {
  std::vector<double> place;  ///< each from 0 to 1
  double value = 0;
};

/// Climbs from `start` to a local maximum of `function` within the unit cube of as many dimensions.
///
/// Compass search (Kolda, Lewis, Torczon, SIAM Review 45 (2003) 385, section 3) with all 3^n - 1
/// neighbours: steps to the best of them while it is better by 16 roundings of the value, at most
/// 1000 times, then halves the step, from 2^-4 down to 2^-40: on a flat ridge the last bits of the
/// value would be climbed for minutes. Without derivatives and deterministic; bounds are met
/// exactly. A smooth maximum is found to about the root of the function's rounding. Cost: 3^n - 1
/// evaluations a step, some hundred steps; n is 5 at most here.
[[nodiscard]] CubePoint ClimbWithinCube(
    const std::function<double(const std::vector<double>&)>& function, std::vector<double> start);

}  // namespace haptometer::sim
