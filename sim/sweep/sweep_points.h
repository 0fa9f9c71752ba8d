#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/sweep/latin_hypercube.h"
#include "sim/sweep/sweep_axis.h"

namespace haptometer::sim {

/// The points of a sweep: every combination of the axes' values (the last axis runs fastest), or a
/// Latin hypercube over them.
///
/// Each point is computed from its number alone, so shards and threads need no common state.
class SweepPoints {
 public:
  /// Without `sampling` every range has a count; with it none has, and a list is dealt out evenly.
  /// At least one axis.
  explicit SweepPoints(std::vector<SweepAxis> axes,
                       const std::optional<LatinHypercube>& sampling = std::nullopt);

  /// How many; the largest 64-bit number where there are more than it tells.
  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// The values of point `point` (from 0), one an axis. Cost: 0.1 us an axis, sampled 0.5 us.
  [[nodiscard]] std::vector<SweepValue> At(std::uint64_t point) const;

  [[nodiscard]] const std::vector<SweepAxis>& axes() const { return axes_; }
  [[nodiscard]] const std::optional<LatinHypercube>& sampling() const { return sampling_; }

 private:
  [[nodiscard]] SweepValue SampledValue(std::size_t axis, std::uint64_t point) const;

  std::vector<SweepAxis> axes_;
  std::optional<LatinHypercube> sampling_;
  std::uint64_t size_ = 1;
};

}  // namespace haptometer::sim
