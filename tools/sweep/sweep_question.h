#pragma once

#include <cstdint>
#include <string>

#include "sim/sweep/sweep_points.h"
#include "sim/sweep/varied_scene.h"

namespace haptometer::tools {

/// One of several parts of a sweep: points number - 1, number - 1 + count, ... from 0.
struct Shard {
  std::uint64_t number = 1;  ///< 1 to count
  std::uint64_t count = 1;

  /// How many of `points` points are its own.
  [[nodiscard]] std::uint64_t RowsOf(std::uint64_t points) const {
    return points < number ? 0 : (points - number) / count + 1;
  }
  /// The point in its row `row`, both from 0.
  [[nodiscard]] std::uint64_t PointOf(std::uint64_t row) const { return number - 1 + row * count; }
};

/// What a sweep asks.
struct SweepQuestion {
  sim::VariedScene scene;
  sim::SweepPoints points;
  Shard shard;
};

}  // namespace haptometer::tools
